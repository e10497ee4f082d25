//! Independent solutions: enumeration of all 3ⁿ choices, and a QP solver.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use ishigaki::lcp::{BoxLcp, Matrix};

/// Gauss–Jordan with complete row search; `None` where the system is singular.
pub fn solve(mut a: Vec<Vec<f64>>, mut y: Vec<f64>) -> Option<Vec<f64>> {
    let n = y.len();
    for k in 0..n {
        let p = (k..n).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs()))?;
        if a[p][k].abs() < 1e-11 {
            return None;
        }
        a.swap(k, p);
        y.swap(k, p);
        let pivot = a[k].clone();
        let value = y[k];
        for i in (0..n).filter(|&i| i != k) {
            let f = a[i][k] / pivot[k];
            (0..n).for_each(|j| a[i][j] -= f * pivot[j]);
            y[i] -= f * value;
        }
    }
    Some((0..n).map(|k| y[k] / a[k][k]).collect())
}

/// Every solution (λ, w) with each row at its lower bound, inside with w = 0, or at its upper bound.
pub fn enumerate(problem: &BoxLcp) -> Vec<(Vec<f64>, Vec<f64>)> {
    let n = problem.len();
    let (lower, upper) = (problem.lower(), problem.upper());
    let mut found = Vec::new();
    for code in 0..3_usize.pow(n as u32) {
        let choice: Vec<usize> = (0..n).map(|i| code / 3_usize.pow(i as u32) % 3).collect();
        let mut lambda: Vec<f64> = (0..n).map(|i| [lower[i], 0.0, upper[i]][choice[i]]).collect();
        if lambda.iter().any(|x| x.is_infinite()) {
            continue;
        }
        let inside: Vec<usize> = (0..n).filter(|&i| choice[i] == 1).collect();
        let w = problem.w(&lambda);
        let part = inside.iter().map(|&i| inside.iter().map(|&j| problem.a()[(i, j)]).collect()).collect();
        let Some(values) = solve(part, inside.iter().map(|&i| -w[i]).collect()) else { continue };
        inside.iter().zip(values).for_each(|(&i, value)| lambda[i] = value);
        let w = problem.w(&lambda);
        let holds = |i: usize| match choice[i] {
            0 => w[i] >= -1e-9,
            1 => (lower[i] - 1e-9..=upper[i] + 1e-9).contains(&lambda[i]),
            _ => w[i] <= 1e-9,
        };
        if (0..n).all(holds) {
            found.push((lambda, w));
        }
    }
    found
}

/// w of min ½ λᵀAλ + bᵀλ over the box, for symmetric positive semidefinite A.
pub fn quadratic_program(problem: &BoxLcp) -> Vec<f64> {
    let n = problem.len();
    // λ ≤ upper and −λ ≤ −lower.
    let mut bounds: Vec<(usize, f64, f64)> = Vec::new();
    for i in 0..n {
        if problem.upper()[i].is_finite() {
            bounds.push((i, 1.0, problem.upper()[i]));
        }
        if problem.lower()[i].is_finite() {
            bounds.push((i, -1.0, -problem.lower()[i]));
        }
    }
    let p = sparse(n, n, |i, j| if i <= j { problem.a()[(i, j)] } else { 0.0 });
    let g = sparse(bounds.len(), n, |row, j| if bounds[row].0 == j { bounds[row].1 } else { 0.0 });
    let right: Vec<f64> = bounds.iter().map(|b| b.2).collect();
    problem.w(&minimize(&p, problem.b(), &g, &right))
}

/// w = J u of the velocities nearest to u₀ with J u ≥ 0 (Gauss's principle, masses 1): strictly convex, no λ in it.
pub fn nearest_velocities(j: &Matrix, u0: &[f64]) -> Vec<f64> {
    let p = sparse(u0.len(), u0.len(), |i, k| f64::from(i == k));
    let g = sparse(j.rows(), u0.len(), |i, k| -j[(i, k)]);
    let q: Vec<f64> = u0.iter().map(|u| -u).collect();
    j.times(&minimize(&p, &q, &g, &vec![0.0; j.rows()]))
}

fn sparse(rows: usize, columns: usize, entry: impl Fn(usize, usize) -> f64) -> CscMatrix {
    let (mut starts, mut indices, mut values) = (vec![0], Vec::new(), Vec::new());
    for j in 0..columns {
        for i in (0..rows).filter(|&i| entry(i, j) != 0.0) {
            indices.push(i);
            values.push(entry(i, j));
        }
        starts.push(indices.len());
    }
    CscMatrix::new(rows, columns, starts, indices, values)
}

/// min ½ xᵀPx + qᵀx with G x ≤ right.
fn minimize(p: &CscMatrix, q: &[f64], g: &CscMatrix, right: &[f64]) -> Vec<f64> {
    let settings = DefaultSettings {
        verbose: false,
        tol_gap_abs: 1e-14,
        tol_gap_rel: 1e-14,
        tol_feas: 1e-13,
        ..DefaultSettings::default()
    };
    let cones = [SupportedConeT::NonnegativeConeT(right.len())];
    let mut solver = DefaultSolver::new(p, q, g, right, &cones, settings).expect("a QP");
    solver.solve();
    let (status, gap) = (solver.solution.status, solver.info.gap_abs);
    // It stops where rounding does not let it go on: near enough is near enough.
    assert!(status == SolverStatus::Solved || gap < 1e-11, "the oracle failed: {status:?}, gap {gap:e}");
    solver.solution.x
}
