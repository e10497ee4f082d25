//! A visit to a block, in the order of its rows or against it.

use super::{DAMPING, ENDS, FRICTION, JointBlock, JointPass, RangeLanes, Target, TurnLanes};
use crate::solver::wide::lanes::{Lane, Lane3, Record, Sides, Symmetric, V3, inverse, load, positive, splat, store};
use fearless_simd::prelude::*;
use fearless_simd::{f32x8, mask32x8};

/// Part of J M⁻¹Jᵀ below which a joint leaves a limit nothing but rounding: `reference.rs`.
const LEAST_FREE: f32 = 1e-4;

/// One visit to eight joints.
#[inline(always)]
pub fn visit<S: Simd, const REVERSED: bool>(
    simd: S,
    block: &mut JointBlock,
    turns: Option<&mut TurnLanes>,
    records: &mut [Record],
    pass: &JointPass,
) {
    let mut sides = Sides::gather(simd, records, &block.bodies[0], &block.bodies[1]);
    match turns {
        Some(turns) => visit_rows::<S, REVERSED>(simd, block, turns, &mut sides, pass),
        None => solve_point(simd, block, &mut sides, pass),
    }
    sides.scatter(simd, records, &block.bodies[0], &block.bodies[1]);
}

#[inline(always)]
fn visit_rows<S: Simd, const REVERSED: bool>(
    simd: S,
    block: &mut JointBlock,
    turns: &mut TurnLanes,
    sides: &mut Sides<S>,
    pass: &JointPass,
) {
    let drags = turns.parts.drags && !pass.by_pose();
    if REVERSED {
        solve_point(simd, block, sides, pass);
    } else if drags {
        for drag in [FRICTION, DAMPING] {
            visit_drag::<S, false>(simd, turns, drag, sides);
        }
    }
    if turns.parts.ranges {
        for k in 0..ENDS.len() {
            let (range, end) = ENDS[if REVERSED { ENDS.len() - 1 - k } else { k }];
            visit_end(simd, block, &mut turns.ranges[range], end, sides, pass);
        }
    }
    if !REVERSED {
        solve_point(simd, block, sides, pass);
    } else if drags {
        for drag in [DAMPING, FRICTION] {
            visit_drag::<S, true>(simd, turns, drag, sides);
        }
    }
}

/// x = K⁻¹ w of the point, D⁻¹ given.
#[inline(always)]
fn substitute<S: Simd>(simd: S, block: &JointBlock, inverse_pivots: V3<S>, w: [f32x8<S>; 3]) -> [f32x8<S>; 3] {
    let l10 = load(simd, &block.lower[0]);
    let (l20, l21) = (load(simd, &block.lower[1]), load(simd, &block.lower[2]));
    let y1 = w[1] - l10 * w[0];
    let y2 = w[2] - (l20 * w[0] + l21 * y1);
    let x2 = y2 * inverse_pivots.z;
    let x1 = y1 * inverse_pivots.y - l21 * x2;
    let x0 = w[0] * inverse_pivots.x - (l10 * x1 + l20 * x2);
    [x0, x1, x2]
}

/// −Δλ = ωK⁻¹(J'u' + bias) of the point.
#[inline(always)]
fn step_of_point<S: Simd>(
    simd: S,
    block: &JointBlock,
    sides: &Sides<S>,
    pass: &JointPass,
    reach: f32,
) -> [f32x8<S>; 3] {
    let relative = sides.relative();
    let moved = match pass.aim {
        Target::ChordToArc => relative.plus(V3::load(simd, &block.arc)),
        Target::ChordFromArc => relative.minus(V3::load(simd, &block.arc)),
        Target::Poses => relative.plus(V3::load(simd, &block.gap).times(splat(simd, pass.recovery))),
    };
    let turned = turned(simd, block, sides.angular_a, sides.angular_b);
    let mut inverse_pivots = V3::load(simd, &block.inverse_pivots);
    if reach != 1.0 {
        // As good as ω times the solution, and done while that waits for w.
        inverse_pivots = inverse_pivots.times(splat(simd, reach));
    }
    substitute(simd, block, inverse_pivots, [moved.x + turned[0], moved.y + turned[1], moved.z + turned[2]])
}

/// Δλ, u' += J'ᵀΔλ.
#[inline(always)]
fn solve_point<S: Simd>(simd: S, block: &mut JointBlock, sides: &mut Sides<S>, pass: &JointPass) {
    let x = step_of_point(simd, block, sides, pass, pass.reach);
    take_step(simd, block, sides, pass, x);
}

/// The same where `wanted`, without over-relaxation.
#[inline(always)]
fn solve_point_where<S: Simd>(
    simd: S,
    block: &mut JointBlock,
    sides: &mut Sides<S>,
    pass: &JointPass,
    wanted: mask32x8<S>,
) {
    let [x, y, z] = step_of_point(simd, block, sides, pass, 1.0);
    let zero = splat(simd, 0.0);
    take_step(simd, block, sides, pass, [wanted.select(x, zero), wanted.select(y, zero), wanted.select(z, zero)]);
}

#[inline(always)]
fn take_step<S: Simd>(simd: S, block: &mut JointBlock, sides: &mut Sides<S>, pass: &JointPass, x: [f32x8<S>; 3]) {
    push_point(simd, block, sides, [-x[0], -x[1], -x[2]]);
    if !pass.by_pose() {
        for k in 0..3 {
            store(load(simd, &block.lambda[k]) - x[k], &mut block.lambda[k]);
        }
    }
}

/// What rotations add to v_A − v_B at the point.
#[inline(always)]
fn turned<S: Simd>(simd: S, block: &JointBlock, of_a: V3<S>, of_b: V3<S>) -> [f32x8<S>; 3] {
    if block.is_round {
        let (arm_a, arm_b) = (V3::load(simd, &block.angular[0][0]), V3::load(simd, &block.angular[1][0]));
        let v = of_a.cross(arm_a).minus(of_b.cross(arm_b));
        return [v.x, v.y, v.z];
    }
    let mut sums = [splat(simd, 0.0); 3];
    for k in 0..3 {
        let (a, b) = (V3::load(simd, &block.angular[0][k]), V3::load(simd, &block.angular[1][k]));
        sums[k] = a.dot(of_a) + b.dot(of_b);
    }
    sums
}

/// u' += J'ᵀλ of the point.
#[inline(always)]
fn push_point<S: Simd>(simd: S, block: &JointBlock, sides: &mut Sides<S>, lambda: [f32x8<S>; 3]) {
    let (mass_a, mass_b) = (load(simd, &block.inverse_mass[0]), load(simd, &block.inverse_mass[1]));
    let impulse = V3 { x: lambda[0], y: lambda[1], z: lambda[2] };
    sides.linear_a = sides.linear_a.plus(impulse.times(mass_a));
    sides.linear_b = sides.linear_b.minus(impulse.times(mass_b));
    if block.is_round {
        let (arm_a, arm_b) = (V3::load(simd, &block.angular[0][0]), V3::load(simd, &block.angular[1][0]));
        sides.angular_a = pushed_round(sides.angular_a, arm_a, impulse);
        sides.angular_b = pushed_round(sides.angular_b, arm_b, impulse.times(splat(simd, -1.0)));
        return;
    }
    for k in 0..3 {
        let (a, b) = (V3::load(simd, &block.angular[0][k]), V3::load(simd, &block.angular[1][k]));
        sides.angular_a = sides.angular_a.plus(a.times(lambda[k]));
        sides.angular_b = sides.angular_b.plus(b.times(lambda[k]));
    }
}

/// ω' + r' × λ, term by term: to the bit what the rows of bodies that are not round give.
#[inline(always)]
fn pushed_round<S: Simd>(spin: V3<S>, arm: V3<S>, impulse: V3<S>) -> V3<S> {
    V3 {
        x: spin.x - arm.z * impulse.y + arm.y * impulse.z,
        y: spin.y + arm.z * impulse.x - arm.x * impulse.z,
        z: spin.z - arm.y * impulse.x + arm.x * impulse.y,
    }
}

/// The end of a range, and then the point again where it is at work: `reference.rs`, `solve_limit`.
#[inline(always)]
fn visit_end<S: Simd>(
    simd: S,
    block: &mut JointBlock,
    range: &mut RangeLanes,
    end: usize,
    sides: &mut Sides<S>,
    pass: &JointPass,
) {
    let zero = splat(simd, 0.0);
    let sign = splat(simd, if end == 0 { 1.0 } else { -1.0 });
    let (a, b) = (V3::load(simd, &range.angular[0]), V3::load(simd, &range.angular[1]));
    let c = load(simd, &range.gaps[end]);
    let inside = c.simd_ge(zero);
    // Not the product where there is no end: ∞ times 0 is no number.
    let back = inside.select(zero, c) * load(simd, &range.trust) * splat(simd, pass.recovery);
    let bias = inside.select(c * splat(simd, pass.per_second), back);
    let w = sign * (a.dot(sides.angular_a) + b.dot(sides.angular_b)) + bias;
    let lambda = load(simd, if pass.by_pose() { &range.pushed[end] } else { &range.lambda[end] });
    let active = lambda.simd_gt(zero) | w.simd_lt(zero);
    if !active.any_true() {
        return;
    }
    if !range.is_free_mass_known {
        find_free_mass(simd, block, range);
    }
    let next = positive(simd, lambda - active.select(w, zero) * load(simd, &range.free_mass));
    let change = active.select(next - lambda, zero);
    store(lambda + change, if pass.by_pose() { &mut range.pushed[end] } else { &mut range.lambda[end] });
    let push = sign * change;
    sides.angular_a = sides.angular_a.plus(a.times(push));
    sides.angular_b = sides.angular_b.plus(b.times(push));
    solve_point_where(simd, block, sides, pass, active);
}

/// 1/(J M⁻¹Jᵀ) of a range's row with what the point leaves free.
#[inline(always)]
fn find_free_mass<S: Simd>(simd: S, block: &JointBlock, range: &mut RangeLanes) {
    let (a, b) = (V3::load(simd, &range.angular[0]), V3::load(simd, &range.angular[1]));
    let coupling = turned(simd, block, a, b);
    let x = substitute(simd, block, V3::load(simd, &block.inverse_pivots), coupling);
    let k = load(simd, &range.k);
    let free = k - (coupling[0] * x[0] + coupling[1] * x[1] + coupling[2] * x[2]);
    let is_free = free.simd_gt(splat(simd, LEAST_FREE) * k);
    store(is_free.select(inverse(simd, free), inverse(simd, k)), &mut range.free_mass);
    range.is_free_mass_known = true;
}

/// Columns of I^−½ of a side.
#[inline(always)]
fn axes_of<S: Simd>(simd: S, root: &[Lane3; 2]) -> [V3<S>; 3] {
    Symmetric { upper: V3::load(simd, &root[0]), lower: V3::load(simd, &root[1]) }.columns()
}

/// Torques against the turning of B relative to A, about one world axis after the other.
#[inline(always)]
fn visit_drag<S: Simd, const REVERSED: bool>(simd: S, turns: &mut TurnLanes, index: usize, sides: &mut Sides<S>) {
    let (of_a, of_b) = (axes_of(simd, &turns.inertia[0]), axes_of(simd, &turns.inertia[1]));
    let drag = &mut turns.drags[index];
    let (softness, reach) = (load(simd, &drag.softness), load(simd, &drag.reach));
    for i in 0..3 {
        let k = if REVERSED { 2 - i } else { i };
        let (a, b) = (of_a[k], of_b[k]);
        let lambda = load(simd, &drag.lambda[k]);
        let w = b.dot(sides.angular_b) - a.dot(sides.angular_a) + softness * lambda;
        let mass = inverse(simd, a.dot(a) + b.dot(b) + softness);
        let free = lambda - w * mass;
        let low = (-reach).simd_gt(free).select(-reach, free);
        let next = low.simd_gt(reach).select(reach, low);
        let change = next - lambda;
        store(next, &mut drag.lambda[k]);
        sides.angular_a = sides.angular_a.minus(a.times(change));
        sides.angular_b = sides.angular_b.plus(b.times(change));
    }
}

/// u' += J'ᵀλ for all impulses of a block.
#[inline(always)]
pub fn warm_start<S: Simd>(simd: S, block: &JointBlock, turns: Option<&TurnLanes>, velocities: &mut [Record]) {
    let mut sides = Sides::gather(simd, velocities, &block.bodies[0], &block.bodies[1]);
    let impulse = V3::load(simd, &block.lambda);
    push_point(simd, block, &mut sides, [impulse.x, impulse.y, impulse.z]);
    if let Some(turns) = turns {
        push_turns(simd, turns, &mut sides);
    }
    sides.scatter(simd, velocities, &block.bodies[0], &block.bodies[1]);
}

#[inline(always)]
fn push_turns<S: Simd>(simd: S, turns: &TurnLanes, sides: &mut Sides<S>) {
    if turns.parts.ranges {
        for (range, end) in ENDS {
            let range = &turns.ranges[range];
            let push = load(simd, &range.lambda[end]) * splat(simd, if end == 0 { 1.0 } else { -1.0 });
            sides.angular_a = sides.angular_a.plus(V3::load(simd, &range.angular[0]).times(push));
            sides.angular_b = sides.angular_b.plus(V3::load(simd, &range.angular[1]).times(push));
        }
    }
    if turns.parts.drags {
        let (of_a, of_b) = (axes_of(simd, &turns.inertia[0]), axes_of(simd, &turns.inertia[1]));
        for drag in &turns.drags {
            for k in 0..3 {
                let lambda = load(simd, &drag.lambda[k]);
                sides.angular_a = sides.angular_a.minus(of_a[k].times(lambda));
                sides.angular_b = sides.angular_b.plus(of_b[k].times(lambda));
            }
        }
    }
}

/// Adds λ to the sums over the substeps.
#[inline(always)]
pub fn add_up<S: Simd>(simd: S, block: &mut JointBlock, turns: Option<&mut TurnLanes>) {
    for k in 0..3 {
        store(load(simd, &block.total[k]) + load(simd, &block.lambda[k]), &mut block.total[k]);
    }
    let Some(turns) = turns else { return };
    if turns.parts.ranges {
        for (range, end) in ENDS {
            let range = &mut turns.ranges[range];
            store(load(simd, &range.total[end]) + load(simd, &range.lambda[end]), &mut range.total[end]);
        }
    }
    if turns.parts.drags {
        for drag in &mut turns.drags {
            for k in 0..3 {
                store(load(simd, &drag.total[k]) + load(simd, &drag.lambda[k]), &mut drag.total[k]);
            }
        }
    }
}

/// The greatest change of an impulse by a visit to a point, N·s, if it is greater than `least`, lane by lane; nothing is changed.
#[inline(always)]
pub fn change_of_point<S: Simd>(
    simd: S,
    block: &JointBlock,
    velocities: &[Record],
    pass: &JointPass,
    least: f32x8<S>,
) -> f32x8<S> {
    let sides = Sides::gather(simd, velocities, &block.bodies[0], &block.bodies[1]);
    let mut greatest = least;
    for x in step_of_point(simd, block, &sides, pass, pass.reach) {
        greatest = x.abs().simd_gt(greatest).select(x.abs(), greatest);
    }
    greatest
}

/// The greatest change of an impulse by a visit to a point, N·s, if it is greater than `least`.
pub fn greatest_change(least: f32, visited: &JointBlock, block: &JointBlock) -> f32 {
    change(least, &visited.lambda, &block.lambda)
}

/// The same of what is asked of rotations, N·m·s.
pub fn greatest_turn(least: f32, visited: &TurnLanes, turns: &TurnLanes) -> f32 {
    let mut greatest = least;
    for (new, old) in visited.ranges.iter().zip(&turns.ranges) {
        greatest = change(greatest, &new.lambda, &old.lambda);
    }
    for (new, old) in visited.drags.iter().zip(&turns.drags) {
        greatest = change(greatest, &new.lambda, &old.lambda);
    }
    greatest
}

fn change<const N: usize>(mut greatest: f32, new: &[Lane; N], old: &[Lane; N]) -> f32 {
    for (new, old) in new.iter().zip(old) {
        for (new, old) in new.iter().zip(old) {
            let change = (new - old).abs();
            greatest = if change > greatest { change } else { greatest };
        }
    }
    greatest
}
