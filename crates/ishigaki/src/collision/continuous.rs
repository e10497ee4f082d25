//! Sweeping fast bodies, so that they pass through nothing.
//!
//! A body marked `continuous` that moves more than a part of its own thickness in a step is cast along its
//! motion; the contact of the moment of impact becomes a row with the gap that is left until then. After the
//! solve its whole path is cast once more, and it is stopped where it would have passed through something:
//! time is lost then, never a wall. Option: `contact.sweep_threshold`; shown by `tests/tunnelling.rs`.

use crate::body::{BodyState, ShapeState};
use crate::collision::pair::Pair;
use crate::math::{Pose, Vec3};
use crate::options::WorldOptions;
use crate::shape::Geometry;
use crate::world::World;
use parry3d::query::{ShapeCastOptions, ShapeCastStatus};

/// Whether the pair is swept: one of the two asks for it and the relative motion is large for its size.
pub(crate) fn is_swept(
    a: &BodyState,
    b: &BodyState,
    shape_a: &ShapeState,
    shape_b: &ShapeState,
    motion: Vec3,
    options: &WorldOptions,
) -> bool {
    let fast = |body: &BodyState, shape: &ShapeState| {
        body.continuous && motion.length() > options.contact.sweep_threshold * shape.inner_radius
    };
    fast(a, shape_a) || fast(b, shape_b)
}

/// Inner radius of the thinner of two shapes, m; surfaces have none and do not count.
pub(crate) fn thinness(a: &ShapeState, b: &ShapeState) -> f32 {
    match (a.inner_radius, b.inner_radius) {
        (a, 0.0) => a,
        (0.0, b) => b,
        (a, b) => a.min(b),
    }
}

/// The part in [0, 1] of `motion` (of A relative to B, m) after which the two touch.
pub(crate) fn time_of_impact(a: &Geometry, pose_a: &Pose, b: &Geometry, pose_b: &Pose, motion: Vec3) -> Option<f32> {
    let (shape_a, shape_b) = (a.to_parry()?, b.to_parry()?);
    let options = ShapeCastOptions {
        max_time_of_impact: 1.0,
        target_distance: 0.0,
        stop_at_penetration: false,
        compute_impact_geometry_on_penetration: false,
    };
    let hit = parry3d::query::cast_shapes(pose_a, motion, &*shape_a, pose_b, Vec3::ZERO, &*shape_b, options).ok()??;
    (hit.status != ShapeCastStatus::PenetratingOrWithinTargetDist).then_some(hit.time_of_impact)
}

impl World {
    /// Stops continuous bodies where their path of this step would have led through something.
    pub(crate) fn stop_at_walls(&mut self) {
        if !self.scratch.roles.iter().any(|role| role.active && role.continuous) {
            return;
        }
        // All pairs, not only those with points: where a row stops a body, nothing is left to do here.
        for i in 0..self.pairs.all.len() {
            let pair @ Pair { shape_a, shape_b, .. } = self.pairs.all[i];
            if pair.is_gone() {
                continue;
            }
            let (shape_a, shape_b) = (self.shapes.at(shape_a), self.shapes.at(shape_b));
            if shape_a.shape.sensor || shape_b.shape.sensor {
                continue;
            }
            let (body_a, body_b) = (shape_a.body, shape_b.body);
            let (a, b) = (self.bodies.at(body_a), self.bodies.at(body_b));
            if !(a.continuous && a.is_active() || b.continuous && b.is_active()) {
                continue;
            }
            let (moved_a, moved_b) = (a.center - start_center(a), b.center - start_center(b));
            let motion = moved_a - moved_b;
            if !is_swept(a, b, shape_a, shape_b, motion, &self.options) {
                continue;
            }
            let start = |body: &BodyState, shape: &ShapeState, moved: Vec3| {
                let mut pose = shape.world_from_shape(body);
                pose.translation -= moved;
                pose
            };
            let (pose_a, pose_b) = (start(a, shape_a, moved_a), start(b, shape_b, moved_b));
            let (geometry_a, geometry_b) = (&shape_a.shape.geometry, &shape_b.shape.geometry);
            let Some(part) = time_of_impact(geometry_a, &pose_a, geometry_b, &pose_b, motion) else { continue };
            if part < 1.0 {
                self.back_up(body_a, moved_a, part);
                self.back_up(body_b, moved_b, part);
            }
        }
    }

    fn back_up(&mut self, index: u32, moved: Vec3, part: f32) {
        let body = self.bodies.at_mut(index);
        if body.continuous && body.is_active() {
            body.center -= moved * (1.0 - part);
        }
    }
}

/// Center at the start of the step; the rotation of the step does not matter for a path of the center.
pub(crate) fn start_center(body: &BodyState) -> Vec3 {
    body.previous_pose.translation + body.previous_pose.rotation * body.mass.center
}
