//! Editing a body: poses, velocities, forces, impulses. TALK A3, B2.

use crate::body::{BodyKind, BodyState};
use crate::error::{Error, Result, finite, finite_vector, not_negative};
use crate::math::{Pose, Vec3};
use crate::shape::{HUGE_LENGTH, Material};
use crate::world::BodyMut;

impl BodyMut<'_> {
    /// The state as it is.
    pub fn state(&self) -> &BodyState {
        self.body
    }

    /// Moves the origin there at once; the velocity stays.
    ///
    /// # Errors
    /// A pose that is not finite or whose rotation is not a unit quaternion; nothing changes.
    pub fn set_pose(&mut self, pose: Pose) -> Result<()> {
        let pose = checked_pose(pose)?;
        self.body.rotation = pose.rotation;
        self.body.center = pose.translation + pose.rotation * self.body.mass.center;
        self.body.previous_pose = pose;
        // ω stays, so L turns with the body.
        let angular_velocity = self.body.angular_velocity;
        self.put_angular_velocity(angular_velocity);
        for &slot in &self.body.shapes {
            let shape = self.shapes.at_mut(slot);
            shape.moved = true;
            // Queries find it there at once; the next step fattens the bounds and looks for pairs.
            (shape.bounds_min, shape.bounds_max) = shape.tight_bounds(self.body);
            self.broad_phase.update(slot, shape.bounds_min, shape.bounds_max);
        }
        Ok(())
    }

    /// Of the center of mass, m/s. Fixed bodies do not move whatever it says.
    ///
    /// # Errors
    /// Not finite; nothing changes.
    pub fn set_velocity(&mut self, velocity: Vec3) -> Result<()> {
        finite_vector("velocity", velocity)?;
        if self.body.kind != BodyKind::Fixed {
            self.body.velocity = velocity;
            self.leave_target();
        }
        Ok(())
    }

    /// World, rad/s.
    ///
    /// # Errors
    /// Not finite; nothing changes.
    pub fn set_angular_velocity(&mut self, angular_velocity: Vec3) -> Result<()> {
        finite_vector("angular_velocity", angular_velocity)?;
        if self.body.kind != BodyKind::Fixed {
            self.put_angular_velocity(angular_velocity);
            self.leave_target();
        }
        Ok(())
    }

    /// A velocity given by hand lasts: it does not end with the step as that toward a target does.
    fn leave_target(&mut self) {
        (self.body.target_driven, self.body.kinematic_target) = (false, None);
    }

    fn put_angular_velocity(&mut self, angular_velocity: Vec3) {
        self.body.angular_velocity = angular_velocity;
        self.body.angular_momentum = self.body.inertia_world() * angular_velocity;
    }

    /// Where a kinematic body shall be at the end of the next step: it gets the velocity that takes it there,
    /// and stops afterwards unless it is given another target.
    ///
    /// # Errors
    /// A pose that is not finite, or a body that is not kinematic; nothing changes.
    pub fn set_kinematic_target(&mut self, pose: Pose) -> Result<()> {
        let pose = checked_pose(pose)?;
        if self.body.kind != BodyKind::Kinematic {
            return Err(Error::invalid(
                "kinematic_target",
                "only a kinematic body has a target: use set_pose or forces",
            ));
        }
        self.body.kinematic_target = Some(Box::new(pose));
        Ok(())
    }

    /// A force at the center of mass during the next step, N. TALK A3.
    ///
    /// # Errors
    /// Not finite; nothing changes. The same for all forces, torques and impulses.
    pub fn apply_force(&mut self, force: Vec3) -> Result<()> {
        self.body.force += finite_vector("force", force)?;
        Ok(())
    }

    /// A force at a world point during the next step, N: torque r × F. TALK A3.
    ///
    /// # Errors
    /// Not finite; nothing changes.
    pub fn apply_force_at(&mut self, force: Vec3, point: Vec3) -> Result<()> {
        finite_vector("force", force)?;
        finite_vector("point", point)?;
        let torque = finite_vector("torque", (point - self.body.center).cross(force))?;
        self.body.force += force;
        self.body.torque += torque;
        Ok(())
    }

    /// A torque during the next step, N·m.
    ///
    /// # Errors
    /// Not finite; nothing changes.
    pub fn apply_torque(&mut self, torque: Vec3) -> Result<()> {
        self.body.torque += finite_vector("torque", torque)?;
        Ok(())
    }

    /// An impulse at the center of mass, now, N·s.
    ///
    /// # Errors
    /// Not finite; nothing changes.
    pub fn apply_impulse(&mut self, impulse: Vec3) -> Result<()> {
        finite_vector("impulse", impulse)?;
        self.body.velocity += self.body.inverse_mass_by_axis() * impulse;
        Ok(())
    }

    /// An impulse at a world point, now, N·s.
    ///
    /// # Errors
    /// Not finite; nothing changes.
    pub fn apply_impulse_at(&mut self, impulse: Vec3, point: Vec3) -> Result<()> {
        finite_vector("impulse", impulse)?;
        finite_vector("point", point)?;
        let angular = finite_vector("angular_impulse", (point - self.body.center).cross(impulse))?;
        self.apply_impulse(impulse)?;
        self.apply_angular_impulse(angular)
    }

    /// An angular impulse, now, N·m·s.
    ///
    /// # Errors
    /// Not finite; nothing changes.
    pub fn apply_angular_impulse(&mut self, impulse: Vec3) -> Result<()> {
        finite_vector("impulse", impulse)?;
        if self.body.kind == BodyKind::Dynamic {
            self.body.angular_momentum += impulse;
            self.body.angular_velocity += self.body.inverse_inertia_world() * impulse;
        }
        Ok(())
    }

    /// Multiplies gravity.
    ///
    /// # Errors
    /// Not finite; nothing changes.
    pub fn set_gravity_scale(&mut self, scale: f32) -> Result<()> {
        self.body.gravity_scale = finite("gravity_scale", scale)?;
        Ok(())
    }

    /// Decay of velocity and angular velocity, 1/s.
    ///
    /// # Errors
    /// Negative or not finite; nothing changes.
    pub fn set_damping(&mut self, linear: f32, angular: f32) -> Result<()> {
        let angular = not_negative("angular_damping", angular)?;
        self.body.linear_damping = not_negative("linear_damping", linear)?;
        self.body.angular_damping = angular;
        Ok(())
    }

    /// Material of one of its shapes, from the next step on; `false` if there is no such shape.
    ///
    /// # Errors
    /// A number out of its range; nothing changes.
    pub fn set_material(&mut self, ordinal: u32, material: Material) -> Result<bool> {
        material.validate()?;
        let Some(&slot) = self.body.shapes.get(ordinal as usize) else { return Ok(false) };
        self.shapes.at_mut(slot).shape.material = material;
        Ok(true)
    }

    /// Puts the body to sleep until something wakes it; only whole islands stay asleep.
    pub fn sleep(&mut self) {
        if self.body.is_dynamic() && self.body.can_sleep {
            self.body.put_to_sleep();
        }
    }
}

fn checked_pose(pose: Pose) -> Result<Pose> {
    finite_vector("pose.position", pose.translation)?;
    if pose.translation.abs().max_element() > HUGE_LENGTH {
        return Err(Error::invalid("pose.position", format!("must be within {HUGE_LENGTH} m of the origin")));
    }
    let length = pose.rotation.length();
    if length.is_finite() && (length - 1.0).abs() < 1e-3 {
        Ok(Pose::from_parts(pose.translation, pose.rotation.normalize()))
    } else {
        Err(Error::invalid("pose.rotation", format!("must be a unit quaternion, has length {length}")))
    }
}
