//! What eight bodies do in a substep: forces, impulses of sweeps taken over, the way and the turn, the shift that joints ask
//! for. TALK A1–A7; `substeps.rs` and `motion/mod.rs` have it for one body.
//!
//! Each body's records come into lanes and go back: they lie one after the other.

use crate::math::Vec3;
use crate::motion::{self, forces};
use crate::options::RotationScheme;
use crate::solver::table::FAR_TURN;
use crate::solver::wide::lanes::{LANES, Q4, Record, Symmetric, V3, load, read, splat, store, write, write_poses};
use crate::solver::wide::lanes::{get, set};
use crate::solver::wide::mover::{Lane6, MoverBlock};
use crate::solver::wide::turning::{
    choose, gyration, inverse_inertia_times, roots, store_rotation, symmetric, turn, turned,
};
use fearless_simd::mask32x8;
use fearless_simd::prelude::*;

/// Records of eight bodies.
pub type Eight = [Record; LANES];

/// What moves all bodies alike in a substep.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    /// How bodies turn.
    pub scheme: RotationScheme,
    /// Greatest speed, m/s.
    pub max_speed: f32,
    /// rad/s.
    pub max_angular_speed: f32,
    /// Substep, s.
    pub h: f32,
}

/// A velocity, a way or an impulse of eight bodies.
#[derive(Clone, Copy)]
struct Twist<S: Simd> {
    linear: V3<S>,
    angular: V3<S>,
}

impl<S: Simd> Twist<S> {
    #[inline(always)]
    fn read(simd: S, records: &Eight) -> Self {
        let (linear, angular) = read(simd, records);
        Self { linear, angular }
    }

    #[inline(always)]
    fn write(self, simd: S, records: &mut Eight) {
        write(simd, records, self.linear, self.angular);
    }

    #[inline(always)]
    fn plus(self, o: Self) -> Self {
        Self { linear: self.linear.plus(o.linear), angular: self.angular.plus(o.angular) }
    }

    #[inline(always)]
    fn minus(self, o: Self) -> Self {
        Self { linear: self.linear.minus(o.linear), angular: self.angular.minus(o.angular) }
    }

    #[inline(always)]
    fn times(self, simd: S, s: f32) -> Self {
        let s = splat(simd, s);
        Self { linear: self.linear.times(s), angular: self.angular.times(s) }
    }

    /// With I^½ of its rotation, as rows see it.
    #[inline(always)]
    fn weighted(self, simd: S, block: &MoverBlock) -> Self {
        Self { linear: self.linear, angular: root_times(simd, block, &block.root, self.angular) }
    }

    /// Back from there.
    #[inline(always)]
    fn unweighted(self, simd: S, block: &MoverBlock) -> Self {
        Self { linear: self.linear, angular: root_times(simd, block, &block.inverse_root, self.angular) }
    }

    /// v and ω as they are.
    #[inline(always)]
    fn of(simd: S, block: &MoverBlock) -> Self {
        Self { linear: V3::load(simd, &block.velocity), angular: V3::load(simd, &block.spin) }
    }
}

/// I^½ or I^−½ times a vector: a number, where bodies are round.
#[inline(always)]
fn root_times<S: Simd>(simd: S, block: &MoverBlock, root: &Lane6, v: V3<S>) -> V3<S> {
    if block.uneven != 0 { symmetric(simd, root).times(v) } else { v.times(load(simd, &root[0])) }
}

/// v += h(F/m + g), L += hτ, damping; then u', with what the last substep carried over added to it.
#[inline(always)]
fn begin<S: Simd>(simd: S, block: &mut MoverBlock, carried: Option<&Eight>, velocities: &mut Eight, h: f32) {
    let step = splat(simd, h);
    let pushed = V3::load(simd, &block.velocity).plus(V3::load(simd, &block.acceleration).times(step));
    pushed.times(load(simd, &block.kept[0])).store(&mut block.velocity);
    if block.is_turned {
        let impulse = V3::load(simd, &block.torque).times(step);
        let kept = load(simd, &block.kept[1]);
        let rotation = Q4::load(simd, &block.rotation);
        let spin = V3::load(simd, &block.spin).plus(inverse_inertia_times(simd, block, rotation, impulse));
        spin.times(kept).store(&mut block.spin);
        V3::load(simd, &block.momentum).plus(impulse).times(kept).store(&mut block.momentum);
    }
    let free = Twist::of(simd, block).weighted(simd, block);
    match carried {
        Some(carried) => free.plus(Twist::read(simd, carried)).write(simd, velocities),
        None => free.write(simd, velocities),
    }
}

/// Takes over what sweeps made of u'; gives the change. Before them it was that of v and ω as they are.
#[inline(always)]
fn take<S: Simd>(simd: S, block: &mut MoverBlock, after: &Eight) -> Twist<S> {
    let change = Twist::read(simd, after).minus(Twist::of(simd, block).weighted(simd, block));
    V3::load(simd, &block.velocity).plus(change.linear).store(&mut block.velocity);
    let turn = root_times(simd, block, &block.root, change.angular);
    let momentum = V3::load(simd, &block.momentum).plus(turn);
    momentum.store(&mut block.momentum);
    let zero = splat(simd, 0.0);
    // What nothing turned is not rounded.
    let still = turn.x.simd_eq(zero) & turn.y.simd_eq(zero) & turn.z.simd_eq(zero);
    let spin = inverse_inertia_times(simd, block, Q4::load(simd, &block.rotation), momentum);
    choose(still, V3::load(simd, &block.spin), spin).store(&mut block.spin);
    change
}

/// v and ω no faster than allowed: `motion/forces.rs`, body by body, since it is rare.
#[inline(always)]
fn limit<S: Simd>(simd: S, block: &mut MoverBlock, motion: &Motion) {
    let (v, w) = (V3::load(simd, &block.velocity), V3::load(simd, &block.spin));
    let fast = v.dot(v).simd_ge(splat(simd, motion.max_speed * motion.max_speed));
    let whirls = w.dot(w).simd_gt(splat(simd, motion.max_angular_speed * motion.max_angular_speed));
    if (fast | whirls).any_true() {
        limit_each(block, motion);
    }
}

#[cold]
fn limit_each(block: &mut MoverBlock, motion: &Motion) {
    for lane in 0..LANES {
        let velocity: Vec3 = get(&block.velocity, lane);
        set(&mut block.velocity, lane, forces::limited(velocity, motion.max_speed));
        let mut spin = block.spin(lane);
        forces::limit_spin(&mut spin, motion.max_angular_speed);
        set(&mut block.spin, lane, spin.angular_velocity);
        set(&mut block.momentum, lane, spin.angular_momentum);
    }
}

/// Takes sweeps over, then x += h v and the turn; the way adds to the displacement. `carried` gets what sweeps changed,
/// `velocities` u' after the motion.
#[inline(always)]
fn advance<S: Simd>(
    simd: S,
    block: &mut MoverBlock,
    carried: &mut Eight,
    velocities: &mut Eight,
    displacements: &mut Eight,
    motion: &Motion,
) {
    take(simd, block, velocities).write(simd, carried);
    limit(simd, block, motion);
    let way = Twist::of(simd, block).times(simd, motion.h);
    note_turn(simd, block, way.angular);
    V3::load(simd, &block.center).plus(way.linear).store(&mut block.center);
    Twist::read(simd, displacements).plus(way.weighted(simd, block)).write(simd, displacements);
    turn(simd, block, motion.scheme, motion.h);
    record(simd, block, velocities);
}

/// Adds to how far bodies turned since they were weighed.
#[inline(always)]
fn note_turn<S: Simd>(simd: S, block: &mut MoverBlock, turn: V3<S>) {
    if block.weighed != 0 {
        V3::load(simd, &block.turn).plus(turn).store(&mut block.turn);
    }
}

#[inline(always)]
fn record<S: Simd>(simd: S, block: &MoverBlock, velocities: &mut Eight) {
    Twist::of(simd, block).weighted(simd, block).write(simd, velocities);
}

/// Takes the sweeps after the motion over; what they changed is carried to the next substep, unless that pushes its
/// impulses anew.
#[inline(always)]
fn end<S: Simd>(simd: S, block: &mut MoverBlock, carried: Option<&mut Eight>, velocities: &Eight) {
    let change = take(simd, block, velocities);
    if let Some(carried) = carried {
        Twist::read(simd, carried).plus(change).write(simd, carried);
    }
}

#[inline(always)]
fn store_symmetric<S: Simd>(matrix: &Symmetric<S>, lanes: &mut [[f32; LANES]; 6]) {
    let (u, l) = (matrix.upper, matrix.lower);
    store(u.x, &mut lanes[0]);
    store(u.y, &mut lanes[1]);
    store(u.z, &mut lanes[2]);
    store(l.x, &mut lanes[3]);
    store(l.y, &mut lanes[4]);
    store(l.z, &mut lanes[5]);
}

/// I^½ and I^−½ for the rotations as they are; the latter into records xx, xy, xz, 0, yy, yz, zz, 0.
#[inline(always)]
fn weigh<S: Simd>(simd: S, block: &mut MoverBlock, inverse_roots: &mut Eight) {
    let [root, inverse] = roots(simd, block);
    store_symmetric(&root, &mut block.root);
    store_symmetric(&inverse, &mut block.inverse_root);
    write(simd, inverse_roots, inverse.upper, inverse.lower);
}

/// The same for bodies whose joints turn with them, where they turned far; their ways so far and their u' are weighted anew.
/// `old_roots` gets I^½ as it was, with marks where it is another one now.
#[inline(always)]
fn reweigh<S: Simd>(
    simd: S,
    block: &mut MoverBlock,
    old_roots: &mut Eight,
    inverse_roots: &mut Eight,
    displacements: &mut Eight,
    velocities: &mut Eight,
) {
    let turned = V3::load(simd, &block.turn);
    let is_far = turned.dot(turned).simd_gt(splat(simd, FAR_TURN * FAR_TURN));
    let chosen = mask32x8::from_bitmask(simd, block.weighed.into()) & is_far;
    if !chosen.any_true() {
        return old_roots.iter_mut().for_each(|root| root.set_marked(false));
    }
    write_roots(simd, block, old_roots);
    for (lane, root) in old_roots.iter_mut().enumerate() {
        root.set_marked(chosen.to_bitmask() >> lane & 1 != 0);
    }
    let zero = splat(simd, 0.0);
    choose(chosen, V3 { x: zero, y: zero, z: zero }, turned).store(&mut block.turn);
    let way = Twist::read(simd, displacements);
    let moved = way.unweighted(simd, block);
    let [root, inverse] = roots(simd, block);
    let (old, old_inverse) = (symmetric(simd, &block.root), symmetric(simd, &block.inverse_root));
    let root = Symmetric { upper: choose(chosen, root.upper, old.upper), lower: choose(chosen, root.lower, old.lower) };
    let inverse = Symmetric {
        upper: choose(chosen, inverse.upper, old_inverse.upper),
        lower: choose(chosen, inverse.lower, old_inverse.lower),
    };
    store_symmetric(&root, &mut block.root);
    store_symmetric(&inverse, &mut block.inverse_root);
    write(simd, inverse_roots, inverse.upper, inverse.lower);
    let weighted = moved.weighted(simd, block);
    write(
        simd,
        displacements,
        choose(chosen, weighted.linear, way.linear),
        choose(chosen, weighted.angular, way.angular),
    );
    record(simd, block, velocities);
}

/// I^½ as records.
#[inline(always)]
fn write_roots<S: Simd>(simd: S, block: &MoverBlock, roots: &mut Eight) {
    let root = symmetric(simd, &block.root);
    write(simd, roots, root.upper, root.lower);
}

/// Moves by `h` seconds of velocities, weighted as u', that are forgotten; L stays, ω follows.
#[inline(always)]
fn shift<S: Simd>(
    simd: S,
    block: &mut MoverBlock,
    pushes: &Eight,
    displacements: &mut Eight,
    velocities: &mut Eight,
    h: f32,
) {
    let push = Twist::read(simd, pushes);
    let zero = splat(simd, 0.0);
    let (l, a) = (push.linear, push.angular);
    let still = l.x.simd_eq(zero) & l.y.simd_eq(zero) & l.z.simd_eq(zero);
    let still = still & a.x.simd_eq(zero) & a.y.simd_eq(zero) & a.z.simd_eq(zero);
    let way = push.unweighted(simd, block);
    note_turn(simd, block, way.angular.times(splat(simd, h)));
    let old = Q4::load(simd, &block.rotation);
    let after = turned(simd, old, way.angular, h);
    let mut far = (after.is_far & !still).to_bitmask();
    let new = Q4 { v: choose(still, old.v, after.rotation.v), w: still.select(old.w, after.rotation.w) };
    let one_by_one = if far == 0 { None } else { Some((*block, way.angular)) };
    store_rotation(new, block);
    if let Some((before, angular)) = one_by_one {
        let mut velocities = [[0.0; LANES]; 3];
        angular.store(&mut velocities);
        while far != 0 {
            let lane = far.trailing_zeros() as usize;
            far &= far - 1;
            let mut spin = before.spin(lane);
            spin.rotation = motion::turned(spin.rotation, get(&velocities, lane), h);
            block.set_turn(lane, &spin);
        }
    }
    V3::load(simd, &block.center).plus(way.linear.times(splat(simd, h))).store(&mut block.center);
    let momentum = V3::load(simd, &block.momentum);
    let spin = inverse_inertia_times(simd, block, Q4::load(simd, &block.rotation), momentum);
    choose(still, V3::load(simd, &block.spin), spin).store(&mut block.spin);
    Twist::read(simd, displacements).plus(push.times(simd, h)).write(simd, displacements);
    record(simd, block, velocities);
}

/// Poses as records: centers, and rotations.
#[inline(always)]
fn pose<S: Simd>(simd: S, block: &MoverBlock, poses: &mut Eight) {
    write_poses(simd, poses, V3::load(simd, &block.center), Q4::load(simd, &block.rotation));
}

/// ω and ω̇ of free turning as records.
#[inline(always)]
fn swing<S: Simd>(simd: S, block: &MoverBlock, spins: &mut Eight) {
    write(simd, spins, V3::load(simd, &block.spin), gyration(simd, block));
}

/// `pose` for all.
#[inline(always)]
pub fn pose_all<S: Simd>(simd: S, blocks: &[MoverBlock], poses: &mut [Record]) {
    for (block, poses) in blocks.iter().zip(poses.as_chunks_mut().0) {
        pose(simd, block, poses);
    }
}

/// `swing` for all.
#[inline(always)]
pub fn swing_all<S: Simd>(simd: S, blocks: &[MoverBlock], spins: &mut [Record]) {
    for (block, spins) in blocks.iter().zip(spins.as_chunks_mut().0) {
        swing(simd, block, spins);
    }
}

/// `begin` for all; without `carried` each substep pushes its impulses anew.
#[inline(always)]
pub fn begin_all<S: Simd>(
    simd: S,
    blocks: &mut [MoverBlock],
    carried: Option<&[Record]>,
    velocities: &mut [Record],
    h: f32,
) {
    let carried = match carried {
        Some(records) => records.as_chunks().0,
        None => &[],
    };
    for (k, (block, velocities)) in blocks.iter_mut().zip(velocities.as_chunks_mut().0).enumerate() {
        begin(simd, block, carried.get(k), velocities, h);
    }
}

/// `advance` for all.
#[inline(always)]
pub fn advance_all<S: Simd>(
    simd: S,
    blocks: &mut [MoverBlock],
    carried: &mut [Record],
    velocities: &mut [Record],
    ways: &mut [Record],
    motion: &Motion,
) {
    let records = carried.as_chunks_mut().0.iter_mut().zip(velocities.as_chunks_mut().0);
    for (block, ((carried, velocities), ways)) in blocks.iter_mut().zip(records.zip(ways.as_chunks_mut().0)) {
        advance(simd, block, carried, velocities, ways, motion);
    }
}

/// `end` for all.
#[inline(always)]
pub fn end_all<S: Simd>(simd: S, blocks: &mut [MoverBlock], carried: Option<&mut [Record]>, velocities: &[Record]) {
    let mut carried = carried.unwrap_or_default().as_chunks_mut().0.iter_mut();
    for (block, velocities) in blocks.iter_mut().zip(velocities.as_chunks().0) {
        end(simd, block, carried.next(), velocities);
    }
}

/// `reweigh` for all.
#[inline(always)]
pub fn reweigh_all<S: Simd>(
    simd: S,
    blocks: &mut [MoverBlock],
    roots: &mut [Record],
    old_roots: &mut [Record],
    ways: &mut [Record],
    velocities: &mut [Record],
) {
    let records = roots.as_chunks_mut().0.iter_mut().zip(old_roots.as_chunks_mut().0);
    let records = records.zip(ways.as_chunks_mut().0).zip(velocities.as_chunks_mut().0);
    for (block, (((roots, old_roots), ways), velocities)) in blocks.iter_mut().zip(records) {
        reweigh(simd, block, old_roots, roots, ways, velocities);
    }
}

/// `shift` for all.
#[inline(always)]
pub fn shift_all<S: Simd>(
    simd: S,
    blocks: &mut [MoverBlock],
    pushes: &[Record],
    ways: &mut [Record],
    velocities: &mut [Record],
    h: f32,
) {
    let records = pushes.as_chunks().0.iter().zip(ways.as_chunks_mut().0);
    let records = records.zip(velocities.as_chunks_mut().0);
    for (block, ((pushes, ways), velocities)) in blocks.iter_mut().zip(records) {
        shift(simd, block, pushes, ways, velocities, h);
    }
}

/// `weigh` for all.
#[inline(always)]
pub fn weigh_all<S: Simd>(simd: S, blocks: &mut [MoverBlock], roots: &mut [Record]) {
    for (block, roots) in blocks.iter_mut().zip(roots.as_chunks_mut().0) {
        weigh(simd, block, roots);
    }
}
