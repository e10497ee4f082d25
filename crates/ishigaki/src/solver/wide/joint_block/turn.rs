//! From poses to rows.

use super::{CONE, JointBlock, RangeLanes, TWIST, TurnLanes};
use crate::solver::wide::lanes::{
    LANES, Q4, Record, Sides, Symmetric, V3, atan2, gather_poses, inverse, load, splat, store,
};
use fearless_simd::f32x8;
use fearless_simd::prelude::*;
use std::f32::consts::{PI, TAU};

/// A row whose pivot is below this part of its diagonal is left out: `block.rs`.
const TINY_PIVOT: f32 = 1e-5;

/// Both bodies of eight joints.
struct Poses<S: Simd> {
    arm_a: V3<S>,
    arm_b: V3<S>,
    rotation_a: Q4<S>,
    rotation_b: Q4<S>,
    /// p_A − p_B.
    gap: V3<S>,
}

#[inline(always)]
fn poses_of<S: Simd>(simd: S, block: &JointBlock, poses: &[Record]) -> Poses<S> {
    let (center_a, rotation_a) = gather_poses(simd, poses, &block.poses[0]);
    let (center_b, rotation_b) = gather_poses(simd, poses, &block.poses[1]);
    let arm_a = rotation_a.turn(simd, V3::load(simd, &block.anchors[0]));
    let arm_b = rotation_b.turn(simd, V3::load(simd, &block.anchors[1]));
    // Centers first: far from the origin their difference is exact, the sums would not be.
    let gap = center_a.minus(center_b).plus(arm_a.minus(arm_b));
    Poses { arm_a, arm_b, rotation_a, rotation_b, gap }
}

/// What rows at a pose depend on beside the joints.
#[derive(Clone, Copy)]
pub struct Aim<'a> {
    /// Centers and rotations.
    pub poses: &'a [Record],
    /// I^−½ of all bodies.
    pub roots: &'a [Record],
    /// Angular velocity of each body, and angular acceleration of its free turning.
    pub spins: &'a [Record],
    /// Substep, s.
    pub h: f32,
}

/// Rows for the poses as they are, `constraint/ball.rs`, `block.rs`, and what the way along arcs adds to the gap in the
/// substep: `constraint/part/point.rs`.
#[inline(always)]
pub fn turn<S: Simd>(simd: S, block: &mut JointBlock, turns: Option<&mut TurnLanes>, aim: &Aim<'_>) {
    let at = poses_of(simd, block, aim.poses);
    at.gap.store(&mut block.gap);
    look_ahead(simd, block, &at, aim);
    if block.is_round && turns.is_none() {
        turn_round(simd, block, &at);
        return;
    }
    let [bodies_a, bodies_b] = &block.bodies;
    let roots = [Symmetric::gather(simd, aim.roots, bodies_a), Symmetric::gather(simd, aim.roots, bodies_b)];
    turn_point(simd, block, &at, &roots);
    if let Some(turns) = turns {
        if turns.parts.drags {
            for (root, lanes) in roots.iter().zip(&mut turns.inertia) {
                root.upper.store(&mut lanes[0]);
                root.lower.store(&mut lanes[1]);
            }
        }
        if turns.parts.ranges {
            turn_ranges(simd, turns, &at, &roots);
        }
    }
}

/// The rows of the point.
#[inline(always)]
fn turn_point<S: Simd>(simd: S, block: &mut JointBlock, at: &Poses<S>, roots: &[Symmetric<S>; 2]) {
    if block.is_round {
        turn_round(simd, block, at);
        return;
    }
    let zero = splat(simd, 0.0);
    let (a, b) = (at.arm_a, at.arm_b);
    // r × e for A, −r × e for B.
    let of_a = [V3 { x: zero, y: a.z, z: -a.y }, V3 { x: -a.z, y: zero, z: a.x }, V3 { x: a.y, y: -a.x, z: zero }];
    let of_b = [V3 { x: zero, y: -b.z, z: b.y }, V3 { x: b.z, y: zero, z: -b.x }, V3 { x: -b.y, y: b.x, z: zero }];
    let (mut a, mut b) = (of_a, of_b);
    for k in 0..3 {
        a[k] = roots[0].times(of_a[k]);
        b[k] = roots[1].times(of_b[k]);
        a[k].store(&mut block.angular[0][k]);
        b[k].store(&mut block.angular[1][k]);
    }
    let diagonals = [
        V3 { x: a[0].dot(a[0]), y: a[1].dot(a[1]), z: a[2].dot(a[2]) },
        V3 { x: b[0].dot(b[0]), y: b[1].dot(b[1]), z: b[2].dot(b[2]) },
    ];
    let beside = V3 {
        x: a[1].dot(a[0]) + b[1].dot(b[0]),
        y: a[2].dot(a[0]) + b[2].dot(b[0]),
        z: a[2].dot(a[1]) + b[2].dot(b[1]),
    };
    factor(simd, block, &diagonals, beside);
}

/// The same of round bodies: to the bit what the rows above give.
#[inline(always)]
fn turn_round<S: Simd>(simd: S, block: &mut JointBlock, at: &Poses<S>) {
    let (a, b) =
        (at.arm_a.times(load(simd, &block.root_inertia[0])), at.arm_b.times(load(simd, &block.root_inertia[1])));
    a.store(&mut block.angular[0][0]);
    b.store(&mut block.angular[1][0]);
    let (xx, yy, zz) = (a.x * a.x, a.y * a.y, a.z * a.z);
    let (pp, qq, rr) = (b.x * b.x, b.y * b.y, b.z * b.z);
    let diagonals = [V3 { x: zz + yy, y: zz + xx, z: yy + xx }, V3 { x: rr + qq, y: rr + pp, z: qq + pp }];
    let beside = V3 { x: -(a.x * a.y) - b.x * b.y, y: -(a.x * a.z) - b.x * b.z, z: -(a.y * a.z) - b.y * b.z };
    factor(simd, block, &diagonals, beside);
}

#[inline(always)]
fn look_ahead<S: Simd>(simd: S, block: &mut JointBlock, at: &Poses<S>, aim: &Aim<'_>) {
    let spin = Sides::gather(simd, aim.spins, &block.bodies[0], &block.bodies[1]);
    let (mut of_a, mut of_b) = (centripetal(spin.linear_a, at.arm_a), centripetal(spin.linear_b, at.arm_b));
    // What is round keeps its ω while nothing pushes it.
    if !block.is_round {
        of_a = of_a.plus(spin.angular_a.cross(at.arm_a));
        of_b = of_b.plus(spin.angular_b.cross(at.arm_b));
    }
    of_a.minus(of_b).times(splat(simd, 0.5 * aim.h)).store(&mut block.arc);
}

/// J M⁻¹Jᵀ = L D Lᵀ of the point; `diagonals` and `beside` (10, 20, 21) are what rotations add to it.
#[inline(always)]
fn factor<S: Simd>(simd: S, block: &mut JointBlock, diagonals: &[V3<S>; 2], beside: V3<S>) {
    let mass = load(simd, &block.inverse_mass[0]) + load(simd, &block.inverse_mass[1]);
    let [a, b] = diagonals;
    let (k00, k11, k22) = (mass + a.x + b.x, mass + a.y + b.y, mass + a.z + b.z);
    let (k10, k20, k21) = (beside.x, beside.y, beside.z);
    let d0 = inverse(simd, k00);
    let (l10, l20) = (k10 * d0, k20 * d0);
    let p1 = k11 - l10 * k10;
    let d1 = inverse_pivot(simd, p1, k11);
    let c21 = k21 - l20 * k10;
    let l21 = c21 * d1;
    let p2 = k22 - l20 * k20 - l21 * c21;
    store(l10, &mut block.lower[0]);
    store(l20, &mut block.lower[1]);
    store(l21, &mut block.lower[2]);
    store(d0, &mut block.inverse_pivots[0]);
    store(d1, &mut block.inverse_pivots[1]);
    store(inverse_pivot(simd, p2, k22), &mut block.inverse_pivots[2]);
}

#[inline(always)]
fn inverse_pivot<S: Simd>(simd: S, pivot: f32x8<S>, diagonal: f32x8<S>) -> f32x8<S> {
    let usable = pivot.simd_gt(splat(simd, TINY_PIVOT) * diagonal);
    usable.select(inverse(simd, pivot), splat(simd, 0.0))
}

/// Twist and cone at the pose: value, axis, and how far the value can be believed.
struct Angle<S: Simd> {
    value: f32x8<S>,
    axis: V3<S>,
    trust: f32x8<S>,
}

#[inline(always)]
fn length<S: Simd>(v: V3<S>) -> f32x8<S> {
    v.dot(v).sqrt()
}

#[inline(always)]
fn constant<S: Simd>(simd: S, v: crate::math::Vec3) -> V3<S> {
    V3 { x: splat(simd, v.x), y: splat(simd, v.y), z: splat(simd, v.z) }
}

/// The angles of twist and cone: `constraint/part/axis.rs`, `twist` and `swing`.
#[inline(always)]
fn angles<S: Simd>(simd: S, turns: &TurnLanes, at: &Poses<S>) -> [Angle<S>; 2] {
    let frame_a = at.rotation_a.after(Q4::load(simd, &turns.frames[0]));
    let frame_b = at.rotation_b.after(Q4::load(simd, &turns.frames[1]));
    let (one, half) = (splat(simd, 1.0), splat(simd, 0.5));
    let x_axis = crate::math::Vec3::X;
    let a = frame_a.turn(simd, constant(simd, x_axis));
    let b = frame_b.turn(simd, constant(simd, x_axis));

    let cross = a.cross(b);
    let sine = length(cross);
    let is_tilted = sine.simd_gt(splat(simd, 1e-5));
    let scale = is_tilted.select(one / is_tilted.select(sine, one), splat(simd, 0.0));
    let across = frame_a.turn(simd, constant(simd, crate::math::tangents(x_axis).0));
    let n = cross.times(scale);
    let n = V3 {
        x: is_tilted.select(n.x, across.x),
        y: is_tilted.select(n.y, across.y),
        z: is_tilted.select(n.z, across.z),
    };
    let cone = Angle { value: atan2(simd, sine, a.dot(b)), axis: n, trust: one };

    let q = frame_a.conjugate(simd).after(frame_b);
    let angle = splat(simd, 2.0) * atan2(simd, q.v.x, q.w);
    let sum = a.plus(b);
    let half_cosine = half * length(sum);
    let least = splat(simd, 0.1);
    let is_sure = half_cosine.simd_gt(least);
    let is_some = half_cosine.simd_gt(splat(simd, 1e-4));
    let bounded = is_sure.select(half_cosine, least);
    let scale = half / (is_some.select(half_cosine, one) * bounded);
    let g = sum.times(scale);
    let g = V3 { x: is_some.select(g.x, a.x), y: is_some.select(g.y, a.y), z: is_some.select(g.z, a.z) };
    let trust = is_sure.select(one, half_cosine / least);
    let middle = load(simd, &turns.ranges[TWIST].middle);
    [Angle { value: nearest_turn(simd, angle, middle), axis: g, trust }, cone]
}

/// An angle of at most a turn either way, plus the whole turns that bring it nearest to the middle, itself within a turn.
#[inline(always)]
fn nearest_turn<S: Simd>(simd: S, angle: f32x8<S>, middle: f32x8<S>) -> f32x8<S> {
    let (pi, turn) = (splat(simd, PI), splat(simd, TAU));
    let mut nearest = angle;
    for _ in 0..2 {
        let off = middle - nearest;
        nearest = off.simd_gt(pi).select(nearest + turn, (-off).simd_gt(pi).select(nearest - turn, nearest));
    }
    nearest
}

#[inline(always)]
fn turn_ranges<S: Simd>(simd: S, turns: &mut TurnLanes, at: &Poses<S>, roots: &[Symmetric<S>; 2]) {
    let [twist, cone] = angles(simd, turns, at);
    turn_range(simd, &mut turns.ranges[TWIST], &twist, roots);
    turn_range(simd, &mut turns.ranges[CONE], &cone, roots);
}

#[inline(always)]
fn turn_range<S: Simd>(simd: S, range: &mut RangeLanes, angle: &Angle<S>, roots: &[Symmetric<S>; 2]) {
    let a = roots[0].times(angle.axis).times(splat(simd, -1.0));
    let b = roots[1].times(angle.axis);
    a.store(&mut range.angular[0]);
    b.store(&mut range.angular[1]);
    angle.axis.store(&mut range.axis);
    store(angle.trust, &mut range.trust);
    store(a.dot(a) + b.dot(b), &mut range.k);
    range.is_free_mass_known = false;
    // A recovery by poses begins without impulses.
    range.pushed = [[0.0; LANES]; 2];
    store_gaps(simd, range, angle);
}

#[inline(always)]
fn store_gaps<S: Simd>(simd: S, range: &mut RangeLanes, angle: &Angle<S>) {
    store(angle.value - load(simd, &range.limits[0]), &mut range.gaps[0]);
    store(load(simd, &range.limits[1]) - angle.value, &mut range.gaps[1]);
}

/// Errors for the poses as they are, without rows.
#[inline(always)]
pub fn see<S: Simd>(simd: S, block: &mut JointBlock, turns: Option<&mut TurnLanes>, poses: &[Record]) {
    let at = poses_of(simd, block, poses);
    at.gap.store(&mut block.gap);
    if let Some(turns) = turns.filter(|turns| turns.parts.ranges) {
        let [twist, cone] = angles(simd, turns, &at);
        store_gaps(simd, &mut turns.ranges[TWIST], &twist);
        store_gaps(simd, &mut turns.ranges[CONE], &cone);
    }
}

/// ω×(ω×r), m/s².
#[inline(always)]
fn centripetal<S: Simd>(w: V3<S>, arm: V3<S>) -> V3<S> {
    w.cross(w.cross(arm))
}
