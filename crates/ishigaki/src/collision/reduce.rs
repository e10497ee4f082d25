//! At most four points of a manifold: the deepest, then those that span the greatest area.
//!
//! More than four add rows but no support. The choice must not flicker while nothing moves, or warm starts are
//! lost: points are visited in the order of their ids, and a later point wins only by a clear lead.
//! Tests: `tests/feature_ids.rs`.

use crate::collision::clip::Candidates;
use crate::collision::manifold::{LocalManifold, LocalPoint, MAX_POINTS};
use crate::collision::narrow_phase::LocalManifolds;
use crate::math::Vec3;
use arrayvec::ArrayVec;

/// A later candidate must lead by this factor.
const LEAD: f32 = 1.02;

/// Appends the manifold of these candidates, if there are any.
///
/// `normal` is B's; depths that differ by less than `tolerance` (m) count as equal.
pub(crate) fn push_manifold(
    normal: Vec3,
    part: u32,
    candidates: &mut Candidates,
    tolerance: f32,
    out: &mut LocalManifolds,
) {
    // A point that is not a number would poison the whole world.
    let is_finite = |p: &LocalPoint| p.separation.is_finite() && p.on_a.is_finite() && p.on_b.is_finite();
    if !candidates.iter().all(is_finite) {
        candidates.retain(|p| is_finite(p));
    }
    if candidates.is_empty() || !normal.is_finite() {
        return;
    }
    sort_by_name(candidates);
    candidates.dedup_by(|p, q| p.id == q.id);
    let points = if candidates.len() <= MAX_POINTS {
        candidates.iter().copied().collect()
    } else {
        spread(normal, candidates, tolerance)
    };
    out.push(LocalManifold { normal, points, part });
}

/// Sorts by name, of equal names the deeper first; a few points, which most manifolds have, without the library's means
/// for many.
fn sort_by_name(points: &mut [LocalPoint]) {
    const FEW: usize = 8;
    let before = |p: ((u32, bool), f32), q: ((u32, bool), f32)| p.0.cmp(&q.0).then(p.1.total_cmp(&q.1));
    let key = |p: &LocalPoint| (p.id.order(), p.separation);
    if points.len() > FEW {
        points.sort_by(|p, q| before(key(p), key(q)));
        return;
    }
    let mut keys = [((0, false), 0.0); FEW];
    for i in 0..points.len() {
        let (point, new) = (points[i], key(&points[i]));
        let mut place = i;
        while place > 0 && before(new, keys[place - 1]).is_lt() {
            (points[place], keys[place]) = (points[place - 1], keys[place - 1]);
            place -= 1;
        }
        (points[place], keys[place]) = (point, new);
    }
}

/// Appends the manifold of a single point.
pub(crate) fn push_point(normal: Vec3, part: u32, point: LocalPoint, out: &mut LocalManifolds) {
    let finite = [normal, point.on_a, point.on_b].iter().all(|v| v.is_finite()) && point.separation.is_finite();
    if finite {
        let mut points = ArrayVec::new();
        points.push(point);
        out.push(LocalManifold { normal, points, part });
    }
}

fn spread(normal: Vec3, candidates: &[LocalPoint], tolerance: f32) -> ArrayVec<LocalPoint, MAX_POINTS> {
    let mut chosen = ArrayVec::new();
    let deepest = candidates.iter().map(|p| p.separation).fold(f32::INFINITY, f32::min);
    let Some(first) = candidates.iter().find(|p| p.separation <= deepest + tolerance) else { return chosen };
    chosen.push(*first);

    let flat = |p: &LocalPoint| {
        let middle = 0.5 * (p.on_a + p.on_b);
        middle - normal * normal.dot(middle)
    };
    let origin = flat(first);
    let Some(second) = greatest(candidates, |p| (flat(p) - origin).length_squared()) else { return chosen };
    chosen.push(*second);

    // Twice the signed area of a triangle, seen along the normal.
    let area = |a: Vec3, b: Vec3, c: Vec3| (b - a).cross(c - a).dot(normal);
    let far = flat(second);
    let Some(third) = greatest(candidates, |p| area(origin, far, flat(p)).abs()) else { return chosen };
    chosen.push(*third);

    // What a fourth point adds outside each side of the triangle of the first three.
    let side = flat(third);
    let turn = area(origin, far, side).signum();
    let added = |p: &LocalPoint| {
        let p = flat(p);
        let outside = [area(origin, far, p), area(far, side, p), area(side, origin, p)];
        outside.iter().fold(0.0, |sum: f32, a| sum + (-turn * a).max(0.0))
    };
    if let Some(fourth) = greatest(candidates, added) {
        chosen.push(*fourth);
    }
    chosen
}

/// The candidate with the clearly greatest positive value.
fn greatest(candidates: &[LocalPoint], value: impl Fn(&LocalPoint) -> f32) -> Option<&LocalPoint> {
    let mut best = None;
    let mut lead = 0.0;
    for point in candidates {
        let value = value(point);
        if value > lead {
            lead = value * LEAD;
            best = Some(point);
        }
    }
    best
}
