//! All substeps of a batch: forces, sweeps with recovery, motion, relax sweeps; then back into the world.
//!
//! The order of things is that of `substeps.rs`, and of `joint_recovery.rs` for joints. A batch in which all bodies rest (`rest.aggressive_sleep`) takes the
//! step as one substep: its impulses are known, and what is left of its motion is taken out once, not once a substep.

use crate::solver::hand_down::{self, HandDown};
use crate::solver::level_correction::{self, CALM, QUIET};
use crate::solver::manifold_block;
use crate::solver::over_relaxation;
use crate::solver::penetration_recovery::Recovery;
use crate::solver::plan::Plan;
use crate::solver::slop;
use crate::solver::wide::Wide;
use crate::solver::wide::batch::{Batch, IslandState, Outcome};
use crate::solver::wide::contact_block::{Biases, SweepPass};
use crate::solver::wide::domain::{Machine, Part};
use crate::solver::wide::joint_block::JointPass;
use crate::solver::wide::lanes::{LANES, Record};
use crate::solver::wide::moving::Motion;
use crate::solver::wide::sweeping::Visits;
use crate::solver::work;
use crate::world::World;
use std::sync::{Mutex, PoisonError};

impl World {
    /// Solves all batches, on several threads if the world has them.
    pub(crate) fn solve_batches(&self, wide: &mut Wide, dt: f32) {
        let machine = Machine { level: wide.level, workers: &self.workers };
        let mut batches = std::mem::take(&mut wide.batches);
        let aids = Mutex::new(std::mem::take(&mut wide.aids));
        let lock = || aids.lock().unwrap_or_else(PoisonError::into_inner);
        let solve = |batch: &mut Batch| {
            let mut aid = lock().pop().unwrap_or_default();
            self.solve_batch(machine, batch, &mut aid, dt);
            lock().push(aid);
        };
        machine.each_batch(&mut batches[..wide.used], solve);
        wide.aids = aids.into_inner().unwrap_or_else(PoisonError::into_inner);
        wide.batches = batches;
    }

    fn solve_batch(&self, machine: Machine<'_>, batch: &mut Batch, aid: &mut Plan, dt: f32) {
        batch.outcome = Outcome::default();
        let solver = &self.options.solver;
        let (substeps, relax_sweeps, solver_substeps) = (batch.substeps, solver.relax_sweeps, solver.substeps);
        // One substep has the sweeps of all.
        let touches = !batch.joints.is_empty() && !batch.is_clear;
        let (of_joints, joint_passes) = if touches { (solver.jointed.sweeps, solver.jointed.passes) } else { (1, 0) };
        let sweeps = solver.sweeps * of_joints * (solver.substeps / substeps).max(1);
        let h = dt / substeps as f32;
        let scale = self.options.length_scale;
        let pass = SweepPass {
            recovery: Recovery::new(&solver.penetration_recovery, slop::depth(&solver.slop, scale), scale),
            h,
            per_second: 1.0 / h,
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
        let relaxing = JointPass::relax(h, over_relaxation::factor(&solver.over_relaxation, touches));
        aid.manifolds.clear();
        batch.aim_joints(machine, h, None);
        for substep in 0..substeps {
            let is_last = substep + 1 == substeps;
            let velocity = JointPass::velocity(h);
            batch.begin(machine, h);
            let mut sweeps = sweeps;
            if !is_free {
                if substep == 0 || batch.pushes_anew() {
                    batch.warm_start(machine);
                    batch.outcome.work += work.warm_start + batch.joints.work.warm_start;
                }
                let looks = substeps < solver_substeps || self.has_stacks(batch);
                if looks {
                    batch.look(machine, &pass);
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
                    batch.sweep(machine, &pass, &velocity, Visits { reversed: order.reversed, biases, add_up: false });
                }
                for _ in 0..joint_passes {
                    batch.revisit_joints(machine, &velocity);
                    batch.outcome.work += 2 * batch.joints.work.points;
                }
                if is_last && self.options.report.residual {
                    batch.outcome.residual = batch.residual(machine, &pass, &velocity);
                }
            }
            batch.advance(machine, &motion);
            if !is_free {
                if !batch.joints.is_empty() {
                    batch.weigh(machine);
                    self.aim_or_recover_joints(machine, batch, h, is_last);
                }
                let relax = if is_last { Biases::RelaxLast } else { Biases::Relax };
                for sweep in 0..relax_sweeps {
                    order.before(sweeps + sweep);
                    let biases = if sweep == 0 { relax } else { Biases::Keep };
                    let visits = Visits { reversed: order.reversed, biases, add_up: sweep + 1 == relax_sweeps };
                    batch.sweep(machine, &pass, &relaxing, visits);
                }
                if relax_sweeps == 0 {
                    batch.leave(machine, &pass, relax);
                }
            }
            batch.end(machine);
            if !pass.warm {
                batch.forget();
            }
            let of_joints = batch.joints.work;
            let reach = if relaxing.reach > 1.0 { u64::from(relax_sweeps) * of_joints.reach } else { 0 };
            batch.outcome.work +=
                u64::from(sweeps + relax_sweeps) * (work.visit + of_joints.sweep) + reach + work.measures;
        }
        batch.see_joints(machine);
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
            if !self.is_worth_handing_down(island.first_body, gain, island.unrest) {
                batch.outcome.pauses.push((island.first_body, hand_down::PAUSE));
            }
        }
    }

    /// Rows of joints for the poses after the motion, and the recovery of their errors: of nets at the end of the step.
    fn aim_or_recover_joints(&self, machine: Machine<'_>, batch: &mut Batch, h: f32, is_last: bool) {
        let recovery = &self.options.solver.joint_recovery;
        let recovers = recovery.enabled && (is_last || !batch.is_clear);
        let rate = if batch.is_clear { recovery.net_rate } else { recovery.rate };
        let pass = JointPass::recovery(h, rate);
        batch.aim_joints(machine, h, recovers.then_some(&pass));
        if !recovers {
            return;
        }
        batch.each(machine, |part| part.shift(machine.level, h));
        batch.outcome.work += batch.joints.work.recovery;
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

impl Batch {
    fn begin(&mut self, machine: Machine<'_>, h: f32) {
        let carries = !self.pushes_anew();
        self.each(machine, |part| part.begin(machine.level, carries, h));
    }

    /// Takes the sweeps over, and moves.
    fn advance(&mut self, machine: Machine<'_>, motion: &Motion) {
        self.each(machine, |part| part.advance(machine.level, motion));
    }

    /// Takes the sweeps after the motion over.
    fn end(&mut self, machine: Machine<'_>) {
        let carries = !self.pushes_anew();
        self.each(machine, |part| part.end(machine.level, carries));
    }

    /// Rows of joints turn with their bodies: their impulses push along other ways than in the last substep.
    fn pushes_anew(&self) -> bool {
        !self.joints.is_empty()
    }

    /// Rows of joints for the poses as they are, and what arcs will add to their gaps in `h` seconds; velocities toward
    /// what they ask for, in the order of a forward sweep as the one before the motion.
    #[inline(never)]
    fn aim_joints(&mut self, machine: Machine<'_>, h: f32, recovery: Option<&JointPass>) {
        if self.joints.is_empty() {
            return;
        }
        let level = machine.level;
        self.each(machine, |part| {
            part.follow(level);
            part.swing(level);
        });
        self.with_poses(machine, |part, poses| part.turn_joints(level, poses, h, recovery));
        self.outcome.work += self.joints.work.rows;
    }

    /// Calls `work` for all joints with the poses of all bodies, those of other domains among them.
    fn with_poses(&mut self, machine: Machine<'_>, work: impl Fn(&mut Part<'_>, &[Record]) + Sync) {
        let poses = std::mem::take(&mut self.joints.poses);
        self.each_and_seam(machine, |part| work(part, &poses));
        self.joints.poses = poses;
    }

    /// Inertias of bodies with joints that turned far, and rows of their contacts, for the rotations as they are: limbs do so
    /// within a step.
    fn weigh(&mut self, machine: Machine<'_>) {
        if !self.movers.blocks.iter().any(|block| block.weighed != 0) {
            return;
        }
        self.each(machine, |part| part.weigh_bodies(machine.level));
        let weigh = |part: &mut Part<'_>| part.weigh_contacts(machine.level);
        let work: u64 = self.each(machine, weigh).into_iter().flatten().sum();
        let of_seam = self.seam().map_or(0, |mut seam| weigh(&mut seam));
        self.outcome.work += work + of_seam;
    }

    /// Errors of joints at the end of the step.
    fn see_joints(&mut self, machine: Machine<'_>) {
        if !self.joints.is_empty() {
            self.each(machine, |part| part.follow(machine.level));
            self.with_poses(machine, |part, poses| part.see_joints(machine.level, poses));
        }
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

    #[inline(never)]
    fn warm_start(&mut self, machine: Machine<'_>) {
        self.each_color(machine, false, |part, blocks| part.warm_start(machine.level, blocks));
        if !self.joints.is_empty() {
            self.each_and_seam(machine, |part| part.warm_start_joints(machine.level));
        }
    }

    /// Biases of the rows; loads and unrest of the islands.
    fn look(&mut self, machine: Machine<'_>, pass: &SweepPass) {
        self.each_and_seam(machine, |part| {
            part.inspect(machine.level, pass, Biases::Recover);
        });
        self.sum_up(machine);
    }

    /// The end of a substep without relax sweeps.
    fn leave(&mut self, machine: Machine<'_>, pass: &SweepPass, biases: Biases) {
        self.each_and_seam(machine, |part| {
            part.leave(machine.level, pass, biases);
            part.add_up_joints(machine.level);
        });
    }

    /// Contacts, then joints; or all of it the other way around.
    #[inline(never)]
    fn sweep(&mut self, machine: Machine<'_>, pass: &SweepPass, joints: &JointPass, visits: Visits) {
        let level = machine.level;
        let sweep_joints = |part: &mut Part<'_>| part.sweep_joints(level, joints, visits.reversed, visits.add_up);
        let has_joints = !self.joints.is_empty();
        if has_joints && visits.reversed {
            self.each_joint(machine, true, sweep_joints);
        }
        self.each_color(machine, visits.reversed, |part, blocks| part.sweep(level, pass, visits, blocks));
        if has_joints && !visits.reversed {
            self.each_joint(machine, false, sweep_joints);
        }
    }

    /// Visits the points of joints alone, back and forth.
    fn revisit_joints(&mut self, machine: Machine<'_>, pass: &JointPass) {
        for reversed in [true, false] {
            self.each_joint(machine, reversed, |part| part.sweep_points(machine.level, pass, reversed));
        }
    }

    fn residual(&mut self, machine: Machine<'_>, pass: &SweepPass, joints: &JointPass) -> f32 {
        let inspect = |part: &mut Part<'_>| {
            part.inspect(machine.level, pass, Biases::Keep).max(part.joint_residual(machine.level, joints))
        };
        let mut greatest = self.each(machine, inspect).into_iter().flatten().fold(0.0, f32::max);
        if let Some(mut seam) = self.seam() {
            greatest = greatest.max(inspect(&mut seam));
        }
        greatest
    }

    fn manifold_work(&self, passes: u64) -> work::Manifolds {
        let mut sum = work::Manifolds::default();
        self.places.iter().for_each(|place| sum.add(place.size.points() as u64, passes));
        sum
    }
}
