//! Friction: box and disk, Stewart–Trinkle, and bounds that follow their normals. TALK C2.

use crate::problems::{INFINITE, assert_solves, uniform};
use ishigaki::lcp::{BoxLcp, Friction, Matrix, Method, Settings, Status, lemke, projected_gauss_seidel};
use ishigaki::solver::permutation::Random;

/// 1 kg pressed down by 1 N·s and pushed by `push` along two tangents.
fn block(push: [f64; 2], mu: f64, disk: bool) -> BoxLcp {
    let a = Matrix::from_fn(3, 3, |i, j| f64::from(i == j));
    let tangent =
        |partner: usize| Some(Friction { normals: vec![0], coefficient: mu, partner: disk.then_some(partner) });
    BoxLcp::new(a, vec![-1.0, push[0], push[1]], vec![0.0; 3], vec![INFINITE; 3])
        .unwrap()
        .with_friction(vec![None, tangent(2), tangent(1)])
        .unwrap()
}

/// A push of 1.2 μN: where it goes is what tells box and disk apart.
#[test]
fn the_box_sticks_or_bends_where_the_disk_slides_along_the_push() {
    let mu = 0.5;
    for method in
        [Method::ProjectedGaussSeidel, Method::ProjectedJacobi, Method::Nncg, Method::BlockProjectedGaussSeidel]
    {
        for degrees in [0.0_f64, 22.5, 45.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let push = [1.2 * mu * cos, 1.2 * mu * sin];
            let disk = method.solve(&block(push, mu, true), &Settings::default());
            assert_eq!(disk.status, Status::Solved);
            // What is left of the push, along it.
            assert!((disk.w[1] - 0.2 * mu * cos).abs() < 1e-8 && (disk.w[2] - 0.2 * mu * sin).abs() < 1e-8);
            let square = method.solve(&block(push, mu, false), &Settings::default());
            assert_eq!(square.status, Status::Solved);
            assert!((square.w[1] - (push[0] - mu).max(0.0)).abs() < 1e-8 && square.w[2].abs() < 1e-8);
        }
    }
}

#[test]
fn lemke_slides_on_a_polygon_that_tends_to_the_disk() {
    let mut errors = Vec::new();
    for corners in [4, 8, 16, 64] {
        let settings = Settings { corners, ..Settings::default() };
        let solution = lemke(&block([0.5, 0.17], 0.4, true), &settings);
        assert_eq!(solution.status, Status::Solved);
        let length = solution.lambda[1].hypot(solution.lambda[2]);
        let inside = (std::f64::consts::PI / corners as f64).cos();
        assert!((0.4 * inside - 1e-12..=0.4 + 1e-12).contains(&length), "{corners} corners: {length}");
        errors.push(solution.residual);
    }
    assert!(errors[3] < 0.1 * errors[0] && errors[3] < 0.02, "{errors:?}");
}

/// Contacts of random bodies with friction boxes, and a few joints.
fn random_contacts(contacts: usize, seed: u64) -> BoxLcp {
    let mut random = Random(seed);
    let n = 3 * contacts + 2;
    let rank = 2 * n;
    let j = Matrix::from_fn(n, rank, |_, _| uniform(&mut random) / (rank as f64).sqrt());
    let a = Matrix::from_fn(n, n, |r, c| j.row(r).iter().zip(j.row(c)).map(|(x, y)| x * y).sum());
    let b = (0..n).map(|_| uniform(&mut random)).collect();
    let bound = |i: usize| if i < 3 * contacts { (0.0, INFINITE) } else { (-INFINITE, INFINITE) };
    let (lower, upper) = (0..n).map(bound).unzip();
    let friction = |i: usize| {
        (i < 3 * contacts && !i.is_multiple_of(3)).then(|| Friction {
            normals: vec![i - i % 3],
            coefficient: 0.4,
            partner: None,
        })
    };
    BoxLcp::new(a, b, lower, upper).unwrap().with_friction((0..n).map(friction).collect()).unwrap()
}

#[test]
fn methods_agree_on_friction_boxes() {
    for seed in 0..8 {
        let problem = random_contacts(1 + seed as usize, 40 + seed);
        let settings = Settings { sweeps: 50_000, tolerance: 1e-11, ..Settings::default() };
        for method in [Method::Lemke, Method::Dantzig, Method::ProjectedGaussSeidel, Method::BlockProjectedGaussSeidel]
        {
            let solution = method.solve(&problem, &settings);
            assert_eq!(solution.status, Status::Solved, "{} on seed {seed}", method.name());
            assert_solves(&problem, &solution, 1e-9, method.name());
        }
    }
}

#[test]
fn torsion_is_bounded_by_the_sum_of_its_normals() {
    // Two normals of 1 and 2 N·s, a radius of 0.1 m, a torque of 1 N·m·s.
    let a = Matrix::from_fn(3, 3, |i, j| f64::from(i == j));
    let torsion = Some(Friction { normals: vec![0, 1], coefficient: 0.1, partner: None });
    let problem = BoxLcp::new(a, vec![-1.0, -2.0, 1.0], vec![0.0; 3], vec![INFINITE; 3])
        .unwrap()
        .with_friction(vec![None, None, torsion])
        .unwrap();
    for method in [Method::Lemke, Method::Dantzig, Method::ProjectedGaussSeidel] {
        let solution = method.solve(&problem, &Settings::default());
        assert!((solution.lambda[2] + 0.3).abs() < 1e-9 && (solution.w[2] - 0.7).abs() < 1e-9, "{}", method.name());
    }
}

#[test]
fn dantzig_leaves_disks_to_blocks() {
    let problem = block([1.0, 1.0], 0.5, true);
    let solution = Method::Dantzig.solve(&problem, &Settings::default());
    assert_eq!((solution.status, solution.fallback), (Status::Solved, Some("block-pgs")));
}

#[test]
fn couplings_that_make_no_sense_are_refused_with_their_place() {
    let plain = || {
        let a = Matrix::from_fn(3, 3, |i, j| f64::from(i == j));
        BoxLcp::new(a, vec![0.0; 3], vec![0.0, -1.0, 0.0], vec![INFINITE; 3]).unwrap()
    };
    let of = |normals: &[usize], coefficient: f64, partner: Option<usize>| {
        Some(Friction { normals: normals.to_vec(), coefficient, partner })
    };
    for (friction, words) in [
        (vec![None, None], "mu_of: must have 3 entries"),
        (vec![None, None, of(&[3], 0.5, None)], "mu_of[2]: names row 3, but there are 3"),
        (vec![None, None, of(&[2], 0.5, None)], "mu_of[2]: names row 2, which is bounded by friction itself"),
        (vec![None, None, of(&[1], 0.5, None)], "mu_of[2]: names row 1, which may pull"),
        (vec![None, None, of(&[], 0.5, None)], "mu_of[2]: must name at least one row"),
        (vec![None, None, of(&[0], -0.5, None)], "mu[2]: must be finite and ≥ 0"),
        (vec![None, None, of(&[0], f64::NAN, None)], "mu[2]: must be finite and ≥ 0"),
        (vec![None, None, of(&[0], 0.5, Some(2))], "disk[2]: names row 2"),
        (vec![None, None, of(&[0], 0.5, Some(9))], "disk[2]: names row 9"),
        (vec![None, of(&[0], 0.4, Some(2)), of(&[0], 0.5, Some(1))], "disk[1]: names row 2: it must name 1 back"),
    ] {
        let error = plain().with_friction(friction).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn pgs_with_a_short_relaxation_ends_at_the_same_place() {
    let problem = random_contacts(4, 77);
    let solve = |relaxation| projected_gauss_seidel(&problem, &Settings { relaxation, ..Settings::default() });
    for relaxation in [0.6, 1.3] {
        assert_solves(&problem, &solve(relaxation), 1e-9, "relaxed");
    }
    assert_ne!(solve(0.6).sweeps, solve(1.3).sweeps);
}
