//! Projected Gauss–Seidel, the readable reference. TALK C3, C7.
//!
//! A sweep visits units of rows in the planned order: Δλ = −(J u + γλ + bias) / (J M⁻¹Jᵀ + γ), the *sum*
//! λ + Δλ clamped to its bounds, u += M⁻¹Jᵀ Δλ. That is all; no technique is known here. A friction disk is
//! two rows solved together: the 2×2 system first, then the vector clamped to the disk; equality rows of a joint
//! are solved together too (`block.rs`).

use crate::constraint::friction::{Bound, Coupling};
use crate::solver::block::Block;
use crate::solver::plan::Plan;
use crate::solver::table::{Row, SolverBody, inner};

/// What a sweep visits as one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// A row with its partners.
    Row(u32),
    /// Index of a manifold block.
    Manifold(u32),
    /// Index of a joint tree.
    Tree(u32),
}

/// One sweep over the units of a plan in their order; `passes` for the normals of manifold blocks.
pub fn sweep(plan: &mut Plan, passes: u32) {
    for k in 0..plan.units.len() {
        visit(plan.units[k], plan, passes);
    }
}

// ANCHOR: over_relaxed
/// The same with over-relaxation of the joints that are solved one by one: `over_relaxation.rs`.
pub fn sweep_over_relaxed(plan: &mut Plan, passes: u32, factor: f32) {
    for k in 0..plan.units.len() {
        match plan.units[k] {
            Unit::Row(row) => match plan.rows[row as usize].coupling {
                Coupling::Block(index) if plan.rows[row as usize].by_pose => {
                    plan.blocks[index as usize].step(factor, &mut plan.rows, &mut plan.bodies);
                }
                _ => visit(plan.units[k], plan, passes),
            },
            unit => visit(unit, plan, passes),
        }
    }
}
// ANCHOR_END: over_relaxed

/// Visits the equality rows of joints alone, back and forth.
pub fn revisit_joints(plan: &mut Plan) {
    let count = plan.units.len();
    for k in (0..count).rev().chain(0..count) {
        if plan.is_hard(plan.units[k]) {
            visit(plan.units[k], plan, 1);
        }
    }
}

/// The same without manifolds whose impulses are found; the multiply-adds that this saved.
pub fn sweep_restless(plan: &mut Plan, passes: u32) -> u64 {
    let mut saved = 0;
    for k in 0..plan.units.len() {
        match plan.units[k] {
            Unit::Manifold(index) if plan.calm.get(index as usize) == Some(&true) => {
                saved += plan.manifold_work(index, u64::from(passes));
            }
            unit => visit(unit, plan, passes),
        }
    }
    saved
}

/// Solves a unit for the velocities as they are.
#[inline]
pub fn visit(unit: Unit, plan: &mut Plan, passes: u32) {
    let (rows, blocks, bodies) = (&mut plan.rows, &plan.blocks, &mut plan.bodies);
    match unit {
        Unit::Row(row) => match rows[row as usize].coupling {
            Coupling::Limit(block) => solve_limit(row as usize, block, plan),
            _ => solve_row_of(row as usize, rows, blocks, bodies),
        },
        Unit::Manifold(index) => plan.manifold_blocks[index as usize].solve(passes, rows, blocks, bodies),
        Unit::Tree(index) => plan.forest.trees[index as usize].solve(rows, blocks, bodies),
    }
}

/// Solves a row, with its partners, for the velocities as they are.
#[inline]
pub fn solve_row_of(unit: usize, rows: &mut [Row], blocks: &[Block], bodies: &mut [SolverBody]) {
    match rows[unit].coupling {
        Coupling::None | Coupling::Limit(_) => solve_row(&mut rows[unit], bodies),
        Coupling::Interval(bound) => {
            let reach = reach(&bound, rows);
            let row = &mut rows[unit];
            (row.lower, row.upper) = (-reach, reach);
            solve_row(row, bodies);
        }
        Coupling::Disk(bound) => solve_disk(unit, reach(&bound, rows), rows, bodies),
        Coupling::Block(index) => blocks[index as usize].solve(rows, bodies),
        Coupling::Partner => {}
    }
}

/// μ Σ λ_n with the impulses as they are now.
#[inline]
pub fn reach(bound: &Bound, rows: &[Row]) -> f32 {
    let first = bound.first as usize;
    let sum: f32 = rows[first..first + bound.count as usize].iter().map(|r| r.lambda).sum();
    // The sum is negative only while an equality is overdrawn: no friction then.
    bound.coefficient * sum.max(0.0)
}

/// Part of J M⁻¹Jᵀ below which a joint leaves a limit nothing but rounding.
const LEAST_FREE: f32 = 1e-4;

/// The end of a range: an impulse as great as what its joint leaves free needs, then the joint again. A light arm with
/// a heavy load welded to its end would give a row that sees the arm alone a hundredth of the impulse that stops it.
fn solve_limit(index: usize, block: u32, plan: &mut Plan) {
    let row = &plan.rows[index];
    let w = row.velocity(&plan.bodies) + row.bias;
    if row.lambda == 0.0 && w >= 0.0 {
        return;
    }
    let of_joint = plan.blocks[block as usize];
    if row.limit_mass == 0.0 {
        let k = inner(&row.jacobian, &row.response);
        let free = if of_joint.in_tree {
            plan.forest.trees[of_joint.tree as usize].free_part(row, &plan.rows, &plan.blocks)
        } else {
            of_joint.free_part(row, &plan.rows)
        };
        plan.rows[index].limit_mass = if free > LEAST_FREE * k { 1.0 / free } else { row.effective_mass };
    }
    let row = &mut plan.rows[index];
    let lambda = (row.lambda - w * row.limit_mass).max(0.0);
    let delta_lambda = lambda - row.lambda;
    row.lambda = lambda;
    row.apply(&mut plan.bodies, delta_lambda);
    if of_joint.in_tree {
        plan.forest.trees[of_joint.tree as usize].solve(&mut plan.rows, &plan.blocks, &mut plan.bodies);
    } else {
        of_joint.solve(&mut plan.rows, &mut plan.bodies);
    }
}

#[inline]
fn solve_row(row: &mut Row, bodies: &mut [SolverBody]) {
    let w = row.velocity(bodies) + row.softness * row.lambda + row.bias;
    // Clamp the sum, not the increment: a later sweep may give impulse back.
    // Not `clamp`: it panics where a bound is NaN.
    let lambda = (row.lambda - w * row.effective_mass).max(row.lower).min(row.upper);
    let delta_lambda = lambda - row.lambda;
    row.lambda = lambda;
    row.apply(bodies, delta_lambda);
}

#[inline]
fn solve_disk(first: usize, reach: f32, rows: &mut [Row], bodies: &mut [SolverBody]) {
    let [one, two] = &mut rows[first..first + 2] else { return };
    let (w1, w2) = (one.velocity(bodies) + one.bias, two.velocity(bodies) + two.bias);
    let [i11, i12, i22] = inverse_2x2(one.effective_mass, two.effective_mass, one.cross_mass);
    // Sticking: the impulse that stops both directions at once, if the disk holds it.
    let (mut l1, mut l2) = (one.lambda - (i11 * w1 + i12 * w2), two.lambda - (i12 * w1 + i22 * w2));
    if l1 * l1 + l2 * l2 > reach * reach {
        // Sliding: a step of one length in both directions, so that at rest λ is opposite to w (Coulomb),
        // which the 2×2 step would turn where its two masses differ.
        let difference = 0.5 * (i11 - i22);
        let step = 0.5 * (i11 + i22) - (difference * difference + i12 * i12).sqrt();
        (l1, l2) = (one.lambda - step * w1, two.lambda - step * w2);
        let length = (l1 * l1 + l2 * l2).sqrt();
        if length > reach {
            (l1, l2) = (l1 * (reach / length), l2 * (reach / length));
        }
    }
    let (delta1, delta2) = (l1 - one.lambda, l2 - two.lambda);
    (one.lambda, two.lambda) = (l1, l2);
    one.apply(bodies, delta1);
    two.apply(bodies, delta2);
}

/// The inverse of the symmetric positive [1/m₁, c; c, 1/m₂] given by its inverse diagonal: 11, 12, 22. Where both rows see
/// the same motion there is none: then 1 / its greatest eigenvalue for both, the longest step that does not overshoot.
#[inline]
fn inverse_2x2(m1: f32, m2: f32, c: f32) -> [f32; 3] {
    let determinant = 1.0 - c * c * m1 * m2;
    if determinant > 1e-3 {
        let share = 1.0 / determinant;
        return [m1 * share, -(c * m1 * m2 * share), m2 * share];
    }
    let (k1, k2) = (1.0 / m1, 1.0 / m2);
    let half = 0.5 * (k1 - k2);
    let step = 1.0 / (0.5 * (k1 + k2) + (half * half + c * c).sqrt());
    [step, 0.0, step]
}
