//! The rarer pairs: cylinders and cones with everything, surfaces with everything solid.

use crate::collision::curved::{Curved, Solid, curved_capsule, curved_curved, curved_pair, nearest_on_curved};
use crate::collision::feature_id::Feature;
use crate::collision::mesh::surface_solid;
use crate::collision::narrow_phase::{LocalManifolds, with_polyhedron};
use crate::collision::round::{Nearest, push_ball_of_part};
use crate::collision::sat::Tolerance;
use crate::math::Pose;
use crate::shape::Geometry;
use parry3d::shape::Cuboid;

/// Manifolds of two shapes without a kernel for the pair alone; A is of no lower rank than B.
pub(crate) fn other_pair(
    a: &Geometry,
    b: &Geometry,
    b_in_a: &Pose,
    margin: f32,
    length_scale: f32,
    hint: &mut u32,
    out: &mut LocalManifolds,
) {
    let tolerance = Tolerance::new(margin, length_scale, a.inner_radius().min(b.inner_radius()));
    let center = b_in_a.translation;
    match (a, Curved::new(a), b, Curved::new(b)) {
        // Neither two surfaces nor parts of a compound reach this place with something to touch.
        (Geometry::TriangleMesh(_) | Geometry::HeightField(_), ..) if b.is_solid() => {
            surface_solid(a, b, b_in_a, margin, length_scale, out);
        }
        (_, Some(a), Geometry::Ball { radius }, _) => {
            let (point, normal, distance) = nearest_on_curved(&a, center);
            let nearest = Nearest { point, normal, distance, feature: Feature::unknown(0) };
            push_ball_of_part(nearest, *radius, center, margin, 0, out);
        }
        (_, Some(a), Geometry::Capsule { half_length, radius }, _) => {
            curved_capsule(&a, (*half_length, *radius), b_in_a, &tolerance, out);
        }
        (_, Some(a), _, Some(b)) => curved_curved(&a, &b, b_in_a, &tolerance, hint, out),
        (Geometry::Cuboid { half_extents }, _, _, Some(b)) => with_polyhedron(a, |solid| {
            let shape = Cuboid::new(*half_extents);
            curved_pair(Solid::Polyhedron(solid), &shape, &b, b_in_a, &tolerance, hint, out);
        }),
        (Geometry::ConvexHull(hull), _, _, Some(b)) => {
            curved_pair(Solid::Polyhedron(hull.view()), &*hull.polyhedron, &b, b_in_a, &tolerance, hint, out);
        }
        _ => {}
    }
}
