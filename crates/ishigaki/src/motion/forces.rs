//! Velocities under forces, damping and speed limits. TALK A1, A3, A5.
//!
//! v' = v + Δt (F/m + g) ; L' = L + Δt τ ; x' = x + Δt v' with the NEW v (symplectic Euler: the engine detects,
//! solves v', then moves with it; the slide's old v is explicit Euler and gains energy).
//! Damping multiplies by e^(−dΔt), exact for any d and Δt. Speed limits guard against numbers that run away.
//!
//! N, N·m, kg, m/s, rad/s, 1/s, s; all vectors in world. Nothing here switches it off; gravity, damping and
//! limits are numbers of the options and bodies.
//! Proved by `tests/motion_laws.rs`: free fall to gΔt² n(n+1)/2, decay to e^(−dt), L = ∫τ dt.

use super::Spin;
use crate::math::{Vec3, exp};

// ANCHOR: accelerated
/// v + h (F/m + g). The inverse mass is by world axis, zero along locked ones: gravity does not act there either.
pub fn accelerated(velocity: Vec3, force: Vec3, inverse_mass: Vec3, gravity: Vec3, h: f32) -> Vec3 {
    let gravity = Vec3::select(inverse_mass.cmpgt(Vec3::ZERO), gravity, Vec3::ZERO);
    velocity + h * (force * inverse_mass + gravity)
}
// ANCHOR_END: accelerated

/// What is left of a velocity after `h` seconds of damping (1/s): e^(−dh).
pub fn damping_factor(damping: f32, h: f32) -> f32 {
    // The common case costs nothing and changes no bit.
    if damping == 0.0 { 1.0 } else { exp(-damping * h) }
}

/// Adds an angular impulse (hτ, N·m·s) to L and ω. `free` is 1 for world axes that may turn, 0 for locked ones.
pub fn apply_angular_impulse(spin: &mut Spin, impulse: Vec3, free: Vec3) {
    if free == Vec3::ONE {
        spin.angular_momentum += impulse;
        spin.angular_velocity += spin.inverse_inertia_times(impulse);
    } else {
        // The locked axes answer with whatever torque holds them.
        spin.angular_velocity += free * spin.inverse_inertia_times(free * impulse);
        spin.angular_momentum = spin.inertia_times(spin.angular_velocity);
    }
}

/// Multiplies L and ω.
pub fn damp_spin(spin: &mut Spin, factor: f32) {
    spin.angular_momentum *= factor;
    spin.angular_velocity *= factor;
}

/// The velocity, no faster than `max_speed` (m/s); NaN stays NaN.
pub fn limited(velocity: Vec3, max_speed: f32) -> Vec3 {
    let square = velocity.length_squared();
    if square == f32::INFINITY && velocity.is_finite() {
        // The square overflowed: the direction from the velocity in units of its largest component.
        (velocity / velocity.abs().max_element()).normalize() * max_speed
    } else if square > max_speed * max_speed {
        velocity * (max_speed / square.sqrt())
    } else {
        velocity
    }
}

/// Scales L and ω together so that the body turns no faster than `max_angular_speed` (rad/s); NaN stays NaN.
pub fn limit_spin(spin: &mut Spin, max_angular_speed: f32) {
    let square = spin.angular_velocity.length_squared();
    if square > max_angular_speed * max_angular_speed {
        damp_spin(spin, max_angular_speed / square.sqrt());
    }
}
