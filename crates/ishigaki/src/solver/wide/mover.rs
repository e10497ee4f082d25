//! Moving bodies of a batch, eight side by side: their states over the substeps, and what weights their velocities.
//!
//! The state is (v, L, pose), as in the reference; solver impulses change L by exactly I^½Δu'. Arrays of records have one
//! for each lane. The first lane is the ground's, which has no mass and never moves; nor do lanes that nobody fills.
//! What is done to them in a substep is in `moving.rs`.

use crate::body::BodyState;
use crate::math::{Quat, Vec3};
use crate::motion::{Spin, forces};
use crate::solver::wide::lanes::{LANES, Lane, Lane3, Record, get, set};

/// A symmetric matrix of each lane: xx, xy, xz, yy, yz, zz.
pub type Lane6 = [Lane; 6];

const ZERO: Lane = [0.0; LANES];
const ZERO3: Lane3 = [ZERO; 3];

/// Eight bodies.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug)]
pub struct MoverBlock {
    /// v, m/s.
    pub velocity: Lane3,
    /// L, kg·m²/s.
    pub momentum: Lane3,
    /// ω, rad/s.
    pub spin: Lane3,
    /// Of mass, m.
    pub center: Lane3,
    /// `world_from_body`.
    pub rotation: [Lane; 4],
    /// 1/m, 1/kg.
    pub inverse_mass: Lane,
    /// I^½ in world, of the start of the step or as bodies were weighed anew.
    pub root: Lane6,
    /// I^−½.
    pub inverse_root: Lane6,
    /// `local_from_principal`.
    pub frame: [Lane; 4],
    /// How far it turned since it was weighed, Σ h ω, rad; of those with which rows of joints turn.
    pub turn: Lane3,
    /// About the principal axes, kg·m².
    pub inertia: Lane3,
    /// 1/I about the principal axes.
    pub inverse_inertia: Lane3,
    /// F/m + g, m/s².
    pub acceleration: Lane3,
    /// N·m.
    pub torque: Lane3,
    /// What damping leaves of v and L in a substep.
    pub kept: [Lane; 2],
    /// Bits of the lanes whose moments of inertia are not all the same.
    pub uneven: u8,
    /// Bits of those of them with which rows of joints turn.
    pub weighed: u8,
    /// Some lane has a torque or angular damping.
    pub is_turned: bool,
}

impl MoverBlock {
    /// Nothing that moves.
    const EMPTY: Self = Self {
        velocity: ZERO3,
        momentum: ZERO3,
        spin: ZERO3,
        center: ZERO3,
        rotation: [ZERO, ZERO, ZERO, [1.0; LANES]],
        inverse_mass: ZERO,
        root: [ZERO; 6],
        inverse_root: [ZERO; 6],
        frame: [ZERO, ZERO, ZERO, [1.0; LANES]],
        turn: ZERO3,
        inertia: ZERO3,
        inverse_inertia: ZERO3,
        acceleration: ZERO3,
        torque: ZERO3,
        kept: [[1.0; LANES]; 2],
        uneven: 0,
        weighed: 0,
        is_turned: false,
    };

    /// Before its lanes are filled; those of bodies are written over as they are.
    pub(super) fn begin(&mut self, slots: &[u32]) {
        if slots.contains(&NOBODY) {
            *self = Self::EMPTY;
        }
        self.turn = ZERO3;
        (self.uneven, self.weighed, self.is_turned) = (0, 0, false);
    }

    /// A lane for a body in substeps of `h` seconds; `is_jointed` if rows of joints turn with it.
    pub(super) fn fill(&mut self, lane: usize, body: &BodyState, gravity: Vec3, h: f32, is_jointed: bool) {
        let spin = body.spin();
        let inverse_mass = body.inverse_mass;
        self.inverse_mass[lane] = inverse_mass;
        set(&mut self.velocity, lane, body.velocity);
        set(&mut self.center, lane, body.center);
        set_rotation(&mut self.frame, lane, spin.principal_frame);
        set(&mut self.inertia, lane, spin.principal_inertia);
        set(&mut self.inverse_inertia, lane, spin.inverse_principal_inertia);
        set(&mut self.momentum, lane, spin.angular_momentum);
        self.set_turn(lane, &spin);
        let acceleration = if inverse_mass > 0.0 { gravity * body.gravity_scale } else { Vec3::ZERO };
        set(&mut self.acceleration, lane, body.force * inverse_mass + acceleration);
        set(&mut self.torque, lane, body.torque);
        self.is_turned |= body.torque != Vec3::ZERO || body.angular_damping != 0.0;
        for (kept, damping) in self.kept.iter_mut().zip([body.linear_damping, body.angular_damping]) {
            kept[lane] = forces::damping_factor(damping, h);
        }
        if !spin.is_isotropic() {
            self.uneven |= 1 << lane;
            if is_jointed {
                self.weighed |= 1 << lane;
            }
        }
    }

    /// R, L and ω of a lane, with what ties them.
    pub fn spin(&self, lane: usize) -> Spin {
        Spin {
            rotation: rotation_of(&self.rotation, lane),
            principal_frame: rotation_of(&self.frame, lane),
            principal_inertia: get(&self.inertia, lane),
            inverse_principal_inertia: get(&self.inverse_inertia, lane),
            angular_momentum: get(&self.momentum, lane),
            angular_velocity: get(&self.spin, lane),
        }
    }

    /// Takes R and ω over.
    pub fn set_turn(&mut self, lane: usize, spin: &Spin) {
        set_rotation(&mut self.rotation, lane, spin.rotation);
        set(&mut self.spin, lane, spin.angular_velocity);
    }
}

fn set_rotation(lanes: &mut [Lane; 4], lane: usize, rotation: Quat) {
    for (lanes, value) in lanes.iter_mut().zip(rotation.to_array()) {
        lanes[lane] = value;
    }
}

fn rotation_of(lanes: &[Lane; 4], lane: usize) -> Quat {
    let [x, y, z, w] = lanes.map(|lanes| lanes[lane]);
    Quat::from_xyzw(x, y, z, w)
}

fn times(matrix: &Lane6, lane: usize, v: Vec3) -> Vec3 {
    let [xx, xy, xz, yy, yz, zz] = matrix.map(|lanes| lanes[lane]);
    Vec3::new(xx * v.x + xy * v.y + xz * v.z, xy * v.x + yy * v.y + yz * v.z, xz * v.x + yz * v.y + zz * v.z)
}

fn record(linear: Vec3, angular: Vec3) -> Record {
    Record([linear.x, linear.y, linear.z, 0.0, angular.x, angular.y, angular.z, 0.0])
}

fn parts(record: &Record) -> (Vec3, Vec3) {
    let [x, y, z, _, p, q, r, _] = record.0;
    (Vec3::new(x, y, z), Vec3::new(p, q, r))
}

/// Bodies of a batch.
#[derive(Clone, Debug, Default)]
pub struct Movers {
    /// Their slots in the world, lane by lane; [`NOBODY`] for the ground and for lanes that nobody fills.
    pub slots: Vec<u32>,
    /// Eight by eight.
    pub blocks: Vec<MoverBlock>,
    /// Records of the bodies in the order of their slots; nothing if they are in this order themselves.
    sorted: Vec<u32>,
    in_order: Vec<u32>,
    /// Of each record: its place among those, from 1 on; nothing if it is the record itself.
    ranks: Vec<u32>,
}

/// In the place of a slot: nothing that moves.
pub const NOBODY: u32 = u32::MAX;

impl Movers {
    /// Forgets all but the ground.
    pub fn clear(&mut self) {
        self.slots.clear();
        self.slots.push(NOBODY);
        self.sorted.clear();
        self.ranks.clear();
    }

    /// Adds an active dynamic body without locked axes.
    pub fn add(&mut self, slot: u32) {
        self.slots.push(slot);
    }

    /// Whether they are those that were last put domain by domain, in the same order.
    pub fn are_as_before(&self) -> bool {
        self.slots == self.in_order
    }

    /// Puts the bodies domain by domain, in whole blocks and with a ground of its own before each; the records of these.
    pub fn arrange(&mut self, domain_of_body: &[u8], grounds: &mut [usize]) {
        std::mem::swap(&mut self.slots, &mut self.in_order);
        self.slots.clear();
        self.sorted.resize(domain_of_body.len(), 0);
        for (number, ground) in grounds.iter_mut().enumerate() {
            self.slots.resize(self.slots.len().next_multiple_of(LANES), NOBODY);
            *ground = self.slots.len();
            self.slots.push(NOBODY);
            for ((&slot, &domain), record) in self.in_order[1..].iter().zip(domain_of_body).zip(&mut self.sorted) {
                if usize::from(domain) == number {
                    *record = self.slots.len() as u32;
                    self.slots.push(slot);
                }
            }
        }
        self.ranks.resize(self.slots.len(), 0);
        for (&record, rank) in self.sorted.iter().zip(1..) {
            self.ranks[record as usize] = rank;
        }
    }

    /// Records and slots of the bodies, in the order of their slots.
    pub fn bodies(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        let of_record = |record: u32| (record, self.slots[record as usize]);
        let is_sorted = self.sorted.is_empty();
        let in_place = (0..self.slots.len() as u32).filter(move |_| is_sorted).map(of_record);
        in_place.chain(self.sorted.iter().map(move |&record| of_record(record))).filter(|&(_, slot)| slot != NOBODY)
    }

    /// A number for the body with this record, from 1 on, that does not depend on domains; 0 for the ground.
    pub fn rank(&self, record: u32) -> u32 {
        self.ranks.get(record as usize).copied().unwrap_or(record)
    }

    /// Whole blocks, one lane for each slot.
    pub fn make_blocks(&mut self) {
        self.slots.resize(self.slots.len().next_multiple_of(LANES), NOBODY);
        self.blocks.resize(self.slots.len() / LANES, MoverBlock::EMPTY);
    }

    /// How many records there are: one for each lane.
    pub fn records(&self) -> usize {
        self.slots.len()
    }

    fn at(&self, record: u32) -> (&MoverBlock, usize) {
        let index = record as usize;
        (&self.blocks[index / LANES], index % LANES)
    }

    /// Whether all moments of inertia of the body with this record are the same; nor does the ground turn.
    pub fn is_round(&self, record: u32) -> bool {
        let (block, lane) = self.at(record);
        block.uneven >> lane & 1 == 0
    }

    /// The first of I^−½ of the body with this record: all of it, if it is round.
    pub fn inverse_root_inertia(&self, record: u32) -> f32 {
        let (block, lane) = self.at(record);
        block.inverse_root[0][lane]
    }

    /// v and ω of u'.
    pub fn velocities(&self, record: u32, u: &Record) -> (Vec3, Vec3) {
        let ((block, lane), (linear, angular)) = (self.at(record), parts(u));
        (linear, times(&block.inverse_root, lane, angular))
    }

    /// u' of v and ω.
    pub fn weighted(&self, record_of: u32, velocity: Vec3, angular_velocity: Vec3) -> Record {
        let (block, lane) = self.at(record_of);
        record(velocity, times(&block.root, lane, angular_velocity))
    }

    /// The change of u' that an impulse, N·s, and an angular impulse, N·m·s, make.
    pub fn pushed(&self, record_of: u32, impulse: Vec3, torque: Vec3) -> Record {
        let (block, lane) = self.at(record_of);
        record(block.inverse_mass[lane] * impulse, times(&block.inverse_root, lane, torque))
    }

    /// (m v, I ω) of u', N·s and N·m·s; nothing of what has no mass.
    pub fn impetus(&self, record: u32, u: &Record) -> (Vec3, Vec3) {
        let ((block, lane), (linear, angular)) = (self.at(record), parts(u));
        let inverse_mass = block.inverse_mass[lane];
        let mass = if inverse_mass > 0.0 { 1.0 / inverse_mass } else { 0.0 };
        (mass * linear, times(&block.root, lane, angular))
    }

    /// Into the world.
    pub fn store(&self, record: u32, body: &mut BodyState) {
        let (block, lane) = self.at(record);
        body.velocity = get(&block.velocity, lane);
        body.center = get(&block.center, lane);
        body.rotation = rotation_of(&block.rotation, lane);
        body.angular_momentum = get(&block.momentum, lane);
        body.angular_velocity = get(&block.spin, lane);
    }
}
