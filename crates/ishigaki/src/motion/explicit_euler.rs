//! Euler's equation integrated explicitly in ω: the talk's warning. TALK A5, A6.
//!
//! ω' = ω + Δt I⁻¹(τ − ω×Iω) ; R' = exp(Δt [ω']ₓ) R. World frame, rad/s, N·m; τ is added by `forces`.
//! ω is the state, L = I'ω' follows and is not kept: each step adds energy in proportion to |ω|², the faster the
//! faster, and a tumbling body blows up within seconds. Kept so that it can be seen and measured.
//!
//! Switched by `MotionOptions::rotation = RotationScheme::ExplicitEuler`.
//! Proved by `tests/motion_laws.rs`: the energy of (1, 2, 3) kg·m² at 10 rad/s grows more than a thousandfold in 10 s.

use super::{Spin, turned};

/// Turns a free body over `h` seconds; ω gains energy, L follows.
pub fn advance(spin: &mut Spin, h: f32) {
    let gyroscopic = spin.angular_velocity.cross(spin.inertia_times(spin.angular_velocity));
    // ω' = ω + Δt I⁻¹(−ω×Iω)
    spin.angular_velocity -= h * spin.inverse_inertia_times(gyroscopic);
    // Turning about ω' itself leaves ω' where it is in the body: this is Euler's equation in body axes, step by step.
    spin.rotation = turned(spin.rotation, spin.angular_velocity, h);
    spin.angular_momentum = spin.inertia_times(spin.angular_velocity);
}
