//! Rows of a block: from the velocities of bodies to those along rows, and from impulses back.
//!
//! Between round bodies (balls, cubes) I^−½ is a number, J' of all three rows of a point comes from the arm r' = I^−½ r:
//! (r' × d)·ω' along each direction d. Their blocks are a third smaller.

use super::{ContactBlock, Masses, TangentLanes, many};
use crate::solver::wide::lanes::{Lane3, Sides, V3, splat};
use fearless_simd::f32x8;
use fearless_simd::prelude::*;

/// J' of one row for rotations of A and B.
#[derive(Clone, Copy)]
pub struct RowLanes<S: Simd> {
    pub angular_a: V3<S>,
    pub angular_b: V3<S>,
}

impl<S: Simd> RowLanes<S> {
    /// J M⁻¹Jᵀ of two rows along the same direction.
    #[inline(always)]
    pub fn inner(&self, o: &Self, m: &Masses<S>) -> f32x8<S> {
        m.linear() + self.inner_across(o, m)
    }

    /// The same along directions that are square to each other.
    #[inline(always)]
    pub fn inner_across(&self, o: &Self, m: &Masses<S>) -> f32x8<S> {
        self.angular_a.dot(o.angular_a) * m.inertia_a + self.angular_b.dot(o.angular_b) * m.inertia_b
    }

    /// What rotations add to w = J'u'.
    #[inline(always)]
    pub fn turning(&self, sides: &Sides<S>) -> f32x8<S> {
        self.angular_a.dot(sides.angular_a) + self.angular_b.dot(sides.angular_b)
    }

    /// The part of u' += M'⁻¹J'ᵀΔλ that rotations take.
    #[inline(always)]
    pub fn turn(&self, delta: f32x8<S>, m: &Masses<S>, sides: &mut Sides<S>) {
        sides.angular_a = sides.angular_a.plus(self.angular_a.times(delta * m.inertia_a));
        sides.angular_b = sides.angular_b.plus(self.angular_b.times(delta * m.inertia_b));
    }
}

#[inline(always)]
pub fn row_of<S: Simd>(simd: S, angular_a: &Lane3, angular_b: &Lane3) -> RowLanes<S> {
    RowLanes { angular_a: V3::load(simd, angular_a), angular_b: V3::load(simd, angular_b) }
}

/// J'u' of the normal rows; `relative` is v_A − v_B.
#[inline(always)]
pub fn normal_velocities<S: Simd, const N: usize>(
    simd: S,
    block: &ContactBlock,
    tangents: Option<&TangentLanes>,
    n: V3<S>,
    relative: V3<S>,
    sides: &Sides<S>,
) -> [f32x8<S>; N] {
    let along = n.dot(relative);
    let (mut of_a, mut of_b) = (sides.angular_a, sides.angular_b);
    if tangents.is_none() {
        // n·(ω' × r') = r'·(n × ω')
        (of_a, of_b) = (n.cross(of_a), of_b.cross(n));
    }
    let mut w = [along; N];
    for i in 0..many::<N>(block.size) {
        let p = &block.points[i];
        let (a, b) = (V3::load(simd, &p.angular_a), V3::load(simd, &p.angular_b));
        w[i] = along + a.dot(of_a) + b.dot(of_b);
    }
    w
}

/// The rotations of u' += M'⁻¹J'ᵀΔλ of the normal rows; ΣΔλ, the push along the normal.
#[inline(always)]
pub fn turn_by_normals<S: Simd, const N: usize>(
    simd: S,
    block: &ContactBlock,
    tangents: Option<&TangentLanes>,
    n: V3<S>,
    change: &[f32x8<S>; N],
    m: &Masses<S>,
    sides: &mut Sides<S>,
) -> f32x8<S> {
    let zero = splat(simd, 0.0);
    let mut sum = zero;
    let zero = V3 { x: zero, y: zero, z: zero };
    let (mut turn_a, mut turn_b) = if tangents.is_some() { (sides.angular_a, sides.angular_b) } else { (zero, zero) };
    for i in 0..many::<N>(block.size) {
        let p = &block.points[i];
        sum += change[i];
        turn_a = turn_a.plus(V3::load(simd, &p.angular_a).times(change[i] * m.inertia_a));
        turn_b = turn_b.plus(V3::load(simd, &p.angular_b).times(change[i] * m.inertia_b));
    }
    if tangents.is_none() {
        (turn_a, turn_b) = (sides.angular_a.plus(turn_a.cross(n)), sides.angular_b.plus(n.cross(turn_b)));
    }
    (sides.angular_a, sides.angular_b) = (turn_a, turn_b);
    sum
}

/// u' += M'⁻¹J'ᵀλ of all rows of a point; `lambda` is along the normal and the tangents.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "a kernel takes the arrays of a batch")]
pub fn push_all<S: Simd>(
    simd: S,
    block: &ContactBlock,
    tangents: Option<&TangentLanes>,
    i: usize,
    [n, t1, t2]: [V3<S>; 3],
    lambda: [f32x8<S>; 3],
    m: &Masses<S>,
    sides: &mut Sides<S>,
) {
    let impulse = n.times(lambda[0]).plus(t1.times(lambda[1])).plus(t2.times(lambda[2]));
    push_along(impulse, m, sides);
    if let Some(lanes) = tangents {
        let p = &block.points[i];
        row_of(simd, &p.angular_a, &p.angular_b).turn(lambda[0], m, sides);
        tangent_row(simd, lanes, i, 0).turn(lambda[1], m, sides);
        tangent_row(simd, lanes, i, 1).turn(lambda[2], m, sides);
    } else {
        turn_round(simd, block, i, impulse, m, sides);
    }
}

/// J'u' of the tangent rows of a point, where `speed` is that of v_A − v_B along the tangents.
#[inline(always)]
pub fn point_velocity<S: Simd>(
    simd: S,
    block: &ContactBlock,
    tangents: Option<&TangentLanes>,
    i: usize,
    t: [V3<S>; 2],
    speed: [f32x8<S>; 2],
    sides: &Sides<S>,
) -> [f32x8<S>; 2] {
    match tangents {
        Some(lanes) => {
            let rows = [tangent_row(simd, lanes, i, 0), tangent_row(simd, lanes, i, 1)];
            [speed[0] + rows[0].turning(sides), speed[1] + rows[1].turning(sides)]
        }
        None => {
            let p = &block.points[i];
            let (a, b) = (V3::load(simd, &p.angular_a), V3::load(simd, &p.angular_b));
            let v = sides.angular_a.cross(a).minus(sides.angular_b.cross(b));
            [speed[0] + t[0].dot(v), speed[1] + t[1].dot(v)]
        }
    }
}

/// u' += M'⁻¹J'ᵀΔλ of the tangent rows of a point, but for the linear part, which all points share: [`Sliding`].
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "a kernel takes the arrays of a batch")]
pub fn turn_point<S: Simd>(
    simd: S,
    block: &ContactBlock,
    tangents: Option<&TangentLanes>,
    i: usize,
    t: [V3<S>; 2],
    change: [f32x8<S>; 2],
    m: &Masses<S>,
    sides: &mut Sides<S>,
) {
    match tangents {
        Some(lanes) => {
            for k in 0..2 {
                tangent_row(simd, lanes, i, k).turn(change[k], m, sides);
            }
        }
        None => {
            let impulse = t[0].times(change[0]).plus(t[1].times(change[1]));
            turn_round(simd, block, i, impulse, m, sides);
        }
    }
}

/// The linear part of friction while the points of a manifold are visited: along the tangents velocities of both bodies differ
/// by two numbers for all points.
pub struct Sliding<S: Simd> {
    /// v_A − v_B along the tangents, m/s.
    pub speed: [f32x8<S>; 2],
    /// ΣΔλ, N·s.
    pub impulse: [f32x8<S>; 2],
    /// What an impulse adds to the speed, 1/kg.
    mass: f32x8<S>,
}

impl<S: Simd> Sliding<S> {
    /// Before the first point; `relative` is v_A − v_B.
    #[inline(always)]
    pub fn new(simd: S, t: [V3<S>; 2], m: &Masses<S>, relative: V3<S>) -> Self {
        Self { speed: [t[0].dot(relative), t[1].dot(relative)], impulse: [splat(simd, 0.0); 2], mass: m.linear() }
    }

    /// Impulses of a point.
    #[inline(always)]
    pub fn add(&mut self, change: [f32x8<S>; 2]) {
        for k in 0..2 {
            self.speed[k] += self.mass * change[k];
            self.impulse[k] += change[k];
        }
    }

    /// v of both bodies, by all of them and by `normal`, the impulse along the normal.
    #[inline(always)]
    pub fn push(self, [n, t1, t2]: [V3<S>; 3], normal: f32x8<S>, m: &Masses<S>, sides: &mut Sides<S>) {
        let sliding = t1.times(self.impulse[0]).plus(t2.times(self.impulse[1]));
        push_along(n.times(normal).plus(sliding), m, sides);
    }
}

/// v of both bodies by an impulse on A and back on B.
#[inline(always)]
fn push_along<S: Simd>(impulse: V3<S>, m: &Masses<S>, sides: &mut Sides<S>) {
    sides.linear_a = sides.linear_a.plus(impulse.times(m.push_a));
    sides.linear_b = sides.linear_b.minus(impulse.times(m.push_b));
}

/// The rotations of round bodies by an impulse on A at a point, and back on B.
#[inline(always)]
fn turn_round<S: Simd>(simd: S, block: &ContactBlock, i: usize, impulse: V3<S>, m: &Masses<S>, sides: &mut Sides<S>) {
    let p = &block.points[i];
    let (a, b) = (V3::load(simd, &p.angular_a), V3::load(simd, &p.angular_b));
    sides.angular_a = sides.angular_a.plus(a.cross(impulse.times(m.inertia_a)));
    sides.angular_b = sides.angular_b.minus(b.cross(impulse.times(m.inertia_b)));
}

#[inline(always)]
fn tangent_row<S: Simd>(simd: S, lanes: &TangentLanes, i: usize, k: usize) -> RowLanes<S> {
    row_of(simd, &lanes.angular_a[i][k], &lanes.angular_b[i][k])
}
