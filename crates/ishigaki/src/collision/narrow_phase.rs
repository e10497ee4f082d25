//! Chooses the kernel of a pair of shapes.

use crate::collision::box_box::box_box;
use crate::collision::half_space::half_space;
use crate::collision::hull_hull::hull_hull;
use crate::collision::manifold::LocalManifold;
use crate::collision::other_pairs::other_pair;
use crate::collision::pair_memory::PairMemory;
use crate::collision::polyhedron::{BoxPolyhedron, Polyhedron};
use crate::collision::round::{
    PlacedCapsule, ball_ball, capsule_ball, capsule_capsule, nearest_on_box, nearest_on_polyhedron, polyhedron_ball,
    polyhedron_capsule, push_ball_of_part,
};
use crate::math::Pose;
use crate::shape::Geometry;
use smallvec::SmallVec;

/// The manifolds of a pair; reused from pair to pair.
pub type LocalManifolds = SmallVec<[LocalManifold; 1]>;

/// Finds all manifolds of A and B with separations up to `margin` (m).
///
/// Everything is in the frame of A; `b_in_a` is the pose of B there. `memory` is kept between steps by
/// the caller (the default at first), for one pair of shapes that do not change: it lets the kernel prefer the axis of
/// the last step, and leave out what cannot have changed. `length_scale` is the
/// typical size of a body, m: tolerances are multiples of it. Poses that are not finite give no manifold.
pub fn find_manifolds(
    a: &Geometry,
    b: &Geometry,
    b_in_a: &Pose,
    margin: f32,
    length_scale: f32,
    memory: &mut PairMemory,
    out: &mut LocalManifolds,
) {
    out.clear();
    if !b_in_a.is_finite() {
        return;
    }
    // Every kernel is written for one order; the other order is its mirror image.
    if rank(a) < rank(b) {
        let a_in_b = b_in_a.inverse();
        find_ordered(b, a, &a_in_b, margin, length_scale, memory, out);
        out.iter_mut().for_each(|manifold| manifold.mirror(b_in_a));
    } else {
        find_ordered(a, b, b_in_a, margin, length_scale, memory, out);
    }
}

/// Kernels take the shape of higher rank first.
fn rank(geometry: &Geometry) -> u32 {
    match geometry {
        Geometry::Ball { .. } => 0,
        Geometry::Capsule { .. } => 1,
        Geometry::Cylinder { .. } | Geometry::Cone { .. } => 2,
        // Boxes and hulls share a kernel that takes them in any order.
        Geometry::Cuboid { .. } | Geometry::ConvexHull(_) => 3,
        Geometry::HeightField(_) | Geometry::TriangleMesh(_) | Geometry::Compound(_) => 4,
        Geometry::HalfSpace { .. } => 5,
    }
}

/// As [`find_manifolds`]; A is of no lower rank than B.
fn find_ordered(
    a: &Geometry,
    b: &Geometry,
    b_in_a: &Pose,
    margin: f32,
    length_scale: f32,
    memory: &mut PairMemory,
    out: &mut LocalManifolds,
) {
    use Geometry::{Ball, Capsule, ConvexHull, Cuboid, HalfSpace};
    let center = b_in_a.translation;
    match (a, b) {
        (HalfSpace { normal }, _) => half_space(*normal, b, b_in_a, margin, length_scale, out),
        (Ball { radius: radius_a }, Ball { radius: radius_b }) => {
            ball_ball(*radius_a, *radius_b, center, margin, out);
        }
        (Capsule { half_length, radius: radius_a }, Ball { radius: radius_b }) => {
            capsule_ball((*half_length, *radius_a), *radius_b, center, margin, out);
        }
        (Capsule { half_length: half_a, radius: radius_a }, Capsule { half_length: half_b, radius: radius_b }) => {
            let first = PlacedCapsule::new(*half_a, *radius_a, &Pose::IDENTITY);
            capsule_capsule(&first, &PlacedCapsule::new(*half_b, *radius_b, b_in_a), margin, out);
        }
        (Cuboid { half_extents }, Ball { radius }) => {
            let nearest = nearest_on_box(*half_extents, center);
            if nearest.feature.as_face().is_some() {
                push_ball_of_part(nearest, *radius, center, margin, 0, out);
            } else if nearest.distance - radius <= margin {
                with_polyhedron(a, |a| polyhedron_ball(&a, nearest, (*radius, center), margin, length_scale, out));
            }
        }
        (ConvexHull(hull), Ball { radius }) => {
            let nearest = nearest_on_polyhedron(&hull.view(), center);
            polyhedron_ball(&hull.view(), nearest, (*radius, center), margin, length_scale, out);
        }
        (Cuboid { half_extents: half_a }, Cuboid { half_extents: half_b }) => {
            box_box(*half_a, *half_b, b_in_a, margin, length_scale, &mut memory.axis, out);
        }
        (Cuboid { .. } | ConvexHull(_), Capsule { half_length, radius }) => with_polyhedron(a, |solid| {
            let capsule = PlacedCapsule::new(*half_length, *radius, b_in_a);
            polyhedron_capsule(&solid, &capsule, margin, length_scale, out);
        }),
        (Cuboid { .. } | ConvexHull(_), Cuboid { .. } | ConvexHull(_)) => {
            let known = memory.recall(b_in_a, b.outer_radius());
            if !known.is_gap_beyond(margin) {
                with_polyhedron(a, |a| {
                    with_polyhedron(b, |b| hull_hull((a, b), b_in_a, (margin, length_scale), (known, memory), out));
                });
            }
        }
        _ => other_pair(a, b, b_in_a, margin, length_scale, &mut memory.axis, out),
    }
}

/// Boxes and hulls as polyhedra; nothing happens for other shapes.
pub(crate) fn with_polyhedron(geometry: &Geometry, mut use_it: impl FnMut(Polyhedron)) {
    match geometry {
        Geometry::Cuboid { half_extents } => use_it(BoxPolyhedron::new(*half_extents).view()),
        Geometry::ConvexHull(hull) => use_it(hull.view()),
        _ => {}
    }
}

impl LocalManifold {
    /// The same contact with A and B exchanged, in the frame of the new A, where the old A is at `pose`.
    fn mirror(&mut self, pose: &Pose) {
        self.normal = -(pose.rotation * self.normal);
        for point in &mut self.points {
            (point.on_a, point.on_b) = (*pose * point.on_b, *pose * point.on_a);
            point.id = point.id.swapped();
        }
    }
}
