//! NNCG: a nonsmooth nonlinear conjugate gradient method over projected Gauss–Seidel. Silcowitz, Niebe, Erleben 2010.
//!
//! A sweep of PGS maps λ to λ'; −(λ' − λ) is taken for the gradient ∇f of a function that is least at the solution.
//! Fletcher–Reeves: β = |∇f|²/|∇f_before|², λ ← λ' + β p, p ← β p − ∇f; where β > 1 the search starts anew with p = 0.
//! PGS passes a force on by one row a sweep; the conjugate direction remembers where the last sweeps were heading, which
//! for chains and stacks gains one or two orders of magnitude at the price of PGS. What is reported after each sweep is the
//! λ' of PGS, which keeps its bounds. Reads sweeps, tolerance, relaxation, order, seed, start. Tests: `tests/lcp`.

use crate::lcp::box_lcp::BoxLcp;
use crate::lcp::projected_gauss_seidel::{visit, visits};
use crate::lcp::settings::{Settings, Solution, arrange, iterate};
use crate::solver::permutation::Random;

/// Nonsmooth nonlinear conjugate gradients.
///
/// ```
/// use ishigaki::lcp::{BoxLcp, Matrix, Settings, nncg, projected_gauss_seidel};
/// let a = Matrix::from_fn(20, 20, |i, j| match i.abs_diff(j) { 0 => 2.0, 1 => -1.0, _ => 0.0 });
/// let stack = BoxLcp::new(a, vec![-1.0; 20], vec![0.0; 20], vec![f64::INFINITY; 20])?;
/// let settings = Settings::default();
/// assert!(5 * nncg(&stack, &settings).sweeps < projected_gauss_seidel(&stack, &settings).sweeps);
/// # Ok::<(), ishigaki::Error>(())
/// ```
// ANCHOR: nncg
pub fn nncg(problem: &BoxLcp, settings: &Settings) -> Solution {
    let mut visits = visits(problem);
    let mut random = Random(settings.seed);
    let n = problem.len();
    let mut direction = vec![0.0; n];
    let mut last_square: Option<f64> = None;
    // β p of the last sweep: where the next one starts beyond what was reported.
    let mut lead = vec![0.0; n];
    iterate(problem, settings, |k, lambda| {
        let start: Vec<f64> = lambda.iter().zip(&lead).map(|(l, d)| l + d).collect();
        lambda.copy_from_slice(&start);
        arrange(settings.order, k, &mut random, &mut visits);
        for &row in &visits {
            visit(problem, row, settings.relaxation, lambda);
        }
        let step: Vec<f64> = lambda.iter().zip(&start).map(|(new, old)| new - old).collect();
        let square: f64 = step.iter().map(|x| x * x).sum();
        let beta = last_square.map_or(0.0, |last| if last > 0.0 { square / last } else { f64::INFINITY });
        last_square = Some(square);
        if beta <= 1.0 {
            for i in 0..n {
                lead[i] = beta * direction[i];
                direction[i] = lead[i] + step[i];
            }
        } else {
            lead.fill(0.0);
            direction.fill(0.0);
        }
    })
}
// ANCHOR_END: nncg
