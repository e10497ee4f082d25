//! Eight values side by side, and vectors of them: what the kernels of the wide path are written in.
//!
//! Storage is always eight lanes wide; a machine with four computes each half in turn. A lane never looks at its
//! neighbors and nothing is fused, so that every width gives the same bits.

use crate::math::Vec3;
use fearless_simd::prelude::*;
use fearless_simd::{f32x4, f32x8, mask32x8};

/// Lanes of a block.
pub const LANES: usize = 8;
/// One number of each lane, as stored.
pub type Lane = [f32; LANES];
/// One vector of each lane, as stored.
pub type Lane3 = [Lane; 3];

/// Velocity or displacement of a body: linear x, y, z, 0, angular x, y, z, 0.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Record(pub [f32; 8]);

impl Record {
    /// Whether it is marked: in what lies beside its numbers.
    pub fn is_marked(&self) -> bool {
        self.0[3] != 0.0
    }

    /// Marks it, or not.
    pub fn set_marked(&mut self, marked: bool) {
        self.0[3] = if marked { 1.0 } else { 0.0 };
    }
}

/// A vector in each lane.
#[derive(Clone, Copy)]
pub struct V3<S: Simd> {
    /// x of each lane.
    pub x: f32x8<S>,
    /// y of each lane.
    pub y: f32x8<S>,
    /// z of each lane.
    pub z: f32x8<S>,
}

/// Puts a vector into a lane.
pub fn set(lanes: &mut Lane3, lane: usize, v: Vec3) {
    (lanes[0][lane], lanes[1][lane], lanes[2][lane]) = (v.x, v.y, v.z);
}

/// The vector of a lane.
pub fn get(lanes: &Lane3, lane: usize) -> Vec3 {
    Vec3::new(lanes[0][lane], lanes[1][lane], lanes[2][lane])
}

/// Reads eight numbers.
#[inline(always)]
pub fn load<S: Simd>(simd: S, lane: &Lane) -> f32x8<S> {
    f32x8::from_slice(simd, lane)
}

/// Writes eight numbers.
#[inline(always)]
pub fn store<S: Simd>(value: f32x8<S>, lane: &mut Lane) {
    value.store_slice(lane);
}

/// The same number in each lane.
#[inline(always)]
pub fn splat<S: Simd>(simd: S, value: f32) -> f32x8<S> {
    f32x8::splat(simd, value)
}

/// `x` where it is positive, else 0; also for NaN.
#[inline(always)]
pub fn positive<S: Simd>(simd: S, x: f32x8<S>) -> f32x8<S> {
    let zero = splat(simd, 0.0);
    x.simd_gt(zero).select(x, zero)
}

/// 1/x where x is positive, else 0.
#[inline(always)]
pub fn inverse<S: Simd>(simd: S, x: f32x8<S>) -> f32x8<S> {
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let is_some = x.simd_gt(zero);
    is_some.select(one / is_some.select(x, one), zero)
}

impl<S: Simd> V3<S> {
    /// Reads eight vectors.
    #[inline(always)]
    pub fn load(simd: S, lanes: &Lane3) -> Self {
        Self { x: load(simd, &lanes[0]), y: load(simd, &lanes[1]), z: load(simd, &lanes[2]) }
    }

    /// Writes eight vectors.
    #[inline(always)]
    pub fn store(self, lanes: &mut Lane3) {
        store(self.x, &mut lanes[0]);
        store(self.y, &mut lanes[1]);
        store(self.z, &mut lanes[2]);
    }

    /// Scalar product.
    #[inline(always)]
    pub fn dot(self, o: Self) -> f32x8<S> {
        self.x * o.x + self.y * o.y + self.z * o.z
    }

    /// Vector product.
    #[inline(always)]
    pub fn cross(self, o: Self) -> Self {
        Self { x: self.y * o.z - o.y * self.z, y: self.z * o.x - o.z * self.x, z: self.x * o.y - o.x * self.y }
    }

    /// Times a number.
    #[inline(always)]
    pub fn times(self, s: f32x8<S>) -> Self {
        Self { x: self.x * s, y: self.y * s, z: self.z * s }
    }

    /// Sum.
    #[inline(always)]
    pub fn plus(self, o: Self) -> Self {
        Self { x: self.x + o.x, y: self.y + o.y, z: self.z + o.z }
    }

    /// Difference.
    #[inline(always)]
    pub fn minus(self, o: Self) -> Self {
        Self { x: self.x - o.x, y: self.y - o.y, z: self.z - o.z }
    }
}

/// A rotation in each lane.
#[derive(Clone, Copy)]
pub struct Q4<S: Simd> {
    /// Vector part.
    pub v: V3<S>,
    /// Scalar part.
    pub w: f32x8<S>,
}

impl<S: Simd> Q4<S> {
    /// Reads eight rotations.
    #[inline(always)]
    pub fn load(simd: S, lanes: &[Lane; 4]) -> Self {
        let v = V3 { x: load(simd, &lanes[0]), y: load(simd, &lanes[1]), z: load(simd, &lanes[2]) };
        Self { v, w: load(simd, &lanes[3]) }
    }

    /// The turned vector: v + 2w(q × v) + 2 q × (q × v).
    #[inline(always)]
    pub fn turn(self, simd: S, v: V3<S>) -> V3<S> {
        let t = self.v.cross(v).times(splat(simd, 2.0));
        v.plus(t.times(self.w)).plus(self.v.cross(t))
    }

    /// This rotation after the other.
    #[inline(always)]
    pub fn after(self, o: Self) -> Self {
        let v = self.v.cross(o.v).plus(o.v.times(self.w)).plus(self.v.times(o.w));
        Self { v, w: self.w * o.w - self.v.dot(o.v) }
    }

    /// The other way around.
    #[inline(always)]
    pub fn conjugate(self, simd: S) -> Self {
        Self { v: self.v.times(splat(simd, -1.0)), w: self.w }
    }
}

/// The angle of (x, y), rad, to 1e-7; 0 where both are 0.
///
/// Of the smaller over the greater of |x| and |y| = t: above tan(π/8) by atan t = π/4 + atan((t − 1)/(t + 1)), then by
/// a polynomial through nodes of Chebyshev, whose own error is 3e-8.
#[inline(always)]
pub fn atan2<S: Simd>(simd: S, y: f32x8<S>, x: f32x8<S>) -> f32x8<S> {
    const EIGHTH: f32 = 0.414_213_56;
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let (ax, ay) = (x.abs(), y.abs());
    let steep = ay.simd_gt(ax);
    let (small, great) = (steep.select(ax, ay), steep.select(ay, ax));
    let some = great.simd_gt(zero);
    let t = small / some.select(great, one);
    let beyond = t.simd_gt(splat(simd, EIGHTH));
    let t = beyond.select((t - one) / (t + one), t);
    let z = t * t;
    let series = splat(simd, 0.085_204_92) * z - splat(simd, 0.140_241_43);
    let series = (series * z + splat(simd, 0.199_912_38)) * z - splat(simd, 0.333_332_87);
    let angle = t + t * z * series + beyond.select(splat(simd, std::f32::consts::FRAC_PI_4), zero);
    let angle = steep.select(splat(simd, std::f32::consts::FRAC_PI_2) - angle, angle);
    let angle = x.simd_lt(zero).select(splat(simd, std::f32::consts::PI) - angle, angle);
    y.simd_lt(zero).select(-angle, angle)
}

/// Of each half: columns of four rows of four.
#[inline(always)]
fn transposed<S: Simd>(simd: S, rows: [f32x8<S>; 4]) -> [f32x8<S>; 4] {
    if S::f32s::LEN < LANES { transposed_in_turn(simd, rows) } else { transposed_at_once(simd, rows) }
}

/// One half after the other, where the machine has four lanes.
#[inline(always)]
fn transposed_in_turn<S: Simd>(simd: S, [a, b, c, d]: [f32x8<S>; 4]) -> [f32x8<S>; 4] {
    let (ac, bd) = (zip_halves(simd, a, c), zip_halves(simd, b, d));
    let (low, high) = (zip_halves(simd, ac.0, bd.0), zip_halves(simd, ac.1, bd.1));
    [low.0, low.1, high.0, high.1]
}

/// Of each half: the first two of both in turn, and the last two.
#[inline(always)]
fn zip_halves<S: Simd>(simd: S, a: f32x8<S>, b: f32x8<S>) -> (f32x8<S>, f32x8<S>) {
    let (low, high) = a.interleave(b);
    let (low, high) = (simd.split_f32x8(low), simd.split_f32x8(high));
    (simd.combine_f32x4(low.0, high.0), simd.combine_f32x4(low.1, high.1))
}

/// Both halves at once, by what stays within them: the compiler makes four lanes of whatever else it is said by.
#[inline(always)]
fn transposed_at_once<S: Simd>(simd: S, [a, b, c, d]: [f32x8<S>; 4]) -> [f32x8<S>; 4] {
    let (two, one) = (mask32x8::from_slice(simd, &TWO), mask32x8::from_slice(simd, &ONE));
    let (ac, bd) = (a.slide_within_blocks::<2>(c), b.slide_within_blocks::<2>(d));
    let (a, c) = (two.select(a, ac), two.select(ac, c));
    let (b, d) = (two.select(b, bd), two.select(bd, d));
    [
        one.select(a, b.slide_within_blocks::<3>(b)),
        one.select(a.slide_within_blocks::<1>(a), b),
        one.select(c, d.slide_within_blocks::<3>(d)),
        one.select(c.slide_within_blocks::<1>(c), d),
    ]
}

/// The first two of each four.
const TWO: [i32; LANES] = [-1, -1, 0, 0, -1, -1, 0, 0];
/// The first of each two.
const ONE: [i32; LANES] = [-1, 0, -1, 0, -1, 0, -1, 0];

/// Records of eight bodies; written out, for a closure would be a call.
#[inline(always)]
fn of<'a>(records: &'a [Record], [a, b, c, d, e, f, g, h]: &[u32; LANES]) -> [&'a Record; LANES] {
    [
        &records[*a as usize],
        &records[*b as usize],
        &records[*c as usize],
        &records[*d as usize],
        &records[*e as usize],
        &records[*f as usize],
        &records[*g as usize],
        &records[*h as usize],
    ]
}

/// Columns of one half of eight records: of the first four in the low halves, of the others in the high ones.
#[inline(always)]
fn columns<S: Simd, const ANGULAR: bool>(simd: S, records: [&Record; LANES]) -> [f32x8<S>; 4] {
    transposed(
        simd,
        [
            pair::<S, ANGULAR>(simd, records[0], records[4]),
            pair::<S, ANGULAR>(simd, records[1], records[5]),
            pair::<S, ANGULAR>(simd, records[2], records[6]),
            pair::<S, ANGULAR>(simd, records[3], records[7]),
        ],
    )
}

#[inline(always)]
fn pair<S: Simd, const ANGULAR: bool>(simd: S, low: &Record, high: &Record) -> f32x8<S> {
    let at = if ANGULAR { 4 } else { 0 };
    simd.combine_f32x4(f32x4::from_slice(simd, &low.0[at..at + 4]), f32x4::from_slice(simd, &high.0[at..at + 4]))
}

/// Both halves of eight records.
#[inline(always)]
fn halves<S: Simd>(simd: S, records: [&Record; LANES]) -> (V3<S>, V3<S>) {
    let (l, a) = (columns::<S, false>(simd, records), columns::<S, true>(simd, records));
    (V3 { x: l[0], y: l[1], z: l[2] }, V3 { x: a[0], y: a[1], z: a[2] })
}

/// Linear and angular parts of the records of eight bodies.
#[inline(always)]
pub fn gather<S: Simd>(simd: S, records: &[Record], bodies: &[u32; LANES]) -> (V3<S>, V3<S>) {
    halves(simd, of(records, bodies))
}

/// Centers and rotations of eight poses: x, y, z, 0, and the rotation.
#[inline(always)]
pub fn gather_poses<S: Simd>(simd: S, poses: &[Record], bodies: &[u32; LANES]) -> (V3<S>, Q4<S>) {
    let poses = of(poses, bodies);
    let (c, q) = (columns::<S, false>(simd, poses), columns::<S, true>(simd, poses));
    (V3 { x: c[0], y: c[1], z: c[2] }, Q4 { v: V3 { x: q[0], y: q[1], z: q[2] }, w: q[3] })
}

/// Linear and angular parts of eight records side by side.
#[inline(always)]
pub fn read<S: Simd>(simd: S, records: &[Record; LANES]) -> (V3<S>, V3<S>) {
    let [a, b, c, d, e, f, g, h] = records;
    halves(simd, [a, b, c, d, e, f, g, h])
}

/// Puts eight records side by side back.
#[inline(always)]
pub fn write<S: Simd>(simd: S, records: &mut [Record; LANES], linear: V3<S>, angular: V3<S>) {
    let zero = splat(simd, 0.0);
    write_rows(simd, records, rows(simd, linear, zero), rows(simd, angular, zero));
}

/// Puts eight poses side by side: x, y, z, 0, and the rotation.
#[inline(always)]
pub fn write_poses<S: Simd>(simd: S, records: &mut [Record; LANES], center: V3<S>, rotation: Q4<S>) {
    let (center, rotation) = (rows(simd, center, splat(simd, 0.0)), rows(simd, rotation.v, rotation.w));
    write_rows(simd, records, center, rotation);
}

#[inline(always)]
fn write_rows<S: Simd>(simd: S, records: &mut [Record; LANES], linear: [f32x8<S>; 4], angular: [f32x8<S>; 4]) {
    for i in 0..LANES / 2 {
        let (linear, angular) = (simd.split_f32x8(linear[i]), simd.split_f32x8(angular[i]));
        put(&mut records[i], linear.0, angular.0);
        put(&mut records[i + 4], linear.1, angular.1);
    }
}

#[inline(always)]
fn put<S: Simd>(record: &mut Record, linear: f32x4<S>, angular: f32x4<S>) {
    linear.store_slice(&mut record.0[..4]);
    angular.store_slice(&mut record.0[4..]);
}

/// Three and one numbers of each of eight bodies: a body to a half, the first four in the low ones.
#[inline(always)]
fn rows<S: Simd>(simd: S, v: V3<S>, w: f32x8<S>) -> [f32x8<S>; 4] {
    transposed(simd, [v.x, v.y, v.z, w])
}

/// Puts the records of eight bodies back; body 0, the ground, stays as it is.
#[inline(always)]
pub fn scatter<S: Simd>(simd: S, records: &mut [Record], bodies: &[u32; LANES], linear: V3<S>, angular: V3<S>) {
    let zero = splat(simd, 0.0);
    let (linear, angular) = (rows(simd, linear, zero), rows(simd, angular, zero));
    for i in 0..LANES / 2 {
        let (linear, angular) = (simd.split_f32x8(linear[i]), simd.split_f32x8(angular[i]));
        put_back(records, bodies[i], linear.0, angular.0);
        put_back(records, bodies[i + 4], linear.1, angular.1);
    }
}

#[inline(always)]
fn put_back<S: Simd>(records: &mut [Record], body: u32, linear: f32x4<S>, angular: f32x4<S>) {
    if body != 0 {
        put(&mut records[body as usize], linear, angular);
    }
}

/// Velocities (or ways, or impulses) of the two bodies of each lane.
pub struct Sides<S: Simd> {
    /// Of A.
    pub linear_a: V3<S>,
    /// Of A.
    pub angular_a: V3<S>,
    /// Of B.
    pub linear_b: V3<S>,
    /// Of B.
    pub angular_b: V3<S>,
}

impl<S: Simd> Sides<S> {
    /// Reads both bodies of eight lanes.
    #[inline(always)]
    pub fn gather(simd: S, records: &[Record], body_a: &[u32; LANES], body_b: &[u32; LANES]) -> Self {
        let (linear_a, angular_a) = gather(simd, records, body_a);
        let (linear_b, angular_b) = gather(simd, records, body_b);
        Self { linear_a, angular_a, linear_b, angular_b }
    }

    /// Writes them.
    #[inline(always)]
    pub fn scatter(self, simd: S, records: &mut [Record], body_a: &[u32; LANES], body_b: &[u32; LANES]) {
        scatter(simd, records, body_a, self.linear_a, self.angular_a);
        scatter(simd, records, body_b, self.linear_b, self.angular_b);
    }

    /// v_A − v_B.
    #[inline(always)]
    pub fn relative(&self) -> V3<S> {
        self.linear_a.minus(self.linear_b)
    }
}

/// A symmetric matrix in each lane.
#[derive(Clone, Copy)]
pub struct Symmetric<S: Simd> {
    /// xx, xy, xz.
    pub upper: V3<S>,
    /// yy, yz, zz.
    pub lower: V3<S>,
}

impl<S: Simd> Symmetric<S> {
    /// Reads those of eight bodies; records hold xx, xy, xz, 0, yy, yz, zz, 0.
    #[inline(always)]
    pub fn gather(simd: S, records: &[Record], bodies: &[u32; LANES]) -> Self {
        let (upper, lower) = gather(simd, records, bodies);
        Self { upper, lower }
    }

    /// The product with a vector.
    #[inline(always)]
    pub fn times(&self, v: V3<S>) -> V3<S> {
        let (u, l) = (self.upper, self.lower);
        V3 {
            x: u.x * v.x + u.y * v.y + u.z * v.z,
            y: u.y * v.x + l.x * v.y + l.y * v.z,
            z: u.z * v.x + l.y * v.y + l.z * v.z,
        }
    }

    /// Its columns, which are its rows.
    #[inline(always)]
    pub fn columns(&self) -> [V3<S>; 3] {
        let (u, l) = (self.upper, self.lower);
        [u, V3 { x: u.y, y: l.x, z: l.y }, V3 { x: u.z, y: l.y, z: l.z }]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};

    #[test]
    fn angles_are_those_of_libm() {
        let mut worst = 0.0_f32;
        for i in 0..4000_u16 {
            let angle = (f32::from(i) - 2000.0) * 0.001_57;
            let (y, x) = (3.0 * crate::math::sin(angle), 3.0 * crate::math::cos(angle));
            let mut found = [0.0; 8];
            dispatch!(Level::new(), simd => store(atan2(simd, splat(simd, y), splat(simd, x)), &mut found));
            worst = worst.max((found[3] - crate::math::atan2(y, x)).abs());
        }
        assert!(worst < 5e-7, "{worst}"); // two units in the last place of π
        let mut origin = [1.0; 8];
        dispatch!(Level::new(), simd => store(atan2(simd, splat(simd, 0.0), splat(simd, 0.0)), &mut origin));
        assert_eq!(origin, [0.0; 8]);
    }

    #[test]
    fn rotations_turn_and_follow_each_other() {
        let (p, q) =
            (crate::math::Quat::from_xyzw(0.1, -0.7, 0.5, 0.5).normalize(), crate::math::Quat::from_rotation_y(0.8));
        let v = crate::math::Vec3::new(1.0, -2.0, 0.5);
        let lanes = |q: crate::math::Quat| q.to_array().map(|x| [x; 8]);
        let (mut turned, mut product) = ([[0.0; 8]; 3], [0.0; 8]);
        dispatch!(Level::new(), simd => {
            let (a, b) = (Q4::load(simd, &lanes(p)), Q4::load(simd, &lanes(q)));
            let v = V3 { x: splat(simd, v.x), y: splat(simd, v.y), z: splat(simd, v.z) };
            a.turn(simd, v).store(&mut turned);
            store(a.after(b.conjugate(simd)).w, &mut product);
        });
        let found = crate::math::Vec3::new(turned[0][5], turned[1][5], turned[2][5]);
        assert!((found - p * v).length() < 1e-6);
        assert!((product[0] - (p * q.conjugate()).w).abs() < 1e-6);
    }

    #[test]
    fn what_is_read_is_written() {
        let records: [Record; LANES] =
            std::array::from_fn(|b| Record([1.0, 2.0, 3.0, 0.0, 4.0, 5.0, 6.0, 0.0].map(|x: f32| x * (b + 1) as f32)));
        let (mut back, mut poses) = ([Record([9.0; 8]); LANES], [Record::default(); LANES]);
        dispatch!(Level::new(), simd => {
            let (linear, angular) = read(simd, &records);
            write(simd, &mut back, linear, angular);
            write_poses(simd, &mut poses, linear, Q4 { v: angular, w: splat(simd, 7.0) });
        });
        assert_eq!(back, records);
        assert_eq!(poses[5].0, [6.0, 12.0, 18.0, 0.0, 24.0, 30.0, 36.0, 7.0]);
    }

    #[test]
    fn what_is_gathered_is_scattered() {
        let mut records: Vec<Record> =
            (0..9).map(|b| Record([1.0, 2.0, 3.0, 0.0, 4.0, 5.0, 6.0, 0.0].map(|x: f32| x * b as f32))).collect();
        let before = records.clone();
        let bodies = [3, 1, 2, 0, 8, 6, 7, 5];
        dispatch!(Level::new(), simd => {
            let (linear, angular) = gather(simd, &records, &bodies);
            let mut xs = [0.0; 8];
            store(angular.y, &mut xs);
            assert_eq!(xs, bodies.map(|b| 5.0 * b as f32));
            scatter(simd, &mut records, &bodies, linear.times(splat(simd, 2.0)), angular);
        });
        for (b, (new, old)) in records.iter().zip(&before).enumerate() {
            let scale = if bodies.contains(&(b as u32)) { 2.0 } else { 1.0 };
            assert_eq!(new.0[..3], [0, 1, 2].map(|k| scale * old.0[k]));
            assert_eq!(new.0[4..], old.0[4..]);
        }
    }
}
