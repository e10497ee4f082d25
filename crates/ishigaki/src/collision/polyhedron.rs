//! One view of boxes, hulls and triangles: vertices, edges, faces, and what belongs to what.
//!
//! A box has the topology of every box, so its tables are constants; only vertices and planes are computed.
//! The numbers given here to vertices, edges and faces are those of the contact ids: they never change.

use crate::collision::side_by_side::SideBySide;
use crate::math::{Pose, Vec3};
use crate::shape::hull::{ConvexHull, Edge, Face};
use smallvec::SmallVec;

/// A convex polyhedron by its parts.
#[derive(Clone, Copy)]
pub(crate) struct Polyhedron<'a> {
    pub vertices: &'a [Vec3],
    pub faces: &'a [Face],
    /// Vertex of every corner, face by face, counter-clockwise seen from outside.
    pub corner_vertices: &'a [u32],
    /// Edge from every corner to the next.
    pub corner_edges: &'a [u32],
    pub edges: &'a [Edge],
    /// A point inside.
    pub center: Vec3,
    /// Radius of a ball inside about the center, m: the size that tolerances are capped by.
    pub inner_radius: f32,
    /// The same for searches, where that is kept.
    pub side_by_side: Option<&'a SideBySide>,
}

/// A corner of a polygon in the frame of A.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Corner {
    pub point: Vec3,
    /// Number of the vertex in its shape.
    pub vertex: u32,
    /// Number of the edge to the next corner.
    pub edge: u32,
}

/// A face in the frame of A; as incident feature it may also be a segment (two corners) or a point (one).
#[derive(Clone, Debug)]
pub(crate) struct Polygon {
    /// Unit, outward.
    pub normal: Vec3,
    /// `normal·x` of its points, m.
    pub offset: f32,
    /// Number of the face in its shape.
    pub face: u32,
    pub corners: SmallVec<[Corner; 8]>,
}

impl Polyhedron<'_> {
    /// A face, placed by `pose`.
    pub fn polygon(&self, face: usize, pose: &Pose) -> Polygon {
        let Face { normal, offset, first, count } = self.faces[face];
        let normal = pose.rotation * normal;
        let range = first as usize..(first + count) as usize;
        let corners = self.corner_vertices[range.clone()].iter().zip(&self.corner_edges[range]);
        let corners =
            corners.map(|(&vertex, &edge)| Corner { point: *pose * self.vertices[vertex as usize], vertex, edge });
        Polygon { normal, offset: offset + normal.dot(pose.translation), face: face as u32, corners: corners.collect() }
    }

    /// The face whose normal is most along `direction`, given in the polyhedron's frame.
    pub fn face_along(&self, direction: Vec3) -> usize {
        let mut best = (0, f32::NEG_INFINITY);
        for (i, face) in self.faces.iter().enumerate() {
            let cosine = face.normal.dot(direction);
            if cosine > best.1 {
                best = (i, cosine);
            }
        }
        best.0
    }

    /// The vertex that reaches farthest along `direction`, given in the polyhedron's frame.
    pub fn support(&self, direction: Vec3) -> usize {
        let mut best = (0, f32::NEG_INFINITY);
        for (i, vertex) in self.vertices.iter().enumerate() {
            let height = vertex.dot(direction);
            if height > best.1 {
                best = (i, height);
            }
        }
        best.0
    }

    /// The face that meets a plane with this normal: of the faces around the deepest vertex the one most against it.
    pub fn incident_face(&self, normal: Vec3) -> usize {
        let deepest = self.support(-normal) as u32;
        let mut best = (0, f32::INFINITY);
        for (i, face) in self.faces.iter().enumerate() {
            let cosine = face.normal.dot(normal);
            if cosine < best.1 && self.face_vertices(i).contains(&deepest) {
                best = (i, cosine);
            }
        }
        best.0
    }

    /// The vertices around a face.
    pub fn face_vertices(&self, face: usize) -> &[u32] {
        let Face { first, count, .. } = self.faces[face];
        &self.corner_vertices[first as usize..(first + count) as usize]
    }

    /// Both ends of an edge.
    pub fn edge_points(&self, edge: usize) -> [Vec3; 2] {
        self.edges[edge].vertices.map(|v| self.vertices[v as usize])
    }
}

impl ConvexHull {
    pub(crate) fn view(&self) -> Polyhedron<'_> {
        let t = &self.topology;
        Polyhedron {
            vertices: &t.vertices,
            faces: &t.faces,
            corner_vertices: &t.corner_vertices,
            corner_edges: &t.corner_edges,
            edges: &t.edges,
            center: t.center,
            inner_radius: t.inner_radius,
            side_by_side: Some(&t.side_by_side),
        }
    }
}

/// Face 2k is at the negative end of axis k, face 2k + 1 at the positive end.
pub(crate) const fn box_face(axis: usize, positive: bool) -> usize {
    2 * axis + positive as usize
}

/// Vertex numbers have one bit per axis: bit k is set at the positive end of axis k.
const fn box_vertex(u_axis: usize, u: usize, v_axis: usize, v: usize, w_axis: usize, w: usize) -> u32 {
    ((u << u_axis) | (v << v_axis) | (w << w_axis)) as u32
}

/// Edge 4k + u + 2v runs along axis k, at the ends u and v (0 or 1) of the next two axes.
pub(crate) const fn box_edge(axis: usize, u: usize, v: usize) -> usize {
    4 * axis + u + 2 * v
}

/// Vertices around each face, counter-clockwise seen from outside.
pub(crate) const BOX_CORNER_VERTICES: [u32; 24] = box_corners().0;
/// Edges around each face.
pub(crate) const BOX_CORNER_EDGES: [u32; 24] = box_corners().1;
/// Edges of a box.
pub(crate) const BOX_EDGES: [Edge; 12] = box_edges();

const fn box_corners() -> ([u32; 24], [u32; 24]) {
    // Counter-clockwise in (u, v) is counter-clockwise seen from the positive end of axis = u × v.
    let from_positive = [[0, 0], [1, 0], [1, 1], [0, 1]];
    let from_negative = [[0, 0], [0, 1], [1, 1], [1, 0]];
    let mut vertices = [0; 24];
    let mut edges = [0; 24];
    let mut face = 0;
    while face < 6 {
        let (axis, positive) = (face / 2, face % 2);
        let (u_axis, v_axis) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut i = 0;
        while i < 4 {
            let (here, next) = if positive == 1 {
                (from_positive[i], from_positive[(i + 1) % 4])
            } else {
                (from_negative[i], from_negative[(i + 1) % 4])
            };
            vertices[4 * face + i] = box_vertex(u_axis, here[0], v_axis, here[1], axis, positive);
            edges[4 * face + i] = if here[0] != next[0] {
                // Along u: the next axes after u are v and the axis of the face.
                box_edge(u_axis, here[1], positive) as u32
            } else {
                box_edge(v_axis, positive, here[0]) as u32
            };
            i += 1;
        }
        face += 1;
    }
    (vertices, edges)
}

const fn box_edges() -> [Edge; 12] {
    let (vertices, edges) = box_corners();
    let mut out = [Edge { vertices: [0; 2], faces: [u32::MAX; 2] }; 12];
    let mut corner = 0;
    while corner < 24 {
        let face = corner / 4;
        let edge = edges[corner] as usize;
        if out[edge].faces[0] == u32::MAX {
            let next = 4 * face + (corner + 1) % 4;
            out[edge] = Edge { vertices: [vertices[corner], vertices[next]], faces: [face as u32, u32::MAX] };
        } else {
            out[edge].faces[1] = face as u32;
        }
        corner += 1;
    }
    out
}

/// A box as a polyhedron.
pub(crate) struct BoxPolyhedron {
    vertices: [Vec3; 8],
    faces: [Face; 6],
    inner_radius: f32,
}

impl BoxPolyhedron {
    pub fn new(half_extents: Vec3) -> Self {
        let vertices = std::array::from_fn(|i| box_corner(half_extents, i as u32));
        let faces = std::array::from_fn(|i| Face {
            normal: box_normal(i),
            offset: half_extents[i / 2],
            first: 4 * i as u32,
            count: 4,
        });
        Self { vertices, faces, inner_radius: half_extents.min_element() }
    }

    pub fn view(&self) -> Polyhedron<'_> {
        Polyhedron {
            vertices: &self.vertices,
            faces: &self.faces,
            corner_vertices: &BOX_CORNER_VERTICES,
            corner_edges: &BOX_CORNER_EDGES,
            edges: &BOX_EDGES,
            center: Vec3::ZERO,
            inner_radius: self.inner_radius,
            side_by_side: None,
        }
    }
}

/// Outward normal of a face of a box.
pub(crate) fn box_normal(face: usize) -> Vec3 {
    let sign = if face % 2 == 1 { 1.0 } else { -1.0 };
    sign * Vec3::AXES[face / 2]
}

/// A vertex of a box.
pub(crate) fn box_corner(half: Vec3, vertex: u32) -> Vec3 {
    let sign = |bit: u32| if vertex >> bit & 1 == 1 { 1.0 } else { -1.0 };
    half * Vec3::new(sign(0), sign(1), sign(2))
}

/// Both ends of an edge of a box.
pub(crate) fn box_edge_points(half: Vec3, edge: usize) -> [Vec3; 2] {
    BOX_EDGES[edge].vertices.map(|vertex| box_corner(half, vertex))
}

const TRIANGLE_CORNER_VERTICES: [u32; 6] = [0, 1, 2, 0, 2, 1];
/// Edge k runs from vertex k to the next.
const TRIANGLE_CORNER_EDGES: [u32; 6] = [0, 1, 2, 2, 1, 0];
const TRIANGLE_EDGES: [Edge; 3] = [
    Edge { vertices: [0, 1], faces: [0, 1] },
    Edge { vertices: [1, 2], faces: [0, 1] },
    Edge { vertices: [2, 0], faces: [0, 1] },
];

/// A triangle as a polyhedron without thickness: face 0 is its front, face 1 its back.
pub(crate) struct TrianglePolyhedron {
    vertices: [Vec3; 3],
    faces: [Face; 2],
    inner_radius: f32,
}

impl TrianglePolyhedron {
    /// Counter-clockwise seen from the front; `None` without area.
    pub fn new(vertices: [Vec3; 3]) -> Option<Self> {
        let [a, b, c] = vertices;
        let doubled = (b - a).cross(c - a);
        let normal = doubled.try_normalize()?;
        let offset = normal.dot((a + b + c) / 3.0);
        let faces = [
            Face { normal, offset, first: 0, count: 3 },
            Face { normal: -normal, offset: -offset, first: 3, count: 3 },
        ];
        // 2 area / perimeter
        let inner_radius = doubled.length() / ((b - a).length() + (c - b).length() + (a - c).length());
        Some(Self { vertices, faces, inner_radius })
    }

    pub fn view(&self) -> Polyhedron<'_> {
        Polyhedron {
            vertices: &self.vertices,
            faces: &self.faces,
            corner_vertices: &TRIANGLE_CORNER_VERTICES,
            corner_edges: &TRIANGLE_CORNER_EDGES,
            edges: &TRIANGLE_EDGES,
            center: (self.vertices[0] + self.vertices[1] + self.vertices[2]) / 3.0,
            inner_radius: self.inner_radius,
            side_by_side: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_of_the_box_are_a_closed_surface_walked_from_outside() {
        let half = Vec3::new(1.0, 2.0, 3.0);
        let solid = BoxPolyhedron::new(half);
        let view = solid.view();
        for (i, face) in view.faces.iter().enumerate() {
            let p: Vec<Vec3> = view.face_vertices(i).iter().map(|&v| view.vertices[v as usize]).collect();
            assert!((p[1] - p[0]).cross(p[2] - p[1]).normalize().dot(face.normal) > 0.999, "face {i} winding");
            assert!(p.iter().all(|p| (p.dot(face.normal) - face.offset).abs() < 1e-6), "face {i} plane");
        }
        for (i, edge) in view.edges.iter().enumerate() {
            let [start, end] = view.edge_points(i);
            assert_eq!((end - start).abs().normalize(), Vec3::AXES[i / 4], "edge {i} direction");
            let uses = view.corner_edges.iter().filter(|&&e| e == i as u32).count();
            assert_eq!(uses, 2, "edge {i} has two faces");
            let around = |face: u32| &view.corner_edges[4 * face as usize..][..4];
            assert!(edge.faces.iter().all(|&f| around(f).contains(&(i as u32))));
        }
    }
}
