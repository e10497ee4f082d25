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

/// How long all bodies of an island must have been slow, s.
pub(crate) fn enough_time(settings: &Sleep, length_scale: f32) -> f32 {
    settings.time * length_scale.sqrt()
}

impl World {
    /// Puts islands to sleep whose bodies have all been slow long enough.
    pub(crate) fn put_islands_to_sleep(&mut self) {
        if self.scratch.roles.iter().any(|role| role.moving_ground) {
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
        let links = self.scratch.links.iter().filter(|link| link.unites()).map(|link| link.bodies);
        for ends in links.chain(self.scratch.joint_links.list.iter().map(|link| link.bodies)) {
            let [a, b] = ends.map(|slot| self.scratch.roles[slot as usize]);
            for (body, other) in [(a, b), (b, a)] {
                if body.active && other.moving_ground {
                    self.scratch.restless_islands[body.island as usize] = true;
                }
            }
        }
    }
}
