//! A surface of triangles against everything solid: each triangle near the solid, with our own kernels.
//!
//! The axes are those of two polyhedra, but an axis that the surroundings of the triangle do not allow only
//! separates, it makes no contact (see [`surface`](crate::collision::surface)). Ids are those of the
//! triangle's own vertices and edges; the manifold's `part` tells which triangle.

use crate::collision::clip::Candidates;
use crate::collision::curved::{Curved, curved_triangle};
use crate::collision::feature_id::Feature;
use crate::collision::narrow_phase::{LocalManifolds, with_polyhedron};
use crate::collision::polyhedron::{Polyhedron, box_edge, box_edge_points};
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
        Geometry::Ball { radius } => for_each_triangle(surface, least, greatest, &mut |triangle| {
            ball(triangle, *radius, pose.translation, margin, out);
        }),
        Geometry::Capsule { half_length, radius } => {
            let placed = PlacedCapsule::new(*half_length, *radius, pose);
            for_each_triangle(surface, least, greatest, &mut |triangle| {
                capsule(triangle, &placed, &tolerance(triangle), out);
            });
        }
        Geometry::Cuboid { .. } | Geometry::ConvexHull(_) => with_polyhedron(solid, |view| {
            let half = if let Geometry::Cuboid { half_extents } = solid { Some(*half_extents) } else { None };
            let placed = Placed { solid: view, half, pose, inverse: pose.inverse(), center: *pose * view.center };
            for_each_triangle(surface, least, greatest, &mut |triangle| {
                polyhedron(triangle, &placed, tolerance(triangle), out);
            });
        }),
        _ => {
            if let Some(curved) = Curved::new(solid) {
                for_each_triangle(surface, least, greatest, &mut |triangle| {
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

/// A polyhedron in the frame of the surface.
struct Placed<'a> {
    solid: Polyhedron<'a>,
    /// Half extents of a box.
    half: Option<Vec3>,
    pose: &'a Pose,
    inverse: Pose,
    center: Vec3,
}

fn polyhedron(triangle: &SurfaceTriangle, placed: &Placed<'_>, tolerance: Tolerance, out: &mut LocalManifolds) {
    if is_behind(triangle, placed.center) {
        return;
    }
    let Some(chosen) = contact_axis(triangle, placed, &tolerance) else { return };
    let pair = Pair { a: triangle.solid.view(), b: placed.solid, b_in_a: placed.pose, part: triangle.index, tolerance };
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
fn contact_axis(triangle: &SurfaceTriangle, placed: &Placed<'_>, tolerance: &Tolerance) -> Option<Axis> {
    let &Placed { ref solid, half, pose, inverse, .. } = placed;
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
    let lead = 0.02 * separation.abs() + tolerance.axis;
    let mut choice = Choice { triangle, placed, margin: tolerance.margin, greatest: separation + lead, best: None };
    let vertices_in_solid: [Vec3; 3] = std::array::from_fn(|k| inverse * flat.vertices[k]);
    for (i, face) in (0..).zip(solid.faces) {
        let heights = vertices_in_solid.map(|v| face.normal.dot(v) - face.offset);
        let separation = heights[0].min(heights[1]).min(heights[2]);
        if !choice.consider(Source::FaceB(i), -face.normal, separation) {
            return None;
        }
    }
    for k in 0..3 {
        let [start, end] = [vertices_in_solid[k], vertices_in_solid[(k + 1) % 3]];
        let outward = inverse.rotation * (flat.vertices[(k + 1) % 3] - flat.vertices[k]).cross(front.normal);
        // Of four edges of a box side by side one can have the contact.
        let tries = if half.is_some() { 3 } else { solid.edges.len() };
        for i in 0..tries {
            let found = match half {
                Some(half) => box_edge_axis(start, end, outward, half, i, choice.greatest),
                None => edge_axis(start, end, outward, solid, i).map(|(direction, gap)| (direction, gap, i)),
            };
            let Some((direction, separation, edge)) = found else { continue };
            if !choice.consider(Source::Edges(k as u32, edge as u32), direction, separation) {
                return None;
            }
        }
    }
    match choice.best {
        Some((_, Verdict::Neighbors)) => None,
        Some((axis, _)) => Some(axis),
        None => Some(over_face),
    }
}

/// The best of the axes seen.
struct Choice<'a> {
    triangle: &'a SurfaceTriangle,
    placed: &'a Placed<'a>,
    margin: f32,
    /// What an axis must be better than.
    greatest: f32,
    best: Option<(Axis, Verdict)>,
}

impl Choice<'_> {
    /// Looks at an axis in the frame of the solid; whether the shapes are near along it.
    fn consider(&mut self, source: Source, direction: Vec3, separation: f32) -> bool {
        let is_near = separation <= self.margin;
        if is_near && separation > self.greatest {
            let direction = self.placed.pose.rotation * direction;
            match self.triangle.verdict(direction, self.placed.center) {
                Verdict::Forbidden => {}
                verdict => {
                    self.greatest = separation;
                    self.best = Some((Axis { source, direction, separation }, verdict));
                }
            }
        }
        is_near
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

/// The same of the edges of a box along one of its axes, and which of them it is; those whose separation is below
/// `least` may be left out, most of them without a root.
fn box_edge_axis(
    start: Vec3,
    end: Vec3,
    outward: Vec3,
    half: Vec3,
    axis: usize,
    least: f32,
) -> Option<(Vec3, f32, usize)> {
    let along = end - start;
    let cross = along.cross(Vec3::AXES[axis]);
    let cross = if cross.dot(outward) >= 0.0 { cross } else { -cross };
    let positive = |k: usize| usize::from(cross[k % 3] < 0.0);
    let edge = box_edge(axis, positive(axis + 1), positive(axis + 2));
    let [point, _] = box_edge_points(half, edge);
    // Shorter than the edge it is made from: where negative, the separation is no greater than this over its length.
    let (scaled, square, longest) = (cross.dot(point - start), cross.length_squared(), along.length_squared());
    let limit = least.min(0.0);
    if scaled < 0.0 && scaled * scaled > 1.000_01 * limit * limit * longest || square < 1e-6 * longest {
        return None;
    }
    let length = square.sqrt();
    Some((cross / length, scaled / length, edge))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::polyhedron::BoxPolyhedron;
    use crate::solver::permutation::Random;

    #[test]
    fn edges_of_a_box_cross_as_those_of_any_polyhedron() {
        let mut random = Random(3);
        let mut number = || (random.bits() >> 40) as f32 / (1 << 23) as f32 - 1.0;
        for _ in 0..500 {
            let mut vector = || Vec3::new(number(), number(), number());
            let half = vector().abs() + Vec3::splat(0.1);
            let (start, end, outward) = (vector(), vector(), vector());
            let solid = BoxPolyhedron::new(half);
            for axis in 0..3 {
                let (direction, gap, edge) = box_edge_axis(start, end, outward, half, axis, f32::NEG_INFINITY).unwrap();
                let others = (4 * axis..4 * axis + 4)
                    .filter_map(|i| Some((i, edge_axis(start, end, outward, &solid.view(), i)?)));
                let others: Vec<_> = others.collect();
                assert_eq!(others.len(), 1, "one of four edges");
                let (name, (same, other_gap)) = others[0];
                assert_eq!(name, edge);
                assert!((same - direction).length() < 1e-6 && (other_gap - gap).abs() < 1e-5);
            }
        }
    }
}
