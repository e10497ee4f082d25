//! Manifold blocks: the points of a manifold solved together. Beyond the talk.
//!
//! A face rests on four points whose normals see each other strongly: three of its six motions. Visited row by row,
//! a sweep passes a load on quickly but tilts crawl, and a stack leans long before its impulses are found. Visited
//! as one unit, normals first and several times (Gauss–Seidel inside), then friction with the bounds they give,
//! the face is nearly solved at each visit: a tower of 40 at ten sweeps a step stands where it fell in a second.
//! Equation and fixed point are those of the rows; only the order of visiting differs. With K = J M⁻¹Jᵀ of the four
//! normals at hand a pass costs 16 multiply-adds, not 84: the bodies are read once and pushed once. Option: `solver.manifold_block`; shown by `tests/techniques.rs`.

use crate::options;
use crate::solver::block::Block;
use crate::solver::plan::ManifoldRows;
use crate::solver::reference::solve_row_of;
use crate::solver::table::{Row, SolverBody, inner};

/// Most points of a manifold.
const MOST: usize = 4;

/// A manifold whose rows are visited as one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ManifoldBlock {
    /// Its first row.
    pub first: u32,
    /// Its first normal row.
    pub first_normal: u32,
    /// One past its last row.
    pub end: u32,
    /// J M⁻¹Jᵀ of its normals: what a change of one does to the others, without a look at the bodies.
    coupling: [[f32; MOST]; MOST],
}

impl ManifoldBlock {
    /// All rows of a manifold; masses come in with [`ManifoldBlock::refresh`].
    pub fn new(m: &ManifoldRows) -> Self {
        Self {
            first: m.first,
            first_normal: m.first + m.layout.first_normal(),
            end: m.first + m.layout.total(),
            coupling: [[0.0; MOST]; MOST],
        }
    }

    /// J M⁻¹Jᵀ for the responses as they are.
    pub fn refresh(&mut self, rows: &[Row]) {
        let normals = &rows[self.first_normal as usize..self.end as usize];
        for (line, row) in self.coupling.iter_mut().zip(normals) {
            for (value, other) in line.iter_mut().zip(normals) {
                *value = inner(&row.jacobian, &other.response);
            }
        }
    }

    /// The normals `passes` times, then friction with the bounds they give.
    #[inline]
    pub fn solve(&self, passes: u32, rows: &mut [Row], blocks: &[Block], bodies: &mut [SolverBody]) {
        self.solve_normals(passes, rows, bodies);
        for friction in self.first..self.first_normal {
            solve_row_of(friction as usize, rows, blocks, bodies);
        }
    }

    /// Gauss–Seidel on the normals alone: reads the bodies once and pushes them once.
    fn solve_normals(&self, passes: u32, rows: &mut [Row], bodies: &mut [SolverBody]) {
        let normals = &mut rows[self.first_normal as usize..self.end as usize];
        let mut w = [0.0_f32; MOST];
        let mut lambda = [0.0_f32; MOST];
        for ((w, lambda), row) in w.iter_mut().zip(&mut lambda).zip(normals.iter()) {
            (*w, *lambda) = (row.velocity(bodies) + row.bias, row.lambda);
        }
        for _ in 0..passes {
            for (i, row) in normals.iter().enumerate() {
                let next = (lambda[i] - w[i] * row.effective_mass).max(0.0);
                let change = next - lambda[i];
                lambda[i] = next;
                for (w, coupling) in w.iter_mut().zip(&self.coupling) {
                    *w += coupling[i] * change;
                }
            }
        }
        for (row, lambda) in normals.iter_mut().zip(lambda) {
            let delta_lambda = lambda - row.lambda;
            row.lambda = lambda;
            row.apply(bodies, delta_lambda);
        }
    }
}

/// Passes over the normals of a manifold in each visit; `None` when its rows are visited one by one.
pub fn passes(options: &options::ManifoldBlock) -> Option<u32> {
    options.enabled.then_some(options.passes)
}
