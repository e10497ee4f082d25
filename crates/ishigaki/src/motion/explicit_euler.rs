//! Euler's equation integrated explicitly in ω: the talk's warning. TALK A5, A6.
//!
//! R' = R + Δt `[ω]ₓ`R, its columns made orthonormal one after the other ; I' = R' I_body R'ᵀ ;
//! ω' = ω + Δt I'⁻¹(τ − ω×I'ω). World frame, rad/s, N·m, s; τ is added by `forces`.
//! ω is the state: L = I'ω' follows, is not kept, and each step adds energy. A body of (1, 2, 3) kg·m² at 10 rad/s
//! has 1.2e6 times its energy after 10 s at 60 Hz. With an exact rotation in place of the slide's R it has 3.7
//! times, and blows up after 19 s: the fault is in ω, the coarse R only hastens it.
//!
//! Kept so that it can be seen and measured. Switched by `MotionOptions::rotation = RotationScheme::ExplicitEuler`.
//! Proved by `tests/motion_laws.rs`: both growths.

use super::Spin;
use super::angular_momentum::{Orthonormalization, orthonormalized, turned_matrix};
use crate::math::{Mat3, Quat};

// ANCHOR: advance
/// Turns a free body over `h` seconds; ω gains energy, L follows.
pub fn advance(spin: &mut Spin, h: f32) {
    let omega = spin.angular_velocity;
    let r = turned_matrix(Mat3::from_quat(spin.rotation), omega, h);
    spin.rotation = Quat::from_mat3(&orthonormalized(Orthonormalization::GramSchmidt, r)).normalize();
    // ω' = ω + Δt I'⁻¹(−ω×I'ω)
    let gyroscopic = omega.cross(spin.inertia_times(omega));
    spin.angular_velocity = omega - h * spin.inverse_inertia_times(gyroscopic);
    spin.angular_momentum = spin.inertia_times(spin.angular_velocity);
}
// ANCHOR_END: advance
