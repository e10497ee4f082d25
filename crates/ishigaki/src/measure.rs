//! What a step did, measured at its end: counts, energies, momenta, errors; joints that broke; forces to report.

use crate::body::BodyState;
use crate::event::Event;
use crate::handle::{BodyHandle, JointHandle};
use crate::math::Vec3;
use crate::report::StepReport;
use crate::solver::plan::Plan;
use crate::world::World;

impl World {
    /// Fills the report with the state at the end of the step.
    pub(crate) fn complete_report(&mut self, plan: &Plan) {
        let report = &mut self.report;
        report.bodies = self.bodies.len();
        report.pairs = self.pairs.len();
        report.wide_rows = plan.wide.rows;
        report.rows = plan.rows.len() + plan.wide.rows;
        for sums in &self.scratch.contact_sums {
            report.contacts += sums.contacts;
            report.max_penetration = report.max_penetration.max(sums.max_penetration);
        }
        let solved = self.scratch.joint_errors;
        report.max_joint_error = if solved.joints == self.joints.len() {
            solved.greatest
        } else {
            self.joints.iter().map(|(_, joint)| joint.anchor_error).fold(0.0, f32::max)
        };
        let gravity = self.options.gravity;
        let mut sums = self.options.report.energy.then(EnergySums::default);
        // What has slept for the whole step is not looked at.
        let roles = &self.scratch.roles;
        let all = sums.is_some() || self.scratch.has_woken;
        let is_seen = |slot: u32| all || !roles[slot as usize].sleeps();
        let mut seen = 0;
        for (index, body) in self.bodies.iter_where(is_seen) {
            seen += 1;
            // What sleeps was finite when it fell asleep.
            let sleeps = body.asleep && !body.broken;
            let is_finite = sleeps || body.is_finite();
            if sleeps {
                report.asleep += 1;
            } else if body.broken || !is_finite {
                report.non_finite.push(BodyHandle { index, generation: self.bodies.generation_at(index) });
            } else if body.is_dynamic() {
                report.max_speed = report.max_speed.max(body.velocity.length());
            }
            if let Some(sums) = sums.as_mut().filter(|_| body.is_dynamic() && is_finite) {
                sums.add(body, gravity);
            }
        }
        report.asleep += report.bodies - seen;
        if let Some(sums) = sums {
            sums.write(report);
        }
    }

    /// Removes joints that carried more than they can.
    pub(crate) fn break_joints(&mut self) {
        if !self.scratch.joint_links.list.iter().any(|link| link.breaks) {
            return;
        }
        let broken: Vec<(JointHandle, f32, f32)> = self
            .joints()
            .filter_map(|(handle, joint)| {
                let (force, torque) = (joint.force.length(), joint.torque.length());
                let over = |limit: Option<f32>, value: f32| limit.is_some_and(|limit| value > limit);
                let breaks = over(joint.definition.break_force, force) || over(joint.definition.break_torque, torque);
                breaks.then_some((handle, force, torque))
            })
            .collect();
        for (joint, force, torque) in broken {
            self.remove_joint(joint);
            self.scratch.has_woken = true;
            self.events.push(Event::JointBroke { joint, force, torque });
        }
    }

    /// Reports contacts that carried more than a body asked to hear of.
    pub(crate) fn notice_forces(&mut self, dt: f32) {
        if !self.scratch.hears_forces.contains(&true) {
            return;
        }
        for i in 0..self.contacts.len() {
            let contact = &self.contacts[i];
            let threshold = |index| self.bodies.at(index).force_threshold.unwrap_or(f32::INFINITY);
            let limit = threshold(contact.body_a).min(threshold(contact.body_b));
            if limit == f32::INFINITY {
                continue;
            }
            let impulse: f32 = contact.manifolds.iter().flat_map(|m| &m.points).map(|p| p.impulse).sum();
            let force = impulse / dt;
            if force > limit {
                let (a, b) = (self.shape_id(contact.shape_a), self.shape_id(contact.shape_b));
                self.events.push(Event::ContactForce { a, b, force });
            }
        }
    }
}

/// Sums over bodies in f64: a thousand terms of one sign lose three digits in f32.
#[derive(Default)]
struct EnergySums {
    kinetic: f64,
    potential: f64,
    momentum: [f64; 3],
    angular: [f64; 3],
}

impl EnergySums {
    fn add(&mut self, body: &BodyState, gravity: Vec3) {
        let add = |sum: &mut [f64; 3], v: Vec3| sum.iter_mut().zip(v.to_array()).for_each(|(s, x)| *s += f64::from(x));
        self.potential -= f64::from(body.mass.mass * body.gravity_scale) * f64::from(gravity.dot(body.center));
        if body.asleep {
            return;
        }
        let p = body.mass.mass * body.velocity;
        self.kinetic += f64::from(body.kinetic_energy());
        add(&mut self.momentum, p);
        add(&mut self.angular, body.angular_momentum + body.center.cross(p));
    }

    fn write(&self, report: &mut StepReport) {
        report.kinetic_energy = self.kinetic as f32;
        report.potential_energy = self.potential as f32;
        report.momentum = Vec3::from_array(self.momentum.map(|x| x as f32));
        report.angular_momentum = Vec3::from_array(self.angular.map(|x| x as f32));
    }
}
