//! Every method that knows bounds, against a QP solver and against enumeration.

use crate::oracle::{enumerate, nearest_velocities, quadratic_program};
use crate::problems::{assert_solves, box_stack, distance, random_psd, uniform};
use ishigaki::lcp::{BoxLcp, Matrix, Method, Order, Settings, Status};
use ishigaki::solver::permutation::Random;

/// What the methods promise, in w.
const EXACT: f64 = 1e-8;

fn settings_for(method: Method) -> Settings {
    // Jacobi answers to all rows at once: where they agree it overshoots.
    let relaxation = if method == Method::ProjectedJacobi { 0.2 } else { 1.0 };
    Settings { sweeps: 100_000, tolerance: 1e-11, relaxation, ..Settings::default() }
}

const PROJECTED: [Method; 6] = [
    Method::Lemke,
    Method::Dantzig,
    Method::ProjectedJacobi,
    Method::ProjectedGaussSeidel,
    Method::Nncg,
    Method::BlockProjectedGaussSeidel,
];

fn compare_with_qp(problem: &BoxLcp, methods: &[Method], what: &str) {
    compare(problem, &quadratic_program(problem), methods, what);
}

fn compare_stack(boxes: usize, methods: &[Method]) {
    let (problem, j, u) = box_stack(boxes, boxes as u64);
    compare(&problem, &nearest_velocities(&j, &u), methods, &format!("{boxes} boxes on four points each"));
}

fn compare(problem: &BoxLcp, expected: &[f64], methods: &[Method], what: &str) {
    for &method in methods {
        let solution = method.solve(problem, &settings_for(method));
        let error = distance(&solution.w, expected);
        let name = method.name();
        eprintln!("{what}: {name} {:?} after {}, w differs by {error:.1e}", solution.status, solution.sweeps);
        assert_eq!(solution.status, Status::Solved, "{what}: {name}");
        assert!(error < EXACT, "{what}: {name} differs by {error:e}");
        assert_eq!(solution.fallback, None, "{what}: {name}");
    }
}

#[test]
fn random_definite_problems_as_a_qp_solver_does() {
    for (n, seed) in [(1, 1), (5, 2), (20, 3), (60, 4)] {
        compare_with_qp(&random_psd(n, 3 * n + 2, seed), &PROJECTED, &format!("definite, n = {n}"));
    }
}

#[test]
fn random_rank_deficient_problems_as_a_qp_solver_does() {
    for (n, seed) in [(6, 11), (20, 12), (60, 13)] {
        compare_with_qp(&random_psd(n, n / 2, seed), &PROJECTED, &format!("rank n/2, n = {n}"));
    }
}

#[test]
fn two_hundred_rows_as_a_qp_solver_does() {
    let direct = [Method::Lemke, Method::Dantzig];
    compare_with_qp(&random_psd(200, 602, 21), &direct, "definite, n = 200");
    compare_with_qp(&random_psd(200, 100, 22), &direct, "rank 100, n = 200");
    compare_stack(50, &direct);
}

#[test]
fn boxes_on_four_points_by_every_method() {
    compare_stack(3, &PROJECTED);
}

#[test]
fn every_choice_of_small_symmetric_problems() {
    for seed in 0..30 {
        let n = 2 + seed as usize % 5;
        let problem = random_psd(n, if seed % 2 == 0 { 3 * n } else { n }, 100 + seed);
        let solutions = enumerate(&problem);
        assert!(!solutions.is_empty());
        for method in PROJECTED {
            let solution = method.solve(&problem, &settings_for(method));
            assert_eq!(solution.status, Status::Solved, "{} on seed {seed}", method.name());
            let nearest = solutions.iter().map(|(_, w)| distance(w, &solution.w)).fold(f64::MAX, f64::min);
            assert!(nearest < EXACT, "{} on seed {seed}: {nearest:e}", method.name());
        }
    }
}

/// A matrix as weight amplification makes it: column j sees the lower of its two bodies c times as heavy.
fn amplified(n: usize, seed: u64) -> BoxLcp {
    let mut random = Random(seed);
    let c = 1.0 + 0.5 * (1.0 + uniform(&mut random));
    let inverse: Vec<f64> = (0..=n).map(|_| 1.0 + 0.9 * uniform(&mut random)).collect();
    // Row i: body i stands on body i − 1; body 0 of a row is the ground.
    let part = |row: usize, body: usize| match (row, body) {
        (r, b) if b == r => 1.0,
        (r, b) if r > 0 && b == r - 1 => -1.0,
        _ => 0.0,
    };
    let seen = |row: usize, body: usize| if row > 0 && body == row - 1 { inverse[body] / c } else { inverse[body] };
    let a = Matrix::from_fn(n, n, |i, j| (0..n).map(|k| part(i, k) * seen(j, k) * part(j, k)).sum());
    assert!(n < 2 || a.asymmetry() > 1e-3);
    let b = (0..n).map(|_| uniform(&mut random)).collect();
    let upper = (0..n).map(|i| if i % 3 == 2 { 0.3 } else { f64::INFINITY }).collect();
    BoxLcp::new(a, b, vec![0.0; n], upper).unwrap()
}

#[test]
fn every_choice_of_small_problems_with_amplified_weights() {
    for seed in 0..12 {
        let problem = amplified(3 + seed as usize % 6, 300 + seed);
        let solutions = enumerate(&problem);
        assert!(!solutions.is_empty(), "seed {seed} has no solution");
        for method in PROJECTED {
            let solution = method.solve(&problem, &settings_for(method));
            assert_eq!(solution.status, Status::Solved, "{} on seed {seed}", method.name());
            let nearest = solutions.iter().map(|(_, w)| distance(w, &solution.w)).fold(f64::MAX, f64::min);
            assert!(nearest < EXACT, "{} on seed {seed}: {nearest:e}", method.name());
        }
    }
}

#[test]
fn orders_agree_and_seeds_repeat() {
    let problem = random_psd(20, 62, 5);
    let solve = |order, seed| {
        let settings = Settings { order, seed, tolerance: 1e-11, ..Settings::default() };
        Method::ProjectedGaussSeidel.solve(&problem, &settings)
    };
    let fixed = solve(Order::Fixed, 1);
    for order in [Order::Random, Order::Alternating] {
        let other = solve(order, 1);
        assert_eq!(other.status, Status::Solved);
        assert!(distance(&other.w, &fixed.w) < 1e-9);
        assert_ne!(other.residuals, fixed.residuals, "{order:?} visits the rows as fixed order does");
    }
    assert_eq!(solve(Order::Random, 7), solve(Order::Random, 7));
    assert_ne!(solve(Order::Random, 7).residuals, solve(Order::Random, 8).residuals);
}

#[test]
fn a_warm_start_at_the_solution_needs_no_sweep() {
    let problem = random_psd(20, 62, 6);
    let cold = Method::ProjectedGaussSeidel.solve(&problem, &Settings { tolerance: 1e-12, ..Settings::default() });
    let warm = Settings { start: Some(cold.lambda.clone()), ..Settings::default() };
    let again = Method::ProjectedGaussSeidel.solve(&problem, &warm);
    assert_eq!((again.sweeps, again.status), (0, Status::Solved));
    let near = cold.lambda.iter().map(|x| 1.001 * x).collect();
    let near = Method::ProjectedGaussSeidel.solve(&problem, &Settings { start: Some(near), ..Settings::default() });
    assert!(near.sweeps < cold.sweeps);
}

#[test]
fn the_residual_falls_and_is_the_one_of_lambda() {
    let problem = box_stack(4, 4).0;
    for method in Method::ALL {
        let solution = method.solve(&problem, &settings_for(method));
        assert_eq!(solution.residuals.len(), solution.sweeps, "{}", method.name());
        assert_eq!(solution.residual, problem.residual(&solution.lambda), "{}", method.name());
        assert_eq!(solution.w, problem.w(&solution.lambda), "{}", method.name());
        if method.is_projected() {
            assert_solves(&problem, &solution, 1e-9, method.name());
            let first = solution.residuals[0];
            assert!(solution.residual < 1e-6 * first.max(1e-3), "{}", method.name());
        }
    }
}
