//! Bodies in a scene file.

use super::shape::{GeometryFile, ShapeFile, Shared};
use super::{finite_or_none, is_default, is_false, is_one, is_true, is_zero};
use ishigaki::{Body, BodyKind, MassProperties, MassSource, Pose, Quat, Vec3};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};

/// A body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct BodyFile {
    /// For joints and people; default `body3` for the fourth.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// What moves it; default dynamic.
    #[serde(skip_serializing_if = "is_dynamic")]
    #[schemars(schema_with = "kind_schema")]
    pub kind: BodyKind,
    /// Place of its origin in the world, m.
    #[serde(skip_serializing_if = "is_default")]
    #[schemars(with = "[f32; 3]")]
    pub position: Vec3,
    /// Orientation, a unit quaternion [x, y, z, w].
    #[serde(skip_serializing_if = "is_default")]
    #[schemars(with = "[f32; 4]")]
    pub rotation: Quat,
    /// Of the center of mass, m/s.
    #[serde(skip_serializing_if = "is_default")]
    #[schemars(with = "[f32; 3]")]
    pub velocity: Vec3,
    /// rad/s, world.
    #[serde(skip_serializing_if = "is_default")]
    #[schemars(with = "[f32; 3]")]
    pub angular_velocity: Vec3,
    /// Its form; may be empty if the mass properties are given.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub shapes: Vec<ShapeFile>,
    /// Where its mass comes from; default: the shapes and their densities.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass: Option<MassFile>,
    /// Multiplies gravity; default 1.
    #[serde(skip_serializing_if = "is_one")]
    pub gravity_scale: f32,
    /// Velocity decays as e^(−damping·t), 1/s.
    #[serde(skip_serializing_if = "is_zero")]
    pub linear_damping: f32,
    /// Angular velocity decays as e^(−damping·t), 1/s.
    #[serde(skip_serializing_if = "is_zero")]
    pub angular_damping: f32,
    /// World axes along which it cannot move.
    #[serde(skip_serializing_if = "is_default")]
    pub locked_translation: [bool; 3],
    /// World axes about which it cannot turn.
    #[serde(skip_serializing_if = "is_default")]
    pub locked_rotation: [bool; 3],
    /// Swept when fast, so that it cannot pass through anything.
    #[serde(skip_serializing_if = "is_false")]
    pub continuous: bool,
    /// May fall asleep; default true.
    #[serde(skip_serializing_if = "is_true")]
    pub can_sleep: bool,
    /// Contacts of this body that carry more than this are reported as events, N.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "finite_or_none")]
    pub force_threshold: Option<f32>,
}

/// Where the mass of a body comes from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum MassFile {
    /// One density for all its shapes, kg/m³.
    Density(f32),
    /// The mass of the body, kg; the inertia follows from the shapes' form.
    Total(f32),
    /// Mass, center and inertia as given.
    Properties(MassPropertiesFile),
}

/// Mass, center of mass and inertia about it, in the body's frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MassPropertiesFile {
    /// kg.
    pub mass: f32,
    /// Center of mass, m.
    #[serde(default, skip_serializing_if = "is_default")]
    #[schemars(with = "[f32; 3]")]
    pub center: Vec3,
    /// About the principal axes through the center, kg·m².
    #[schemars(with = "[f32; 3]")]
    pub principal_inertia: Vec3,
    /// The principal axes in the body's frame, a unit quaternion [x, y, z, w].
    #[serde(default, skip_serializing_if = "is_default")]
    #[schemars(with = "[f32; 4]")]
    pub principal_frame: Quat,
}

impl From<MassProperties> for MassPropertiesFile {
    fn from(p: MassProperties) -> Self {
        Self {
            mass: p.mass,
            center: p.center,
            principal_inertia: p.principal_inertia,
            principal_frame: p.principal_frame,
        }
    }
}

impl From<MassPropertiesFile> for MassProperties {
    fn from(p: MassPropertiesFile) -> Self {
        Self {
            mass: p.mass,
            center: p.center,
            principal_inertia: p.principal_inertia,
            principal_frame: p.principal_frame,
        }
    }
}

fn is_dynamic(kind: &BodyKind) -> bool {
    *kind == BodyKind::Dynamic
}

fn kind_schema(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "type": "string", "enum": ["fixed", "kinematic", "dynamic"] })
}

impl Default for BodyFile {
    fn default() -> Self {
        (&Body::empty(BodyKind::Dynamic)).into()
    }
}

impl From<&Body> for BodyFile {
    fn from(body: &Body) -> Self {
        Self {
            name: body.name.clone(),
            kind: body.kind,
            position: body.pose.translation,
            rotation: body.pose.rotation,
            velocity: body.velocity,
            angular_velocity: body.angular_velocity,
            shapes: body.shapes.iter().map(ShapeFile::from).collect(),
            mass: match body.mass {
                MassSource::Shapes => None,
                MassSource::Mass(mass) => Some(MassFile::Total(mass)),
                MassSource::Explicit(properties) => Some(MassFile::Properties(properties.into())),
            },
            gravity_scale: body.gravity_scale,
            linear_damping: body.linear_damping,
            angular_damping: body.angular_damping,
            locked_translation: body.locked_translation,
            locked_rotation: body.locked_rotation,
            continuous: body.continuous,
            can_sleep: body.can_sleep,
            force_threshold: None,
        }
    }
}

impl From<Body> for BodyFile {
    fn from(body: Body) -> Self {
        (&body).into()
    }
}

impl BodyFile {
    /// The engine's definition under a name; errors carry the place within the body.
    pub(super) fn build(&self, name: &str, shared: &Shared) -> ishigaki::Result<Body> {
        let mut shapes = Vec::with_capacity(self.shapes.len());
        for (i, shape) in self.shapes.iter().enumerate() {
            let place = format!("shapes[{i}]");
            let shape = match self.mass {
                Some(MassFile::Density(density)) => dense(shape, density).build(shared, 0),
                _ => shape.build(shared, 0),
            };
            shapes.push(shape.map_err(|e| e.within(&place))?);
        }
        Ok(Body {
            kind: self.kind,
            name: name.to_string(),
            pose: Pose::from_parts(self.position, self.rotation),
            velocity: self.velocity,
            angular_velocity: self.angular_velocity,
            shapes,
            mass: match self.mass {
                None | Some(MassFile::Density(_)) => MassSource::Shapes,
                Some(MassFile::Total(mass)) => MassSource::Mass(mass),
                Some(MassFile::Properties(properties)) => MassSource::Explicit(properties.into()),
            },
            gravity_scale: self.gravity_scale,
            linear_damping: self.linear_damping,
            angular_damping: self.angular_damping,
            locked_translation: self.locked_translation,
            locked_rotation: self.locked_rotation,
            continuous: self.continuous,
            can_sleep: self.can_sleep,
        })
    }
}

/// The shape with another density, in compounds too.
fn dense(shape: &ShapeFile, density: f32) -> ShapeFile {
    let mut shape = shape.clone();
    shape.density = density;
    if let GeometryFile::Compound { shapes } = &mut shape.geometry {
        for child in shapes {
            *child = dense(child, density);
        }
    }
    shape
}
