//! Cylinders and cones against capsules, polyhedra and each other.
//!
//! parry's GJK and EPA give direction and depth; the points are ours. Where a flat face or cap is as good a
//! direction as theirs (within a tolerance), the features of both shapes toward each other are clipped as for
//! polyhedra: a cap has eight rim points with fixed names and the deepest point of its rim, a side has the line that
//! lies lowest. Two side lines that run along each other touch in two points; all else touches in one.
//! Test: `tests/narrow_phase.rs`.

use crate::collision::clip::{Candidates, Clip};
use crate::collision::feature_id::{Feature, FeatureId};
use crate::collision::half_space::{RIM_POINTS, rim_points};
use crate::collision::manifold::LocalPoint;
use crate::collision::mesh::is_behind;
use crate::collision::narrow_phase::LocalManifolds;
use crate::collision::polyhedron::{Corner, Polygon, Polyhedron};
use crate::collision::reduce::push_manifold;
use crate::collision::round::{overlap_along, sine};
use crate::collision::sat::{Axis, Source, Tolerance, pass_corners};
use crate::collision::surface::{SurfaceTriangle, Verdict};
use crate::math::{Pose, Vec3, cos};
use crate::shape::Geometry;
use parry3d::query::{DefaultQueryDispatcher, QueryDispatcher};
use parry3d::shape::{Capsule, Cone, Cylinder, Shape, Triangle};
use smallvec::SmallVec;

/// A cap or face is looked at if its normal is within this cosine of the direction of contact.
const FACING: f32 = 0.9;
/// Steeper than this a cap shows its rim, not its side line.
const CAP: f32 = 0.7;
/// Sine of the angle below which side lines run along each other.
const ALONG: f32 = 0.03;
/// Sides of the polygon that stands for a cap when others are clipped to it; it contains the disk.
const CAP_SIDES: u32 = 16;
/// Numbers of the deepest points of the rims at the bottom and at the top, after the fixed ones.
pub(crate) const DEEPEST: u32 = 2 * RIM_POINTS;
/// Number of the side line.
const SIDE_LINE: u32 = 2 * RIM_POINTS;

/// A cylinder or a cone about Y.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Curved {
    half_height: f32,
    radius: f32,
    /// Of the top; 0 for a cone.
    top_radius: f32,
}

/// What a cylinder or cone can meet.
#[derive(Clone, Copy)]
pub(crate) enum Solid<'a> {
    Polyhedron(Polyhedron<'a>),
    Curved(Curved),
    /// Half length and radius, m.
    Capsule(f32, f32),
}

/// What a solid holds out to the other: a polygon, line or point, `radius` under the surface.
struct Feeler {
    polygon: Polygon,
    radius: f32,
    /// The deepest point of a rim, besides its fixed points.
    deepest: Option<Polygon>,
}

fn points_polygon(points: &[(Vec3, u32)], edge: u32, face: u32, pose: &Pose) -> Polygon {
    let corner = |&(point, vertex): &(Vec3, u32)| Corner { point: *pose * point, vertex, edge };
    Polygon { normal: Vec3::Y, offset: 0.0, face, corners: points.iter().map(corner).collect() }
}

impl Curved {
    /// `None` for all but cylinders and cones.
    pub fn new(geometry: &Geometry) -> Option<Self> {
        match *geometry {
            Geometry::Cylinder { half_height, radius } => Some(Self { half_height, radius, top_radius: radius }),
            Geometry::Cone { half_height, radius } => Some(Self { half_height, radius, top_radius: 0.0 }),
            _ => None,
        }
    }

    fn with_parry<R>(&self, use_it: impl FnOnce(&dyn Shape) -> R) -> R {
        if self.top_radius > 0.0 {
            use_it(&Cylinder::new(self.half_height, self.radius))
        } else {
            use_it(&Cone::new(self.half_height, self.radius))
        }
    }

    /// Bottom and top points of the side line on the side of `direction`, with their numbers.
    fn side_line(&self, direction: Vec3) -> [(Vec3, u32); 2] {
        let outward = Vec3::new(direction.x, 0.0, direction.z).normalize_or(Vec3::X);
        let bottom = outward * self.radius - Vec3::Y * self.half_height;
        let top = outward * self.top_radius + Vec3::Y * self.half_height;
        [(bottom, DEEPEST), (top, if self.top_radius > 0.0 { DEEPEST + 1 } else { RIM_POINTS })]
    }

    fn support(&self, direction: Vec3) -> Vec3 {
        let [(bottom, _), (top, _)] = self.side_line(direction);
        if top.dot(direction) > bottom.dot(direction) { top } else { bottom }
    }

    /// The cap that looks along `direction`: 0 at the bottom, 1 at the top.
    fn cap(&self, direction: Vec3, cosine: f32) -> Option<u32> {
        if -direction.y > cosine {
            Some(0)
        } else if direction.y > cosine && self.top_radius > 0.0 {
            Some(1)
        } else {
            None
        }
    }

    fn cap_height(&self, cap: u32) -> f32 {
        if cap == 0 { -self.half_height } else { self.half_height }
    }

    fn feeler(&self, direction: Vec3, pose: &Pose) -> Feeler {
        let line = self.side_line(direction);
        let Some(cap) = self.cap(direction, CAP) else {
            return Feeler { polygon: points_polygon(&line, SIDE_LINE, 2, pose), radius: 0.0, deepest: None };
        };
        let rim = rim_points(self.cap_height(cap), self.radius);
        let corner = |i: u32| Corner {
            point: *pose * rim[i as usize],
            vertex: cap * RIM_POINTS + i,
            // The edge to the next corner has the number of the corner with the lesser angle.
            edge: cap * RIM_POINTS + if cap == 1 { i } else { (i + RIM_POINTS - 1) % RIM_POINTS },
        };
        let order = 0..RIM_POINTS;
        let corners: SmallVec<[Corner; 8]> =
            if cap == 1 { order.map(corner).collect() } else { order.rev().map(corner).collect() };
        let deepest = points_polygon(&[line[cap as usize]], SIDE_LINE, cap, pose);
        let polygon = Polygon { normal: Vec3::Y, offset: 0.0, face: cap, corners };
        Feeler { polygon, radius: 0.0, deepest: Some(deepest) }
    }

    /// The cap as a face that others are clipped to.
    fn cap_polygon(&self, cap: u32, pose: &Pose) -> Polygon {
        let sign = if cap == 1 { 1.0 } else { -1.0 };
        let normal = pose.rotation * (Vec3::Y * sign);
        let height = self.cap_height(cap);
        let step = std::f32::consts::TAU / CAP_SIDES as f32;
        let around = self.radius / cos(0.5 * step);
        let corner = |i: u32| {
            let angle = step * (i as f32 + 0.5);
            let point = Vec3::new(around * cos(angle), height, -sign * around * crate::math::sin(angle));
            let number = 3 * RIM_POINTS + cap * CAP_SIDES + i;
            Corner { point: *pose * point, vertex: number, edge: number }
        };
        let offset = normal.dot(*pose * Vec3::new(0.0, height, 0.0));
        Polygon { normal, offset, face: cap, corners: (0..CAP_SIDES).map(corner).collect() }
    }
}

impl Solid<'_> {
    /// The point that reaches farthest along `direction`; both in the solid's frame.
    fn support(&self, direction: Vec3) -> Vec3 {
        match self {
            Self::Polyhedron(solid) => solid.vertices[solid.support(direction)],
            Self::Curved(curved) => curved.support(direction),
            Self::Capsule(half_length, radius) => {
                Vec3::new(0.0, half_length * direction.y.signum(), 0.0) + *radius * direction
            }
        }
    }

    /// The flat face that looks along `direction` (in the solid's frame), placed.
    fn facing(&self, direction: Vec3, pose: &Pose) -> Option<Polygon> {
        match self {
            Self::Polyhedron(solid) => {
                let face = solid.face_along(direction);
                (solid.faces[face].normal.dot(direction) > FACING).then(|| solid.polygon(face, pose))
            }
            Self::Curved(curved) => curved.cap(direction, FACING).map(|cap| curved.cap_polygon(cap, pose)),
            Self::Capsule(..) => None,
        }
    }

    fn feeler(&self, direction: Vec3, pose: &Pose) -> Feeler {
        match self {
            Self::Polyhedron(solid) => {
                let face = solid.incident_face(-direction);
                Feeler { polygon: solid.polygon(face, pose), radius: 0.0, deepest: None }
            }
            Self::Curved(curved) => curved.feeler(direction, pose),
            Self::Capsule(half_length, radius) => {
                let end = Vec3::new(0.0, *half_length, 0.0);
                let polygon = points_polygon(&[(-end, 0), (end, 1)], 0, 0, pose);
                Feeler { polygon, radius: *radius, deepest: None }
            }
        }
    }

    /// Numbers and normals of its flat faces, in its frame.
    fn normals(&self) -> SmallVec<[(u32, Vec3); 8]> {
        match self {
            Self::Polyhedron(solid) => (0..).zip(solid.faces).map(|(i, face)| (i, face.normal)).collect(),
            Self::Curved(curved) if curved.top_radius > 0.0 => SmallVec::from_slice(&[(0, -Vec3::Y), (1, Vec3::Y)]),
            Self::Curved(_) => SmallVec::from_slice(&[(0, -Vec3::Y)]),
            Self::Capsule(..) => SmallVec::new(),
        }
    }

    /// The straight line on the surface that looks along `direction`, if it lies across it.
    fn line(&self, direction: Vec3, pose: &Pose) -> Option<[(Vec3, u32); 2]> {
        let line = match self {
            Self::Polyhedron(_) => return None,
            Self::Curved(curved) => curved.side_line(direction),
            Self::Capsule(half_length, radius) => {
                let end = Vec3::new(0.0, *half_length, 0.0);
                let side = direction * *radius;
                [(side - end, 0), (side + end, 1)]
            }
        };
        let along = line[1].0 - line[0].0;
        let across = direction.dot(along).abs() <= ALONG * along.length();
        across.then(|| line.map(|(point, number)| (*pose * point, number)))
    }
}

/// A pair with a cylinder or cone, in the frame of A.
struct CurvedPair<'a> {
    a: Solid<'a>,
    b: Solid<'a>,
    b_in_a: &'a Pose,
    tolerance: &'a Tolerance,
}

/// Direction from A to B, distance along it, and the points on A and B.
struct Found {
    direction: Vec3,
    distance: f32,
    on_a: Vec3,
    on_b: Vec3,
}

impl CurvedPair<'_> {
    /// What parry's GJK and EPA say.
    fn find(&self, a: &dyn Shape, b: &dyn Shape) -> Option<Found> {
        let contact = DefaultQueryDispatcher.contact(self.b_in_a, a, b, self.tolerance.margin).ok()??;
        let (on_a, on_b) = (contact.point1, *self.b_in_a * contact.point2);
        // Where the centers coincide it may give no direction: any will do, best out of a cap.
        let Some(direction) = contact.normal1.try_normalize().filter(|n| n.is_finite()) else {
            return Some(self.along(self.b_in_a.rotation * Vec3::Y));
        };
        Some(Found { direction, distance: contact.dist, on_a, on_b })
    }

    /// The deepest points along a direction from A to B.
    fn along(&self, direction: Vec3) -> Found {
        let on_a = self.a.support(direction);
        let lowest = *self.b_in_a * self.b.support(self.b_in_a.rotation.inverse() * -direction);
        let distance = direction.dot(lowest - on_a);
        Found { direction, distance, on_a, on_b: on_a + direction * distance }
    }

    /// As [`find`](Self::find), but what slides over the seam of two flush solids finds no wall there.
    fn find_axis(&self, a: &dyn Shape, b: &dyn Shape, hint: &mut u32) -> Option<Found> {
        let mut faces: SmallVec<[Axis; 16]> = SmallVec::new();
        let into_b = self.b_in_a.rotation.inverse();
        for (number, normal) in self.a.normals() {
            faces.push(self.axis(Source::FaceA(number), normal));
        }
        for (number, normal) in self.b.normals() {
            faces.push(self.axis(Source::FaceB(number), -(self.b_in_a.rotation * normal)));
        }
        let greatest = faces.iter().max_by(|p, q| p.separation.total_cmp(&q.separation)).copied();
        let Some(found) = self.find(a, b) else {
            *hint = greatest.map_or(0, |axis| axis.source.to_hint(true));
            return None;
        };
        // The direction found is known to the hint by the face that is nearest to it.
        let likeness = |axis: &Axis| axis.direction.dot(found.direction);
        let alike = faces.iter().max_by(|p, q| likeness(p).total_cmp(&likeness(q)));
        let Some(alike) = alike.filter(|axis| likeness(axis) > 0.7) else { return Some(found) };
        let chosen = Axis { source: alike.source, direction: found.direction, separation: found.distance };
        match pass_corners(&faces, chosen, self.tolerance, Source::from_hint(*hint)) {
            None => {
                *hint = chosen.source.to_hint(true);
                None
            }
            Some(axis) => {
                *hint = axis.source.to_hint(axis.separation > 0.0);
                if axis.source == chosen.source {
                    return Some(found);
                }
                let toward_a = into_b * -axis.direction;
                let on_b = *self.b_in_a * self.b.support(toward_a);
                let on_a = on_b - axis.direction * axis.separation;
                Some(Found { direction: axis.direction, distance: axis.separation, on_a, on_b })
            }
        }
    }

    fn axis(&self, source: Source, direction: Vec3) -> Axis {
        Axis { source, direction, separation: self.along(direction).distance }
    }

    /// The manifold's normal (B's) and points.
    fn points(&self, found: &Found) -> (Vec3, Candidates) {
        let lead = 0.05 * found.distance.abs() + self.tolerance.axis;
        // The deepest point must be among the points: it may hang over the border of the face.
        let holds = |points: &Candidates| points.iter().any(|p| p.separation <= found.distance + lead);
        let into_b = self.b_in_a.rotation.inverse();
        if let Some(face) = self.a.facing(found.direction, &Pose::IDENTITY) {
            let lowest = *self.b_in_a * self.b.support(into_b * -face.normal);
            if face.normal.dot(lowest) - face.offset >= found.distance - lead {
                let points = self.over(&face, &self.b.feeler(into_b * -face.normal, self.b_in_a), true);
                if holds(&points) {
                    return (-face.normal, points);
                }
            }
        }
        if let Some(face) = self.b.facing(into_b * -found.direction, self.b_in_a) {
            let lowest = self.a.support(-face.normal);
            if face.normal.dot(lowest) - face.offset >= found.distance - lead {
                let points = self.over(&face, &self.a.feeler(-face.normal, &Pose::IDENTITY), false);
                if holds(&points) {
                    return (face.normal, points);
                }
            }
        }
        let mut points = self.along_lines(found);
        if !holds(&points) {
            points.clear();
            let id = FeatureId::new(Feature::unknown(0), Feature::unknown(0));
            points.push(LocalPoint { on_a: found.on_a, on_b: found.on_b, separation: found.distance, id });
        }
        (-found.direction, points)
    }

    fn over(&self, face: &Polygon, feeler: &Feeler, reference_is_a: bool) -> Candidates {
        let mut points = Candidates::new();
        let (margin, tolerance) = (self.tolerance.margin, self.tolerance.clip);
        let clip = Clip { reference_is_a, radius: feeler.radius, margin, tolerance };
        clip.points(face, &feeler.polygon, &mut points);
        if let Some(deepest) = &feeler.deepest {
            clip.points(face, deepest, &mut points);
        }
        points
    }

    /// Two points where the side lines of both run along each other.
    fn along_lines(&self, found: &Found) -> Candidates {
        let mut points = Candidates::new();
        let into_b = self.b_in_a.rotation.inverse();
        let Some(of_a) = self.a.line(found.direction, &Pose::IDENTITY) else { return points };
        let Some(of_b) = self.b.line(into_b * -found.direction, self.b_in_a) else { return points };
        let (line_a, line_b) = (of_a.map(|p| p.0), of_b.map(|p| p.0));
        if sine(line_a[1] - line_a[0], line_b[1] - line_b[0]) >= ALONG {
            return points;
        }
        for end in overlap_along(line_a, line_b).into_iter().flatten() {
            let on_a = line_a[0].lerp(line_a[1], end.first);
            let on_b = line_b[0].lerp(line_b[1], end.second);
            let separation = (on_b - on_a).dot(found.direction);
            let id = if end.of_first {
                FeatureId::new(Feature::vertex(of_a[end.end as usize].1), Feature::edge(SIDE_LINE))
            } else {
                FeatureId::new(Feature::edge(SIDE_LINE), Feature::vertex(of_b[end.end as usize].1))
            };
            if separation <= self.tolerance.margin {
                points.push(LocalPoint { on_a, on_b, separation, id });
            }
        }
        points
    }
}

/// The manifold of A and a cylinder or cone B.
pub(crate) fn curved_pair(
    a: Solid,
    shape_a: &dyn Shape,
    b: &Curved,
    b_in_a: &Pose,
    tolerance: &Tolerance,
    hint: &mut u32,
    out: &mut LocalManifolds,
) {
    let pair = CurvedPair { a, b: Solid::Curved(*b), b_in_a, tolerance };
    let Some(found) = b.with_parry(|shape_b| pair.find_axis(shape_a, shape_b, hint)) else { return };
    let (normal, mut points) = pair.points(&found);
    push_manifold(normal, 0, &mut points, tolerance.clip, out);
}

/// The manifold of two cylinders or cones.
pub(crate) fn curved_curved(
    a: &Curved,
    b: &Curved,
    b_in_a: &Pose,
    tolerance: &Tolerance,
    hint: &mut u32,
    out: &mut LocalManifolds,
) {
    a.with_parry(|shape_a| curved_pair(Solid::Curved(*a), shape_a, b, b_in_a, tolerance, hint, out));
}

/// The manifold of a cylinder or cone A and a capsule B.
pub(crate) fn curved_capsule(
    a: &Curved,
    (half_length, radius): (f32, f32),
    b_in_a: &Pose,
    tolerance: &Tolerance,
    out: &mut LocalManifolds,
) {
    let pair = CurvedPair { a: Solid::Curved(*a), b: Solid::Capsule(half_length, radius), b_in_a, tolerance };
    let capsule = Capsule::new_y(half_length, radius);
    let Some(found) = a.with_parry(|shape_a| pair.find(shape_a, &capsule)) else { return };
    let (normal, mut points) = pair.points(&found);
    push_manifold(normal, 0, &mut points, tolerance.clip, out);
}

/// The manifold of a triangle of a surface and a cylinder or cone.
pub(crate) fn curved_triangle(
    triangle: &SurfaceTriangle,
    curved: &Curved,
    pose: &Pose,
    tolerance: &Tolerance,
    out: &mut LocalManifolds,
) {
    if is_behind(triangle, pose.translation) {
        return;
    }
    let flat = triangle.solid.view();
    let pair = CurvedPair { a: Solid::Polyhedron(flat), b: Solid::Curved(*curved), b_in_a: pose, tolerance };
    let shape = Triangle::new(flat.vertices[0], flat.vertices[1], flat.vertices[2]);
    let Some(found) = curved.with_parry(|shape_b| pair.find(&shape, shape_b)) else { return };
    let toward_front = found.direction.dot(triangle.normal) > 0.0;
    let (normal, mut points) = match triangle.verdict(found.direction, pose.translation) {
        Verdict::Neighbors => return,
        Verdict::Allowed if toward_front => pair.points(&found),
        _ => {
            let face = flat.polygon(0, &Pose::IDENTITY);
            let down = pose.rotation.inverse() * -face.normal;
            (-face.normal, pair.over(&face, &pair.b.feeler(down, pose), true))
        }
    };
    triangle.drop_inner_points(&mut points);
    push_manifold(normal, triangle.index, &mut points, tolerance.clip, out);
}

/// A point on a cylinder or cone nearest to `point`: (point on it, outward normal, distance, negative inside).
pub(crate) fn nearest_on_curved(curved: &Curved, point: Vec3) -> (Vec3, Vec3, f32) {
    let axis = Vec3::Y;
    let outward = Vec3::new(point.x, 0.0, point.z).normalize_or(Vec3::X);
    // In the half plane through the axis: across, up. The outline runs from the axis around the solid to the axis.
    let at = (outward.dot(point), point.y);
    let height = curved.half_height;
    let outline = [(0.0, -height), (curved.radius, -height), (curved.top_radius, height), (0.0, height)];
    let mut inside = true;
    let mut best = (f32::INFINITY, (0.0, 0.0), (0.0, 1.0));
    for side in outline.windows(2) {
        let (start, along) = (side[0], (side[1].0 - side[0].0, side[1].1 - side[0].1));
        let square = along.0 * along.0 + along.1 * along.1;
        if square == 0.0 {
            continue;
        }
        let length = square.sqrt();
        let normal = (along.1 / length, -along.0 / length);
        let offset = (at.0 - start.0, at.1 - start.1);
        inside &= offset.0 * normal.0 + offset.1 * normal.1 <= 0.0;
        let part = ((offset.0 * along.0 + offset.1 * along.1) / square).clamp(0.0, 1.0);
        let on = (start.0 + part * along.0, start.1 + part * along.1);
        let gap = (at.0 - on.0) * (at.0 - on.0) + (at.1 - on.1) * (at.1 - on.1);
        if gap < best.0 {
            best = (gap, on, normal);
        }
    }
    let (square, on, normal) = best;
    let place = |(across, up): (f32, f32)| outward * across + axis * up;
    let distance = square.sqrt();
    let on_surface = place(on);
    if inside || distance <= 1e-9 {
        return (on_surface, place(normal), -distance);
    }
    (on_surface, (point - on_surface) / distance, distance)
}
