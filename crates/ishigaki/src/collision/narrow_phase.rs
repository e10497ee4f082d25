//! Chooses the kernel of a pair of shapes: our own for the hot pairs, parry for the rest.

use crate::collision::manifold::LocalManifold;
use crate::math::Pose;
use crate::shape::Geometry;
use smallvec::SmallVec;

/// The manifolds of a pair; reused from pair to pair.
pub type LocalManifolds = SmallVec<[LocalManifold; 1]>;

/// Finds all manifolds of A and B with separations up to `margin` (m).
///
/// Everything is in the frame of A; `b_in_a` is the pose of B there. `hint` is remembered between steps by
/// the caller (0 at first) and lets the kernel prefer the axis of the last step. `length_scale` is the
/// typical size of a body, m: tolerances are multiples of it.
pub fn find_manifolds(
    _a: &Geometry,
    _b: &Geometry,
    _b_in_a: &Pose,
    _margin: f32,
    _length_scale: f32,
    _hint: &mut u32,
    out: &mut LocalManifolds,
) {
    out.clear();
    todo!()
}
