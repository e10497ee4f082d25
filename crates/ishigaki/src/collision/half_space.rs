//! A half-space against everything: the lowest points of the other shape.
//!
//! Boxes and hulls touch with vertices, balls and capsules with the ends of their core. A cylinder or a cone
//! stands on eight points of its rim that keep their names, and on the one deepest point of the rim between
//! them, so that it rolls as a circle does. Test: `tests/narrow_phase.rs`.

use crate::collision::clip::Candidates;
use crate::collision::curved::DEEPEST;
use crate::collision::feature_id::{Feature, FeatureId};
use crate::collision::manifold::LocalPoint;
use crate::collision::narrow_phase::LocalManifolds;
use crate::collision::polyhedron::{BoxPolyhedron, Polyhedron};
use crate::collision::reduce::push_manifold;
use crate::math::{Pose, Vec3, cos, sin};
use crate::shape::Geometry;

/// Points of a rim with fixed names.
pub(crate) const RIM_POINTS: u32 = 8;
/// A cap stands on its rim if its normal is within this cosine of the plane's.
const STANDING: f32 = 0.7;

/// A half-space and anything solid, in the frame of the half-space.
pub(crate) fn half_space(
    normal: Vec3,
    solid: &Geometry,
    pose: &Pose,
    margin: f32,
    length_scale: f32,
    out: &mut LocalManifolds,
) {
    let mut floor = Floor { normal, down: pose.rotation.inverse() * -normal, pose, margin, points: Candidates::new() };
    match solid {
        Geometry::Ball { radius } => floor.push(Vec3::ZERO, *radius, Feature::vertex(0)),
        Geometry::Capsule { half_length, radius } => floor.push_capsule(*half_length, *radius),
        Geometry::Cuboid { half_extents } => floor.push_vertices(&BoxPolyhedron::new(*half_extents).view()),
        Geometry::ConvexHull(hull) => floor.push_vertices(&hull.view()),
        Geometry::Cylinder { half_height, radius } => {
            floor.push_rim(0, -half_height, *radius);
            floor.push_rim(1, *half_height, *radius);
        }
        Geometry::Cone { half_height, radius } => {
            floor.push_rim(0, -half_height, *radius);
            floor.push(Vec3::new(0.0, *half_height, 0.0), 0.0, Feature::vertex(RIM_POINTS));
        }
        _ => {}
    }
    // B's surface normal points into the half-space.
    push_manifold(-normal, 0, &mut floor.points, 1e-4 * length_scale, out);
}

struct Floor<'a> {
    normal: Vec3,
    /// Against the normal, in the frame of the solid.
    down: Vec3,
    pose: &'a Pose,
    margin: f32,
    points: Candidates,
}

impl Floor<'_> {
    /// A point of the solid, `radius` under its surface.
    fn push(&mut self, local: Vec3, radius: f32, feature: Feature) {
        let on_b = *self.pose * local - self.normal * radius;
        let separation = self.normal.dot(on_b);
        if separation <= self.margin {
            let on_a = on_b - self.normal * separation;
            let id = FeatureId::new(Feature::face(0), feature);
            self.points.push(LocalPoint { on_a, on_b, separation, id });
        }
    }

    /// Both ends as soon as one is near, unless it stands upright: what hits a limb may swing the other end down, and
    /// through the surface, within the step.
    fn push_capsule(&mut self, half_length: f32, radius: f32) {
        let lowest = self.normal.dot(self.pose.translation) - half_length * self.down.y.abs() - radius;
        if lowest <= self.margin {
            self.margin = self.margin.max(half_length);
        }
        self.push(Vec3::new(0.0, -half_length, 0.0), radius, Feature::vertex(0));
        if half_length > 0.0 {
            self.push(Vec3::new(0.0, half_length, 0.0), radius, Feature::vertex(1));
        }
    }

    fn push_vertices(&mut self, solid: &Polyhedron) {
        for (i, &vertex) in solid.vertices.iter().enumerate() {
            self.push(vertex, 0.0, Feature::vertex(i as u32));
        }
    }

    /// The rim number `rim` of a cylinder or cone, at `height` on its axis.
    fn push_rim(&mut self, rim: u32, height: f32, radius: f32) {
        let center = Vec3::new(0.0, height, 0.0);
        let outward = Vec3::new(self.down.x, 0.0, self.down.z);
        if let Some(outward) = outward.try_normalize() {
            self.push(center + outward * radius, 0.0, Feature::vertex(DEEPEST + rim));
        }
        if self.down.y * height.signum() > STANDING {
            for (i, point) in rim_points(height, radius).into_iter().enumerate() {
                self.push(point, 0.0, Feature::vertex(rim * RIM_POINTS + i as u32));
            }
        }
    }
}

/// Eight points around a rim, in the order of the angle from X toward −Z: counter-clockwise seen from above.
pub(crate) fn rim_points(height: f32, radius: f32) -> [Vec3; RIM_POINTS as usize] {
    std::array::from_fn(|i| {
        let angle = i as f32 * (std::f32::consts::TAU / RIM_POINTS as f32);
        Vec3::new(radius * cos(angle), height, -radius * sin(angle))
    })
}
