//! The talk's rotation in four steps. TALK A6.
//!
//! R' = R + Δt `[ω]ₓ`R ; I' = R' I_body R'ᵀ ; L' = L + Δt τ (see `forces`) ; ω' = I'⁻¹ L'.
//! Carrying L instead of ω keeps |L| by construction, and with it the energy in [L²/2I_max, L²/2I_min]:
//! it cannot blow up. R is of first order, so the energy drifts inside that range.
//!
//! R + Δt `[ω]ₓ`R is longer than a rotation by √(1 + Δt²ω²) across ω: it must be made orthonormal again, and how
//! decides which way the energy drifts. The engine takes the nearest rotation ([`Orthonormalization::Polar`]);
//! with [`Orthonormalization::None`] R itself grows without bound. Matrices are world_from_local, Δt in s, ω in
//! rad/s. Switched by `MotionOptions::rotation = RotationScheme::AngularMomentum`.
//! Proved by `tests/motion_laws.rs`: |L|, the range of the energy, the growth of R.

use super::Spin;
use crate::math::{Mat3, Quat, Vec3, skew};

/// How a matrix that is nearly a rotation is made one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Orthonormalization {
    /// Not at all: the experiment that shows why it is needed.
    None,
    /// The first column keeps its direction, the second its plane with the first.
    GramSchmidt,
    /// The nearest rotation (polar factor): no column is preferred.
    #[default]
    Polar,
}

// ANCHOR: advance
/// Turns a free body over `h` seconds; L stays, ω follows.
pub fn advance(spin: &mut Spin, h: f32) {
    let r = turned_matrix(Mat3::from_quat(spin.rotation), spin.angular_velocity, h);
    let r = orthonormalized(Orthonormalization::Polar, r);
    spin.rotation = Quat::from_mat3(&r).normalize();
    // ω' = I'⁻¹ L'
    spin.angular_velocity = spin.inverse_inertia_times(spin.angular_momentum);
}
// ANCHOR_END: advance

/// R + Δt `[ω]ₓ`R, as on the slide.
pub fn turned_matrix(r: Mat3, angular_velocity: Vec3, h: f32) -> Mat3 {
    r + h * (skew(angular_velocity) * r)
}

/// The matrix made orthonormal. Its columns must be independent; otherwise the result is not finite.
pub fn orthonormalized(how: Orthonormalization, r: Mat3) -> Mat3 {
    match how {
        Orthonormalization::None => r,
        Orthonormalization::GramSchmidt => gram_schmidt(r),
        Orthonormalization::Polar => polar(r),
    }
}

fn gram_schmidt(r: Mat3) -> Mat3 {
    let x = r.x_axis / r.x_axis.length();
    let y = r.y_axis - x * x.dot(r.y_axis);
    let y = y / y.length();
    Mat3::from_cols(x, y, x.cross(y))
}

/// Newton's iteration R ← (R + R⁻ᵀ)/2: every singular value σ goes to (σ + 1/σ)/2 and so to 1 (Higham 1986).
fn polar(mut r: Mat3) -> Mat3 {
    // Halves a great σ, then squares the error: enough for σ up to 1000, ten times a body at the speed limit.
    for _ in 0..16 {
        let next = 0.5 * (r + r.inverse().transpose());
        let change = next - r;
        r = next;
        let greatest = change.to_cols_array().iter().fold(0.0_f32, |m, x| m.max(x.abs()));
        if greatest < 1e-6 {
            break;
        }
    }
    r
}
