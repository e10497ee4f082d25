//! Islands that are solved together while they are in the cache: bodies, blocks of manifolds, and their colors.
//!
//! A large batch is cut into domains; there manifolds get colors (`color.rs`), and eight of a color make a block.

use crate::body::{BodyState, NO_HEIGHT};
use crate::collision::feature_id::{Feature, FeatureId};
use crate::collision::manifold::{Contact, ContactPoint, Manifold};
use crate::handle::Arena;
use crate::math::Vec3;
use crate::options::{FrictionModel, WorldOptions};
use crate::solver::weight_amplification;
use crate::solver::wide::contact_block::{ContactBlock, ScaleLanes, Size, TangentLanes};
use crate::solver::wide::domain::{Domain, Machine, Part, Sums};
use crate::solver::wide::joints::Joints;
use crate::solver::wide::lanes::{LANES, Lane, Record, set};
use crate::solver::wide::mover::{Movers, NOBODY};
use crate::solver::wide::moving;
use crate::world::JointState;
use fearless_simd::{Level, dispatch};

/// A body that moves no faster than this part of what aggressive sleep calls rest is not about to go.
const CALM_SPEED: f32 = 0.2;

/// What fills the lanes of a block beyond the points of a manifold.
const NO_POINT: ContactPoint = ContactPoint {
    arm_a: Vec3::ZERO,
    arm_b: Vec3::ZERO,
    separation: 0.0,
    id: FeatureId::new(Feature::unknown(0), Feature::unknown(0)),
    lambda_normal: 0.0,
    lambda_friction: [0.0; 2],
    impulse: 0.0,
};

/// Where a manifold is.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Index of the contact.
    pub contact: u32,
    /// Which of its manifolds.
    pub manifold: u32,
    /// Its bodies in the batch; 0 for what does not move.
    pub bodies: [u32; 2],
    /// Island, local to the batch.
    pub island: u32,
    pub(super) domain: u8,
    /// Points of its block, at most.
    pub size: Size,
    pub(super) is_round: bool,
    /// Number of its lane among those of all blocks; before it has one, its color.
    pub(super) lane: u32,
}

/// What a batch remembers of each of its islands.
#[derive(Clone, Copy, Debug, Default)]
pub struct IslandState {
    /// Its number in the world.
    pub number: u32,
    /// Slot of a body that belongs to it, the first of all.
    pub first_body: u32,
    /// Levels it has.
    pub levels: u32,
    /// Manifolds it has.
    pub manifolds: u32,
    /// Those of them that are between round bodies.
    pub round_manifolds: u32,
    /// Σλ_n, N·s.
    pub load: f32,
    /// Energy that visits to its rows would take, J.
    pub unrest: f32,
}

impl IslandState {
    /// Whether nearly all of its manifolds are between round bodies: those of a mixed heap would fill too few lanes of
    /// blocks of their own.
    pub fn is_round(&self) -> bool {
        4 * self.round_manifolds >= 3 * self.manifolds
    }

    /// Whether its unrest is below a part of Σλ g h.
    pub fn is_below(&self, part: f32, g: f32, h: f32) -> bool {
        self.unrest <= part * self.load * g * h
    }
}

/// What solving a batch leaves beside motion and impulses.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Multiply-adds.
    pub work: u64,
    /// Greatest change of an impulse that a visit would make after the last sweep before the last motion, N·s.
    pub residual: f32,
    /// First bodies of islands that corrections did not help, and for how many steps these rest.
    pub pauses: Vec<(u32, u64)>,
}

/// Islands that are solved together.
#[derive(Clone, Debug, Default)]
pub struct Batch {
    /// Bodies, and the ground before them; their index is that of their records.
    pub movers: Movers,
    /// u'.
    pub velocities: Vec<Record>,
    /// J'ᵀλ of the last substep: the warm start of the next, without a pass over the rows.
    pub carried: Vec<Record>,
    /// Ways, weighted as u', since the start of the step.
    pub displacements: Vec<Record>,
    /// Rows of the reference that its manifolds would be.
    pub rows: u32,
    /// Substeps it takes: one where all bodies rest.
    pub substeps: u32,
    /// Its parts, and last the seam between them.
    pub domains: Vec<Domain>,
    /// Manifolds that it will have, about.
    pub divisible: u32,
    /// Joints that it will have.
    pub joint_count: u32,
    /// Manifolds in the order of contacts.
    pub places: Vec<Place>,
    /// Indices of these, domain by domain.
    pub manifolds: Vec<u32>,
    /// Blocks, domain by domain, and there color by color.
    pub blocks: Vec<ContactBlock>,
    /// Tangent rows of those whose bodies are not all round, domain by domain.
    pub tangents: Vec<TangentLanes>,
    /// Of each block where masses are amplified; else one for all.
    pub scales: Vec<ScaleLanes>,
    /// Joints.
    pub joints: Joints,
    /// Nothing touches its joints: nets, and trees that fly.
    pub is_clear: bool,
    /// Islands.
    pub islands: Vec<IslandState>,
    /// Of each block and lane: energy that visits to its rows would take, J.
    pub unrest: Vec<Lane>,
    /// Of the last solve.
    pub outcome: Outcome,
    /// I^−½: xx, xy, xz, 0, yy, yz, zz, 0.
    pub roots: Vec<Record>,
    /// I^½ as it was before bodies turned, marked where it is another one now; nothing without joints.
    pub old_roots: Vec<Record>,
    pub(super) used_colors: Vec<u64>,
    pub(super) sums: Vec<Sums>,
    /// Parts that its joints are visited in: `domain.rs`.
    pub(super) cells: u8,
    /// Of each block of bodies: its part, whether that is a cell, a domain or both.
    pub(super) part_of_block: Vec<u8>,
    pub(super) ranks_of_bodies: Vec<u32>,
    /// The edition of links of which branches its bodies are cut along.
    pub(super) cut_along: Option<u64>,
    pub(super) centers: Vec<(Vec3, u32)>,
    pub(super) domain_of_body: Vec<u8>,
}

/// What lanes are filled from.
#[derive(Clone, Copy)]
pub(crate) struct Source<'a> {
    /// All contacts.
    pub contacts: &'a [Contact],
    /// All joints.
    pub joints: &'a Arena<JointState>,
    /// All bodies.
    pub bodies: &'a Arena<BodyState>,
    /// Of the world.
    pub options: &'a WorldOptions,
    /// s.
    pub dt: f32,
    /// From stored impulses to the first λ.
    pub warm_scale: f32,
}

impl Place {
    /// A manifold before it has a color.
    pub fn new(contact: u32, manifold: u32, bodies: [u32; 2], island: u32, size: Size) -> Self {
        Self { contact, manifold, bodies, island, domain: 0, size, is_round: false, lane: 0 }
    }

    /// Its block.
    pub fn block(&self) -> usize {
        self.lane as usize / LANES
    }

    /// Its lane there.
    pub fn lane(&self) -> usize {
        self.lane as usize % LANES
    }
}

impl Batch {
    /// Forgets all.
    pub fn clear(&mut self) {
        self.movers.clear();
        self.places.clear();
        self.islands.clear();
        (self.divisible, self.joint_count) = (0, 0);
    }

    /// Bodies, colors, blocks, rows. A line of its own in profiles, as are others with this mark.
    #[inline(never)]
    pub(crate) fn build(&mut self, machine: Machine<'_>, source: &Source<'_>) {
        let full = source.options.solver.substeps;
        self.substeps = if self.rests(source) { 1 } else { full };
        let source = &Source { warm_scale: source.warm_scale * full as f32 / self.substeps as f32, ..*source };
        let h = source.dt / self.substeps as f32;
        self.joints.arrange(self.movers.records(), usize::from(self.cells), source.bodies, &mut self.domains);
        self.make_records();
        self.each(machine, |part| part.take_bodies(machine.level, source, h));
        self.fill_joints(machine, source, h);
        self.color();
        let solver = &source.options.solver;
        self.scales.clear();
        let own_scales = if solver.weight_amplification.enabled { self.blocks.len() } else { 0 };
        self.scales.resize(own_scales.max(1), ScaleLanes::ONE);
        self.rows = self.each(machine, |part| part.fill(source)).into_iter().flatten().sum();
        self.rows += self.seam().map_or(0, |mut seam| seam.fill(source));
        if solver.weight_amplification.enabled {
            self.amplify(source);
        } else if solver.wide.seed && solver.warm_start.enabled && self.joints.is_empty() {
            self.seed(source, h);
        }
        self.each_and_seam(machine, |part| part.prepare(machine.level));
    }

    /// Whether all bodies rest. What hangs in the air for a moment, at the top of its flight say, or begins to slide does
    /// not.
    fn rests(&self, source: &Source<'_>) -> bool {
        let rest = &source.options.rest.aggressive_sleep;
        let speed = CALM_SPEED * rest.linear_speed * source.options.length_scale.sqrt();
        let rests = |(_, slot): (u32, u32)| {
            let body = source.bodies.at(slot);
            body.rest_steps >= rest.steps && body.height != NO_HEIGHT && body.velocity.length_squared() <= speed * speed
        };
        rest.enabled && self.joints.is_empty() && self.movers.bodies().all(rests)
    }

    /// Lanes of all joints.
    fn fill_joints(&mut self, machine: Machine<'_>, source: &Source<'_>, h: f32) {
        if self.joints.is_empty() {
            return;
        }
        if self.joints.are_filled() {
            return self.each_and_seam(machine, |part| part.renew_joints(source.warm_scale));
        }
        let fill = |part: &mut Part<'_>| part.fill_joints(source, h);
        let of_cells = self.each(machine, fill);
        let of_seam = self.seam().map(|mut seam| fill(&mut seam));
        for filled in of_cells.into_iter().flatten().chain(of_seam) {
            self.joints.rows += filled.rows;
            self.joints.work += filled.work;
        }
    }

    /// Room for what is written when bodies are taken, or a substep begins.
    fn make_records(&mut self) {
        for records in [&mut self.velocities, &mut self.carried, &mut self.displacements, &mut self.roots] {
            records.resize(self.movers.records(), Record::default());
        }
        let jointed = if self.joints.is_empty() { 0 } else { self.movers.records() };
        self.old_roots.resize(jointed, Record::default());
    }

    fn amplify(&mut self, source: &Source<'_>) {
        let options = &source.options.solver.weight_amplification;
        let height = |slot: u32| source.bodies.at(slot).height;
        for place in &self.places {
            let contact = &source.contacts[place.contact as usize];
            let scale = weight_amplification::scale(options, height(contact.body_a), height(contact.body_b));
            let (lanes, lane) = (&mut self.scales[place.block()], place.lane());
            (lanes.mass[0][lane], lanes.mass[1][lane]) = (scale.mass_a, scale.mass_b);
            (lanes.inertia[0][lane], lanes.inertia[1][lane]) = (scale.inertia_a, scale.inertia_b);
        }
    }
}

impl Part<'_> {
    /// States of the bodies, as they are in the world, and their inertias.
    fn take_bodies(&mut self, level: Level, source: &Source<'_>, h: f32) {
        self.carried.fill(Record::default());
        self.displacements.fill(Record::default());
        for (block, slots) in self.movers.iter_mut().zip(self.slots.chunks(LANES)) {
            block.begin(slots);
        }
        let first = self.domain().records.start;
        for (index, &slot) in self.slots.iter().enumerate().filter(|&(_, &slot)| slot != NOBODY) {
            let is_jointed = self.joints.has((first + index) as u32);
            let body = source.bodies.at(slot);
            self.movers[index / LANES].fill(index % LANES, body, source.options.gravity, h, is_jointed);
        }
        let (movers, roots) = (&mut *self.movers, &mut *self.roots);
        dispatch!(level, simd => moving::weigh_all(simd, movers, roots));
    }

    /// Lanes of all manifolds; how many rows the reference would have for them.
    fn fill(&mut self, source: &Source<'_>) -> u32 {
        let solver = &source.options.solver;
        let first_block = self.domain().blocks.start;
        let mut rows = 0;
        for &name in self.manifolds {
            let place = self.places[name as usize];
            let contact = &source.contacts[place.contact as usize];
            let manifold = &contact.manifolds[place.manifold as usize];
            let (block, lane) = (place.block() - first_block, place.lane());
            let friction = if solver.friction == FrictionModel::Off { 0.0 } else { contact.friction };
            rows += manifold.points.len() as u32 * if friction > 0.0 { 3 } else { 1 };
            self.fill_manifold(block, lane, friction, manifold, source.warm_scale);
            let bears = solver.warm_start.enabled && !place.bodies.iter().any(|&b| self.joints.has(b));
            self.blocks[block].set_bears(lane, bears);
            self.fill_bodies(block, lane, place.bodies);
        }
        rows
    }

    fn fill_manifold(&mut self, block: usize, lane: usize, friction: f32, manifold: &Manifold, warm_scale: f32) {
        let block = &mut self.blocks[block];
        block.friction[lane] = friction;
        set(&mut block.normal, lane, manifold.normal);
        let friction_scale = if friction > 0.0 { warm_scale } else { 0.0 };
        for i in 0..block.size.points() {
            let (p, disk) = (&mut block.points[i], &mut block.disks[i]);
            let (exists, point) = manifold.points.get(i).map_or((0.0, &NO_POINT), |point| (1.0, point));
            p.effective_mass[lane] = exists;
            set(&mut p.angular_a, lane, point.arm_a);
            set(&mut p.angular_b, lane, point.arm_b);
            p.separation[lane] = point.separation;
            p.lambda[lane] = point.lambda_normal * warm_scale;
            for (lanes, value) in disk.lambda.iter_mut().zip(point.lambda_friction) {
                lanes[lane] = value * friction_scale;
            }
        }
    }

    fn fill_bodies(&mut self, block: usize, lane: usize, bodies: [u32; 2]) {
        let bodies = bodies.map(|body| self.local(body));
        let rows = &mut self.blocks[block];
        (rows.body_a[lane], rows.body_b[lane]) = (bodies[0], bodies[1]);
        for (side, &body) in bodies.iter().enumerate() {
            rows.inverse_mass[side][lane] = self.movers[body as usize / LANES].inverse_mass[body as usize % LANES];
        }
    }
}
