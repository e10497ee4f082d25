//! Problems with a name, and ways to have no solution.

use crate::oracle::enumerate;
use crate::problems::{contacts, distance};
use ishigaki::lcp::{BoxLcp, Settings, Status, lemke};

fn lower_triangle(n: usize) -> Vec<Vec<f64>> {
    let entry = |i: usize, j: usize| if i == j { 1.0 } else { f64::from(j < i) * 2.0 };
    (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect()
}

fn murty(n: usize) -> BoxLcp {
    let rows = lower_triangle(n);
    let rows: Vec<&[f64]> = rows.iter().map(Vec::as_slice).collect();
    let b: Vec<f64> = (1..=n).map(|i| -((n + 1 - i..=n).map(|k| 2_f64.powi(k as i32)).sum::<f64>())).collect();
    contacts(&rows, &b)
}

#[test]
fn murtys_example_is_solved_and_costs_two_to_the_n() {
    let mut pivots = Vec::new();
    for n in 2..=8 {
        let problem = murty(n);
        let solution = lemke(&problem, &Settings::default());
        assert_eq!(solution.status, Status::Solved);
        let [(_, expected)] = &enumerate(&problem)[..] else { panic!("a P-matrix has one solution") };
        assert!(distance(&solution.w, expected) < 1e-8);
        pivots.push(solution.sweeps);
    }
    eprintln!("{pivots:?}");
    for (n, pair) in (3..).zip(pivots.windows(2)) {
        assert!(pair[1] >= 2 * pair[0] - 1, "n = {n}: {pivots:?}");
    }
    // And with too few pivots it says so.
    let settings = Settings { sweeps: 20, ..Settings::default() };
    assert_eq!(lemke(&murty(8), &settings).status, Status::Limit);
}
