//! Problems with a name, and ways to have no solution.

use crate::oracle::enumerate;
use crate::problems::{INFINITE, assert_solves, contacts, distance, unbounded};
use ishigaki::lcp::{BoxLcp, Matrix, Method, Settings, Solution, Status, gauss_seidel, jacobi, lemke, nncg};
use ishigaki::lcp::{dantzig, projected_gauss_seidel};

/// Murty 1978: y = M z + q with M lower triangular, 1 on and 2 below the diagonal, q_i = −Σ_{k > n−i} 2ᵏ.
fn murty(n: usize) -> BoxLcp {
    let entry = |i: usize, j: usize| if i == j { 1.0 } else { f64::from(j < i) * 2.0 };
    let q = |i: usize| -(n + 1 - i..=n).map(|k| (1_u64 << k) as f64).sum::<f64>();
    let b = (1..=n).map(q).collect();
    BoxLcp::new(Matrix::from_fn(n, n, entry), b, vec![0.0; n], vec![INFINITE; n]).unwrap()
}

#[test]
fn murtys_example_is_solved_and_costs_two_to_the_n() {
    let mut pivots = Vec::new();
    for n in 2..=8 {
        let problem = murty(n);
        let [(_, expected)] = &enumerate(&problem)[..] else { panic!("a P-matrix has one solution") };
        for solution in [lemke(&problem, &Settings::default()), dantzig(&problem, &Settings::default())] {
            assert_eq!(solution.status, Status::Solved);
            assert!(distance(&solution.w, expected) < 1e-8);
        }
        pivots.push(lemke(&problem, &Settings::default()).sweeps);
    }
    assert_eq!(pivots, [4, 8, 16, 32, 64, 128, 256]);
    // With too few pivots it says so.
    let settings = Settings { sweeps: 20, ..Settings::default() };
    assert_eq!(lemke(&murty(8), &settings).status, Status::Limit);
}

#[test]
fn what_cannot_be_solved_is_infeasible() {
    // w = −1 whatever λ; a contact and an equation that contradict; two equal equations with different right sides.
    let hopeless = contacts(&[&[0.0]], &[-1.0]);
    let a = || Matrix::from_fn(2, 2, |_, _| 1.0);
    let contradiction = unbounded(a(), vec![1.0, 2.0]);
    let squeezed = BoxLcp::new(a(), vec![1.0, -1.0], vec![-INFINITE, 0.0], vec![INFINITE; 2]).unwrap();
    // Opposite contacts that both want to open wider than the other lets them: A is singular, b out of its range.
    let pinched = contacts(&[&[1.0, -1.0], &[-1.0, 1.0]], &[-1.0, -1.0]);
    for (name, problem) in
        [("hopeless", hopeless), ("contradiction", contradiction), ("squeezed", squeezed), ("pinched", pinched)]
    {
        for method in [Method::Lemke, Method::Dantzig] {
            let solution = method.solve(&problem, &Settings::default());
            assert_eq!(solution.status, Status::Infeasible, "{name}: {}", method.name());
            assert!(solution.lambda.iter().all(|x| x.is_finite()));
        }
        let settings = Settings::sweeps(1000);
        assert_eq!(projected_gauss_seidel(&problem, &settings).status, Status::Limit, "{name}");
    }
}

#[test]
fn zero_diagonals_are_no_division() {
    // A linear program and its dual: min 2x + 3y with x + y ≥ 4, x + 2y ≥ 5. Skew, so that all diagonals are 0.
    let program = contacts(
        &[&[0.0, 0.0, -1.0, -1.0], &[0.0, 0.0, -1.0, -2.0], &[1.0, 1.0, 0.0, 0.0], &[1.0, 2.0, 0.0, 0.0]],
        &[2.0, 3.0, -4.0, -5.0],
    );
    for method in [Method::Lemke, Method::Dantzig] {
        let solution = method.solve(&program, &Settings::default());
        assert_eq!(solution.status, Status::Solved, "{}", method.name());
        assert!(distance(&solution.lambda, &[3.0, 1.0, 1.0, 1.0]) < 1e-12, "{:?}", solution.lambda);
    }
    // A motor that nothing moves goes to its bound.
    let motor = BoxLcp::new(Matrix::zeros(2, 2), vec![1.0, -1.0], vec![-2.0; 2], vec![3.0; 2]).unwrap();
    for method in [Method::Lemke, Method::Dantzig, Method::ProjectedGaussSeidel, Method::ProjectedJacobi, Method::Nncg]
    {
        let solution = method.solve(&motor, &Settings::default());
        assert_eq!(solution.status, Status::Solved, "{}", method.name());
        assert_eq!(solution.lambda, [-2.0, 3.0], "{}", method.name());
    }
}

#[test]
fn ties_do_not_make_it_cycle() {
    // Kostreva 1979: Lemke's method with a ratio test by index walks in a circle here.
    let kostreva = contacts(&[&[1.0, 2.0, 0.0], &[0.0, 1.0, 2.0], &[2.0, 0.0, 1.0]], &[-1.0, -1.0, -1.0]);
    // All ratios tie from the first pivot on: rank 1.
    let rows = vec![vec![1.0; 6]; 6];
    let ones = contacts(&rows.iter().map(Vec::as_slice).collect::<Vec<_>>(), &[-1.0; 6]);
    // b = 0 on a vertex where everything touches.
    let touching = contacts(&[&[1.0, -1.0, 0.0], &[-1.0, 2.0, -1.0], &[0.0, -1.0, 1.0]], &[0.0, 0.0, 0.0]);
    for (name, problem) in [("kostreva", kostreva), ("ones", ones), ("touching", touching)] {
        for method in [Method::Lemke, Method::Dantzig] {
            let solution = method.solve(&problem, &Settings::default());
            assert_eq!(solution.status, Status::Solved, "{name}: {}", method.name());
            assert!(solution.sweeps < 30, "{name}: {} pivots", solution.sweeps);
            assert_solves(&problem, &solution, 1e-10, name);
        }
    }
}

#[test]
fn bounds_that_leave_no_choice_are_kept() {
    let a = Matrix::from_fn(3, 3, |i, j| if i == j { 2.0 } else { 1.0 });
    let problem = BoxLcp::new(a, vec![-4.0; 3], vec![1.0, 0.0, -INFINITE], vec![1.0, 0.5, 0.25]).unwrap();
    let [(expected, _)] = &enumerate(&problem)[..] else { panic!("one solution") };
    for method in Method::ALL.into_iter().filter(|m| m.is_projected()) {
        let solution = method.solve(&problem, &Settings::default());
        assert!(distance(&solution.lambda, expected) < 1e-9, "{}: {:?}", method.name(), solution.lambda);
    }
}

/// n equal masses in a row, each held to the next: the talk's chain.
fn chain(n: usize) -> BoxLcp {
    let entry = |i: usize, j: usize| match i.abs_diff(j) {
        0 if i == 0 => 1.0,
        0 => 2.0,
        1 => -1.0,
        _ => 0.0,
    };
    let b = (0..n).map(|i| if i == 0 { -1.0 } else { 0.0 }).collect();
    unbounded(Matrix::from_fn(n, n, entry), b)
}

/// Sweeps until λ is within 1 % of the solution.
fn sweeps_to_one_percent(problem: &BoxLcp, method: impl Fn(&BoxLcp, &Settings) -> Solution) -> usize {
    let exact = lemke(problem, &Settings::default()).lambda;
    let greatest = exact.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let error =
        |sweeps| distance(&method(problem, &Settings { tolerance: 0.0, ..Settings::sweeps(sweeps) }).lambda, &exact);
    let (mut low, mut high) = (0, 4096);
    while high - low > 1 {
        let middle = (low + high) / 2;
        if error(middle) > 0.01 * greatest { low = middle } else { high = middle }
    }
    high
}

#[test]
fn gauss_seidel_needs_half_the_sweeps_of_jacobi() {
    for (n, least, most) in [(10, 1.9, 2.2), (20, 1.9, 2.1)] {
        let (j, gs) = (sweeps_to_one_percent(&chain(n), jacobi), sweeps_to_one_percent(&chain(n), gauss_seidel));
        eprintln!("chain of {n}: Jacobi {j}, Gauss–Seidel {gs}");
        assert!((least..most).contains(&(j as f64 / gs as f64)), "{j} / {gs}");
        assert!(5 * sweeps_to_one_percent(&chain(n), nncg) < gs);
    }
}

#[test]
fn jacobi_that_runs_away_stops_at_numbers() {
    // Five rows that see each other as themselves: ρ = 4.
    let problem = unbounded(Matrix::from_fn(5, 5, |i, j| if i == j { 1.01 } else { 1.0 }), vec![-1.0; 5]);
    let solution = jacobi(&problem, &Settings::default());
    assert_eq!(solution.status, Status::Limit);
    assert!(solution.sweeps < 1000 && solution.lambda.iter().all(|x| x.is_finite()));
    let slow = Settings { relaxation: 0.2, ..Settings::default() };
    assert_eq!(jacobi(&problem, &slow).status, Status::Solved);
}

/// Two bodies, one row each way: what is left after k sweeps of PGS is v/2ᵏ. TALK C7.
#[test]
fn two_bodies_halve_what_is_left_in_each_sweep() {
    let problem = contacts(&[&[1.0, -1.0], &[-1.0, 2.0]], &[-1.0, 0.0]);
    for k in 1..=20 {
        let solution = projected_gauss_seidel(&problem, &Settings { tolerance: 0.0, ..Settings::sweeps(k) });
        assert!((2.0 - solution.lambda[0] - 2.0 * 0.5_f64.powi(k as i32)).abs() < 1e-12, "{:?}", solution.lambda);
    }
}

#[test]
fn four_points_share_their_load_where_gauss_seidel_starts_from_nothing() {
    let corner = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let a = Matrix::from_fn(4, 4, |i, j| 1.0 + 1.5 * (corner[i].0 * corner[j].0 + corner[i].1 * corner[j].1));
    let problem = BoxLcp::new(a, vec![-1.0; 4], vec![0.0; 4], vec![INFINITE; 4]).unwrap();
    let solution = projected_gauss_seidel(&problem, &Settings::default());
    assert!(solution.lambda.iter().all(|x| (x - 0.25).abs() < 0.07), "{:?}", solution.lambda);
    // Lemke ends on a vertex: three points at most.
    let vertex = lemke(&problem, &Settings::default());
    assert!(vertex.lambda.iter().filter(|&&x| x > 1e-9).count() <= 3, "{:?}", vertex.lambda);
}

#[test]
fn problems_that_make_no_sense_are_refused_with_their_place() {
    let a = || Matrix::from_fn(2, 2, |i, j| f64::from(i == j));
    let nan = Matrix::from_fn(2, 2, |i, j| if (i, j) == (1, 0) { f64::NAN } else { 1.0 });
    let new = |a: Matrix, b: [f64; 2], lower: [f64; 2], upper: &[f64]| {
        BoxLcp::new(a, b.to_vec(), lower.to_vec(), upper.to_vec()).unwrap_err().to_string()
    };
    let up = [INFINITE; 2];
    for (error, words) in [
        (new(nan, [0.0; 2], [0.0; 2], &up), "a[1][0]: must be finite"),
        (new(Matrix::zeros(2, 3), [0.0; 2], [0.0; 2], &up), "a: must be 2 × 2, is 2 × 3"),
        (new(a(), [0.0, INFINITE], [0.0; 2], &up), "b[1]: must be finite"),
        (new(a(), [0.0; 2], [0.0, 2.0], &[INFINITE, 1.0]), "lower[1]: is 2, above upper[1], which is 1"),
        (new(a(), [0.0; 2], [0.0, INFINITE], &up), "lower[1]: must be a number or −∞"),
        (new(a(), [0.0; 2], [0.0; 2], &[1.0, f64::NAN]), "upper[1]: must be a number or ∞"),
        (new(a(), [0.0; 2], [0.0; 2], &[1.0]), "upper: must have 2 entries"),
    ] {
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn no_rows_are_solved() {
    let problem = unbounded(Matrix::zeros(0, 0), Vec::new());
    for method in Method::ALL {
        assert_eq!(method.solve(&problem, &Settings::default()).status, Status::Solved, "{}", method.name());
    }
}
