//! Moving bodies of a batch, eight side by side: their states over the substeps, and what weights their velocities.
//!
//! The state is (v, L, pose), as in the reference; solver impulses change L by exactly I^½Δu'. A body's record is one
//! after its index: the first is the ground's. Records fill whole blocks; lanes beyond the bodies hold nothing that moves.
//! What is done to them in a substep is in `moving.rs`.

use crate::body::BodyState;
use crate::handle::Arena;
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
    /// m^½.
    pub root_mass: Lane,
    /// m^−½.
    pub inverse_root_mass: Lane,
    /// I^½ in world, of the start of the step or as bodies were weighed anew.
    pub root: Lane6,
    /// I^−½.
    pub inverse_root: Lane6,
    /// `local_from_principal`.
    pub frame: [Lane; 4],
    /// About the principal axes, kg·m².
    pub inertia: Lane3,
    /// 1/I about the principal axes.
    pub inverse_inertia: Lane3,
    /// 1 where moments of inertia are not all the same, else 0.
    pub uneven: Lane,
    /// 1 where rows of joints turn with such a body, else 0.
    pub weighed: Lane,
    /// F/m + g, m/s².
    pub acceleration: Lane3,
    /// N·m.
    pub torque: Lane3,
    /// Of v and ω, 1/s.
    pub damping: [Lane; 2],
    /// What damping leaves of v and L in a substep.
    pub kept: [Lane; 2],
    /// Some lane is uneven.
    pub has_uneven: bool,
    /// Some lane is weighed.
    pub has_weighed: bool,
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
        root_mass: ZERO,
        inverse_root_mass: ZERO,
        root: [ZERO; 6],
        inverse_root: [ZERO; 6],
        frame: [ZERO, ZERO, ZERO, [1.0; LANES]],
        inertia: ZERO3,
        inverse_inertia: ZERO3,
        uneven: ZERO,
        weighed: ZERO,
        acceleration: ZERO3,
        torque: ZERO3,
        damping: [ZERO; 2],
        kept: [[1.0; LANES]; 2],
        has_uneven: false,
        has_weighed: false,
        is_turned: false,
    };

    fn fill(&mut self, lane: usize, body: &BodyState, gravity: Vec3) {
        let spin = body.spin();
        let inverse_mass = body.inverse_mass;
        let mass = if inverse_mass > 0.0 { 1.0 / inverse_mass } else { 0.0 };
        (self.root_mass[lane], self.inverse_root_mass[lane]) = (mass.sqrt(), inverse_mass.sqrt());
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
        (self.damping[0][lane], self.damping[1][lane]) = (body.linear_damping, body.angular_damping);
        self.is_turned |= body.torque != Vec3::ZERO || body.angular_damping != 0.0;
        if !spin.is_isotropic() {
            self.uneven[lane] = 1.0;
            self.has_uneven = true;
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
    /// Their slots in the world.
    pub slots: Vec<u32>,
    /// Eight by eight.
    pub blocks: Vec<MoverBlock>,
}

impl Movers {
    /// Forgets all.
    pub fn clear(&mut self) {
        self.slots.clear();
        self.blocks.clear();
    }

    /// Adds an active dynamic body without locked axes; the index of its record.
    pub fn add(&mut self, slot: u32) -> u32 {
        self.slots.push(slot);
        self.slots.len() as u32
    }

    /// States of the bodies, as they are in the world.
    pub(crate) fn fill(&mut self, bodies: &Arena<BodyState>, gravity: Vec3) {
        self.blocks.clear();
        for eight in self.slots.chunks(LANES) {
            let mut block = MoverBlock::EMPTY;
            for (lane, &slot) in eight.iter().enumerate() {
                block.fill(lane, bodies.at(slot), gravity);
            }
            self.blocks.push(block);
        }
    }

    /// How many records there are: of the ground, and of whole blocks.
    pub fn records(&self) -> usize {
        1 + LANES * self.blocks.len()
    }

    /// Before substeps of `h` seconds: what damping leaves, and which bodies are weighed anew after motions.
    pub fn begin_step(&mut self, h: f32, is_jointed: impl Fn(u32) -> bool) {
        for (index, _) in self.slots.iter().enumerate() {
            let (block, lane) = (&mut self.blocks[index / LANES], index % LANES);
            for (kept, damping) in block.kept.iter_mut().zip(&block.damping) {
                kept[lane] = forces::damping_factor(damping[lane], h);
            }
            if block.uneven[lane] > 0.0 && is_jointed(index as u32 + 1) {
                block.weighed[lane] = 1.0;
                block.has_weighed = true;
            }
        }
    }

    fn at(&self, record: u32) -> (&MoverBlock, usize) {
        let index = record as usize - 1;
        (&self.blocks[index / LANES], index % LANES)
    }

    /// m^−½ of the body with this record; 0 for the ground.
    pub fn inverse_root_mass(&self, record: u32) -> f32 {
        if record == 0 {
            return 0.0;
        }
        let (block, lane) = self.at(record);
        block.inverse_root_mass[lane]
    }

    /// v and ω of a mass-weighted velocity.
    pub fn velocities(&self, record: u32, u: &Record) -> (Vec3, Vec3) {
        let ((block, lane), (linear, angular)) = (self.at(record), parts(u));
        (block.inverse_root_mass[lane] * linear, times(&block.inverse_root, lane, angular))
    }

    /// The mass-weighted velocity of v and ω.
    pub fn weighted(&self, record_of: u32, velocity: Vec3, angular_velocity: Vec3) -> Record {
        let (block, lane) = self.at(record_of);
        record(block.root_mass[lane] * velocity, times(&block.root, lane, angular_velocity))
    }

    /// M^−½ times an impulse, N·s, and an angular impulse, N·m·s: the change of u' that they make.
    pub fn pushed(&self, record_of: u32, impulse: Vec3, torque: Vec3) -> Record {
        let (block, lane) = self.at(record_of);
        record(block.inverse_root_mass[lane] * impulse, times(&block.inverse_root, lane, torque))
    }

    /// M^½u' = (m v, I ω) of a mass-weighted velocity, N·s and N·m·s.
    pub fn impetus(&self, record: u32, u: &Record) -> (Vec3, Vec3) {
        let ((block, lane), (linear, angular)) = (self.at(record), parts(u));
        (block.root_mass[lane] * linear, times(&block.root, lane, angular))
    }

    /// Into the world.
    pub fn store(&self, index: usize, body: &mut BodyState) {
        let (block, lane) = (&self.blocks[index / LANES], index % LANES);
        body.velocity = get(&block.velocity, lane);
        body.center = get(&block.center, lane);
        body.rotation = rotation_of(&block.rotation, lane);
        body.angular_momentum = get(&block.momentum, lane);
        body.angular_velocity = get(&block.spin, lane);
    }
}
