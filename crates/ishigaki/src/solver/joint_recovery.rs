//! Joint recovery: by velocities where they are solved exactly, by poses where joints touch something. TALK B9, corrected.
//!
//! The talk asks joint rows for the speed k C/h. Joints that touch nothing are solved at once, and the relax sweeps take
//! all of that speed out again: so it is done for them, and angular momentum is kept to rounding. In turn with contacts, and
//! in nets, few sweeps leave some of it; it stays in λ, the warm start hands it on, and heaps tremble for ever. There the
//! rows are solved after the motion for velocities of their own, that start at zero: J v = −k C/h; the bodies move by
//! h v, and v and its impulses are forgotten (split impulse, pseudo-velocities). Nets that touch nothing do so at the end of
//! the step alone: as much comes back for a fourth of the work. In heaps it does not; what lies under others creeps out.
//!
//! Bodies move along straight lines, arms along arcs: with a = ½h(ω×(ω×r) + ω̇×r) of both arms the error after the motion
//! is C + h(J u + a). What recovers by poses has velocities along *chords*: J u = −a before the motion, so that poses stay
//! on the arc, and J u = a after it, the direction in which the same straight line leaves. λ is then the same in both
//! halves of a substep: as a first guess it is right, and what few sweeps leave undone gives no energy, as it does where
//! velocities end along the tangent, J u = 0. At the limit of many sweeps this is SHAKE, which is symplectic. Where all is
//! solved at once tangents are as good, and are what motors and reports expect.
//! Motors, springs and friction have no errors; contacts recover for themselves, and overlap that a joint makes is theirs
//! to take back.
//! Option: `solver.joint_recovery`; proved by `tests/laws_joint.rs` and `tests/net.rs`.
//! Source: Weinstein, Teran & Fedkiw 2006 (joint errors are met by poses before velocities are solved); Catto, Box2D,
//! `b2Island.cpp`, notes on position correction (pseudo-velocities); Ryckaert, Ciccotti & Berendsen 1977 (SHAKE).

use crate::constraint::friction::Coupling;
use crate::math::Vec3;
use crate::motion;
use crate::solver::plan::Plan;
use crate::solver::reference::{Unit, visit};
use crate::solver::table::SolverBody;
use crate::world::World;

impl World {
    /// Moves bodies toward what their joints ask for; rows of joints are those of the poses as they are.
    pub(crate) fn recover_joints(&mut self, plan: &mut Plan, h: f32) {
        if !self.options.solver.joint_recovery.enabled || plan.recovery_work == 0 {
            return;
        }
        let joint_rows = plan.joint_rows();
        let mut lambdas = std::mem::take(&mut plan.lambdas);
        lambdas.clear();
        lambdas.extend(plan.rows[..joint_rows].iter_mut().map(|row| std::mem::take(&mut row.lambda)));
        for body in &mut plan.bodies {
            (body.velocity, body.angular_velocity) = (Vec3::ZERO, Vec3::ZERO);
        }
        for k in 0..plan.units.len() {
            let unit = plan.units[k];
            if is_recovered(unit, plan) {
                visit(unit, plan, 1);
            }
        }
        self.report.work += plan.recovery_work;
        for (row, &lambda) in plan.rows.iter_mut().zip(&lambdas) {
            row.lambda = lambda;
        }
        plan.lambdas = lambdas;
        for (body, &slot) in plan.bodies[1..].iter_mut().zip(&plan.movers) {
            let state = self.bodies.at_mut(slot);
            let (way, turn) = (h * body.velocity, h * body.angular_velocity);
            if way != Vec3::ZERO || turn != Vec3::ZERO {
                state.center += way;
                state.rotation = motion::turned(state.rotation, body.angular_velocity, h);
                body.translation += way;
                body.turn += turn;
                if state.is_dynamic() && !state.has_locked_rotation() {
                    state.angular_velocity = state.spin().inverse_inertia_times(state.angular_momentum);
                }
            }
            (body.velocity, body.angular_velocity) = (state.velocity, state.angular_velocity);
        }
    }
}

/// Marks the rows of joints that recover by poses: of what touches something or is joined to what does, of nets, and, where
/// trees are off, of chains.
pub fn choose_recovery(plan: &mut Plan, trees: bool) {
    let is_swept =
        |body: &SolverBody| body.touched || body.in_idle_tree || body.in_net || (body.shares_joints && !trees);
    let joint_rows = plan.joint_rows();
    plan.joints_are_exact = true;
    for index in 0..joint_rows {
        let ends = (plan.rows[index].body_a, plan.rows[index].body_b);
        let by_pose = is_swept(&plan.bodies[ends.0 as usize]) || is_swept(&plan.bodies[ends.1 as usize]);
        let row = &mut plan.rows[index];
        row.by_pose = by_pose;
        if row.by_pose {
            plan.joints_are_exact = false;
            row.bias = row.relax_bias + row.arc;
            for body in [row.body_a, row.body_b] {
                let body = &mut plan.bodies[body as usize];
                // Trees of a net are solved at once, with stiffness that is taken from the inertia anew.
                body.keeps_rows = body.moves() && !body.in_net;
            }
        }
    }
}

/// Equality rows and ends of ranges of joints that recover by poses.
pub fn is_recovered(unit: Unit, plan: &Plan) -> bool {
    match unit {
        Unit::Tree(index) => plan.forest.trees[index as usize].in_net,
        Unit::Manifold(_) => false,
        Unit::Row(index) => {
            let row = &plan.rows[index as usize];
            row.by_pose && (matches!(row.coupling, Coupling::Block(_)) || row.is_limit())
        }
    }
}
