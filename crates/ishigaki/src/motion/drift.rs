//! How far a body moves in a substep: symplectic Euler, or the trapezoid of the two velocities. TALK A1.
//!
//! Δv = h(F/m + g) ; v' = v + Δv ; x' = x + h v' (symplectic) or x' = x + h(v' − ½Δv) = x + h(v + v')/2 (trapezoidal).
//! m/s and s in, m out. Symplectic Euler falls on ½v² + gy − ½ghv = const: ½v² + gy swings by ½gh|v|, a ball at 10 m/s
//! by 0.05 % at 1 ms, and a fall is too long by ght/2. The trapezoid is exact for constant forces, whatever h is.
//! It is meant for bodies that no row pushes in the substep: what rests has v' = 0 by the impulse of its support,
//! and half of gravity taken back would lift it. For it, restitution reflects the velocity before the forces, which
//! then act on: a bounce at e = 1 keeps ½v² + gy too.
//!
//! Off by default. Option: `MotionOptions::drift`; proved by `tests/laws_drift.rs`: the fall to rounding, the
//! energy of a hundred bounces, a resting block that stays where it is.

use crate::math::Vec3;
use crate::options::DriftScheme;

// ANCHOR: displacement
/// How far a body moves in `h` seconds with v' = `velocity`; `forced` is Δv, `pushed` says that a row pushes it.
#[inline]
pub fn displacement(scheme: DriftScheme, velocity: Vec3, forced: Vec3, pushed: bool, h: f32) -> Vec3 {
    match scheme {
        DriftScheme::Trapezoidal if !pushed => h * (velocity - 0.5 * forced),
        _ => h * velocity,
    }
}
// ANCHOR_END: displacement
