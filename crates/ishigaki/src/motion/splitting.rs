//! Rotation by symmetric splitting: the default. TALK A7.
//!
//! L is kept in world and never touched. Its energy ½ Σ L_a²/I_a (L_b = RᵀL, body axes a) is split into three
//! terms; each alone turns the body about one of its axes at a constant rate, which is solved exactly:
//! R ← R·exp(τ (L_b)_a/I_a e_a). Five such turns, a = x½ y½ z y½ x½ (Strang), make a symplectic, reversible
//! scheme of second order: |L| exact, energy error bounded for all times, any angle per step allowed.
//!
//! Without it: integrating ω blows up (`explicit_euler`), the talk's first-order R drifts in energy
//! (`angular_momentum`), implicit gyroscopic terms damp the motion.
//! Switched by `MotionOptions::rotation = RotationScheme::Splitting`.
//! Proved by `tests/motion_laws.rs`: Dzhanibekov's flips against 2K(k)/ω_p with order 2, energy within 2e-4.

use super::{Spin, renormalized, sine_cosine, turned};
use crate::math::{Quat, Vec3};

/// Turns a free body over `h` seconds; L stays, ω follows.
pub fn advance(spin: &mut Spin, h: f32) {
    let inverse = spin.inverse_principal_inertia;
    if inverse.x == inverse.y && inverse.y == inverse.z {
        // Every axis is a principal one: ω is constant and parallel to L.
        spin.angular_velocity = spin.angular_momentum * inverse.x;
        spin.rotation = turned(spin.rotation, spin.angular_velocity, h);
        return;
    }
    let axes = spin.world_from_principal();
    let mut momentum = (axes.conjugate() * spin.angular_momentum).to_array();
    let mut turn = Quat::IDENTITY.to_array();
    turn_about::<0>(&mut turn, &mut momentum, 0.5 * h * inverse.x);
    turn_about::<1>(&mut turn, &mut momentum, 0.5 * h * inverse.y);
    turn_about::<2>(&mut turn, &mut momentum, h * inverse.z);
    turn_about::<1>(&mut turn, &mut momentum, 0.5 * h * inverse.y);
    turn_about::<0>(&mut turn, &mut momentum, 0.5 * h * inverse.x);

    let axes = axes * Quat::from_array(turn);
    spin.rotation = renormalized(axes * spin.principal_frame.conjugate());
    // ω = I⁻¹L
    spin.angular_velocity = axes * (inverse * Vec3::from_array(momentum));
}

/// q ← q·exp(θ e_a) and L_b ← exp(−θ e_a) L_b with θ = (τ/I_a) (L_b)_a.
fn turn_about<const A: usize>(turn: &mut [f32; 4], momentum: &mut [f32; 3], tau_by_inertia: f32) {
    const W: usize = 3;
    let (a, b, c) = (A, (A + 1) % 3, (A + 2) % 3);
    let (sine, cosine) = sine_cosine(0.5 * tau_by_inertia * momentum[a]);
    // From half the angle to the whole one.
    let (sine_whole, cosine_whole) = (2.0 * sine * cosine, 1.0 - 2.0 * sine * sine);
    let (mb, mc) = (momentum[b], momentum[c]);
    momentum[b] = cosine_whole * mb + sine_whole * mc;
    momentum[c] = cosine_whole * mc - sine_whole * mb;
    let q = *turn;
    turn[a] = cosine * q[a] + sine * q[W];
    turn[b] = cosine * q[b] + sine * q[c];
    turn[c] = cosine * q[c] - sine * q[b];
    turn[W] = cosine * q[W] - sine * q[a];
}
