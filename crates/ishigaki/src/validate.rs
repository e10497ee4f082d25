//! The laws that hold between the parts of a world: every slot that is named exists, lists are sorted.
//!
//! Editing keeps them; bytes from elsewhere may break them, and then a step would look where nothing is.

use crate::body::{BodyKind, BodyState, ShapeState};
use crate::collision::manifold::Contact;
use crate::collision::pair::Pair;
use crate::error::{Error, Result, finite_vector, not_negative, positive};
use crate::math::{Pose, Quat};
use crate::shape::Geometry;
use crate::world::{JointState, World};

impl World {
    /// Checks that the state is one that `step` can go on from: numbers in their ranges, references to what exists.
    ///
    /// A world that was built by its methods always passes; [`restore`](Self::restore) asks it of what it has read.
    ///
    /// # Errors
    /// The first contradiction, with its place.
    pub fn validate(&self) -> Result<()> {
        self.options.validate().map_err(|e| e.within("options"))?;
        self.bodies.validate().map_err(|e| e.within("bodies"))?;
        self.shapes.validate().map_err(|e| e.within("shapes"))?;
        self.joints.validate().map_err(|e| e.within("joints"))?;
        for (index, body) in self.bodies.iter() {
            self.check_body(index, body).map_err(|e| e.within(&format!("bodies[{index}]")))?;
        }
        for (slot, shape) in self.shapes.iter() {
            self.check_shape(slot, shape).map_err(|e| e.within(&format!("shapes[{slot}]")))?;
        }
        for (slot, joint) in self.joints.iter() {
            self.check_joint(joint).map_err(|e| e.within(&format!("joints[{slot}]")))?;
        }
        for (i, pair) in self.pairs.iter().enumerate() {
            self.check_pair(pair).map_err(|e| e.within(&format!("pairs[{i}]")))?;
        }
        for (i, contact) in self.contacts.iter().enumerate() {
            self.check_contact(contact).map_err(|e| e.within(&format!("contacts[{i}]")))?;
        }
        sorted("pairs", self.pairs.iter().map(Pair::key))?;
        sorted("contacts", self.contacts.iter().map(Contact::key))?;
        sorted("excluded", self.excluded.iter().copied())?;
        sorted("jointed", self.jointed.iter().copied())?;
        not_negative("last_substep", self.last_substep)?;
        Ok(())
    }

    fn check_body(&self, index: u32, body: &BodyState) -> Result<()> {
        rotation("mass.principal_frame", body.mass.principal_frame)?;
        if body.kind == BodyKind::Dynamic {
            body.mass.validate().map_err(|e| e.within("mass"))?;
        }
        not_negative("inverse_mass", body.inverse_mass)?;
        for (i, inverse) in body.inverse_principal_inertia.to_array().into_iter().enumerate() {
            not_negative(&format!("inverse_principal_inertia[{i}]"), inverse)?;
        }
        // A body that ran away stays as it is; all others turn by rotations.
        if body.rotation.is_finite() {
            rotation("rotation", body.rotation)?;
        }
        if let Some(target) = &body.kinematic_target {
            finite_pose("kinematic_target", target)?;
        }
        if !body.gravity_scale.is_finite() {
            return Err(Error::invalid("gravity_scale", "must be finite"));
        }
        not_negative("linear_damping", body.linear_damping)?;
        not_negative("angular_damping", body.angular_damping)?;
        for (ordinal, &slot) in body.shapes.iter().enumerate() {
            let own = self.shapes.in_use(slot).is_some_and(|s| s.body == index && s.ordinal as usize == ordinal);
            if !own {
                return Err(Error::invalid(format!("shapes[{ordinal}]"), format!("slot {slot} is not its shape")));
            }
        }
        Ok(())
    }

    fn check_shape(&self, slot: u32, shape: &ShapeState) -> Result<()> {
        let body = self.bodies.in_use(shape.body);
        if body.and_then(|b| b.shapes.get(shape.ordinal as usize)) != Some(&slot) {
            return Err(Error::invalid("body", format!("body {} does not have it", shape.body)));
        }
        if matches!(shape.shape.geometry, Geometry::Compound(_)) {
            return Err(Error::invalid("geometry", "a compound is laid out flat in a world"));
        }
        shape.shape.validate()?;
        finite_vector("offset", shape.offset)?;
        not_negative("inner_radius", shape.inner_radius)?;
        if shape.bounds_min.cmpgt(shape.bounds_max).any() {
            return Err(Error::invalid("bounds", "the least corner is beyond the greatest"));
        }
        Ok(())
    }

    fn check_joint(&self, joint: &JointState) -> Result<()> {
        joint.definition.validate()?;
        for (place, handle) in [("body_a", joint.definition.body_a), ("body_b", joint.definition.body_b)] {
            self.bodies.get(handle.into()).ok_or_else(|| Error::Stale { place: place.into() })?;
        }
        let resolved = &joint.resolved;
        for (place, anchor, frame) in
            [("a", resolved.anchor_a, resolved.frame_a), ("b", resolved.anchor_b, resolved.frame_b)]
        {
            finite_pose(place, &Pose::from_parts(anchor, frame))?;
        }
        let rows = resolved.row_count(&joint.definition.kind);
        if joint.lambdas.len() != rows {
            let message = format!("has {} impulses for {rows} rows", joint.lambdas.len());
            return Err(Error::invalid("lambdas", message));
        }
        Ok(())
    }

    fn check_pair(&self, pair: &Pair) -> Result<()> {
        let [a, b] = [pair.shape_a, pair.shape_b].map(|slot| self.shapes.in_use(slot).map(|shape| shape.body));
        if a.is_none() || b.is_none() || a == b {
            return Err(Error::invalid("shape_b", "must be of another body than shape_a, and both must exist"));
        }
        Ok(())
    }

    fn check_contact(&self, contact: &Contact) -> Result<()> {
        if !contact.is_empty() && !self.pairs.contains(contact.key()) {
            return Err(Error::invalid("shape_a", "is of no pair"));
        }
        for (place, slot, body) in
            [("shape_a", contact.shape_a, contact.body_a), ("shape_b", contact.shape_b, contact.body_b)]
        {
            let fits = self.bodies.in_use(body).is_some() && self.shapes.in_use(slot).is_some_and(|s| s.body == body);
            if !fits {
                return Err(Error::invalid(place, format!("slot {slot} is not a shape of body {body}")));
            }
        }
        if contact.shape_a >= contact.shape_b || contact.body_a == contact.body_b {
            return Err(Error::invalid("shape_b", "must come after shape_a, on another body"));
        }
        not_negative("friction", contact.friction)?;
        let extras = contact.extras();
        not_negative("torsional_friction", extras.torsional_friction)?;
        not_negative("rolling_friction", extras.rolling_friction)?;
        not_negative("restitution", extras.restitution)?;
        for (i, manifold) in contact.manifolds.iter().enumerate() {
            if manifold.points.is_empty() {
                return Err(Error::invalid(format!("manifolds[{i}]"), "has no points"));
            }
            if manifold.normal.is_finite() {
                positive(&format!("manifolds[{i}].normal"), manifold.normal.length())?;
            }
        }
        Ok(())
    }
}

/// Each key once, in order, its first part the smaller.
fn sorted(place: &str, keys: impl Iterator<Item = (u32, u32)>) -> Result<()> {
    let mut last = None;
    for (i, key) in keys.enumerate() {
        if key.0 >= key.1 || last.is_some_and(|last| last >= key) {
            return Err(Error::invalid(format!("{place}[{i}]"), "out of order"));
        }
        last = Some(key);
    }
    Ok(())
}

fn rotation(place: &str, value: Quat) -> Result<()> {
    let length = value.length();
    if length.is_finite() && (length - 1.0).abs() < 1e-3 {
        Ok(())
    } else {
        Err(Error::invalid(place, format!("must be a unit quaternion, has length {length}")))
    }
}

fn finite_pose(place: &str, pose: &Pose) -> Result<()> {
    rotation(place, pose.rotation)?;
    crate::error::finite_vector(place, pose.translation).map(|_| ())
}
