//! Eight manifolds side by side: their rows, and the visit of a sweep. DESIGN, "Fast path".
//!
//! Bodies move in mass-weighted velocities u' = M^½u, rows see them through J' = J M^−½: J M⁻¹Jᵀ = J'J'ᵀ, and one
//! Jacobian both reads (w = J'u') and pushes (u' += J'ᵀΔλ). A visit is that of `manifold_block.rs` in the reference:
//! normals several times against each other through K = J'J'ᵀ, then the friction disk of each point, with the bound
//! that the normals give. The lanes of a block share no body that moves.
//! No closures in here: the compiler does not give them the machine's wide instructions, and where one is not inlined
//! each operation becomes a call.
//! Held to the reference by `tests/wide.rs`.
#![expect(clippy::needless_range_loop, reason = "kernels walk several arrays of points in step")]

use crate::solver::penetration_recovery::Recovery;
use crate::solver::wide::lanes::{LANES, Lane, Lane3, Record, Sides, V3, load, positive, splat, store};
use fearless_simd::f32x8;
use fearless_simd::prelude::*;

/// Points of a manifold.
pub const POINTS: usize = 4;
const ZERO: Lane = [0.0; LANES];
const ZERO3: Lane3 = [ZERO; 3];

/// Points of the manifolds of a block, at most. Balls and edges would pay for faces otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Size {
    /// Balls.
    One,
    /// Edges.
    Two,
    /// Faces.
    Four,
}

impl Size {
    /// All of them, the smallest first.
    pub const ALL: [Self; 3] = [Self::One, Self::Two, Self::Four];

    /// The smallest that holds a manifold.
    pub fn of(points: usize) -> Self {
        match points {
            0 | 1 => Self::One,
            2 => Self::Two,
            _ => Self::Four,
        }
    }

    /// How many points.
    pub fn points(self) -> usize {
        match self {
            Self::One => 1,
            Self::Two => 2,
            Self::Four => POINTS,
        }
    }
}

/// A kernel made for the size of the block: its loops have a known length.
macro_rules! by_size {
    ($size:expr, $n:ident => $call:expr) => {
        match $size {
            Size::One => {
                const $n: usize = 1;
                $call
            }
            Size::Two => {
                const $n: usize = 2;
                $call
            }
            Size::Four => {
                const $n: usize = POINTS;
                $call
            }
        }
    };
}

mod prepare;
mod visit;

pub use prepare::{prepare, reweigh};
pub use visit::{Unrest, inspect, visit};

/// One point of eight manifolds.
#[derive(Clone, Copy, Debug)]
pub struct PointLanes {
    /// J' of the normal row for rotations of A; while blocks are filled, the arm on A, m.
    pub angular_a: Lane3,
    /// Of B.
    pub angular_b: Lane3,
    /// J'J'ᵀ of the normal row, 1/kg.
    pub k: Lane,
    /// Its inverse, kg; 0 where there is no point.
    pub effective_mass: Lane,
    /// Normal impulse, N·s.
    pub lambda: Lane,
    /// At the start of the step, m; at its end after the last motion.
    pub separation: Lane,
    /// Of the normal row in this substep, m/s.
    pub bias: Lane,
    /// λ summed over the substeps, N·s.
    pub total: Lane,
}

/// Friction of one point of eight manifolds.
#[derive(Clone, Copy, Debug)]
pub struct DiskLanes {
    /// J' of the two tangent rows for rotations of A; while blocks are filled, the first holds the impulse in world.
    pub angular_a: [Lane3; 2],
    /// Of B.
    pub angular_b: [Lane3; 2],
    /// (J'J'ᵀ)⁻¹ of the two rows, row by row, kg.
    pub inverse: [Lane; 4],
    /// 1 / the greatest eigenvalue of J'J'ᵀ, kg.
    pub step: Lane,
    /// Friction impulses along the tangents, N·s.
    pub lambda: [Lane; 2],
}

/// Multiples of the inverse masses that a manifold sees: weight amplification.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScaleLanes {
    /// Of the masses of A and B.
    pub mass: [Lane; 2],
    /// Of the inertias of A and B.
    pub inertia: [Lane; 2],
}

impl ScaleLanes {
    /// The masses as they are.
    pub const ONE: Self = Self { mass: [[1.0; LANES]; 2], inertia: [[1.0; LANES]; 2] };
}

/// Eight manifolds.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug)]
pub struct ContactBlock {
    /// Index of the first body of each manifold in the batch; 0 is whatever does not move.
    pub body_a: [u32; LANES],
    /// Of the second.
    pub body_b: [u32; LANES],
    /// B's surface normals.
    pub normal: Lane3,
    /// m^−½ of A, kg^−½.
    pub root_a: Lane,
    /// Of B.
    pub root_b: Lane,
    /// Coulomb's μ.
    pub friction: Lane,
    /// Gap that does not switch support off, m: none between bodies with joints.
    pub deadband: Lane,
    /// Points that the fullest of the eight has: 1, 2 or 4; beyond them nothing is read.
    pub size: Size,
    /// J'J'ᵀ of points 01, 02, 03, 12, 13, 23.
    pub coupling: [Lane; 6],
    /// Normals.
    pub points: [PointLanes; POINTS],
    /// Friction.
    pub disks: [DiskLanes; POINTS],
}

impl ContactBlock {
    /// Eight manifolds that do nothing.
    pub const EMPTY: Self = Self {
        body_a: [0; LANES],
        body_b: [0; LANES],
        normal: ZERO3,
        root_a: ZERO,
        root_b: ZERO,
        friction: ZERO,
        deadband: ZERO,
        size: Size::Four,
        coupling: [ZERO; 6],
        points: [PointLanes {
            angular_a: ZERO3,
            angular_b: ZERO3,
            k: ZERO,
            effective_mass: ZERO,
            lambda: ZERO,
            separation: ZERO,
            bias: ZERO,
            total: ZERO,
        }; POINTS],
        disks: [DiskLanes {
            angular_a: [ZERO3; 2],
            angular_b: [ZERO3; 2],
            inverse: [ZERO; 4],
            step: ZERO,
            lambda: [ZERO; 2],
        }; POINTS],
    };
}

/// What all visits of a sweep share.
#[derive(Clone, Copy, Debug)]
pub struct SweepPass {
    /// How overlap and gaps become biases.
    pub recovery: Recovery,
    /// Substep, s.
    pub h: f32,
    /// Passes over the normals of a manifold.
    pub passes: u32,
    /// Impulses are carried over.
    pub warm: bool,
}

/// Where K of points i < j is in `coupling`.
const fn pair(i: usize, j: usize) -> usize {
    match (i, j) {
        (0, 1) => 0,
        (0, 2) => 1,
        (0, 3) => 2,
        (1, 2) => 3,
        (1, 3) => 4,
        _ => 5,
    }
}

/// M^½ Δu of an impulse: the masses that a block sees.
struct Masses<S: Simd> {
    root_a: f32x8<S>,
    root_b: f32x8<S>,
    /// Scaled: what is pushed.
    push_a: f32x8<S>,
    push_b: f32x8<S>,
    inertia_a: f32x8<S>,
    inertia_b: f32x8<S>,
}

impl<S: Simd> Masses<S> {
    #[inline(always)]
    fn of(simd: S, block: &ContactBlock, scale: &ScaleLanes) -> Self {
        let (root_a, root_b) = (load(simd, &block.root_a), load(simd, &block.root_b));
        Self {
            root_a,
            root_b,
            push_a: root_a * load(simd, &scale.mass[0]),
            push_b: root_b * load(simd, &scale.mass[1]),
            inertia_a: load(simd, &scale.inertia[0]),
            inertia_b: load(simd, &scale.inertia[1]),
        }
    }
}

/// J' of one row: direction, and rotations of A and B.
#[derive(Clone, Copy)]
struct RowLanes<S: Simd> {
    direction: V3<S>,
    angular_a: V3<S>,
    angular_b: V3<S>,
}

impl<S: Simd> RowLanes<S> {
    /// J'J''ᵀ of two rows.
    #[inline(always)]
    fn inner(&self, o: &Self, m: &Masses<S>) -> f32x8<S> {
        self.direction.dot(o.direction) * (m.root_a * m.push_a + m.root_b * m.push_b)
            + self.angular_a.dot(o.angular_a) * m.inertia_a
            + self.angular_b.dot(o.angular_b) * m.inertia_b
    }

    /// w = J'u'.
    #[inline(always)]
    fn velocity(&self, relative: V3<S>, sides: &Sides<S>) -> f32x8<S> {
        self.direction.dot(relative) + self.angular_a.dot(sides.angular_a) + self.angular_b.dot(sides.angular_b)
    }

    /// u' += J'ᵀΔλ.
    #[inline(always)]
    fn push(&self, delta: f32x8<S>, m: &Masses<S>, sides: &mut Sides<S>) {
        sides.linear_a = sides.linear_a.plus(self.direction.times(delta * m.push_a));
        sides.linear_b = sides.linear_b.minus(self.direction.times(delta * m.push_b));
        sides.angular_a = sides.angular_a.plus(self.angular_a.times(delta * m.inertia_a));
        sides.angular_b = sides.angular_b.plus(self.angular_b.times(delta * m.inertia_b));
    }
}

/// The unit vectors of [`crate::math::tangents`], with the same operations.
#[inline(always)]
fn tangents<S: Simd>(simd: S, n: V3<S>) -> [V3<S>; 2] {
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let sign = n.z.simd_ge(zero).select(one, -one);
    let a = -one / (sign + n.z);
    let b = n.x * n.y * a;
    [V3 { x: one + sign * n.x * n.x * a, y: sign * b, z: -sign * n.x }, V3 { x: b, y: sign + n.y * n.y * a, z: -n.y }]
}

/// u' += J'ᵀλ for all impulses of a block.
#[inline(always)]
pub fn warm_start<S: Simd>(simd: S, block: &ContactBlock, scale: &ScaleLanes, velocities: &mut [Record]) {
    by_size!(block.size, N => warm_start_points::<S, N>(simd, block, scale, velocities))
}

#[inline(always)]
fn warm_start_points<S: Simd, const N: usize>(
    simd: S,
    block: &ContactBlock,
    scale: &ScaleLanes,
    velocities: &mut [Record],
) {
    let masses = Masses::of(simd, block, scale);
    let n = V3::load(simd, &block.normal);
    let t = tangents(simd, n);
    let mut sides = Sides::gather(simd, velocities, &block.body_a, &block.body_b);
    for i in 0..N {
        let (p, disk) = (&block.points[i], &block.disks[i]);
        row_of(simd, n, &p.angular_a, &p.angular_b).push(load(simd, &p.lambda), &masses, &mut sides);
        for k in 0..2 {
            let lambda = load(simd, &disk.lambda[k]);
            row_of(simd, t[k], &disk.angular_a[k], &disk.angular_b[k]).push(lambda, &masses, &mut sides);
        }
    }
    sides.scatter(simd, velocities, &block.body_a, &block.body_b);
}

#[inline(always)]
fn row_of<S: Simd>(simd: S, direction: V3<S>, angular_a: &Lane3, angular_b: &Lane3) -> RowLanes<S> {
    RowLanes { direction, angular_a: V3::load(simd, angular_a), angular_b: V3::load(simd, angular_b) }
}

/// What becomes of the biases of the normals before a visit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Biases {
    /// They stay.
    Keep,
    /// For the displacements as they are, with recovery.
    Recover,
    /// Without recovery: the motion has been.
    Relax,
    /// Without recovery, and what is found becomes the separations that are stored.
    RelaxLast,
}

/// Biases of the normals for the displacements as they are.
#[inline(always)]
pub fn measure<S: Simd>(simd: S, block: &mut ContactBlock, displacements: &[Record], pass: &SweepPass, biases: Biases) {
    by_size!(block.size, N => measure_points::<S, N>(simd, block, displacements, pass, biases))
}

#[inline(always)]
fn measure_points<S: Simd, const N: usize>(
    simd: S,
    block: &mut ContactBlock,
    displacements: &[Record],
    pass: &SweepPass,
    biases: Biases,
) {
    let n = V3::load(simd, &block.normal);
    let moved = Sides::gather(simd, displacements, &block.body_a, &block.body_b);
    let relative = moved.relative(load(simd, &block.root_a), load(simd, &block.root_b));
    let zero = splat(simd, 0.0);
    let (h, deadband) = (splat(simd, pass.h), load(simd, &block.deadband));
    for p in &mut block.points[..N] {
        let row = row_of(simd, n, &p.angular_a, &p.angular_b);
        let s = load(simd, &p.separation) + row.velocity(relative, &moved);
        let borne = h * load(simd, &p.lambda) * load(simd, &p.k);
        let gap = positive(simd, s - borne.simd_lt(deadband).select(borne, deadband)) / h;
        let mut overlap = zero;
        if biases == Biases::Recover {
            let excess = positive(simd, -s - splat(simd, pass.recovery.slop));
            let push = splat(simd, pass.recovery.rate) * excess / h;
            let fastest = splat(simd, pass.recovery.max_speed);
            overlap = -push.simd_lt(fastest).select(push, fastest);
        }
        store(s.simd_gt(zero).select(gap, overlap), &mut p.bias);
        if biases == Biases::RelaxLast {
            store(s, &mut p.separation);
        }
    }
}

/// Adds λ to the sums over the substeps.
#[inline(always)]
pub fn add_up<S: Simd>(simd: S, block: &mut ContactBlock) {
    by_size!(block.size, N => add_up_points::<S, N>(simd, block))
}

#[inline(always)]
fn add_up_points<S: Simd, const N: usize>(simd: S, block: &mut ContactBlock) {
    for p in &mut block.points[..N] {
        store(load(simd, &p.total) + load(simd, &p.lambda), &mut p.total);
    }
}
