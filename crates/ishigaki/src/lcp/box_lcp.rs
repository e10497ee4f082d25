//! The general box LCP. TALK C1–C3.
//!
//! w = A λ + b with λ ∈ [lower, upper]: λ = lower ⇒ w ≥ 0; inside ⇒ w = 0; λ = upper ⇒ w ≤ 0. One form for contacts
//! (0, ∞), joints (−∞, ∞), limits, motors, friction. A is a mass seen from the rows (1/kg), λ an impulse (N·s), w and b
//! velocities (m/s), but any units that fit will do. Residual: ‖λ − clip(λ − w, lower, upper)‖∞.
//!
//! Friction couples bounds to other rows: |λ_t| ≤ μ Σλ_n, for a row alone (box) or for the length of two rows (disk).
//! Without it a tangent would have to guess how hard its contact presses. Tests: `tests/lcp`.

use crate::error::{Error, Result};
use crate::lcp::matrix::Matrix;

/// |λ_i| ≤ `coefficient` · Σ λ of `normals`, the bounds of row i read again whenever it is visited. TALK C2.
#[derive(Clone, Debug, PartialEq)]
pub struct Friction {
    /// Rows of the normal impulses; several for torsion and rolling.
    pub normals: Vec<usize>,
    /// μ, or a length (m) for torsion and rolling.
    pub coefficient: f64,
    /// The other row of a disk: then √(λ_i² + λ_partner²) is bounded. `None`: this row alone (box).
    pub partner: Option<usize>,
}

/// A box LCP, checked when it is made: sizes fit, numbers are numbers, friction names rows that exist.
///
/// ```
/// use ishigaki::lcp::{BoxLcp, Matrix, Settings, projected_gauss_seidel};
/// // Two boxes on each other, 1 kg each, falling at 1 m/s: the lower contact carries both.
/// let a = Matrix::from_fn(2, 2, |i, j| [[1.0, -1.0], [-1.0, 2.0]][i][j]);
/// let problem = BoxLcp::new(a, vec![-1.0, 0.0], vec![0.0; 2], vec![f64::INFINITY; 2])?;
/// let solution = projected_gauss_seidel(&problem, &Settings::default());
/// assert!((solution.lambda[0] - 2.0).abs() < 1e-8 && (solution.lambda[1] - 1.0).abs() < 1e-8);
/// # Ok::<(), ishigaki::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct BoxLcp {
    pub(crate) a: Matrix,
    pub(crate) b: Vec<f64>,
    pub(crate) lower: Vec<f64>,
    pub(crate) upper: Vec<f64>,
    pub(crate) friction: Vec<Option<Friction>>,
    pub(crate) groups: Vec<usize>,
}

impl BoxLcp {
    /// A problem without friction; infinite bounds are `f64::INFINITY` and its negative.
    ///
    /// # Errors
    /// Sizes that differ, numbers that are not finite, a lower bound above the upper; the place is named, as `a[3][2]`.
    pub fn new(a: Matrix, b: Vec<f64>, lower: Vec<f64>, upper: Vec<f64>) -> Result<Self> {
        let n = b.len();
        if a.rows() != n || a.columns() != n {
            return Err(Error::invalid("a", format!("must be {n} × {n}, is {} × {}", a.rows(), a.columns())));
        }
        same_length("lower", lower.len(), n)?;
        same_length("upper", upper.len(), n)?;
        for i in 0..n {
            if let Some(j) = a.row(i).iter().position(|x| !x.is_finite()) {
                return Err(Error::invalid(format!("a[{i}][{j}]"), format!("must be finite, is {}", a[(i, j)])));
            }
            if !b[i].is_finite() {
                return Err(Error::invalid(format!("b[{i}]"), format!("must be finite, is {}", b[i])));
            }
            if lower[i].is_nan() || lower[i] == f64::INFINITY {
                return Err(Error::invalid(format!("lower[{i}]"), "must be a number or −∞"));
            }
            if upper[i].is_nan() || upper[i] == f64::NEG_INFINITY {
                return Err(Error::invalid(format!("upper[{i}]"), "must be a number or ∞"));
            }
            if lower[i] > upper[i] {
                let message = format!("is {}, above upper[{i}], which is {}", lower[i], upper[i]);
                return Err(Error::invalid(format!("lower[{i}]"), message));
            }
        }
        Ok(Self { a, b, lower, upper, friction: vec![None; n], groups: Vec::new() })
    }

    /// The same with friction: one entry for each row. The bounds of a coupled row are not read any more.
    ///
    /// # Errors
    /// Rows that do not exist, normals that may pull (lower < 0) or are bounded by friction themselves, coefficients that
    /// are negative, disks whose two rows do not name each other with the same normals and coefficient.
    pub fn with_friction(mut self, friction: Vec<Option<Friction>>) -> Result<Self> {
        let n = self.len();
        same_length("mu_of", friction.len(), n)?;
        for (i, coupling) in friction.iter().enumerate() {
            let Some(f) = coupling else { continue };
            if !(f.coefficient.is_finite() && f.coefficient >= 0.0) {
                return Err(Error::invalid(
                    format!("mu[{i}]"),
                    format!("must be finite and ≥ 0, is {}", f.coefficient),
                ));
            }
            let place = || format!("mu_of[{i}]");
            if f.normals.is_empty() {
                return Err(Error::invalid(place(), "must name at least one row"));
            }
            for &row in &f.normals {
                if row >= n {
                    return Err(Error::invalid(place(), format!("names row {row}, but there are {n}")));
                }
                if friction[row].is_some() {
                    let message = format!("names row {row}, which is bounded by friction itself");
                    return Err(Error::invalid(place(), message));
                }
                if self.lower[row] < 0.0 {
                    let message = format!("names row {row}, which may pull: its lower bound must be ≥ 0");
                    return Err(Error::invalid(place(), message));
                }
            }
            let Some(partner) = f.partner else { continue };
            let back = Friction { partner: Some(i), ..f.clone() };
            if partner == i || friction.get(partner) != Some(&Some(back)) {
                let message = format!("names row {partner}: it must name {i} back, with the same normals and μ");
                return Err(Error::invalid(format!("disk[{i}]"), message));
            }
        }
        self.friction = friction;
        Ok(self)
    }

    /// The same with the rows in groups, which block methods solve together: a number for each row.
    ///
    /// # Errors
    /// Another count than there are rows.
    pub fn with_groups(mut self, groups: Vec<usize>) -> Result<Self> {
        same_length("group", groups.len(), self.len())?;
        self.groups = groups;
        Ok(self)
    }

    /// How many rows.
    pub fn len(&self) -> usize {
        self.b.len()
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.b.is_empty()
    }

    /// A.
    pub fn a(&self) -> &Matrix {
        &self.a
    }

    /// b.
    pub fn b(&self) -> &[f64] {
        &self.b
    }

    /// Least λ; meaningless for rows with friction.
    pub fn lower(&self) -> &[f64] {
        &self.lower
    }

    /// Greatest λ; meaningless for rows with friction.
    pub fn upper(&self) -> &[f64] {
        &self.upper
    }

    /// The coupling of each row.
    pub fn friction(&self) -> &[Option<Friction>] {
        &self.friction
    }

    /// The group of each row, or nothing.
    pub fn groups(&self) -> &[usize] {
        &self.groups
    }

    /// Whether any two rows are a disk.
    pub fn has_disks(&self) -> bool {
        self.friction.iter().flatten().any(|f| f.partner.is_some())
    }

    /// A λ + b.
    pub fn w(&self, lambda: &[f64]) -> Vec<f64> {
        self.a.times(lambda).iter().zip(&self.b).map(|(w, b)| w + b).collect()
    }

    /// Row i of A λ + b.
    pub fn w_of(&self, i: usize, lambda: &[f64]) -> f64 {
        self.a.row_times(i, lambda) + self.b[i]
    }

    /// μ Σλ_n for the impulses as they are.
    pub fn reach(&self, friction: &Friction, lambda: &[f64]) -> f64 {
        let sum: f64 = friction.normals.iter().map(|&n| lambda[n]).sum();
        // A method that lets normals pull for a while has no friction then.
        friction.coefficient * sum.max(0.0)
    }

    /// Bounds of row i, those of friction for the impulses as they are.
    pub fn bounds(&self, i: usize, lambda: &[f64]) -> (f64, f64) {
        match &self.friction[i] {
            None => (self.lower[i], self.upper[i]),
            Some(f) => {
                let reach = self.reach(f, lambda);
                (-reach, reach)
            }
        }
    }

    /// ‖λ − clip(λ − w)‖∞; for a disk the length of λ − clip(λ − w) of its two rows, clipped to the disk.
    pub fn residual(&self, lambda: &[f64]) -> f64 {
        self.residual_for(lambda, &self.w(lambda))
    }

    /// The same where w = A λ + b is known.
    pub fn residual_for(&self, lambda: &[f64], w: &[f64]) -> f64 {
        let mut greatest = 0.0_f64;
        for i in 0..self.len() {
            let change = match &self.friction[i] {
                Some(f) if f.partner.is_some_and(|p| p < i) => continue,
                Some(f) if f.partner.is_some() => {
                    let j = f.partner.unwrap_or(i);
                    let to = clip_to_disk([lambda[i] - w[i], lambda[j] - w[j]], self.reach(f, lambda));
                    length(lambda[i] - to[0], lambda[j] - to[1])
                }
                _ => {
                    let (lower, upper) = self.bounds(i, lambda);
                    (lambda[i] - clip(lambda[i] - w[i], lower, upper)).abs()
                }
            };
            // Not `max` alone: it would drop a NaN.
            greatest = if change.is_nan() { f64::INFINITY } else { greatest.max(change) };
        }
        greatest
    }

    /// λ of least size within the bounds: where methods start that are told nothing else.
    pub fn cold_start(&self) -> Vec<f64> {
        let row = |i: usize| if self.friction[i].is_some() { 0.0 } else { clip(0.0, self.lower[i], self.upper[i]) };
        (0..self.len()).map(row).collect()
    }
}

/// x within [lower, upper]; unlike `f64::clamp` it never panics.
#[inline]
pub(crate) fn clip(x: f64, lower: f64, upper: f64) -> f64 {
    x.max(lower).min(upper)
}

/// √(x² + y²); std's `hypot` differs between platforms.
#[inline]
pub(crate) fn length(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

/// The nearest point of a disk around 0.
#[inline]
pub(crate) fn clip_to_disk([x, y]: [f64; 2], radius: f64) -> [f64; 2] {
    let length = length(x, y);
    let scale = if length > radius { radius / length } else { 1.0 };
    [x * scale, y * scale]
}

fn same_length(place: &str, length: usize, n: usize) -> Result<()> {
    if length == n {
        Ok(())
    } else {
        Err(Error::invalid(place, format!("must have {n} entries, one for each row, has {length}")))
    }
}
