//! What a thread does to the joints that it has in its hands: the passes of a substep.

use crate::constraint::part::limit_motor::middle;
use crate::math::Quat;
use crate::solver::wide::batch::Source;
use crate::solver::wide::domain::{Domain, Part};
use crate::solver::wide::joint_block::{
    self as kernel, Aim, CONE, DAMPING, FRICTION, JointBlock, JointPass, TWIST, TurnLanes,
};
use crate::solver::wide::joints::{BallParts, Impulse, JointPlace, JointWork, Joints, Mark};
use crate::solver::wide::lanes::{LANES, Lane, Record, set, splat, store};
use crate::solver::wide::moving;
use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch};
use std::ops::Range;

/// Joints of some domains, or of the seam, with what bodies have for them.
pub(super) struct JointPart<'a> {
    /// Of each body of the batch.
    marks: &'a [Mark],
    /// All of the batch.
    places: &'a [JointPlace],
    /// Which of them are at hand.
    names: &'a [u32],
    first_block: usize,
    blocks: &'a mut [JointBlock],
    turns: Turns<'a>,
    poses: &'a mut [Record],
    spins: &'a mut [Record],
    pushes: &'a mut [Record],
}

/// What some blocks ask of rotations.
struct Turns<'a> {
    /// Number of the first in the batch.
    first: u32,
    lanes: &'a mut [TurnLanes],
}

impl Turns<'_> {
    /// Those of a block, if there are any.
    #[inline(always)]
    fn of(&self, block: &JointBlock) -> Option<&TurnLanes> {
        self.lanes.get(block.turns.wrapping_sub(self.first) as usize)
    }

    #[inline(always)]
    fn of_mut(&mut self, block: &JointBlock) -> Option<&mut TurnLanes> {
        self.lanes.get_mut(block.turns.wrapping_sub(self.first) as usize)
    }
}

/// Cuts a list that may be empty.
pub(super) fn split<T>(list: &mut [T], at: usize) -> (&mut [T], &mut [T]) {
    list.split_at_mut(at.min(list.len()))
}

fn part_of<T>(list: &mut [T], range: Range<usize>) -> &mut [T] {
    if list.is_empty() { list } else { &mut list[range] }
}

impl<'a> JointPart<'a> {
    /// What `domains` have of all joints; `records` are those of their bodies.
    pub fn new(joints: &'a mut Joints, domains: &[Domain], records: Range<usize>) -> Self {
        let (first, last) = (&domains[0], &domains[domains.len() - 1]);
        let turns = &mut joints.turns[first.turns.start..last.turns.end];
        Self {
            marks: &joints.marks,
            places: &joints.places,
            names: &joints.names[first.joints.start..last.joints.end],
            first_block: first.joint_blocks.start,
            blocks: &mut joints.blocks[first.joint_blocks.start..last.joint_blocks.end],
            turns: Turns { first: first.turns.start as u32, lanes: turns },
            poses: part_of(&mut joints.poses, records.clone()),
            spins: part_of(&mut joints.spins, records.clone()),
            pushes: part_of(&mut joints.pushes, records),
        }
    }

    /// Those of the domains up to `next`, and the rest.
    pub fn cut(self, first: &Domain, next: &Domain) -> (Self, Self) {
        let record = next.records.start - first.records.start;
        let (names, other_names) = self.names.split_at(next.joints.start - first.joints.start);
        let block = next.joint_blocks.start - first.joint_blocks.start;
        let (blocks, other_blocks) = self.blocks.split_at_mut(block);
        let (turns, other_turns) = self.turns.lanes.split_at_mut(next.turns.start - first.turns.start);
        let (poses, other_poses) = split(self.poses, record);
        let (spins, other_spins) = split(self.spins, record);
        let (pushes, other_pushes) = split(self.pushes, record);
        let other = Self {
            marks: self.marks,
            places: self.places,
            names: other_names,
            first_block: next.joint_blocks.start,
            blocks: other_blocks,
            turns: Turns { first: next.turns.start as u32, lanes: other_turns },
            poses: other_poses,
            spins: other_spins,
            pushes: other_pushes,
        };
        let part = Self {
            marks: self.marks,
            places: self.places,
            names,
            first_block: self.first_block,
            blocks,
            turns: Turns { first: self.turns.first, lanes: turns },
            poses,
            spins,
            pushes,
        };
        (part, other)
    }

    /// Whether a body of the batch has any.
    pub fn has(&self, body: u32) -> bool {
        self.marks.get(body as usize).is_some_and(|mark| mark.is_joined())
    }
}

/// What came into the lanes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Filled {
    /// Rows of the reference that it would be.
    pub rows: u32,
    pub work: JointWork,
}

impl Part<'_> {
    /// Lanes of the joints, for substeps of `h` seconds.
    pub fn fill_joints(&mut self, source: &Source<'_>, h: f32) -> Filled {
        let mut filled = Filled::default();
        for &name in self.joints.names {
            self.fill_joint(self.joints.places[name as usize], source, h, &mut filled);
        }
        let JointPart { places, names, first_block, blocks, turns, .. } = &self.joints;
        for place in names.iter().map(|&name| &places[name as usize]) {
            let block = &blocks[place.block as usize - first_block];
            filled.work.add(block, turns.of(block), place.lane as usize);
        }
        filled
    }

    /// The same for lanes that are filled: impulses of the step before, times `warm_scale`.
    pub fn renew_joints(&mut self, warm_scale: f32) {
        for block in &mut *self.joints.blocks {
            block.renew(warm_scale);
        }
    }

    fn fill_joint(&mut self, place: JointPlace, source: &Source<'_>, h: f32, filled: &mut Filled) {
        let bodies = place.bodies.map(|body| self.local(body));
        let (lane, joint) = (place.lane as usize, source.joints.at(place.joint));
        filled.rows += joint.lambdas.len() as u32;
        let block = &mut self.joints.blocks[place.block as usize - self.joints.first_block];
        let resolved = &joint.resolved;
        for (side, anchor) in [resolved.anchor_a, resolved.anchor_b].into_iter().enumerate() {
            let (mover, at) = (&self.movers[bodies[side] as usize / LANES], bodies[side] as usize % LANES);
            block.bodies[side][lane] = bodies[side];
            block.poses[side][lane] = place.poses[side];
            set(&mut block.anchors[side], lane, anchor);
            block.inverse_mass[side][lane] = mover.inverse_mass[at];
            block.root_inertia[side][lane] = mover.inverse_root[0][at];
            block.is_round &= mover.uneven >> at & 1 == 0;
        }
        let ball = BallParts::at(&place, joint);
        let mut turns = self.joints.turns.of_mut(block);
        if let Some(turns) = turns.as_deref_mut() {
            fill_turns(turns, lane, &ball, [resolved.frame_a, resolved.frame_b], h);
        }
        let mut stored = joint.lambdas.iter();
        Impulse::each(&ball, |impulse| {
            let lambda = source.warm_scale * stored.next().copied().unwrap_or(0.0);
            impulse.set(block, turns.as_deref_mut(), lane, lambda);
        });
    }

    /// Poses of the bodies.
    pub fn follow(&mut self, level: Level) {
        let (movers, poses) = (&*self.movers, &mut *self.joints.poses);
        dispatch!(level, simd => moving::pose_all(simd, movers, poses));
    }

    /// How they turn. What recovery by poses pushes begins with nothing.
    pub fn swing(&mut self, level: Level) {
        self.joints.pushes.fill(Record::default());
        let (movers, spins) = (&*self.movers, &mut *self.joints.spins);
        dispatch!(level, simd => moving::swing_all(simd, movers, spins));
    }

    /// Rows for the poses as they are, and what the way along arcs will add to gaps in `h` seconds; with `recovery`
    /// velocities toward what joints ask for (`joint_recovery.rs`), while the rows are near.
    pub fn turn_joints(&mut self, level: Level, poses: &[Record], h: f32, recovery: Option<&JointPass>) {
        let (blocks, turns) = (&mut *self.joints.blocks, &mut self.joints.turns);
        let aim = Aim { poses, roots: &*self.roots, spins: &*self.joints.spins, h };
        let visits =
            JointVisits { aim: Some(&aim), pass: recovery, reversed: false, add_up: false, points_alone: false };
        visit_all(level, blocks, turns, self.joints.pushes, visits);
    }

    /// u' += J'ᵀλ.
    pub fn warm_start_joints(&mut self, level: Level) {
        let (blocks, turns, velocities) = (&*self.joints.blocks, &self.joints.turns, &mut *self.velocities);
        dispatch!(level, simd => warm_start_all(simd, blocks, turns, velocities));
    }

    /// A visit to each joint; with `add_up` λ is what the substep leaves.
    pub fn sweep_joints(&mut self, level: Level, pass: &JointPass, reversed: bool, add_up: bool) {
        let (blocks, turns) = (&mut *self.joints.blocks, &mut self.joints.turns);
        let visits = JointVisits { aim: None, pass: Some(pass), reversed, add_up, points_alone: false };
        visit_all(level, blocks, turns, self.velocities, visits);
    }

    /// A visit to the point of each joint.
    pub fn sweep_points(&mut self, level: Level, pass: &JointPass, reversed: bool) {
        let (blocks, turns) = (&mut *self.joints.blocks, &mut self.joints.turns);
        let visits = JointVisits { aim: None, pass: Some(pass), reversed, add_up: false, points_alone: true };
        visit_all(level, blocks, turns, self.velocities, visits);
    }

    /// Moves bodies along these velocities, which are forgotten.
    pub fn shift(&mut self, level: Level, h: f32) {
        let (movers, pushes) = (&mut *self.movers, &*self.joints.pushes);
        let (ways, velocities) = (&mut *self.displacements, &mut *self.velocities);
        dispatch!(level, simd => moving::shift_all(simd, movers, pushes, ways, velocities, h));
    }

    /// Adds λ to the sums over the substeps.
    pub fn add_up_joints(&mut self, level: Level) {
        let (blocks, turns) = (&mut *self.joints.blocks, &mut self.joints.turns);
        dispatch!(level, simd => add_up_all(simd, blocks, turns));
    }

    /// Errors at the poses as they are.
    pub fn see_joints(&mut self, level: Level, poses: &[Record]) {
        let (blocks, turns) = (&mut *self.joints.blocks, &mut self.joints.turns);
        dispatch!(level, simd => see_all(simd, blocks, turns, poses));
    }

    /// Greatest change of an impulse that a visit would make.
    pub fn joint_residual(&mut self, level: Level, pass: &JointPass) -> f32 {
        let (velocities, mut greatest) = (&*self.velocities, [0.0; LANES]);
        let blocks = &*self.joints.blocks;
        dispatch!(level, simd => see_changes(simd, blocks, velocities, pass, &mut greatest));
        let mut greatest = greatest.into_iter().fold(0.0, f32::max);
        if self.joints.turns.lanes.is_empty() {
            return greatest;
        }
        let seen = &mut *self.joints.pushes;
        seen.copy_from_slice(velocities);
        for block in blocks {
            let Some(turns) = self.joints.turns.of(block) else { continue };
            let (mut visited, mut turned) = ([*block], [*turns]);
            let mut of_visited = Turns { first: block.turns, lanes: &mut turned };
            let visits =
                JointVisits { aim: None, pass: Some(pass), reversed: false, add_up: false, points_alone: false };
            visit_all(level, &mut visited, &mut of_visited, seen, visits);
            for &body in block.bodies.as_flattened() {
                seen[body as usize] = velocities[body as usize];
            }
            greatest = kernel::greatest_change(greatest, &visited[0], block);
            greatest = kernel::greatest_turn(greatest, &turned[0], turns);
        }
        greatest
    }
}

fn fill_turns(turns: &mut TurnLanes, lane: usize, ball: &BallParts, frames: [Quat; 2], h: f32) {
    for (lanes, frame) in turns.frames.iter_mut().zip(frames) {
        for (lanes, value) in lanes.iter_mut().zip(frame.to_array()) {
            lanes[lane] = value;
        }
    }
    if let Some(cone) = ball.cone {
        turns.ranges[CONE].limits[1][lane] = cone;
    }
    if let Some(twist) = &ball.twist {
        let range = &mut turns.ranges[TWIST];
        (range.limits[0][lane], range.limits[1][lane]) = (twist.lower, twist.upper);
        range.middle[lane] = middle(Some(twist));
    }
    turns.drags[FRICTION].reach[lane] = h * ball.friction;
    let softness = 1.0 / (h * ball.damping);
    if softness.is_finite() {
        (turns.drags[DAMPING].softness[lane], turns.drags[DAMPING].reach[lane]) = (softness, f32::INFINITY);
    }
}

#[inline(always)]
fn warm_start_all<S: Simd>(simd: S, blocks: &[JointBlock], turns: &Turns<'_>, velocities: &mut [Record]) {
    for block in blocks {
        kernel::warm_start(simd, block, turns.of(block), velocities);
    }
}

/// What is done to each block while it is near.
#[derive(Clone, Copy)]
struct JointVisits<'a> {
    /// Rows are made anew, in a forward order.
    aim: Option<&'a Aim<'a>>,
    pass: Option<&'a JointPass>,
    reversed: bool,
    /// λ is what the substep leaves.
    add_up: bool,
    /// Nothing of what is asked of rotations.
    points_alone: bool,
}

/// A visit to each.
#[inline(never)]
fn visit_all(
    level: Level,
    blocks: &mut [JointBlock],
    turns: &mut Turns<'_>,
    records: &mut [Record],
    visits: JointVisits<'_>,
) {
    if visits.reversed {
        dispatch!(level, simd => sweep::<_, true>(simd, blocks, turns, records, visits));
    } else {
        dispatch!(level, simd => sweep::<_, false>(simd, blocks, turns, records, visits));
    }
}

#[inline(always)]
fn sweep<S: Simd, const REVERSED: bool>(
    simd: S,
    blocks: &mut [JointBlock],
    turns: &mut Turns<'_>,
    records: &mut [Record],
    visits: JointVisits<'_>,
) {
    let n = blocks.len();
    for i in 0..n {
        let block = &mut blocks[if REVERSED { n - 1 - i } else { i }];
        let mut turns = turns.of_mut(block);
        if let (Some(aim), false) = (visits.aim, REVERSED) {
            kernel::turn(simd, block, turns.as_deref_mut(), aim);
        }
        if let Some(pass) = visits.pass {
            let turns = turns.as_deref_mut().filter(|_| !visits.points_alone);
            kernel::visit::<S, REVERSED>(simd, block, turns, records, pass);
        }
        if visits.add_up {
            kernel::add_up(simd, block, turns);
        }
    }
}

/// The greatest change of an impulse, lane by lane, by visits to what asks nothing of rotations.
#[inline(always)]
fn see_changes<S: Simd>(simd: S, blocks: &[JointBlock], velocities: &[Record], pass: &JointPass, greatest: &mut Lane) {
    let mut most = splat(simd, 0.0);
    for block in blocks {
        if block.turns == JointBlock::NO_TURNS {
            most = kernel::change_of_point(simd, block, velocities, pass, most);
        }
    }
    store(most, greatest);
}

#[inline(always)]
fn add_up_all<S: Simd>(simd: S, blocks: &mut [JointBlock], turns: &mut Turns<'_>) {
    for block in blocks {
        let turns = turns.of_mut(block);
        kernel::add_up(simd, block, turns);
    }
}

#[inline(always)]
fn see_all<S: Simd>(simd: S, blocks: &mut [JointBlock], turns: &mut Turns<'_>, poses: &[Record]) {
    for block in blocks {
        let turns = turns.of_mut(block);
        kernel::see(simd, block, turns, poses);
    }
}
