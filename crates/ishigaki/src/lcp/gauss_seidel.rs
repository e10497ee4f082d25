//! Gauss–Seidel: row after row, each with the newest values of the others. TALK C5, C6.
//!
//! λ_i ← −(b_i + Σ_{j≠i} a_ij λ_j)/a_ii. Half the sweeps of Jacobi (ρ_GS = ρ_J² for chains), and it converges for every
//! symmetric positive definite A. Where A is only semidefinite (four points under a box) it stays near its start: from 0 it
//! tends to the solution that spreads the load. Bounds are not looked at: contacts would pull. Reads sweeps, tolerance,
//! relaxation, order, seed, start.

use crate::lcp::box_lcp::BoxLcp;
use crate::lcp::settings::{Settings, Solution, arrange, iterate};
use crate::solver::permutation::Random;

/// Gauss–Seidel for the linear system A λ + b = 0: only the residual knows bounds and friction.
///
/// ```
/// use ishigaki::lcp::{BoxLcp, Matrix, Settings, gauss_seidel, jacobi};
/// let a = Matrix::from_fn(8, 8, |i, j| match i.abs_diff(j) { 0 => 2.0, 1 => -1.0, _ => 0.0 });
/// let free = |sign: f64| vec![sign * f64::INFINITY; 8];
/// let chain = BoxLcp::new(a, vec![1.0; 8], free(-1.0), free(1.0))?;
/// let settings = Settings::default();
/// let (gs, j) = (gauss_seidel(&chain, &settings).sweeps, jacobi(&chain, &settings).sweeps);
/// assert!((1.9..2.1).contains(&(j as f64 / gs as f64)), "{j} / {gs}");
/// # Ok::<(), ishigaki::Error>(())
/// ```
// ANCHOR: gauss_seidel
pub fn gauss_seidel(problem: &BoxLcp, settings: &Settings) -> Solution {
    let mut rows: Vec<usize> = (0..problem.len()).collect();
    let mut random = Random(settings.seed);
    iterate(problem, settings, |k, lambda| {
        arrange(settings.order, k, &mut random, &mut rows);
        for &i in &rows {
            let diagonal = problem.a[(i, i)];
            if diagonal != 0.0 {
                lambda[i] -= settings.relaxation * problem.w_of(i, lambda) / diagonal;
            }
        }
    })
}
// ANCHOR_END: gauss_seidel
