//! Balls and capsules: a core (point or segment) and a radius around it.
//!
//! The contact normal is the direction between the nearest points of the core and the other shape, so it turns
//! smoothly around edges; only where the core itself is inside does a separating axis decide. A capsule that
//! lies on a face or along an edge touches in two points, or it would rock on one.
//! Test: `tests/narrow_phase.rs`.

use crate::collision::clip::{Candidates, Clip, nearest_on_segments};
use crate::collision::feature_id::{Feature, FeatureId};
use crate::collision::manifold::LocalPoint;
use crate::collision::narrow_phase::LocalManifolds;
use crate::collision::polyhedron::{Corner, Polygon, Polyhedron, box_edge, box_face, box_normal};
use crate::collision::reduce::{push_manifold, push_point};
use crate::collision::sat::Tolerance;
use crate::collision::segment::{SegmentGap, segment_gaps};
use crate::math::{Pose, Vec3, tangents};
use smallvec::{SmallVec, smallvec};

/// Sine of the angle below which a capsule lies along an edge or another capsule.
const ALONG: f32 = 0.03;
/// What touches an edge in a direction within this cosine of a face's normal may be skimming over the face.
const SKIMMING: f32 = 0.3;

/// The point of a shape nearest to a given one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nearest {
    pub point: Vec3,
    /// Unit, outward.
    pub normal: Vec3,
    /// m; negative inside.
    pub distance: f32,
    pub feature: Feature,
}

impl Nearest {
    /// Nearest point outside; `fallback` is the normal where the point lies on the surface.
    fn outside(point: Vec3, to: Vec3, fallback: Vec3, feature: Feature) -> Self {
        let distance = (to - point).length();
        let normal = if distance > 1e-9 { (to - point) / distance } else { fallback };
        Self { point, normal, distance, feature }
    }
}

/// Two balls, the second at `center`.
pub(crate) fn ball_ball(radius_a: f32, radius_b: f32, center: Vec3, margin: f32, out: &mut LocalManifolds) {
    let feature = Feature::vertex(0);
    push_ball(Nearest::outside(Vec3::ZERO, center, Vec3::Y, feature), radius_a, radius_b, center, margin, out);
}

/// A capsule along Y and a ball at `center`.
pub(crate) fn capsule_ball(
    (half_length, radius_a): (f32, f32),
    radius_b: f32,
    center: Vec3,
    margin: f32,
    out: &mut LocalManifolds,
) {
    let height = center.y.clamp(-half_length, half_length);
    let feature = segment_feature(height, half_length);
    push_ball(
        Nearest::outside(Vec3::new(0.0, height, 0.0), center, Vec3::X, feature),
        radius_a,
        radius_b,
        center,
        margin,
        out,
    );
}

/// The one point where a ball at `center` touches; the core of A is `radius_a` thick.
fn push_ball(nearest: Nearest, radius_a: f32, radius_b: f32, center: Vec3, margin: f32, out: &mut LocalManifolds) {
    let distance = nearest.distance - radius_a;
    let point = nearest.point + nearest.normal * radius_a;
    push_ball_of_part(Nearest { point, distance, ..nearest }, radius_b, center, margin, 0, out);
}

/// The one point where a ball at `center` touches.
pub(crate) fn push_ball_of_part(
    nearest: Nearest,
    radius: f32,
    center: Vec3,
    margin: f32,
    part: u32,
    out: &mut LocalManifolds,
) {
    let separation = nearest.distance - radius;
    if separation > margin {
        return;
    }
    let on_b = center - nearest.normal * radius;
    let id = FeatureId::new(nearest.feature, Feature::vertex(0));
    push_point(-nearest.normal, part, LocalPoint { on_a: nearest.point, on_b, separation, id }, out);
}

fn segment_feature(height: f32, half_length: f32) -> Feature {
    if height >= half_length {
        Feature::vertex(1)
    } else if height <= -half_length {
        Feature::vertex(0)
    } else {
        Feature::edge(0)
    }
}

/// The point of a box nearest to `point`.
pub(crate) fn nearest_on_box(half: Vec3, point: Vec3) -> Nearest {
    let inside = point.clamp(-half, half);
    if inside != point {
        let outward = point - inside;
        let beyond: [bool; 3] = std::array::from_fn(|k| outward[k] != 0.0);
        let positive: [usize; 3] = std::array::from_fn(|k| (point[k] > 0.0) as usize);
        let feature = match beyond.iter().filter(|&&b| b).count() {
            1 => {
                let axis = beyond.iter().position(|&b| b).unwrap_or(0);
                Feature::face(box_face(axis, positive[axis] == 1) as u32)
            }
            2 => {
                let axis = beyond.iter().position(|&b| !b).unwrap_or(0);
                Feature::edge(box_edge(axis, positive[(axis + 1) % 3], positive[(axis + 2) % 3]) as u32)
            }
            _ => Feature::vertex((positive[0] | positive[1] << 1 | positive[2] << 2) as u32),
        };
        return Nearest::outside(inside, point, outward.normalize_or(Vec3::Y), feature);
    }
    let depth = half - point.abs();
    let axis = if depth.x <= depth.y && depth.x <= depth.z {
        0
    } else if depth.y <= depth.z {
        1
    } else {
        2
    };
    let face = box_face(axis, point[axis] >= 0.0);
    let normal = box_normal(face);
    Nearest { point: point + normal * depth[axis], normal, distance: -depth[axis], feature: Feature::face(face as u32) }
}

/// The point of a polyhedron nearest to `point`.
pub(crate) fn nearest_on_polyhedron(solid: &Polyhedron, point: Vec3) -> Nearest {
    let mut best = (0, f32::NEG_INFINITY);
    let mut is_seen: SmallVec<[bool; 32]> = SmallVec::new();
    for (i, face) in solid.faces.iter().enumerate() {
        let distance = face.normal.dot(point) - face.offset;
        is_seen.push(distance > 0.0);
        if distance > best.1 {
            best = (i, distance);
        }
        // Over the inside of a face it sees, that face is nearest.
        if distance > 0.0 && is_over(solid, i, point) {
            best = (i, distance);
            break;
        }
    }
    let (face, distance) = best;
    let normal = solid.faces[face].normal;
    if distance <= 0.0 || is_over(solid, face, point) {
        let feature = Feature::face(face as u32);
        return Nearest { point: point - normal * distance, normal, distance, feature };
    }
    // No edge is nearest between two faces that look away.
    let mut nearest: Option<(f32, Vec3, Feature)> = None;
    for (i, edge) in solid.edges.iter().enumerate() {
        if !edge.faces.iter().any(|&face| is_seen[face as usize]) {
            continue;
        }
        let [start, end] = solid.edge_points(i);
        let along = end - start;
        let part = (point - start).dot(along) / along.length_squared();
        let (on_edge, feature) = if part <= 0.0 {
            (start, Feature::vertex(edge.vertices[0]))
        } else if part >= 1.0 {
            (end, Feature::vertex(edge.vertices[1]))
        } else {
            (start + along * part, Feature::edge(i as u32))
        };
        let square = (point - on_edge).length_squared();
        if nearest.is_none_or(|best| square < best.0) {
            nearest = Some((square, on_edge, feature));
        }
    }
    let (_, on_edge, feature) = nearest.unwrap_or((0.0, point, Feature::face(face as u32)));
    Nearest::outside(on_edge, point, normal, feature)
}

/// Whether the point projects into the face.
pub(crate) fn is_over(solid: &Polyhedron, face: usize, point: Vec3) -> bool {
    let normal = solid.faces[face].normal;
    let corners = solid.face_vertices(face);
    corners.iter().enumerate().all(|(i, &corner)| {
        let start = solid.vertices[corner as usize];
        let end = solid.vertices[corners[(i + 1) % corners.len()] as usize];
        (end - start).cross(normal).dot(point - start) <= 0.0
    })
}

/// A capsule in the frame of A: both ends of its segment, and the radius.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlacedCapsule {
    pub ends: [Vec3; 2],
    pub radius: f32,
}

impl PlacedCapsule {
    pub fn new(half_length: f32, radius: f32, pose: &Pose) -> Self {
        let half = pose.rotation * Vec3::new(0.0, half_length, 0.0);
        Self { ends: [pose.translation - half, pose.translation + half], radius }
    }

    fn along(&self) -> Vec3 {
        self.ends[1] - self.ends[0]
    }

    /// The segment as a polygon of two corners.
    fn polygon(&self) -> Polygon {
        let corner = |i: usize| Corner { point: self.ends[i], vertex: i as u32, edge: 0 };
        Polygon { normal: Vec3::Y, offset: 0.0, face: 0, corners: smallvec![corner(0), corner(1)] }
    }

    fn feature(part: f32) -> Feature {
        if part <= 0.0 {
            Feature::vertex(0)
        } else if part >= 1.0 {
            Feature::vertex(1)
        } else {
            Feature::edge(0)
        }
    }
}

/// Two capsules in the frame of A.
pub(crate) fn capsule_capsule(a: &PlacedCapsule, b: &PlacedCapsule, margin: f32, out: &mut LocalManifolds) {
    let (s, t) = nearest_on_segments(a.ends, b.ends);
    let (on_core_a, on_core_b) = (a.ends[0].lerp(a.ends[1], s), b.ends[0].lerp(b.ends[1], t));
    let gap = on_core_b - on_core_a;
    let distance = gap.length();
    let radii = a.radius + b.radius;
    if distance - radii > margin {
        return;
    }
    let (along_a, along_b) = (a.along(), b.along());
    let size = a.radius.min(b.radius);
    // From A to B; cores that cross part along their common perpendicular.
    let direction = if distance > 1e-4 * size {
        gap / distance
    } else {
        let axis = if along_a.length_squared() >= along_b.length_squared() { along_a } else { along_b };
        let across = along_a.cross(along_b).try_normalize().filter(|_| sine(along_a, along_b) > ALONG);
        across.unwrap_or_else(|| axis.try_normalize().map_or(Vec3::Y, |axis| tangents(axis).0))
    };
    let point = |s: f32, t: f32, id: FeatureId| {
        let (core_a, core_b) = (a.ends[0].lerp(a.ends[1], s), b.ends[0].lerp(b.ends[1], t));
        let separation = (core_b - core_a).dot(direction) - radii;
        LocalPoint { on_a: core_a + direction * a.radius, on_b: core_b - direction * b.radius, separation, id }
    };
    let mut points = Candidates::new();
    if sine(along_a, along_b) < ALONG
        && direction.dot(along_a).abs() < 2.0 * ALONG * along_a.length()
        && let Some(overlap) = overlap_along(a.ends, b.ends)
    {
        for end in overlap {
            let feature_a = if end.of_first { Feature::vertex(end.end) } else { Feature::edge(0) };
            let feature_b = if end.of_first { Feature::edge(0) } else { Feature::vertex(end.end) };
            let point = point(end.first, end.second, FeatureId::new(feature_a, feature_b));
            if point.separation <= margin {
                points.push(point);
            }
        }
    }
    if points.is_empty() {
        points.push(point(s, t, FeatureId::new(PlacedCapsule::feature(s), PlacedCapsule::feature(t))));
    }
    push_manifold(-direction, 0, &mut points, 0.0, out);
}

pub(crate) fn sine(a: Vec3, b: Vec3) -> f32 {
    let lengths = a.length() * b.length();
    if lengths > 0.0 { a.cross(b).length() / lengths } else { 1.0 }
}

/// An end of the stretch where two nearly parallel segments run side by side.
pub(crate) struct OverlapEnd {
    /// Part of the first and of the second segment.
    pub first: f32,
    pub second: f32,
    /// Which segment ends here, and with which end.
    pub of_first: bool,
    pub end: u32,
}

/// The stretch where two nearly parallel segments run side by side; `None` if it is a point or less.
pub(crate) fn overlap_along(first: [Vec3; 2], second: [Vec3; 2]) -> Option<[OverlapEnd; 2]> {
    let (along1, along2) = (first[1] - first[0], second[1] - second[0]);
    let part1 = |p: Vec3| (p - first[0]).dot(along1) / along1.length_squared();
    let part2 = |p: Vec3| (p - second[0]).dot(along2) / along2.length_squared();
    let ends = second.map(part1);
    let (low, high) = if ends[0] <= ends[1] { (0, 1) } else { (1, 0) };
    if ends[low].max(0.0) >= ends[high].min(1.0) {
        return None;
    }
    let end = |second_end: usize, limit: usize, inside: bool| {
        if inside {
            OverlapEnd { first: ends[second_end], second: second_end as f32, of_first: false, end: second_end as u32 }
        } else {
            let second = part2(first[limit]).clamp(0.0, 1.0);
            OverlapEnd { first: limit as f32, second, of_first: true, end: limit as u32 }
        }
    };
    Some([end(low, 0, ends[low] > 0.0), end(high, 1, ends[high] < 1.0)])
}

/// A polyhedron and a capsule in its frame.
pub(crate) fn polyhedron_capsule(
    solid: &Polyhedron,
    capsule: &PlacedCapsule,
    margin: f32,
    length_scale: f32,
    out: &mut LocalManifolds,
) {
    let tolerance = Tolerance::new(margin, length_scale, solid.inner_radius.min(capsule.radius));
    let reach = margin + capsule.radius;
    let Some(gaps) = segment_gaps(solid, capsule.ends, reach) else { return };
    let mut gap = gaps.choose(tolerance.axis);
    if gap.distance > reach {
        return;
    }
    let mut points = capsule_points(solid, capsule, &gap, &tolerance, false);
    let over_face = points.iter().any(|p| p.separation <= gap.distance - capsule.radius + tolerance.axis);
    if !over_face {
        // The deepest end is just beside the face it seemed to lie on.
        gap = gaps.choose(0.0);
        points = capsule_points(solid, capsule, &gap, &tolerance, true);
        let skims = skims(solid, (gap.feature, gap.direction), &capsule.ends, capsule.radius, &tolerance);
        points.retain(|p| p.separation <= 0.0 || !skims);
    }
    push_manifold(-gap.direction, 0, &mut points, tolerance.clip, out);
}

/// Whether what comes near an edge or a vertex only skims over the plane of a face beside it: a floor of flush
/// boxes goes on there, and a contact that is not yet one would slow what rolls over the seam.
fn skims(
    solid: &Polyhedron,
    (feature, direction): (Feature, Vec3),
    core: &[Vec3],
    radius: f32,
    tolerance: &Tolerance,
) -> bool {
    let lowest = |normal: Vec3| core.iter().map(|p| normal.dot(*p)).fold(f32::INFINITY, f32::min) - radius;
    feature.as_face().is_none()
        && solid
            .faces
            .iter()
            .any(|face| face.normal.dot(direction) > SKIMMING && lowest(face.normal) - face.offset >= -tolerance.sliver)
}

/// A polyhedron and a ball in its frame, whose center is nearest to `nearest`.
pub(crate) fn polyhedron_ball(
    solid: &Polyhedron,
    nearest: Nearest,
    (radius, center): (f32, Vec3),
    margin: f32,
    length_scale: f32,
    out: &mut LocalManifolds,
) {
    let tolerance = Tolerance::new(margin, length_scale, solid.inner_radius.min(radius));
    let apart = nearest.distance > radius;
    if !(apart && skims(solid, (nearest.feature, nearest.normal), &[center], radius, &tolerance)) {
        push_ball_of_part(nearest, radius, center, margin, 0, out);
    }
}

/// Where a polyhedron and a capsule touch along the direction of `gap`.
///
/// Where clipping finds nothing the nearest point stands alone, if `may_stand_alone`.
pub(crate) fn capsule_points(
    solid: &Polyhedron,
    capsule: &PlacedCapsule,
    gap: &SegmentGap,
    tolerance: &Tolerance,
    may_stand_alone: bool,
) -> Candidates {
    let margin = tolerance.margin;
    let mut points = Candidates::new();
    if let Some(face) = gap.feature.as_face() {
        let clip = Clip { reference_is_a: true, radius: capsule.radius, margin, tolerance: tolerance.clip };
        clip.points(&solid.polygon(face as usize, &Pose::IDENTITY), &capsule.polygon(), &mut points);
    } else if let Some(edge) = gap.feature.as_edge() {
        along_edge(solid, edge as usize, capsule, gap.direction, margin, &mut points);
    }
    let separation = gap.distance - capsule.radius;
    if points.is_empty() && may_stand_alone && separation <= margin {
        let core = capsule.ends[0].lerp(capsule.ends[1], gap.part);
        let id = FeatureId::new(gap.feature, PlacedCapsule::feature(gap.part));
        points.push(LocalPoint { on_a: gap.on_solid, on_b: core - gap.direction * capsule.radius, separation, id });
    }
    points
}

/// Two points where a capsule lies along an edge.
fn along_edge(
    solid: &Polyhedron,
    edge: usize,
    capsule: &PlacedCapsule,
    direction: Vec3,
    margin: f32,
    points: &mut Candidates,
) {
    let ends = solid.edge_points(edge);
    if sine(ends[1] - ends[0], capsule.along()) >= ALONG {
        return;
    }
    for end in overlap_along(ends, capsule.ends).into_iter().flatten() {
        let on_a = ends[0].lerp(ends[1], end.first);
        let core = capsule.ends[0].lerp(capsule.ends[1], end.second);
        let separation = (core - on_a).dot(direction) - capsule.radius;
        let id = if end.of_first {
            FeatureId::new(Feature::vertex(solid.edges[edge].vertices[end.end as usize]), Feature::edge(0))
        } else {
            FeatureId::new(Feature::edge(edge as u32), Feature::vertex(end.end))
        };
        if separation <= margin {
            points.push(LocalPoint { on_a, on_b: core - direction * capsule.radius, separation, id });
        }
    }
}
