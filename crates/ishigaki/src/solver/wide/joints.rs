//! Joints of a batch: from the world into blocks, over the substeps, and back.
//!
//! Joints are visited level by level, outward from what does not move (`joint_link.rs`), and on a level wave by wave: those
//! of a wave share no body that moves. Colors of all joints at once would fill lanes as well, but carry a load over a few
//! joints in a sweep; along levels it passes through a whole net, whatever the order in which its joints were added.
//!
//! As long as bodies and joints of a batch are those of the step before, its joints stay in their blocks, with their impulses.
//!
//! A large batch is cut into cells (`domain.rs`): its joints come cell by cell, and those of the seam after all cells.
//! Several threads take cells side by side.

use crate::body::BodyState;
use crate::constraint::joint::{Joint, JointKind, Range as AngleRange};
use crate::handle::Arena;
use crate::math::{Quat, Vec3};
use crate::solver::joint_link::JointLink;
use crate::solver::wide::domain::Domain;
use crate::solver::wide::joint_block::{self as kernel, CONE, DAMPING, FRICTION, JointBlock, Parts, TWIST, TurnLanes};
use crate::solver::wide::lanes::{LANES, Record, get};
use crate::solver::work;
use crate::world::JointState;
use std::ops::Range;

/// Where a joint is.
#[derive(Clone, Copy, Debug)]
pub struct JointPlace {
    /// Its slot.
    pub joint: u32,
    /// Its bodies in the batch; 0 for what does not move.
    pub bodies: [u32; 2],
    pub(super) poses: [u32; 2],
    /// Of its joint; then its wave among those of its cell.
    wave: u32,
    /// The cell of its bodies, or the seam: `domain.rs`.
    pub cell: u8,
    kind: u8,
    pub(super) block: u32,
    pub(super) lane: u32,
}

/// Multiply-adds of joints, counted once a step.
#[derive(Clone, Copy, Debug, Default)]
pub struct JointWork {
    /// Of a sweep.
    pub sweep: u64,
    /// Of points alone in it.
    pub points: u64,
    /// Of over-relaxation in it.
    pub reach: u64,
    /// Of a sweep of the recovery by poses.
    pub recovery: u64,
    /// Of a warm start.
    pub warm_start: u64,
    /// Of rows at a pose.
    pub rows: u64,
}

/// Joints of a cell, or of the seam.
#[derive(Clone, Debug, Default)]
struct Cell {
    names: Range<usize>,
    blocks: Range<usize>,
    turns: Range<usize>,
    /// By wave and kind: first how many joints, then the first block.
    counts: Vec<[u32; Parts::KINDS]>,
    /// The level at which it is, and its first wave.
    level: u32,
    first_wave: u32,
}

/// A body while joints are dealt out to waves.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Mark {
    /// One more than the level of its last joint; 0 if it has none.
    level: u32,
    /// Waves of this level in which it is.
    waves: u64,
}

impl Mark {
    /// It has joints.
    pub fn is_joined(self) -> bool {
        self.level > 0
    }
}

/// When joints were put into blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Stamp {
    /// Of the links: `joint_link.rs`.
    pub edition: u64,
    /// Whose impulses they hold.
    pub step: u64,
}

/// All joints of a batch.
#[derive(Clone, Debug, Default)]
pub struct Joints {
    /// What they were put into blocks for; nothing if they do not stay there.
    stamp: Option<Stamp>,
    /// Lane by lane, the bodies of the batch then.
    slots: Vec<u32>,
    /// They are where they were in the step before.
    is_kept: bool,
    /// In the order of the world.
    pub places: Vec<JointPlace>,
    /// Wave by wave.
    pub blocks: Vec<JointBlock>,
    /// What some of them ask of rotations.
    pub(super) turns: Vec<TurnLanes>,
    /// Places of those of each cell, one cell after the other, and of the seam.
    pub(super) names: Vec<u32>,
    cells: Vec<Cell>,
    /// Rows of the reference that they would be.
    pub rows: u32,
    /// Centers and rotations: the movers, then what does not move.
    pub(super) poses: Vec<Record>,
    /// Slots of what does not move.
    still: Vec<u32>,
    /// Angular velocity and free angular acceleration of the movers.
    pub(super) spins: Vec<Record>,
    /// Velocities of the recovery by poses.
    pub(super) pushes: Vec<Record>,
    /// Of each body.
    pub(super) marks: Vec<Mark>,
    /// Places, level by level.
    by_level: Vec<u32>,
    /// How many places are on a level, then where those of the next begin.
    of_level: Vec<u32>,
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
pub(super) struct BallParts {
    pub cone: Option<f32>,
    pub twist: Option<AngleRange>,
    pub friction: f32,
    pub damping: f32,
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
    pub fn at(place: &JointPlace, joint: &JointState) -> Self {
        if place.kind == 0 { Self::NONE } else { Self::of(&joint.definition) }
    }

    fn parts(&self) -> Parts {
        Parts { ranges: self.cone.is_some() || self.twist.is_some(), drags: self.friction > 0.0 || self.damping > 0.0 }
    }
}

/// Where the lanes have an impulse of a joint.
#[derive(Clone, Copy)]
pub(super) enum Impulse {
    /// Which of [`TurnLanes::drags`], and along which axis.
    Drag(usize, usize),
    /// Which of [`TurnLanes::ranges`], and of which end.
    End(usize, usize),
    /// Along which axis.
    Point(usize),
}

impl Impulse {
    /// Those of a joint, in the order in which it keeps them: `constraint/ball.rs`.
    pub fn each(ball: &BallParts, mut visit: impl FnMut(Self)) {
        for (drag, exists) in [(FRICTION, ball.friction > 0.0), (DAMPING, ball.damping > 0.0)] {
            if exists {
                (0..3).for_each(|axis| visit(Self::Drag(drag, axis)));
            }
        }
        let twist = ball.twist.map_or([false; 2], |t| [t.lower.is_finite(), t.upper.is_finite()]);
        for (range, end, exists) in [(TWIST, 0, twist[0]), (TWIST, 1, twist[1]), (CONE, 1, ball.cone.is_some())] {
            if exists {
                visit(Self::End(range, end));
            }
        }
        (0..3).for_each(|axis| visit(Self::Point(axis)));
    }

    fn of(self, block: &JointBlock, turns: Option<&TurnLanes>, lane: usize) -> f32 {
        match self {
            Self::Point(axis) => block.lambda[axis][lane],
            Self::Drag(drag, axis) => turns.map_or(0.0, |turns| turns.drags[drag].lambda[axis][lane]),
            Self::End(range, end) => turns.map_or(0.0, |turns| turns.ranges[range].lambda[end][lane]),
        }
    }

    /// Writes it.
    pub fn set(self, block: &mut JointBlock, turns: Option<&mut TurnLanes>, lane: usize, impulse: f32) {
        match (self, turns) {
            (Self::Point(axis), _) => block.lambda[axis][lane] = impulse,
            (Self::Drag(drag, axis), Some(turns)) => turns.drags[drag].lambda[axis][lane] = impulse,
            (Self::End(range, end), Some(turns)) => turns.ranges[range].lambda[end][lane] = impulse,
            (_, None) => {}
        }
    }
}

fn pose_record(center: Vec3, rotation: Quat) -> Record {
    Record([center.x, center.y, center.z, 0.0, rotation.x, rotation.y, rotation.z, rotation.w])
}

impl Cell {
    /// A wave for a joint on this level, after those of lower levels: the first one that its bodies are not in.
    fn deal(&mut self, place: &mut JointPlace, level: u32, marks: &mut [Mark]) {
        if self.level != level || self.counts.is_empty() {
            (self.level, self.first_wave) = (level, self.counts.len() as u32);
        }
        let mut taken = 0_u64;
        for &body in place.bodies.iter().filter(|&&b| b != 0) {
            let mark = &mut marks[body as usize];
            if mark.level != level + 1 {
                *mark = Mark { level: level + 1, waves: 0 };
            }
            taken |= mark.waves;
        }
        place.wave = match taken.trailing_ones() {
            // All are taken: it gets one of its own, beyond all that are told apart, whether or not this cell has them.
            u64::BITS => (self.counts.len() as u32).max(self.first_wave + u64::BITS),
            free => {
                place.bodies.iter().filter(|&&b| b != 0).for_each(|&b| marks[b as usize].waves |= 1 << free);
                self.first_wave + free
            }
        };
        if self.counts.len() <= place.wave as usize {
            self.counts.resize(place.wave as usize + 1, [0; Parts::KINDS]);
        }
        let count = &mut self.counts[place.wave as usize][usize::from(place.kind)];
        place.lane = *count;
        *count += 1;
    }
}

impl JointWork {
    /// A joint more, in this lane, with the impulses it had when the step began.
    pub(super) fn add(&mut self, block: &JointBlock, turns: Option<&TurnLanes>, lane: usize) {
        let (point, push, rows) = match block.is_round {
            true => (work::ROUND_POINT, work::ROUND_POINT_PUSH, work::ROUND_POINT_ROWS),
            false => (work::POINT, work::POINT_PUSH, work::POINT_ROWS),
        };
        self.warm_start += push;
        let (mut ends, mut drags, mut ranges) = (0, 0, 0);
        if let Some(turns) = turns {
            let bears = |&(range, end): &(usize, usize)| turns.ranges[range].lambda[end][lane] > 0.0;
            let bearing = kernel::ENDS.iter().filter(|end| bears(end)).count() as u64;
            if turns.parts.ranges {
                (ends, ranges) =
                    (3 * work::TURN_LOOK + bearing * (work::TURN_PUSH + point + work::FREE_PART), work::RANGE_ROWS);
                self.warm_start += 3 * work::TURN_PUSH;
            }
            if turns.parts.drags {
                drags = 6 * work::TURN_VISIT;
                self.warm_start += 6 * work::TURN_PUSH;
            }
        }
        self.recovery += point + work::POINT_PART + ends;
        self.reach += work::POINT_PART;
        self.points += point;
        self.sweep += point + ends + drags;
        self.rows += rows + ranges;
    }
}

impl std::ops::AddAssign for JointWork {
    fn add_assign(&mut self, other: Self) {
        self.sweep += other.sweep;
        self.reach += other.reach;
        self.points += other.points;
        self.recovery += other.recovery;
        self.warm_start += other.warm_start;
        self.rows += other.rows;
    }
}

impl Joints {
    /// Leaves so many joints of these bodies where they are, if they are those of the step before; else forgets all.
    /// Nothing stays that has no stamp.
    pub(crate) fn keep(&mut self, slots: &[u32], count: u32, now: Option<Stamp>) -> bool {
        self.is_kept = now.is_some() && self.stamp == now && self.places.len() == count as usize && self.slots == slots;
        self.stamp = now.map(|now| Stamp { step: now.step + 1, ..now });
        if !self.is_kept {
            self.clear();
            self.slots.clear();
            if count > 0 {
                self.slots.extend_from_slice(slots);
            }
        }
        self.is_kept
    }

    /// They need not be added.
    pub fn is_kept(&self) -> bool {
        self.is_kept
    }

    fn clear(&mut self) {
        self.places.clear();
        self.still.clear();
        self.marks.clear();
        self.rows = 0;
        self.work = JointWork::default();
    }

    /// There are none.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Adds a joint; `bodies` are their indices in the batch.
    pub(crate) fn add(&mut self, link: &JointLink, bodies: [u32; 2], cell: u8) {
        // What does not move has its pose after those of the movers, whose number is not known yet.
        let mut poses = bodies;
        for (pose, end) in poses.iter_mut().zip(link.bodies) {
            if *pose == 0 {
                self.still.push(end);
                *pose = u32::MAX - (self.still.len() as u32 - 1);
            }
        }
        let JointLink { joint, kind, level, .. } = *link;
        self.places.push(JointPlace { joint, bodies, poses, wave: level, cell, kind, block: 0, lane: 0 });
    }

    /// Waves and blocks, among so many records; which of them are of which domain, where bodies are of so many cells.
    /// A line of its own in profiles.
    #[inline(never)]
    pub(crate) fn arrange(&mut self, records: usize, cells: usize, bodies: &Arena<BodyState>, domains: &mut [Domain]) {
        if self.is_empty() {
            self.turns.clear();
            self.blocks.clear();
            self.names.clear();
            for list in [&mut self.poses, &mut self.spins, &mut self.pushes] {
                list.clear();
            }
            return;
        }
        if self.is_kept {
            self.empty_turns();
        } else {
            self.turns.clear();
            self.cells.resize_with(cells + 1, Cell::default);
            self.make_waves(records);
            self.make_blocks();
            self.name_joints();
        }
        self.share_out(domains);
        // Whatever is in them is written over before it is read.
        for records_of in [&mut self.poses, &mut self.spins, &mut self.pushes] {
            records_of.resize(records, Record::default());
        }
        let still = self.still.iter().map(|&slot| bodies.at(slot));
        self.poses.extend(still.map(|body| pose_record(body.center, body.rotation)));
    }

    /// Whether their lanes hold all that lanes are filled with: those that ask nothing of rotations.
    pub(super) fn are_filled(&self) -> bool {
        self.is_kept && self.turns.is_empty()
    }

    /// Blocks that stay, before lanes are filled anew.
    fn empty_turns(&mut self) {
        if self.turns.is_empty() {
            return;
        }
        (self.rows, self.work) = (0, JointWork::default());
        for turns in &mut self.turns {
            *turns = TurnLanes::new(turns.parts);
        }
        for block in &mut self.blocks {
            block.begin(block.turns);
        }
    }

    /// Which joints are of which domain: of each cell's its own, or all of one. One cell among several domains is theirs
    /// together, as the seam is.
    fn share_out(&self, domains: &mut [Domain]) {
        let (cells, last) = (self.cells.len(), domains.len() - 1);
        let ends = self.cells.iter().map(|cell| (cell.names.end, cell.blocks.end, cell.turns.end));
        let mut end = (0, 0, 0);
        for (number, next) in ends.enumerate() {
            let domain = &mut domains[if last == 1 {
                0
            } else if cells == 2 {
                last
            } else {
                number
            }];
            if domain.joints.is_empty() {
                (domain.joints.start, domain.joint_blocks.start, domain.turns.start) = end;
            }
            (domain.joints.end, domain.joint_blocks.end, domain.turns.end) = next;
            end = next;
        }
    }

    /// Waves of each cell and of the seam, level by level.
    fn make_waves(&mut self, records: usize) {
        let first_still = records as u32;
        self.of_level.clear();
        for place in &mut self.places {
            for pose in &mut place.poses {
                if *pose >= first_still {
                    *pose = first_still + (u32::MAX - *pose);
                }
            }
            if self.of_level.len() <= place.wave as usize {
                self.of_level.resize(place.wave as usize + 1, 0);
            }
            self.of_level[place.wave as usize] += 1;
        }
        let mut first = 0;
        for count in &mut self.of_level {
            (*count, first) = (first, first + *count);
        }
        self.by_level.resize(self.places.len(), 0);
        for (place, name) in self.places.iter().zip(0..) {
            let next = &mut self.of_level[place.wave as usize];
            self.by_level[*next as usize] = name;
            *next += 1;
        }
        self.marks.clear();
        self.marks.resize(records, Mark::default());
        self.cells.iter_mut().for_each(|cell| cell.counts.clear());
        for &name in &self.by_level {
            let place = &mut self.places[name as usize];
            self.cells[usize::from(place.cell)].deal(place, place.wave, &mut self.marks);
        }
    }

    /// Blocks for what was counted. Full ones are written over; those with lanes that nothing fills are emptied.
    fn make_blocks(&mut self) {
        let (mut first, mut names) = (0, 0);
        for cell in &mut self.cells {
            cell.names = names..names;
            cell.blocks.start = first;
            cell.turns.start = self.turns.len();
            for of_wave in &mut cell.counts {
                for (kind, count) in of_wave.iter_mut().enumerate() {
                    let parts = Parts::of_kind(kind);
                    names += *count as usize;
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
            (cell.blocks.end, cell.turns.end) = (first, self.turns.len());
        }
        self.blocks.truncate(first);
        self.names.resize(names, 0);
    }

    /// Where joints are among the blocks; the list of those of each cell.
    fn name_joints(&mut self) {
        for (place, name) in self.places.iter_mut().zip(0..) {
            let cell = &mut self.cells[usize::from(place.cell)];
            place.block = cell.counts[place.wave as usize][usize::from(place.kind)] + place.lane / LANES as u32;
            place.lane %= LANES as u32;
            self.names[cell.names.end] = name;
            cell.names.end += 1;
        }
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

    /// Places of the joints in these slots.
    pub(crate) fn places_in(&self, slots: Range<u32>) -> &[JointPlace] {
        let below = |slot: u32| self.places.partition_point(|place| place.joint < slot);
        &self.places[below(slots.start)..below(slots.end)]
    }

    /// Impulses, force and errors of a joint, for the world. What has joints takes all substeps: its impulses are those of
    /// one.
    pub(crate) fn store(&self, place: &JointPlace, joint: &mut JointState, dt: f32) {
        let (lane, block) = (place.lane as usize, &self.blocks[place.block as usize]);
        let turns = self.turns.get(block.turns as usize);
        let ball = BallParts::at(place, joint);
        let mut stored = joint.lambdas.iter_mut();
        Impulse::each(&ball, |impulse| {
            if let Some(stored) = stored.next() {
                *stored = impulse.of(block, turns, lane);
            }
        });
        joint.force = get(&block.total, lane) / dt;
        let (torque, error) = turns.map_or((Vec3::ZERO, 0.0), |turns| reaction(turns, lane));
        (joint.torque, joint.angle_error) = (torque / dt, error);
        joint.anchor_error = get(&block.gap, lane).length();
    }

    /// They do not stay where they are: something else solves them.
    pub fn give_up(&mut self) {
        self.stamp = None;
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A hub with more joints than waves are told apart, in two cells, and joints among what hangs on it.
    #[test]
    fn joints_of_a_wave_share_no_body() {
        let mut cells = [Cell::default(), Cell::default()];
        let mut marks = [Mark::default(); 200];
        let ends = (2..90).map(|b| ([1, b], 0)).chain((90..170).map(|b| ([1, b], 1)));
        let ends = ends.chain((90..169).map(|b| ([b, b + 1], 1))).chain((2..89).map(|b| ([b, b + 1], 0)));
        let mut places = Vec::new();
        for (bodies, cell) in ends {
            let (joint, poses) = (0, bodies);
            let mut place = JointPlace { joint, bodies, poses, wave: 0, cell, kind: 0, block: 0, lane: 0 };
            cells[usize::from(cell)].deal(&mut place, 0, &mut marks);
            places.push(place);
        }
        for (k, one) in places.iter().enumerate() {
            for other in &places[..k] {
                let is_together = (one.cell, one.wave) == (other.cell, other.wave);
                let shares = one.bodies.iter().any(|body| other.bodies.contains(body));
                assert!(!(is_together && shares), "{one:?} and {other:?}");
            }
        }
    }
}
