//! From arms and impulses to the rows of a block.

use super::{
    ContactBlock, DiskLanes, Masses, ONE_FOR_ALL, POINTS, RowLanes, ScaleLanes, Size, TangentLanes, many, pair, row_of,
    unit_tangents,
};
use crate::solver::wide::lanes::{Record, Symmetric, V3, inverse, load, splat, store};
use crate::solver::wide::turning::choose;
use fearless_simd::prelude::*;
use fearless_simd::{f32x8, mask32x8};

/// Of a point: arms on both bodies, and 1 where there is a point, else 0.
struct Arms<S: Simd> {
    a: V3<S>,
    b: V3<S>,
    kept: f32x8<S>,
}

impl<S: Simd> Arms<S> {
    /// Times I^−½, where bodies are round.
    #[inline(always)]
    fn weighted(&self, roots: &[Symmetric<S>; 2]) -> Self {
        let [a, b] = roots;
        let (a, b) = (self.a.times(a.upper.x * self.kept), self.b.times(b.upper.x * self.kept));
        Self { a, b, kept: self.kept }
    }

    /// J' along `axes`.
    #[inline(always)]
    fn rows(&self, axes: [V3<S>; 3], roots: &[Symmetric<S>; 2]) -> [RowLanes<S>; 3] {
        let arms = Self { a: self.a.times(self.kept), b: self.b.times(self.kept), kept: self.kept };
        let [n, t1, t2] = axes;
        let mut rows = [arms.round_row(n), arms.round_row(t1), arms.round_row(t2)];
        for row in &mut rows {
            *row = RowLanes { angular_a: roots[0].times(row.angular_a), angular_b: roots[1].times(row.angular_b) };
        }
        rows
    }

    /// J' along an axis, from weighted arms.
    #[inline(always)]
    fn round_row(&self, axis: V3<S>) -> RowLanes<S> {
        RowLanes { angular_a: self.a.cross(axis), angular_b: axis.cross(self.b) }
    }
}

/// I^−½ times normal and tangents, of both bodies: J' of all rows of all points of a manifold follow from these.
struct Frame<S: Simd> {
    a: [V3<S>; 3],
    b: [V3<S>; 3],
}

impl<S: Simd> Frame<S> {
    #[inline(always)]
    fn new([n, t1, t2]: [V3<S>; 3], [a, b]: &[Symmetric<S>; 2]) -> Self {
        Self { a: [a.times(n), a.times(t1), a.times(t2)], b: [b.times(n), b.times(t1), b.times(t2)] }
    }

    /// J' of the rows along `axes` of a point.
    #[inline(always)]
    fn rows(&self, arms: &Arms<S>, axes: [V3<S>; 3]) -> [RowLanes<S>; 3] {
        let of_a = turned(&self.a, arms.a.times(arms.kept), axes);
        let of_b = turned(&self.b, arms.b.times(-arms.kept), axes);
        [
            RowLanes { angular_a: of_a[0], angular_b: of_b[0] },
            RowLanes { angular_a: of_a[1], angular_b: of_b[1] },
            RowLanes { angular_a: of_a[2], angular_b: of_b[2] },
        ]
    }
}

/// I^−½(r × d) along normal and tangents d: r in these axes, which are right-handed in the order t1, t2, n.
#[inline(always)]
fn turned<S: Simd>([n, t1, t2]: &[V3<S>; 3], arm: V3<S>, axes: [V3<S>; 3]) -> [V3<S>; 3] {
    let (along, one, two) = (arm.dot(axes[0]), arm.dot(axes[1]), arm.dot(axes[2]));
    [t1.times(two).minus(t2.times(one)), t2.times(along).minus(n.times(two)), n.times(one).minus(t1.times(along))]
}

/// From arms and impulses to rows: a block as it was filled becomes one that can be visited. `roots` holds I^−½ of all
/// bodies.
#[inline(always)]
pub fn prepare<S: Simd>(
    simd: S,
    block: &mut ContactBlock,
    tangents: Option<&mut TangentLanes>,
    scale: &ScaleLanes,
    roots: &[Record],
) {
    match tangents {
        Some(lanes) => {
            by_size!(block.size, N => prepare_points::<S, N>(simd, block, Some(lanes), scale, roots))
        }
        None => by_size!(block.size, N => prepare_points::<S, N>(simd, block, None, scale, roots)),
    }
}

#[inline(always)]
fn prepare_points<S: Simd, const N: usize>(
    simd: S,
    block: &mut ContactBlock,
    mut tangents: Option<&mut TangentLanes>,
    scale: &ScaleLanes,
    roots: &[Record],
) {
    let n = V3::load(simd, &block.normal);
    let t = unit_tangents(simd, n);
    let masses = Masses::of(simd, block, scale);
    let roots = [Symmetric::gather(simd, roots, &block.body_a), Symmetric::gather(simd, roots, &block.body_b)];
    let axes = [n, t[0], t[1]];
    let frame = Frame::new(axes, &roots);
    let (zero, half) = (splat(simd, 0.0), splat(simd, 0.5));
    let mut normals = [RowLanes { angular_a: n, angular_b: n }; N];
    for i in 0..many::<N>(block.size) {
        let (p, disk) = (&mut block.points[i], &mut block.disks[i]);
        let exists = load(simd, &p.effective_mass).simd_gt(zero);
        let kept = exists.select(splat(simd, 1.0), zero);
        let (arm_a, arm_b) = (V3::load(simd, &p.angular_a), V3::load(simd, &p.angular_b));
        let s = load(simd, &p.separation);
        store(s, &mut p.bias);
        // Arms to the middle of the gap, as in `constraint/contact.rs`.
        let mut shift = half * s;
        if s.simd_gt(zero).any_true() {
            let (length_a, length_b) = (arm_a.dot(arm_a).sqrt(), arm_b.dot(arm_b).sqrt());
            let shorter = length_a.simd_lt(length_b).select(length_a, length_b);
            let from_afar = s.simd_gt(splat(simd, 0.1) * shorter);
            shift = from_afar.select(zero, shift);
        }
        let shift = n.times(shift);
        let (arm_a, arm_b) = (arm_a.minus(shift), arm_b.plus(shift));
        let arms = Arms { a: arm_a, b: arm_b, kept };

        let (normal, tangent);
        match tangents.as_deref_mut() {
            Some(lanes) => {
                // A frame pays from two points on.
                let is_single = many::<N>(block.size) == 1;
                let rows = if is_single { arms.rows(axes, &roots) } else { frame.rows(&arms, axes) };
                normal = rows[0];
                tangent = [rows[1], rows[2]];
                normal.angular_a.store(&mut p.angular_a);
                normal.angular_b.store(&mut p.angular_b);
                for k in 0..2 {
                    tangent[k].angular_a.store(&mut lanes.angular_a[i][k]);
                    tangent[k].angular_b.store(&mut lanes.angular_b[i][k]);
                }
            }
            None => {
                let arms = arms.weighted(&roots);
                normal = arms.round_row(n);
                tangent = [arms.round_row(t[0]), arms.round_row(t[1])];
                arms.a.store(&mut p.angular_a);
                arms.b.store(&mut p.angular_b);
            }
        }
        let k = normal.inner(&normal, &masses);
        store(k, &mut p.k);
        store(exists.select(inverse(simd, k), zero), &mut p.effective_mass);
        store(zero, &mut p.total);
        normals[i] = normal;
        prepare_disk(simd, disk, &tangent, &masses, kept);
    }
    couple(block, &normals, &masses);
}

#[inline(always)]
fn couple<S: Simd, const N: usize>(block: &mut ContactBlock, normals: &[RowLanes<S>; N], masses: &Masses<S>) {
    for i in 0..many::<N>(block.size) {
        for j in i + 1..many::<N>(block.size) {
            store(normals[i].inner(&normals[j], masses), &mut block.coupling[pair(i, j)]);
        }
    }
}

/// Rows of the lanes `turned` for other inertias: `old` holds I^½ of all bodies as rows have them, `new` I^−½ as they shall.
/// Those of round bodies do not change.
#[inline(always)]
pub fn reweigh<S: Simd>(
    simd: S,
    block: &mut ContactBlock,
    tangents: &mut TangentLanes,
    scale: &ScaleLanes,
    old: &[Record],
    new: &[Record],
    turned: u8,
) {
    by_size!(block.size, N => reweigh_points::<S, N>(simd, block, tangents, scale, old, new, turned))
}

#[inline(always)]
fn reweigh_points<S: Simd, const N: usize>(
    simd: S,
    block: &mut ContactBlock,
    tangents: &mut TangentLanes,
    scale: &ScaleLanes,
    old: &[Record],
    new: &[Record],
    turned: u8,
) {
    let n = V3::load(simd, &block.normal);
    let masses = Masses::of(simd, block, scale);
    let change = Reweighing {
        turned: mask32x8::from_bitmask(simd, turned.into()),
        old: [Symmetric::gather(simd, old, &block.body_a), Symmetric::gather(simd, old, &block.body_b)],
        new: [Symmetric::gather(simd, new, &block.body_a), Symmetric::gather(simd, new, &block.body_b)],
    };
    let mut normals = [RowLanes { angular_a: n, angular_b: n }; N];
    for i in 0..many::<N>(block.size) {
        let (p, disk) = (&mut block.points[i], &mut block.disks[i]);
        let exists = load(simd, &p.effective_mass).simd_gt(splat(simd, 0.0));
        let normal = change.of(row_of(simd, &p.angular_a, &p.angular_b));
        let k = normal.inner(&normal, &masses);
        let zero = splat(simd, 0.0);
        store(k, &mut p.k);
        store(exists.select(inverse(simd, k), zero), &mut p.effective_mass);
        normal.angular_a.store(&mut p.angular_a);
        normal.angular_b.store(&mut p.angular_b);
        normals[i] = normal;
        let tangent = [
            change.of(row_of(simd, &tangents.angular_a[i][0], &tangents.angular_b[i][0])),
            change.of(row_of(simd, &tangents.angular_a[i][1], &tangents.angular_b[i][1])),
        ];
        for k in 0..2 {
            tangent[k].angular_a.store(&mut tangents.angular_a[i][k]);
            tangent[k].angular_b.store(&mut tangents.angular_b[i][k]);
        }
        prepare_disk(simd, disk, &tangent, &masses, exists.select(splat(simd, 1.0), zero));
    }
    couple(block, &normals, &masses);
}

/// From rows with one inertia of A and B to rows with another, in some lanes.
struct Reweighing<S: Simd> {
    turned: mask32x8<S>,
    old: [Symmetric<S>; 2],
    new: [Symmetric<S>; 2],
}

impl<S: Simd> Reweighing<S> {
    #[inline(always)]
    fn of(&self, row: RowLanes<S>) -> RowLanes<S> {
        let of_a = self.new[0].times(self.old[0].times(row.angular_a));
        let of_b = self.new[1].times(self.old[1].times(row.angular_b));
        RowLanes {
            angular_a: choose(self.turned, of_a, row.angular_a),
            angular_b: choose(self.turned, of_b, row.angular_b),
        }
    }
}

/// The inverse of the 2 × 2 system of a disk, as `reference.rs` has it.
#[inline(always)]
fn prepare_disk<S: Simd>(simd: S, disk: &mut DiskLanes, rows: &[RowLanes<S>; 2], m: &Masses<S>, exists: f32x8<S>) {
    let (k1, k2) = (rows[0].inner(&rows[0], m), rows[1].inner(&rows[1], m));
    let c = rows[0].inner_across(&rows[1], m);
    let (m1, m2) = (exists * inverse(simd, k1), exists * inverse(simd, k2));
    let determinant = splat(simd, 1.0) - c * c * m1 * m2;
    let well = determinant.simd_gt(splat(simd, 1e-3));
    let share = well.select(inverse(simd, determinant), splat(simd, 1.0));
    let (mut i11, mut i22, mut i12) = (m1 * share, m2 * share, -(c * m1 * m2 * share));
    if !well.all_true() {
        let half = splat(simd, 0.5) * (k1 - k2);
        let greatest = splat(simd, 0.5) * (k1 + k2) + (half * half + c * c).sqrt();
        let step = exists * inverse(simd, greatest);
        (i11, i22, i12) = (well.select(i11, step), well.select(i22, step), well.select(i12, splat(simd, 0.0)));
    }
    store(i11, &mut disk.inverse[0]);
    store(i12, &mut disk.inverse[1]);
    store(i22, &mut disk.inverse[2]);
}
