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
use std::cell::OnceCell;

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
    /// The triangles across its edges: index and corners.
    beside: [Option<(u32, [Vec3; 3])>; 3],
    /// What most triangles near a solid are not asked for.
    surroundings: OnceCell<Surroundings>,
    /// Whether there is solid ground behind it: what has sunk in is pushed out.
    pub is_ground: bool,
}

/// What a triangle knows of its edges.
struct Surroundings {
    /// Across each edge.
    neighbors: [Option<Neighbor>; 3],
    /// In the plane of the triangle, away from it, unit: one for each edge.
    outward: [Vec3; 3],
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
    fn new(vertices: [Vec3; 3], index: u32, beside: [Option<(u32, [Vec3; 3])>; 3], is_ground: bool) -> Option<Self> {
        let solid = TrianglePolyhedron::new(vertices)?;
        let normal = solid.view().faces[0].normal;
        Some(Self { solid, index, normal, beside, surroundings: OnceCell::new(), is_ground })
    }

    fn surroundings(&self) -> &Surroundings {
        self.surroundings.get_or_init(|| {
            let vertices = self.solid.view().vertices;
            let side = |k: usize| (vertices[(k + 1) % 3] - vertices[k]).cross(self.normal).normalize_or_zero();
            let neighbors = self.beside.map(|n| n.and_then(|(index, corners)| Neighbor::new(index, corners)));
            Surroundings { neighbors, outward: [side(0), side(1), side(2)] }
        })
    }

    /// Whether `direction`, a unit vector away from the surface, may be a normal for a solid with this center.
    pub fn verdict(&self, direction: Vec3, center: Vec3) -> Verdict {
        let up = direction.dot(self.normal);
        if up < -BEYOND_RIDGE {
            return Verdict::Forbidden;
        }
        let mut verdict = Verdict::Allowed;
        let Surroundings { neighbors, outward } = self.surroundings();
        for (outward, neighbor) in outward.iter().zip(neighbors) {
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
        let flat = self.surroundings().neighbors.map(|n| n.is_some_and(|n| n.normal.dot(self.normal) > FLAT));
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

/// Whether all of a box is in front of the plane through three corners.
fn is_in_front([a, b, c]: [Vec3; 3], least: Vec3, greatest: Vec3) -> bool {
    let normal = (b - a).cross(c - a);
    normal.dot(0.5 * (least + greatest) - a) > normal.abs().dot(0.5 * (greatest - least))
}

/// Calls `visit` with the triangles of the surface near the box from `least` to `greatest`: none that touches it is
/// left out.
pub(crate) fn for_each_triangle(
    surface: &Geometry,
    least: Vec3,
    greatest: Vec3,
    visit: &mut dyn FnMut(&SurfaceTriangle),
) {
    match surface {
        Geometry::TriangleMesh(mesh) => visit_mesh(mesh, least, greatest, visit),
        Geometry::HeightField(field) => visit_field(field, least, greatest, visit),
        _ => {}
    }
}

fn visit_mesh(mesh: &TriangleMesh, least: Vec3, greatest: Vec3, visit: &mut dyn FnMut(&SurfaceTriangle)) {
    let bounds = Aabb::new(least, greatest);
    let mut found: SmallVec<[u32; 64]> = mesh.mesh.bvh().intersect_aabb(&bounds).collect();
    found.sort_unstable();
    let corners = |t: u32| mesh.triangles()[t as usize].map(|v| mesh.vertices()[v as usize]);
    for t in found {
        if is_in_front(corners(t), least, greatest) {
            continue;
        }
        let neighbors = mesh.neighbors[t as usize].map(|n| n.map(|n| (n, corners(n))));
        if let Some(triangle) = SurfaceTriangle::new(corners(t), t, neighbors, false) {
            visit(&triangle);
        }
    }
}

/// Cells have two triangles: 2 (row (columns − 1) + column) and the next; the first is at the corner of least x and z.
fn visit_field(field: &HeightField, least: Vec3, greatest: Vec3, visit: &mut dyn FnMut(&SurfaceTriangle)) {
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
    // In cells along x and z: beyond the line between both triangles of a cell the sum is greater than 1.
    let sum = |p: Vec3, row: usize, column: usize| {
        (p.x + 0.5 * size_x) / step_x - column as f32 + ((p.z + 0.5 * size_z) / step_z - row as f32)
    };
    for row in range(least.z, greatest.z, size_z, step_z, cells_z) {
        for column in range(least.x, greatest.x, size_x, step_x, cells_x) {
            for second in [false, true] {
                let is_beside = if second { sum(greatest, row, column) < 1.0 } else { sum(least, row, column) > 1.0 };
                if is_beside {
                    continue;
                }
                let (index, corners) = triangle(row, column, second);
                let heights = corners.map(|c| c.y);
                if heights.iter().all(|&y| y > greatest.y) || is_in_front(corners, least, greatest) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::permutation::Random;
    use parry3d::math::Pose;
    use parry3d::query::intersection_test;
    use parry3d::shape::{Cuboid, Triangle};
    use std::sync::Arc;

    #[test]
    fn no_triangle_that_touches_the_box_is_left_out() {
        const COUNT: usize = 5;
        let mut random = Random(11);
        let mut number = |size: f32| size * (random.bits() >> 40) as f32 / (1 << 24) as f32;
        let heights: Vec<f32> = (0..COUNT * COUNT).map(|_| number(1.0)).collect();
        let corner = |row: usize, column: usize| {
            Vec3::new(0.8 * column as f32 - 1.6, heights[row * COUNT + column], 0.5 * row as f32 - 1.0)
        };
        let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
        for (row, column) in (0..COUNT - 1).flat_map(|row| (0..COUNT - 1).map(move |column| (row, column))) {
            let [a, b] = [corner(row, column), corner(row + 1, column)];
            let [c, d] = [corner(row, column + 1), corner(row + 1, column + 1)];
            for corners in [[a, b, c], [b, d, c]] {
                triangles.push([0, 1, 2].map(|k| vertices.len() as u32 + k));
                vertices.extend(corners);
            }
        }
        let field = HeightField::new(COUNT, COUNT, heights.clone(), 3.2, 2.0).unwrap();
        let mesh = TriangleMesh::new(vertices.clone(), triangles.clone()).unwrap();
        let surfaces = [Geometry::HeightField(Arc::new(field)), Geometry::TriangleMesh(Arc::new(mesh))];
        let (mut touched, mut visited) = (0, 0);
        for _ in 0..300 {
            let least = Vec3::new(number(3.6) - 2.0, number(1.5) - 0.5, number(2.4) - 1.4);
            let half = 0.5 * Vec3::new(0.05 + number(0.7), 0.05 + number(0.7), 0.05 + number(0.7));
            let place = Pose::from_translation(least + half);
            for surface in &surfaces {
                let mut found = Vec::new();
                for_each_triangle(surface, least, least + 2.0 * half, &mut |triangle| found.push(triangle.index));
                visited += found.len();
                for (index, corners) in (0..).zip(&triangles) {
                    let [a, b, c] = corners.map(|v| vertices[v as usize]);
                    let touches =
                        intersection_test(&Pose::IDENTITY, &Triangle::new(a, b, c), &place, &Cuboid::new(half));
                    if touches.unwrap().intersecting {
                        touched += 1;
                        assert!(found.contains(&index), "triangle {index} at {least} and {half}");
                    }
                }
            }
        }
        assert!(touched > 500 && visited < 2 * touched, "{visited} looked at, {touched} touch");
    }
}
