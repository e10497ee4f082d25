//! Shock propagation and its blend. TALK D6, D7.
//!
//! In each contact the lower body counts as infinitely heavy, and contacts are visited from the ground up:
//! forces travel upward only, and a stack is solved in one pass. The price is the weight-feeling problem: a
//! scale under n boxes reads the weight of one. Blended, λ = (1−c)λ₀ + cλ₁ with λ₀ the plain and λ₁ the shock
//! solution from the same start, it reads (1−c) + c/n of the weight, for two solves.
//! Options: `solver.shock_propagation.{enabled, blend}`; shown by `tests/techniques.rs`.

use crate::body::NO_HEIGHT;
use crate::solver::plan::{Plan, sort_units};
use crate::solver::reference::Unit;
use crate::solver::table::MassScale;
use crate::solver::weight_amplification::{Lower, lower};

// ANCHOR: scale
/// The scale of a contact between bodies of these heights.
pub fn scale(height_a: u32, height_b: u32) -> MassScale {
    match lower(height_a, height_b) {
        Some(Lower::A) => MassScale { mass_a: 0.0, inertia_a: 0.0, ..MassScale::ONE },
        Some(Lower::B) => MassScale { mass_b: 0.0, inertia_b: 0.0, ..MassScale::ONE },
        None => MassScale::ONE,
    }
}
// ANCHOR_END: scale

// ANCHOR: sort_upward
/// From the ground up: units sorted by the lower height of their two bodies, otherwise as they were.
pub fn sort_upward(plan: &mut Plan) {
    let (rows, bodies) = (&plan.rows, &plan.bodies);
    let (manifolds, trees, blocks) = (&plan.manifold_blocks, &plan.forest.trees, &plan.blocks);
    sort_units(&mut plan.units, &|unit| {
        let row = &rows[match *unit {
            Unit::Row(row) => row,
            Unit::Manifold(index) => manifolds[index as usize].first,
            Unit::Tree(index) => blocks[trees[index as usize].blocks[0] as usize].first,
        } as usize];
        let (a, b) = (bodies[row.body_a as usize].height, bodies[row.body_b as usize].height);
        // A body in the air comes last, whatever it touches.
        if a == NO_HEIGHT || b == NO_HEIGHT { NO_HEIGHT } else { a.min(b) }
    });
}
// ANCHOR_END: sort_upward
