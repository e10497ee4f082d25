//! What all methods are told and what they give back.

use crate::lcp::box_lcp::BoxLcp;
use crate::solver::permutation::Random;

/// Order of the rows in a sweep. TALK D3.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// First to last.
    #[default]
    Fixed,
    /// A new random order in each sweep, from [`Settings::seed`].
    Random,
    /// First to last, then last to first.
    Alternating,
}

/// How long and in which way a method works. Each method says what it reads.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Sweeps at most, or pivots of direct methods.
    pub sweeps: usize,
    /// Solved when the residual is not greater.
    pub tolerance: f64,
    /// ω: a row takes this part of its step; in (0, 2) for Gauss–Seidel, smaller for Jacobi.
    pub relaxation: f64,
    /// Order of the rows.
    pub order: Order,
    /// Of random orders.
    pub seed: u64,
    /// Warm start; missing entries and numbers that are not finite count as 0.
    pub start: Option<Vec<f64>>,
    /// Passes over the normals of a block in each visit.
    pub passes: usize,
    /// Corners of the polygon that stands for a friction disk in Lemke's method: at least 3.
    pub corners: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            sweeps: 10_000,
            tolerance: 1e-10,
            relaxation: 1.0,
            order: Order::Fixed,
            seed: 1,
            start: None,
            passes: 10,
            corners: 8,
        }
    }
}

impl Settings {
    /// At most `sweeps` sweeps.
    pub fn sweeps(sweeps: usize) -> Self {
        Self { sweeps, ..Self::default() }
    }

    /// λ to begin with: the warm start, or 0 moved into the bounds.
    pub(crate) fn start_of(&self, problem: &BoxLcp) -> Vec<f64> {
        let Some(start) = &self.start else { return problem.cold_start() };
        let value = |i: usize| start.get(i).copied().filter(|x| x.is_finite()).unwrap_or(0.0);
        (0..problem.len()).map(value).collect()
    }
}

/// How a method ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The residual is within the tolerance, or a direct method has found a complementary basis.
    Solved,
    /// No λ solves it (Lemke: a ray). Proved for positive semidefinite A; for others "none was found".
    Infeasible,
    /// Out of sweeps or pivots, or the numbers ran away.
    Limit,
}

impl Status {
    /// The word of files and command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Solved => "solved",
            Self::Infeasible => "infeasible",
            Self::Limit => "limit",
        }
    }
}

/// What a method found, solved or not.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// λ, always finite.
    pub lambda: Vec<f64>,
    /// A λ + b.
    pub w: Vec<f64>,
    /// ‖λ − clip(λ − w)‖∞ after every sweep or pivot.
    pub residuals: Vec<f64>,
    /// The residual of `lambda`.
    pub residual: f64,
    /// Sweeps or pivots done.
    pub sweeps: usize,
    /// How it ended.
    pub status: Status,
    /// The method that had to help, where one did.
    pub fallback: Option<&'static str>,
}

impl Solution {
    /// Fills in what follows from λ.
    pub(crate) fn of(problem: &BoxLcp, lambda: Vec<f64>, residuals: Vec<f64>, status: Status) -> Self {
        let w = problem.w(&lambda);
        let residual = problem.residual_for(&lambda, &w);
        Self { sweeps: residuals.len(), lambda, w, residuals, residual, status, fallback: None }
    }
}

/// Repeats `sweep(k, λ)` until the residual is within the tolerance, sweeps run out or numbers do.
pub(crate) fn iterate(problem: &BoxLcp, settings: &Settings, mut sweep: impl FnMut(usize, &mut Vec<f64>)) -> Solution {
    let mut lambda = settings.start_of(problem);
    let mut residuals = Vec::new();
    let mut status = Status::Limit;
    if problem.residual(&lambda) <= settings.tolerance {
        return Solution::of(problem, lambda, residuals, Status::Solved);
    }
    for k in 0..settings.sweeps {
        let before = lambda.clone();
        sweep(k, &mut lambda);
        let residual = problem.residual(&lambda);
        if !residual.is_finite() || lambda.iter().any(|x| !x.is_finite()) {
            // It diverged: the last numbers that are numbers.
            lambda = before;
            break;
        }
        residuals.push(residual);
        if residual <= settings.tolerance {
            status = Status::Solved;
            break;
        }
    }
    Solution::of(problem, lambda, residuals, status)
}

/// Puts `visits` into the order of sweep `k`.
pub(crate) fn arrange<T>(order: Order, k: usize, random: &mut Random, visits: &mut [T]) {
    match order {
        Order::Random => {
            for i in (1..visits.len()).rev() {
                visits.swap(i, random.below(i as u32 + 1) as usize);
            }
        }
        Order::Alternating if k > 0 => visits.reverse(),
        _ => {}
    }
}
