//! Equality rows of a joint, solved together.
//!
//! The rows of one joint share two bodies and are strongly coupled: for a light bob on a long arm the condition
//! of J M⁻¹Jᵀ is (1 + m r²/I) ≈ 1000, and Gauss–Seidel over its three rows would crawl. A block is a run of up to
//! six hard rows without bounds; K = J M⁻¹Jᵀ is factored before the sweeps and after the motion as LDLᵀ, and
//! Δλ = −K⁻¹ w. A row whose pivot vanishes (both bodies are locked along it, or two rows ask for the same) is left out.
//! Ends of ranges are rows of their own, visited with the block of their joint (`reference.rs`).
//! Proved by `tests/smoke.rs` (a pendulum keeps its length) and the unit tests here.

use crate::constraint::friction::Coupling;
use crate::solver::table::{Row, SolverBody, inner};

/// Rows in a block at most: a rigid connection has six.
pub const MAX_BLOCK: usize = 6;
/// A pivot below this part of its diagonal is rounding.
const TINY_PIVOT: f32 = 1e-5;

/// Rows `first .. first + count` of a joint and the factors of their K.
#[derive(Clone, Copy, Debug)]
pub struct Block {
    /// Index of the first row.
    pub first: u32,
    /// How many.
    pub count: u32,
    /// Unit lower triangle L, below the diagonal.
    lower: [[f32; MAX_BLOCK]; MAX_BLOCK],
    /// It is solved with a tree of joints, not alone.
    pub in_tree: bool,
    /// Which one.
    pub tree: u32,
    /// 1/D; 0 for rows left out.
    inverse_pivots: [f32; MAX_BLOCK],
}

/// Gathers runs of hard unbounded rows among `rows[first..]` into blocks and marks them.
pub fn gather(first: usize, rows: &mut [Row], blocks: &mut Vec<Block>) {
    let mut start = first;
    while start < rows.len() {
        let run = rows[start..].iter().take(MAX_BLOCK).take_while(|r| r.is_hard_equality()).count();
        if run > 0 {
            let block = Block {
                first: start as u32,
                count: run as u32,
                in_tree: false,
                tree: 0,
                lower: [[0.0; MAX_BLOCK]; MAX_BLOCK],
                inverse_pivots: [0.0; MAX_BLOCK],
            };
            rows[start].coupling = Coupling::Block(blocks.len() as u32);
            for row in &mut rows[start + 1..start + run] {
                row.coupling = Coupling::Partner;
            }
            blocks.push(block);
        }
        start += run.max(1);
    }
    if rows[first..].iter().any(|row| matches!(row.coupling, Coupling::Block(_))) {
        for row in rows[first..].iter_mut().filter(|row| row.is_limit()) {
            row.coupling = Coupling::Limit(blocks.len() as u32 - 1);
        }
    }
}

impl Block {
    /// K = L D Lᵀ for the responses as they are.
    pub fn factor(&mut self, rows: &[Row]) {
        let rows = &rows[self.first as usize..][..self.count as usize];
        let mut pivots = [0.0_f32; MAX_BLOCK];
        for i in 0..rows.len() {
            for j in 0..=i {
                let mut sum = inner(&rows[i].jacobian, &rows[j].response);
                let diagonal = sum;
                for (k, pivot) in pivots.iter().enumerate().take(j) {
                    sum -= self.lower[i][k] * pivot * self.lower[j][k];
                }
                if i == j {
                    let usable = sum > TINY_PIVOT * diagonal;
                    pivots[i] = if usable { sum } else { 0.0 };
                    self.inverse_pivots[i] = if usable { 1.0 / sum } else { 0.0 };
                } else {
                    self.lower[i][j] = sum * self.inverse_pivots[j];
                }
            }
        }
    }

    /// x = K⁻¹ x.
    fn substitute(&self, x: &mut [f32; MAX_BLOCK]) {
        let count = self.count as usize;
        for i in 0..count {
            x[i] -= (0..i).map(|k| self.lower[i][k] * x[k]).sum::<f32>();
        }
        for i in (0..count).rev() {
            x[i] *= self.inverse_pivots[i];
            x[i] -= (i + 1..count).map(|k| self.lower[k][i] * x[k]).sum::<f32>();
            if self.inverse_pivots[i] == 0.0 {
                x[i] = 0.0;
            }
        }
    }

    /// J M⁻¹Jᵀ of a row between the same two bodies with what the block leaves of M⁻¹: K_ll − K_lb K⁻¹ K_bl.
    pub fn free_part(&self, row: &Row, rows: &[Row]) -> f32 {
        let rows = &rows[self.first as usize..][..self.count as usize];
        let mut coupling = [0.0_f32; MAX_BLOCK];
        for (c, other) in coupling.iter_mut().zip(rows) {
            *c = inner(&other.jacobian, &row.response);
        }
        let mut x = coupling;
        self.substitute(&mut x);
        inner(&row.jacobian, &row.response) - coupling.iter().zip(x).map(|(c, x)| c * x).sum::<f32>()
    }

    /// Δλ = −K⁻¹ (J u + bias), u += M⁻¹Jᵀ Δλ.
    pub fn solve(&self, rows: &mut [Row], bodies: &mut [SolverBody]) {
        let rows = &mut rows[self.first as usize..][..self.count as usize];
        let mut x = [0.0_f32; MAX_BLOCK];
        for (x, row) in x.iter_mut().zip(rows.iter()) {
            *x = row.velocity(bodies) + row.bias;
        }
        self.substitute(&mut x);
        for (row, x) in rows.iter_mut().zip(x) {
            row.lambda -= x;
            row.apply(bodies, -x);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constraint::row::{Jacobian, RowSpec};
    use crate::math::{Mat3, Vec3};

    fn bob() -> Vec<SolverBody> {
        let mut body = SolverBody::GROUND;
        body.inverse_mass = Vec3::ONE;
        body.inverse_inertia = Mat3::from_diagonal(Vec3::splat(1000.0));
        body.velocity = Vec3::new(0.3, -1.0, 2.0);
        body.angular_velocity = Vec3::new(1.0, 4.0, -2.0);
        vec![SolverBody::GROUND, body]
    }

    fn point(arm: Vec3, axes: &[Vec3]) -> Vec<Row> {
        let spec = |axis: &Vec3| RowSpec::equality(Jacobian::point(*axis, Vec3::ZERO, arm), 0.0);
        axes.iter().map(|axis| Row::of_joint(&spec(axis), 0, 1, 0.0)).collect()
    }

    fn solve_once(rows: &mut [Row], bodies: &mut [SolverBody]) {
        let mut blocks = Vec::new();
        gather(0, rows, &mut blocks);
        for row in rows.iter_mut() {
            row.refresh_mass(bodies);
        }
        assert_eq!(blocks.len(), 1);
        blocks[0].factor(rows);
        blocks[0].solve(rows, bodies);
    }

    #[test]
    fn one_visit_stops_an_ill_conditioned_point() {
        let (mut bodies, mut rows) = (bob(), point(Vec3::new(0.6, -0.5, 0.4), &[Vec3::X, Vec3::Y, Vec3::Z]));
        solve_once(&mut rows, &mut bodies);
        for row in &rows {
            assert!(row.velocity(&bodies).abs() < 1e-4, "{}", row.velocity(&bodies));
        }
    }

    #[test]
    fn a_row_that_says_nothing_new_is_left_out() {
        let (mut bodies, mut rows) = (bob(), point(Vec3::X, &[Vec3::X, Vec3::X, Vec3::Y]));
        solve_once(&mut rows, &mut bodies);
        assert!(rows.iter().all(|r| r.lambda.is_finite() && r.velocity(&bodies).abs() < 1e-4));
    }
}
