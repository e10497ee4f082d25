//! Islands that are solved together while they are in the cache: bodies, blocks of manifolds, and their colors.
//!
//! Manifolds get the lowest color that none of their bodies has yet, in the order of contacts; eight of a color make
//! a block, if they are of about as many points. Colors depend on islands and contacts alone, never on lanes or threads.

use crate::body::{BodyState, NO_HEIGHT};
use crate::collision::feature_id::{Feature, FeatureId};
use crate::collision::manifold::{Contact, ContactPoint, Manifold};
use crate::handle::Arena;
use crate::math::Vec3;
use crate::options::{FrictionModel, SolverOptions, WorldOptions};
use crate::solver::penetration_recovery::Recovery;
use crate::solver::wide::contact_block::{ContactBlock, ScaleLanes, Size, prepare};
use crate::solver::wide::joints::Joints;
use crate::solver::wide::lanes::{LANES, Lane, Record, set};
use crate::solver::wide::mover::Movers;
use crate::solver::wide::moving;
use crate::solver::{slop, weight_amplification};
use crate::world::JointState;
use fearless_simd::{Level, dispatch};

/// Colors that are told apart; what finds none of them free gets a block of its own.
const COLORS: usize = 64;

/// A body that moves no faster than this part of what aggressive sleep calls rest is not about to go.
const CALM_SPEED: f32 = 0.2;

/// What fills the lanes of a block beyond the points of a manifold.
const NO_POINT: ContactPoint = ContactPoint {
    arm_a: Vec3::ZERO,
    arm_b: Vec3::ZERO,
    separation: 0.0,
    id: FeatureId::new(Feature::unknown(0), Feature::unknown(0)),
    lambda_normal: 0.0,
    lambda_friction: Vec3::ZERO,
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
    color: u32,
    /// Points of its block, at most.
    pub size: Size,
    /// Block.
    pub block: u32,
    /// Lane of the block.
    pub lane: u32,
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
    /// Σλ_n, N·s.
    pub load: f32,
    /// Energy that visits to its rows would take, J.
    pub unrest: f32,
}

impl IslandState {
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
    /// Bodies; their index here is one less than in the arrays of records, where 0 is the ground.
    pub movers: Movers,
    /// u' of the ground and of all movers.
    pub velocities: Vec<Record>,
    /// u' before the sweeps.
    pub before: Vec<Record>,
    /// J'ᵀλ of the last substep: the warm start of the next, without a pass over the rows.
    pub carried: Vec<Record>,
    /// Mass-weighted ways since the start of the step.
    pub displacements: Vec<Record>,
    /// Rows of the reference that its manifolds would be.
    pub rows: u32,
    /// Substeps it takes: one where all bodies rest.
    pub substeps: u32,
    /// Manifolds in the order of contacts.
    pub places: Vec<Place>,
    /// Blocks, color by color.
    pub blocks: Vec<ContactBlock>,
    /// Of each block where masses are amplified; else one for all.
    pub scales: Vec<ScaleLanes>,
    /// Joints.
    pub joints: Joints,
    /// Nothing holds or hits its trees of joints: they need fewer sweeps.
    pub flies: bool,
    /// Islands.
    pub islands: Vec<IslandState>,
    /// Of each block and lane: energy that visits to its rows would take, J.
    pub unrest: Vec<Lane>,
    /// Of the last solve.
    pub outcome: Outcome,
    used_colors: Vec<u64>,
    /// By color and size: first how many manifolds, then the first block.
    counts_of: Vec<[u32; Size::ALL.len()]>,
    /// I^−½ of the ground and of all movers: xx, xy, xz, 0, yy, yz, zz, 0.
    pub roots: Vec<Record>,
    /// I^½ as it was before bodies turned.
    pub old_roots: Vec<Record>,
    counts: Vec<Lane>,
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
    pub fn new(contact: u32, manifold: u32, bodies: [u32; 2], island: u32) -> Self {
        Self { contact, manifold, bodies, island, color: 0, size: Size::Four, block: 0, lane: 0 }
    }
}

impl Batch {
    /// Forgets all.
    pub fn clear(&mut self) {
        self.movers.clear();
        self.places.clear();
        self.joints.clear();
        self.islands.clear();
    }

    /// Colors, blocks, rows.
    pub(crate) fn build(&mut self, level: Level, source: &Source<'_>) {
        let rest = &source.options.rest.aggressive_sleep;
        // What hangs in the air for a moment, at the top of its flight say, or begins to slide does not rest.
        let rests = |slot: u32| {
            let body = source.bodies.at(slot);
            let speed = CALM_SPEED * rest.linear_speed * source.options.length_scale.sqrt();
            body.rest_steps >= rest.steps && body.height != NO_HEIGHT && body.velocity.length_squared() <= speed * speed
        };
        let solver = &source.options.solver;
        let full = solver.substeps;
        let at_rest = rest.enabled && self.joints.is_empty() && self.movers.slots.iter().all(|&slot| rests(slot));
        self.substeps = if at_rest { 1 } else { full };
        let source = &Source { warm_scale: source.warm_scale * full as f32 / self.substeps as f32, ..*source };
        let h = source.dt / self.substeps as f32;
        self.movers.fill(source.bodies, source.options.gravity);
        self.joints.build(&self.movers, source.joints, h, source.warm_scale);
        let joints = &self.joints;
        self.movers.begin_step(h, |body| joints.has(body));
        for records in [
            &mut self.velocities,
            &mut self.before,
            &mut self.carried,
            &mut self.displacements,
            &mut self.roots,
            &mut self.old_roots,
        ] {
            records.clear();
            records.resize(self.movers.records(), Record::default());
        }
        let (blocks, roots) = (&mut self.movers.blocks, &mut self.roots);
        dispatch!(level, simd => moving::weigh_all(simd, blocks, roots));
        self.color(source.contacts);
        self.fill(source);
        let masses_are_true = !source.options.solver.weight_amplification.enabled;
        let seeds = source.options.solver.wide.seed && source.options.solver.warm_start.enabled;
        if seeds && masses_are_true && self.joints.is_empty() {
            self.seed(source, h);
        }
        dispatch!(level, simd => {
            for (k, block) in self.blocks.iter_mut().enumerate() {
                let scale = &self.scales[k.min(self.scales.len() - 1)];
                prepare(simd, block, scale, &self.roots, &self.counts[k]);
            }
        });
    }

    /// Colors of the manifolds; blocks for each color and size.
    fn color(&mut self, contacts: &[Contact]) {
        self.used_colors.clear();
        self.used_colors.resize(self.movers.records(), 0);
        self.counts_of.clear();
        self.counts_of.resize(COLORS, [0; Size::ALL.len()]);
        for place in &mut self.places {
            let taken = place.bodies.iter().filter(|&&b| b != 0).fold(0, |m, &b| m | self.used_colors[b as usize]);
            let color = taken.trailing_ones() as usize;
            if color < COLORS {
                for &body in place.bodies.iter().filter(|&&b| b != 0) {
                    self.used_colors[body as usize] |= 1 << color;
                }
                place.color = color as u32;
            } else {
                place.color = self.counts_of.len() as u32;
                self.counts_of.push([0; Size::ALL.len()]);
            }
            let manifold = &contacts[place.contact as usize].manifolds[place.manifold as usize];
            place.size = Size::of(manifold.points.len());
            let count = &mut self.counts_of[place.color as usize][place.size as usize];
            place.lane = *count;
            *count += 1;
        }
        self.make_blocks();
        for place in &mut self.places {
            let index = place.lane;
            place.block = self.counts_of[place.color as usize][place.size as usize] + index / LANES as u32;
            place.lane = index % LANES as u32;
        }
    }

    /// Blocks for what was counted. Full ones are written over as they are, lane by lane: only those with lanes that
    /// nothing fills are emptied.
    fn make_blocks(&mut self) {
        let mut first = 0;
        for of_color in &mut self.counts_of {
            for (count, size) in of_color.iter_mut().zip(Size::ALL) {
                let blocks = count.div_ceil(LANES as u32) as usize;
                if self.blocks.len() < first + blocks {
                    self.blocks.resize(first + blocks, ContactBlock::EMPTY);
                    self.counts.resize(first + blocks, [0.0; LANES]);
                }
                for block in &mut self.blocks[first..first + blocks] {
                    block.size = size;
                }
                if !count.is_multiple_of(LANES as u32) {
                    let last = first + blocks - 1;
                    self.blocks[last] = ContactBlock { size, ..ContactBlock::EMPTY };
                    self.counts[last] = [0.0; LANES];
                }
                *count = first as u32;
                first += blocks;
            }
        }
        self.blocks.truncate(first);
        self.counts.truncate(first);
    }

    fn fill(&mut self, source: &Source<'_>) {
        let solver = &source.options.solver;
        self.scales.clear();
        let own_scales = if solver.weight_amplification.enabled { self.blocks.len() } else { 0 };
        self.scales.resize(own_scales.max(1), ScaleLanes::ONE);
        self.rows = 0;
        let scale = source.options.length_scale;
        let recovery = Recovery::new(&solver.penetration_recovery, slop::depth(&solver.slop, scale), scale);
        for p in 0..self.places.len() {
            let place = self.places[p];
            let contact = &source.contacts[place.contact as usize];
            let manifold = &contact.manifolds[place.manifold as usize];
            let (block, lane) = (place.block as usize, place.lane as usize);
            let friction = if solver.friction == FrictionModel::Off { 0.0 } else { contact.friction };
            self.rows += manifold.points.len() as u32 * if friction > 0.0 { 3 } else { 1 };
            self.fill_manifold(block, lane, friction, manifold, source.warm_scale);
            let bears = solver.warm_start.enabled && !place.bodies.iter().any(|&b| self.joints.has(b));
            self.blocks[block].deadband[lane] = if bears { recovery.deadband } else { 0.0 };
            self.fill_bodies(block, lane, place.bodies);
            if solver.weight_amplification.enabled {
                self.amplify(block, lane, contact, source.bodies, solver);
            }
        }
    }

    fn fill_manifold(&mut self, block: usize, lane: usize, friction: f32, manifold: &Manifold, warm_scale: f32) {
        self.counts[block][lane] = manifold.points.len() as f32;
        let block = &mut self.blocks[block];
        block.friction[lane] = friction;
        set(&mut block.normal, lane, manifold.normal);
        let friction_scale = if friction > 0.0 { warm_scale } else { 0.0 };
        for i in 0..block.size.points() {
            let (p, disk) = (&mut block.points[i], &mut block.disks[i]);
            let point = manifold.points.get(i).unwrap_or(&NO_POINT);
            set(&mut p.angular_a, lane, point.arm_a);
            set(&mut p.angular_b, lane, point.arm_b);
            p.separation[lane] = point.separation;
            p.lambda[lane] = point.lambda_normal * warm_scale;
            set(&mut disk.angular_a[0], lane, point.lambda_friction * friction_scale);
        }
    }

    fn fill_bodies(&mut self, block: usize, lane: usize, bodies: [u32; 2]) {
        let rows = &mut self.blocks[block];
        (rows.body_a[lane], rows.body_b[lane]) = (bodies[0], bodies[1]);
        for (side, &body) in bodies.iter().enumerate() {
            let root = if side == 0 { &mut rows.root_a } else { &mut rows.root_b };
            root[lane] = self.movers.inverse_root_mass(body);
        }
    }

    fn amplify(
        &mut self,
        block: usize,
        lane: usize,
        contact: &Contact,
        bodies: &Arena<BodyState>,
        options: &SolverOptions,
    ) {
        let height = |slot: u32| bodies.at(slot).height;
        let scale =
            weight_amplification::scale(&options.weight_amplification, height(contact.body_a), height(contact.body_b));
        let lanes = &mut self.scales[block];
        (lanes.mass[0][lane], lanes.mass[1][lane]) = (scale.mass_a, scale.mass_b);
        (lanes.inertia[0][lane], lanes.inertia[1][lane]) = (scale.inertia_a, scale.inertia_b);
    }
}
