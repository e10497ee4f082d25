//! A visit to a block, in the order of its rows or against it.

use super::{DAMPING, ENDS, FRICTION, JointBlock, JointPass};
use crate::solver::wide::lanes::{Lane, Lane3, Record, Sides, Symmetric, V3, inverse, load, positive, splat, store};
use fearless_simd::prelude::*;
use fearless_simd::{f32x8, mask32x8};

/// Part of J'J'ᵀ below which a joint leaves a limit nothing but rounding: `reference.rs`.
const LEAST_FREE: f32 = 1e-4;

/// One visit to eight joints.
#[inline(always)]
pub fn visit<S: Simd, const REVERSED: bool>(simd: S, block: &mut JointBlock, records: &mut [Record], pass: &JointPass) {
    let mut sides = Sides::gather(simd, records, &block.bodies[0], &block.bodies[1]);
    visit_rows::<S, REVERSED>(simd, block, &mut sides, pass);
    sides.scatter(simd, records, &block.bodies[0], &block.bodies[1]);
}

#[inline(always)]
fn visit_rows<S: Simd, const REVERSED: bool>(simd: S, block: &mut JointBlock, sides: &mut Sides<S>, pass: &JointPass) {
    let all = splat(simd, 1.0).simd_gt(splat(simd, 0.0));
    let drags = block.parts.drags && !pass.by_pose;
    if REVERSED {
        solve_point(simd, block, sides, pass, all);
    } else if drags {
        for drag in [FRICTION, DAMPING] {
            visit_drag::<S, false>(simd, block, drag, sides);
        }
    }
    if block.parts.ranges {
        for k in 0..ENDS.len() {
            let (range, end) = ENDS[if REVERSED { ENDS.len() - 1 - k } else { k }];
            visit_end(simd, block, range, end, sides, pass);
        }
    }
    if !REVERSED {
        solve_point(simd, block, sides, pass, all);
    } else if drags {
        for drag in [DAMPING, FRICTION] {
            visit_drag::<S, true>(simd, block, drag, sides);
        }
    }
}

/// x = K⁻¹ w of the point.
#[inline(always)]
fn substitute<S: Simd>(simd: S, block: &JointBlock, w: [f32x8<S>; 3]) -> [f32x8<S>; 3] {
    let l10 = load(simd, &block.lower[0]);
    let (l20, l21) = (load(simd, &block.lower[1]), load(simd, &block.lower[2]));
    let y1 = w[1] - l10 * w[0];
    let y2 = w[2] - (l20 * w[0] + l21 * y1);
    let x2 = y2 * load(simd, &block.inverse_pivots[2]);
    let x1 = y1 * load(simd, &block.inverse_pivots[1]) - l21 * x2;
    let x0 = w[0] * load(simd, &block.inverse_pivots[0]) - (l10 * x1 + l20 * x2);
    [x0, x1, x2]
}

/// Δλ = −K⁻¹(J'u' + bias), u' += J'ᵀΔλ, where `wanted`.
#[inline(always)]
fn solve_point<S: Simd>(simd: S, block: &mut JointBlock, sides: &mut Sides<S>, pass: &JointPass, wanted: mask32x8<S>) {
    let (root_a, root_b) = (load(simd, &block.root[0]), load(simd, &block.root[1]));
    let relative = sides.relative(root_a, root_b);
    let gap = V3::load(simd, &block.gap).times(splat(simd, pass.recovery));
    let bias = gap.plus(V3::load(simd, &block.arc).times(splat(simd, pass.arc)));
    let mut w = [relative.x + bias.x, relative.y + bias.y, relative.z + bias.z];
    for k in 0..3 {
        let (a, b) = (V3::load(simd, &block.angular[0][k]), V3::load(simd, &block.angular[1][k]));
        w[k] += a.dot(sides.angular_a) + b.dot(sides.angular_b);
    }
    let x = substitute(simd, block, w);
    let zero = splat(simd, 0.0);
    let x = [wanted.select(x[0], zero), wanted.select(x[1], zero), wanted.select(x[2], zero)];
    push_point(simd, block, sides, [-x[0], -x[1], -x[2]]);
    if !pass.by_pose {
        for k in 0..3 {
            store(load(simd, &block.lambda[k]) - x[k], &mut block.lambda[k]);
        }
    }
}

/// u' += J'ᵀλ of the point.
#[inline(always)]
fn push_point<S: Simd>(simd: S, block: &JointBlock, sides: &mut Sides<S>, lambda: [f32x8<S>; 3]) {
    let (root_a, root_b) = (load(simd, &block.root[0]), load(simd, &block.root[1]));
    let impulse = V3 { x: lambda[0], y: lambda[1], z: lambda[2] };
    sides.linear_a = sides.linear_a.plus(impulse.times(root_a));
    sides.linear_b = sides.linear_b.minus(impulse.times(root_b));
    for k in 0..3 {
        let (a, b) = (V3::load(simd, &block.angular[0][k]), V3::load(simd, &block.angular[1][k]));
        sides.angular_a = sides.angular_a.plus(a.times(lambda[k]));
        sides.angular_b = sides.angular_b.plus(b.times(lambda[k]));
    }
}

/// The end of a range, and then the point again where it is at work: `reference.rs`, `solve_limit`.
#[inline(always)]
fn visit_end<S: Simd>(
    simd: S,
    block: &mut JointBlock,
    index: usize,
    end: usize,
    sides: &mut Sides<S>,
    pass: &JointPass,
) {
    let zero = splat(simd, 0.0);
    let sign = splat(simd, if end == 0 { 1.0 } else { -1.0 });
    let range = &block.ranges[index];
    let (a, b) = (V3::load(simd, &range.angular[0]), V3::load(simd, &range.angular[1]));
    let c = load(simd, &range.gaps[end]);
    let inside = c.simd_ge(zero);
    // Not the product where there is no end: ∞ times 0 is no number.
    let back = inside.select(zero, c) * load(simd, &range.trust) * splat(simd, pass.recovery);
    let bias = inside.select(c * splat(simd, pass.per_second), back);
    let w = sign * (a.dot(sides.angular_a) + b.dot(sides.angular_b)) + bias;
    let lambda = load(simd, if pass.by_pose { &range.pushed[end] } else { &range.lambda[end] });
    let active = lambda.simd_gt(zero) | w.simd_lt(zero);
    if !active.any_true() {
        return;
    }
    if !range.is_free_mass_known {
        find_free_mass(simd, block, index);
    }
    let range = &mut block.ranges[index];
    let next = positive(simd, lambda - active.select(w, zero) * load(simd, &range.free_mass));
    let change = active.select(next - lambda, zero);
    store(lambda + change, if pass.by_pose { &mut range.pushed[end] } else { &mut range.lambda[end] });
    let push = sign * change;
    sides.angular_a = sides.angular_a.plus(a.times(push));
    sides.angular_b = sides.angular_b.plus(b.times(push));
    solve_point(simd, block, sides, pass, active);
}

/// 1/(J'J'ᵀ) of a range's row with what the point leaves free.
#[inline(always)]
fn find_free_mass<S: Simd>(simd: S, block: &mut JointBlock, index: usize) {
    let range = &block.ranges[index];
    let (a, b) = (V3::load(simd, &range.angular[0]), V3::load(simd, &range.angular[1]));
    let mut coupling = [splat(simd, 0.0); 3];
    for k in 0..3 {
        let (row_a, row_b) = (V3::load(simd, &block.angular[0][k]), V3::load(simd, &block.angular[1][k]));
        coupling[k] = row_a.dot(a) + row_b.dot(b);
    }
    let x = substitute(simd, block, coupling);
    let k = load(simd, &range.k);
    let free = k - (coupling[0] * x[0] + coupling[1] * x[1] + coupling[2] * x[2]);
    let is_free = free.simd_gt(splat(simd, LEAST_FREE) * k);
    let mass = is_free.select(inverse(simd, free), inverse(simd, k));
    let range = &mut block.ranges[index];
    store(mass, &mut range.free_mass);
    range.is_free_mass_known = true;
}

/// Columns of I^−½ of a side.
#[inline(always)]
fn axes_of<S: Simd>(simd: S, root: &[Lane3; 2]) -> [V3<S>; 3] {
    Symmetric { upper: V3::load(simd, &root[0]), lower: V3::load(simd, &root[1]) }.columns()
}

/// Torques against the turning of B relative to A, about one world axis after the other.
#[inline(always)]
fn visit_drag<S: Simd, const REVERSED: bool>(simd: S, block: &mut JointBlock, index: usize, sides: &mut Sides<S>) {
    let (of_a, of_b) = (axes_of(simd, &block.inertia[0]), axes_of(simd, &block.inertia[1]));
    let drag = &mut block.drags[index];
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
pub fn warm_start<S: Simd>(simd: S, block: &JointBlock, velocities: &mut [Record]) {
    let mut sides = Sides::gather(simd, velocities, &block.bodies[0], &block.bodies[1]);
    let impulse = V3::load(simd, &block.lambda);
    push_point(simd, block, &mut sides, [impulse.x, impulse.y, impulse.z]);
    if block.parts.ranges {
        for (range, end) in ENDS {
            let range = &block.ranges[range];
            let push = load(simd, &range.lambda[end]) * splat(simd, if end == 0 { 1.0 } else { -1.0 });
            sides.angular_a = sides.angular_a.plus(V3::load(simd, &range.angular[0]).times(push));
            sides.angular_b = sides.angular_b.plus(V3::load(simd, &range.angular[1]).times(push));
        }
    }
    if block.parts.drags {
        let (of_a, of_b) = (axes_of(simd, &block.inertia[0]), axes_of(simd, &block.inertia[1]));
        for drag in &block.drags {
            for k in 0..3 {
                let lambda = load(simd, &drag.lambda[k]);
                sides.angular_a = sides.angular_a.minus(of_a[k].times(lambda));
                sides.angular_b = sides.angular_b.plus(of_b[k].times(lambda));
            }
        }
    }
    sides.scatter(simd, velocities, &block.bodies[0], &block.bodies[1]);
}

/// Adds λ to the sums over the substeps.
#[inline(always)]
pub fn add_up<S: Simd>(simd: S, block: &mut JointBlock) {
    for k in 0..3 {
        store(load(simd, &block.total[k]) + load(simd, &block.lambda[k]), &mut block.total[k]);
    }
    if block.parts.ranges {
        for (range, end) in ENDS {
            let range = &mut block.ranges[range];
            store(load(simd, &range.total[end]) + load(simd, &range.lambda[end]), &mut range.total[end]);
        }
    }
    if block.parts.drags {
        for drag in &mut block.drags {
            for k in 0..3 {
                store(load(simd, &drag.total[k]) + load(simd, &drag.lambda[k]), &mut drag.total[k]);
            }
        }
    }
}

/// The greatest change of an impulse by a visit, N·s or N·m·s, if it is greater than `least`.
pub fn greatest_change(least: f32, visited: &JointBlock, block: &JointBlock) -> f32 {
    let mut greatest = change(least, &visited.lambda, &block.lambda);
    for (new, old) in visited.ranges.iter().zip(&block.ranges) {
        greatest = change(greatest, &new.lambda, &old.lambda);
    }
    for (new, old) in visited.drags.iter().zip(&block.drags) {
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
