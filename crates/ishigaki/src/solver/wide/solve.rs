//! All substeps of a batch: forces, sweeps with recovery, motion, relax sweeps; then back into the world.
//!
//! The order of things is that of `substeps.rs`, and of `joint_recovery.rs` for joints. A batch in which all bodies rest (`rest.aggressive_sleep`) takes the
//! step as one substep: its impulses are known, and what is left of its motion is taken out once, not once a substep.

use crate::solver::hand_down::{self, HandDown};
use crate::solver::level_correction::{self, CALM, QUIET};
use crate::solver::manifold_block;
use crate::solver::penetration_recovery::Recovery;
use crate::solver::plan::Plan;
use crate::solver::slop;
use crate::solver::wide::Wide;
use crate::solver::wide::batch::{Batch, IslandState, Outcome};
use crate::solver::wide::contact_block::{self as kernel, Biases, SweepPass};
use crate::solver::wide::joint_block::JointPass;
use crate::solver::wide::lanes::{LANES, Lane, Record, splat, store};
use crate::solver::wide::moving::{self, Motion};
use crate::solver::work;
use crate::world::World;
use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch};
use std::sync::{Mutex, PoisonError};

impl World {
    /// Solves all batches, on several threads if the world has them.
    pub(crate) fn solve_batches(&self, wide: &mut Wide, dt: f32) {
        let (level, mut batches) = (wide.level, std::mem::take(&mut wide.batches));
        let aids = Mutex::new(std::mem::take(&mut wide.aids));
        let lock = || aids.lock().unwrap_or_else(PoisonError::into_inner);
        self.workers.for_each(&mut batches[..wide.used], |batch| {
            let mut aid = lock().pop().unwrap_or_default();
            self.solve_batch(level, batch, &mut aid, dt);
            lock().push(aid);
        });
        wide.aids = aids.into_inner().unwrap_or_else(PoisonError::into_inner);
        wide.batches = batches;
    }

    fn solve_batch(&self, level: Level, batch: &mut Batch, aid: &mut Plan, dt: f32) {
        batch.outcome = Outcome::default();
        let solver = &self.options.solver;
        let (substeps, relax_sweeps, solver_substeps) = (batch.substeps, solver.relax_sweeps, solver.substeps);
        // One substep has the sweeps of all.
        let of_joints = if batch.joints.is_empty() || batch.flies { 1 } else { solver.jointed.sweeps };
        let sweeps = solver.sweeps * of_joints * (solver.substeps / substeps).max(1);
        let h = dt / substeps as f32;
        let scale = self.options.length_scale;
        let pass = SweepPass {
            recovery: Recovery::new(&solver.penetration_recovery, slop::depth(&solver.slop, scale), scale),
            h,
            passes: manifold_block::passes(&solver.manifold_block).unwrap_or(1),
            warm: solver.warm_start.enabled,
        };
        let root = scale.sqrt();
        let motion = Motion {
            scheme: self.options.motion.rotation,
            max_speed: self.options.motion.max_speed * root,
            max_angular_speed: self.options.motion.max_angular_speed / root,
            h,
        };
        let mut order = Order::for_sweeps(sweeps);
        let work = batch.manifold_work(u64::from(pass.passes));
        batch.outcome.work += work.rows;
        let is_free = batch.blocks.is_empty() && batch.joints.is_empty();
        let looks = !is_free && (substeps < solver_substeps || self.has_stacks(batch));
        aid.manifolds.clear();
        batch.aim_joints(level, h);
        for substep in 0..substeps {
            let is_last = substep + 1 == substeps;
            let velocity = JointPass::velocity(h);
            batch.begin(level, h);
            let mut sweeps = sweeps;
            if !is_free {
                if substep == 0 || batch.pushes_anew() {
                    batch.warm_start(level);
                    batch.outcome.work += work.warm_start;
                }
                if looks {
                    batch.look(level, &pass);
                    batch.outcome.work += work.looks;
                    let is_quiet = self.correct_batch(batch, aid, &pass);
                    if is_quiet && substeps < solver_substeps {
                        // The impulses are found: one sweep keeps them so.
                        (sweeps, order) = (2, Order::for_sweeps(2));
                    }
                }
                for sweep in 0..sweeps {
                    order.before(sweep);
                    let biases = if sweep == 0 && !looks { Biases::Recover } else { Biases::Keep };
                    batch.sweep(level, &pass, &velocity, Visits { reversed: order.reversed, biases, add_up: false });
                }
                if is_last && self.options.report.residual {
                    batch.outcome.residual = batch.residual(level, &pass, &velocity);
                }
            }
            batch.advance(level, &motion);
            if !is_free {
                if !batch.joints.is_empty() {
                    batch.outcome.work += work.reweighing;
                    self.recover_batch_joints(level, batch, order.reversed, h);
                }
                let relax = if is_last { Biases::RelaxLast } else { Biases::Relax };
                for sweep in 0..relax_sweeps {
                    order.before(sweeps + sweep);
                    let biases = if sweep == 0 { relax } else { Biases::Keep };
                    let visits = Visits { reversed: order.reversed, biases, add_up: sweep + 1 == relax_sweeps };
                    batch.sweep(level, &pass, &JointPass::relax(h), visits);
                }
                if relax_sweeps == 0 {
                    batch.leave(level, &pass, relax);
                }
            }
            batch.end(level);
            if !pass.warm {
                batch.forget();
            }
            batch.outcome.work +=
                u64::from(sweeps + relax_sweeps) * (work.visit + batch.joints.work.sweep) + work.measures;
        }
        batch.see_joints(level);
        batch.outcome.work += std::mem::take(&mut aid.level_correction.work);
    }

    /// Whether there are loads that corrections may be for. Loads that hang on joints are not seen by them.
    fn has_stacks(&self, batch: &Batch) -> bool {
        let may_be = |island: &IslandState| island.levels > 1 && !self.pauses(batch, island);
        batch.joints.is_empty() && self.corrects_levels() && batch.islands.iter().any(may_be)
    }

    /// Whether corrections leave an island alone for now.
    fn pauses(&self, batch: &Batch, island: &IslandState) -> bool {
        island.first_body == u32::MAX
            || self.bodies.at(island.first_body).no_correction_until > self.step_count
            || batch.outcome.pauses.iter().any(|&(body, _)| body == island.first_body)
    }

    /// Corrects the loads of stacks that are not at rest; whether all of them are quiet.
    fn correct_batch(&self, batch: &mut Batch, aid: &mut Plan, pass: &SweepPass) -> bool {
        let g = self.options.gravity.length();
        let mut wanted = std::mem::take(&mut aid.chosen);
        wanted.clear();
        let mut all_quiet = true;
        for island in &batch.islands {
            all_quiet &= island.is_below(QUIET, g, pass.h);
            wanted.push(!island.is_below(CALM, g, pass.h) && island.levels > 1 && !self.pauses(batch, island));
        }
        if self.options.solver.hand_down.enabled && self.corrects_levels() {
            self.hand_down_dear(batch, &mut aid.hand_down, &mut wanted, pass);
        }
        if self.corrects_levels() && wanted.contains(&true) {
            self.correct_loads(batch, aid, &wanted, pass);
            batch.outcome.pauses.append(&mut aid.level_correction.pauses);
        }
        aid.chosen = wanted;
        all_quiet
    }

    /// Takes the islands out of `wanted` that are too dear for level correction, and hands their loads down.
    fn hand_down_dear(&self, batch: &mut Batch, work: &mut HandDown, wanted: &mut [bool], pass: &SweepPass) {
        let g = self.options.gravity.length();
        for (index, is_wanted) in wanted.iter_mut().enumerate() {
            let island = batch.islands[index];
            if !(*is_wanted && level_correction::is_dear(island.manifolds as usize, island.levels as usize)) {
                continue;
            }
            *is_wanted = false;
            if island.is_below(QUIET, g, pass.h) {
                continue;
            }
            let gain = self.hand_down(batch, work, index as u32);
            if !hand_down::is_worth_it(gain, island.unrest) {
                batch.outcome.pauses.push((island.first_body, hand_down::PAUSE));
            }
        }
    }

    /// Rows of joints for the poses after the motion, and the recovery of their errors.
    fn recover_batch_joints(&self, level: Level, batch: &mut Batch, reversed: bool, h: f32) {
        batch.weigh(level);
        batch.aim_joints(level, h);
        let recovery = &self.options.solver.joint_recovery;
        if recovery.enabled {
            let pass = JointPass::recovery(h, recovery.rate);
            batch.recover(level, &pass, reversed, h);
            batch.outcome.work += batch.joints.work.recovery;
        }
    }
}

/// Forwards and backwards in turn, as `permutation.rs` has it.
struct Order {
    reversed: bool,
}

impl Order {
    /// The last sweep before the motion is a forward one, whatever their number.
    fn for_sweeps(sweeps: u32) -> Self {
        Self { reversed: sweeps.is_multiple_of(2) }
    }

    fn before(&mut self, sweep: u32) {
        if sweep > 0 {
            self.reversed = !self.reversed;
        }
    }
}

/// What a sweep does beside its visits.
#[derive(Clone, Copy)]
struct Visits {
    reversed: bool,
    biases: Biases,
    /// λ is what the substep leaves.
    add_up: bool,
}

impl Batch {
    fn begin(&mut self, level: Level, h: f32) {
        let carried = (!self.pushes_anew()).then_some(&self.carried[..]);
        let (blocks, before, velocities) = (&mut self.movers.blocks, &mut self.before, &mut self.velocities);
        dispatch!(level, simd => moving::begin_all(simd, blocks, carried, before, velocities, h));
    }

    /// Takes the sweeps over, and moves.
    fn advance(&mut self, level: Level, motion: &Motion) {
        let blocks = &mut self.movers.blocks;
        let (carried, before) = (&mut self.carried, &mut self.before);
        let (velocities, ways) = (&mut self.velocities, &mut self.displacements);
        dispatch!(level, simd => moving::advance_all(simd, blocks, carried, before, velocities, ways, motion));
    }

    /// Rows of joints turn with their bodies: their impulses push along other ways than in the last substep.
    fn pushes_anew(&self) -> bool {
        !self.joints.is_empty()
    }

    /// Rows of joints for the poses as they are, and what arcs will add to their gaps in `h` seconds.
    fn aim_joints(&mut self, level: Level, h: f32) {
        if !self.joints.is_empty() {
            self.joints.aim(level, &self.movers, &self.roots, h);
            self.outcome.work += self.joints.work.rows;
        }
    }

    /// Inertias of bodies with joints, and rows of their contacts, for the rotations as they are: limbs turn far in a step.
    fn weigh(&mut self, level: Level) {
        let movers = &mut self.movers.blocks;
        let (roots, old, ways) = (&mut self.roots, &mut self.old_roots, &mut self.displacements);
        let (before, velocities) = (&mut self.before, &mut self.velocities);
        let (blocks, scales) = (&mut self.blocks[..], &self.scales[..]);
        dispatch!(level, simd => {
            moving::reweigh_all(simd, movers, roots, old, ways, before, velocities);
            reweigh_all(simd, blocks, scales, old, roots);
        });
    }

    /// Moves bodies as joints ask for.
    fn recover(&mut self, level: Level, pass: &JointPass, reversed: bool, h: f32) {
        let pushes = self.joints.recover(level, pass, reversed);
        let (blocks, ways) = (&mut self.movers.blocks, &mut self.displacements);
        let (before, velocities) = (&mut self.before, &mut self.velocities);
        dispatch!(level, simd => moving::shift_all(simd, blocks, pushes, ways, before, velocities, h));
    }

    /// Errors of joints at the end of the step.
    fn see_joints(&mut self, level: Level) {
        if !self.joints.is_empty() {
            self.joints.see(level, &self.movers);
        }
    }

    /// Takes the sweeps after the motion over.
    fn end(&mut self, level: Level) {
        let blocks = &mut self.movers.blocks;
        let (carried, before, velocities) = (&mut self.carried, &self.before, &self.velocities);
        dispatch!(level, simd => moving::end_all(simd, blocks, carried, before, velocities));
    }

    /// Without warm start each substep begins from nothing.
    fn forget(&mut self) {
        self.carried.fill(Record::default());
        for block in &mut self.blocks {
            block.points.iter_mut().for_each(|p| p.lambda = [0.0; LANES]);
            block.disks.iter_mut().for_each(|d| d.lambda = [[0.0; LANES]; 2]);
        }
        self.joints.forget();
    }

    fn warm_start(&mut self, level: Level) {
        let (blocks, scales, velocities) = (&self.blocks, &self.scales, &mut self.velocities);
        dispatch!(level, simd => warm_start_all(simd, blocks, scales, velocities));
        self.joints.warm_start(level, &mut self.velocities);
    }

    /// Biases of the rows; loads and unrest of the islands.
    fn look(&mut self, level: Level, pass: &SweepPass) {
        self.inspect(level, pass, Biases::Recover);
        for island in &mut self.islands {
            (island.load, island.unrest) = (0.0, 0.0);
        }
        for place in &self.places {
            let (block, lane) = (&self.blocks[place.block as usize], place.lane as usize);
            let island = &mut self.islands[place.island as usize];
            island.unrest += self.unrest[place.block as usize][lane];
            island.load += block.points[..place.size.points()].iter().map(|p| p.lambda[lane]).sum::<f32>();
        }
    }

    /// The end of a substep without relax sweeps.
    fn leave(&mut self, level: Level, pass: &SweepPass, biases: Biases) {
        let (blocks, displacements) = (&mut self.blocks, &self.displacements);
        dispatch!(level, simd => leave_all(simd, blocks, displacements, pass, biases));
        self.joints.add_up(level);
    }

    /// Contacts, then joints; or all of it the other way around.
    fn sweep(&mut self, level: Level, pass: &SweepPass, joints: &JointPass, visits: Visits) {
        if visits.reversed {
            self.joints.sweep(level, &mut self.velocities, joints, true, visits.add_up);
        }
        let (blocks, scales) = (&mut self.blocks[..], &self.scales[..]);
        let (velocities, displacements) = (&mut self.velocities[..], &self.displacements[..]);
        dispatch!(level, simd => sweep(simd, blocks, scales, velocities, displacements, pass, visits));
        if !visits.reversed {
            self.joints.sweep(level, &mut self.velocities, joints, false, visits.add_up);
        }
    }

    fn residual(&mut self, level: Level, pass: &SweepPass, joints: &JointPass) -> f32 {
        let of_contacts = self.inspect(level, pass, Biases::Keep);
        of_contacts.max(self.joints.residual(level, &self.velocities, joints))
    }

    /// How far each block is from rest; the greatest change of an impulse that a visit would make.
    fn inspect(&mut self, level: Level, pass: &SweepPass, biases: Biases) -> f32 {
        let (blocks, displacements) = (&mut self.blocks, &self.displacements);
        let (velocities, unrest) = (&self.velocities, &mut self.unrest);
        unrest.clear();
        let mut residual = [0.0; LANES];
        dispatch!(level, simd => {
            inspect_all(simd, blocks, displacements, velocities, pass, biases, unrest, &mut residual);
        });
        residual.into_iter().fold(0.0, f32::max)
    }

    fn manifold_work(&self, passes: u64) -> work::Manifolds {
        let mut sum = work::Manifolds::default();
        self.places.iter().for_each(|place| sum.add(place.size.points() as u64, passes));
        sum
    }
}

#[inline(always)]
fn warm_start_all<S: Simd>(
    simd: S,
    blocks: &[kernel::ContactBlock],
    scales: &[kernel::ScaleLanes],
    velocities: &mut [Record],
) {
    for (k, block) in blocks.iter().enumerate() {
        kernel::warm_start(simd, block, &scales[k.min(scales.len() - 1)], velocities);
    }
}

#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "a kernel takes the arrays of a batch")]
fn inspect_all<S: Simd>(
    simd: S,
    blocks: &mut [kernel::ContactBlock],
    displacements: &[Record],
    velocities: &[Record],
    pass: &SweepPass,
    biases: Biases,
    unrest: &mut Vec<Lane>,
    residual: &mut Lane,
) {
    let mut greatest = splat(simd, 0.0);
    for block in blocks {
        if biases != Biases::Keep {
            kernel::measure(simd, block, displacements, pass, biases);
        }
        let found = kernel::inspect(simd, block, velocities);
        greatest = found.residual.simd_gt(greatest).select(found.residual, greatest);
        let mut lanes = [0.0; LANES];
        store(found.energy, &mut lanes);
        unrest.push(lanes);
    }
    store(greatest, residual);
}

#[inline(always)]
fn reweigh_all<S: Simd>(
    simd: S,
    blocks: &mut [kernel::ContactBlock],
    scales: &[kernel::ScaleLanes],
    old: &[Record],
    new: &[Record],
) {
    for (k, block) in blocks.iter_mut().enumerate() {
        kernel::reweigh(simd, block, &scales[k.min(scales.len() - 1)], old, new);
    }
}

#[inline(always)]
fn leave_all<S: Simd>(
    simd: S,
    blocks: &mut [kernel::ContactBlock],
    displacements: &[Record],
    pass: &SweepPass,
    biases: Biases,
) {
    for block in blocks {
        kernel::measure(simd, block, displacements, pass, biases);
        kernel::add_up(simd, block);
    }
}

/// Each block comes once into the cache for all that a sweep does to it.
#[inline(always)]
fn sweep<S: Simd>(
    simd: S,
    blocks: &mut [kernel::ContactBlock],
    scales: &[kernel::ScaleLanes],
    velocities: &mut [Record],
    displacements: &[Record],
    pass: &SweepPass,
    visits: Visits,
) {
    let (n, last) = (blocks.len(), scales.len() - 1);
    for i in 0..n {
        let k = if visits.reversed { n - 1 - i } else { i };
        let block = &mut blocks[k];
        if visits.biases != Biases::Keep {
            kernel::measure(simd, block, displacements, pass, visits.biases);
        }
        kernel::visit(simd, block, &scales[k.min(last)], velocities, pass);
        if visits.add_up {
            kernel::add_up(simd, block);
        }
    }
}
