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
use crate::solver::wide::lanes::{
    LANES, Lane, Lane3, Record, V3, gather, inverse, load, positive, scatter, splat, store,
};
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
    /// Impulses are carried over: a gap within the deadband does not switch support off.
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

/// The eight velocities (or displacements) of both sides.
struct Sides<S: Simd> {
    linear_a: V3<S>,
    angular_a: V3<S>,
    linear_b: V3<S>,
    angular_b: V3<S>,
}

impl<S: Simd> Sides<S> {
    #[inline(always)]
    fn gather(simd: S, records: &[Record], block: &ContactBlock) -> Self {
        let (linear_a, angular_a) = gather(simd, records, &block.body_a);
        let (linear_b, angular_b) = gather(simd, records, &block.body_b);
        Self { linear_a, angular_a, linear_b, angular_b }
    }

    #[inline(always)]
    fn scatter(self, simd: S, records: &mut [Record], block: &ContactBlock) {
        scatter(simd, records, &block.body_a, self.linear_a, self.angular_a);
        scatter(simd, records, &block.body_b, self.linear_b, self.angular_b);
    }

    /// v_A − v_B from the mass-weighted.
    #[inline(always)]
    fn relative(&self, root_a: f32x8<S>, root_b: f32x8<S>) -> V3<S> {
        self.linear_a.times(root_a).minus(self.linear_b.times(root_b))
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

/// I^−½ of eight bodies: xx, xy, xz, yy, yz, zz.
pub type RootInertia = [Lane; 6];

#[inline(always)]
fn weighted<S: Simd>(simd: S, root: &RootInertia, v: V3<S>) -> V3<S> {
    let (xx, xy, xz) = (load(simd, &root[0]), load(simd, &root[1]), load(simd, &root[2]));
    let (yy, yz, zz) = (load(simd, &root[3]), load(simd, &root[4]), load(simd, &root[5]));
    V3 { x: xx * v.x + xy * v.y + xz * v.z, y: xy * v.x + yy * v.y + yz * v.z, z: xz * v.x + yz * v.y + zz * v.z }
}

/// Of a point: arms on both bodies, and 1 where there is a point, else 0.
struct Arms<S: Simd> {
    a: V3<S>,
    b: V3<S>,
    kept: f32x8<S>,
}

impl<S: Simd> Arms<S> {
    /// J' along an axis.
    #[inline(always)]
    fn row(&self, simd: S, axis: V3<S>, roots: &[RootInertia; 2]) -> RowLanes<S> {
        RowLanes {
            direction: axis,
            angular_a: weighted(simd, &roots[0], self.a.cross(axis)).times(self.kept),
            angular_b: weighted(simd, &roots[1], axis.cross(self.b)).times(self.kept),
        }
    }
}

/// From arms and impulses to rows: a block as it was filled becomes one that can be visited.
#[inline(always)]
pub fn prepare<S: Simd>(
    simd: S,
    block: &mut ContactBlock,
    scale: &ScaleLanes,
    roots: &[RootInertia; 2],
    counts: &Lane,
) {
    by_size!(block.size, N => prepare_points::<S, N>(simd, block, scale, roots, counts))
}

#[inline(always)]
fn prepare_points<S: Simd, const N: usize>(
    simd: S,
    block: &mut ContactBlock,
    scale: &ScaleLanes,
    roots: &[RootInertia; 2],
    counts: &Lane,
) {
    let n = V3::load(simd, &block.normal);
    let t = tangents(simd, n);
    let masses = Masses::of(simd, block, scale);
    let (zero, half) = (splat(simd, 0.0), splat(simd, 0.5));
    let counts = load(simd, counts);
    let mut normals = [RowLanes { direction: n, angular_a: n, angular_b: n }; N];
    for i in 0..N {
        let (p, disk) = (&mut block.points[i], &mut block.disks[i]);
        let exists = counts.simd_gt(splat(simd, i as f32));
        let kept = exists.select(splat(simd, 1.0), zero);
        let (arm_a, arm_b) = (V3::load(simd, &p.angular_a), V3::load(simd, &p.angular_b));
        let s = load(simd, &p.separation);
        // Arms to the middle of the gap, as in `constraint/contact.rs`.
        let (length_a, length_b) = (arm_a.dot(arm_a).sqrt(), arm_b.dot(arm_b).sqrt());
        let shorter = length_a.simd_lt(length_b).select(length_a, length_b);
        let from_afar = s.simd_gt(splat(simd, 0.1) * shorter);
        let shift = n.times(from_afar.select(zero, half * s));
        let (arm_a, arm_b) = (arm_a.minus(shift), arm_b.plus(shift));
        let arms = Arms { a: arm_a, b: arm_b, kept };

        let normal = arms.row(simd, n, roots);
        let k = normal.inner(&normal, &masses);
        let effective_mass = exists.select(inverse(simd, k), zero);
        normal.angular_a.store(&mut p.angular_a);
        normal.angular_b.store(&mut p.angular_b);
        store(k, &mut p.k);
        store(effective_mass, &mut p.effective_mass);
        store(zero, &mut p.total);
        normals[i] = normal;

        let impulse = V3::load(simd, &disk.angular_a[0]);
        let tangent = [arms.row(simd, t[0], roots), arms.row(simd, t[1], roots)];
        for k in 0..2 {
            store(impulse.dot(t[k]), &mut disk.lambda[k]);
            tangent[k].angular_a.store(&mut disk.angular_a[k]);
            tangent[k].angular_b.store(&mut disk.angular_b[k]);
        }
        prepare_disk(simd, disk, &tangent, &masses, kept);
    }
    for i in 0..N {
        for j in i + 1..N {
            store(normals[i].inner(&normals[j], &masses), &mut block.coupling[pair(i, j)]);
        }
    }
}

/// The inverse of the 2 × 2 system of a disk, and the step that does not overshoot, as `reference.rs` has them.
#[inline(always)]
fn prepare_disk<S: Simd>(simd: S, disk: &mut DiskLanes, rows: &[RowLanes<S>; 2], m: &Masses<S>, exists: f32x8<S>) {
    let (k1, k2) = (rows[0].inner(&rows[0], m), rows[1].inner(&rows[1], m));
    let c = rows[0].inner(&rows[1], m);
    let (m1, m2) = (exists * inverse(simd, k1), exists * inverse(simd, k2));
    let determinant = splat(simd, 1.0) - c * c * m1 * m2;
    let well = determinant.simd_gt(splat(simd, 1e-3));
    let share = well.select(inverse(simd, determinant), splat(simd, 1.0));
    store(m1 * share, &mut disk.inverse[0]);
    store(well.select(-(c * m1 * m2 * share), splat(simd, 0.0)), &mut disk.inverse[1]);
    store(-(c * m1 * m2 * share), &mut disk.inverse[2]);
    store(m2 * share, &mut disk.inverse[3]);
    let half = splat(simd, 0.5) * (k1 - k2);
    let greatest = splat(simd, 0.5) * (k1 + k2) + (half * half + c * c).sqrt();
    store(exists * inverse(simd, greatest), &mut disk.step);
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
    let mut sides = Sides::gather(simd, velocities, block);
    for i in 0..N {
        let (p, disk) = (&block.points[i], &block.disks[i]);
        row_of(simd, n, &p.angular_a, &p.angular_b).push(load(simd, &p.lambda), &masses, &mut sides);
        for k in 0..2 {
            let lambda = load(simd, &disk.lambda[k]);
            row_of(simd, t[k], &disk.angular_a[k], &disk.angular_b[k]).push(lambda, &masses, &mut sides);
        }
    }
    sides.scatter(simd, velocities, block);
}

#[inline(always)]
fn row_of<S: Simd>(simd: S, direction: V3<S>, angular_a: &Lane3, angular_b: &Lane3) -> RowLanes<S> {
    RowLanes { direction, angular_a: V3::load(simd, angular_a), angular_b: V3::load(simd, angular_b) }
}

/// Biases of the normals for the displacements as they are; with `RELAX` without recovery, with `LAST`
/// they become the separations that are stored.
#[inline(always)]
pub fn measure<S: Simd, const RELAX: bool, const LAST: bool>(
    simd: S,
    block: &mut ContactBlock,
    displacements: &[Record],
    pass: &SweepPass,
) {
    by_size!(block.size, N => measure_points::<S, RELAX, LAST, N>(simd, block, displacements, pass))
}

#[inline(always)]
fn measure_points<S: Simd, const RELAX: bool, const LAST: bool, const N: usize>(
    simd: S,
    block: &mut ContactBlock,
    displacements: &[Record],
    pass: &SweepPass,
) {
    let n = V3::load(simd, &block.normal);
    let moved = Sides::gather(simd, displacements, block);
    let relative = moved.relative(load(simd, &block.root_a), load(simd, &block.root_b));
    let zero = splat(simd, 0.0);
    let h = splat(simd, pass.h);
    for p in &mut block.points[..N] {
        let row = row_of(simd, n, &p.angular_a, &p.angular_b);
        let s = load(simd, &p.separation) + row.velocity(relative, &moved);
        let deadband = splat(simd, if pass.warm { pass.recovery.deadband } else { 0.0 });
        let borne = h * load(simd, &p.lambda) * load(simd, &p.k);
        let gap = positive(simd, s - borne.simd_lt(deadband).select(borne, deadband)) / h;
        let overlap = if RELAX {
            zero
        } else {
            let excess = positive(simd, -s - splat(simd, pass.recovery.slop));
            let push = splat(simd, pass.recovery.rate) * excess / h;
            let fastest = splat(simd, pass.recovery.max_speed);
            -push.simd_lt(fastest).select(push, fastest)
        };
        store(s.simd_gt(zero).select(gap, overlap), &mut p.bias);
        if LAST {
            store(s, &mut p.separation);
        }
    }
}

/// One visit to eight manifolds.
#[inline(always)]
pub fn visit<S: Simd>(
    simd: S,
    block: &mut ContactBlock,
    scale: &ScaleLanes,
    velocities: &mut [Record],
    pass: &SweepPass,
) {
    by_size!(block.size, N => visit_points::<S, N>(simd, block, scale, velocities, pass))
}

#[inline(always)]
fn visit_points<S: Simd, const N: usize>(
    simd: S,
    block: &mut ContactBlock,
    scale: &ScaleLanes,
    velocities: &mut [Record],
    pass: &SweepPass,
) {
    let masses = Masses::of(simd, block, scale);
    let n = V3::load(simd, &block.normal);
    let mut sides = Sides::gather(simd, velocities, block);
    visit_normals::<S, N>(simd, block, n, &masses, &mut sides, pass.passes);
    let t = tangents(simd, n);
    let mu = load(simd, &block.friction);
    for i in 0..N {
        let reach = mu * positive(simd, load(simd, &block.points[i].lambda));
        visit_disk(simd, &mut block.disks[i], t, reach, &masses, &mut sides);
    }
    sides.scatter(simd, velocities, block);
}

/// Gauss–Seidel on the normals alone: the bodies are read once and pushed once.
#[inline(always)]
fn visit_normals<S: Simd, const N: usize>(
    simd: S,
    block: &mut ContactBlock,
    n: V3<S>,
    masses: &Masses<S>,
    sides: &mut Sides<S>,
    passes: u32,
) {
    let zero = splat(simd, 0.0);
    let relative = sides.relative(masses.root_a, masses.root_b);
    let along = n.dot(relative);
    let (mut w, mut lambda) = ([zero; N], [zero; N]);
    for i in 0..N {
        let p = &block.points[i];
        let (a, b) = (V3::load(simd, &p.angular_a), V3::load(simd, &p.angular_b));
        w[i] = along + a.dot(sides.angular_a) + b.dot(sides.angular_b) + load(simd, &p.bias);
        lambda[i] = load(simd, &p.lambda);
    }
    for _ in 0..passes {
        for i in 0..N {
            let next = positive(simd, lambda[i] - w[i] * load(simd, &block.points[i].effective_mass));
            let change = next - lambda[i];
            lambda[i] = next;
            for j in 0..N {
                let k = if i == j {
                    &block.points[i].k
                } else {
                    &block.coupling[pair(if i < j { i } else { j }, if i < j { j } else { i })]
                };
                w[j] += load(simd, k) * change;
            }
        }
    }
    let mut sum = zero;
    for i in 0..N {
        let p = &mut block.points[i];
        let change = lambda[i] - load(simd, &p.lambda);
        store(lambda[i], &mut p.lambda);
        sum += change;
        let (a, b) = (V3::load(simd, &p.angular_a), V3::load(simd, &p.angular_b));
        sides.angular_a = sides.angular_a.plus(a.times(change * masses.inertia_a));
        sides.angular_b = sides.angular_b.plus(b.times(change * masses.inertia_b));
    }
    sides.linear_a = sides.linear_a.plus(n.times(sum * masses.push_a));
    sides.linear_b = sides.linear_b.minus(n.times(sum * masses.push_b));
}

/// Sticks if the disk holds it, else slides: `reference.rs`, `solve_disk`.
#[inline(always)]
fn visit_disk<S: Simd>(
    simd: S,
    disk: &mut DiskLanes,
    t: [V3<S>; 2],
    reach: f32x8<S>,
    masses: &Masses<S>,
    sides: &mut Sides<S>,
) {
    let relative = sides.relative(masses.root_a, masses.root_b);
    let rows = [
        row_of(simd, t[0], &disk.angular_a[0], &disk.angular_b[0]),
        row_of(simd, t[1], &disk.angular_a[1], &disk.angular_b[1]),
    ];
    let w = [rows[0].velocity(relative, sides), rows[1].velocity(relative, sides)];
    let (i11, i12) = (load(simd, &disk.inverse[0]), load(simd, &disk.inverse[1]));
    let (i21, i22) = (load(simd, &disk.inverse[2]), load(simd, &disk.inverse[3]));
    let old = [load(simd, &disk.lambda[0]), load(simd, &disk.lambda[1])];
    let stick = [old[0] - (i11 * w[0] + i12 * w[1]), old[1] - (i21 * w[0] + i22 * w[1])];
    let step = load(simd, &disk.step);
    let slide = [old[0] - step * w[0], old[1] - step * w[1]];
    let length = (slide[0] * slide[0] + slide[1] * slide[1]).sqrt();
    let outside = length.simd_gt(reach);
    let one = splat(simd, 1.0);
    let shrink = outside.select(reach / outside.select(length, one), one);
    let slips = (stick[0] * stick[0] + stick[1] * stick[1]).simd_gt(reach * reach);
    for k in 0..2 {
        let new = slips.select(slide[k] * shrink, stick[k]);
        let change = new - old[k];
        store(new, &mut disk.lambda[k]);
        rows[k].push(change, masses, sides);
    }
}

/// How far a block is from rest: what visits to each row alone would do.
#[derive(Clone, Copy)]
pub struct Unrest<S: Simd> {
    /// Greatest change of an impulse, ‖λ − clip(λ − w·m_eff)‖∞, N·s.
    pub residual: f32x8<S>,
    /// Energy that the changes would take, ½ Σ |Δλ w|, J.
    pub energy: f32x8<S>,
}

/// Looks at a block without a visit.
#[inline(always)]
pub fn inspect<S: Simd>(simd: S, block: &ContactBlock, velocities: &[Record]) -> Unrest<S> {
    by_size!(block.size, N => inspect_points::<S, N>(simd, block, velocities))
}

#[inline(always)]
fn inspect_points<S: Simd, const N: usize>(simd: S, block: &ContactBlock, velocities: &[Record]) -> Unrest<S> {
    let n = V3::load(simd, &block.normal);
    let t = tangents(simd, n);
    let sides = Sides::gather(simd, velocities, block);
    let relative = sides.relative(load(simd, &block.root_a), load(simd, &block.root_b));
    let mu = load(simd, &block.friction);
    let (zero, one, half) = (splat(simd, 0.0), splat(simd, 1.0), splat(simd, 0.5));
    let mut unrest = Unrest { residual: zero, energy: zero };
    for (p, disk) in block.points[..N].iter().zip(&block.disks) {
        let lambda = load(simd, &p.lambda);
        let row = row_of(simd, n, &p.angular_a, &p.angular_b);
        let w = row.velocity(relative, &sides) + load(simd, &p.bias);
        let change = positive(simd, lambda - w * load(simd, &p.effective_mass)) - lambda;
        let reach = mu * positive(simd, lambda);
        let old = [load(simd, &disk.lambda[0]), load(simd, &disk.lambda[1])];
        let step = load(simd, &disk.step);
        let rows = [
            row_of(simd, t[0], &disk.angular_a[0], &disk.angular_b[0]),
            row_of(simd, t[1], &disk.angular_a[1], &disk.angular_b[1]),
        ];
        let v = [rows[0].velocity(relative, &sides), rows[1].velocity(relative, &sides)];
        let wanted = [old[0] - step * v[0], old[1] - step * v[1]];
        let length = (wanted[0] * wanted[0] + wanted[1] * wanted[1]).sqrt();
        let outside = length.simd_gt(reach);
        let shrink = outside.select(reach / outside.select(length, one), one);
        let slip = [shrink * wanted[0] - old[0], shrink * wanted[1] - old[1]];
        let greatest = positive(simd, change.abs() - unrest.residual) + unrest.residual;
        let sliding = (slip[0] * slip[0] + slip[1] * slip[1]).sqrt();
        unrest.residual = positive(simd, sliding - greatest) + greatest;
        unrest.energy += half * ((change * w).abs() + (slip[0] * v[0] + slip[1] * v[1]).abs());
    }
    unrest
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
