//! What a renderer needs to know once, in the form of a recording's `SCEN` chunk (`docs/recording-format.md`): bodies,
//! their shapes, and each geometry that shapes share written once.

use ishigaki::shape::Geometry;
use ishigaki::{BodyKind, Vec3, World};
use serde::Serialize;
use serde_json::{Value, json};
use std::sync::Arc;

/// The bodies and shapes of a world.
#[derive(Clone, Debug, Serialize)]
pub struct SceneGeometry {
    /// Unit, against gravity.
    pub up: [f32; 3],
    /// Forms of shapes.
    pub geometries: Vec<Value>,
    /// In slot order.
    pub bodies: Vec<SceneBody>,
}

/// A body.
#[derive(Clone, Debug, Serialize)]
pub struct SceneBody {
    /// May be empty.
    pub name: String,
    /// What moves it.
    pub kind: BodyKind,
    /// kg; of dynamic bodies only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass: Option<f32>,
    /// Compounds are laid out as single shapes.
    pub shapes: Vec<SceneShape>,
}

/// A shape in the frame of its body.
#[derive(Clone, Debug, Serialize)]
pub struct SceneShape {
    /// Place in the list of geometries.
    pub geometry: usize,
    /// m.
    pub position: [f32; 3],
    /// x, y, z, w.
    pub rotation: [f32; 4],
    /// Makes no contact.
    pub sensor: bool,
}

/// All shapes of a world as it is now.
pub fn scene_geometry(world: &World) -> SceneGeometry {
    let up = -world.options().gravity.try_normalize().unwrap_or(Vec3::NEG_Y);
    let mut geometries = Geometries::default();
    let mut bodies = Vec::with_capacity(world.report().bodies);
    for (handle, state) in world.bodies() {
        let shapes = world.shapes_of(handle).filter_map(|(_, shape, _)| {
            Some(SceneShape {
                geometry: geometries.place(&shape.geometry)?,
                position: shape.pose.translation.to_array(),
                rotation: shape.pose.rotation.to_array(),
                sensor: shape.sensor,
            })
        });
        let shapes = shapes.collect();
        let mass = (state.kind() == BodyKind::Dynamic).then(|| state.mass());
        bodies.push(SceneBody { name: state.name().to_string(), kind: state.kind(), mass, shapes });
    }
    SceneGeometry { up: up.to_array(), geometries: geometries.list, bodies }
}

#[derive(Default)]
struct Geometries {
    list: Vec<Value>,
    /// Addresses of hulls, surfaces and terrains that shapes share, with their places.
    shared: Vec<(usize, usize)>,
    /// The last one that is written by its numbers: neighbors are often equal.
    last: Option<Geometry>,
}

impl Geometries {
    /// The place of a geometry in the list; `None` for compounds, which worlds lay out flat.
    fn place(&mut self, geometry: &Geometry) -> Option<usize> {
        let address = match geometry {
            Geometry::ConvexHull(hull) => Arc::as_ptr(hull) as usize,
            Geometry::TriangleMesh(mesh) => Arc::as_ptr(mesh) as usize,
            Geometry::HeightField(field) => Arc::as_ptr(field) as usize,
            Geometry::Compound(_) => return None,
            _ => {
                if self.last.as_ref() != Some(geometry) {
                    self.list.push(write(geometry));
                    self.last = Some(geometry.clone());
                }
                return Some(self.list.len() - 1);
            }
        };
        if let Some(&(_, place)) = self.shared.iter().find(|(a, _)| *a == address) {
            return Some(place);
        }
        self.last = None;
        self.list.push(write(geometry));
        self.shared.push((address, self.list.len() - 1));
        Some(self.list.len() - 1)
    }
}

fn write(geometry: &Geometry) -> Value {
    match geometry {
        Geometry::Ball { radius } => json!({ "ball": { "radius": radius } }),
        Geometry::Cuboid { half_extents } => json!({ "cuboid": { "half_extents": half_extents.to_array() } }),
        Geometry::Capsule { half_length, radius } => {
            json!({ "capsule": { "half_length": half_length, "radius": radius } })
        }
        Geometry::Cylinder { half_height, radius } => {
            json!({ "cylinder": { "half_height": half_height, "radius": radius } })
        }
        Geometry::Cone { half_height, radius } => json!({ "cone": { "half_height": half_height, "radius": radius } }),
        Geometry::HalfSpace { normal } => json!({ "half_space": { "normal": normal.to_array() } }),
        Geometry::ConvexHull(hull) => {
            let faces: Vec<&[u32]> = (0..hull.face_count()).map(|face| hull.face(face).1).collect();
            json!({ "convex_hull": { "vertices": flat(hull.vertices()), "faces": faces } })
        }
        Geometry::TriangleMesh(mesh) => {
            let triangles: Vec<u32> = mesh.triangles().iter().flatten().copied().collect();
            json!({ "triangle_mesh": { "vertices": flat(mesh.vertices()), "triangles": triangles } })
        }
        Geometry::HeightField(field) => {
            let ((rows, columns), (size_x, size_z)) = (field.dimensions(), field.size());
            json!({ "height_field": { "rows": rows, "columns": columns, "size_x": size_x, "size_z": size_z,
                                      "heights": field.heights() } })
        }
        Geometry::Compound(_) => Value::Null,
    }
}

fn flat(points: &[Vec3]) -> Vec<f32> {
    points.iter().flat_map(|p| p.to_array()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ishigaki::{Body, Shape};

    #[test]
    fn shared_and_equal_geometries_are_written_once() {
        let corners: Vec<Vec3> =
            (0..8).map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) - 0.5).collect();
        let hull = Shape::convex_hull(&corners).unwrap();
        let mut world = World::default();
        for x in 0..3 {
            world.add_body(Body::dynamic(hull.clone()).at(Vec3::X * x as f32)).unwrap();
        }
        for x in 0..3 {
            world.add_body(Body::dynamic(Shape::ball(0.5)).at(Vec3::Y * (2 + x) as f32)).unwrap();
        }
        let scene = scene_geometry(&world);
        assert_eq!((scene.bodies.len(), scene.geometries.len()), (6, 2));
        assert_eq!(scene.geometries[0]["convex_hull"]["faces"].as_array().map(Vec::len), Some(6));
        assert_eq!(scene.up, [0.0, 1.0, 0.0]);
    }
}
