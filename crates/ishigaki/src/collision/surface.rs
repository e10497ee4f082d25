//! Triangles of meshes and height fields, and which contact normals they may give.
//!
//! A flat floor of many triangles must feel like one plane. Taken alone, each triangle has edges to stumble over:
//! the nearest point of the next triangle is its border, and the direction from there is nearly horizontal. But a
//! border shared with a neighbor is no border: contact normals on it lie between the two face normals. Directions
//! outside this fan are not allowed (the face normal takes their place, and finds nothing where the body is not
//! over the face); directions inside it belong to the triangle whose face they are nearer to.
//! Surfaces have a front; bodies whose center is behind a triangle of a mesh do not touch it.
//! Test: `tests/narrow_phase.rs`, sliding over a flat mesh.

use crate::collision::clip::Candidates;
use crate::collision::manifold::LocalPoint;
use crate::collision::polyhedron::TrianglePolyhedron;
use crate::math::Vec3;
use crate::shape::{Geometry, HeightField, TriangleMesh};
use parry3d::bounding_volume::Aabb;
use smallvec::SmallVec;

/// Sine of the angle by which a direction may pass the fan of a ridge.
const BEYOND_RIDGE: f32 = 0.02;
/// The same where the two triangles are in one plane or make a valley.
const BEYOND_FLAT: f32 = 1e-4;
/// Cosine above which two triangles are in one plane.
const FLAT: f32 = 1.0 - 1e-6;

/// A triangle of a surface and its surroundings.
pub(crate) struct SurfaceTriangle {
    pub solid: TrianglePolyhedron,
    pub index: u32,
    pub normal: Vec3,
    /// Across each edge.
    neighbors: [Option<Neighbor>; 3],
    /// In the plane of the triangle, away from it, unit: one for each edge.
    outward: [Vec3; 3],
    /// Whether there is solid ground behind it: what has sunk in is pushed out.
    pub is_ground: bool,
}

/// A triangle across an edge.
#[derive(Clone, Copy)]
struct Neighbor {
    index: u32,
    normal: Vec3,
    /// `normal·x` of its points, m.
    offset: f32,
}

impl Neighbor {
    fn new(index: u32, [a, b, c]: [Vec3; 3]) -> Option<Self> {
        let normal = (b - a).cross(c - a).try_normalize()?;
        Some(Self { index, normal, offset: normal.dot(a) })
    }
}

/// What a triangle makes of a direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// A contact of this triangle may have it as normal.
    Allowed,
    /// A neighbor has this contact.
    Neighbors,
    /// No contact of this surface may have it.
    Forbidden,
}

impl SurfaceTriangle {
    fn new(vertices: [Vec3; 3], index: u32, neighbors: [Option<(u32, [Vec3; 3])>; 3], is_ground: bool) -> Option<Self> {
        let solid = TrianglePolyhedron::new(vertices)?;
        let normal = solid.view().faces[0].normal;
        let side = |k: usize| (vertices[(k + 1) % 3] - vertices[k]).cross(normal).normalize_or_zero();
        let neighbors = neighbors.map(|n| n.and_then(|(index, corners)| Neighbor::new(index, corners)));
        Some(Self { solid, index, normal, neighbors, outward: [side(0), side(1), side(2)], is_ground })
    }

    /// Whether `direction`, a unit vector away from the surface, may be a normal for a solid with this center.
    pub fn verdict(&self, direction: Vec3, center: Vec3) -> Verdict {
        let up = direction.dot(self.normal);
        if up < -BEYOND_RIDGE {
            return Verdict::Forbidden;
        }
        let mut verdict = Verdict::Allowed;
        for (outward, neighbor) in self.outward.iter().zip(&self.neighbors) {
            let out = direction.dot(*outward);
            if out <= BEYOND_FLAT {
                continue;
            }
            let Some(Neighbor { index, normal, offset }) = neighbor else { continue };
            // sin(φ − φₖ): how far the direction is past the neighbor's normal, seen along the edge.
            let (fan_up, fan_out) = (normal.dot(self.normal), normal.dot(*outward));
            let past = fan_up * out - fan_out * up;
            let limit = if fan_out > BEYOND_RIDGE { BEYOND_RIDGE } else { BEYOND_FLAT };
            if past > limit {
                return Verdict::Forbidden;
            }
            let lead = direction.dot(*normal) - up;
            let sees_it = self.is_ground || normal.dot(center) >= *offset;
            if sees_it && (lead > 1e-6 || lead >= -1e-6 && *index < self.index) {
                verdict = Verdict::Neighbors;
            }
        }
        verdict
    }

    /// Drops points on borders inside a plane: the same plane goes on behind them, and so does the contact.
    pub fn drop_inner_points(&self, points: &mut Candidates) {
        let flat = self.neighbors.map(|n| n.is_some_and(|n| n.normal.dot(self.normal) > FLAT));
        points.retain(|point: &mut LocalPoint| {
            if let Some(edge) = point.id.a().as_edge() {
                !flat[edge as usize % 3]
            } else if let Some(vertex) = point.id.a().as_vertex() {
                // Edges k − 1 and k meet in vertex k.
                !(flat[vertex as usize % 3] && flat[(vertex as usize + 2) % 3])
            } else {
                true
            }
        });
    }
}

/// Calls `visit` with every triangle of the surface whose box touches the box from `least` to `greatest`.
pub(crate) fn for_each_triangle(
    surface: &Geometry,
    least: Vec3,
    greatest: Vec3,
    mut visit: impl FnMut(&SurfaceTriangle),
) {
    match surface {
        Geometry::TriangleMesh(mesh) => visit_mesh(mesh, least, greatest, &mut visit),
        Geometry::HeightField(field) => visit_field(field, least, greatest, &mut visit),
        _ => {}
    }
}

fn visit_mesh(mesh: &TriangleMesh, least: Vec3, greatest: Vec3, visit: &mut impl FnMut(&SurfaceTriangle)) {
    let bounds = Aabb::new(least, greatest);
    let mut found: SmallVec<[u32; 64]> = mesh.mesh.bvh().intersect_aabb(&bounds).collect();
    found.sort_unstable();
    let corners = |t: u32| mesh.triangles()[t as usize].map(|v| mesh.vertices()[v as usize]);
    for t in found {
        let neighbors = mesh.neighbors[t as usize].map(|n| n.map(|n| (n, corners(n))));
        if let Some(triangle) = SurfaceTriangle::new(corners(t), t, neighbors, false) {
            visit(&triangle);
        }
    }
}

/// Cells have two triangles: 2 (row (columns − 1) + column) and the next; the first is at the corner of least x and z.
fn visit_field(field: &HeightField, least: Vec3, greatest: Vec3, visit: &mut impl FnMut(&SurfaceTriangle)) {
    let (rows, columns) = field.dimensions();
    let (size_x, size_z) = field.size();
    let (cells_x, cells_z) = (columns - 1, rows - 1);
    let (step_x, step_z) = (size_x / cells_x as f32, size_z / cells_z as f32);
    let range = |low: f32, high: f32, size: f32, step: f32, cells: usize| {
        // Casts saturate, so what is far outside is clamped to the border cells.
        let first = (((low + 0.5 * size) / step).floor().max(0.0) as usize).min(cells);
        let last = (((high + 0.5 * size) / step).floor() + 1.0).max(0.0) as usize;
        first..last.min(cells)
    };
    let point = |row: usize, column: usize| {
        let height = field.heights()[row * columns + column];
        Vec3::new(step_x * column as f32 - 0.5 * size_x, height, step_z * row as f32 - 0.5 * size_z)
    };
    let triangle = |row: usize, column: usize, second: bool| {
        let index = 2 * (row * cells_x + column) as u32 + second as u32;
        let corners = if second {
            [point(row + 1, column), point(row + 1, column + 1), point(row, column + 1)]
        } else {
            [point(row, column), point(row + 1, column), point(row, column + 1)]
        };
        (index, corners)
    };
    for row in range(least.z, greatest.z, size_z, step_z, cells_z) {
        for column in range(least.x, greatest.x, size_x, step_x, cells_x) {
            for second in [false, true] {
                let (index, corners) = triangle(row, column, second);
                let heights = corners.map(|c| c.y);
                if heights.iter().all(|&y| y > greatest.y) {
                    continue;
                }
                let neighbors = if second {
                    [
                        (row + 1 < cells_z).then(|| triangle(row + 1, column, false)),
                        (column + 1 < cells_x).then(|| triangle(row, column + 1, false)),
                        Some(triangle(row, column, false)),
                    ]
                } else {
                    [
                        (column > 0).then(|| triangle(row, column - 1, true)),
                        Some(triangle(row, column, true)),
                        (row > 0).then(|| triangle(row - 1, column, true)),
                    ]
                };
                if let Some(triangle) = SurfaceTriangle::new(corners, index, neighbors, true) {
                    visit(&triangle);
                }
            }
        }
    }
}
