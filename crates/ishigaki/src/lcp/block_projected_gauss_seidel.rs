//! Block projected Gauss–Seidel: the rows of a manifold, or of a joint, together. Beyond the talk.
//!
//! A face rests on four points whose normals see each other strongly. In each visit of a group: rows without bounds are
//! solved exactly (a joint), bounded rows `passes` times by PGS (the normals), then the rows of friction with the bounds
//! that these leave, as the engine does with `solver.manifold_block`. The fixed point is that of PGS. Without it, tilts of
//! a stack crawl: each sweep lets one corner answer to another only once. Groups are those of the problem; where it has
//! none, a normal with the friction that it bounds is one. Reads sweeps, tolerance, relaxation, order (of the groups),
//! seed, start, passes. Tests: `tests/lcp`.

use crate::lcp::box_lcp::BoxLcp;
use crate::lcp::matrix::Matrix;
use crate::lcp::projected_gauss_seidel::{visit, visits};
use crate::lcp::settings::{Settings, Solution, arrange, iterate};
use crate::solver::permutation::Random;

/// Block projected Gauss–Seidel.
///
/// ```
/// use ishigaki::lcp::{BoxLcp, Matrix, Settings, block_projected_gauss_seidel};
/// // Two equations that say nearly the same: one visit for a block.
/// let a = Matrix::from_fn(2, 2, |i, j| if i == j { 1.0 } else { 0.999 });
/// let free = |sign: f64| vec![sign * f64::INFINITY; 2];
/// let problem = BoxLcp::new(a, vec![1.0, -1.0], free(-1.0), free(1.0))?.with_groups(vec![0, 0])?;
/// assert_eq!(block_projected_gauss_seidel(&problem, &Settings::default()).sweeps, 1);
/// # Ok::<(), ishigaki::Error>(())
/// ```
pub fn block_projected_gauss_seidel(problem: &BoxLcp, settings: &Settings) -> Solution {
    let mut blocks = blocks(problem);
    let mut random = Random(settings.seed);
    iterate(problem, settings, |k, lambda| {
        arrange(settings.order, k, &mut random, &mut blocks);
        for block in &blocks {
            block.visit(problem, settings, lambda);
        }
    })
}

/// The rows of a group by what is done with them.
struct Block {
    /// Without bounds and independent of each other: solved together.
    free: Vec<usize>,
    /// A of these rows.
    matrix: Matrix,
    bounded: Vec<usize>,
    friction: Vec<usize>,
}

impl Block {
    fn visit(&self, problem: &BoxLcp, settings: &Settings, lambda: &mut [f64]) {
        let w: Vec<f64> = self.free.iter().map(|&i| -problem.w_of(i, lambda)).collect();
        for (&i, step) in self.free.iter().zip(self.matrix.solve(&w).unwrap_or_default()) {
            lambda[i] += settings.relaxation * step;
        }
        for _ in 0..settings.passes.max(1) {
            self.bounded.iter().for_each(|&i| visit(problem, i, settings.relaxation, lambda));
        }
        self.friction.iter().for_each(|&i| visit(problem, i, settings.relaxation, lambda));
    }
}

fn blocks(problem: &BoxLcp) -> Vec<Block> {
    let group = if problem.groups.is_empty() { groups_of_friction(problem) } else { problem.groups.clone() };
    let mut rows = visits(problem);
    // Stable: within a group the order of the problem.
    rows.sort_by_key(|&i| group[i]);
    rows.chunk_by(|&i, &j| group[i] == group[j]).map(|rows| block(problem, rows)).collect()
}

fn block(problem: &BoxLcp, rows: &[usize]) -> Block {
    let (mut free, mut bounded, mut friction) = (Vec::new(), Vec::new(), Vec::new());
    for &i in rows {
        let is_free = problem.lower[i] == f64::NEG_INFINITY && problem.upper[i] == f64::INFINITY;
        if problem.friction[i].is_some() {
            friction.push(i);
        } else if is_free && is_independent(problem, &free, i) {
            free.push(i);
        } else {
            bounded.push(i);
        }
    }
    Block { matrix: problem.a.part(&free, &free), free, bounded, friction }
}

/// Whether row i says something that `rows` do not: the Schur complement of its diagonal is no rounding.
fn is_independent(problem: &BoxLcp, rows: &[usize], i: usize) -> bool {
    let a = &problem.a;
    let column: Vec<f64> = rows.iter().map(|&j| a[(j, i)]).collect();
    let Some(x) = a.part(rows, rows).solve(&column) else { return false };
    let covered: f64 = rows.iter().zip(x).map(|(&j, x)| a[(i, j)] * x).sum();
    a[(i, i)] - covered > 1e-9 * a[(i, i)].abs()
}

/// A normal and the rows it bounds belong together; rows of several normals join those.
fn groups_of_friction(problem: &BoxLcp) -> Vec<usize> {
    let mut group: Vec<usize> = (0..problem.len()).collect();
    for (i, friction) in problem.friction.iter().enumerate() {
        let Some(f) = friction else { continue };
        let least = f.normals.iter().chain([&i]).map(|&n| group[n]).min().unwrap_or(i);
        let joined: Vec<usize> = f.normals.iter().chain([&i]).map(|&n| group[n]).collect();
        for g in &mut group {
            if joined.contains(g) {
                *g = least;
            }
        }
    }
    group
}
