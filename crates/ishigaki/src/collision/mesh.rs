//! A surface of triangles against everything solid: each triangle near the solid, with our own kernels.
//!
//! The axes are those of two polyhedra, but an axis that the surroundings of the triangle do not allow only
//! separates, it makes no contact (see [`surface`](crate::collision::surface)). Ids are those of the
//! triangle's own vertices and edges; the manifold's `part` tells which triangle.

use crate::collision::clip::Candidates;
use crate::collision::curved::{Curved, curved_triangle};
use crate::collision::feature_id::Feature;
use crate::collision::narrow_phase::{LocalManifolds, with_polyhedron};
use crate::collision::polyhedron::Polyhedron;
use crate::collision::reduce::push_manifold;
use crate::collision::round::{PlacedCapsule, capsule_points, nearest_on_polyhedron, push_ball_of_part};
use crate::collision::sat::{Axis, Pair, Points, Source, Tolerance};
use crate::collision::segment::{SegmentGap, segment_gaps};
use crate::collision::surface::{SurfaceTriangle, Verdict, for_each_triangle};
use crate::math::{Pose, Vec3};
use crate::shape::Geometry;

/// Manifolds of a triangle mesh or height field and a solid, one for each triangle touched.
pub(crate) fn surface_solid(
    surface: &Geometry,
    solid: &Geometry,
    pose: &Pose,
    margin: f32,
    length_scale: f32,
    out: &mut LocalManifolds,
) {
    let (least, greatest) = solid.bounds(pose);
    let (least, greatest) = (least - Vec3::splat(margin), greatest + Vec3::splat(margin));
    let size = solid.inner_radius();
    let tolerance =
        |triangle: &SurfaceTriangle| Tolerance::new(margin, length_scale, size.min(triangle.solid.view().inner_radius));
    match solid {
        Geometry::Ball { radius } => for_each_triangle(surface, least, greatest, |triangle| {
            ball(triangle, *radius, pose.translation, margin, out);
        }),
        Geometry::Capsule { half_length, radius } => {
            let placed = PlacedCapsule::new(*half_length, *radius, pose);
            for_each_triangle(surface, least, greatest, |triangle| {
                capsule(triangle, &placed, &tolerance(triangle), out);
            });
        }
        Geometry::Cuboid { .. } | Geometry::ConvexHull(_) => with_polyhedron(solid, |solid| {
            for_each_triangle(surface, least, greatest, |triangle| {
                polyhedron(triangle, &solid, pose, tolerance(triangle), out);
            });
        }),
        _ => {
            if let Some(curved) = Curved::new(solid) {
                for_each_triangle(surface, least, greatest, |triangle| {
                    curved_triangle(triangle, &curved, pose, &tolerance(triangle), out);
                });
            }
        }
    }
}

/// Whether the solid with this center is on the wrong side of the triangle.
pub(crate) fn is_behind(triangle: &SurfaceTriangle, center: Vec3) -> bool {
    let front = triangle.solid.view().faces[0];
    !triangle.is_ground && front.normal.dot(center) < front.offset
}

fn ball(triangle: &SurfaceTriangle, radius: f32, center: Vec3, margin: f32, out: &mut LocalManifolds) {
    if is_behind(triangle, center) {
        return;
    }
    let mut nearest = nearest_on_polyhedron(&triangle.solid.view(), center);
    match nearest.feature.as_face() {
        Some(0) => {}
        // Under the ground: out the way it came in.
        Some(_) => {
            nearest.normal = triangle.normal;
            nearest.distance = -nearest.distance;
            nearest.feature = Feature::face(0);
        }
        None if triangle.verdict(nearest.normal, center) == Verdict::Allowed => {}
        None => return,
    }
    push_ball_of_part(nearest, radius, center, margin, triangle.index, out);
}

fn capsule(triangle: &SurfaceTriangle, capsule: &PlacedCapsule, tolerance: &Tolerance, out: &mut LocalManifolds) {
    let center = 0.5 * (capsule.ends[0] + capsule.ends[1]);
    if is_behind(triangle, center) {
        return;
    }
    let solid = triangle.solid.view();
    let front = solid.faces[0];
    let Some(gaps) = segment_gaps(&solid, capsule.ends, tolerance.margin + capsule.radius) else { return };
    let mut gap = gaps.choose(tolerance.axis);
    let verdict = match gap.feature.as_face() {
        Some(0) => Verdict::Allowed,
        Some(_) => Verdict::Forbidden,
        None => triangle.verdict(gap.direction, center),
    };
    if verdict == Verdict::Neighbors {
        return;
    }
    if verdict == Verdict::Forbidden {
        let heights = capsule.ends.map(|end| front.normal.dot(end) - front.offset);
        let near = (heights[1] < heights[0]) as usize;
        gap = SegmentGap {
            direction: front.normal,
            distance: heights[near],
            feature: Feature::face(0),
            on_solid: capsule.ends[near] - front.normal * heights[near],
            part: near as f32,
        };
    }
    let over_face_only = gap.feature.as_face().is_some();
    let mut points = capsule_points(&solid, capsule, &gap, tolerance, !over_face_only);
    triangle.drop_inner_points(&mut points);
    push_manifold(-gap.direction, triangle.index, &mut points, tolerance.clip, out);
}

fn polyhedron(
    triangle: &SurfaceTriangle,
    solid: &Polyhedron,
    pose: &Pose,
    tolerance: Tolerance,
    out: &mut LocalManifolds,
) {
    if is_behind(triangle, *pose * solid.center) {
        return;
    }
    let Some(chosen) = contact_axis(triangle, solid, pose, &tolerance) else { return };
    let pair = Pair { a: triangle.solid.view(), b: *solid, b_in_a: pose, part: triangle.index, tolerance };
    let mut points = Candidates::new();
    match chosen.source {
        Source::FaceA(_) => {
            pair.face_points(0, true, &mut points);
        }
        Source::FaceB(_) | Source::Edges(..) => {
            pair.along(&chosen, &mut points);
        }
    }
    triangle.drop_inner_points(&mut points);
    push_manifold(-chosen.direction, pair.part, &mut points, tolerance.clip, out);
}

/// The axis of least overlap that is allowed here; `None` if apart or if a neighbor has the contact.
fn contact_axis(triangle: &SurfaceTriangle, solid: &Polyhedron, pose: &Pose, tolerance: &Tolerance) -> Option<Axis> {
    let center = *pose * solid.center;
    let flat = triangle.solid.view();
    let front = flat.faces[0];
    let down = pose.rotation.inverse() * -front.normal;
    let lowest = *pose * solid.vertices[solid.support(down)];
    let separation = front.normal.dot(lowest) - front.offset;
    let over_face = Axis { source: Source::FaceA(0), direction: front.normal, separation };
    if separation > tolerance.margin {
        return None;
    }
    // A face or edge of the solid must be better than the face of the triangle by a lead.
    let needed = separation + 0.02 * separation.abs() + tolerance.axis;
    let mut best: Option<(Axis, Verdict)> = None;
    let mut consider = |axis: Axis| {
        if axis.separation > best.map_or(needed, |(best, _)| best.separation) {
            match triangle.verdict(axis.direction, center) {
                Verdict::Forbidden => {}
                verdict => best = Some((axis, verdict)),
            }
        }
        axis.separation <= tolerance.margin
    };

    let pose_inverse = pose.inverse();
    let vertices_in_solid: [Vec3; 3] = std::array::from_fn(|k| pose_inverse * flat.vertices[k]);
    for (i, face) in (0..).zip(solid.faces) {
        let heights = vertices_in_solid.map(|v| face.normal.dot(v) - face.offset);
        let separation = heights[0].min(heights[1]).min(heights[2]);
        if !consider(Axis { source: Source::FaceB(i), direction: pose.rotation * -face.normal, separation }) {
            return None;
        }
    }
    for k in 0..3 {
        let [start, end] = [vertices_in_solid[k], vertices_in_solid[(k + 1) % 3]];
        let outward = pose_inverse.rotation * (flat.vertices[(k + 1) % 3] - flat.vertices[k]).cross(front.normal);
        for i in 0..solid.edges.len() {
            let Some((direction, separation)) = edge_axis(start, end, outward, solid, i) else { continue };
            let source = Source::Edges(k as u32, i as u32);
            if !consider(Axis { source, direction: pose.rotation * direction, separation }) {
                return None;
            }
        }
    }
    match best {
        Some((_, Verdict::Neighbors)) => None,
        Some((axis, _)) => Some(axis),
        None => Some(over_face),
    }
}

/// The axis of an edge of the triangle and an edge of the solid, in the frame of the solid, if their arcs cross.
fn edge_axis(start: Vec3, end: Vec3, outward: Vec3, solid: &Polyhedron, edge: usize) -> Option<(Vec3, f32)> {
    let points = solid.edge_points(edge);
    let (along, solid_along) = (end - start, points[1] - points[0]);
    let cross = along.cross(solid_along);
    let square = cross.length_squared();
    if square < 1e-6 * along.length_squared() * solid_along.length_squared() {
        return None;
    }
    let unit = cross / square.sqrt();
    let direction = if unit.dot(outward) >= 0.0 { unit } else { -unit };
    let normals = solid.edges[edge].faces.map(|f| solid.faces[f as usize].normal);
    let cosine = normals[0].dot(normals[1]);
    let on_arc = -direction.dot(normals[0]) >= cosine && -direction.dot(normals[1]) >= cosine;
    on_arc.then(|| (direction, direction.dot(points[0] - start)))
}
