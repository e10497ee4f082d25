//! Pairs with cylinders, cones, meshes and height fields: parry finds, we filter, name and reduce.

use crate::collision::clip::Candidates;
use crate::collision::feature_id::{Feature, FeatureId};
use crate::collision::manifold::LocalPoint;
use crate::collision::narrow_phase::LocalManifolds;
use crate::collision::reduce::push_manifold;
use crate::math::Pose;
use crate::shape::Geometry;
use parry3d::query::{ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher};

/// Manifolds of two shapes that have no kernel of their own.
pub(crate) fn other_pair(
    a: &Geometry,
    b: &Geometry,
    b_in_a: &Pose,
    margin: f32,
    length_scale: f32,
    _hint: &mut u32,
    out: &mut LocalManifolds,
) {
    let (Some(shape_a), Some(shape_b)) = (a.to_parry(), b.to_parry()) else { return };
    let mut manifolds: Vec<ContactManifold<(), ()>> = Vec::new();
    let found =
        DefaultQueryDispatcher.contact_manifolds(b_in_a, &*shape_a.0, &*shape_b.0, margin, &mut manifolds, &mut None);
    if found.is_err() {
        return;
    }
    for manifold in &manifolds {
        let outward = manifold.local_n1;
        let mut points = Candidates::new();
        for contact in manifold.points.iter().filter(|contact| contact.dist <= margin) {
            let id = FeatureId::new(Feature::unknown(contact.fid1.0 & 0xffff), Feature::unknown(points.len() as u32));
            let on_b = *b_in_a * contact.local_p2;
            points.push(LocalPoint { on_a: contact.local_p1, on_b, separation: contact.dist, id });
        }
        push_manifold(-outward, (manifold.subshape1, manifold.subshape2), points, 1e-4 * length_scale, out);
    }
}
