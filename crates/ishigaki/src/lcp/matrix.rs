//! A small dense matrix of f64, row by row, and its elimination with partial pivoting.

use std::ops::{Index, IndexMut};

/// A dense matrix; `m[(i, j)]` is row i, column j.
#[derive(Clone, Debug, PartialEq)]
pub struct Matrix {
    rows: usize,
    columns: usize,
    data: Vec<f64>,
}

impl Matrix {
    /// All zeros.
    pub fn zeros(rows: usize, columns: usize) -> Self {
        Self { rows, columns, data: vec![0.0; rows * columns] }
    }

    /// Each entry from its row and column.
    pub fn from_fn(rows: usize, columns: usize, mut entry: impl FnMut(usize, usize) -> f64) -> Self {
        let mut m = Self::zeros(rows, columns);
        for i in 0..rows {
            for j in 0..columns {
                m[(i, j)] = entry(i, j);
            }
        }
        m
    }

    /// How many rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// How many columns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// One row.
    pub fn row(&self, i: usize) -> &[f64] {
        &self.data[i * self.columns..(i + 1) * self.columns]
    }

    /// One row, to be changed.
    pub fn row_mut(&mut self, i: usize) -> &mut [f64] {
        &mut self.data[i * self.columns..(i + 1) * self.columns]
    }

    /// Row i times x.
    pub fn row_times(&self, i: usize, x: &[f64]) -> f64 {
        self.row(i).iter().zip(x).map(|(a, x)| a * x).sum()
    }

    /// The matrix times x.
    pub fn times(&self, x: &[f64]) -> Vec<f64> {
        (0..self.rows).map(|i| self.row_times(i, x)).collect()
    }

    /// The entries of `rows` × `columns`.
    #[must_use]
    pub fn part(&self, rows: &[usize], columns: &[usize]) -> Self {
        Self::from_fn(rows.len(), columns.len(), |i, j| self[(rows[i], columns[j])])
    }

    /// Greatest |entry − transposed entry| relative to the greatest entry; 0 for symmetric matrices.
    pub fn asymmetry(&self) -> f64 {
        let greatest = self.data.iter().fold(0.0_f64, |m, a| m.max(a.abs()));
        let mut difference = 0.0_f64;
        for i in 0..self.rows.min(self.columns) {
            for j in 0..i {
                difference = difference.max((self[(i, j)] - self[(j, i)]).abs());
            }
        }
        if greatest > 0.0 { difference / greatest } else { 0.0 }
    }

    /// row(to) += factor · row(from) from column `first` on, from ≠ to.
    pub(crate) fn add_row(&mut self, to: usize, factor: f64, from: usize, first: usize) {
        let n = self.columns;
        let (low, high) = self.data.split_at_mut(to.max(from) * n);
        let (a, b) = (&mut low[to.min(from) * n..][..n], &mut high[..n]);
        let (target, source) = if to < from { (a, b) } else { (b, a) };
        for (t, s) in target[first..].iter_mut().zip(&source[first..]) {
            *t += factor * *s;
        }
    }

    /// x with M x = y, or `None` where the matrix is singular to rounding. Gaussian elimination with partial
    /// pivoting and one step of iterative refinement.
    pub fn solve(&self, y: &[f64]) -> Option<Vec<f64>> {
        let factors = self.factor()?;
        let mut x = factors.solve(y);
        let rest: Vec<f64> = self.times(&x).iter().zip(y).map(|(mx, y)| y - mx).collect();
        x.iter_mut().zip(factors.solve(&rest)).for_each(|(x, d)| *x += d);
        x.iter().all(|x| x.is_finite()).then_some(x)
    }

    /// P M = L U, or `None` where a pivot is below rounding.
    fn factor(&self) -> Option<Factors> {
        let n = self.rows;
        let mut lu = self.clone();
        let mut order: Vec<usize> = (0..n).collect();
        for k in 0..n {
            // Column by column: rows of kilograms and of grams may meet in one matrix.
            let greatest = (0..n).fold(0.0_f64, |m, i| m.max(self[(i, k)].abs()));
            let pivot = (k..n).max_by(|&i, &j| lu[(i, k)].abs().total_cmp(&lu[(j, k)].abs()))?;
            if lu[(pivot, k)].abs() <= 1e-13 * greatest {
                return None;
            }
            if pivot != k {
                order.swap(k, pivot);
                for j in 0..n {
                    (lu[(k, j)], lu[(pivot, j)]) = (lu[(pivot, j)], lu[(k, j)]);
                }
            }
            for i in k + 1..n {
                let factor = lu[(i, k)] / lu[(k, k)];
                // L keeps its factors on the left of the diagonal: only what is right of it changes.
                lu.add_row(i, -factor, k, k + 1);
                lu[(i, k)] = factor;
            }
        }
        Some(Factors { lu, order })
    }
}

/// L, U in one square and the order of the rows.
struct Factors {
    lu: Matrix,
    order: Vec<usize>,
}

impl Factors {
    fn solve(&self, y: &[f64]) -> Vec<f64> {
        let n = self.order.len();
        let mut x: Vec<f64> = self.order.iter().map(|&i| y[i]).collect();
        for i in 0..n {
            x[i] -= (0..i).map(|j| self.lu[(i, j)] * x[j]).sum::<f64>();
        }
        for i in (0..n).rev() {
            x[i] -= (i + 1..n).map(|j| self.lu[(i, j)] * x[j]).sum::<f64>();
            x[i] /= self.lu[(i, i)];
        }
        x
    }
}

impl Index<(usize, usize)> for Matrix {
    type Output = f64;

    fn index(&self, (i, j): (usize, usize)) -> &f64 {
        &self.data[i * self.columns + j]
    }
}

impl IndexMut<(usize, usize)> for Matrix {
    fn index_mut(&mut self, (i, j): (usize, usize)) -> &mut f64 {
        &mut self.data[i * self.columns + j]
    }
}
