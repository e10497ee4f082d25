//! Manifold blocks: the points of a manifold solved together. Beyond the talk.
//!
//! A face rests on four points whose normals see each other strongly: three of its six motions. Visited row by row,
//! a sweep passes a load on quickly but tilts crawl, and a stack leans long before its impulses are found. Visited
//! as one unit, normals first and several times (Gauss–Seidel inside), then friction with the bounds they give,
//! the face is nearly solved at each visit: a tower of 40 at ten sweeps a step stands where it fell in a second.
//! Equation and fixed point are those of the rows; only the order of visiting differs. Cost: `passes` visits of each
//! normal for one. Option: `solver.manifold_block`; shown by `tests/techniques.rs`.

use crate::options::ManifoldBlock;
use crate::solver::block::Block;
use crate::solver::plan::ManifoldRows;
use crate::solver::reference::solve_unit;
use crate::solver::table::{Row, SolverBody};

/// Rows that a sweep visits as one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unit {
    /// Its first row.
    pub first: u32,
    /// The first normal row of a manifold; the same as `first` for single rows.
    pub first_normal: u32,
    /// One past its last row.
    pub end: u32,
}

impl Unit {
    /// A row with its partners.
    pub fn row(index: u32) -> Self {
        Self { first: index, first_normal: index, end: index }
    }

    /// All rows of a manifold.
    pub fn manifold(m: &ManifoldRows) -> Self {
        Self { first: m.first, first_normal: m.first + m.layout.first_normal(), end: m.first + m.layout.total() }
    }
}

/// Passes over the normals of a manifold in each visit; `None` when its rows are visited one by one.
pub fn passes(options: &ManifoldBlock) -> Option<u32> {
    options.enabled.then_some(options.passes)
}

/// Visits a unit: a row, or the normals of a manifold `passes` times and then its friction.
#[inline]
pub fn solve(unit: Unit, passes: u32, rows: &mut [Row], blocks: &[Block], bodies: &mut [SolverBody]) {
    if unit.first == unit.end {
        solve_unit(unit.first as usize, rows, blocks, bodies);
        return;
    }
    for _ in 0..passes {
        for normal in unit.first_normal..unit.end {
            solve_unit(normal as usize, rows, blocks, bodies);
        }
    }
    for friction in unit.first..unit.first_normal {
        solve_unit(friction as usize, rows, blocks, bodies);
    }
}
