//! Eight manifolds side by side: their rows, and the visit of a sweep. DESIGN, "Fast path".
//!
//! Bodies turn in velocities weighted by their inertia, u' = (v, I^½ω), and rows see them through J' = J diag(1, I^−½): one
//! Jacobian both reads (w = J'u') and pushes (u' += M'⁻¹J'ᵀΔλ with M' = diag(m, 1)). What is linear is as it is: v_A − v_B costs
//! no product, and an impulse has the same direction for both bodies. A visit is that of `manifold_block.rs` in the reference:
//! normals several times against each other through K = J M⁻¹Jᵀ, then the friction disk of each point, with the bound
//! that the normals give. The lanes of a block share no body that moves.
//! No closures in here: the compiler does not give them the machine's wide instructions, and where one is not inlined
//! each operation becomes a call.
//! Held to the reference by `tests/wide.rs`.
#![expect(clippy::needless_range_loop, reason = "kernels walk several arrays of points in step")]

use crate::solver::penetration_recovery::Recovery;
use crate::solver::wide::lanes::{LANES, Lane, Lane3, Record, Sides, V3, load, positive, splat, store};
use fearless_simd::prelude::*;
use fearless_simd::{f32x8, mask32x8};

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

/// In a browser a program must first get there: one kernel for all sizes takes a third of the room.
const ONE_FOR_ALL: bool = cfg!(target_arch = "wasm32");

/// How many points a kernel for `N` of them looks at.
#[inline(always)]
fn many<const N: usize>(size: Size) -> usize {
    if ONE_FOR_ALL { size.points() } else { N }
}

/// A kernel made for the size of the block: its loops have a known length.
macro_rules! by_size {
    ($size:expr, $n:ident => $call:expr) => {
        match $size {
            _ if ONE_FOR_ALL => {
                const $n: usize = POINTS;
                $call
            }
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

/// The same for blocks of round bodies, too: `$tangents` is known to be `None` there.
macro_rules! by_kind {
    ($tangents:ident, $size:expr, $n:ident => $call:expr) => {
        match $tangents {
            Some(_) => by_size!($size, $n => $call),
            None => {
                let $tangents = None;
                by_size!($size, $n => $call)
            }
        }
    };
}

mod prepare;
mod rows;
mod visit;

pub use prepare::{prepare, reweigh};
use rows::{RowLanes, Sliding, normal_velocities, point_velocity, push_all, row_of, turn_by_normals, turn_point};
pub use visit::{Unrest, inspect, visit};

/// One point of eight manifolds.
#[derive(Clone, Copy, Debug)]
pub struct PointLanes {
    /// J' of the normal row for rotations of A, or, of round bodies, the arm on A times I^−½; while blocks are filled, the
    /// arm, m.
    pub angular_a: Lane3,
    /// Of B.
    pub angular_b: Lane3,
    /// J M⁻¹Jᵀ of the normal row, 1/kg.
    pub k: Lane,
    /// Its inverse, kg; 0 where there is no point. While blocks are filled, 1 where there is one.
    pub effective_mass: Lane,
    /// Normal impulse, N·s.
    pub lambda: Lane,
    /// At the start of the step, m; at its end after the last motion.
    pub separation: Lane,
    /// Of the normal row in this substep, m/s; before its first look or visit, the separation as it is, m.
    pub bias: Lane,
    /// λ summed over the substeps, N·s.
    pub total: Lane,
}

/// Friction of one point of eight manifolds.
#[derive(Clone, Copy, Debug)]
pub struct DiskLanes {
    /// (J M⁻¹Jᵀ)⁻¹ of the two tangent rows, kg: 11, 12, 22. Where it is near to singular, the longest step that does not
    /// overshoot, for both.
    pub inverse: [Lane; 3],
    /// Friction impulses along the tangents, N·s.
    pub lambda: [Lane; 2],
}

/// J' of the tangent rows of eight manifolds, but of those between round bodies: all moments of inertia of such a body are
/// the same, and the arm times I^−½ makes all three rows of a point.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug)]
pub struct TangentLanes {
    /// For rotations of A, by point and tangent.
    pub angular_a: [[Lane3; 2]; POINTS],
    /// Of B.
    pub angular_b: [[Lane3; 2]; POINTS],
}

impl TangentLanes {
    /// Of manifolds that do nothing.
    pub const EMPTY: Self = Self { angular_a: [[ZERO3; 2]; POINTS], angular_b: [[ZERO3; 2]; POINTS] };
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
    /// 1/m of A and B, 1/kg.
    pub inverse_mass: [Lane; 2],
    /// Coulomb's μ.
    pub friction: Lane,
    /// Points that the fullest of the eight has: 1, 2 or 4; beyond them nothing is read.
    pub size: Size,
    /// Bits of the lanes whose support small gaps do not switch off: not between bodies with joints.
    pub bears: u8,
    /// Which of the [`TangentLanes`] of its domain belong to it; beyond all of them if its bodies are round.
    pub tangents: u32,
    /// J M⁻¹Jᵀ of points 01, 02, 03, 12, 13, 23.
    pub coupling: [Lane; 6],
    /// Normals.
    pub points: [PointLanes; POINTS],
    /// Friction.
    pub disks: [DiskLanes; POINTS],
}

impl ContactBlock {
    /// In the place of [`Self::tangents`].
    pub const ROUND: u32 = u32::MAX;

    /// Eight manifolds that do nothing.
    pub const EMPTY: Self = Self {
        body_a: [0; LANES],
        body_b: [0; LANES],
        normal: ZERO3,
        inverse_mass: [ZERO; 2],
        friction: ZERO,
        size: Size::Four,
        bears: 0,
        tangents: Self::ROUND,
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
        disks: [DiskLanes { inverse: [ZERO; 3], lambda: [ZERO; 2] }; POINTS],
    };

    /// Bits of the lanes with a body whose inertia is another one now than `old_roots` has.
    pub fn turned(&self, old_roots: &[Record]) -> u8 {
        let has_turned = |body: u32| old_roots[body as usize].is_marked();
        let lanes = self.body_a.iter().zip(&self.body_b).enumerate();
        lanes.fold(0, |bits, (lane, (&a, &b))| bits | u8::from(has_turned(a) || has_turned(b)) << lane)
    }

    /// Whether small gaps leave the support of a lane as it is.
    pub fn set_bears(&mut self, lane: usize, bears: bool) {
        self.bears = self.bears & !(1 << lane) | u8::from(bears) << lane;
    }
}

/// What all visits of a sweep share.
#[derive(Clone, Copy, Debug)]
pub struct SweepPass {
    /// How overlap and gaps become biases.
    pub recovery: Recovery,
    /// Substep, s.
    pub h: f32,
    /// 1/h, 1/s.
    pub per_second: f32,
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

/// The masses that a block sees: 1/m, and multiples of the inverse inertias.
struct Masses<S: Simd> {
    push_a: f32x8<S>,
    push_b: f32x8<S>,
    inertia_a: f32x8<S>,
    inertia_b: f32x8<S>,
}

impl<S: Simd> Masses<S> {
    #[inline(always)]
    fn of(simd: S, block: &ContactBlock, scale: &ScaleLanes) -> Self {
        Self {
            push_a: load(simd, &block.inverse_mass[0]) * load(simd, &scale.mass[0]),
            push_b: load(simd, &block.inverse_mass[1]) * load(simd, &scale.mass[1]),
            inertia_a: load(simd, &scale.inertia[0]),
            inertia_b: load(simd, &scale.inertia[1]),
        }
    }
}

impl<S: Simd> Masses<S> {
    /// J M⁻¹Jᵀ of the linear part of a row, 1/kg.
    #[inline(always)]
    fn linear(&self) -> f32x8<S> {
        self.push_a + self.push_b
    }
}

/// The unit vectors of [`crate::math::tangents`], with the same operations.
#[inline(always)]
fn unit_tangents<S: Simd>(simd: S, n: V3<S>) -> [V3<S>; 2] {
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let sign = n.z.simd_ge(zero).select(one, -one);
    let a = -one / (sign + n.z);
    let b = n.x * n.y * a;
    [V3 { x: one + sign * n.x * n.x * a, y: sign * b, z: -sign * n.x }, V3 { x: b, y: sign + n.y * n.y * a, z: -n.y }]
}

/// u' += J'ᵀλ for all impulses of a block.
#[inline(always)]
pub fn warm_start<S: Simd>(
    simd: S,
    block: &ContactBlock,
    tangents: Option<&TangentLanes>,
    scale: &ScaleLanes,
    velocities: &mut [Record],
) {
    by_kind!(tangents, block.size, N => warm_start_points::<S, N>(simd, block, tangents, scale, velocities))
}

#[inline(always)]
fn warm_start_points<S: Simd, const N: usize>(
    simd: S,
    block: &ContactBlock,
    tangents: Option<&TangentLanes>,
    scale: &ScaleLanes,
    velocities: &mut [Record],
) {
    let masses = Masses::of(simd, block, scale);
    let n = V3::load(simd, &block.normal);
    let t = unit_tangents(simd, n);
    let mut sides = Sides::gather(simd, velocities, &block.body_a, &block.body_b);
    for i in 0..many::<N>(block.size) {
        let (p, disk) = (&block.points[i], &block.disks[i]);
        let lambda = [load(simd, &p.lambda), load(simd, &disk.lambda[0]), load(simd, &disk.lambda[1])];
        push_all(simd, block, tangents, i, [n, t[0], t[1]], lambda, &masses, &mut sides);
    }
    sides.scatter(simd, velocities, &block.body_a, &block.body_b);
}

/// What becomes of the biases of the normals before a visit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Biases {
    /// They stay.
    Keep,
    /// With recovery, before the motion: for the separations as they are.
    Recover,
    /// Without recovery: the motion has been.
    Relax,
    /// Without recovery, and what is found becomes the separations that are stored.
    RelaxLast,
}

/// Separations of the points, m.
pub type Separations = [Lane; POINTS];

/// Separations for the displacements as they are.
#[inline(always)]
pub fn separations<S: Simd>(
    simd: S,
    block: &ContactBlock,
    tangents: Option<&TangentLanes>,
    displacements: &[Record],
) -> Separations {
    by_kind!(tangents, block.size, N => separations_of::<S, N>(simd, block, tangents, displacements))
}

#[inline(always)]
fn separations_of<S: Simd, const N: usize>(
    simd: S,
    block: &ContactBlock,
    tangents: Option<&TangentLanes>,
    displacements: &[Record],
) -> Separations {
    let n = V3::load(simd, &block.normal);
    let moved = Sides::gather(simd, displacements, &block.body_a, &block.body_b);
    let relative = moved.relative();
    let ways = normal_velocities::<S, N>(simd, block, tangents, n, relative, &moved);
    let mut separations = [ZERO; POINTS];
    for i in 0..many::<N>(block.size) {
        store(load(simd, &block.points[i].separation) + ways[i], &mut separations[i]);
    }
    separations
}

/// Biases of the normals before the motion, with recovery.
#[inline(always)]
pub fn recover<S: Simd>(simd: S, block: &mut ContactBlock, pass: &SweepPass) {
    by_size!(block.size, N => recover_points::<S, N>(simd, block, pass))
}

#[inline(always)]
fn recover_points<S: Simd, const N: usize>(simd: S, block: &mut ContactBlock, pass: &SweepPass) {
    let deadband = deadband(simd, block, pass);
    let (zero, per_second) = (splat(simd, 0.0), splat(simd, pass.per_second));
    let (rate, fastest) = (splat(simd, pass.recovery.rate * pass.per_second), splat(simd, pass.recovery.max_speed));
    for p in &mut block.points[..many::<N>(block.size)] {
        let s = load(simd, &p.bias);
        let push = rate * positive(simd, -s - splat(simd, pass.recovery.slop));
        let overlap = -push.simd_lt(fastest).select(push, fastest);
        store(s.simd_gt(zero).select(gap_bias(simd, p, s, deadband, per_second), overlap), &mut p.bias);
    }
}

/// Biases of the normals after the motion, without recovery; `is_last`: what was found becomes the separations that are
/// stored.
#[inline(always)]
pub fn relax<S: Simd>(simd: S, block: &mut ContactBlock, separations: &Separations, pass: &SweepPass, is_last: bool) {
    by_size!(block.size, N => relax_points::<S, N>(simd, block, separations, pass, is_last))
}

#[inline(always)]
fn relax_points<S: Simd, const N: usize>(
    simd: S,
    block: &mut ContactBlock,
    separations: &Separations,
    pass: &SweepPass,
    is_last: bool,
) {
    let deadband = deadband(simd, block, pass);
    let (zero, per_second) = (splat(simd, 0.0), splat(simd, pass.per_second));
    for i in 0..many::<N>(block.size) {
        let (p, s) = (&mut block.points[i], load(simd, &separations[i]));
        store(s.simd_gt(zero).select(gap_bias(simd, p, s, deadband, per_second), zero), &mut p.bias);
        if is_last {
            store(s, &mut p.separation);
        }
    }
}

/// Gaps that close at this speed leave support as it is, m/s.
#[inline(always)]
fn deadband<S: Simd>(simd: S, block: &ContactBlock, pass: &SweepPass) -> f32x8<S> {
    let bears = mask32x8::from_bitmask(simd, block.bears.into());
    bears.select(splat(simd, pass.recovery.deadband * pass.per_second), splat(simd, 0.0))
}

/// The speed at which a gap `s` may close: `penetration_recovery.rs`.
#[inline(always)]
fn gap_bias<S: Simd>(simd: S, p: &PointLanes, s: f32x8<S>, deadband: f32x8<S>, per_second: f32x8<S>) -> f32x8<S> {
    let borne = load(simd, &p.lambda) * load(simd, &p.k);
    positive(simd, s * per_second - borne.simd_lt(deadband).select(borne, deadband))
}

/// The end of a substep: λ adds to the sums, and the separations are those of the next.
#[inline(always)]
pub fn leave<S: Simd>(simd: S, block: &mut ContactBlock, separations: &Separations) {
    by_size!(block.size, N => leave_points::<S, N>(simd, block, separations))
}

#[inline(always)]
fn leave_points<S: Simd, const N: usize>(simd: S, block: &mut ContactBlock, separations: &Separations) {
    for i in 0..many::<N>(block.size) {
        let p = &mut block.points[i];
        store(load(simd, &p.total) + load(simd, &p.lambda), &mut p.total);
        p.bias = separations[i];
    }
}
