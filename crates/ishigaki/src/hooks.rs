//! What a step can be given besides Δt: a clock for timings, and a say in contacts.

use crate::body::{BodyState, ShapeId};
use crate::collision::manifold::{Contact, SurfaceExtras};
use crate::math::Vec3;

/// The two shapes of a contact and the bodies they are on.
#[derive(Clone, Copy, Debug)]
pub struct PairView<'a> {
    /// First shape.
    pub a: ShapeId,
    /// Second shape.
    pub b: ShapeId,
    /// Body of the first shape.
    pub body_a: &'a BodyState,
    /// Body of the second shape.
    pub body_b: &'a BodyState,
}

/// Filters and changes contacts before they are solved; called in the order of pairs for pairs with points.
///
/// What it does must depend on the world and its own state alone, or the run is not reproducible.
pub trait ContactHooks {
    /// `false` drops the contact for this step (a one-way platform looks at `contact.manifolds()` in [`modify`](Self::modify) instead).
    fn allow(&mut self, _pair: &PairView<'_>) -> bool {
        true
    }

    /// Changes friction, restitution or surface velocity, or drops manifolds.
    fn modify(&mut self, _pair: &PairView<'_>, _contact: &mut Contact) {}
}

/// What a step can be given besides Δt.
#[derive(Default)]
pub struct StepContext<'a> {
    /// Seconds on any clock; the engine reads none itself.
    pub clock: Option<&'a mut dyn FnMut() -> f64>,
    /// A say in contacts.
    pub hooks: Option<&'a mut dyn ContactHooks>,
}

impl std::fmt::Debug for StepContext<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("StepContext")
            .field("clock", &self.clock.is_some())
            .field("hooks", &self.hooks.is_some())
            .finish()
    }
}

impl Contact {
    /// Coulomb's μ of the pair.
    pub fn friction(&self) -> f32 {
        self.friction
    }

    /// Sets Coulomb's μ for this step; a number that is not finite and ≥ 0 is ignored.
    pub fn set_friction(&mut self, friction: f32) {
        if friction.is_finite() && friction >= 0.0 {
            self.friction = friction;
        }
    }

    /// Sets Newton's e for this step; a number outside [0, 1] is ignored.
    pub fn set_restitution(&mut self, restitution: f32) {
        if (0.0..=1.0).contains(&restitution) {
            self.set_extras(SurfaceExtras { restitution, ..self.extras() });
        }
    }

    /// Sets the velocity of B's surface relative to A's, world, m/s, for this step; ignored if not finite.
    pub fn set_surface_velocity(&mut self, velocity: Vec3) {
        if velocity.is_finite() {
            self.set_extras(SurfaceExtras { surface_velocity: velocity, ..self.extras() });
        }
    }

    /// Drops all points for this step: the bodies pass through each other.
    pub fn drop_points(&mut self) {
        self.manifolds.clear();
        self.frozen = false;
    }
}
