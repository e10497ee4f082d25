//! Bodies: the definition a user writes here, the state the engine keeps in `body/state.rs`.

use crate::error::{Error, Result, finite_vector, not_negative, positive};
use crate::mass::MassProperties;
use crate::math::{Pose, Quat, Vec3};
use crate::shape::{Geometry, HUGE_LENGTH, Shape};
use serde::{Deserialize, Serialize};

mod role;
mod state;

pub(crate) use role::Role;
pub use state::{BodyState, NO_HEIGHT, ShapeId};
pub(crate) use state::{ShapeState, unlocked};

/// What moves a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BodyKind {
    /// Nothing.
    Fixed,
    /// Its user: it has a velocity, and infinite mass.
    Kinematic,
    /// Forces.
    Dynamic,
}

/// Where the mass of a body comes from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum MassSource {
    /// The shapes and their densities.
    Shapes,
    /// The shapes' form, scaled to this mass, kg.
    Mass(f32),
    /// As given.
    Explicit(MassProperties),
}

/// The definition of a body.
///
/// ```
/// use ishigaki::{Body, Shape, Vec3};
/// let brick = Body::dynamic(Shape::cuboid(0.1, 0.05, 0.05)).density(2000.0).at(Vec3::new(0.0, 1.0, 0.0));
/// assert_eq!(brick.shapes.len(), 1);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// What moves it.
    pub kind: BodyKind,
    /// For people; need not be unique.
    pub name: String,
    /// Place of its origin in the world.
    pub pose: Pose,
    /// Of the center of mass, m/s.
    pub velocity: Vec3,
    /// rad/s, world.
    pub angular_velocity: Vec3,
    /// Its form; may be empty if the mass is explicit.
    pub shapes: Vec<Shape>,
    /// Where its mass comes from.
    pub mass: MassSource,
    /// Multiplies gravity.
    pub gravity_scale: f32,
    /// Velocity decays as e^(−damping·t), 1/s.
    pub linear_damping: f32,
    /// Angular velocity decays as e^(−damping·t), 1/s.
    pub angular_damping: f32,
    /// World axes along which it cannot move.
    pub locked_translation: [bool; 3],
    /// World axes about which it cannot turn.
    pub locked_rotation: [bool; 3],
    /// Swept when fast, so that it cannot pass through anything.
    pub continuous: bool,
    /// May fall asleep.
    pub can_sleep: bool,
}

impl Body {
    /// A body of a kind with one shape, at the origin, at rest.
    pub fn new(kind: BodyKind, shape: Shape) -> Self {
        Self { shapes: vec![shape], ..Self::empty(kind) }
    }

    /// A body without a shape: a sensor rig, a pivot, a mass without form.
    pub fn empty(kind: BodyKind) -> Self {
        Self {
            kind,
            name: String::new(),
            pose: Pose::IDENTITY,
            velocity: Vec3::ZERO,
            angular_velocity: Vec3::ZERO,
            shapes: Vec::new(),
            mass: MassSource::Shapes,
            gravity_scale: 1.0,
            linear_damping: 0.0,
            angular_damping: 0.0,
            locked_translation: [false; 3],
            locked_rotation: [false; 3],
            continuous: false,
            can_sleep: true,
        }
    }

    /// A body that forces move.
    pub fn dynamic(shape: Shape) -> Self {
        Self::new(BodyKind::Dynamic, shape)
    }

    /// A body that nothing moves.
    pub fn fixed(shape: Shape) -> Self {
        Self::new(BodyKind::Fixed, shape)
    }

    /// A body that its user moves.
    pub fn kinematic(shape: Shape) -> Self {
        Self::new(BodyKind::Kinematic, shape)
    }

    /// One more shape.
    #[must_use]
    pub fn with(mut self, shape: Shape) -> Self {
        self.shapes.push(shape);
        self
    }

    /// For people; need not be unique.
    #[must_use]
    pub fn named(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// Place of the origin, m.
    #[must_use]
    pub fn at(mut self, translation: Vec3) -> Self {
        self.pose.translation = translation;
        self
    }

    /// Orientation, a unit quaternion.
    #[must_use]
    pub fn rotated(mut self, rotation: Quat) -> Self {
        self.pose.rotation = rotation;
        self
    }

    /// Place and orientation of the origin.
    #[must_use]
    pub fn posed(mut self, pose: Pose) -> Self {
        self.pose = pose;
        self
    }

    /// Density of all its shapes, kg/m³.
    #[must_use]
    pub fn density(mut self, density: f32) -> Self {
        for shape in &mut self.shapes {
            shape.density = density;
        }
        self
    }

    /// Mass in kg; the inertia follows from the shapes' form.
    #[must_use]
    pub fn mass(mut self, mass: f32) -> Self {
        self.mass = MassSource::Mass(mass);
        self
    }

    /// Mass, center and inertia as given.
    #[must_use]
    pub fn mass_properties(mut self, properties: MassProperties) -> Self {
        self.mass = MassSource::Explicit(properties);
        self
    }

    /// Of the center of mass, m/s.
    #[must_use]
    pub fn velocity(mut self, velocity: Vec3) -> Self {
        self.velocity = velocity;
        self
    }

    /// rad/s, world.
    #[must_use]
    pub fn angular_velocity(mut self, angular_velocity: Vec3) -> Self {
        self.angular_velocity = angular_velocity;
        self
    }

    /// Multiplies gravity.
    #[must_use]
    pub fn gravity_scale(mut self, scale: f32) -> Self {
        self.gravity_scale = scale;
        self
    }

    /// Decay of velocity and angular velocity, 1/s.
    #[must_use]
    pub fn damping(mut self, linear: f32, angular: f32) -> Self {
        self.linear_damping = linear;
        self.angular_damping = angular;
        self
    }

    /// World axes along which it cannot move.
    #[must_use]
    pub fn lock_translation(mut self, axes: [bool; 3]) -> Self {
        self.locked_translation = axes;
        self
    }

    /// World axes about which it cannot turn.
    #[must_use]
    pub fn lock_rotation(mut self, axes: [bool; 3]) -> Self {
        self.locked_rotation = axes;
        self
    }

    /// Swept when fast, so that it cannot pass through anything.
    #[must_use]
    pub fn continuous(mut self) -> Self {
        self.continuous = true;
        self
    }

    /// Never falls asleep.
    #[must_use]
    pub fn sleepless(mut self) -> Self {
        self.can_sleep = false;
        self
    }

    /// Friction of all its shapes.
    #[must_use]
    pub fn friction(mut self, friction: f32) -> Self {
        for shape in &mut self.shapes {
            shape.material.friction = friction;
        }
        self
    }

    /// Restitution of all its shapes.
    #[must_use]
    pub fn restitution(mut self, restitution: f32) -> Self {
        for shape in &mut self.shapes {
            shape.material.restitution = restitution;
        }
        self
    }

    /// Refuses definitions that make no sense; names the field.
    ///
    /// # Errors
    /// The first field that is not finite, out of its range, or does not fit the kind.
    pub fn validate(&self) -> Result<()> {
        finite_vector("position", self.pose.translation)?;
        if self.pose.translation.abs().max_element() > HUGE_LENGTH {
            return Err(Error::invalid("position", format!("must be within {HUGE_LENGTH} m of the origin")));
        }
        let length = self.pose.rotation.length();
        if !(length.is_finite() && (length - 1.0).abs() < 1e-3) {
            return Err(Error::invalid("rotation", format!("must be a unit quaternion, has length {length}")));
        }
        finite_vector("velocity", self.velocity)?;
        finite_vector("angular_velocity", self.angular_velocity)?;
        if !self.gravity_scale.is_finite() {
            return Err(Error::invalid("gravity_scale", format!("must be finite, is {}", self.gravity_scale)));
        }
        not_negative("linear_damping", self.linear_damping)?;
        not_negative("angular_damping", self.angular_damping)?;
        for (i, shape) in self.shapes.iter().enumerate() {
            let place = format!("shapes[{i}]");
            shape.validate().map_err(|e| e.within(&place))?;
            if self.kind == BodyKind::Dynamic && !shape.geometry.is_solid() {
                return Err(Error::invalid(
                    place,
                    "a half-space, triangle mesh or height field has no volume and cannot be dynamic: use a fixed or kinematic body, or convex hulls",
                ));
            }
        }
        match &self.mass {
            MassSource::Shapes => Ok(()),
            MassSource::Mass(mass) => positive("mass", *mass).map(|_| ()),
            MassSource::Explicit(properties) => properties.validate().map_err(|e| e.within("mass_properties")),
        }
    }

    /// The shapes with compounds laid out flat, in a fixed order.
    pub(crate) fn flat_shapes(&self) -> Vec<Shape> {
        let mut flat = Vec::with_capacity(self.shapes.len());
        for shape in &self.shapes {
            flatten(shape, &mut flat);
        }
        flat
    }
}

fn flatten(shape: &Shape, out: &mut Vec<Shape>) {
    if let Geometry::Compound(children) = &shape.geometry {
        for child in children {
            let mut child = child.clone();
            child.pose = shape.pose * child.pose;
            child.sensor |= shape.sensor;
            flatten(&child, out);
        }
    } else {
        out.push(shape.clone());
    }
}
