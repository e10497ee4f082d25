//! Stages `build_rows` and `plan_sweep`: from contacts and joints to a table of rows, its masses and its order.
//!
//! The plan is what a solver works on; it knows slots, not handles, and holds plain arrays that are used again
//! in each step. Rows of joints come first, then those of contacts, both in the world's fixed order.

use crate::collision::link::Link;
use crate::collision::manifold::SurfaceExtras;
use crate::constraint::contact::{self, Layout, Surface};
use crate::constraint::frame::{BodyFrame, JointStep};
use crate::constraint::friction::Coupling;
use crate::constraint::row::RowSpec;
use crate::math::Mat3;
use crate::options::{Permutation, SolverOptions};
use crate::solver::block::{self, Block};
use crate::solver::hand_down::HandDown;
use crate::solver::joint_recovery::{choose_recovery, is_recovered};
use crate::solver::joint_tree::Forest;
use crate::solver::level_correction::LevelCorrection;
use crate::solver::manifold_block::{self, ManifoldBlock};
use crate::solver::reference::Unit;
use crate::solver::table::{MassScale, Row, SolverBody};
use crate::solver::wide::Wide;
use crate::solver::{over_relaxation, shock_propagation, weight_amplification, work};
use crate::union_find::{root, unite};
use crate::world::World;

/// All that the solve stage works on.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    /// The ground, then every body that moves in this step.
    pub bodies: Vec<SolverBody>,
    /// The slot of each moving body; `bodies[i + 1]` is `movers[i]`.
    pub movers: Vec<u32>,
    /// From slots to `bodies`; 0 for whatever does not move.
    pub index_of: Vec<u32>,
    /// Of each slot: an active body with joints.
    pub is_jointed: Vec<bool>,
    joint_parents: Vec<u32>,
    /// Substeps of a step.
    pub substeps: u32,
    /// Sweeps with recovery in each.
    pub sweeps: u32,
    /// Visits to the equality rows of joints alone after them, back and forth.
    pub joint_passes: u32,
    /// Some bodies with joints are in contact.
    pub joints_touch: bool,
    /// ω of joints in the sweeps after the motion.
    pub over_relaxation: f32,
    /// Relax sweeps in each.
    pub relax_sweeps: u32,
    /// Impulses are stored for a substep of the options: this many times those of a substep here.
    pub share: f32,
    /// The table.
    pub rows: Vec<Row>,
    /// What a sweep visits as one, in the order of visiting.
    pub units: Vec<Unit>,
    /// Equality rows of joints that are solved together.
    pub blocks: Vec<Block>,
    /// Joints that are solved at once.
    pub forest: Forest,
    /// All joints are solved at once with those that they hang together with: none touches something or is in a net.
    pub joints_are_exact: bool,
    /// Manifolds whose rows are visited as one.
    pub manifold_blocks: Vec<ManifoldBlock>,
    /// Where the rows of each manifold are.
    pub manifolds: Vec<ManifoldRows>,
    /// Where the rows of each joint are.
    pub joints: Vec<JointRows>,
    /// Poses and velocities of jointed bodies, by body.
    pub frames: Vec<BodyFrame>,
    /// What joints ask for in this substep.
    pub specs: Vec<RowSpec>,
    /// Manifolds of islands whose impulses are found: one sweep with recovery is enough for them.
    pub calm: Vec<bool>,
    /// Multiply-adds of a sweep over all units.
    pub sweep_work: u64,
    /// Multiply-adds of M⁻¹Jᵀ of joints.
    pub joint_row_work: u64,
    /// Multiply-adds of factors of joints alone.
    pub block_work: u64,
    /// Multiply-adds of factors of trees.
    pub tree_work: u64,
    /// Multiply-adds of a warm start.
    pub push_work: u64,
    /// Multiply-adds of a sweep over the equality rows of joints.
    pub hard_work: u64,
    /// Multiply-adds of a sweep over what joint recovery visits.
    pub recovery_work: u64,
    /// Impulses of joints while these recover.
    pub lambdas: Vec<f32>,
    /// Islands of a batch that these rows are for, and those chosen for correction.
    pub(crate) rows_of: Vec<bool>,
    pub(crate) chosen: Vec<bool>,
    /// Islands that are solved wide.
    pub wide: Wide,
    /// Arrays of hand-down.
    pub hand_down: HandDown,
    /// Arrays of level correction.
    pub level_correction: LevelCorrection,
}

/// Rows of one manifold.
#[derive(Clone, Copy, Debug)]
pub struct ManifoldRows {
    /// Index of the contact.
    pub contact: u32,
    /// Which of its manifolds.
    pub manifold: u32,
    /// Index of its first row.
    pub first: u32,
    /// How many rows of each kind follow.
    pub layout: Layout,
    /// Material of the pair.
    pub surface: Surface,
    /// Newton's e of the pair.
    pub restitution: f32,
}

/// Rows of one joint.
#[derive(Clone, Copy, Debug)]
pub struct JointRows {
    /// Slot of the joint.
    pub joint: u32,
    /// Index of its first row.
    pub first: u32,
    /// How many rows it has.
    pub count: u32,
}

/// What there is of joints in the reference.
struct Jointed {
    any: bool,
    /// They close loops, over the ground or not.
    loops: bool,
    /// All of them are ball joints.
    all_balls: bool,
}

impl World {
    /// Stage `build_rows`.
    pub(crate) fn build_rows(&mut self, plan: &mut Plan, dt: f32) {
        self.build_batches(&mut plan.wide, dt);
        self.count_substeps(plan);
        self.collect_bodies(plan);
        plan.rows.clear();
        plan.joints.clear();
        plan.blocks.clear();
        plan.manifolds.clear();
        if !plan.wide.takes_all {
            self.add_joint_rows(plan, dt);
            self.add_contact_rows(plan, dt);
        }
    }

    /// What the reference does in a step: more where jointed bodies touch something or hang in loops, less where they
    /// do neither.
    fn count_substeps(&self, plan: &mut Plan) {
        let solver = &self.options.solver;
        let found = self.find_jointed(plan);
        let touches = |link: &Link| link.meets() && link.bodies.iter().any(|&b| plan.is_jointed[b as usize]);
        let touches = found.any && self.scratch.links.iter().any(touches);
        (plan.substeps, plan.sweeps, plan.relax_sweeps) = (solver.substeps, solver.sweeps, solver.relax_sweeps);
        plan.joints_touch = touches;
        (plan.joint_passes, plan.over_relaxation) = (0, over_relaxation::factor(&solver.over_relaxation, touches));
        match (touches, found.loops) {
            _ if !found.any => {}
            (true, _) if found.all_balls => {
                plan.sweeps *= solver.jointed.sweeps;
                plan.joint_passes = solver.jointed.passes;
            }
            (false, true) if found.all_balls => {}
            (true, _) | (false, true) => plan.substeps *= solver.jointed.substeps,
            (false, false) => plan.substeps = (solver.substeps / solver.jointed.free_divisor).max(1),
        }
        plan.share = plan.substeps as f32 / solver.substeps as f32;
    }

    /// Marks active bodies with joints, and looks at these.
    fn find_jointed(&self, plan: &mut Plan) -> Jointed {
        let mut found = Jointed { any: false, loops: false, all_balls: true };
        if plan.wide.takes_all {
            return found;
        }
        let slots = self.bodies.slot_count();
        plan.is_jointed.clear();
        plan.is_jointed.resize(slots, false);
        plan.joint_parents.clear();
        // Whatever does not move is one: the number after the last slot.
        plan.joint_parents.extend(0..=slots as u32);
        for link in &self.scratch.joint_links.list {
            let ends = link.bodies;
            let is_active = ends.map(|slot| self.scratch.roles[slot as usize].active);
            if is_active == [false, false] || ends.iter().any(|&slot| plan.wide.takes(slot)) {
                continue;
            }
            found.any = true;
            found.all_balls &= link.fits;
            let mut roots = [slots as u32; 2];
            for ((root_of, slot), active) in roots.iter_mut().zip(ends).zip(is_active) {
                plan.is_jointed[slot as usize] |= active;
                if active {
                    *root_of = slot;
                }
                *root_of = root(&mut plan.joint_parents, *root_of);
            }
            found.loops |= roots[0] == roots[1];
            unite(&mut plan.joint_parents, roots[0], roots[1]);
        }
        found
    }

    fn collect_bodies(&mut self, plan: &mut Plan) {
        plan.bodies.clear();
        plan.bodies.push(SolverBody::GROUND);
        plan.movers.clear();
        plan.index_of.clear();
        plan.index_of.resize(self.bodies.slot_count(), 0);
        for (slot, role) in (0..).zip(&self.scratch.roles) {
            let dynamic = role.active;
            if !(dynamic || role.moving_ground) || plan.wide.takes(slot) {
                continue;
            }
            let body = self.bodies.at(slot);
            plan.index_of[slot as usize] = plan.bodies.len() as u32;
            plan.movers.push(slot);
            plan.bodies.push(SolverBody {
                velocity: body.velocity,
                angular_velocity: body.angular_velocity,
                inverse_mass: body.inverse_mass_by_axis(),
                inverse_inertia: if dynamic { body.inverse_inertia_world() } else { Mat3::ZERO },
                height: body.height,
                ..SolverBody::GROUND
            });
        }
    }

    fn add_joint_rows(&mut self, plan: &mut Plan, dt: f32) {
        let scale = self.warm_start_scale(dt) / plan.share;
        let step = self.joint_step(dt / plan.substeps as f32);
        let links = &self.scratch.joint_links.list;
        for place in 0..links.len() {
            let link = &links[plan.wide.joint_order.get(place).map_or(place, |&index| index as usize)];
            let [a, b] = link.bodies.map(|slot| self.scratch.roles[slot as usize]);
            let is_wide = link.bodies.iter().any(|&slot| plan.wide.takes(slot));
            if is_wide || !(a.active || b.active) || a.broken || b.broken {
                continue;
            }
            let (slot, joint) = (link.joint, self.joints.at_mut(link.joint));
            let [body_a, body_b] = link.bodies.map(|slot| plan.index_of[slot as usize]);
            let [a, b] = link.bodies.map(|slot| self.bodies.at(slot));
            plan.specs.clear();
            joint.resolved.rows(&joint.definition.kind, &a.frame(), &b.frame(), &step, &mut plan.specs);
            for body in [body_a, body_b] {
                let body = &mut plan.bodies[body as usize];
                body.shares_joints = body.jointed && body.moves();
                body.jointed = true;
            }
            let first = plan.rows.len() as u32;
            plan.joints.push(JointRows { joint: slot, first, count: plan.specs.len() as u32 });
            let rows = plan.specs.iter().zip(&joint.lambdas);
            plan.rows.extend(rows.map(|(spec, &lambda)| Row::of_joint(spec, body_a, body_b, lambda * scale)));
            block::gather(first as usize, &mut plan.rows, &mut plan.blocks);
        }
    }

    fn add_contact_rows(&self, plan: &mut Plan, dt: f32) {
        let scale = self.warm_start_scale(dt) / plan.share;
        let model = self.options.solver.friction;
        for (index, link) in self.scratch.links.iter().enumerate() {
            let [body_a, body_b] = link.bodies.map(|slot| plan.index_of[slot as usize]);
            let is_active = |&slot: &u32| self.scratch.roles[slot as usize].active;
            if !link.meets() || link.batch != Link::NONE || !link.bodies.iter().any(is_active) {
                continue;
            }
            let contact = &self.contacts[index];
            let SurfaceExtras { restitution, torsional_friction, rolling_friction, surface_velocity } =
                contact.extras();
            let surface =
                Surface { friction: contact.friction, torsional_friction, rolling_friction, surface_velocity };
            for (m, manifold) in contact.manifolds.iter().enumerate() {
                for body in [body_a, body_b] {
                    let body = &mut plan.bodies[body as usize];
                    // What does not move passes nothing on to others that touch it or hang from it.
                    body.touched = body.moves();
                }
                let first = plan.rows.len() as u32;
                plan.manifolds.push(ManifoldRows {
                    contact: index as u32,
                    manifold: m as u32,
                    first,
                    layout: Layout::new(manifold.points.len(), &surface, model),
                    surface,
                    restitution,
                });
                contact::rows(manifold, &surface, model, first, |spec| {
                    let mut row = Row::of_contact(&spec, body_a, body_b);
                    row.lambda *= scale;
                    plan.rows.push(row);
                });
            }
        }
    }

    /// Impulses are forces times the substep of the options: they scale when it changes.
    pub(crate) fn warm_start_scale(&self, dt: f32) -> f32 {
        let h = dt / self.options.solver.substeps as f32;
        let change = if self.last_substep > 0.0 { h / self.last_substep } else { 0.0 };
        let options = &self.options.solver.warm_start;
        if options.enabled { change * options.factor } else { 0.0 }
    }

    /// What rows of joints are told of a substep of `h` seconds.
    pub(crate) fn joint_step(&self, h: f32) -> JointStep {
        let recovery = &self.options.solver.joint_recovery;
        JointStep { h, recovery_rate: if recovery.enabled { recovery.rate } else { 0.0 } }
    }

    /// The same after the motion, for the recovery by poses.
    pub(crate) fn pose_step(&self, plan: &Plan, h: f32) -> JointStep {
        let step = self.joint_step(h);
        if plan.joints_touch {
            step
        } else {
            JointStep { recovery_rate: self.options.solver.joint_recovery.net_rate, ..step }
        }
    }
}

/// Those with the same key stay as they were. Once in a program, whatever the key.
#[inline(never)]
pub(crate) fn sort_units(units: &mut [Unit], key: &dyn Fn(&Unit) -> u32) {
    units.sort_by_key(key);
}

/// Stage `plan_sweep`: the scale of the masses and the first order of the units.
pub fn plan_sweep(plan: &mut Plan, options: &SolverOptions) {
    plan.units.clear();
    let blocks = manifold_block::passes(&options.manifold_block).is_some();
    let first_contact = plan.manifolds.first().map_or(plan.rows.len(), |m| m.first as usize);
    let single = if blocks { first_contact } else { plan.rows.len() };
    if options.joint_tree.enabled {
        plan.forest.find(&plan.rows, &mut plan.blocks, &mut plan.bodies);
    } else {
        plan.forest = Forest::default();
    }
    choose_recovery(plan, options.joint_tree.enabled);
    plan.manifold_blocks.clear();
    if blocks {
        plan.manifold_blocks.extend(plan.manifolds.iter().map(ManifoldBlock::new));
        let first = plan.units.len();
        plan.units.extend((0..plan.manifold_blocks.len() as u32).map(Unit::Manifold));
        if !plan.wide.order.is_empty() {
            let place = |unit: &Unit| {
                let Unit::Manifold(index) = *unit else { return u32::MAX };
                let m = &plan.manifolds[index as usize];
                let order = &plan.wide.order;
                let found = order.binary_search_by_key(&(m.contact, m.manifold), |&(c, k, _)| (c, k));
                found.map_or(u32::MAX, |at| order[at].2)
            };
            sort_units(&mut plan.units[first..], &place);
        }
    }
    for (i, row) in plan.rows[..single].iter().enumerate() {
        let alone = match row.coupling {
            Coupling::Partner => false,
            Coupling::Block(block) => !plan.blocks[block as usize].in_tree,
            _ => true,
        };
        if alone {
            plan.units.push(Unit::Row(i as u32));
        }
    }
    // The last sweep before bodies move ends with the trees: what is between joints then has no gap to grow.
    let trees = plan.forest.trees.iter().enumerate().filter(|(_, t)| !t.is_idle);
    plan.units.extend(trees.map(|(index, _)| Unit::Tree(index as u32)));
    if plan.joints_are_exact {
        // The end of a range sees what forces did to its body only once the joint has passed it on; it is solved with
        // the joint, so nothing is left between joints after it.
        let rows = &plan.rows;
        let is_limit = |unit: &Unit| {
            u32::from(matches!(*unit, Unit::Row(row) if matches!(rows[row as usize].coupling, Coupling::Limit(_))))
        };
        sort_units(&mut plan.units, &is_limit);
    }
    if options.permutation == Permutation::Alternating && plan.sweeps.is_multiple_of(2) {
        plan.units.reverse();
    }
    plan.calm.clear();
    count_work(plan, options);
    let shock = &options.shock_propagation;
    let pure_shock = shock.enabled && shock.blend >= 1.0;
    if pure_shock {
        scale_contacts(plan, shock_propagation::scale);
        shock_propagation::sort_upward(plan);
    } else if options.weight_amplification.enabled {
        let wa = &options.weight_amplification;
        scale_contacts(plan, |a, b| weight_amplification::scale(wa, a, b));
    }
}

fn count_work(plan: &mut Plan, options: &SolverOptions) {
    let passes = u64::from(options.manifold_block.passes);
    plan.sweep_work = plan.units.iter().map(|&unit| unit_work(plan, unit, passes)).sum();
    let recovered = plan.units.iter().filter(|&&unit| is_recovered(unit, plan));
    plan.recovery_work = recovered.map(|&unit| unit_work(plan, unit, passes)).sum();
    let hard = plan.units.iter().filter(|&&unit| plan.is_hard(unit));
    plan.hard_work = hard.map(|&unit| unit_work(plan, unit, passes)).sum();
    let (mut rows, mut in_blocks) = (0, 0);
    (plan.push_work, plan.block_work) = (0, 0);
    for block in &plan.blocks {
        let size = block.size();
        (rows, in_blocks) = (rows + size.responses(), in_blocks + size.rows);
        plan.push_work += size.push();
        plan.block_work += if block.in_tree { 0 } else { size.factor() };
    }
    let alone = |all: usize| all as u64 - in_blocks;
    plan.push_work += alone(plan.rows.len()) * work::APPLY;
    plan.joint_row_work = rows + alone(plan.joint_rows()) * (work::RESPONSE + work::INNER);
    let trees = plan.forest.trees.iter().filter(|t| !t.is_idle).map(|t| t.assembly_work(&plan.blocks));
    plan.tree_work = trees.sum();
}

/// Multiply-adds of a visit.
fn unit_work(plan: &Plan, unit: Unit, passes: u64) -> u64 {
    match unit {
        Unit::Row(row) => row_work(plan, row),
        Unit::Manifold(index) => plan.manifold_work(index, passes),
        Unit::Tree(index) => plan.forest.trees[index as usize].visit_work(&plan.blocks),
    }
}

fn row_work(plan: &Plan, row: u32) -> u64 {
    match plan.rows[row as usize].coupling {
        Coupling::None | Coupling::Interval(_) => work::VISIT,
        // Where a limit bears, its joint is solved with it.
        Coupling::Limit(_) if plan.rows[row as usize].lambda == 0.0 => work::VISIT,
        Coupling::Limit(block) => {
            let block = &plan.blocks[block as usize];
            work::VISIT
                + match plan.forest.trees.get(block.tree as usize) {
                    Some(tree) if block.in_tree => tree.visit_work(&plan.blocks),
                    _ => block.size().visit_alone(),
                }
        }
        Coupling::Disk(_) => work::DISK,
        Coupling::Block(block) => plan.blocks[block as usize].size().visit_alone(),
        Coupling::Partner => 0,
    }
}

impl Plan {
    /// Whether a unit is equality rows of joints.
    pub fn is_hard(&self, unit: Unit) -> bool {
        match unit {
            Unit::Row(row) => matches!(self.rows[row as usize].coupling, Coupling::Block(_)),
            Unit::Manifold(_) => false,
            Unit::Tree(_) => true,
        }
    }

    /// Rows of joints: they come first.
    pub fn joint_rows(&self) -> usize {
        self.joints.last().map_or(0, |j| (j.first + j.count) as usize)
    }

    /// Multiply-adds of a visit to a manifold block.
    pub fn manifold_work(&self, index: u32, passes: u64) -> u64 {
        let m = &self.manifold_blocks[index as usize];
        let friction: u64 = (m.first..m.first_normal).map(|row| row_work(self, row)).sum();
        friction + work::normals(u64::from(m.end - m.first_normal), passes)
    }
}

/// Sets the mass scale of every contact row from the heights of its two bodies.
pub fn scale_contacts(plan: &mut Plan, scale: impl Fn(u32, u32) -> MassScale) {
    for m in &plan.manifolds {
        let (first, last) = (m.first as usize, (m.first + m.layout.total()) as usize);
        for row in &mut plan.rows[first..last] {
            let (a, b) = (plan.bodies[row.body_a as usize].height, plan.bodies[row.body_b as usize].height);
            row.scale = scale(a, b);
        }
    }
}
