//! Mass, center and inertia of shapes and bodies. TALK A4.

use crate::error::{Error, Result, finite_vector, positive};
use crate::math::{Quat, Vec3};
use crate::shape::Shape;
use serde::{Deserialize, Serialize};

/// Mass, center of mass and inertia about it, in the body's frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MassProperties {
    /// kg.
    pub mass: f32,
    /// Center of mass, m.
    pub center: Vec3,
    /// About the principal axes through the center, kg·m².
    pub principal_inertia: Vec3,
    /// local_from_principal: the principal axes in the body's frame.
    pub principal_frame: Quat,
}

impl MassProperties {
    /// Of several shapes with their densities; sensors have none.
    pub fn of_shapes(_shapes: &[Shape]) -> Self {
        todo!()
    }

    /// The same body with another mass: the inertia scales along.
    #[must_use]
    pub fn with_mass(self, mass: f32) -> Self {
        let scale = if self.mass > 0.0 { mass / self.mass } else { 0.0 };
        Self { mass, principal_inertia: self.principal_inertia * scale, ..self }
    }

    /// Refuses numbers that make no sense; names the field.
    ///
    /// # Errors
    /// A mass or inertia ≤ 0 or not finite, an inertia that breaks the triangle inequality, a frame that is not a rotation.
    pub fn validate(&self) -> Result<()> {
        positive("mass", self.mass)?;
        finite_vector("center", self.center)?;
        let i = self.principal_inertia;
        positive("principal_inertia[0]", i.x)?;
        positive("principal_inertia[1]", i.y)?;
        positive("principal_inertia[2]", i.z)?;
        let greatest = i.max_element();
        // Models are rounded to few digits: allow one percent.
        if 2.0 * greatest > 1.01 * (i.x + i.y + i.z) {
            let message = format!(
                "no body has the moments ({}, {}, {}): one is greater than the sum of the others",
                i.x, i.y, i.z
            );
            return Err(Error::invalid("principal_inertia", message));
        }
        let length = self.principal_frame.length();
        if !(length.is_finite() && (length - 1.0).abs() < 1e-3) {
            return Err(Error::invalid("principal_frame", format!("must be a unit quaternion, has length {length}")));
        }
        Ok(())
    }
}
