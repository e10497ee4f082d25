//! Jacobi: every row for itself, all with the values of the last sweep. TALK C5.
//!
//! λ_i ← −(b_i + Σ_{j≠i} a_ij λ_j)/a_ii with the λ_j of the sweep before; the projected variant clips each result to its
//! bounds. Rows do not wait for each other, but forces travel one row a sweep, and where a row sees many others (a pyramid)
//! all of them answer at once and the numbers run away unless `relaxation` is small. A row with a_ii = 0 cannot move w_i:
//! it goes to the bound that w_i points to (projected) or stays. Reads sweeps, tolerance, relaxation, start.

use crate::lcp::box_lcp::{BoxLcp, clip, clip_to_disk};
use crate::lcp::projected_gauss_seidel::bound_by_sign;
use crate::lcp::settings::{Settings, Solution, iterate};

/// Jacobi for the linear system A λ + b = 0: bounds and friction are not looked at, only the residual knows them.
///
/// ```
/// use ishigaki::lcp::{BoxLcp, Matrix, Settings, Status, jacobi};
/// let a = Matrix::from_fn(2, 2, |i, j| if i == j { 2.0 } else { 1.0 });
/// let free = |sign: f64| vec![sign * f64::INFINITY; 2];
/// let problem = BoxLcp::new(a, vec![-3.0, -3.0], free(-1.0), free(1.0))?;
/// let solution = jacobi(&problem, &Settings::default());
/// assert_eq!(solution.status, Status::Solved);
/// assert!((solution.lambda[0] - 1.0).abs() < 1e-8);
/// # Ok::<(), ishigaki::Error>(())
/// ```
// ANCHOR: jacobi
pub fn jacobi(problem: &BoxLcp, settings: &Settings) -> Solution {
    iterate(problem, settings, |_, lambda| {
        let w = problem.w(lambda);
        for (i, lambda) in lambda.iter_mut().enumerate() {
            let diagonal = problem.a[(i, i)];
            if diagonal != 0.0 {
                *lambda -= settings.relaxation * w[i] / diagonal;
            }
        }
    })
}
// ANCHOR_END: jacobi

/// Jacobi with every λ clipped to its bounds. Friction bounds follow the normals of the same sweep.
pub fn projected_jacobi(problem: &BoxLcp, settings: &Settings) -> Solution {
    iterate(problem, settings, |_, lambda| {
        let w = problem.w(lambda);
        let before = lambda.clone();
        let step = |i: usize| {
            let diagonal = problem.a[(i, i)];
            if diagonal > 0.0 { before[i] - settings.relaxation * w[i] / diagonal } else { before[i] }
        };
        for i in (0..problem.len()).filter(|&i| problem.friction[i].is_none()) {
            let (lower, upper) = (problem.lower[i], problem.upper[i]);
            lambda[i] = if problem.a[(i, i)] > 0.0 {
                clip(step(i), lower, upper)
            } else {
                bound_by_sign(before[i], w[i], lower, upper)
            };
        }
        for i in 0..problem.len() {
            let Some(friction) = &problem.friction[i] else { continue };
            let reach = problem.reach(friction, lambda);
            match friction.partner {
                Some(j) if j > i => [lambda[i], lambda[j]] = clip_to_disk([step(i), step(j)], reach),
                Some(_) => {}
                None => lambda[i] = clip(step(i), -reach, reach),
            }
        }
    })
}
