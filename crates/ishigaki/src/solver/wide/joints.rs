//! Joints of a batch: from the world into blocks, over the substeps, and back.
//!
//! A joint is in the wave after the last one that shares a moving body with it, in the order of joints: all of a wave are
//! independent, and waves one after the other are the visits of the reference, to the bit of what rounding leaves.
//! Colors would fill lanes as well, but carry a load over a few joints in a sweep; along the order of joints it passes
//! through a whole chain.

use crate::body::BodyState;
use crate::constraint::joint::{Joint, JointKind, Range};
use crate::constraint::part::limit_motor::middle;
use crate::handle::Arena;
use crate::math::{Quat, Vec3};
use crate::solver::joint_link::JointLink;
use crate::solver::wide::joint_block::{
    self as kernel, Aim, CONE, DAMPING, FRICTION, JointBlock, JointPass, Parts, TWIST, TurnLanes,
};
use crate::solver::wide::lanes::{LANES, Lane, Record, get, set, splat, store};
use crate::solver::wide::mover::{MoverBlock, Movers};
use crate::solver::wide::moving;
use crate::solver::work;
use crate::step::JointErrors;
use crate::world::JointState;
use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch};

/// Where a joint is.
#[derive(Clone, Copy, Debug)]
pub struct JointPlace {
    /// Its slot.
    pub joint: u32,
    /// Its bodies in the batch; 0 for what does not move.
    pub bodies: [u32; 2],
    poses: [u32; 2],
    wave: u32,
    kind: u8,
    block: u32,
    lane: u32,
}

/// Multiply-adds of joints, counted once a step.
#[derive(Clone, Copy, Debug, Default)]
pub struct JointWork {
    /// Of a sweep.
    pub sweep: u64,
    /// Of a sweep of the recovery by poses.
    pub recovery: u64,
    /// Of rows at a pose.
    pub rows: u64,
}

/// All joints of a batch.
#[derive(Clone, Debug, Default)]
pub struct Joints {
    /// In the order of the world.
    pub places: Vec<JointPlace>,
    /// Wave by wave.
    pub blocks: Vec<JointBlock>,
    /// What some of them ask of rotations.
    turns: Vec<TurnLanes>,
    /// Rows of the reference that they would be.
    pub rows: u32,
    /// Centers and rotations: the movers, then what does not move.
    poses: Vec<Record>,
    still: Vec<Record>,
    /// Angular velocity and free angular acceleration of the movers.
    spins: Vec<Record>,
    /// Velocities of the recovery by poses.
    pushes: Vec<Record>,
    waves: Vec<u32>,
    counts: Vec<[u32; Parts::KINDS]>,
    /// Multiply-adds of a sweep, of one of the recovery by poses, and of rows at a pose.
    pub work: JointWork,
}

/// Whether the lanes have rows for it.
pub fn fits(joint: &Joint) -> bool {
    match &joint.kind {
        JointKind::Ball { cone, twist, .. } => {
            cone.is_none_or(|cone| cone > 0.0) && twist.as_ref().is_none_or(|t| t.lower != t.upper)
        }
        _ => false,
    }
}

/// Number of the kind of block for it.
pub fn kind(joint: &Joint) -> u8 {
    BallParts::of(joint).parts().kind() as u8
}

/// What a ball joint has beside the point.
#[derive(Clone, Copy)]
struct BallParts {
    cone: Option<f32>,
    twist: Option<Range>,
    friction: f32,
    damping: f32,
}

impl BallParts {
    /// Nothing.
    const NONE: Self = Self { cone: None, twist: None, friction: 0.0, damping: 0.0 };

    fn of(joint: &Joint) -> Self {
        match &joint.kind {
            JointKind::Ball { cone, twist, friction, damping } => {
                Self { cone: *cone, twist: *twist, friction: *friction, damping: *damping }
            }
            _ => Self::NONE,
        }
    }

    /// Of a joint with a place: where the place says that there is nothing, the definition, which lies far from what a
    /// step needs of a joint, is not looked at.
    fn at(place: &JointPlace, joint: &JointState) -> Self {
        if place.kind == 0 { Self::NONE } else { Self::of(&joint.definition) }
    }

    fn parts(&self) -> Parts {
        Parts { ranges: self.cone.is_some() || self.twist.is_some(), drags: self.friction > 0.0 || self.damping > 0.0 }
    }
}

/// A number of a lane, in the order in which a joint keeps its impulses: `constraint/ball.rs`.
fn each_impulse(
    ball: &BallParts,
    block: &mut JointBlock,
    turns: Option<&mut TurnLanes>,
    lane: usize,
    mut visit: impl FnMut(&mut f32),
) {
    if let Some(turns) = turns {
        for (drag, exists) in [(FRICTION, ball.friction > 0.0), (DAMPING, ball.damping > 0.0)] {
            if exists {
                turns.drags[drag].lambda.iter_mut().for_each(|lambda| visit(&mut lambda[lane]));
            }
        }
        let twist = ball.twist.map_or([false; 2], |t| [t.lower.is_finite(), t.upper.is_finite()]);
        for (range, end, exists) in [(TWIST, 0, twist[0]), (TWIST, 1, twist[1]), (CONE, 1, ball.cone.is_some())] {
            if exists {
                visit(&mut turns.ranges[range].lambda[end][lane]);
            }
        }
    }
    block.lambda.iter_mut().for_each(|lambda| visit(&mut lambda[lane]));
}

fn pose_record(center: Vec3, rotation: Quat) -> Record {
    Record([center.x, center.y, center.z, 0.0, rotation.x, rotation.y, rotation.z, rotation.w])
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

impl JointWork {
    /// A joint more, in this lane, with the impulses it had when the step began.
    fn add(&mut self, block: &JointBlock, turns: Option<&TurnLanes>, lane: usize) {
        let (point, rows) = match block.is_round {
            true => (work::ROUND_POINT, work::ROUND_POINT_ROWS),
            false => (work::POINT, work::POINT_ROWS),
        };
        let (mut ends, mut drags, mut ranges) = (0, 0, 0);
        if let Some(turns) = turns {
            let bears = |&(range, end): &(usize, usize)| turns.ranges[range].lambda[end][lane] > 0.0;
            let bearing = kernel::ENDS.iter().filter(|end| bears(end)).count() as u64;
            if turns.parts.ranges {
                (ends, ranges) = (3 * work::TURN_VISIT + bearing * (point + work::FREE_PART), work::RANGE_ROWS);
            }
            if turns.parts.drags {
                drags = 6 * work::TURN_VISIT;
            }
        }
        self.recovery += point + ends;
        self.sweep += point + ends + drags;
        self.rows += rows + ranges;
    }
}

impl Joints {
    /// Forgets all.
    pub fn clear(&mut self) {
        self.places.clear();
        self.still.clear();
        self.waves.clear();
        self.rows = 0;
        self.work = JointWork::default();
    }

    /// There are none.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Whether a body has any, once they are built.
    pub fn has(&self, body: u32) -> bool {
        self.waves.get(body as usize).is_some_and(|&waves| waves > 0)
    }

    /// Adds a joint; `bodies` are their indices in the batch.
    pub(crate) fn add(&mut self, link: &JointLink, bodies: [u32; 2], world: &Arena<BodyState>) {
        // What does not move has its pose after those of the movers, whose number is not known yet.
        let mut poses = bodies;
        for (pose, end) in poses.iter_mut().zip(link.bodies) {
            if *pose == 0 {
                let body = world.at(end);
                self.still.push(pose_record(body.center, body.rotation));
                *pose = u32::MAX - (self.still.len() as u32 - 1);
            }
        }
        let JointLink { joint, kind, .. } = *link;
        self.places.push(JointPlace { joint, bodies, poses, wave: 0, kind, block: 0, lane: 0 });
    }

    /// Waves and blocks, among so many records. A line of its own in profiles.
    #[inline(never)]
    pub(crate) fn arrange(&mut self, records: usize) {
        if self.is_empty() {
            self.blocks.clear();
            self.turns.clear();
            return;
        }
        self.make_waves(records);
        // Whatever is in them is written over before it is read.
        for records_of in [&mut self.poses, &mut self.spins, &mut self.pushes] {
            records_of.resize(records, Record::default());
        }
        self.poses.append(&mut self.still);
        self.work = JointWork::default();
    }

    /// Lanes of all joints, for substeps of `h` seconds; `scale` makes first impulses of stored ones.
    pub(crate) fn fill(&mut self, movers: &Movers, joints: &Arena<JointState>, h: f32, scale: f32) {
        for p in 0..self.places.len() {
            self.fill_joint(p, movers, joints, h, scale);
        }
        for place in &self.places {
            let block = &self.blocks[place.block as usize];
            self.work.add(block, self.turns.get(block.turns as usize), place.lane as usize);
        }
    }

    fn make_waves(&mut self, records: usize) {
        self.waves.clear();
        self.waves.resize(records, 0);
        self.counts.clear();
        let first_still = records as u32;
        for place in &mut self.places {
            for pose in &mut place.poses {
                if *pose >= first_still {
                    *pose = first_still + (u32::MAX - *pose);
                }
            }
            let moving = place.bodies.iter().filter(|&&b| b != 0);
            let wave = moving.clone().map(|&b| self.waves[b as usize]).max().unwrap_or(0);
            moving.for_each(|&b| self.waves[b as usize] = wave + 1);
            place.wave = wave;
            if self.counts.len() <= wave as usize {
                self.counts.resize(wave as usize + 1, [0; Parts::KINDS]);
            }
            let count = &mut self.counts[wave as usize][usize::from(place.kind)];
            place.lane = *count;
            *count += 1;
        }
        self.make_blocks();
        for place in &mut self.places {
            place.block = self.counts[place.wave as usize][usize::from(place.kind)] + place.lane / LANES as u32;
            place.lane %= LANES as u32;
        }
    }

    /// Blocks for what was counted. Full ones are written over; those with lanes that nothing fills are emptied.
    fn make_blocks(&mut self) {
        self.turns.clear();
        let mut first = 0;
        for of_wave in &mut self.counts {
            for (kind, count) in of_wave.iter_mut().enumerate() {
                let parts = Parts::of_kind(kind);
                let end = first + count.div_ceil(LANES as u32) as usize;
                if self.blocks.len() < end {
                    self.blocks.resize(end, JointBlock::EMPTY);
                }
                if !count.is_multiple_of(LANES as u32) {
                    self.blocks[end - 1] = JointBlock::EMPTY;
                }
                for block in &mut self.blocks[first..end] {
                    if parts == Parts::default() {
                        block.begin(JointBlock::NO_TURNS);
                    } else {
                        block.begin(self.turns.len() as u32);
                        self.turns.push(TurnLanes::new(parts));
                    }
                }
                *count = first as u32;
                first = end;
            }
        }
        self.blocks.truncate(first);
    }

    fn fill_joint(&mut self, index: usize, movers: &Movers, joints: &Arena<JointState>, h: f32, scale: f32) {
        let place = self.places[index];
        let (lane, joint) = (place.lane as usize, joints.at(place.joint));
        self.rows += joint.lambdas.len() as u32;
        let block = &mut self.blocks[place.block as usize];
        let mut turns = self.turns.get_mut(block.turns as usize);
        let resolved = &joint.resolved;
        for (side, anchor) in [resolved.anchor_a, resolved.anchor_b].into_iter().enumerate() {
            block.bodies[side][lane] = place.bodies[side];
            block.poses[side][lane] = place.poses[side];
            set(&mut block.anchors[side], lane, anchor);
            block.root[side][lane] = movers.inverse_root_mass(place.bodies[side]);
            block.root_inertia[side][lane] = movers.inverse_root_inertia(place.bodies[side]);
            block.is_round &= movers.is_round(place.bodies[side]);
        }
        let ball = BallParts::at(&place, joint);
        if let Some(turns) = turns.as_deref_mut() {
            fill_turns(turns, lane, &ball, [resolved.frame_a, resolved.frame_b], h);
        }
        let mut stored = joint.lambdas.iter();
        each_impulse(&ball, block, turns, lane, |lambda| {
            *lambda = scale * stored.next().copied().unwrap_or(0.0);
        });
    }

    /// Rows for the poses as they are, and what the way along arcs will add to gaps in `h` seconds. `roots` holds I^−½
    /// of all bodies.
    pub fn aim(&mut self, level: Level, movers: &Movers, roots: &[Record], h: f32) {
        let (blocks, turns, poses, spins) = (&mut self.blocks, &mut self.turns, &mut self.poses, &mut self.spins);
        dispatch!(level, simd => {
            follow(simd, &movers.blocks, poses, Some(spins));
            turn_all(simd, blocks, turns, &Aim { poses, roots, spins, h });
        });
    }

    /// u' += J'ᵀλ.
    pub fn warm_start(&self, level: Level, velocities: &mut [Record]) {
        let (blocks, turns) = (&self.blocks, &self.turns);
        dispatch!(level, simd => warm_start_all(simd, blocks, turns, velocities));
    }

    /// A visit to each joint; with `add_up` λ is what the substep leaves.
    pub fn sweep(&mut self, level: Level, velocities: &mut [Record], pass: &JointPass, reversed: bool, add_up: bool) {
        let order = Visits { reversed, add_up };
        visit_all(level, (&mut self.blocks, &mut self.turns), velocities, pass, order);
    }

    /// Velocities toward what joints ask for: `joint_recovery.rs`. They are moved along and forgotten.
    pub fn recover(&mut self, level: Level, pass: &JointPass, reversed: bool) -> &[Record] {
        let mut pushes = std::mem::take(&mut self.pushes);
        pushes.fill(Record::default());
        self.sweep(level, &mut pushes, pass, reversed, false);
        self.pushes = pushes;
        &self.pushes
    }

    /// Adds λ to the sums over the substeps.
    pub fn add_up(&mut self, level: Level) {
        let (blocks, turns) = (&mut self.blocks, &mut self.turns);
        dispatch!(level, simd => add_up_all(simd, blocks, turns));
    }

    /// Without warm start each substep begins from nothing.
    pub fn forget(&mut self) {
        for block in &mut self.blocks {
            block.lambda = [[0.0; LANES]; 3];
        }
        for turns in &mut self.turns {
            turns.ranges.iter_mut().for_each(|r| r.lambda = [[0.0; LANES]; 2]);
            turns.drags.iter_mut().for_each(|d| d.lambda = [[0.0; LANES]; 3]);
        }
    }

    /// Greatest change of an impulse that a visit would make.
    pub fn residual(&mut self, level: Level, velocities: &[Record], pass: &JointPass) -> f32 {
        let (blocks, mut greatest) = (&self.blocks, [0.0; LANES]);
        dispatch!(level, simd => see_changes(simd, blocks, velocities, pass, &mut greatest));
        let mut greatest = greatest.into_iter().fold(0.0, f32::max);
        if self.turns.is_empty() {
            return greatest;
        }
        let mut seen = std::mem::take(&mut self.pushes);
        seen.copy_from_slice(velocities);
        for block in &self.blocks {
            let Some(turns) = self.turns.get(block.turns as usize) else { continue };
            let (mut visited, mut turned) = ([*block], [*turns]);
            visited[0].turns = 0;
            let order = Visits { reversed: false, add_up: false };
            visit_all(level, (&mut visited, &mut turned), &mut seen, pass, order);
            for &body in block.bodies.as_flattened() {
                seen[body as usize] = velocities[body as usize];
            }
            greatest = kernel::greatest_change(greatest, &visited[0], block);
            greatest = kernel::greatest_turn(greatest, &turned[0], turns);
        }
        self.pushes = seen;
        greatest
    }

    /// Errors at the end of the step.
    pub fn see(&mut self, level: Level, movers: &Movers) {
        let (blocks, turns, poses) = (&mut self.blocks, &mut self.turns, &mut self.poses);
        dispatch!(level, simd => {
            follow(simd, &movers.blocks, poses, None);
            see_all(simd, blocks, turns, poses);
        });
    }

    /// Impulses, forces and errors back into the world; `share` makes stored impulses of those of a substep.
    pub(crate) fn store(&mut self, joints: &mut Arena<JointState>, share: f32, dt: f32, errors: &mut JointErrors) {
        for place in &self.places {
            let (lane, block) = (place.lane as usize, &mut self.blocks[place.block as usize]);
            let mut turns = self.turns.get_mut(block.turns as usize);
            let joint = joints.at_mut(place.joint);
            let ball = BallParts::at(place, joint);
            let mut stored = joint.lambdas.iter_mut();
            each_impulse(&ball, block, turns.as_deref_mut(), lane, |lambda| {
                if let Some(stored) = stored.next() {
                    *stored = share * *lambda;
                }
            });
            joint.force = get(&block.total, lane) / dt;
            let (torque, error) = turns.map_or((Vec3::ZERO, 0.0), |turns| reaction(turns, lane));
            (joint.torque, joint.angle_error) = (torque / dt, error);
            joint.anchor_error = get(&block.gap, lane).length();
            errors.add(joint.anchor_error);
        }
    }
}

/// Torque on A, N·m·s, and how far the farthest angle is beyond its range, rad.
fn reaction(turns: &TurnLanes, lane: usize) -> (Vec3, f32) {
    let (mut torque, mut error) = (Vec3::ZERO, 0.0_f32);
    // A drag's and an angle's are of B relative to A.
    if turns.parts.drags {
        torque -= turns.drags.iter().map(|drag| get(&drag.total, lane)).sum::<Vec3>();
    }
    if turns.parts.ranges {
        for (range, end) in kernel::ENDS {
            let sign = if end == 0 { 1.0 } else { -1.0 };
            torque -= sign * turns.ranges[range].total[end][lane] * turns.axis(range, lane);
            error = error.max(-turns.ranges[range].gaps[end][lane]);
        }
    }
    (torque, error)
}

/// Poses of the movers, and how they turn.
#[inline(always)]
fn follow<S: Simd>(simd: S, movers: &[MoverBlock], poses: &mut [Record], spins: Option<&mut [Record]>) {
    let mut spins = spins.unwrap_or_default().as_chunks_mut().0.iter_mut();
    for (block, poses) in movers.iter().zip(poses.as_chunks_mut().0) {
        moving::pose(simd, block, poses);
        if let Some(spins) = spins.next() {
            moving::swing(simd, block, spins);
        }
    }
}

#[inline(always)]
fn turn_all<S: Simd>(simd: S, blocks: &mut [JointBlock], turns: &mut [TurnLanes], aim: &Aim<'_>) {
    for block in blocks {
        let turns = turns.get_mut(block.turns as usize);
        kernel::turn(simd, block, turns, aim);
    }
}

#[inline(always)]
fn warm_start_all<S: Simd>(simd: S, blocks: &[JointBlock], turns: &[TurnLanes], velocities: &mut [Record]) {
    for block in blocks {
        kernel::warm_start(simd, block, turns.get(block.turns as usize), velocities);
    }
}

/// In which order, and whether λ is what the substep leaves.
#[derive(Clone, Copy)]
struct Visits {
    reversed: bool,
    add_up: bool,
}

/// A visit to each.
fn visit_all(
    level: Level,
    (blocks, turns): (&mut [JointBlock], &mut [TurnLanes]),
    velocities: &mut [Record],
    pass: &JointPass,
    order: Visits,
) {
    if order.reversed {
        dispatch!(level, simd => sweep::<_, true>(simd, blocks, turns, velocities, pass, order.add_up));
    } else {
        dispatch!(level, simd => sweep::<_, false>(simd, blocks, turns, velocities, pass, order.add_up));
    }
}

#[inline(always)]
fn sweep<S: Simd, const REVERSED: bool>(
    simd: S,
    blocks: &mut [JointBlock],
    turns: &mut [TurnLanes],
    velocities: &mut [Record],
    pass: &JointPass,
    add_up: bool,
) {
    let n = blocks.len();
    for i in 0..n {
        let block = &mut blocks[if REVERSED { n - 1 - i } else { i }];
        let mut turns = turns.get_mut(block.turns as usize);
        kernel::visit::<S, REVERSED>(simd, block, turns.as_deref_mut(), velocities, pass);
        if add_up {
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
fn add_up_all<S: Simd>(simd: S, blocks: &mut [JointBlock], turns: &mut [TurnLanes]) {
    for block in blocks {
        let turns = turns.get_mut(block.turns as usize);
        kernel::add_up(simd, block, turns);
    }
}

#[inline(always)]
fn see_all<S: Simd>(simd: S, blocks: &mut [JointBlock], turns: &mut [TurnLanes], poses: &[Record]) {
    for block in blocks {
        let turns = turns.get_mut(block.turns as usize);
        kernel::see(simd, block, turns, poses);
    }
}
