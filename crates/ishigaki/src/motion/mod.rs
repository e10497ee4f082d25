//! Free motion of one body: forces on velocities, the way from velocities, three schemes for the rotation. TALK A1–A7.
//!
//! Pure functions on plain values: they know no world, no option but the scheme, and no constraint.
//! Everything that moves a body's rotation goes through [`Spin`], and [`advance`] chooses the scheme.

pub mod angular_momentum;
pub mod drift;
pub mod explicit_euler;
pub mod forces;
pub mod splitting;

use crate::math::{Quat, Vec3, cos, sin};
use crate::options::RotationScheme;

/// The rotation of a body: R, L and ω with the inertia that ties them, L = R P diag(I) Pᵀ Rᵀ ω.
///
/// L is the state and ω follows from it, except under [`RotationScheme::ExplicitEuler`] and for bodies with
/// locked axes, where ω is the state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spin {
    /// R: world_from_local, unit.
    pub rotation: Quat,
    /// P: local_from_principal, unit.
    pub principal_frame: Quat,
    /// About the principal axes, kg·m².
    pub principal_inertia: Vec3,
    /// 1 / `principal_inertia`, or zero for bodies that nothing turns, 1/(kg·m²).
    pub inverse_principal_inertia: Vec3,
    /// L about the center of mass, world, kg·m²/s.
    pub angular_momentum: Vec3,
    /// ω, world, rad/s.
    pub angular_velocity: Vec3,
}

impl Spin {
    /// A body whose principal axes are its own, turning with ω (world, rad/s); moments > 0, kg·m².
    pub fn new(rotation: Quat, principal_inertia: Vec3, angular_velocity: Vec3) -> Self {
        let mut spin = Self {
            rotation,
            principal_frame: Quat::IDENTITY,
            principal_inertia,
            inverse_principal_inertia: principal_inertia.recip(),
            angular_momentum: Vec3::ZERO,
            angular_velocity,
        };
        spin.angular_momentum = spin.inertia_times(angular_velocity);
        spin
    }

    /// world_from_principal.
    pub fn world_from_principal(&self) -> Quat {
        self.rotation * self.principal_frame
    }

    /// Every axis is a principal one, as of balls and cubes: L is parallel to ω.
    pub fn is_isotropic(&self) -> bool {
        let inverse = self.inverse_principal_inertia;
        inverse.x == inverse.y && inverse.y == inverse.z
    }

    /// I v, world: L from ω.
    pub fn inertia_times(&self, v: Vec3) -> Vec3 {
        let axes = self.world_from_principal();
        axes * (self.principal_inertia * (axes.conjugate() * v))
    }

    /// I⁻¹ v, world: ω from L.
    pub fn inverse_inertia_times(&self, v: Vec3) -> Vec3 {
        if self.is_isotropic() {
            return v * self.inverse_principal_inertia.x;
        }
        let axes = self.world_from_principal();
        axes * (self.inverse_principal_inertia * (axes.conjugate() * v))
    }

    /// ½ ω·L, J.
    pub fn kinetic_energy(&self) -> f32 {
        0.5 * self.angular_velocity.dot(self.angular_momentum)
    }
}

/// Turns a body over `h` seconds without torque.
///
/// `locked` says that some of its axes cannot turn: ω is then kept as it is, whatever the scheme, and L
/// follows. What is not finite stays so.
pub fn advance(scheme: RotationScheme, spin: &mut Spin, locked: bool, h: f32) {
    if locked {
        spin.rotation = turned(spin.rotation, spin.angular_velocity, h);
        spin.angular_momentum = spin.inertia_times(spin.angular_velocity);
        return;
    }
    match scheme {
        RotationScheme::Splitting => splitting::advance(spin, h),
        RotationScheme::AngularMomentum => angular_momentum::advance(spin, h),
        RotationScheme::ExplicitEuler => explicit_euler::advance(spin, h),
    }
}

/// exp(h `[ω]ₓ`) R: the rotation after `h` seconds of constant ω (world, rad/s).
pub fn turned(rotation: Quat, angular_velocity: Vec3, h: f32) -> Quat {
    let half = angular_velocity * (0.5 * h);
    let square = half.length_squared();
    let (sine_by_angle, versine) = if square < SERIES_LIMIT * SERIES_LIMIT {
        (sine_series(square), versine_series(square))
    } else {
        let angle = square.sqrt();
        (sin(angle) / angle, 1.0 - cos(angle))
    };
    let xyz = half * sine_by_angle;
    changed(rotation, Quat::from_xyzw(xyz.x, xyz.y, xyz.z, -versine) * rotation)
}

/// R + change, with one Newton step toward unit length: an error ε becomes 3ε²/2.
///
/// A turn is passed as its difference from no turn, which small turns keep to all digits: the sum is then
/// rounded once, and a body at rest is not rounded at all.
fn changed(rotation: Quat, change: Quat) -> Quat {
    rotation + (change + rotation * (0.5 - 0.5 * rotation.length_squared()))
}

/// Below this angle (rad) a few terms of the series are exact to f32 rounding and cheaper than libm.
pub(crate) const SERIES_LIMIT: f32 = 0.5;

/// sin x and 1 − cos x.
fn sine_versine(x: f32) -> (f32, f32) {
    if x.abs() < SERIES_LIMIT {
        let square = x * x;
        (x * sine_series(square), versine_series(square))
    } else {
        (sin(x), 1.0 - cos(x))
    }
}

/// sin x / x from x² < ¼: 1 − x²/3! + x⁴/5! − x⁶/7!, error < 6e-9.
fn sine_series(square: f32) -> f32 {
    1.0 - square * (1.0 / 6.0) * (1.0 - square * (1.0 / 20.0) * (1.0 - square * (1.0 / 42.0)))
}

/// 1 − cos x from x² < ¼: x²/2! − x⁴/4! + x⁶/6! − x⁸/8!, error < 3e-10.
fn versine_series(square: f32) -> f32 {
    let inner = 1.0 - square * (1.0 / 30.0) * (1.0 - square * (1.0 / 56.0));
    0.5 * square * (1.0 - square * (1.0 / 12.0) * inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn series_meet_the_true_functions() {
        for i in -2000..=2000 {
            let x = 0.001 * i as f32;
            let (sine, versine) = sine_versine(x);
            assert!((f64::from(sine) - f64::from(x).sin()).abs() < 1e-7);
            assert!((f64::from(versine) - 1.0 + f64::from(x).cos()).abs() < 1e-7);
        }
    }
}
