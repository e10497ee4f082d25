//! An active-set method: Dantzig's principal pivoting, one row after the other. Cottle & Dantzig 1968, Baraff 1994.
//!
//! Rows are taken in one by one; those inside keep all their conditions meanwhile. Row i moves λ_i towards w_i = 0 while the
//! clamped rows C (w = 0, λ inside) answer with Δλ_C = −A_CC⁻¹ A_Ci, until w_i = 0, or λ_i or a row of C reaches a bound,
//! or the w of a row at its bound reaches 0: that row changes its set, and the motion goes on. A row that depends on C moves
//! no w: it is left idle inside with w = 0. For symmetric positive semidefinite A every step is progress; without blocking
//! rows the problem is infeasible. Few pivots, O(|C|³) each here. Fallback: bounds of friction boxes are held while the rest
//! is solved and then read again; where that does not settle, where A is not symmetric or ties make it lose its way,
//! Lemke's method takes over; problems with friction disks go to block PGS. Reads sweeps (as pivots), tolerance, and what
//! the fallbacks read. Tests: `tests/lcp`.

use crate::lcp::block_projected_gauss_seidel::block_projected_gauss_seidel;
use crate::lcp::box_lcp::{BoxLcp, clip};
use crate::lcp::lemke::lemke;
use crate::lcp::settings::{Settings, Solution, Status};

/// Relative to the greatest of the numbers compared: rounding.
const TINY: f64 = 1e-11;
/// A sum is 0 when it is this much smaller than its terms.
const NOISE: f64 = 1e-10;
/// Readings of the bounds of friction before Lemke's method takes over.
const ROUNDS: usize = 100;

/// Dantzig's method; [`Solution::fallback`] names the method that had to finish.
///
/// ```
/// use ishigaki::lcp::{BoxLcp, Matrix, Settings, Status, dantzig};
/// // A box on four points: three of them say all there is to say.
/// let corner = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
/// let a = Matrix::from_fn(4, 4, |i, j| 1.0 + 6.0 * (corner[i].0 * corner[j].0 + corner[i].1 * corner[j].1));
/// let problem = BoxLcp::new(a, vec![-1.0; 4], vec![0.0; 4], vec![f64::INFINITY; 4])?;
/// let solution = dantzig(&problem, &Settings::default());
/// assert_eq!((solution.status, solution.fallback), (Status::Solved, None));
/// assert!((solution.lambda.iter().sum::<f64>() - 1.0).abs() < 1e-12);
/// # Ok::<(), ishigaki::Error>(())
/// ```
pub fn dantzig(problem: &BoxLcp, settings: &Settings) -> Solution {
    let mut residuals = Vec::new();
    if problem.has_disks() {
        return fall_back(block_projected_gauss_seidel(problem, settings), "block-pgs", residuals);
    }
    let mut lambda = problem.cold_start();
    let coupled = problem.friction.iter().any(Option::is_some);
    for _ in 0..if coupled { ROUNDS } else { 1 } {
        let bounds = (0..problem.len()).map(|i| problem.bounds(i, &lambda)).collect();
        let mut state = State::new(problem, bounds);
        let left = settings.sweeps.saturating_sub(residuals.len());
        let end = state.solve(left, |lambda, w| residuals.push(problem.residual_for(lambda, w)));
        lambda = state.lambda;
        if end == End::OutOfPivots {
            return Solution::of(problem, lambda, residuals, Status::Limit);
        }
        let residual = problem.residual(&lambda);
        let scale = problem.b.iter().chain(&lambda).fold(1.0_f64, |m, x| m.max(x.abs()));
        if end == End::Done && residual <= settings.tolerance.max(1e-11 * scale) {
            return Solution::of(problem, lambda, residuals, Status::Solved);
        }
        if end != End::Done {
            break;
        }
    }
    let left = Settings { sweeps: settings.sweeps.saturating_sub(residuals.len()), ..settings.clone() };
    fall_back(lemke(problem, &left), "lemke", residuals)
}

fn fall_back(solution: Solution, name: &'static str, mut residuals: Vec<f64>) -> Solution {
    residuals.extend(&solution.residuals);
    Solution { sweeps: residuals.len(), residuals, fallback: Some(name), ..solution }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum End {
    Done,
    OutOfPivots,
    /// Nothing blocks, or a system that should have a solution has none.
    Lost,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Set {
    /// Not taken in yet.
    Waiting,
    /// Inside, w = 0.
    Clamped,
    /// Inside, w = 0, but the clamped rows say all that it says.
    Idle,
    Lower,
    Upper,
}

struct State<'a> {
    problem: &'a BoxLcp,
    bounds: Vec<(f64, f64)>,
    set: Vec<Set>,
    lambda: Vec<f64>,
    w: Vec<f64>,
}

/// A unit of motion of the row that is driven.
struct Motion {
    lambda: Vec<f64>,
    w: Vec<f64>,
    /// What rounding may make of a w that does not move.
    noise: Vec<f64>,
}

impl<'a> State<'a> {
    fn new(problem: &'a BoxLcp, bounds: Vec<(f64, f64)>) -> Self {
        let lambda: Vec<f64> = bounds.iter().map(|&(lower, upper)| clip(0.0, lower, upper)).collect();
        let w = problem.w(&lambda);
        Self { problem, bounds, set: vec![Set::Waiting; w.len()], lambda, w }
    }

    fn solve(&mut self, most: usize, mut watch: impl FnMut(&[f64], &[f64])) -> End {
        let is_free = |&i: &usize| self.bounds[i].0 == f64::NEG_INFINITY && self.bounds[i].1 == f64::INFINITY;
        // Equations first: nothing can block them.
        let (free, bounded): (Vec<usize>, Vec<usize>) = (0..self.problem.len()).partition(is_free);
        let mut pivots = 0;
        for i in free.into_iter().chain(bounded) {
            loop {
                if self.take_in(i) {
                    break;
                }
                if pivots == most {
                    return End::OutOfPivots;
                }
                pivots += 1;
                // Three times the rows is usual; a walk in circles is one of rounding.
                if pivots > 50 * (self.problem.len() + 10) || !self.drive(i) {
                    return End::Lost;
                }
                watch(&self.lambda, &self.w);
            }
        }
        self.polish();
        End::Done
    }

    /// Whether row i needs no more motion; it is in its set then.
    fn take_in(&mut self, i: usize) -> bool {
        let (lower, upper) = self.bounds[i];
        let (lambda, w) = (self.lambda[i], self.w[i]);
        let zero = self.zero();
        let set = match self.set[i] {
            Set::Waiting if lambda <= lower && w >= -zero => Set::Lower,
            Set::Waiting if lambda >= upper && w <= zero => Set::Upper,
            Set::Waiting if w.abs() <= zero => {
                if self.motion(i, 1.0).is_some_and(|m| m.w[i] > m.noise[i]) {
                    Set::Clamped
                } else {
                    Set::Idle
                }
            }
            Set::Waiting => return false,
            known => known,
        };
        self.set[i] = set;
        true
    }

    /// |w| below this is 0.
    fn zero(&self) -> f64 {
        TINY * self.problem.b.iter().fold(1e-3_f64, |m, x| m.max(x.abs()))
    }

    fn members(&self, set: Set) -> Vec<usize> {
        (0..self.set.len()).filter(|&j| self.set[j] == set).collect()
    }

    /// Δλ_i = sign, Δλ_C = −A_CC⁻¹ A_Ci sign, Δw = A Δλ.
    fn motion(&self, i: usize, sign: f64) -> Option<Motion> {
        let clamped = self.members(Set::Clamped);
        let a = &self.problem.a;
        let right: Vec<f64> = clamped.iter().map(|&j| -sign * a[(j, i)]).collect();
        let answer = a.part(&clamped, &clamped).solve(&right)?;
        let mut lambda = vec![0.0; self.lambda.len()];
        lambda[i] = sign;
        clamped.iter().zip(answer).for_each(|(&j, x)| lambda[j] = x);
        let w = a.times(&lambda);
        let terms = |j: usize| a.row(j).iter().zip(&lambda).map(|(a, l)| (a * l).abs()).sum::<f64>();
        let noise = (0..w.len()).map(|j| NOISE * terms(j)).collect();
        Some(Motion { lambda, w, noise })
    }

    /// Moves row i until a row changes its set; `false` if nothing stops it.
    fn drive(&mut self, i: usize) -> bool {
        let sign = -self.w[i].signum();
        let Some(motion) = self.motion(i, sign) else { return false };
        let Some((step, row, set)) = self.first_stop(i, &motion) else { return false };
        for (lambda, delta) in self.lambda.iter_mut().zip(&motion.lambda) {
            *lambda += step * delta;
        }
        match set {
            Set::Lower => self.lambda[row] = self.bounds[row].0,
            Set::Upper => self.lambda[row] = self.bounds[row].1,
            _ => {}
        }
        self.w = self.problem.w(&self.lambda);
        self.set[row] = set;
        true
    }

    /// How far the motion goes, which row stops it and where that row belongs then.
    fn first_stop(&self, i: usize, motion: &Motion) -> Option<(f64, usize, Set)> {
        let mut best: Option<(f64, usize, Set)> = None;
        let mut offer = |step: f64, row: usize, set: Set| {
            if step.is_finite() && best.is_none_or(|(least, _, _)| step < least) {
                best = Some((step.max(0.0), row, set));
            }
        };
        for j in 0..self.set.len() {
            let (lower, upper) = self.bounds[j];
            let (dl, dw) = (motion.lambda[j], motion.w[j]);
            let moves_w = dw.abs() > motion.noise[j];
            if (j == i || self.set[j] == Set::Clamped) && dl.abs() > TINY {
                let (bound, set) = if dl > 0.0 { (upper, Set::Upper) } else { (lower, Set::Lower) };
                offer((bound - self.lambda[j]) / dl, j, set);
            }
            if j == i && moves_w && dw * self.w[i] < 0.0 {
                offer(-self.w[i] / dw, i, Set::Clamped);
            }
            match self.set[j] {
                Set::Lower if moves_w && dw < 0.0 && lower < upper => offer(-self.w[j] / dw, j, Set::Clamped),
                Set::Upper if moves_w && dw > 0.0 && lower < upper => offer(-self.w[j] / dw, j, Set::Clamped),
                Set::Idle if moves_w => offer(0.0, j, Set::Clamped),
                _ => {}
            }
        }
        best
    }

    /// λ_C from A and b alone: the rounding of many steps goes.
    fn polish(&mut self) {
        let clamped = self.members(Set::Clamped);
        let mut rest = self.lambda.clone();
        clamped.iter().for_each(|&j| rest[j] = 0.0);
        let right: Vec<f64> = clamped.iter().map(|&j| -self.problem.w_of(j, &rest)).collect();
        let Some(values) = self.problem.a.part(&clamped, &clamped).solve(&right) else { return };
        for (&j, value) in clamped.iter().zip(values) {
            rest[j] = clip(value, self.bounds[j].0, self.bounds[j].1);
        }
        if self.problem.residual(&rest) <= self.problem.residual(&self.lambda) {
            self.lambda = rest;
        }
    }
}
