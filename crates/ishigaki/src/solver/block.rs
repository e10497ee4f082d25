//! Equality rows of a joint, solved together.
//!
//! The rows of one joint share two bodies and are strongly coupled: for a light bob on a long arm the condition
//! of J M⁻¹Jᵀ is (1 + m r²/I) ≈ 1000, and Gauss–Seidel over its three rows would crawl. A block is a run of up to
//! six hard rows without bounds; K = J M⁻¹Jᵀ is factored before the sweeps and after the motion as LDLᵀ, and
//! Δλ = −K⁻¹ w. A row whose pivot vanishes (both bodies are locked along it, or two rows ask for the same) is left out.
//! Ends of ranges are rows of their own, visited with the block of their joint (`reference.rs`).
//! Proved by `tests/smoke.rs` (a pendulum keeps its length) and the unit tests here.

use crate::constraint::friction::Coupling;
use crate::math::Vec3;
use crate::solver::table::{MassScale, Response, Row, SolverBody, inner, inner_at, response};
use crate::solver::work;

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
    /// Those of them, the first ones, that lie along the world axes x, y, z: three or none.
    pub axes: u32,
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
                axes: if is_point(&rows[start..start + run]) { 3 } else { 0 },
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

/// The first three rows lie along the world axes, of bodies as heavy as they are.
fn is_point(rows: &[Row]) -> bool {
    let lies_along = |(row, axis): (&Row, Vec3)| row.jacobian.linear == axis && row.scale == MassScale::ONE;
    rows.len() >= 3 && rows.iter().zip(Vec3::AXES).all(lies_along)
}

impl Block {
    fn range(&self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }

    fn ends<'a>(&self, rows: &[Row], bodies: &'a [SolverBody]) -> [&'a SolverBody; 2] {
        let row = &rows[self.first as usize];
        [&bodies[row.body_a as usize], &bodies[row.body_b as usize]]
    }

    /// Fills in M⁻¹Jᵀ of its rows.
    pub fn weigh(&self, rows: &mut [Row], bodies: &[SolverBody]) {
        let [a, b] = self.ends(rows, bodies);
        let rows = &mut rows[self.range()];
        let (points, others) = rows.split_at_mut(self.axes as usize);
        for (i, row) in points.iter_mut().enumerate() {
            let (mut linear_a, mut linear_b) = (Vec3::ZERO, Vec3::ZERO);
            (linear_a[i], linear_b[i]) = (a.inverse_mass[i], -b.inverse_mass[i]);
            let angular_a = a.inverse_inertia * row.jacobian.angular_a;
            let angular_b = b.inverse_inertia * row.jacobian.angular_b;
            row.response = Response { linear_a, angular_a, linear_b, angular_b };
        }
        for row in others {
            row.response = response(&row.jacobian, a, b, row.scale);
        }
    }

    /// J M⁻¹Jᵀ of rows `i` and `j`.
    pub fn inner(&self, i: usize, j: usize, rows: &[Row]) -> f32 {
        let rows = &rows[self.range()];
        let (row, other) = (&rows[i], &rows[j]);
        if i.max(j) >= self.axes as usize {
            return inner(&row.jacobian, &other.response);
        }
        let (jacobian, r) = (&row.jacobian, &other.response);
        let linear = if i == j { r.linear_a[i] - r.linear_b[i] } else { 0.0 };
        linear + jacobian.angular_a.dot(r.angular_a) + jacobian.angular_b.dot(r.angular_b)
    }

    /// The part of J M⁻¹J'ᵀ of its row `i` and row `j` of another block that runs through one body: the A or B of each.
    #[inline]
    pub fn inner_at(&self, i: usize, is_a: bool, other: &Self, j: usize, other_is_a: bool, rows: &[Row]) -> f32 {
        let (row, col) = (&rows[self.first as usize + i], &rows[other.first as usize + j]);
        if i >= self.axes as usize || j >= other.axes as usize {
            return inner_at(row, is_a, col, other_is_a);
        }
        let angular = if is_a { row.jacobian.angular_a } else { row.jacobian.angular_b };
        let r = &col.response;
        let (v, w) = if other_is_a { (r.linear_a, r.angular_a) } else { (r.linear_b, r.angular_b) };
        let linear = match (i == j, is_a) {
            (false, _) => 0.0,
            (true, true) => v[i],
            (true, false) => -v[i],
        };
        linear + angular.dot(w)
    }

    /// J u + bias.
    pub fn velocities(&self, rows: &[Row], bodies: &[SolverBody]) -> [f32; MAX_BLOCK] {
        let [a, b] = self.ends(rows, bodies);
        let (points, others) = rows[self.range()].split_at(self.axes as usize);
        let mut w = [0.0_f32; MAX_BLOCK];
        let relative = a.velocity - b.velocity;
        for (i, row) in points.iter().enumerate() {
            let j = &row.jacobian;
            let turning = relative[i] + j.angular_a.dot(a.angular_velocity) + j.angular_b.dot(b.angular_velocity);
            w[i] = turning + row.bias;
        }
        for (w, row) in w[points.len()..].iter_mut().zip(others) {
            *w = row.velocity(bodies) + row.bias;
        }
        w
    }

    /// u += M⁻¹Jᵀ Δλ.
    pub fn push(&self, change: &[f32; MAX_BLOCK], rows: &[Row], bodies: &mut [SolverBody]) {
        let (points, others) = rows[self.range()].split_at(self.axes as usize);
        if let [x, ..] = points {
            let impulse = Vec3::new(change[0], change[1], change[2]);
            let a = &mut bodies[x.body_a as usize];
            a.velocity += a.inverse_mass * impulse;
            for (row, &change) in points.iter().zip(change) {
                a.angular_velocity += row.response.angular_a * change;
            }
            let b = &mut bodies[x.body_b as usize];
            b.velocity -= b.inverse_mass * impulse;
            for (row, &change) in points.iter().zip(change) {
                b.angular_velocity += row.response.angular_b * change;
            }
        }
        for (row, &change) in others.iter().zip(&change[points.len()..]) {
            row.apply(bodies, change);
        }
    }

    /// u += M⁻¹Jᵀλ.
    pub fn push_all(&self, rows: &[Row], bodies: &mut [SolverBody]) {
        let mut lambda = [0.0; MAX_BLOCK];
        for (lambda, row) in lambda.iter_mut().zip(&rows[self.range()]) {
            *lambda = row.lambda;
        }
        self.push(&lambda, rows, bodies);
    }

    /// Adds x to λ and pushes.
    pub fn add(&self, x: &[f32; MAX_BLOCK], rows: &mut [Row], bodies: &mut [SolverBody]) {
        for (row, x) in rows[self.range()].iter_mut().zip(x) {
            row.lambda += x;
        }
        self.push(x, rows, bodies);
    }

    /// Rows, and those of them that are a point's, for the account of work.
    pub fn size(&self) -> work::Size {
        work::Size { rows: self.count.into(), axes: self.axes.into() }
    }

    /// K = L D Lᵀ for the responses as they are.
    pub fn factor(&mut self, rows: &[Row]) {
        let mut pivots = [0.0_f32; MAX_BLOCK];
        for i in 0..self.count as usize {
            for j in 0..=i {
                let mut sum = self.inner(i, j, rows);
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
        self.step(1.0, rows, bodies);
    }

    /// The same, `factor` times as far.
    pub fn step(&self, factor: f32, rows: &mut [Row], bodies: &mut [SolverBody]) {
        let mut x = self.velocities(rows, bodies);
        self.substitute(&mut x);
        self.add(&x.map(|x| -(factor * x)), rows, bodies);
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
        assert_eq!(blocks.len(), 1);
        blocks[0].weigh(rows, bodies);
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
    fn a_point_does_what_its_rows_do() {
        let mut bodies = bob();
        let arm = Vec3::new(-0.2, 0.7, 0.1);
        bodies.push(SolverBody {
            velocity: Vec3::new(-1.5, 0.2, 0.4),
            angular_velocity: Vec3::new(0.3, -2.0, 1.0),
            inverse_mass: Vec3::new(0.25, 0.0, 0.25),
            inverse_inertia: Mat3::from_diagonal(Vec3::new(2.0, 3.0, 5.0)),
            ..SolverBody::GROUND
        });
        let spec =
            |axis: Vec3, bias: f32| RowSpec::equality(Jacobian::point(axis, arm, Vec3::new(0.6, -0.5, 0.4)), bias);
        let axis = Vec3::new(0.6, 0.8, 0.0);
        let specs = [
            spec(Vec3::X, 0.1),
            spec(Vec3::Y, -0.2),
            spec(Vec3::Z, 0.3),
            RowSpec::equality(Jacobian::rotation(axis), 0.4),
        ];
        let mut rows: Vec<Row> = specs.iter().map(|spec| Row::of_joint(spec, 1, 2, 0.7)).collect();
        let mut blocks = Vec::new();
        gather(0, &mut rows, &mut blocks);
        let point = blocks[0];
        let general = Block { axes: 0, ..point };
        assert_eq!((point.count, point.axes), (4, 3));

        let mut by_rows = rows.clone();
        point.weigh(&mut rows, &bodies);
        general.weigh(&mut by_rows, &bodies);
        for (row, other) in rows.iter().zip(&by_rows) {
            assert_eq!(row.response, other.response);
        }
        for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
            assert_eq!(point.inner(i, j, &rows), general.inner(i, j, &rows), "{i} {j}");
            for (is_a, other_is_a) in [(true, true), (true, false), (false, true), (false, false)] {
                let inner = |block: &Block| block.inner_at(i, is_a, block, j, other_is_a, &rows);
                assert_eq!(inner(&point), inner(&general), "{i} {j} {is_a} {other_is_a}");
            }
        }
        assert_eq!(point.velocities(&rows, &bodies), general.velocities(&rows, &bodies));
        let mut others = bodies.clone();
        point.push_all(&rows, &mut bodies);
        general.push_all(&rows, &mut others);
        for (body, other) in bodies.iter().zip(&others) {
            assert_eq!((body.velocity, body.angular_velocity), (other.velocity, other.angular_velocity));
        }
    }

    #[test]
    fn a_step_of_omega_leaves_one_less_omega_of_the_error() {
        for factor in [0.5, 1.0, 1.6, 1.9] {
            let (mut bodies, mut rows) = (bob(), point(Vec3::new(0.6, -0.5, 0.4), &[Vec3::X, Vec3::Y, Vec3::Z]));
            let before: Vec<f32> = rows.iter().map(|row| row.velocity(&bodies)).collect();
            let mut blocks = Vec::new();
            gather(0, &mut rows, &mut blocks);
            blocks[0].weigh(&mut rows, &bodies);
            blocks[0].factor(&rows);
            blocks[0].step(factor, &mut rows, &mut bodies);
            for (row, before) in rows.iter().zip(before) {
                let left = row.velocity(&bodies);
                assert!((left - (1.0 - factor) * before).abs() < 1e-4, "ω = {factor}: {before} to {left}");
            }
        }
    }

    #[test]
    fn a_row_that_says_nothing_new_is_left_out() {
        let (mut bodies, mut rows) = (bob(), point(Vec3::X, &[Vec3::X, Vec3::X, Vec3::Y]));
        solve_once(&mut rows, &mut bodies);
        assert!(rows.iter().all(|r| r.lambda.is_finite() && r.velocity(&bodies).abs() < 1e-4));
    }
}
