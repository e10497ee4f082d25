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

use super::{Spin, changed, sine_versine, turned};
use crate::math::{Quat, Vec3};

/// Turns a free body over `h` seconds; L stays, ω follows.
pub fn advance(spin: &mut Spin, h: f32) {
    let inverse = spin.inverse_principal_inertia;
    if spin.is_isotropic() {
        // ω is constant.
        spin.angular_velocity = spin.angular_momentum * inverse.x;
        spin.rotation = turned(spin.rotation, spin.angular_velocity, h);
        return;
    }
    // ANCHOR: five_turns
    let axes = spin.world_from_principal();
    let mut momentum = (axes.conjugate() * spin.angular_momentum).to_array();
    let mut turn = [0.0; 4];
    turn_about::<0>(&mut turn, &mut momentum, 0.5 * h * inverse.x);
    turn_about::<1>(&mut turn, &mut momentum, 0.5 * h * inverse.y);
    turn_about::<2>(&mut turn, &mut momentum, h * inverse.z);
    turn_about::<1>(&mut turn, &mut momentum, 0.5 * h * inverse.y);
    turn_about::<0>(&mut turn, &mut momentum, 0.5 * h * inverse.x);
    // ANCHOR_END: five_turns

    // From principal to local axes: P exp(..) P⁻¹.
    let xyz = spin.principal_frame * Vec3::new(turn[0], turn[1], turn[2]);
    let change = Quat::from_xyzw(xyz.x, xyz.y, xyz.z, turn[W]);
    spin.rotation = changed(spin.rotation, spin.rotation * change);
    // ω = I⁻¹L
    spin.angular_velocity = spin.world_from_principal() * (inverse * Vec3::from_array(momentum));
}

/// Index of a quaternion's real part.
const W: usize = 3;

/// q ← q·exp(θ e_a) and L_b ← exp(−θ e_a) L_b with θ = (τ/I_a) (L_b)_a; `turn` is q − 1.
fn turn_about<const A: usize>(turn: &mut [f32; 4], momentum: &mut [f32; 3], tau_by_inertia: f32) {
    let (a, b, c) = (A, (A + 1) % 3, (A + 2) % 3);
    // Of half the angle; then sin θ = 2 sin cos, 1 − cos θ = 2 sin².
    let (sine, versine) = sine_versine(0.5 * tau_by_inertia * momentum[a]);
    let (sine_whole, versine_whole) = (2.0 * sine * (1.0 - versine), 2.0 * sine * sine);
    let (mb, mc) = (momentum[b], momentum[c]);
    momentum[b] = mb + (sine_whole * mc - versine_whole * mb);
    momentum[c] = mc - (sine_whole * mb + versine_whole * mc);
    let q = *turn;
    turn[a] = q[a] + (sine + sine * q[W] - versine * q[a]);
    turn[b] = q[b] + (sine * q[c] - versine * q[b]);
    turn[c] = q[c] - (sine * q[b] + versine * q[c]);
    turn[W] = q[W] - (versine + versine * q[W] + sine * q[a]);
}
