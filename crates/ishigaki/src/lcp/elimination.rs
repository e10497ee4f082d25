//! Rows without bounds are equations: they are solved for their λ before any pivoting. TALK C4.
//!
//! Gauss–Jordan over the free rows F, the greatest diagonal first: z_F = −M_FF⁻¹ (M_FR z_R + q_F), which leaves the
//! complementary rows an LCP with the Schur complement of M_FF, positive semidefinite where M is. Joints often say the same
//! twice (a closed loop): such a row is left over as 0 = 0, and its λ is 0; as 0 = 1 the problem is infeasible. What is
//! left over otherwise (it happens where A is not symmetric) becomes two rows, z⁺ and z⁻, with y ≥ 0 and −y ≥ 0.

use crate::lcp::matrix::Matrix;

/// Relative to a matrix scaled to a diagonal of 1.
const TINY: f64 = 1e-11;

/// An LCP without free rows and the way back.
pub(crate) struct Reduced {
    pub m: Matrix,
    pub q: Vec<f64>,
    /// For each variable of the reduced problem: which one it was, and its sign.
    variables: Vec<(usize, f64)>,
    /// z_j = −(row · z + q)/pivot, for the columns that were eliminated: (j, row of `work`).
    solved: Vec<(usize, usize)>,
    work: Matrix,
}

impl Reduced {
    /// `None` where the equations contradict each other.
    pub fn new(m: &Matrix, q: &[f64], free: &[bool]) -> Option<Self> {
        let n = q.len();
        let mut work = Matrix::from_fn(n, n + 1, |i, j| if j < n { m[(i, j)] } else { q[i] });
        let (mut rows, mut columns): (Vec<usize>, Vec<usize>) = (0..n).filter(|&i| free[i]).map(|i| (i, i)).unzip();
        let mut solved = Vec::new();
        while let Some((i, j)) = greatest(&work, &rows, &columns) {
            eliminate(&mut work, i, j);
            rows.retain(|&r| r != i);
            columns.retain(|&c| c != j);
            solved.push((j, i));
        }
        let mut kept: Vec<(usize, usize, f64)> = (0..n).filter(|&i| !free[i]).map(|i| (i, i, 1.0)).collect();
        let bounded: Vec<usize> = kept.iter().map(|k| k.0).collect();
        for (&i, &j) in rows.iter().zip(&columns) {
            let says_nothing = bounded.iter().all(|&k| work[(i, k)].abs() <= TINY && work[(k, j)].abs() <= TINY);
            if !says_nothing {
                kept.extend([(i, j, 1.0), (i, j, -1.0)]);
            } else if work[(i, n)].abs() > TINY.sqrt() * (1.0 + q.iter().fold(0.0_f64, |m, x| m.max(x.abs()))) {
                return None;
            }
        }
        let reduced =
            Matrix::from_fn(kept.len(), kept.len(), |a, b| kept[a].2 * kept[b].2 * work[(kept[a].0, kept[b].1)]);
        let q = kept.iter().map(|&(i, _, sign)| sign * work[(i, n)]).collect();
        Some(Self { m: reduced, q, variables: kept.iter().map(|&(_, j, s)| (j, s)).collect(), solved, work })
    }

    /// All z from those of the reduced problem.
    pub fn expand(&self, z: &[f64]) -> Vec<f64> {
        let n = self.work.rows();
        let mut all = vec![0.0; n];
        for (&(j, sign), z) in self.variables.iter().zip(z) {
            all[j] += sign * z;
        }
        // Eliminated columns are unit vectors: each equation gives its own z from those that are left.
        let given = all.clone();
        for &(j, i) in &self.solved {
            all[j] = -(self.work.row_times(i, &given) + self.work[(i, n)]);
        }
        all
    }
}

/// The best pivot among free rows and columns: a diagonal one if there is any.
fn greatest(work: &Matrix, rows: &[usize], columns: &[usize]) -> Option<(usize, usize)> {
    let best = |pairs: &mut dyn Iterator<Item = (usize, usize)>| {
        pairs.max_by(|&a, &b| work[a].abs().total_cmp(&work[b].abs())).filter(|&p| work[p].abs() > TINY)
    };
    let diagonal = best(&mut rows.iter().filter(|i| columns.contains(i)).map(|&i| (i, i)));
    diagonal.or_else(|| best(&mut rows.iter().flat_map(|&i| columns.iter().map(move |&j| (i, j)))))
}

/// Makes column j the unit vector of row i.
fn eliminate(work: &mut Matrix, i: usize, j: usize) {
    let pivot = work[(i, j)];
    work.row_mut(i).iter_mut().for_each(|x| *x /= pivot);
    for k in (0..work.rows()).filter(|&k| k != i) {
        let factor = work[(k, j)];
        if factor != 0.0 {
            work.add_row(k, -factor, i, 0);
            work[(k, j)] = 0.0;
        }
    }
}
