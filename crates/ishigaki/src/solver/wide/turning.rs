//! Rotations of eight bodies side by side: ω = I⁻¹L, I^±½ in world, and the symmetric splitting of `motion/splitting.rs`.
//!
//! The formulas are those of one body, in lanes. What is rare stays with one body: other schemes, and turns of half a radian
//! and more in a substep, where series end. For balls and cubes, round in what follows, L is parallel to ω and all of this
//! is a product.

use crate::motion::{self, SERIES_LIMIT};
use crate::options::RotationScheme;
use crate::solver::wide::lanes::{LANES, Q4, Symmetric, V3, load, splat, store};
use crate::solver::wide::mover::{Lane6, MoverBlock};
use fearless_simd::prelude::*;
use fearless_simd::{f32x8, mask32x8};

/// Reads eight symmetric matrices.
#[inline(always)]
pub fn symmetric<S: Simd>(simd: S, lanes: &Lane6) -> Symmetric<S> {
    Symmetric {
        upper: V3 { x: load(simd, &lanes[0]), y: load(simd, &lanes[1]), z: load(simd, &lanes[2]) },
        lower: V3 { x: load(simd, &lanes[3]), y: load(simd, &lanes[4]), z: load(simd, &lanes[5]) },
    }
}

/// Where moments of inertia are not all the same.
#[inline(always)]
fn is_uneven<S: Simd>(simd: S, block: &MoverBlock) -> mask32x8<S> {
    mask32x8::from_bitmask(simd, block.uneven.into())
}

/// `a` where the mask is set, else `b`.
#[inline(always)]
pub fn choose<S: Simd>(mask: mask32x8<S>, a: V3<S>, b: V3<S>) -> V3<S> {
    V3 { x: mask.select(a.x, b.x), y: mask.select(a.y, b.y), z: mask.select(a.z, b.z) }
}

#[inline(always)]
fn scaled<S: Simd>(a: V3<S>, b: V3<S>) -> V3<S> {
    V3 { x: a.x * b.x, y: a.y * b.y, z: a.z * b.z }
}

/// I⁻¹L in world for the rotations given.
#[inline(always)]
pub fn inverse_inertia_times<S: Simd>(simd: S, block: &MoverBlock, rotation: Q4<S>, l: V3<S>) -> V3<S> {
    let inverse = V3::load(simd, &block.inverse_inertia);
    let round = l.times(inverse.x);
    if block.uneven == 0 {
        return round;
    }
    let axes = rotation.after(Q4::load(simd, &block.frame));
    let turned = axes.turn(simd, scaled(axes.conjugate(simd).turn(simd, l), inverse));
    choose(is_uneven(simd, block), turned, round)
}

/// ω̇ of free turning, I⁻¹(L × ω), rad/s².
#[inline(always)]
pub fn gyration<S: Simd>(simd: S, block: &MoverBlock) -> V3<S> {
    let zero = splat(simd, 0.0);
    let zero = V3 { x: zero, y: zero, z: zero };
    if block.uneven == 0 {
        return zero;
    }
    let torque = V3::load(simd, &block.momentum).cross(V3::load(simd, &block.spin));
    let rate = inverse_inertia_times(simd, block, Q4::load(simd, &block.rotation), torque);
    choose(is_uneven(simd, block), rate, zero)
}

/// A diag(d) Aᵀ for the axes A of a lane where it is uneven, else diag(d).
#[inline(always)]
fn rotated_diagonal<S: Simd>(simd: S, axes: Option<&[V3<S>; 3]>, uneven: mask32x8<S>, d: V3<S>) -> Symmetric<S> {
    let zero = splat(simd, 0.0);
    let round = Symmetric { upper: V3 { x: d.x, y: zero, z: zero }, lower: V3 { x: d.y, y: zero, z: d.z } };
    let Some([a, b, c]) = axes else { return round };
    let (da, db, dc) = (a.times(d.x), b.times(d.y), c.times(d.z));
    let upper = V3 {
        x: a.x * da.x + b.x * db.x + c.x * dc.x,
        y: a.x * da.y + b.x * db.y + c.x * dc.y,
        z: a.x * da.z + b.x * db.z + c.x * dc.z,
    };
    let lower = V3 {
        x: a.y * da.y + b.y * db.y + c.y * dc.y,
        y: a.y * da.z + b.y * db.z + c.y * dc.z,
        z: a.z * da.z + b.z * db.z + c.z * dc.z,
    };
    Symmetric { upper: choose(uneven, upper, round.upper), lower: choose(uneven, lower, round.lower) }
}

#[inline(always)]
fn root<S: Simd>(v: V3<S>) -> V3<S> {
    V3 { x: v.x.sqrt(), y: v.y.sqrt(), z: v.z.sqrt() }
}

/// I^½ and I^−½ in world for the rotations as they are.
#[inline(always)]
pub fn roots<S: Simd>(simd: S, block: &MoverBlock) -> [Symmetric<S>; 2] {
    let uneven = is_uneven(simd, block);
    let root_of = [root(V3::load(simd, &block.inertia)), root(V3::load(simd, &block.inverse_inertia))];
    if block.uneven == 0 {
        return [rotated_diagonal(simd, None, uneven, root_of[0]), rotated_diagonal(simd, None, uneven, root_of[1])];
    }
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let frame = Q4::load(simd, &block.rotation).after(Q4::load(simd, &block.frame));
    let axes = [
        frame.turn(simd, V3 { x: one, y: zero, z: zero }),
        frame.turn(simd, V3 { x: zero, y: one, z: zero }),
        frame.turn(simd, V3 { x: zero, y: zero, z: one }),
    ];
    [rotated_diagonal(simd, Some(&axes), uneven, root_of[0]), rotated_diagonal(simd, Some(&axes), uneven, root_of[1])]
}

/// sin x / x and 1 − cos x of x², from the series of `motion/mod.rs`.
#[inline(always)]
fn series<S: Simd>(simd: S, square: f32x8<S>) -> (f32x8<S>, f32x8<S>) {
    let one = splat(simd, 1.0);
    let sine = one - square * splat(simd, 1.0 / 42.0);
    let sine = one - square * splat(simd, 1.0 / 20.0) * sine;
    let sine = one - square * splat(simd, 1.0 / 6.0) * sine;
    let versine = one - square * splat(simd, 1.0 / 30.0) * (one - square * splat(simd, 1.0 / 56.0));
    let versine = splat(simd, 0.5) * square * (one - square * splat(simd, 1.0 / 12.0) * versine);
    (sine, versine)
}

/// R + change with one Newton step toward unit length: `motion/mod.rs`, `changed`.
#[inline(always)]
fn changed<S: Simd>(simd: S, r: Q4<S>, change: Q4<S>) -> Q4<S> {
    let square = r.v.dot(r.v) + r.w * r.w;
    let scale = splat(simd, 0.5) - splat(simd, 0.5) * square;
    Q4 { v: r.v.plus(change.v.plus(r.v.times(scale))), w: r.w + (change.w + r.w * scale) }
}

/// Rotations after a turn.
pub struct Turned<S: Simd> {
    /// Where series hold.
    pub rotation: Q4<S>,
    /// Where they do not.
    pub is_far: mask32x8<S>,
}

/// After `h` seconds of constant ω: `motion/mod.rs`, `turned`.
#[inline(always)]
pub fn turned<S: Simd>(simd: S, rotation: Q4<S>, angular_velocity: V3<S>, h: f32) -> Turned<S> {
    let half = angular_velocity.times(splat(simd, 0.5 * h));
    let square = half.dot(half);
    let (sine, versine) = series(simd, square);
    let change = Q4 { v: half.times(sine), w: splat(simd, 0.0) - versine }.after(rotation);
    let is_far = !square.simd_lt(splat(simd, SERIES_LIMIT * SERIES_LIMIT));
    Turned { rotation: changed(simd, rotation, change), is_far }
}

/// The turn so far, as its difference from none, and L in principal axes.
struct Splitting<S: Simd> {
    turn: [f32x8<S>; 4],
    momentum: [f32x8<S>; 3],
    /// Greatest half angle about an axis.
    greatest: f32x8<S>,
}

impl<S: Simd> Splitting<S> {
    /// `motion/splitting.rs`, `turn_about`.
    #[inline(always)]
    fn about<const A: usize>(&mut self, simd: S, tau_by_inertia: f32x8<S>) {
        let (a, b, c) = (A, (A + 1) % 3, (A + 2) % 3);
        let two = splat(simd, 2.0);
        let half = splat(simd, 0.5) * tau_by_inertia * self.momentum[a];
        let size = half.abs();
        self.greatest = size.simd_gt(self.greatest).select(size, self.greatest);
        let (sine, versine) = series(simd, half * half);
        let sine = half * sine;
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

/// R and ω of uneven bodies after `h` seconds without torque.
#[inline(always)]
fn split<S: Simd>(simd: S, block: &MoverBlock, h: f32) -> (Turned<S>, V3<S>) {
    let (rotation, frame) = (Q4::load(simd, &block.rotation), Q4::load(simd, &block.frame));
    let inverse = V3::load(simd, &block.inverse_inertia);
    let l = rotation.after(frame).conjugate(simd).turn(simd, V3::load(simd, &block.momentum));
    let (zero, step, half) = (splat(simd, 0.0), splat(simd, h), splat(simd, 0.5 * h));
    let mut splitting = Splitting { turn: [zero; 4], momentum: [l.x, l.y, l.z], greatest: zero };
    splitting.about::<0>(simd, half * inverse.x);
    splitting.about::<1>(simd, half * inverse.y);
    splitting.about::<2>(simd, step * inverse.z);
    splitting.about::<1>(simd, half * inverse.y);
    splitting.about::<0>(simd, half * inverse.x);
    let [x, y, z, w] = splitting.turn;
    // From principal to local axes.
    let change = rotation.after(Q4 { v: frame.turn(simd, V3 { x, y, z }), w });
    let rotation = changed(simd, rotation, change);
    let [x, y, z] = splitting.momentum;
    let velocity = rotation.after(frame).turn(simd, scaled(V3 { x, y, z }, inverse));
    let is_far = !splitting.greatest.simd_lt(splat(simd, SERIES_LIMIT));
    (Turned { rotation, is_far }, velocity)
}

/// Turns eight bodies over `h` seconds without torque; L stays, ω follows.
#[inline(always)]
pub fn turn<S: Simd>(simd: S, block: &mut MoverBlock, scheme: RotationScheme, h: f32) {
    if scheme != RotationScheme::Splitting {
        for lane in 0..LANES {
            turn_one(block, lane, scheme, h);
        }
        return;
    }
    let rotation = Q4::load(simd, &block.rotation);
    let mut velocity = V3::load(simd, &block.momentum).times(load(simd, &block.inverse_inertia[0]));
    let mut after = turned(simd, rotation, velocity, h);
    if block.uneven != 0 {
        let uneven = is_uneven(simd, block);
        let (turned, spin) = split(simd, block, h);
        velocity = choose(uneven, spin, velocity);
        after.is_far = (uneven & turned.is_far) | (!uneven & after.is_far);
        let (a, b) = (turned.rotation, after.rotation);
        after.rotation = Q4 { v: choose(uneven, a.v, b.v), w: uneven.select(a.w, b.w) };
    }
    let mut far = after.is_far.to_bitmask();
    let before = if far == 0 { None } else { Some(*block) };
    velocity.store(&mut block.spin);
    store_rotation(after.rotation, block);
    if let Some(before) = before {
        while far != 0 {
            let lane = far.trailing_zeros() as usize;
            far &= far - 1;
            let mut spin = before.spin(lane);
            motion::advance(scheme, &mut spin, false, h);
            block.set_turn(lane, &spin);
        }
    }
}

#[inline(always)]
fn turn_one(block: &mut MoverBlock, lane: usize, scheme: RotationScheme, h: f32) {
    let mut spin = block.spin(lane);
    motion::advance(scheme, &mut spin, false, h);
    block.set_turn(lane, &spin);
}

/// Writes eight rotations.
#[inline(always)]
pub fn store_rotation<S: Simd>(rotation: Q4<S>, block: &mut MoverBlock) {
    store(rotation.v.x, &mut block.rotation[0]);
    store(rotation.v.y, &mut block.rotation[1]);
    store(rotation.v.z, &mut block.rotation[2]);
    store(rotation.w, &mut block.rotation[3]);
}
