//! The scene of a recording: everything that does not change during the run.

use crate::recorder::About;
use ishigaki::{BodyHandle, BodyKind, JointKind, Pose, Quat, Vec3, World};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What does not change during a run. The fields are those of the `SCEN` chunk.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// Name of the scene or path of its file.
    pub name: String,
    /// Version of the engine.
    pub engine: String,
    /// Length of a step, s.
    pub dt: f32,
    /// Steps from one frame to the next, at least 1.
    pub every: u64,
    /// Whether frames hold contacts.
    pub contacts: bool,
    /// Unit; against gravity, Y without gravity.
    pub up: Vec3,
    /// All options of the engine, as it wrote them: another version may have others.
    pub options: serde_json::Value,
    /// Where a viewer should look from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<Camera>,
    /// Forms that shapes refer to by number; no two are the same.
    pub geometries: Vec<Geometry>,
    /// Bodies in the order of frames.
    pub bodies: Vec<BodyEntry>,
    /// Joints.
    pub joints: Vec<JointEntry>,
}

/// Where a viewer should look from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    /// Where the eye is, world, m.
    pub position: Vec3,
    /// What it looks at, world, m.
    pub target: Vec3,
}

/// The form of a shape in its own frame, m; the same as [`ishigaki::Geometry`], as plain numbers that can be drawn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "the fields are those of ishigaki::Geometry; lists are said here")]
pub enum Geometry {
    /// About the origin.
    Ball { radius: f32 },
    /// About the origin.
    Cuboid { half_extents: Vec3 },
    /// Along Y.
    Capsule { half_length: f32, radius: f32 },
    /// About Y.
    Cylinder { half_height: f32, radius: f32 },
    /// About Y, apex up.
    Cone { half_height: f32, radius: f32 },
    /// Three numbers for each vertex; faces are plane, counter-clockwise seen from outside.
    ConvexHull { vertices: Vec<f32>, faces: Vec<Vec<u32>> },
    /// Solid where normal·x ≤ 0.
    HalfSpace { normal: Vec3 },
    /// Three numbers for each vertex, three for each triangle; counter-clockwise seen from outside.
    TriangleMesh { vertices: Vec<f32>, triangles: Vec<u32> },
    /// `heights[row * columns + column]` along Y; rows along Z, columns along X, centered.
    HeightField { rows: usize, columns: usize, size_x: f32, size_z: f32, heights: Vec<f32> },
}

/// A body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BodyEntry {
    /// May be empty.
    pub name: String,
    /// What moves it.
    pub kind: BodyKind,
    /// Center of mass in the body's frame, m.
    pub center: Vec3,
    /// kg; of dynamic bodies.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass: Option<f32>,
    /// Compounds are laid out as single shapes.
    pub shapes: Vec<ShapeEntry>,
}

/// A shape of a body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShapeEntry {
    /// Number of its form.
    pub geometry: usize,
    /// In the body's frame, m.
    pub position: Vec3,
    /// body_from_shape.
    pub rotation: Quat,
    /// Touches nothing.
    pub sensor: bool,
}

/// A joint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointEntry {
    /// May be empty.
    pub name: String,
    /// `ball`, `hinge`, `slider`, `fixed`, `distance` or `generic`.
    pub kind: String,
    /// Number of the first body.
    pub body_a: u32,
    /// Number of the second body.
    pub body_b: u32,
    /// The joint's frame on A, in A's frame.
    pub frame_a: Placement,
    /// The joint's frame on B, in B's frame.
    pub frame_b: Placement,
}

/// A pose as it is written.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Placement {
    /// m.
    pub position: Vec3,
    /// A unit quaternion.
    pub rotation: Quat,
}

impl ShapeEntry {
    /// body_from_shape.
    pub fn pose(&self) -> Pose {
        Pose::from_parts(self.position, self.rotation)
    }
}

impl Placement {
    /// The same, to calculate with.
    pub fn pose(&self) -> Pose {
        Pose::from_parts(self.position, self.rotation)
    }
}

impl Scene {
    /// Describes a world as it is now, its bodies numbered in slot order.
    pub fn describe(world: &World, about: &About) -> Self {
        let numbers = world.bodies().zip(0..).map(|((handle, _), number)| (handle, number)).collect();
        Self::of(world, about, &numbers)
    }

    /// Describes a world; `numbers` are those of its bodies.
    pub(crate) fn of(world: &World, about: &About, numbers: &BTreeMap<BodyHandle, u32>) -> Self {
        let mut geometries = Geometries::default();
        let bodies = world.bodies().map(|(handle, body)| {
            let shapes = world.shapes_of(handle).filter_map(|(_, shape, _)| {
                let geometry = geometries.number(&shape.geometry)?;
                let (position, rotation) = (shape.pose.translation, shape.pose.rotation);
                Some(ShapeEntry { geometry, position, rotation, sensor: shape.sensor })
            });
            let dynamic = body.kind() == BodyKind::Dynamic;
            BodyEntry {
                name: body.name().into(),
                kind: body.kind(),
                shapes: shapes.collect(),
                center: body.mass_properties().center,
                mass: dynamic.then(|| body.mass()),
            }
        });
        let bodies = bodies.collect();
        let gravity = world.options().gravity;
        // Through text: as a value directly, 0.1 in f32 would become 0.10000000149011612.
        let options = serde_json::to_string(world.options()).and_then(|text| serde_json::from_str(&text));
        Self {
            name: about.name.clone(),
            engine: env!("CARGO_PKG_VERSION").into(),
            dt: about.dt,
            every: about.every.max(1),
            contacts: about.contacts,
            up: (-gravity).try_normalize().unwrap_or(Vec3::Y),
            // Only a map whose keys are no strings could fail; there is none.
            options: options.unwrap_or_default(),
            camera: about.camera,
            geometries: geometries.list,
            bodies,
            joints: world.joints().filter_map(|(_, joint)| joint_entry(world, joint, numbers)).collect(),
        }
    }

    /// Reads and checks what a reader relies on: numbers that refer to something, lists of the right length.
    pub(crate) fn from_json(json: &[u8]) -> Result<Self, String> {
        let scene: Self = serde_json::from_slice(json).map_err(|e| format!("the scene cannot be read: {e}"))?;
        let bodies = scene.bodies.len();
        for (i, body) in scene.bodies.iter().enumerate() {
            if body.shapes.iter().any(|shape| shape.geometry >= scene.geometries.len()) {
                return Err(format!("bodies[{i}] has a shape whose geometry is not there"));
            }
        }
        for (i, geometry) in scene.geometries.iter().enumerate() {
            geometry.check().map_err(|what| format!("geometries[{i}]: {what}"))?;
        }
        if scene.joints.iter().any(|joint| joint.body_a.max(joint.body_b) as usize >= bodies) {
            return Err("a joint of a body that is not there".into());
        }
        if scene.every == 0 || u32::try_from(bodies).is_err() {
            return Err("its number of bodies or of steps between frames makes no sense".into());
        }
        Ok(scene)
    }
}

fn joint_entry(world: &World, joint: &ishigaki::JointState, numbers: &BTreeMap<BodyHandle, u32>) -> Option<JointEntry> {
    let definition = joint.definition();
    let (a, b) = (world.body(definition.body_a)?, world.body(definition.body_b)?);
    let [on_a, on_b] = joint.frames_from_centers();
    let placement =
        |frame: Pose, center: Vec3| Placement { position: center + frame.translation, rotation: frame.rotation };
    let kind = match definition.kind {
        JointKind::Ball { .. } => "ball",
        JointKind::Hinge { .. } => "hinge",
        JointKind::Slider { .. } => "slider",
        JointKind::Fixed => "fixed",
        JointKind::Distance { .. } => "distance",
        JointKind::Generic { .. } => "generic",
    };
    Some(JointEntry {
        name: definition.name.clone(),
        kind: kind.into(),
        body_a: *numbers.get(&definition.body_a)?,
        body_b: *numbers.get(&definition.body_b)?,
        frame_a: placement(on_a, a.mass_properties().center),
        frame_b: placement(on_b, b.mass_properties().center),
    })
}

/// Forms without repetition: a wall has many bricks and few forms.
#[derive(Default)]
struct Geometries {
    list: Vec<Geometry>,
    /// By their JSON: floats have no order of their own.
    numbers: BTreeMap<String, usize>,
}

impl Geometries {
    fn number(&mut self, geometry: &ishigaki::Geometry) -> Option<usize> {
        let geometry = Geometry::of(geometry)?;
        let key = serde_json::to_string(&geometry).unwrap_or_default();
        let list = &mut self.list;
        let number = *self.numbers.entry(key).or_insert_with(|| {
            list.push(geometry);
            list.len() - 1
        });
        Some(number)
    }
}

impl Geometry {
    /// `None` for compounds: worlds lay them out as single shapes.
    pub fn of(geometry: &ishigaki::Geometry) -> Option<Self> {
        use ishigaki::Geometry as Engine;
        let flat = |points: &[Vec3]| points.iter().flat_map(|p| p.to_array()).collect();
        Some(match geometry {
            &Engine::Ball { radius } => Self::Ball { radius },
            &Engine::Cuboid { half_extents } => Self::Cuboid { half_extents },
            &Engine::Capsule { half_length, radius } => Self::Capsule { half_length, radius },
            &Engine::Cylinder { half_height, radius } => Self::Cylinder { half_height, radius },
            &Engine::Cone { half_height, radius } => Self::Cone { half_height, radius },
            Engine::ConvexHull(hull) => Self::ConvexHull {
                vertices: flat(hull.vertices()),
                faces: (0..hull.face_count()).map(|i| hull.face(i).1.to_vec()).collect(),
            },
            &Engine::HalfSpace { normal } => Self::HalfSpace { normal },
            Engine::TriangleMesh(mesh) => {
                Self::TriangleMesh { vertices: flat(mesh.vertices()), triangles: mesh.triangles().concat() }
            }
            Engine::HeightField(field) => {
                let ((rows, columns), (size_x, size_z)) = (field.dimensions(), field.size());
                Self::HeightField { rows, columns, size_x, size_z, heights: field.heights().to_vec() }
            }
            Engine::Compound(_) => return None,
        })
    }

    fn check(&self) -> Result<(), String> {
        let inside = |vertices: &[f32], corners: &[u32]| {
            vertices.len().is_multiple_of(3) && corners.iter().all(|&c| (c as usize) < vertices.len() / 3)
        };
        let right = match self {
            Self::ConvexHull { vertices, faces } => faces.iter().all(|face| face.len() >= 3 && inside(vertices, face)),
            Self::TriangleMesh { vertices, triangles } => {
                triangles.len().is_multiple_of(3) && inside(vertices, triangles)
            }
            Self::HeightField { rows, columns, heights, .. } => {
                *rows >= 2 && *columns >= 2 && rows.checked_mul(*columns) == Some(heights.len())
            }
            _ => true,
        };
        right.then_some(()).ok_or_else(|| "its lists do not fit each other".into())
    }
}
