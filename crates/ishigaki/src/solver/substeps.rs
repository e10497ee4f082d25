//! Stage `solve`: all substeps, velocities and positions.
//!
//! Each substep: rows of joints anew · forces · impacts · warm start · sweeps with recovery · bodies move · joints
//! recover (`joint_recovery.rs`) · relax sweeps without recovery, which take its speed out again. Contacts keep their
//! Jacobians over the step, their separations advance by J·δ; joints refresh anchors, since their errors must not
//! drift, before the sweeps and after the motion: velocities end tangent to what the joint allows there, or, where joints
//! recover by poses, along the chord that leaves from there, and what swings keeps its energy.
//! Proved by `tests/laws_pendulum.rs`, `tests/laws_momentum.rs`.

use crate::body::{BodyState, unlocked};
use crate::collision::link::Link;
use crate::collision::manifold::Contact;
use crate::constraint::contact;
use crate::constraint::frame::{BodyFrame, JointStep};
use crate::constraint::friction::Coupling;
use crate::constraint::joint_rows::reaction;
use crate::constraint::row::RowSpec;
use crate::math::{Quat, Vec3};
use crate::motion::{self, Spin, drift, forces};
use crate::options::{DriftScheme, Permutation};
use crate::solver::penetration_recovery::Recovery;
use crate::solver::plan::{Plan, scale_contacts};
use crate::solver::restitution::{self, Impact};
use crate::solver::table::{MassScale, Row, SolverBody, couple_disks};
use crate::solver::{joint_tree, permutation, reference, residual, shock_propagation, slop, table, warm_start, work};
use crate::world::World;
use arrayvec::ArrayVec;

impl World {
    /// Stage `solve`.
    pub(crate) fn solve(&mut self, plan: &mut Plan, dt: f32) {
        let substeps = plan.substeps;
        let h = dt / substeps as f32;
        // Those of the wide path are written by it; those that sleep have none.
        let narrow = |(_, link): &(&mut Contact, &Link)| link.batch == Link::NONE && !link.sleeps;
        for (contact, _) in self.contacts.iter_mut().zip(&self.scratch.links).filter(narrow) {
            for point in contact.manifolds.iter_mut().flat_map(|m| &mut m.points) {
                point.impulse = 0.0;
            }
        }
        self.solve_batches(&mut plan.wide, dt);
        if plan.movers.is_empty() && plan.rows.is_empty() && !self.options.report.residual_by_sweep {
            // All is on the wide path, as in most steps.
            self.report.sweeps += (substeps * (plan.sweeps + plan.relax_sweeps)) as usize;
        } else {
            (0..substeps).for_each(|substep| self.substep(plan, h, substep));
        }
        self.report.work += std::mem::take(&mut plan.level_correction.work);
        self.report.work_budget = work::budget(plan.rows.len() + plan.wide.rows);
        self.last_substep = dt / self.options.solver.substeps as f32;
        self.store_impulses(plan, dt);
        self.store_batches(&mut plan.wide, dt);
    }

    fn substep(&mut self, plan: &mut Plan, h: f32, substep: u32) {
        self.prepare_substep(plan, h, substep);
        self.start_warm(plan);
        self.velocity_sweeps(plan, h, substep + 1 == plan.substeps);
        self.commit_velocities(plan);
        self.move_bodies(plan, h);
        if !plan.joints.is_empty() {
            self.report.work += self.weigh_turned(plan);
            self.turn_joint_rows(plan, h);
            self.report.work += factor_joints(plan);
            if plan.joints_touch || substep + 1 == plan.substeps {
                self.recover_joints(plan, h);
            }
        }
        if plan.relax_sweeps > 0 {
            self.relax(plan, h);
        }
        for row in &mut plan.rows {
            row.total_lambda += row.lambda;
        }
    }

    /// All that comes before the impulses of a substep: rows of joints anew, forces, masses, biases, impacts.
    pub(crate) fn prepare_substep(&mut self, plan: &mut Plan, h: f32, substep: u32) {
        if substep > 0 {
            self.refresh_joint_rows(plan, h);
            self.restore_order(plan);
        }
        self.apply_forces(plan, h, substep == 0);
        joint_tree::stiffen(&plan.rows, &plan.blocks, h, &mut plan.bodies);
        self.report.work += refresh_masses(plan, substep == 0) + plan.push_work;
        let gaps = self.refresh_contact_biases(plan, h);
        if gaps.any_bounce && self.options.solver.restitution.enabled {
            self.resolve_impacts(plan, h);
        }
    }

    /// Where all joints are solved exactly each substep visits in the order of the first: trees last before the motion, so
    /// that nothing is left between joints, and motors last after it, so that they end at their speed. Nets and what
    /// touches converge better forwards and backwards in turn.
    fn restore_order(&self, plan: &mut Plan) {
        let alternates = self.options.solver.permutation == Permutation::Alternating;
        let turns = plan.sweeps + plan.relax_sweeps - 1;
        if alternates && !plan.joints.is_empty() && plan.joints_are_exact && !turns.is_multiple_of(2) {
            plan.units.reverse();
        }
    }

    /// Anchors, axes and errors of joints for the poses as they are; impulses stay. What recovers by poses keeps the rows
    /// from before that: it moved no farther than its errors.
    fn refresh_joint_rows(&mut self, plan: &mut Plan, h: f32) {
        self.collect_frames(plan, BodyState::frame);
        self.for_joint_rows(plan, self.joint_step(h), |row, spec| {
            if row.by_pose && spec.softness == 0.0 {
                row.bias = row.relax_bias + 2.0 * row.arc;
                return;
            }
            let fresh = Row::of_joint(spec, row.body_a, row.body_b, row.lambda);
            let (total_lambda, coupling, by_pose) = (row.total_lambda, row.coupling, row.by_pose);
            *row = Row { total_lambda, coupling, by_pose, ..fresh };
        });
    }

    /// Inertia after the motion of bodies that turned far and keep their rows for the next substep, and masses of their
    /// contacts. Multiply-adds of that.
    fn weigh_turned(&self, plan: &mut Plan) -> u64 {
        for (body, &slot) in plan.bodies[1..].iter_mut().zip(&plan.movers) {
            body.turned = body.keeps_rows && body.has_turned_far() && self.bodies.at(slot).is_dynamic();
            if body.turned {
                weigh(body, self.bodies.at(slot));
            }
        }
        refresh_contact_masses(plan, false)
    }

    /// Jacobians of hard joint rows at the poses after the motion, with the bias of what recovers there. Velocities must
    /// end along what the joint allows *there*, or along the chord from there: along the directions before the motion, the
    /// next substep would take the difference out as a loss. Soft rows keep theirs, as their bias is an implicit equation
    /// about the whole substep, and see the inertia as it is now.
    fn turn_joint_rows(&mut self, plan: &mut Plan, h: f32) {
        self.collect_frames(plan, BodyState::frame);
        self.for_joint_rows(plan, self.pose_step(plan, h), |row, spec| {
            if spec.softness == 0.0 {
                row.jacobian = spec.jacobian;
                let recovery = if row.by_pose { spec.bias - spec.arc } else { spec.relax_bias };
                row.arc = if row.by_pose { spec.arc } else { 0.0 };
                (row.bias, row.relax_bias) = (recovery, spec.relax_bias - row.arc);
            }
        });
        weigh_joint_rows(plan);
    }

    /// Poses and velocities of jointed bodies: each is asked for by several joints.
    fn collect_frames(&self, plan: &mut Plan, frame: impl Fn(&BodyState) -> BodyFrame) {
        plan.frames.clear();
        plan.frames.push(BodyFrame::at_rest(Vec3::ZERO, Quat::IDENTITY));
        for (body, &slot) in plan.bodies[1..].iter().zip(&plan.movers) {
            let nothing = plan.frames[0];
            plan.frames.push(if body.jointed { frame(self.bodies.at(slot)) } else { nothing });
        }
    }

    /// Calls `edit` for each joint row with what its joint asks for at the poses as they are.
    fn for_joint_rows(&mut self, plan: &mut Plan, step: JointStep, mut edit: impl FnMut(&mut Row, &RowSpec)) {
        for rows in &plan.joints {
            let joint = self.joints.at_mut(rows.joint);
            let (a, b) = (joint.definition.body_a.index, joint.definition.body_b.index);
            let [a, b] = [a, b].map(|slot| match plan.index_of[slot as usize] {
                0 => self.bodies.at(slot).frame_without_gyration(),
                index => plan.frames[index as usize],
            });
            plan.specs.clear();
            joint.resolved.rows(&joint.definition.kind, &a, &b, &step, &mut plan.specs);
            let (first, last) = (rows.first as usize, (rows.first + rows.count) as usize);
            for (row, spec) in plan.rows[first..last].iter_mut().zip(&plan.specs) {
                edit(row, spec);
            }
        }
    }

    /// v += h(F/m + g), L += hτ, damping; then ω and I⁻¹ of the solver from the pose as it is.
    fn apply_forces(&mut self, plan: &mut Plan, h: f32, first: bool) {
        let gravity = self.options.gravity;
        for (body, &slot) in plan.bodies[1..].iter_mut().zip(&plan.movers) {
            let state = self.bodies.at_mut(slot);
            if !state.is_dynamic() {
                continue;
            }
            let before = (state.velocity, state.angular_velocity);
            let acceleration = gravity * state.gravity_scale;
            state.velocity = forces::accelerated(state.velocity, state.force, body.inverse_mass, acceleration, h);
            state.velocity *= forces::damping_factor(state.linear_damping, h);
            let mut spin = spin_of(state);
            forces::apply_angular_impulse(&mut spin, h * state.torque, unlocked(state.locked_rotation));
            forces::damp_spin(&mut spin, forces::damping_factor(state.angular_damping, h));
            body.forced_velocity = state.velocity - before.0;
            body.forced_spin = spin.angular_velocity - before.1;
            (state.angular_momentum, state.angular_velocity) = (spin.angular_momentum, spin.angular_velocity);
            body.velocity = state.velocity;
            body.angular_velocity = state.angular_velocity;
            // Contacts keep Jacobians and masses over the step; joints have theirs anew.
            body.turned = first || (body.jointed && !body.keeps_rows);
            if body.turned {
                weigh(body, state);
            }
        }
    }

    /// Biases of normals from separations that advanced with the bodies.
    fn refresh_contact_biases(&self, plan: &mut Plan, h: f32) -> Gaps {
        let options = &self.options.solver;
        let scale = self.options.length_scale;
        let recovery = Recovery::new(&options.penetration_recovery, slop::depth(&options.slop, scale), scale);
        let warm = options.warm_start.enabled;
        let mut gaps = Gaps { any_bounce: false };
        for m in &plan.manifolds {
            gaps.any_bounce |= m.restitution > 0.0;
            let manifold = &self.contacts[m.contact as usize].manifolds[m.manifold as usize];
            let first = (m.first + m.layout.first_normal()) as usize;
            for (row, point) in plan.rows[first..].iter_mut().zip(&manifold.points) {
                let separation = point.separation + row.displacement(&plan.bodies);
                let jointed = |body: u32| plan.bodies[body as usize].jointed;
                let is_borne = warm
                    && row.lambda > 0.0
                    && row.effective_mass > 0.0
                    && !jointed(row.body_a)
                    && !jointed(row.body_b);
                let borne = if is_borne { row.lambda / row.effective_mass } else { 0.0 };
                (row.bias, row.relax_bias) = recovery.bias(separation, h, borne);
            }
        }
        gaps
    }

    /// Sweeps without recovery for the poses after the motion, so that its push does not stay in the velocities.
    fn relax(&mut self, plan: &mut Plan, h: f32) {
        for row in &mut plan.rows {
            row.bias = row.relax_bias;
        }
        self.refresh_contact_biases(plan, h);
        let restitution = self.options.solver.restitution.enabled;
        for m in &plan.manifolds {
            let first = (m.first + m.layout.first_normal()) as usize;
            for row in &mut plan.rows[first..first + m.layout.normals as usize] {
                // What flies at a surface that it does not touch yet keeps its speed for the impact to come.
                let flies = restitution && m.restitution > 0.0 && row.relax_bias > 0.0 && row.lambda == 0.0;
                row.bias = if flies { f32::MAX } else { row.relax_bias };
            }
        }
        for sweep in 0..plan.relax_sweeps {
            self.one_sweep(plan, plan.sweeps + sweep);
        }
        self.commit_velocities(plan);
    }

    fn resolve_impacts(&mut self, plan: &mut Plan, h: f32) {
        let options = &self.options.solver;
        let threshold = options.restitution.threshold * self.options.length_scale.sqrt();
        let (model, passes) = (options.friction, options.restitution.passes);
        for _ in 0..passes {
            let mut any = false;
            for m in plan.manifolds.iter().filter(|m| m.restitution > 0.0) {
                let manifold = &mut self.contacts[m.contact as usize].manifolds[m.manifold as usize];
                let normals = &plan.rows[(m.first + m.layout.first_normal()) as usize..][..manifold.points.len()];
                let separations: ArrayVec<f32, 4> = manifold
                    .points
                    .iter()
                    .zip(normals)
                    .map(|(p, r)| p.separation + r.displacement(&plan.bodies))
                    .collect();
                let impact = Impact {
                    body_a: normals[0].body_a,
                    body_b: normals[0].body_b,
                    surface: m.surface,
                    restitution: m.restitution,
                    threshold,
                    h,
                    drift: self.options.motion.drift,
                };
                let mut impulses = [0.0; 4];
                any |= restitution::resolve(&impact, manifold, &separations, model, &mut plan.bodies, |i, impulse| {
                    impulses[i] = impulse;
                });
                for (point, impulse) in manifold.points.iter_mut().zip(impulses) {
                    point.impulse += impulse;
                }
            }
            if !any {
                break;
            }
        }
    }

    fn start_warm(&mut self, plan: &mut Plan) {
        // The factor is for impulses of the last step; those of the last substep are the best guess there is.
        let factor = if self.options.solver.warm_start.enabled { 1.0 } else { 0.0 };
        if self.blends_shock() {
            // Both solutions start from the same velocities: each applies the impulses itself.
            for row in &mut plan.rows {
                row.lambda *= factor;
            }
        } else {
            warm_start::warm_start(factor, &mut plan.rows, &plan.blocks, &mut plan.bodies);
        }
    }

    /// Level correction needs the masses as they are.
    pub(crate) fn corrects_levels(&self) -> bool {
        self.options.solver.level_correction.enabled && self.knows_true_masses()
    }

    /// No technique makes bodies count as heavier than they are.
    pub(crate) fn knows_true_masses(&self) -> bool {
        let options = &self.options.solver;
        !options.weight_amplification.enabled && !options.shock_propagation.enabled
    }

    fn blends_shock(&self) -> bool {
        let shock = &self.options.solver.shock_propagation;
        shock.enabled && shock.blend < 1.0
    }

    /// The sweeps with recovery; with blended shock propagation, both solutions and their mean.
    fn velocity_sweeps(&mut self, plan: &mut Plan, h: f32, is_last: bool) {
        if self.blends_shock() {
            self.blended_sweeps(plan);
        } else {
            self.sweeps(plan, h);
        }
        if self.options.report.residual && is_last {
            self.report.residual = residual::residual(&plan.rows, &plan.blocks, &plan.bodies);
        }
    }

    fn sweeps(&mut self, plan: &mut Plan, h: f32) {
        if self.corrects_levels() {
            self.correct_levels(plan, h);
            for (body, steps) in plan.level_correction.pauses.drain(..) {
                self.bodies.at_mut(body).no_correction_until = self.step_count + steps;
            }
        }
        for sweep in 0..plan.sweeps {
            self.one_sweep(plan, sweep);
            if self.options.report.residual_by_sweep {
                self.report.residual_by_sweep.push(residual::residual(&plan.rows, &plan.blocks, &plan.bodies));
            }
        }
        for _ in 0..plan.joint_passes {
            reference::revisit_joints(plan);
            self.report.work += 2 * plan.hard_work;
        }
    }

    fn one_sweep(&mut self, plan: &mut Plan, sweep: u32) {
        permutation::before_sweep(self.options.solver.permutation, sweep, &mut self.random, &mut plan.units);
        let shock = &self.options.solver.shock_propagation;
        if shock.enabled && shock.blend >= 1.0 {
            // From the ground up, whatever the permutation did within a level.
            shock_propagation::sort_upward(plan);
        }
        if (1..plan.sweeps).contains(&sweep) && !plan.calm.is_empty() {
            let passes = self.options.solver.manifold_block.passes;
            let saved = reference::sweep_restless(plan, passes);
            self.report.sweeps += 1;
            self.report.work += plan.sweep_work - saved;
        } else {
            self.sweep_units(plan, sweep >= plan.sweeps);
        }
    }

    fn sweep_units(&mut self, plan: &mut Plan, is_relaxing: bool) {
        let passes = self.options.solver.manifold_block.passes;
        if is_relaxing && plan.over_relaxation > 1.0 {
            reference::sweep_over_relaxed(plan, passes, plan.over_relaxation);
        } else {
            reference::sweep(plan, passes);
        }
        self.report.sweeps += 1;
        self.report.work += plan.sweep_work;
    }

    /// λ = (1−c)λ₀ + cλ₁ from two solves with the same start, and so are the velocities: each solution is at rest with
    /// its own masses, and the blend of λ applied with either masses would not be. TALK D7.
    fn blended_sweeps(&mut self, plan: &mut Plan) {
        let c = self.options.solver.shock_propagation.blend;
        let start: Vec<SolverBody> = plan.bodies.clone();
        let first: Vec<f32> = plan.rows.iter().map(|r| r.lambda).collect();
        let scales: Vec<MassScale> = plan.rows.iter().map(|r| r.scale).collect();

        warm_start::apply_all(&plan.rows, &plan.blocks, &mut plan.bodies);
        self.sweeps(plan, 0.0);
        let plain: Vec<f32> = plan.rows.iter().map(|r| r.lambda).collect();
        let plain_bodies = std::mem::replace(&mut plan.bodies, start);

        for (row, lambda) in plan.rows.iter_mut().zip(&first) {
            row.lambda = *lambda;
        }
        scale_contacts(plan, shock_propagation::scale);
        refresh_masses(plan, true);
        warm_start::apply_all(&plan.rows, &plan.blocks, &mut plan.bodies);
        let order = plan.units.clone();
        for sweep in 0..plan.sweeps {
            permutation::before_sweep(self.options.solver.permutation, sweep, &mut self.random, &mut plan.units);
            shock_propagation::sort_upward(plan);
            self.sweep_units(plan, false);
        }
        plan.units = order;

        for (body, plain) in plan.bodies.iter_mut().zip(&plain_bodies) {
            body.velocity = (1.0 - c) * plain.velocity + c * body.velocity;
            body.angular_velocity = (1.0 - c) * plain.angular_velocity + c * body.angular_velocity;
        }
        for ((row, plain), scale) in plan.rows.iter_mut().zip(&plain).zip(scales) {
            row.lambda = (1.0 - c) * plain + c * row.lambda;
            row.scale = scale;
        }
        refresh_masses(plan, true);
    }

    /// Takes the solver's velocities into the bodies: L changes by I Δω, so it stays exact where nothing pushed.
    fn commit_velocities(&mut self, plan: &mut Plan) {
        for (body, &slot) in plan.bodies[1..].iter().zip(&plan.movers) {
            let state = self.bodies.at_mut(slot);
            if !state.is_dynamic() {
                continue;
            }
            state.velocity = body.velocity;
            let change = body.angular_velocity - state.angular_velocity;
            if change != Vec3::ZERO {
                // With the inertia that the rows saw: the sum of all Jᵀλ to rounding, also after the body has turned.
                state.angular_momentum += body.inertia * change;
                state.angular_velocity = if state.has_locked_rotation() {
                    body.angular_velocity
                } else {
                    spin_of(state).inverse_inertia_times(state.angular_momentum)
                };
            }
        }
    }

    /// x += h v; R by the scheme of the rotation; kinematic bodies move as they are told.
    fn move_bodies(&mut self, plan: &mut Plan, h: f32) {
        let motion = &self.options.motion;
        if motion.drift == DriftScheme::Trapezoidal {
            table::mark_pushed(&plan.rows, &mut plan.bodies);
        }
        let root = self.options.length_scale.sqrt();
        let (max_speed, max_angular_speed) = (motion.max_speed * root, motion.max_angular_speed / root);
        for (body, &slot) in plan.bodies[1..].iter_mut().zip(&plan.movers) {
            let state = self.bodies.at_mut(slot);
            if state.is_dynamic() {
                state.velocity = forces::limited(state.velocity, max_speed);
                let mut spin = spin_of(state);
                forces::limit_spin(&mut spin, max_angular_speed);
                body.turn += h * spin.angular_velocity;
                motion::advance(motion.rotation, &mut spin, state.has_locked_rotation(), h);
                state.rotation = spin.rotation;
                state.angular_momentum = spin.angular_momentum;
                state.angular_velocity = spin.angular_velocity;
            } else {
                body.turn += h * state.angular_velocity;
                state.rotation = motion::turned(state.rotation, state.angular_velocity, h);
            }
            let way = drift::displacement(motion.drift, state.velocity, body.forced_velocity, body.pushed, h);
            state.center += way;
            body.translation += way;
            (body.velocity, body.angular_velocity) = (state.velocity, state.angular_velocity);
        }
    }

    /// Impulses and separations back into contacts and joints, for the next step and for reports.
    fn store_impulses(&mut self, plan: &Plan, dt: f32) {
        let model = self.options.solver.friction;
        let mut lambdas: ArrayVec<f32, 16> = ArrayVec::new();
        for m in &plan.manifolds {
            let rows = &plan.rows[m.first as usize..(m.first + m.layout.total()) as usize];
            let manifold = &mut self.contacts[m.contact as usize].manifolds[m.manifold as usize];
            lambdas.clear();
            lambdas.extend(rows.iter().map(|r| plan.share * r.lambda));
            contact::store(manifold, &m.surface, model, &lambdas);
            let normals = &rows[m.layout.first_normal() as usize..];
            for (point, row) in manifold.points.iter_mut().zip(normals) {
                point.impulse += row.total_lambda;
                // Linear, so that frozen rows live on without creeping. TALK D10.
                point.separation += row.displacement(&plan.bodies);
            }
        }
        for j in &plan.joints {
            let rows = &plan.rows[j.first as usize..(j.first + j.count) as usize];
            let joint = self.joints.at_mut(j.joint);
            for (stored, row) in joint.lambdas.iter_mut().zip(rows) {
                *stored = plan.share * row.lambda;
            }
            let (a, b) = (joint.definition.body_a.index, joint.definition.body_b.index);
            let (a, b) = (self.bodies.at(a).frame(), self.bodies.at(b).frame());
            let arm_a = joint.resolved.arm_a(&a);
            let (impulse, angular_impulse) = reaction(rows.iter().map(|r| (r.jacobian, r.total_lambda)), arm_a);
            (joint.force, joint.torque) = (impulse / dt, angular_impulse / dt);
            joint.resolved.refresh(&joint.definition.kind, &a, &b);
            joint.anchor_error = joint.resolved.anchor_error(&joint.definition.kind, &a, &b);
            joint.angle_error = joint.resolved.angle_error(&joint.definition.kind, &a, &b);
            self.scratch.joint_errors.add(joint.anchor_error);
        }
    }
}

/// What the biases found on their way.
struct Gaps {
    any_bounce: bool,
}

/// M⁻¹Jᵀ and effective masses of the rows of all bodies that turned, for the inertia as it is.
/// Multiply-adds of that.
fn refresh_masses(plan: &mut Plan, all: bool) -> u64 {
    weigh_joint_rows(plan);
    for block in plan.blocks.iter_mut().filter(|block| !block.in_tree) {
        block.factor(&plan.rows);
    }
    for tree in plan.forest.trees.iter_mut().filter(|t| !t.is_idle) {
        tree.factor(&plan.rows, &plan.blocks);
    }
    plan.joint_row_work + plan.block_work + plan.tree_work + refresh_contact_masses(plan, all)
}

/// M⁻¹Jᵀ of the rows of joints, and effective masses of those alone.
fn weigh_joint_rows(plan: &mut Plan) {
    let joint_rows = plan.joint_rows();
    for block in &plan.blocks {
        block.weigh(&mut plan.rows, &plan.bodies);
    }
    let is_alone = |row: &&mut Row| !matches!(row.coupling, Coupling::Block(_) | Coupling::Partner);
    for row in plan.rows[..joint_rows].iter_mut().filter(is_alone) {
        row.refresh_mass(&plan.bodies);
    }
}

/// The same for contacts alone.
fn refresh_contact_masses(plan: &mut Plan, all: bool) -> u64 {
    let mut work = 0;
    for (index, m) in plan.manifolds.iter().enumerate() {
        let rows = &mut plan.rows[m.first as usize..(m.first + m.layout.total()) as usize];
        let turned = |body: u32| plan.bodies[body as usize].turned;
        if rows.is_empty() || !(all || turned(rows[0].body_a) || turned(rows[0].body_b)) {
            continue;
        }
        for row in rows.iter_mut() {
            row.refresh_mass(&plan.bodies);
        }
        couple_disks(rows);
        let n = u64::from(m.layout.normals);
        work += u64::from(m.layout.total()) * (work::RESPONSE + work::INNER)
            + u64::from(m.layout.tangents) / 2 * work::INNER;
        if let Some(block) = plan.manifold_blocks.get_mut(index) {
            block.refresh(&plan.rows);
            work += n * (n + 1) / 2 * work::INNER;
        }
    }
    work
}

/// Takes the inertia of a body as it is turned.
fn weigh(body: &mut SolverBody, state: &BodyState) {
    body.inverse_inertia = state.inverse_inertia_world();
    body.inertia = state.inertia_world();
    body.turn_of_inertia = body.turn;
}

/// Factors of joints whose rows have turned; multiply-adds of rows and factors.
fn factor_joints(plan: &mut Plan) -> u64 {
    let mut work = plan.joint_row_work + plan.block_work;
    // With old factors a little motion would be left for ever, and heaps would not come to rest.
    for block in plan.blocks.iter_mut().filter(|block| !block.in_tree) {
        block.factor(&plan.rows);
    }
    for tree in plan.forest.trees.iter_mut().filter(|t| !t.is_idle) {
        // Of slow bodies the factors stay those of the poses before the motion: the little that turned comes back in
        // the next sweep. Of fast ones a step with such factors might be none toward the solution.
        if tree.bodies().any(|body| plan.bodies[body as usize].has_turned_far()) {
            tree.factor(&plan.rows, &plan.blocks);
            work += tree.assembly_work(&plan.blocks);
        }
    }
    work
}

fn spin_of(state: &BodyState) -> Spin {
    state.spin()
}
