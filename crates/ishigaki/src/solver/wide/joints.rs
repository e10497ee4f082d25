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
use crate::solver::wide::joint_block::{self as kernel, CONE, DAMPING, FRICTION, JointBlock, JointPass, Parts, TWIST};
use crate::solver::wide::lanes::{LANES, Record, get, set};
use crate::solver::wide::mover::{MoverBlock, Movers};
use crate::solver::wide::moving;
use crate::solver::work;
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
    kind: usize,
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

/// What a ball joint has beside the point.
#[derive(Clone, Copy)]
struct BallParts {
    cone: Option<f32>,
    twist: Option<Range>,
    friction: f32,
    damping: f32,
}

impl BallParts {
    fn of(joint: &Joint) -> Self {
        match &joint.kind {
            JointKind::Ball { cone, twist, friction, damping } => {
                Self { cone: *cone, twist: *twist, friction: *friction, damping: *damping }
            }
            _ => Self { cone: None, twist: None, friction: 0.0, damping: 0.0 },
        }
    }

    fn parts(&self) -> Parts {
        Parts { ranges: self.cone.is_some() || self.twist.is_some(), drags: self.friction > 0.0 || self.damping > 0.0 }
    }
}

/// A number of a lane, in the order in which a joint keeps its impulses: `constraint/ball.rs`.
fn each_impulse(ball: &BallParts, block: &mut JointBlock, lane: usize, mut visit: impl FnMut(&mut f32, &mut f32)) {
    for (drag, exists) in [(FRICTION, ball.friction > 0.0), (DAMPING, ball.damping > 0.0)] {
        if exists {
            let drag = &mut block.drags[drag];
            (0..3).for_each(|k| visit(&mut drag.lambda[k][lane], &mut drag.total[k][lane]));
        }
    }
    let twist = ball.twist.map_or([false; 2], |t| [t.lower.is_finite(), t.upper.is_finite()]);
    for (range, end, exists) in [(TWIST, 0, twist[0]), (TWIST, 1, twist[1]), (CONE, 1, ball.cone.is_some())] {
        if exists {
            let range = &mut block.ranges[range];
            visit(&mut range.lambda[end][lane], &mut range.total[end][lane]);
        }
    }
    (0..3).for_each(|k| visit(&mut block.lambda[k][lane], &mut block.total[k][lane]));
}

fn pose_record(center: Vec3, rotation: Quat) -> Record {
    Record([center.x, center.y, center.z, 0.0, rotation.x, rotation.y, rotation.z, rotation.w])
}

impl JointWork {
    /// A joint more, with so many ends of ranges at work when the step began.
    fn add(&mut self, parts: Parts, bearing: u64) {
        let Parts { ranges, drags } = parts;
        let ends = if ranges { 3 * work::TURN_VISIT } else { 0 } + bearing * (work::POINT + work::FREE_PART);
        self.recovery += work::POINT + ends;
        self.sweep += work::POINT + ends + if drags { 6 * work::TURN_VISIT } else { 0 };
        self.rows += work::POINT_ROWS + if ranges { work::RANGE_ROWS } else { 0 };
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
    pub(crate) fn add(&mut self, slot: u32, joint: &JointState, bodies: [u32; 2], world: &Arena<BodyState>) {
        let ends = [joint.definition.body_a.index, joint.definition.body_b.index];
        // What does not move has its pose after those of the movers, whose number is not known yet.
        let mut poses = bodies;
        for (pose, end) in poses.iter_mut().zip(ends) {
            if *pose == 0 {
                let body = world.at(end);
                self.still.push(pose_record(body.center, body.rotation));
                *pose = u32::MAX - (self.still.len() as u32 - 1);
            }
        }
        let kind = BallParts::of(&joint.definition).parts().kind();
        self.rows += joint.lambdas.len() as u32;
        self.places.push(JointPlace { joint: slot, bodies, poses, wave: 0, kind, block: 0, lane: 0 });
    }

    /// Waves and blocks, among so many records. A line of its own in profiles.
    #[inline(never)]
    pub(crate) fn arrange(&mut self, records: usize) {
        if self.is_empty() {
            self.blocks.clear();
            return;
        }
        self.make_waves(records);
        for records_of in [&mut self.poses, &mut self.spins, &mut self.pushes] {
            records_of.clear();
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
            let count = &mut self.counts[wave as usize][place.kind];
            place.lane = *count;
            *count += 1;
        }
        self.make_blocks();
        for place in &mut self.places {
            place.block = self.counts[place.wave as usize][place.kind] + place.lane / LANES as u32;
            place.lane %= LANES as u32;
        }
    }

    /// Blocks for what was counted. Full ones are written over, but for what not every joint has; those with lanes that
    /// nothing fills are emptied.
    fn make_blocks(&mut self) {
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
                self.blocks[first..end].iter_mut().for_each(|block| block.begin(parts));
                *count = first as u32;
                first = end;
            }
        }
        self.blocks.truncate(first);
    }

    fn fill_joint(&mut self, index: usize, movers: &Movers, joints: &Arena<JointState>, h: f32, scale: f32) {
        let place = self.places[index];
        let (lane, joint) = (place.lane as usize, joints.at(place.joint));
        let block = &mut self.blocks[place.block as usize];
        let resolved = &joint.resolved;
        let anchors = [(resolved.anchor_a, resolved.frame_a), (resolved.anchor_b, resolved.frame_b)];
        for (side, (anchor, frame)) in anchors.into_iter().enumerate() {
            block.bodies[side][lane] = place.bodies[side];
            block.poses[side][lane] = place.poses[side];
            set(&mut block.anchors[side], lane, anchor);
            block.root[side][lane] = movers.inverse_root_mass(place.bodies[side]);
            if block.parts.ranges {
                for (lanes, value) in block.frames[side].iter_mut().zip(frame.to_array()) {
                    lanes[lane] = value;
                }
            }
        }
        let ball = BallParts::of(&joint.definition);
        if let Some(cone) = ball.cone {
            block.ranges[CONE].limits[1][lane] = cone;
        }
        if let Some(twist) = &ball.twist {
            let range = &mut block.ranges[TWIST];
            (range.limits[0][lane], range.limits[1][lane]) = (twist.lower, twist.upper);
            range.middle[lane] = middle(Some(twist));
        }
        block.drags[FRICTION].reach[lane] = h * ball.friction;
        let softness = 1.0 / (h * ball.damping);
        if softness.is_finite() {
            (block.drags[DAMPING].softness[lane], block.drags[DAMPING].reach[lane]) = (softness, f32::INFINITY);
        }
        let mut stored = joint.lambdas.iter();
        each_impulse(&ball, block, lane, |lambda, _| *lambda = scale * stored.next().copied().unwrap_or(0.0));
        let bears = |&(range, end): &(usize, usize)| block.ranges[range].lambda[end][lane] > 0.0;
        let bearing = kernel::ENDS.iter().filter(|end| bears(end)).count() as u64;
        self.work.add(block.parts, bearing);
    }

    /// Rows for the poses as they are, and what the way along arcs will add to gaps in `h` seconds. `roots` holds I^−½
    /// of all bodies.
    pub fn aim(&mut self, level: Level, movers: &Movers, roots: &[Record], h: f32) {
        let (blocks, poses, spins) = (&mut self.blocks, &mut self.poses, &mut self.spins);
        dispatch!(level, simd => {
            follow(simd, &movers.blocks, poses);
            swing(simd, &movers.blocks, spins);
            aim_all(simd, blocks, poses, roots, spins, h);
        });
    }

    /// u' += J'ᵀλ.
    pub fn warm_start(&self, level: Level, velocities: &mut [Record]) {
        let blocks = &self.blocks;
        dispatch!(level, simd => warm_start_all(simd, blocks, velocities));
    }

    /// A visit to each joint; with `add_up` λ is what the substep leaves.
    pub fn sweep(&mut self, level: Level, velocities: &mut [Record], pass: &JointPass, reversed: bool, add_up: bool) {
        visit_all(level, &mut self.blocks, velocities, pass, reversed, add_up);
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
        let blocks = &mut self.blocks;
        dispatch!(level, simd => add_up_all(simd, blocks));
    }

    /// Without warm start each substep begins from nothing.
    pub fn forget(&mut self) {
        for block in &mut self.blocks {
            block.lambda = [[0.0; LANES]; 3];
            block.ranges.iter_mut().for_each(|r| r.lambda = [[0.0; LANES]; 2]);
            block.drags.iter_mut().for_each(|d| d.lambda = [[0.0; LANES]; 3]);
        }
    }

    /// Greatest change of an impulse that a visit would make.
    pub fn residual(&mut self, level: Level, velocities: &[Record], pass: &JointPass) -> f32 {
        if self.is_empty() {
            return 0.0;
        }
        let mut seen = std::mem::take(&mut self.pushes);
        seen.copy_from_slice(velocities);
        let mut greatest = 0.0;
        for block in &self.blocks {
            let mut visited = [*block];
            visit_all(level, &mut visited, &mut seen, pass, false, false);
            for &body in block.bodies.as_flattened() {
                seen[body as usize] = velocities[body as usize];
            }
            greatest = kernel::greatest_change(greatest, &visited[0], block);
        }
        self.pushes = seen;
        greatest
    }

    /// Errors at the end of the step.
    pub fn see(&mut self, level: Level, movers: &Movers) {
        let (blocks, poses) = (&mut self.blocks, &mut self.poses);
        dispatch!(level, simd => {
            follow(simd, &movers.blocks, poses);
            see_all(simd, blocks, poses);
        });
    }

    /// Impulses, forces and errors back into the world; `share` makes stored impulses of those of a substep.
    pub(crate) fn store(&mut self, joints: &mut Arena<JointState>, share: f32, dt: f32) {
        for place in &self.places {
            let (lane, block) = (place.lane as usize, &mut self.blocks[place.block as usize]);
            let joint = joints.at_mut(place.joint);
            let ball = BallParts::of(&joint.definition);
            let mut stored = joint.lambdas.iter_mut();
            each_impulse(&ball, block, lane, |lambda, _| {
                if let Some(stored) = stored.next() {
                    *stored = share * *lambda;
                }
            });
            joint.force = get(&block.total, lane) / dt;
            // Torques on A: a drag's and an angle's are of B relative to A.
            let mut torque = Vec3::ZERO;
            if block.parts.drags {
                torque -= block.drags.iter().map(|drag| get(&drag.total, lane)).sum::<Vec3>();
            }
            joint.angle_error = 0.0;
            if block.parts.ranges {
                for (range, end) in kernel::ENDS {
                    let sign = if end == 0 { 1.0 } else { -1.0 };
                    torque -= sign * block.ranges[range].total[end][lane] * block.axis(range, lane);
                    joint.angle_error = joint.angle_error.max(-block.ranges[range].gaps[end][lane]);
                }
            }
            joint.torque = torque / dt;
            joint.anchor_error = get(&block.gap, lane).length();
        }
    }
}

/// Poses of the movers.
#[inline(always)]
fn follow<S: Simd>(simd: S, movers: &[MoverBlock], poses: &mut [Record]) {
    for (block, poses) in movers.iter().zip(poses.as_chunks_mut().0) {
        moving::pose(simd, block, poses);
    }
}

/// How the movers turn.
#[inline(always)]
fn swing<S: Simd>(simd: S, movers: &[MoverBlock], spins: &mut [Record]) {
    for (block, spins) in movers.iter().zip(spins.as_chunks_mut().0) {
        moving::swing(simd, block, spins);
    }
}

#[inline(always)]
fn aim_all<S: Simd>(simd: S, blocks: &mut [JointBlock], poses: &[Record], roots: &[Record], spins: &[Record], h: f32) {
    for block in blocks {
        kernel::turn(simd, block, poses, roots);
        kernel::look_ahead(simd, block, spins, h);
    }
}

#[inline(always)]
fn warm_start_all<S: Simd>(simd: S, blocks: &[JointBlock], velocities: &mut [Record]) {
    for block in blocks {
        kernel::warm_start(simd, block, velocities);
    }
}

fn visit_all(
    level: Level,
    blocks: &mut [JointBlock],
    velocities: &mut [Record],
    pass: &JointPass,
    reversed: bool,
    add_up: bool,
) {
    if reversed {
        dispatch!(level, simd => sweep::<_, true>(simd, blocks, velocities, pass, add_up));
    } else {
        dispatch!(level, simd => sweep::<_, false>(simd, blocks, velocities, pass, add_up));
    }
}

#[inline(always)]
fn sweep<S: Simd, const REVERSED: bool>(
    simd: S,
    blocks: &mut [JointBlock],
    velocities: &mut [Record],
    pass: &JointPass,
    add_up: bool,
) {
    let n = blocks.len();
    for i in 0..n {
        let k = if REVERSED { n - 1 - i } else { i };
        kernel::visit::<S, REVERSED>(simd, &mut blocks[k], velocities, pass);
        if add_up {
            kernel::add_up(simd, &mut blocks[k]);
        }
    }
}

#[inline(always)]
fn add_up_all<S: Simd>(simd: S, blocks: &mut [JointBlock]) {
    for block in blocks {
        kernel::add_up(simd, block);
    }
}

#[inline(always)]
fn see_all<S: Simd>(simd: S, blocks: &mut [JointBlock], poses: &[Record]) {
    for block in blocks {
        kernel::see(simd, block, poses);
    }
}
