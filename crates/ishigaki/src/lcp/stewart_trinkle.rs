//! From a box LCP, with friction, to the plain LCP that Lemke's method takes. TALK C4; Stewart & Trinkle 1996.
//!
//! y = M z + q, 0 ≤ y ⟂ z ≥ 0. A row with one bound is one z: λ = lower + z or λ = upper − z, y = ±w. With two bounds the
//! range left of z is a second variable: [y; r] = [[A, E], [−Eᵀ, 0]] [z; v] + …, r = range − z ≥ 0 ⟂ v ≥ 0, so that
//! w = y − v. Friction in the directions d_k of one row (±1) or of a disk (a polygon with `corners` corners on its edge):
//! λ_t = Σ β_k d_k; d_k·w + σ ≥ 0 ⟂ β_k ≥ 0; μΣλ_n − Σβ_k ≥ 0 ⟂ σ ≥ 0: the speed of sliding is σ, and the force is
//! opposite to it. All of it is λ = T z + t, M = Tᵀ A T + links, q = Tᵀ(A t + b) + …. Rows without bounds are equations:
//! they are marked `free` and eliminated before the pivoting. What goes wrong without: freezing μλ_n beforehand gives a
//! problem whose solution has another λ_n. Tests: `tests/lcp`.

use crate::lcp::box_lcp::BoxLcp;
use crate::lcp::matrix::Matrix;

/// y = M z + q with y ⟂ z for most variables, y = 0 for free ones; λ = T z + t.
pub(crate) struct Linear {
    pub m: Matrix,
    pub q: Vec<f64>,
    pub free: Vec<bool>,
    /// For each variable: the rows of λ that it is a part of.
    columns: Vec<Vec<(usize, f64)>>,
    /// λ where all variables are 0.
    offset: Vec<f64>,
    /// z = scale · (the z of `m` and `q`): rows of kilograms and of grams look alike to the pivoting.
    scale: Vec<f64>,
}

impl Linear {
    pub fn new(problem: &BoxLcp, corners: usize) -> Self {
        let mut builder = Builder { offset: vec![0.0; problem.len()], ..Builder::default() };
        for i in 0..problem.len() {
            match &problem.friction[i] {
                None => builder.add_row(i, problem.lower[i], problem.upper[i]),
                Some(f) if f.partner.is_none() => builder.add_friction(i, vec![vec![(i, 1.0)], vec![(i, -1.0)]]),
                Some(f) => {
                    if let Some(j) = f.partner.filter(|&j| j > i) {
                        builder.add_friction(i, polygon(i, j, corners));
                    }
                }
            }
        }
        builder.finish(problem)
    }

    /// λ = T z + t.
    pub fn lambda(&self, z: &[f64]) -> Vec<f64> {
        let mut lambda = self.offset.clone();
        for ((column, z), scale) in self.columns.iter().zip(z).zip(&self.scale) {
            for &(row, factor) in column {
                lambda[row] += factor * scale * z;
            }
        }
        lambda
    }
}

/// Unit vectors at equal angles in the plane of two rows.
fn polygon(i: usize, j: usize, corners: usize) -> Vec<Vec<(usize, f64)>> {
    let corners = corners.clamp(3, 10_000);
    let corner = |k: usize| {
        let angle = std::f64::consts::TAU * k as f64 / corners as f64;
        vec![(i, libm::cos(angle)), (j, libm::sin(angle))]
    };
    (0..corners).map(corner).collect()
}

#[derive(Default)]
struct Builder {
    columns: Vec<Vec<(usize, f64)>>,
    free: Vec<bool>,
    offset: Vec<f64>,
    /// (range variable, its z, range).
    ranges: Vec<(usize, usize, f64)>,
    /// (σ, its βs, a row of the friction).
    slips: Vec<(usize, Vec<usize>, usize)>,
}

impl Builder {
    fn add(&mut self, column: Vec<(usize, f64)>, free: bool) -> usize {
        self.columns.push(column);
        self.free.push(free);
        self.columns.len() - 1
    }

    fn add_row(&mut self, i: usize, lower: f64, upper: f64) {
        if lower == upper {
            // λ is known and w may be anything: no unknown.
            self.offset[i] = lower;
        } else if lower.is_finite() {
            self.offset[i] = lower;
            let z = self.add(vec![(i, 1.0)], false);
            if upper.is_finite() {
                let v = self.add(Vec::new(), false);
                self.ranges.push((v, z, upper - lower));
            }
        } else if upper.is_finite() {
            self.offset[i] = upper;
            self.add(vec![(i, -1.0)], false);
        } else {
            self.add(vec![(i, 1.0)], true);
        }
    }

    fn add_friction(&mut self, row: usize, directions: Vec<Vec<(usize, f64)>>) {
        let betas = directions.into_iter().map(|d| self.add(d, false)).collect();
        let sigma = self.add(Vec::new(), false);
        self.slips.push((sigma, betas, row));
    }

    fn finish(self, problem: &BoxLcp) -> Linear {
        let n = self.columns.len();
        let dot = |column: &[(usize, f64)], v: &[f64]| column.iter().map(|&(row, f)| f * v[row]).sum::<f64>();
        let mut m = Matrix::zeros(n, n);
        for (k, column) in self.columns.iter().enumerate() {
            // A T_k, then each Tᵢᵀ of it.
            let mut image = vec![0.0; problem.len()];
            for &(row, factor) in column {
                for (i, x) in image.iter_mut().enumerate() {
                    *x += factor * problem.a[(i, row)];
                }
            }
            for (i, other) in self.columns.iter().enumerate() {
                m[(i, k)] = dot(other, &image);
            }
        }
        let w = problem.w(&self.offset);
        let mut q: Vec<f64> = self.columns.iter().map(|column| dot(column, &w)).collect();
        for &(v, z, range) in &self.ranges {
            (m[(z, v)], m[(v, z)], q[v]) = (1.0, -1.0, range);
        }
        for (sigma, betas, row) in &self.slips {
            for &beta in betas {
                (m[(beta, *sigma)], m[(*sigma, beta)]) = (1.0, -1.0);
            }
            let Some(friction) = &problem.friction[*row] else { continue };
            for &normal in &friction.normals {
                q[*sigma] += friction.coefficient * self.offset[normal];
                for (k, column) in self.columns.iter().enumerate() {
                    let part: f64 = column.iter().filter(|(row, _)| *row == normal).map(|(_, f)| f).sum();
                    m[(*sigma, k)] += friction.coefficient * part;
                }
            }
        }
        let scale = self.scale(&m);
        for i in 0..n {
            q[i] *= scale[i];
            for (x, s) in m.row_mut(i).iter_mut().zip(&scale) {
                *x *= scale[i] * s;
            }
        }
        Linear { m, q, free: self.free, columns: self.columns, offset: self.offset, scale }
    }

    /// 1/√(diagonal) for parts of λ, the inverse for what is linked to them.
    fn scale(&self, m: &Matrix) -> Vec<f64> {
        let mut scale: Vec<f64> =
            (0..m.rows()).map(|k| if m[(k, k)] > 0.0 { 1.0 / m[(k, k)].sqrt() } else { 1.0 }).collect();
        for &(v, z, _) in &self.ranges {
            scale[v] = 1.0 / scale[z];
        }
        for (sigma, betas, _) in &self.slips {
            scale[*sigma] = 1.0 / scale[betas[0]];
        }
        scale
    }
}
