//! Shapes in a scene file.

use super::{is_default, is_false, is_zero};
use crate::error::{Result, SceneError};
use ishigaki::{Combine, ConvexHull, Geometry, Groups, HeightField, Material, Pose, Quat, Shape, TriangleMesh, Vec3};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Compounds in compounds, at most: deeper nesting is a mistake.
const MAX_DEPTH: usize = 16;

/// The form of a shape in its own frame; lengths in m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum GeometryFile {
    /// A ball about the origin.
    Ball {
        /// m.
        radius: f32,
    },
    /// A box about the origin, its edges along the axes.
    Cuboid {
        /// Half of each edge, m.
        #[schemars(with = "[f32; 3]")]
        half_extents: Vec3,
    },
    /// All points within `radius` of a segment along Y.
    Capsule {
        /// Half of the segment, m: the whole length is 2 (half_length + radius).
        half_length: f32,
        /// m.
        radius: f32,
    },
    /// A cylinder about Y.
    Cylinder {
        /// m.
        half_height: f32,
        /// m.
        radius: f32,
    },
    /// A cone about Y, apex at +half_height, base at −half_height.
    Cone {
        /// m.
        half_height: f32,
        /// Of the base, m.
        radius: f32,
    },
    /// All points with normal·x ≤ 0: fixed or kinematic bodies only.
    HalfSpace {
        /// Unit, outward; default up.
        #[serde(default = "up")]
        #[schemars(with = "[f32; 3]")]
        normal: Vec3,
    },
    /// The convex hull of points.
    ConvexHull(HullFile),
    /// A hull of the scene's `hulls`, by name.
    SharedHull(String),
    /// A surface of triangles: fixed or kinematic bodies only.
    TriangleMesh(MeshFile),
    /// A mesh of the scene's `meshes`, by name.
    SharedMesh(String),
    /// A terrain: fixed or kinematic bodies only.
    HeightField {
        /// Grid points along Z.
        rows: usize,
        /// Grid points along X.
        columns: usize,
        /// Row by row, m.
        heights: Vec<f32>,
        /// Extent along X, m.
        size_x: f32,
        /// Extent along Z, m.
        size_z: f32,
    },
    /// Several shapes that move as one.
    Compound {
        /// At least one.
        shapes: Vec<ShapeFile>,
    },
}

/// The convex hull of points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HullFile {
    /// At least four that span a volume, m.
    #[schemars(with = "Vec<[f32; 3]>")]
    pub points: Vec<Vec3>,
}

/// A surface of triangles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshFile {
    /// m.
    #[schemars(with = "Vec<[f32; 3]>")]
    pub vertices: Vec<Vec3>,
    /// Indices of vertices, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// A shape of a body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShapeFile {
    /// Form.
    pub geometry: GeometryFile,
    /// Place in the body's frame, m.
    #[serde(default, skip_serializing_if = "is_default")]
    #[schemars(with = "[f32; 3]")]
    pub position: Vec3,
    /// Orientation in the body's frame, a unit quaternion [x, y, z, w].
    #[serde(default, skip_serializing_if = "is_default")]
    #[schemars(with = "[f32; 4]")]
    pub rotation: Quat,
    /// kg/m³; default 1000.
    #[serde(default = "density", skip_serializing_if = "is_density")]
    pub density: f32,
    /// Coulomb's μ ≥ 0; default 0.6.
    #[serde(default = "friction", skip_serializing_if = "is_friction")]
    pub friction: f32,
    /// How the μ of two touching shapes combine; default geometric_mean.
    #[serde(default = "friction_combine", skip_serializing_if = "is_friction_combine")]
    #[schemars(schema_with = "combine_schema")]
    pub friction_combine: Combine,
    /// Newton's e in [0, 1]; default 0.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub restitution: f32,
    /// How the e of two touching shapes combine; default maximum.
    #[serde(default = "restitution_combine", skip_serializing_if = "is_restitution_combine")]
    #[schemars(schema_with = "combine_schema")]
    pub restitution_combine: Combine,
    /// Torque against spin about the normal: this length × normal force, m.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub torsional_friction: f32,
    /// Torque against rolling: this length × normal force, m.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub rolling_friction: f32,
    /// Velocity of the surface relative to the body (a conveyor), m/s, in the body's frame.
    #[serde(default, skip_serializing_if = "is_default")]
    #[schemars(with = "[f32; 3]")]
    pub surface_velocity: Vec3,
    /// Bits of the groups this shape is in; default 1.
    #[serde(default = "member_of", skip_serializing_if = "is_member_of")]
    pub member_of: u32,
    /// Bits of the groups this shape touches; default all.
    #[serde(default = "collides_with", skip_serializing_if = "is_collides_with")]
    pub collides_with: u32,
    /// Reports overlaps, makes no contact, has no mass.
    #[serde(default, skip_serializing_if = "is_false")]
    pub sensor: bool,
}

fn up() -> Vec3 {
    Vec3::Y
}

// serde wants a function for each default and each comparison; the numbers themselves are the engine's.
macro_rules! defaults {
    ($($name:ident, $is:ident: $type:ty = $value:expr;)*) => {$(
        fn $name() -> $type {
            $value
        }
        fn $is(value: &$type) -> bool {
            *value == $value
        }
    )*};
}
defaults! {
    density, is_density: f32 = 1000.0;
    friction, is_friction: f32 = Material::default().friction;
    friction_combine, is_friction_combine: Combine = Material::default().friction_combine;
    restitution_combine, is_restitution_combine: Combine = Material::default().restitution_combine;
    member_of, is_member_of: u32 = Groups::default().member_of;
    collides_with, is_collides_with: u32 = Groups::default().collides_with;
}

fn combine_schema(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "type": "string", "enum": ["average", "geometric_mean", "minimum", "multiply", "maximum"] })
}

impl From<GeometryFile> for ShapeFile {
    fn from(geometry: GeometryFile) -> Self {
        Self {
            geometry,
            position: Vec3::ZERO,
            rotation: Quat::IDENTITY,
            density: density(),
            friction: friction(),
            friction_combine: friction_combine(),
            restitution: 0.0,
            restitution_combine: restitution_combine(),
            torsional_friction: 0.0,
            rolling_friction: 0.0,
            surface_velocity: Vec3::ZERO,
            member_of: member_of(),
            collides_with: collides_with(),
            sensor: false,
        }
    }
}

impl From<&Shape> for ShapeFile {
    fn from(shape: &Shape) -> Self {
        let m = &shape.material;
        Self {
            geometry: (&shape.geometry).into(),
            position: shape.pose.translation,
            rotation: shape.pose.rotation,
            density: shape.density,
            friction: m.friction,
            friction_combine: m.friction_combine,
            restitution: m.restitution,
            restitution_combine: m.restitution_combine,
            torsional_friction: m.torsional_friction,
            rolling_friction: m.rolling_friction,
            surface_velocity: m.surface_velocity,
            member_of: shape.groups.member_of,
            collides_with: shape.groups.collides_with,
            sensor: shape.sensor,
        }
    }
}

impl From<&Geometry> for GeometryFile {
    fn from(geometry: &Geometry) -> Self {
        match geometry {
            &Geometry::Ball { radius } => Self::Ball { radius },
            &Geometry::Cuboid { half_extents } => Self::Cuboid { half_extents },
            &Geometry::Capsule { half_length, radius } => Self::Capsule { half_length, radius },
            &Geometry::Cylinder { half_height, radius } => Self::Cylinder { half_height, radius },
            &Geometry::Cone { half_height, radius } => Self::Cone { half_height, radius },
            &Geometry::HalfSpace { normal } => Self::HalfSpace { normal },
            Geometry::ConvexHull(hull) => Self::ConvexHull(HullFile { points: hull.points().to_vec() }),
            Geometry::TriangleMesh(mesh) => Self::TriangleMesh(MeshFile {
                vertices: mesh.vertices().to_vec(),
                triangles: mesh.triangles().to_vec(),
            }),
            Geometry::HeightField(field) => {
                let (rows, columns) = field.dimensions();
                let (size_x, size_z) = field.size();
                Self::HeightField { rows, columns, heights: field.heights().to_vec(), size_x, size_z }
            }
            Geometry::Compound(shapes) => Self::Compound { shapes: shapes.iter().map(ShapeFile::from).collect() },
        }
    }
}

/// The hulls and meshes of a scene that shapes share, made once.
pub(super) struct Shared {
    hulls: BTreeMap<String, Arc<ConvexHull>>,
    meshes: BTreeMap<String, Arc<TriangleMesh>>,
}

impl Shared {
    pub fn new(hulls: &BTreeMap<String, HullFile>, meshes: &BTreeMap<String, MeshFile>) -> Result<Self> {
        let hulls = hulls.iter().map(|(name, hull)| {
            let place = format!("hulls.{name}");
            Ok((name.clone(), Arc::new(hull.build().map_err(|e| SceneError::from_engine(&place, e))?)))
        });
        let meshes = meshes.iter().map(|(name, mesh)| {
            let place = format!("meshes.{name}");
            Ok((name.clone(), Arc::new(mesh.build().map_err(|e| SceneError::from_engine(&place, e))?)))
        });
        Ok(Self { hulls: hulls.collect::<Result<_>>()?, meshes: meshes.collect::<Result<_>>()? })
    }
}

impl HullFile {
    fn build(&self) -> ishigaki::Result<ConvexHull> {
        if let Some(i) = self.points.iter().position(|p| !p.is_finite()) {
            return Err(engine_error(&format!("points[{i}]"), "must be finite"));
        }
        ConvexHull::new(&self.points)
    }
}

impl MeshFile {
    fn build(&self) -> ishigaki::Result<TriangleMesh> {
        TriangleMesh::new(self.vertices.clone(), self.triangles.clone())
    }
}

fn engine_error(place: &str, message: &str) -> ishigaki::Error {
    ishigaki::Error::Invalid { place: place.to_string(), message: message.to_string() }
}

impl ShapeFile {
    /// The engine's shape; errors carry the place within the shape.
    pub(super) fn build(&self, shared: &Shared, depth: usize) -> ishigaki::Result<Shape> {
        Ok(Shape {
            geometry: self.geometry.build(shared, depth)?,
            pose: Pose::from_parts(self.position, self.rotation),
            density: self.density,
            material: Material {
                friction: self.friction,
                friction_combine: self.friction_combine,
                restitution: self.restitution,
                restitution_combine: self.restitution_combine,
                torsional_friction: self.torsional_friction,
                rolling_friction: self.rolling_friction,
                surface_velocity: self.surface_velocity,
            },
            groups: Groups { member_of: self.member_of, collides_with: self.collides_with },
            sensor: self.sensor,
        })
    }
}

impl GeometryFile {
    fn build(&self, shared: &Shared, depth: usize) -> ishigaki::Result<Geometry> {
        Ok(match self {
            &Self::Ball { radius } => Geometry::Ball { radius },
            &Self::Cuboid { half_extents } => Geometry::Cuboid { half_extents },
            &Self::Capsule { half_length, radius } => Geometry::Capsule { half_length, radius },
            &Self::Cylinder { half_height, radius } => Geometry::Cylinder { half_height, radius },
            &Self::Cone { half_height, radius } => Geometry::Cone { half_height, radius },
            &Self::HalfSpace { normal } => Geometry::HalfSpace { normal },
            Self::ConvexHull(hull) => Geometry::ConvexHull(Arc::new(hull.build()?)),
            Self::TriangleMesh(mesh) => Geometry::TriangleMesh(Arc::new(mesh.build()?)),
            Self::SharedHull(name) => Geometry::ConvexHull(lookup("shared_hull", "hull", name, &shared.hulls)?),
            Self::SharedMesh(name) => Geometry::TriangleMesh(lookup("shared_mesh", "mesh", name, &shared.meshes)?),
            Self::HeightField { rows, columns, heights, size_x, size_z } => {
                Geometry::HeightField(Arc::new(HeightField::new(*rows, *columns, heights.clone(), *size_x, *size_z)?))
            }
            Self::Compound { shapes } => {
                if depth >= MAX_DEPTH {
                    let message = format!("compounds are nested deeper than {MAX_DEPTH}: lay them out flat");
                    return Err(engine_error("shapes", &message));
                }
                let build = |(i, s): (usize, &ShapeFile)| {
                    s.build(shared, depth + 1).map_err(|e| e.within(&format!("shapes[{i}]")))
                };
                Geometry::Compound(shapes.iter().enumerate().map(build).collect::<ishigaki::Result<_>>()?)
            }
        })
    }
}

fn lookup<T>(place: &str, what: &str, name: &str, known: &BTreeMap<String, Arc<T>>) -> ishigaki::Result<Arc<T>> {
    known
        .get(name)
        .cloned()
        .ok_or_else(|| engine_error(place, &crate::error::unknown(what, name, known.keys().map(String::as_str))))
}
