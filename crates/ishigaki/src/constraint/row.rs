//! One scalar constraint: a row of the table that every technique edits. TALK B5, B11, C3.
//!
//! With u the generalized velocities of two bodies, w = J u + bias must satisfy, with the impulse λ,
//! λ = lower ⇒ w ≥ 0; lower < λ < upper ⇒ w = 0; λ = upper ⇒ w ≤ 0.

use crate::math::Vec3;

/// J of one row: w = linear·(v_A − v_B) + angular_a·ω_A + angular_b·ω_B.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Jacobian {
    /// Direction in world; zero for pure rotations.
    pub linear: Vec3,
    /// r_A × linear for forces, the axis for torques.
    pub angular_a: Vec3,
    /// −r_B × linear for forces, the negative axis for torques.
    pub angular_b: Vec3,
}

// ANCHOR: jacobian
impl Jacobian {
    /// Velocity along `axis` of a point of A relative to a point of B; arms from the centers of mass. TALK B5.
    pub fn point(axis: Vec3, arm_a: Vec3, arm_b: Vec3) -> Self {
        Self { linear: axis, angular_a: arm_a.cross(axis), angular_b: -arm_b.cross(axis) }
    }

    /// Angular velocity of A relative to B about `axis`. TALK B8.
    pub fn rotation(axis: Vec3) -> Self {
        Self { linear: Vec3::ZERO, angular_a: axis, angular_b: -axis }
    }

    /// The same row with A and B's motion reversed: of B relative to A.
    #[must_use]
    pub fn negated(self) -> Self {
        Self { linear: -self.linear, angular_a: -self.angular_a, angular_b: -self.angular_b }
    }
}
// ANCHOR_END: jacobian

// ANCHOR: row_spec
/// What a constraint asks of one row in one substep, before masses come in.
///
/// w = J u + γλ + bias, with λ in [lower, upper].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowSpec {
    /// J.
    pub jacobian: Jacobian,
    /// γ ≥ 0, 1/kg (1/(kg·m²) for rotations): 0 for hard rows; an implicit spring otherwise.
    pub softness: f32,
    /// Wanted velocity with recovery of position errors, negated: J u = −bias; m/s or rad/s.
    pub bias: f32,
    /// The same without recovery: used by relax sweeps.
    pub relax_bias: f32,
    /// The part of `bias` that is no recovery: what the bodies' way along arcs will add to the error in this substep.
    pub arc: f32,
    /// Least impulse, N·s or N·m·s.
    pub lower: f32,
    /// Greatest impulse.
    pub upper: f32,
}
// ANCHOR_END: row_spec

impl RowSpec {
    /// A hard equality J u = −bias whose bias is recovery alone.
    pub fn equality(jacobian: Jacobian, recovery_bias: f32) -> Self {
        Self {
            jacobian,
            softness: 0.0,
            bias: recovery_bias,
            relax_bias: 0.0,
            arc: 0.0,
            lower: f32::NEG_INFINITY,
            upper: f32::INFINITY,
        }
    }

    /// The same, looking ahead along the arc of its bodies.
    #[must_use]
    pub fn along(self, arc: f32) -> Self {
        Self { bias: self.bias + arc, arc, ..self }
    }

    /// A row that does nothing: λ is held at 0. Keeps its place in the count where a condition has lost its meaning.
    pub fn inert(jacobian: Jacobian) -> Self {
        Self { jacobian, softness: 0.0, bias: 0.0, relax_bias: 0.0, arc: 0.0, lower: 0.0, upper: 0.0 }
    }
}
