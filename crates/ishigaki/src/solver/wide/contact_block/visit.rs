//! A visit to a block, and a look at it without one.

use super::{
    ContactBlock, DiskLanes, Masses, ONE_FOR_ALL, POINTS, ScaleLanes, Size, SweepPass, TangentLanes, many, pair,
    unit_tangents,
};
use super::{Sliding, normal_velocities, point_velocity, turn_by_normals, turn_point};
use crate::solver::wide::lanes::{Record, Sides, V3, load, positive, splat, store};
use fearless_simd::f32x8;
use fearless_simd::prelude::*;

/// Friction impulses below this are nothing, N·s.
const DUST: f32 = 1e-18;

/// One visit to eight manifolds.
#[inline(always)]
pub fn visit<S: Simd>(
    simd: S,
    block: &mut ContactBlock,
    tangents: Option<&TangentLanes>,
    scale: &ScaleLanes,
    velocities: &mut [Record],
    pass: &SweepPass,
) {
    by_kind!(tangents, block.size, N => visit_points::<S, N>(simd, block, tangents, scale, velocities, pass))
}

#[inline(always)]
fn visit_points<S: Simd, const N: usize>(
    simd: S,
    block: &mut ContactBlock,
    tangents: Option<&TangentLanes>,
    scale: &ScaleLanes,
    velocities: &mut [Record],
    pass: &SweepPass,
) {
    let masses = Masses::of(simd, block, scale);
    let n = V3::load(simd, &block.normal);
    let mut sides = Sides::gather(simd, velocities, &block.body_a, &block.body_b);
    let relative = sides.relative();
    let mut w = normal_velocities::<S, N>(simd, block, tangents, n, relative, &sides);
    let change = solve_normals(simd, block, &mut w, pass.passes);
    let pushed = turn_by_normals(simd, block, tangents, n, &change, &masses, &mut sides);
    let t = unit_tangents(simd, n);
    let mu = load(simd, &block.friction);
    // What the normals push is square to it.
    let mut sliding = Sliding::new(simd, t, &masses, relative);
    for i in 0..many::<N>(block.size) {
        let reach = mu * positive(simd, load(simd, &block.points[i].lambda));
        let w = point_velocity(simd, block, tangents, i, t, sliding.speed, &sides);
        let change = solve_disk(simd, &mut block.disks[i], w, reach);
        sliding.add(change);
        turn_point(simd, block, tangents, i, t, change, &masses, &mut sides);
    }
    sliding.push([n, t[0], t[1]], pushed, &masses, &mut sides);
    sides.scatter(simd, velocities, &block.body_a, &block.body_b);
}

/// Gauss–Seidel on the normals alone, from their velocities on: the bodies are read once and pushed once. The changes of λ.
#[inline(always)]
fn solve_normals<S: Simd, const N: usize>(
    simd: S,
    block: &mut ContactBlock,
    w: &mut [f32x8<S>; N],
    passes: u32,
) -> [f32x8<S>; N] {
    let mut lambda = [splat(simd, 0.0); N];
    for i in 0..many::<N>(block.size) {
        w[i] += load(simd, &block.points[i].bias);
        lambda[i] = load(simd, &block.points[i].lambda);
    }
    let old = lambda;
    // One point alone is solved by the first.
    let passes = if many::<N>(block.size) == 1 { 1 } else { passes };
    for _ in 0..passes {
        for i in 0..many::<N>(block.size) {
            let next = positive(simd, lambda[i] - w[i] * load(simd, &block.points[i].effective_mass));
            let change = next - lambda[i];
            lambda[i] = next;
            for j in 0..many::<N>(block.size) {
                let k = if i == j {
                    &block.points[i].k
                } else {
                    &block.coupling[pair(if i < j { i } else { j }, if i < j { j } else { i })]
                };
                w[j] += load(simd, k) * change;
            }
        }
    }
    let mut change = old;
    for i in 0..many::<N>(block.size) {
        change[i] = lambda[i] - old[i];
        store(lambda[i], &mut block.points[i].lambda);
    }
    change
}

/// Sticks if the disk holds it, else slides: `reference.rs`, `solve_disk`. The changes of λ.
#[inline(always)]
fn solve_disk<S: Simd>(simd: S, disk: &mut DiskLanes, w: [f32x8<S>; 2], reach: f32x8<S>) -> [f32x8<S>; 2] {
    let [i11, i12, i22] = [load(simd, &disk.inverse[0]), load(simd, &disk.inverse[1]), load(simd, &disk.inverse[2])];
    let old = [load(simd, &disk.lambda[0]), load(simd, &disk.lambda[1])];
    let stick = [old[0] - (i11 * w[0] + i12 * w[1]), old[1] - (i12 * w[0] + i22 * w[1])];
    let slips = (stick[0] * stick[0] + stick[1] * stick[1]).simd_gt(reach * reach);
    let mut new = stick;
    // A root and a quotient take as long as all else here, and most of what touches sticks.
    if slips.any_true() {
        let step = scalar_step(simd, disk);
        let slide = [old[0] - step * w[0], old[1] - step * w[1]];
        let length = (slide[0] * slide[0] + slide[1] * slide[1]).sqrt();
        let outside = length.simd_gt(reach);
        let one = splat(simd, 1.0);
        let shrink = outside.select(reach / outside.select(length, one), one);
        new = [slips.select(slide[0] * shrink, stick[0]), slips.select(slide[1] * shrink, stick[1])];
    }
    // What is nothing would take long to be multiplied: `math.rs`, `without_dust`.
    let (zero, dust) = (splat(simd, 0.0), splat(simd, DUST));
    let new = [new[0].abs().simd_lt(dust).select(zero, new[0]), new[1].abs().simd_lt(dust).select(zero, new[1])];
    store(new[0], &mut disk.lambda[0]);
    store(new[1], &mut disk.lambda[1]);
    [new[0] - old[0], new[1] - old[1]]
}

/// The least eigenvalue of the inverse: the longest step that overshoots in no direction.
#[inline(always)]
fn scalar_step<S: Simd>(simd: S, disk: &DiskLanes) -> f32x8<S> {
    let [i11, i12, i22] = [load(simd, &disk.inverse[0]), load(simd, &disk.inverse[1]), load(simd, &disk.inverse[2])];
    let half = splat(simd, 0.5);
    let difference = half * (i11 - i22);
    half * (i11 + i22) - (difference * difference + i12 * i12).sqrt()
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
pub fn inspect<S: Simd>(
    simd: S,
    block: &ContactBlock,
    tangents: Option<&TangentLanes>,
    velocities: &[Record],
) -> Unrest<S> {
    by_kind!(tangents, block.size, N => inspect_points::<S, N>(simd, block, tangents, velocities))
}

#[inline(always)]
fn inspect_points<S: Simd, const N: usize>(
    simd: S,
    block: &ContactBlock,
    tangents: Option<&TangentLanes>,
    velocities: &[Record],
) -> Unrest<S> {
    let n = V3::load(simd, &block.normal);
    let t = unit_tangents(simd, n);
    let sides = Sides::gather(simd, velocities, &block.body_a, &block.body_b);
    let relative = sides.relative();
    let mu = load(simd, &block.friction);
    let (zero, one, half) = (splat(simd, 0.0), splat(simd, 1.0), splat(simd, 0.5));
    let mut unrest = Unrest { residual: zero, energy: zero };
    let normal = normal_velocities::<S, N>(simd, block, tangents, n, relative, &sides);
    let speed = [t[0].dot(relative), t[1].dot(relative)];
    for i in 0..many::<N>(block.size) {
        let (p, disk) = (&block.points[i], &block.disks[i]);
        let lambda = load(simd, &p.lambda);
        let w = normal[i] + load(simd, &p.bias);
        let change = positive(simd, lambda - w * load(simd, &p.effective_mass)) - lambda;
        let reach = mu * positive(simd, lambda);
        let old = [load(simd, &disk.lambda[0]), load(simd, &disk.lambda[1])];
        let step = scalar_step(simd, disk);
        let v = point_velocity(simd, block, tangents, i, t, speed, &sides);
        let wanted = [old[0] - step * v[0], old[1] - step * v[1]];
        let square = wanted[0] * wanted[0] + wanted[1] * wanted[1];
        let mut shrink = one;
        // Not less than the limit, so that no root is rounded below it.
        if square.simd_ge(reach * reach * splat(simd, 0.999)).any_true() {
            let length = square.sqrt();
            let outside = length.simd_gt(reach);
            shrink = outside.select(reach / outside.select(length, one), one);
        }
        let slip = [shrink * wanted[0] - old[0], shrink * wanted[1] - old[1]];
        let greatest = positive(simd, change.abs() - unrest.residual) + unrest.residual;
        let sliding = (slip[0] * slip[0] + slip[1] * slip[1]).sqrt();
        unrest.residual = positive(simd, sliding - greatest) + greatest;
        unrest.energy += half * ((change * w).abs() + (slip[0] * v[0] + slip[1] * v[1]).abs());
    }
    unrest
}
