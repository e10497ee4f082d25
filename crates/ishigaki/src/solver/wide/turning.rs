//! Rotations of eight movers side by side: ω = I⁻¹L, its free acceleration, and the symmetric splitting of
//! `motion/splitting.rs`.
//!
//! The formulas are those of one body, in lanes. What is rare stays with one body: other schemes, and turns of half a radian
//! and more in a substep, where series end. So do balls and cubes, for which all of this is a product.

use crate::math::{Quat, Vec3};
use crate::motion::SERIES_LIMIT;
use crate::options::RotationScheme;
use crate::solver::wide::lanes::{LANES, Lane, Q4, Record, V3, inverse as inverse_of, load, splat};
use crate::solver::wide::mover::Mover;
use fearless_simd::f32x8;
use fearless_simd::prelude::*;

/// What eight movers are about to do.
struct Spins<S: Simd> {
    rotation: Q4<S>,
    /// `local_from_principal`.
    frame: Q4<S>,
    /// 1/I about the principal axes.
    inverse: V3<S>,
    /// L.
    momentum: V3<S>,
}

/// Numbers of eight movers: 4 of the rotation, 4 of the frame, 3 of 1/I, 3 of L.
type Numbers = [Lane; 14];

/// Of the movers with these indices, eight at most.
fn numbers_of(movers: &[Mover], indices: &[u32]) -> Numbers {
    let mut numbers = [[0.0; LANES]; 14];
    // Lanes beyond the movers hold rotations that are none.
    (numbers[3], numbers[7]) = ([1.0; LANES], [1.0; LANES]);
    for (lane, &index) in indices.iter().enumerate() {
        let spin = movers[index as usize].spin();
        let (r, p) = (spin.rotation.to_array(), spin.principal_frame.to_array());
        let (i, l) = (spin.inverse_principal_inertia, spin.angular_momentum);
        let all = [r[0], r[1], r[2], r[3], p[0], p[1], p[2], p[3], i.x, i.y, i.z, l.x, l.y, l.z];
        for (lanes, number) in numbers.iter_mut().zip(all) {
            lanes[lane] = number;
        }
    }
    numbers
}

#[inline(always)]
fn vector<S: Simd>(simd: S, n: &Numbers, at: usize) -> V3<S> {
    V3 { x: load(simd, &n[at]), y: load(simd, &n[at + 1]), z: load(simd, &n[at + 2]) }
}

impl<S: Simd> Spins<S> {
    #[inline(always)]
    fn load(simd: S, n: &Numbers) -> Self {
        Self {
            rotation: Q4 { v: vector(simd, n, 0), w: load(simd, &n[3]) },
            frame: Q4 { v: vector(simd, n, 4), w: load(simd, &n[7]) },
            inverse: vector(simd, n, 8),
            momentum: vector(simd, n, 11),
        }
    }

    /// L in principal axes.
    #[inline(always)]
    fn principal_momentum(&self, simd: S) -> V3<S> {
        self.rotation.after(self.frame).conjugate(simd).turn(simd, self.momentum)
    }

    /// I⁻¹L in world of an L in principal axes.
    #[inline(always)]
    fn velocity(&self, simd: S, rotation: Q4<S>, l: V3<S>) -> V3<S> {
        let w = V3 { x: l.x * self.inverse.x, y: l.y * self.inverse.y, z: l.z * self.inverse.z };
        rotation.after(self.frame).turn(simd, w)
    }
}

fn vector_of(lanes: &[Lane; 3], lane: usize) -> Vec3 {
    Vec3::new(lanes[0][lane], lanes[1][lane], lanes[2][lane])
}

/// ω = I⁻¹L of up to eight movers, where L has changed.
#[inline(always)]
pub fn find_spins<S: Simd>(simd: S, movers: &mut [Mover], indices: &[u32]) {
    let numbers = numbers_of(movers, indices);
    let spins = Spins::load(simd, &numbers);
    let l = spins.principal_momentum(simd);
    let mut found = [[0.0; LANES]; 3];
    spins.velocity(simd, spins.rotation, l).store(&mut found);
    for (lane, &index) in indices.iter().enumerate() {
        movers[index as usize].take_spin(vector_of(&found, lane));
    }
}

/// ω̇ of free turning of up to eight movers, I⁻¹(L × ω), rad/s²; into the angular parts of their records.
#[inline(always)]
pub fn find_gyrations<S: Simd>(simd: S, movers: &[Mover], indices: &[u32], records: &mut [Record]) {
    let mut numbers = numbers_of(movers, indices);
    for (lane, &index) in indices.iter().enumerate() {
        let spin = movers[index as usize].spin();
        let torque = spin.angular_momentum.cross(spin.angular_velocity);
        (numbers[11][lane], numbers[12][lane], numbers[13][lane]) = (torque.x, torque.y, torque.z);
    }
    let spins = Spins::load(simd, &numbers);
    let l = spins.principal_momentum(simd);
    let mut found = [[0.0; LANES]; 3];
    spins.velocity(simd, spins.rotation, l).store(&mut found);
    for (lane, &index) in indices.iter().enumerate() {
        let gyration = vector_of(&found, lane);
        records[index as usize + 1].0[4..7].copy_from_slice(&gyration.to_array());
    }
}

/// I^½ and I^−½ in world, xx, xy, xz, yy, yz, zz, of the movers with these indices, by lane.
pub struct Roots {
    /// I^½.
    pub root: [Lane; 6],
    /// I^−½.
    pub inverse: [Lane; 6],
}

/// I^½ and I^−½ of up to eight movers for their rotations as they are.
#[inline(always)]
pub fn roots_of<S: Simd>(simd: S, movers: &[Mover], indices: &[u32]) -> Roots {
    let numbers = numbers_of(movers, indices);
    let spins = Spins::load(simd, &numbers);
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let axes = spins.rotation.after(spins.frame);
    let axes = [
        axes.turn(simd, V3 { x: one, y: zero, z: zero }),
        axes.turn(simd, V3 { x: zero, y: one, z: zero }),
        axes.turn(simd, V3 { x: zero, y: zero, z: one }),
    ];
    let inverse = [spins.inverse.x.sqrt(), spins.inverse.y.sqrt(), spins.inverse.z.sqrt()];
    let root = [inverse_of(simd, inverse[0]), inverse_of(simd, inverse[1]), inverse_of(simd, inverse[2])];
    let mut found = Roots { root: [[0.0; LANES]; 6], inverse: [[0.0; LANES]; 6] };
    store_symmetric(&axes, &root, &mut found.root);
    store_symmetric(&axes, &inverse, &mut found.inverse);
    found
}

/// A diag(d) Aᵀ for the columns of A.
#[inline(always)]
fn store_symmetric<S: Simd>(axes: &[V3<S>; 3], d: &[f32x8<S>; 3], out: &mut [Lane; 6]) {
    let [a, b, c] = *axes;
    let (da, db, dc) = (a.times(d[0]), b.times(d[1]), c.times(d[2]));
    (a.x * da.x + b.x * db.x + c.x * dc.x).store_slice(&mut out[0]);
    (a.x * da.y + b.x * db.y + c.x * dc.y).store_slice(&mut out[1]);
    (a.x * da.z + b.x * db.z + c.x * dc.z).store_slice(&mut out[2]);
    (a.y * da.y + b.y * db.y + c.y * dc.y).store_slice(&mut out[3]);
    (a.y * da.z + b.y * db.z + c.y * dc.z).store_slice(&mut out[4]);
    (a.z * da.z + b.z * db.z + c.z * dc.z).store_slice(&mut out[5]);
}

/// sin x and 1 − cos x from the series of `motion/mod.rs`.
#[inline(always)]
fn sine_versine<S: Simd>(simd: S, x: f32x8<S>) -> (f32x8<S>, f32x8<S>) {
    let one = splat(simd, 1.0);
    let square = x * x;
    let sine = one - square * splat(simd, 1.0 / 42.0);
    let sine = one - square * splat(simd, 1.0 / 20.0) * sine;
    let sine = x * (one - square * splat(simd, 1.0 / 6.0) * sine);
    let versine = one - square * splat(simd, 1.0 / 30.0) * (one - square * splat(simd, 1.0 / 56.0));
    let versine = splat(simd, 0.5) * square * (one - square * splat(simd, 1.0 / 12.0) * versine);
    (sine, versine)
}

/// The turn so far, as its difference from none, and L in principal axes.
struct Turning<S: Simd> {
    turn: [f32x8<S>; 4],
    momentum: [f32x8<S>; 3],
    /// Greatest half angle about an axis.
    greatest: f32x8<S>,
}

impl<S: Simd> Turning<S> {
    /// `motion/splitting.rs`, `turn_about`.
    #[inline(always)]
    fn about<const A: usize>(&mut self, simd: S, tau_by_inertia: f32x8<S>) {
        let (a, b, c) = (A, (A + 1) % 3, (A + 2) % 3);
        let two = splat(simd, 2.0);
        let half = splat(simd, 0.5) * tau_by_inertia * self.momentum[a];
        let size = half.abs();
        self.greatest = size.simd_gt(self.greatest).select(size, self.greatest);
        let (sine, versine) = sine_versine(simd, half);
        let (sine_whole, versine_whole) = (two * sine * (splat(simd, 1.0) - versine), two * sine * sine);
        let (mb, mc) = (self.momentum[b], self.momentum[c]);
        self.momentum[b] = mb + (sine_whole * mc - versine_whole * mb);
        self.momentum[c] = mc - (sine_whole * mb + versine_whole * mc);
        let q = self.turn;
        self.turn[a] = q[a] + (sine + sine * q[3] - versine * q[a]);
        self.turn[b] = q[b] + (sine * q[c] - versine * q[b]);
        self.turn[c] = q[c] - (sine * q[b] + versine * q[c]);
        self.turn[3] = q[3] - (versine + versine * q[3] + sine * q[a]);
    }
}

/// Turns up to eight movers over `h` seconds, those that turn too far for series one by one.
#[inline(always)]
pub fn turn<S: Simd>(simd: S, movers: &mut [Mover], indices: &[u32], h: f32) {
    let numbers = numbers_of(movers, indices);
    let spins = Spins::load(simd, &numbers);
    let l = spins.principal_momentum(simd);
    let (zero, step, half) = (splat(simd, 0.0), splat(simd, h), splat(simd, 0.5 * h));
    let mut turning = Turning { turn: [zero; 4], momentum: [l.x, l.y, l.z], greatest: zero };
    turning.about::<0>(simd, half * spins.inverse.x);
    turning.about::<1>(simd, half * spins.inverse.y);
    turning.about::<2>(simd, step * spins.inverse.z);
    turning.about::<1>(simd, half * spins.inverse.y);
    turning.about::<0>(simd, half * spins.inverse.x);
    let [x, y, z, w] = turning.turn;
    // From principal to local axes, then R + R·change with one Newton step toward unit length: `motion/mod.rs`, `changed`.
    let change = spins.rotation.after(Q4 { v: spins.frame.turn(simd, V3 { x, y, z }), w });
    let r = spins.rotation;
    let square = r.v.dot(r.v) + r.w * r.w;
    let scale = splat(simd, 0.5) - splat(simd, 0.5) * square;
    let v = r.v.plus(change.v.plus(r.v.times(scale)));
    let rotation = Q4 { v, w: r.w + (change.w + r.w * scale) };
    let [mx, my, mz] = turning.momentum;
    let mut found = [[0.0; LANES]; 7];
    for (lanes, value) in found.iter_mut().zip([rotation.v.x, rotation.v.y, rotation.v.z, rotation.w]) {
        value.store_slice(lanes);
    }
    let velocity = spins.velocity(simd, rotation, V3 { x: mx, y: my, z: mz });
    velocity.x.store_slice(&mut found[4]);
    velocity.y.store_slice(&mut found[5]);
    velocity.z.store_slice(&mut found[6]);
    let mut greatest = [0.0; LANES];
    turning.greatest.store_slice(&mut greatest);
    for (lane, &index) in indices.iter().enumerate() {
        let mover = &mut movers[index as usize];
        if greatest[lane] < SERIES_LIMIT {
            let [x, y, z, w] = [0, 1, 2, 3].map(|k| found[k][lane]);
            let velocity = Vec3::new(found[4][lane], found[5][lane], found[6][lane]);
            mover.take_turn(Quat::from_xyzw(x, y, z, w), velocity);
        } else {
            mover.turn(RotationScheme::Splitting, h);
        }
    }
}
