//! One judge for all engines: what their bodies' states say, in f64.
//!
//! The words are those of `ishigaki-scenes`: **penetration**, the deepest overlap of two shapes after the first half
//! second, m; **drift**, the greatest horizontal displacement of a center of mass from its start, m; **joint gap**, the
//! greatest distance between two anchors that should coincide, m; **stands**, no center was ever farther from its start
//! than ¼ of its body's smallest edge. Overlaps are computed here, by no engine's own account.

use crate::engine::State;
use crate::scene::Scene;
use crate::solid::{self, Solid};
use anyhow::{Context, Result};
use parry3d_f64::bounding_volume::{Aabb, BoundingVolume};
use parry3d_f64::mass_properties::MassProperties;
use parry3d_f64::math::{Pose, Vector};
use std::collections::HashSet;

/// A body stands while its center is within this part of its smallest edge from its start.
const STANDS_WITHIN: f64 = 0.25;
/// Overlaps before this time are not counted: a scene may start with gaps, s.
const SETTLING_TIME: f64 = 0.5;

/// What was seen so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// Deepest overlap, m; infinite once a state is not a number.
    pub penetration_max: f64,
    /// Greatest horizontal displacement, m.
    pub drift_max: f64,
    /// Greatest distance between anchors, m; 0 without joints.
    pub joint_gap_max: f64,
    /// No center ever moved more than ¼ of its body's smallest edge.
    pub stands: bool,
    /// Kinetic and potential energy of the last state over that of the first, less 1; 0 if the first is 0.
    pub energy_change: f64,
}

/// Watches the states of one engine in one scene.
pub struct Meter {
    solids: Vec<Solid>,
    /// Body of each solid.
    owner: Vec<usize>,
    masses: Vec<MassProperties>,
    edges: Vec<f64>,
    starts: Vec<Vector>,
    apart: HashSet<(usize, usize)>,
    first_energy: f64,
    quality: Quality,
    scene: Scene,
}

impl Meter {
    /// Remembers where everything is.
    pub fn new(scene: &Scene) -> Result<Self> {
        let (mut solids, mut owner) = (Vec::new(), Vec::new());
        for (i, body) in scene.bodies.iter().enumerate() {
            for shape in &body.shapes {
                solids.push(Solid::new(shape, &scene.hulls).with_context(|| format!("body {i}"))?);
                owner.push(i);
            }
        }
        let joined = scene.joints.iter().map(|j| j.bodies).chain(scene.excluded.iter().copied());
        let states: Vec<State> = scene.bodies.iter().map(State::from).collect();
        let mut meter = Self {
            solids,
            owner,
            masses: scene.bodies.iter().map(|b| solid::mass_properties(b, scene)).collect(),
            edges: scene.bodies.iter().map(|b| solid::smallest_edge(b, scene)).collect(),
            starts: Vec::new(),
            apart: joined.map(|[a, b]| (a.min(b), a.max(b))).collect(),
            first_energy: 0.0,
            quality: Quality {
                penetration_max: 0.0,
                drift_max: 0.0,
                joint_gap_max: 0.0,
                stands: true,
                energy_change: 0.0,
            },
            scene: scene.clone(),
        };
        meter.starts = meter.centers(&poses(&states));
        meter.first_energy = meter.energy(&states);
        Ok(meter)
    }

    /// Takes in the states after `time` seconds.
    pub fn observe(&mut self, states: &[State], time: f64) {
        let poses = poses(states);
        let centers = self.centers(&poses);
        for (i, center) in centers.iter().enumerate().filter(|(i, _)| self.scene.bodies[*i].dynamic) {
            let moved = *center - self.starts[i];
            self.quality.drift_max = worst(self.quality.drift_max, moved.x.hypot(moved.z));
            self.quality.stands &= moved.length() <= STANDS_WITHIN * self.edges[i];
        }
        for joint in &self.scene.joints {
            let [a, b] = [0, 1].map(|k| {
                let anchor: Vector = joint.anchors[k].map(f64::from).into();
                poses[joint.bodies[k]].transform_point(anchor)
            });
            self.quality.joint_gap_max = worst(self.quality.joint_gap_max, (a - b).length());
        }
        if time > SETTLING_TIME {
            self.quality.penetration_max = worst(self.quality.penetration_max, self.penetration(&poses));
        }
        if self.first_energy != 0.0 {
            self.quality.energy_change = self.energy(states) / self.first_energy - 1.0;
        }
    }

    /// What was seen so far.
    pub fn quality(&self) -> Quality {
        self.quality
    }

    fn centers(&self, poses: &[Pose]) -> Vec<Vector> {
        poses.iter().zip(&self.masses).map(|(pose, mass)| pose.transform_point(mass.local_com)).collect()
    }

    /// J: kinetic, and potential above y = 0.
    fn energy(&self, states: &[State]) -> f64 {
        let gravity: Vector = self.scene.gravity.map(f64::from).into();
        let dynamic = states.iter().zip(&self.masses).zip(&self.scene.bodies).filter(|(_, body)| body.dynamic);
        let parts = dynamic.map(|((state, properties), _)| {
            let pose = solid::pose(state.position, state.rotation);
            let (v, omega): (Vector, Vector) = (state.velocity.into(), state.angular_velocity.into());
            let principal = (pose.rotation * properties.principal_inertia_local_frame).inverse() * omega;
            let turning = (principal * principal).dot(properties.principal_inertia());
            let mass = properties.mass();
            0.5 * (mass * v.length_squared() + turning) - mass * gravity.dot(pose.transform_point(properties.local_com))
        });
        parts.sum()
    }

    /// The deepest overlap of any two shapes that may touch; infinite if a pose is not a number.
    fn penetration(&self, poses: &[Pose]) -> f64 {
        if poses.iter().any(|p| !p.translation.is_finite()) {
            return f64::INFINITY;
        }
        let mut bounded: Vec<(usize, Aabb)> = Vec::with_capacity(self.solids.len());
        let mut everywhere = Vec::new();
        for (i, solid) in self.solids.iter().enumerate() {
            match solid.bounds(&poses[self.owner[i]]) {
                Some(bounds) => bounded.push((i, bounds)),
                None => everywhere.push(i),
            }
        }
        let overlap = |i: usize, j: usize| {
            let (a, b) = (&poses[self.owner[i]], &poses[self.owner[j]]);
            if self.may_touch(i, j) { self.solids[i].overlap(a, &self.solids[j], b) } else { 0.0 }
        };
        let mut deepest = 0.0;
        for &ground in &everywhere {
            deepest = bounded.iter().fold(deepest, |d, &(i, _)| worst(d, overlap(i, ground)));
        }
        // Sweep along x: a shape meets those that begin before it ends.
        bounded.sort_by(|a, b| a.1.mins.x.total_cmp(&b.1.mins.x));
        for (k, (i, a)) in bounded.iter().enumerate() {
            let near = bounded[k + 1..].iter().take_while(|(_, b)| b.mins.x <= a.maxs.x);
            deepest = near.filter(|(_, b)| a.intersects(b)).fold(deepest, |d, &(j, _)| worst(d, overlap(*i, j)));
        }
        deepest
    }

    /// Different bodies, one of them moving, not joined, in groups that touch.
    fn may_touch(&self, i: usize, j: usize) -> bool {
        let (a, b) = (self.owner[i], self.owner[j]);
        let (one, two) = (&self.scene.bodies[a], &self.scene.bodies[b]);
        a != b
            && (one.dynamic || two.dynamic)
            && one.member_of & two.collides_with != 0
            && two.member_of & one.collides_with != 0
            && !self.apart.contains(&(a.min(b), a.max(b)))
    }
}

impl From<&crate::scene::Body> for State {
    fn from(body: &crate::scene::Body) -> Self {
        Self {
            position: body.position.map(f64::from),
            rotation: body.rotation.map(f64::from),
            velocity: body.velocity.map(f64::from),
            angular_velocity: body.angular_velocity.map(f64::from),
        }
    }
}

fn poses(states: &[State]) -> Vec<Pose> {
    states.iter().map(|s| solid::pose(s.position, s.rotation)).collect()
}

/// The greater; NaN counts as infinite.
fn worst(so_far: f64, value: f64) -> f64 {
    if value.is_nan() { f64::INFINITY } else { so_far.max(value) }
}

#[cfg(test)]
#[path = "meter/tests.rs"]
mod tests;
