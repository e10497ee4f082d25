//! Island sleep. TALK D9.
//!
//! Whole islands only: when every body of an island has been slow for a while, all of them stop being
//! simulated. It does not stabilise anything; it follows from stability. An island wakes when a contact begins,
//! a support is removed, a force is applied, a joint changes, or a kinematic body moves against it.
//! Option: `rest.sleep`; shown by `tests/sleep.rs`.

use crate::body::BodyState;
use crate::options::Sleep;
use crate::world::World;

// ANCHOR: count_rest_time
/// Adds up the time a body has been slow.
pub(crate) fn count_rest_time(body: &mut BodyState, settings: &Sleep, length_scale: f32, dt: f32) {
    let root = length_scale.sqrt();
    let slow = body.velocity.length() < settings.linear_speed * root
        && body.angular_velocity.length() < settings.angular_speed / root;
    body.rest_time = if slow && body.can_sleep { body.rest_time + dt } else { 0.0 };
}
// ANCHOR_END: count_rest_time

impl World {
    /// Puts islands to sleep whose bodies have all been slow long enough.
    pub(crate) fn put_islands_to_sleep(&mut self) {
        let time = self.options.rest.sleep.time * self.options.length_scale.sqrt();
        let islands = self.report.islands;
        let restless = &mut self.scratch.restless_islands;
        restless.clear();
        restless.resize(islands, false);
        let mut carries = false;
        for (_, body) in self.bodies.iter() {
            carries |= body.is_moving_kinematic();
            if body.is_active() && body.rest_time < time {
                restless[body.island as usize] = true;
            }
        }
        if carries {
            self.keep_awake_what_is_carried();
        }
        if self.scratch.restless_islands.iter().all(|&is_restless| is_restless) {
            return;
        }
        for (_, body) in self.bodies.iter_mut() {
            if body.is_active() && !self.scratch.restless_islands[body.island as usize] {
                body.put_to_sleep();
            }
        }
    }

    /// A moving platform keeps what lies on it awake; so does one that pulls by a joint.
    fn keep_awake_what_is_carried(&mut self) {
        let links = self.scratch.links.iter().filter(|link| link.unites).map(|link| link.bodies);
        let joints = self.joints.iter().map(|(_, joint)| [joint.definition.body_a, joint.definition.body_b]);
        for [a, b] in links.chain(joints.map(|ends| ends.map(|end| end.index))) {
            let [a, b] = [a, b].map(|slot| self.bodies.at(slot));
            for (body, other) in [(a, b), (b, a)] {
                if body.is_active() && other.is_moving_kinematic() {
                    self.scratch.restless_islands[body.island as usize] = true;
                }
            }
        }
    }
}
