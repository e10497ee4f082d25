//! Projected Gauss–Seidel (PGS). TALK C7.
//!
//! Gauss–Seidel, and every λ is clipped to its bounds as soon as it is computed: that is all. Bounds of friction are read
//! anew at each visit. The two rows of a disk are visited as one: the 2×2 system first (sticking); if that leaves the disk,
//! a step of one length in both directions, clipped to the disk, whose fixed point is Coulomb's: λ opposite to w.
//! Converges for symmetric positive semidefinite A without friction; slowly for stacks, each sweep passes a force on by one
//! row. Reads sweeps, tolerance, relaxation, order, seed, start.

use crate::lcp::box_lcp::{BoxLcp, clip, clip_to_disk, length};
use crate::lcp::settings::{Settings, Solution, arrange, iterate};
use crate::solver::permutation::Random;

/// Projected Gauss–Seidel.
///
/// ```
/// use ishigaki::lcp::{BoxLcp, Friction, Matrix, Settings, projected_gauss_seidel};
/// // 1 kg pressed down by 2 N·s and pushed aside by (3, 4) N·s, μ = 1/2: it slides, held back by 1 N·s.
/// let a = Matrix::from_fn(3, 3, |i, j| if i == j { 1.0 } else { 0.0 });
/// let tangent = |partner| Some(Friction { normals: vec![0], coefficient: 0.5, partner: Some(partner) });
/// let problem = BoxLcp::new(a, vec![-2.0, 3.0, 4.0], vec![0.0; 3], vec![f64::INFINITY; 3])?
///     .with_friction(vec![None, tangent(2), tangent(1)])?;
/// let solution = projected_gauss_seidel(&problem, &Settings::default());
/// for (lambda, expected) in solution.lambda.iter().zip([2.0, -0.6, -0.8]) {
///     assert!((lambda - expected).abs() < 1e-9);
/// }
/// # Ok::<(), ishigaki::Error>(())
/// ```
pub fn projected_gauss_seidel(problem: &BoxLcp, settings: &Settings) -> Solution {
    let mut visits = visits(problem);
    let mut random = Random(settings.seed);
    iterate(problem, settings, |k, lambda| {
        arrange(settings.order, k, &mut random, &mut visits);
        for &row in &visits {
            visit(problem, row, settings.relaxation, lambda);
        }
    })
}

/// Rows to visit: the second of a disk is visited with the first.
pub(crate) fn visits(problem: &BoxLcp) -> Vec<usize> {
    let is_second = |i: &usize| problem.friction[*i].as_ref().and_then(|f| f.partner).is_some_and(|p| p < *i);
    (0..problem.len()).filter(|i| !is_second(i)).collect()
}

// ANCHOR: visit
/// Solves row i, with its partner on a disk, for the others as they are.
pub(crate) fn visit(problem: &BoxLcp, i: usize, relaxation: f64, lambda: &mut [f64]) {
    if let Some(friction) = &problem.friction[i]
        && let Some(j) = friction.partner
    {
        let reach = problem.reach(friction, lambda);
        visit_disk(problem, [i, j], reach, relaxation, lambda);
        return;
    }
    let (lower, upper) = problem.bounds(i, lambda);
    let (w, diagonal) = (problem.w_of(i, lambda), problem.a[(i, i)]);
    lambda[i] = if diagonal > 0.0 {
        clip(lambda[i] - relaxation * w / diagonal, lower, upper)
    } else {
        bound_by_sign(lambda[i], w, lower, upper)
    };
}
// ANCHOR_END: visit

/// Where a_ii = 0 the row cannot move w: λ goes to the bound that w asks for, if there is one.
pub(crate) fn bound_by_sign(lambda: f64, w: f64, lower: f64, upper: f64) -> f64 {
    let wanted = if w > 0.0 {
        lower
    } else if w < 0.0 {
        upper
    } else {
        lambda
    };
    clip(if wanted.is_finite() { wanted } else { lambda }, lower, upper)
}

fn visit_disk(problem: &BoxLcp, [i, j]: [usize; 2], reach: f64, relaxation: f64, lambda: &mut [f64]) {
    let a = &problem.a;
    let (k1, k2, c1, c2) = (a[(i, i)], a[(j, j)], a[(i, j)], a[(j, i)]);
    let (w1, w2) = (problem.w_of(i, lambda), problem.w_of(j, lambda));
    let determinant = k1 * k2 - c1 * c2;
    if determinant > 1e-12 * (k1 * k2).abs() {
        let (d1, d2) = ((k2 * w1 - c1 * w2) / determinant, (k1 * w2 - c2 * w1) / determinant);
        let (l1, l2) = (lambda[i] - relaxation * d1, lambda[j] - relaxation * d2);
        if l1 * l1 + l2 * l2 <= reach * reach {
            (lambda[i], lambda[j]) = (l1, l2);
            return;
        }
    }
    // 1 / the greatest eigenvalue of the symmetric part: the longest step that does not overshoot.
    let (half, cross) = (0.5 * (k1 - k2), 0.5 * (c1 + c2));
    let greatest = 0.5 * (k1 + k2) + length(half, cross);
    if greatest > 0.0 {
        let step = relaxation / greatest;
        [lambda[i], lambda[j]] = clip_to_disk([lambda[i] - step * w1, lambda[j] - step * w2], reach);
    }
}
