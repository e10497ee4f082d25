//! Lemke's method: complementary pivoting. TALK C4 (the slide says Lemke–Howson).
//!
//! y = M z + q + d z₀ with d = (1, …, 1): z₀ large enough makes y ≥ 0. It enters the basis in place of the worst y; then
//! always the complement of what has just left enters, until z₀ leaves: solved. Which row leaves is decided by the
//! lexicographic ratio test: of equal ratios (four points under a box make many) the choice by the rows of B⁻¹ never comes
//! back to a basis, so that it cannot cycle. If nothing blocks the entering variable, the method ends on a ray: for
//! positive semidefinite A there is no solution. Exact but for rounding, and it pays: O(n²) a pivot, n…3n pivots, 2ⁿ in
//! Murty's example. The λ of the last basis is computed anew from A and b, so that the rounding of pivots does not add up;
//! if it is wrong all the same, smaller pivots are refused and the method begins again.
//! Reads sweeps (as pivots; 0 pivots are no method), corners. Tests: `tests/lcp`.

use crate::lcp::box_lcp::BoxLcp;
use crate::lcp::elimination::Reduced;
use crate::lcp::matrix::Matrix;
use crate::lcp::settings::{Settings, Solution, Status};
use crate::lcp::stewart_trinkle::Linear;

/// Entries below these, in a matrix scaled to a diagonal of 1, are rounding: of f64 first; then, where a basis comes out
/// wrong, of problems that have been f32 before, whose four points under a box are dependent only to 1e-7.
const TINY: [f64; 3] = [1e-9, 1e-7, 1e-5];
/// Ratios closer than this are ties.
const TIE: f64 = 1e-12;

/// Lemke's method, with friction as Stewart and Trinkle's LCP.
///
/// Friction disks become polygons of [`Settings::corners`] corners: the residual, which is that of the disk, then says how
/// far the polygon is from it, and status `Solved` speaks of the polygon.
///
/// ```
/// use ishigaki::lcp::{BoxLcp, Matrix, Settings, Status, lemke};
/// // w = −λ₂ − 1 can never be ≥ 0.
/// let a = Matrix::from_fn(2, 2, |i, j| if (i, j) == (0, 1) { -1.0 } else { f64::from((i, j) == (1, 0)) });
/// let problem = BoxLcp::new(a, vec![-1.0, 1.0], vec![0.0; 2], vec![f64::INFINITY; 2])?;
/// assert_eq!(lemke(&problem, &Settings::default()).status, Status::Infeasible);
/// # Ok::<(), ishigaki::Error>(())
/// ```
pub fn lemke(problem: &BoxLcp, settings: &Settings) -> Solution {
    let linear = Linear::new(problem, settings.corners);
    let mut residuals = Vec::new();
    let Some(reduced) = Reduced::new(&linear.m, &linear.q, &linear.free) else {
        // Equations that contradict each other.
        return Solution::of(problem, problem.cold_start(), residuals, Status::Infeasible);
    };
    let lambda_of = |z: &[f64]| linear.lambda(&reduced.expand(z));
    let mut best: Option<Attempt> = None;
    for tiny in TINY {
        let left = settings.sweeps.saturating_sub(residuals.len());
        let watch = |z: &[f64]| residuals.push(problem.residual(&lambda_of(z)));
        let attempt = Attempt::new(&reduced, tiny, left, watch);
        if best.as_ref().is_none_or(|best| attempt.is_better_than(best)) {
            best = Some(attempt);
        }
        if best.as_ref().is_some_and(|best| best.is_exact()) || residuals.len() == settings.sweeps {
            break;
        }
    }
    let (lambda, status) = match best {
        Some(best) => (lambda_of(&best.z), best.status()),
        None => (problem.cold_start(), Status::Limit),
    };
    if lambda.iter().any(|x| !x.is_finite()) {
        return Solution::of(problem, problem.cold_start(), residuals, Status::Limit);
    }
    Solution::of(problem, lambda, residuals, status)
}

/// What pivoting with one idea of rounding came to.
struct Attempt {
    z: Vec<f64>,
    end: Status,
    /// ‖z − max(0, z − y)‖∞ over the greatest of the numbers in it.
    error: f64,
}

impl Attempt {
    fn new(reduced: &Reduced, tiny: f64, most: usize, watch: impl FnMut(&[f64])) -> Self {
        let (m, q) = (&reduced.m, &reduced.q);
        let (mut z, end) = pivot(m, q, tiny, most, watch);
        let error = |z: &[f64]| {
            let scale = z.iter().chain(q).fold(1.0_f64, |greatest, x| greatest.max(x.abs()));
            let change = |i: usize| (z[i] - (z[i] - m.row_times(i, z) - q[i]).max(0.0)).abs();
            let greatest = (0..z.len()).map(change).fold(0.0_f64, f64::max) / scale;
            if greatest.is_finite() { greatest } else { f64::INFINITY }
        };
        if end == Status::Solved
            && let Some(refined) = refine(m, q, &z)
            && error(&refined) < error(&z)
        {
            z = refined;
        }
        Self { error: error(&z), z, end }
    }

    fn is_exact(&self) -> bool {
        self.end == Status::Solved && self.error < 1e-12
    }

    fn is_better_than(&self, other: &Self) -> bool {
        let solved = |a: &Self| a.end == Status::Solved;
        (solved(self), -self.error) > (solved(other), -other.error)
    }

    fn status(&self) -> Status {
        // A basis that rounding made: no solution, and no proof that there is none.
        if self.end == Status::Solved && self.error > 1e-6 { Status::Limit } else { self.end }
    }
}

/// Complementary pivoting on y = M z + q; `watch` sees z after each pivot.
fn pivot(m: &Matrix, q: &[f64], tiny: f64, most: usize, mut watch: impl FnMut(&[f64])) -> (Vec<f64>, Status) {
    let n = q.len();
    if q.iter().all(|&q| q >= 0.0) {
        return (vec![0.0; n], Status::Solved);
    }
    let mut tableau = Tableau::new(m, q);
    let mut row = tableau.worst_row();
    let mut entering = tableau.artificial();
    for _ in 0..most {
        let leaving = tableau.exchange(row, entering);
        watch(&tableau.z());
        if leaving == tableau.artificial() {
            return (tableau.z(), Status::Solved);
        }
        entering = tableau.complement(leaving);
        match tableau.blocking_row(entering, tiny) {
            Some(next) => row = next,
            None => return (tableau.z(), Status::Infeasible),
        }
    }
    (tableau.z(), Status::Limit)
}

/// [I, −M, −d | q], multiplied by the inverse of the basis: columns y (0…n), z (n…2n), z₀, and the values.
struct Tableau {
    t: Matrix,
    n: usize,
    /// The variable of each row, as the index of its column.
    basis: Vec<usize>,
}

impl Tableau {
    fn new(m: &Matrix, q: &[f64]) -> Self {
        let n = q.len();
        let mut t = Matrix::zeros(n, 2 * n + 2);
        for i in 0..n {
            let row = t.row_mut(i);
            row[i] = 1.0;
            row[n..2 * n].iter_mut().zip(m.row(i)).for_each(|(t, m)| *t = -m);
            row[2 * n] = -1.0;
            row[2 * n + 1] = q[i];
        }
        Self { t, n, basis: (0..n).collect() }
    }

    fn artificial(&self) -> usize {
        2 * self.n
    }

    fn complement(&self, variable: usize) -> usize {
        if variable < self.n { variable + self.n } else { variable - self.n }
    }

    fn value(&self, row: usize) -> f64 {
        self.t[(row, 2 * self.n + 1)]
    }

    /// The row that is lexicographically least: with z₀ in its place all others are positive.
    fn worst_row(&self) -> usize {
        let mut worst = 0;
        for i in 1..self.n {
            // Of equal values the last: (q, e_i) is greater than (q, e_k) for i < k.
            if self.value(i) <= self.value(worst) + TIE * self.value(worst).abs() {
                worst = i;
            }
        }
        worst
    }

    /// The row that limits the entering variable, by the lexicographic ratio test; z₀ wherever it is among the first.
    fn blocking_row(&self, entering: usize, tiny: f64) -> Option<usize> {
        let mut best: Option<usize> = None;
        for i in (0..self.n).filter(|&i| self.t[(i, entering)] > tiny) {
            best = match best {
                Some(b) if !self.is_before(i, b, entering) => Some(b),
                _ => Some(i),
            };
        }
        best
    }

    /// Whether (value, B⁻¹ row) / column of row i is lexicographically less than that of row k.
    fn is_before(&self, i: usize, k: usize, entering: usize) -> bool {
        let (ci, ck) = (self.t[(i, entering)], self.t[(k, entering)]);
        let (a, b) = (self.value(i) / ci, self.value(k) / ck);
        let scale = a.abs().max(b.abs()).max(1.0);
        if (a - b).abs() > TIE * scale {
            return a < b;
        }
        if self.basis[i] == self.artificial() || self.basis[k] == self.artificial() {
            return self.basis[i] == self.artificial();
        }
        for column in 0..self.n {
            let (a, b) = (self.t[(i, column)] / ci, self.t[(k, column)] / ck);
            if (a - b).abs() > TIE * a.abs().max(b.abs()).max(1.0) {
                return a < b;
            }
        }
        false
    }

    /// Gauss–Jordan on (row, entering); gives the variable that left.
    fn exchange(&mut self, row: usize, entering: usize) -> usize {
        let pivot = self.t[(row, entering)];
        self.t.row_mut(row).iter_mut().for_each(|x| *x /= pivot);
        for i in (0..self.n).filter(|&i| i != row) {
            let factor = self.t[(i, entering)];
            if factor != 0.0 {
                self.t.add_row(i, -factor, row, 0);
                self.t[(i, entering)] = 0.0;
            }
        }
        std::mem::replace(&mut self.basis[row], entering)
    }

    fn z(&self) -> Vec<f64> {
        let mut z = vec![0.0; self.n];
        for (row, &variable) in self.basis.iter().enumerate() {
            if (self.n..2 * self.n).contains(&variable) {
                z[variable - self.n] = self.value(row).max(0.0);
            }
        }
        z
    }
}

/// The values of the variables that are > 0, from M and q alone: M_BB z_B = −q_B.
fn refine(m: &Matrix, q: &[f64], z: &[f64]) -> Option<Vec<f64>> {
    let basic: Vec<usize> = (0..z.len()).filter(|&i| z[i] > 0.0).collect();
    let right: Vec<f64> = basic.iter().map(|&i| -q[i]).collect();
    let values = m.part(&basic, &basic).solve(&right)?;
    let mut refined = vec![0.0; z.len()];
    for (&i, value) in basic.iter().zip(values) {
        refined[i] = value.max(0.0);
    }
    Some(refined)
}
