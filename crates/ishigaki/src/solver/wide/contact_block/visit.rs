//! A visit to a block, and a look at it without one.

use super::{ContactBlock, DiskLanes, Masses, POINTS, ScaleLanes, Size, SweepPass, pair, row_of, tangents};
use crate::solver::wide::lanes::{Record, Sides, V3, load, positive, splat, store};
use fearless_simd::f32x8;
use fearless_simd::prelude::*;

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
    let mut sides = Sides::gather(simd, velocities, &block.body_a, &block.body_b);
    visit_normals::<S, N>(simd, block, n, &masses, &mut sides, pass.passes);
    let t = tangents(simd, n);
    let mu = load(simd, &block.friction);
    for i in 0..N {
        let reach = mu * positive(simd, load(simd, &block.points[i].lambda));
        visit_disk(simd, &mut block.disks[i], t, reach, &masses, &mut sides);
    }
    sides.scatter(simd, velocities, &block.body_a, &block.body_b);
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
    let sides = Sides::gather(simd, velocities, &block.body_a, &block.body_b);
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
