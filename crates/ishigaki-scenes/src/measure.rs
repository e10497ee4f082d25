//! The words in which scenes are judged, the same in tests, experiments and the command line.
//!
//! - **stands**: no center of mass was ever farther from its start than ¼ of its body's smallest edge.
//! - **drift**: the greatest horizontal displacement of a center of mass from its start, m.
//! - **pen**: the deepest overlap at the end of any step after the first 0.5 s, m.
//! - **joint gap**: the greatest distance between two anchors that should coincide, m.
//! - **rest time**: from when on no body has been faster than 0.05 m/s.
//!
//! Horizontal is across gravity (across Y without gravity). The smallest edge of a body is that of its smallest
//! shape: a ball's diameter, the least side of a box, a capsule's thickness, the least side of a hull's bounds.

use ishigaki::{BodyHandle, BodyKind, Geometry, Shape, Vec3, World};
use serde::Serialize;

/// A body stands while its center is within this part of its smallest edge from its start.
pub const STANDS_WITHIN: f32 = 0.25;
/// Overlaps before this time are not counted: a scene may start with gaps, s.
pub const SETTLING_TIME: f64 = 0.5;
/// Slower than this is at rest, m/s.
pub const REST_SPEED: f32 = 0.05;

/// What a [`Meter`] has seen so far.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Measure {
    /// No center ever moved more than ¼ of its body's smallest edge.
    pub stands: bool,
    /// Greatest displacement of a center over its body's smallest edge: > 0.25 does not stand.
    pub greatest_move: f32,
    /// Greatest horizontal displacement, m.
    pub drift: f32,
    /// Deepest overlap at the end of a step after the first 0.5 s, m.
    pub pen: f32,
    /// Greatest distance between two anchors, m.
    pub joint_gap: f32,
    /// From when on no body has been faster than 0.05 m/s, s; `None` while one is.
    pub rest_time: Option<f64>,
    /// Greatest speed after the last step, m/s.
    pub speed: f32,
}

/// Watches a world step by step.
///
/// Make it before the first step, call [`Meter::observe`] after each.
#[derive(Clone, Debug)]
pub struct Meter {
    starts: Vec<Start>,
    up: Vec3,
    start_time: f64,
    measure: Measure,
}

#[derive(Clone, Copy, Debug)]
struct Start {
    body: BodyHandle,
    center: Vec3,
    edge: f32,
}

impl Meter {
    /// Remembers where all dynamic bodies are.
    pub fn new(world: &World) -> Self {
        let dynamic = world.bodies().filter(|(_, body)| body.kind() == BodyKind::Dynamic);
        let starts = dynamic.map(|(handle, body)| Start {
            body: handle,
            center: body.center(),
            edge: smallest_edge(world, handle).unwrap_or(world.options().length_scale),
        });
        let measure = Measure {
            stands: true,
            greatest_move: 0.0,
            drift: 0.0,
            pen: 0.0,
            joint_gap: 0.0,
            rest_time: None,
            speed: 0.0,
        };
        Self {
            starts: starts.collect(),
            up: -world.options().gravity.try_normalize().unwrap_or(Vec3::NEG_Y),
            start_time: world.time(),
            measure,
        }
    }

    /// Takes in the world after a step. Bodies that were removed no longer count.
    pub fn observe(&mut self, world: &World) {
        let m = &mut self.measure;
        m.speed = 0.0;
        for start in &self.starts {
            let Some(body) = world.body(start.body) else { continue };
            let moved = body.center() - start.center;
            let part = moved.length() / start.edge;
            // Not finite is the farthest away; `max` alone would drop NaN.
            m.greatest_move = if part.is_finite() { m.greatest_move.max(part) } else { f32::INFINITY };
            m.drift = worst(m.drift, (moved - self.up * moved.dot(self.up)).length());
            m.speed = worst(m.speed, body.velocity().length());
        }
        m.stands = m.greatest_move <= STANDS_WITHIN;
        let time = world.time() - self.start_time;
        if time > SETTLING_TIME {
            m.pen = worst(m.pen, world.report().max_penetration);
        }
        for (_, joint) in world.joints() {
            m.joint_gap = worst(m.joint_gap, joint.anchor_error());
        }
        if m.speed > REST_SPEED {
            m.rest_time = None;
        } else {
            m.rest_time.get_or_insert(time);
        }
    }

    /// What was seen so far.
    pub fn measure(&self) -> Measure {
        self.measure
    }
}

/// The greater; NaN counts as infinite.
fn worst(so_far: f32, value: f32) -> f32 {
    if value.is_nan() { f32::INFINITY } else { so_far.max(value) }
}

/// The smallest edge of a body's shapes, m; `None` without a bounded shape.
pub fn smallest_edge(world: &World, body: BodyHandle) -> Option<f32> {
    let edges = world.shapes_of(body).filter(|(_, shape, _)| !shape.sensor).filter_map(|(_, shape, _)| edge(shape));
    edges.reduce(f32::min)
}

fn edge(shape: &Shape) -> Option<f32> {
    match &shape.geometry {
        Geometry::Ball { radius } | Geometry::Capsule { radius, .. } => Some(2.0 * radius),
        Geometry::Cuboid { half_extents } => Some(2.0 * half_extents.min_element()),
        Geometry::Cylinder { half_height, radius } | Geometry::Cone { half_height, radius } => {
            Some(2.0 * half_height.min(*radius))
        }
        Geometry::ConvexHull(hull) => {
            let points = hull.points();
            let low = points.iter().copied().reduce(Vec3::min)?;
            let high = points.iter().copied().reduce(Vec3::max)?;
            Some((high - low).min_element())
        }
        Geometry::Compound(shapes) => shapes.iter().filter_map(edge).reduce(f32::min),
        Geometry::HalfSpace { .. } | Geometry::TriangleMesh(_) | Geometry::HeightField(_) => None,
    }
}

/// Mean normal force of all contacts on a body over the last step of length `dt`, world, N: what a scale reads.
pub fn contact_force(world: &World, body: BodyHandle, dt: f32) -> Vec3 {
    let mut impulse = Vec3::ZERO;
    for contact in world.contacts() {
        // The normal points from B to A: A is pushed along it, B against it.
        let sign = match (contact.a.body == body, contact.b.body == body) {
            (true, false) => 1.0,
            (false, true) => -1.0,
            _ => continue,
        };
        for manifold in contact.manifolds {
            let sum: f32 = manifold.points.iter().map(|p| p.impulse).sum();
            impulse += sign * sum * manifold.normal;
        }
    }
    impulse / dt
}
