//! Problems that the tests share.

use ishigaki::lcp::{BoxLcp, Matrix, Solution};
use ishigaki::solver::permutation::Random;

pub const INFINITE: f64 = f64::INFINITY;

/// In [−1, 1).
pub fn uniform(random: &mut Random) -> f64 {
    (random.bits() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// A = J Jᵀ of random rows, J with `rank` columns, b = J v + what keeps it solvable; contacts, joints and motors in turn.
pub fn random_psd(n: usize, rank: usize, seed: u64) -> BoxLcp {
    let mut random = Random(seed);
    let j = Matrix::from_fn(n, rank, |_, _| uniform(&mut random) / (rank as f64).sqrt());
    let v: Vec<f64> = (0..rank).map(|_| uniform(&mut random)).collect();
    let a = Matrix::from_fn(n, n, |r, c| j.row(r).iter().zip(j.row(c)).map(|(x, y)| x * y).sum());
    let mut b = j.times(&v);
    let bounds = |i: usize| match i % 5 {
        0 => (-0.1, 0.15),
        1 => (-INFINITE, 0.0),
        // Equations: few enough to be independent.
        2 if i < rank / 2 => (-INFINITE, INFINITE),
        _ => (0.0, INFINITE),
    };
    // A contact that is apart may stay apart: b greater than J v keeps a solution.
    (0..n).filter(|&i| bounds(i) == (0.0, INFINITE)).for_each(|i| b[i] += 0.1 * (1.0 + uniform(&mut random)));
    let (lower, upper) = (0..n).map(bounds).unzip();
    BoxLcp::new(a, b, lower, upper).unwrap()
}

/// `boxes` boxes of 1 m and 1 kg on each other, four points a face: rank 3 for each four rows. Each falls at 1 m/s
/// and tilts a little as `seed` says. Also J and u₀, with velocities that make all masses 1.
pub fn box_stack(boxes: usize, seed: u64) -> (BoxLcp, Matrix, Vec<f64>) {
    let corner = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)];
    // 1/√I of a cube.
    let root = 6.0_f64.sqrt();
    let of_face = |i: usize, k: usize| [1.0, root * corner[i].0, root * corner[i].1][k];
    let entry = |i: usize, k: usize| match (i / 4, k / 3) {
        (above, b) if b == above => of_face(i % 4, k % 3),
        (above, b) if b + 1 == above => -of_face(i % 4, k % 3),
        _ => 0.0,
    };
    let j = Matrix::from_fn(4 * boxes, 3 * boxes, entry);
    let mut random = Random(seed);
    let u: Vec<f64> = (0..3 * boxes).map(|k| if k % 3 == 0 { -1.0 } else { 0.5 * uniform(&mut random) }).collect();
    let n = j.rows();
    let a = Matrix::from_fn(n, n, |r, c| j.row(r).iter().zip(j.row(c)).map(|(x, y)| x * y).sum());
    (BoxLcp::new(a, j.times(&u), vec![0.0; n], vec![INFINITE; n]).unwrap(), j, u)
}

pub fn unbounded(a: Matrix, b: Vec<f64>) -> BoxLcp {
    let n = b.len();
    BoxLcp::new(a, b, vec![-INFINITE; n], vec![INFINITE; n]).unwrap()
}

pub fn contacts(rows: &[&[f64]], b: &[f64]) -> BoxLcp {
    let n = b.len();
    let a = Matrix::from_fn(n, n, |i, j| rows[i][j]);
    BoxLcp::new(a, b.to_vec(), vec![0.0; n], vec![INFINITE; n]).unwrap()
}

/// ‖x − y‖∞.
pub fn distance(x: &[f64], y: &[f64]) -> f64 {
    assert_eq!(x.len(), y.len());
    x.iter().zip(y).fold(0.0, |m, (a, b)| (a - b).abs().max(m))
}

/// λ keeps its bounds, w its signs.
pub fn assert_solves(problem: &BoxLcp, solution: &Solution, tolerance: f64, what: &str) {
    let residual = problem.residual(&solution.lambda);
    assert!(residual <= tolerance, "{what}: residual {residual:e}, {:?} after {}", solution.status, solution.sweeps);
}
