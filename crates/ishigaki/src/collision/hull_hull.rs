//! Two convex polyhedra: the separating axis test, with pairs of edges pruned on the Gauss map.
//!
//! An edge is an arc between the normals of its two faces on the unit sphere. Two edges can make a face of the
//! Minkowski difference A − B, and so a separating axis, only if the arc of one crosses the negated arc of the
//! other; most pairs are rejected by four dot products (Gregorius 2013, "The separating axis test between
//! convex polyhedra"). Test: `tests/narrow_phase.rs` against a search over all axes in f64.

use crate::collision::narrow_phase::LocalManifolds;
use crate::collision::polyhedron::Polyhedron;
use crate::collision::sat::{Axis, Pair, Source, Tolerance, choose_axis};
use crate::math::{Mat3, Pose, Vec3};
use smallvec::SmallVec;

/// Square of the sine of the angle below which two edges count as parallel.
const PARALLEL_SQUARED: f32 = 1e-6;

/// Manifold of two polyhedra.
pub(crate) fn hull_hull(
    a: Polyhedron,
    b: Polyhedron,
    b_in_a: &Pose,
    margin: f32,
    length_scale: f32,
    hint: &mut u32,
    out: &mut LocalManifolds,
) {
    let a_in_b = b_in_a.inverse();
    if let Some((source, _)) = Source::from_hint(*hint)
        && let Some(axis) = face_axis(&a, &b, b_in_a, &a_in_b, source)
        && axis.separation > margin
    {
        // Still apart along the axis of the last step.
        *hint = axis.source.to_hint(true);
        return;
    }
    let mut faces: SmallVec<[Axis; 32]> = SmallVec::new();
    let sources_a = (0..a.faces.len() as u32).map(Source::FaceA);
    let sources_b = (0..b.faces.len() as u32).map(Source::FaceB);
    for source in sources_a.chain(sources_b) {
        let Some(axis) = face_axis(&a, &b, b_in_a, &a_in_b, source) else { continue };
        if axis.separation > margin {
            *hint = axis.source.to_hint(true);
            return;
        }
        faces.push(axis);
    }
    let (edges, last_edges) = edge_axes(&a, &b, b_in_a, *hint);
    if let Some(apart) = edges.filter(|axis| axis.separation > margin) {
        *hint = apart.source.to_hint(true);
        return;
    }
    let tolerance = Tolerance::new(margin, length_scale, a.inner_radius.min(b.inner_radius));
    match choose_axis(&faces, edges, last_edges, &tolerance, *hint) {
        Some(axis) => {
            *hint = axis.source.to_hint(axis.separation > 0.0);
            Pair { a, b, b_in_a, part: (0, 0), tolerance }.push_contact(&axis, &faces, edges, out);
        }
        None => {
            let apart = faces.iter().max_by(|p, q| p.separation.total_cmp(&q.separation));
            if let Some(apart) = apart.filter(|axis| axis.separation > 0.0) {
                *hint = apart.source.to_hint(true);
            }
        }
    }
}

/// The axis of one face; `None` if the hint names a face that does not exist, or no face.
fn face_axis(a: &Polyhedron, b: &Polyhedron, b_in_a: &Pose, a_in_b: &Pose, source: Source) -> Option<Axis> {
    let (direction, separation) = match source {
        Source::FaceA(face) => {
            let face = a.faces.get(face as usize)?;
            let (normal, offset) = plane_in(a_in_b, face.normal, face.offset);
            (face.normal, b.vertices[b.support(-normal)].dot(normal) - offset)
        }
        Source::FaceB(face) => {
            let face = b.faces.get(face as usize)?;
            let (normal, offset) = plane_in(b_in_a, face.normal, face.offset);
            (-normal, a.vertices[a.support(-normal)].dot(normal) - offset)
        }
        Source::Edges(..) => return None,
    };
    Some(Axis { source, direction, separation })
}

/// A plane in another frame.
fn plane_in(pose: &Pose, normal: Vec3, offset: f32) -> (Vec3, f32) {
    let normal = pose.rotation * normal;
    (normal, offset + normal.dot(pose.translation))
}

/// An edge in the frame of A, with the normals of its faces.
struct PlacedEdge {
    start: Vec3,
    along: Vec3,
    normals: [Vec3; 2],
}

fn place(polyhedron: &Polyhedron, edge: usize, turn: &Mat3, translation: Vec3) -> PlacedEdge {
    let [start, end] = polyhedron.edge_points(edge);
    let normals = polyhedron.edges[edge].faces.map(|f| *turn * polyhedron.faces[f as usize].normal);
    PlacedEdge { start: *turn * start + translation, along: *turn * (end - start), normals }
}

/// The best axis of two edges, and that of the last step if it still is one.
fn edge_axes(a: &Polyhedron, b: &Polyhedron, b_in_a: &Pose, hint: u32) -> (Option<Axis>, Option<Axis>) {
    let turn = Mat3::from_quat(b_in_a.rotation);
    let edges_b: SmallVec<[PlacedEdge; 32]> =
        (0..b.edges.len()).map(|e| place(b, e, &turn, b_in_a.translation)).collect();
    let last = Source::from_hint(hint).map(|(source, _)| source);
    let mut best: Option<Axis> = None;
    let mut last_axis = None;
    for i in 0..a.edges.len() {
        let edge_a = place(a, i, &Mat3::IDENTITY, Vec3::ZERO);
        for (j, edge_b) in edges_b.iter().enumerate() {
            if !arcs_cross(&edge_a, edge_b) {
                continue;
            }
            let cross = edge_a.along.cross(edge_b.along);
            let square = cross.length_squared();
            if square < PARALLEL_SQUARED * edge_a.along.length_squared() * edge_b.along.length_squared() {
                continue;
            }
            let unit = cross / square.sqrt();
            // Outward from A: on the side of the normals of the edge.
            let direction = if unit.dot(edge_a.normals[0] + edge_a.normals[1]) >= 0.0 { unit } else { -unit };
            let separation = direction.dot(edge_b.start - edge_a.start);
            let axis = Axis { source: Source::Edges(i as u32, j as u32), direction, separation };
            if best.is_none_or(|best| separation > best.separation) {
                best = Some(axis);
            }
            if last == Some(axis.source) {
                last_axis = Some(axis);
            }
        }
    }
    (best, last_axis)
}

/// Whether the arc (a₀, a₁) crosses the arc (−b₀, −b₁) on the unit sphere.
fn arcs_cross(a: &PlacedEdge, b: &PlacedEdge) -> bool {
    // The edge is along a₀ × a₁ up to a positive factor, so it stands for the plane of the arc.
    let (a0, a1) = (a.normals[0], a.normals[1]);
    let (b0, b1) = (-b.normals[0], -b.normals[1]);
    let (b0_side, b1_side) = (b0.dot(a.along), b1.dot(a.along));
    let (a0_side, a1_side) = (a0.dot(b.along), a1.dot(b.along));
    // Each arc has its ends on both sides of the other's plane …
    if b0_side * b1_side >= 0.0 || a0_side * a1_side >= 0.0 {
        return false;
    }
    // … and both lie on the same half of the sphere.
    same_half(a0, a1, b0, b1)
}

/// Whether two arcs whose planes separate each other's ends cross in the same half, not in opposite points.
fn same_half(a0: Vec3, a1: Vec3, b0: Vec3, b1: Vec3) -> bool {
    // The arc b meets the plane of a in this direction (its ends are on both sides).
    let plane = a0.cross(a1);
    let (d0, d1) = (b0.dot(plane), b1.dot(plane));
    let meet = b0 * d1.abs() + b1 * d0.abs();
    meet.dot(a0 + a1) > 0.0
}
