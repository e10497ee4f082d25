//! From separating axes to contact points: what boxes, hulls and triangles share.
//!
//! Separating axis theorem: convex A and B are apart exactly if they are along a face normal of one of them or
//! the cross product of two edges; else the axis of least overlap gives the normal. Where axes are nearly as good
//! as each other the choice must not flicker, so faces go before edges, A before B, and the last step's axis
//! (`hint`) before all, each within a tolerance. Without this a resting box changes its contact points, and
//! with them its warm start, in every step. Tests: `tests/narrow_phase.rs`, `tests/feature_ids.rs`.

use crate::collision::clip::{Candidates, Clip, nearest_on_segments};
use crate::collision::feature_id::{Feature, FeatureId};
use crate::collision::manifold::LocalPoint;
use crate::collision::narrow_phase::LocalManifolds;
use crate::collision::polyhedron::Polyhedron;
use crate::collision::reduce::push_manifold;
use crate::math::{Pose, Vec3};

/// Faces within this part of the best axis are preferred to edges.
const EDGE_LEAD: f32 = 0.05;
/// A's faces within this part of the best axis are preferred to B's.
const FACE_LEAD: f32 = 0.02;

/// Lengths that count as nothing for a pair of shapes, m.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tolerance {
    /// Contacts are made up to this separation.
    pub margin: f32,
    /// Axes whose separations differ by less are equally good.
    pub axis: f32,
    /// A vertex this far outside a face counts as on it.
    pub clip: f32,
    /// Overlap in two directions by less than this is a sliver: its contact must not stop a sliding body.
    pub sliver: f32,
}

impl Tolerance {
    /// `size` is the inner radius of the smaller shape, m.
    pub fn new(margin: f32, length_scale: f32, size: f32) -> Self {
        Self {
            margin,
            axis: (1e-3 * length_scale).min(1e-2 * size),
            clip: (1e-4 * length_scale).min(1e-2 * size),
            // Twice the default slop: resting bodies overlap by one.
            sliver: (1e-2 * length_scale).min(0.25 * size),
        }
    }
}

/// What a separating axis is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Source {
    FaceA(u32),
    FaceB(u32),
    Edges(u32, u32),
}

/// A candidate for the contact normal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axis {
    pub source: Source,
    /// Unit, from A to B, in the frame of A.
    pub direction: Vec3,
    /// m; negative = overlap.
    pub separation: f32,
}

impl Source {
    const KIND_SHIFT: u32 = 26;
    const EDGE_BITS: u32 = 13;
    const APART: u32 = 1 << 28;

    /// What the caller remembers for the next step; `apart` tells that the shapes were apart along the axis.
    pub fn to_hint(self, apart: bool) -> u32 {
        let mask = (1 << Self::EDGE_BITS) - 1;
        let (kind, index) = match self {
            Self::FaceA(face) => (1, face),
            Self::FaceB(face) => (2, face),
            Self::Edges(a, b) => (3, (a & mask) << Self::EDGE_BITS | b & mask),
        };
        kind << Self::KIND_SHIFT | index & ((1 << Self::KIND_SHIFT) - 1) | if apart { Self::APART } else { 0 }
    }

    /// The axis of the last step, and whether the shapes were apart along it.
    pub fn from_hint(hint: u32) -> Option<(Self, bool)> {
        let index = hint & ((1 << Self::KIND_SHIFT) - 1);
        let source = match hint >> Self::KIND_SHIFT & 3 {
            1 => Self::FaceA(index),
            2 => Self::FaceB(index),
            3 => Self::Edges(index >> Self::EDGE_BITS, index & ((1 << Self::EDGE_BITS) - 1)),
            _ => return None,
        };
        Some((source, hint & Self::APART != 0))
    }
}

/// The axis that contacts are made from: the greatest separation, with preferences (see above).
///
/// `faces` are the axes of all faces, A's first; `edges` is the best edge axis and `last_edges` that of the hint.
/// `None` if bodies only pass each other corner to corner, with nothing to hold on to.
pub(crate) fn choose_axis(
    faces: &[Axis],
    edges: Option<Axis>,
    last_edges: Option<Axis>,
    tolerance: &Tolerance,
    hint: u32,
) -> Option<Axis> {
    let hint = Source::from_hint(hint);
    let mut best: Option<Axis> = None;
    for axis in faces {
        let needed = best.map_or(f32::NEG_INFINITY, |best| {
            let other_shape = matches!(best.source, Source::FaceA(_)) && matches!(axis.source, Source::FaceB(_));
            let lead = if other_shape { FACE_LEAD * best.separation.abs() + tolerance.axis } else { 0.0 };
            best.separation + lead
        });
        if axis.separation > needed {
            best = Some(*axis);
        }
    }
    let best = best?;
    let greatest = faces.iter().map(|axis| axis.separation).fold(f32::NEG_INFINITY, f32::max);
    let lead = EDGE_LEAD * greatest.abs() + tolerance.axis;
    let last_face = faces
        .iter()
        .find(|axis| hint.is_some_and(|(source, _)| source == axis.source) && axis.separation >= greatest - lead);
    let mut chosen = last_face.copied().unwrap_or(best);
    if let Some(edges) = edges {
        // An edge axis stays while it is no worse than the faces, and comes in only by a lead.
        match last_edges {
            Some(last) if last.separation >= greatest && last.separation >= edges.separation - lead => chosen = last,
            _ if edges.separation > chosen.separation + lead => chosen = edges,
            _ => {}
        }
    }
    pass_corners(faces, chosen, tolerance, hint)
}

/// Faces within this cosine lie along each other.
const ALONG: f32 = 0.9999;

/// Two boxes that lie flush side by side are one floor: what slides over the seam overlaps the second box by a
/// sliver, a few millimeters deep along the true normal and still fewer along the way. The least overlap would
/// stop it. So a sliver takes the axis along which the shapes overlapped *before* they met; and shapes that are
/// still apart, but only corner to corner, get no contact yet.
pub(crate) fn pass_corners(
    faces: &[Axis],
    chosen: Axis,
    tolerance: &Tolerance,
    hint: Option<(Source, bool)>,
) -> Option<Axis> {
    if chosen.separation < -tolerance.sliver {
        return Some(chosen);
    }
    let mut across: Option<Axis> = None;
    for axis in faces {
        let turned = axis.direction.dot(chosen.direction).abs() < 0.7;
        if turned && across.is_none_or(|best| axis.separation > best.separation) {
            across = Some(*axis);
        }
    }
    let Some(across) = across.filter(|axis| axis.separation >= -tolerance.sliver) else { return Some(chosen) };
    if chosen.separation > 0.0 {
        return None;
    }
    let Some((source, was_apart)) = hint else {
        // Laid down face along face and corner to corner, as in worlds built on a grid: what hardly touches is not
        // pushed either way.
        let along = faces.iter().filter(|axis| axis.direction.dot(chosen.direction).abs() > ALONG).count();
        return Some(chosen).filter(|axis| along < 2 || axis.separation < -0.1 * tolerance.sliver);
    };
    let Some(last) = faces.iter().find(|axis| axis.source == source) else { return Some(chosen) };
    let last_was_chosen = last.direction.dot(chosen.direction).abs() > 0.7;
    // If they were apart along the chosen axis and met along it, they had rested on each other along the other one;
    // once that is chosen it stays.
    Some(if last_was_chosen == was_apart { across } else { chosen })
}

/// A and B, placed, with their tolerances: what contact points are made from.
pub(crate) struct Pair<'a> {
    pub a: Polyhedron<'a>,
    pub b: Polyhedron<'a>,
    pub b_in_a: &'a Pose,
    pub part: u32,
    pub tolerance: Tolerance,
}

/// How contact points are made from the axes of a pair.
pub(crate) trait Points {
    /// Appends the points along an axis; gives B's normal.
    fn along(&self, axis: &Axis, points: &mut Candidates) -> Vec3;
    /// Where clipping finds nothing though the shapes overlap: the deepest vertex of one against the plane of the other.
    fn deepest(&self, axis: &Axis) -> LocalPoint;
}

/// Appends the manifold along `axis`; `greatest` is the greatest separation of all axes.
///
/// Where the deepest part is not over the face (only the preference for faces chose it), along the best edges.
pub(crate) fn push_contact(
    pair: &impl Points,
    (axis, greatest): (&Axis, f32),
    edges: impl FnOnce() -> Option<Axis>,
    (part, tolerance): (u32, &Tolerance),
    out: &mut LocalManifolds,
) {
    let mut points = Candidates::new();
    let mut normal = pair.along(axis, &mut points);
    // While they are apart, an empty face means that they pass each other.
    if !reach_deepest(&points, axis, tolerance) && (greatest <= 0.0 || !points.is_empty()) {
        match edges() {
            Some(edges) if edges.separation >= axis.separation => {
                points.clear();
                normal = pair.along(&edges, &mut points);
            }
            // What is apart must not seem farther apart than it is.
            _ if greatest > 0.0 => points.clear(),
            _ if points.is_empty() => points.push(pair.deepest(axis)),
            _ => {}
        }
    }
    push_manifold(normal, part, &mut points, tolerance.clip, out);
}

/// Whether one of the points made along an axis is about as deep as the shapes overlap along it.
pub(crate) fn reach_deepest(points: &[LocalPoint], axis: &Axis, tolerance: &Tolerance) -> bool {
    let enough = axis.separation + EDGE_LEAD * axis.separation.abs() + tolerance.axis;
    points.iter().any(|p| p.separation <= enough)
}

/// The greatest separation of these axes, m.
pub(crate) fn greatest_separation<'a>(axes: impl IntoIterator<Item = &'a Axis>) -> f32 {
    axes.into_iter().map(|axis| axis.separation).fold(f32::NEG_INFINITY, f32::max)
}

/// The point where two edges pass each other, in the frame of A.
pub(crate) fn edge_point(
    (edge_a, of_a): (u32, [Vec3; 2]),
    (edge_b, of_b): (u32, [Vec3; 2]),
    direction: Vec3,
) -> LocalPoint {
    let (s, t) = nearest_on_segments(of_a, of_b);
    let (on_a, on_b) = (of_a[0].lerp(of_a[1], s), of_b[0].lerp(of_b[1], t));
    let id = FeatureId::new(Feature::edge(edge_a), Feature::edge(edge_b));
    LocalPoint { on_a, on_b, separation: (on_b - on_a).dot(direction), id }
}

impl Pair<'_> {
    /// Appends the manifold along `axis`, one of `faces` or `edges`.
    pub fn push_contact(&self, axis: &Axis, faces: &[Axis], edges: Option<Axis>, out: &mut LocalManifolds) {
        let greatest = greatest_separation(faces.iter().chain(&edges));
        push_contact(self, (axis, greatest), || edges, (self.part, &self.tolerance), out);
    }

    /// Contact points over a face; gives B's normal.
    pub fn face_points(&self, face: usize, reference_is_a: bool, points: &mut Candidates) -> Vec3 {
        let clip = Clip { reference_is_a, radius: 0.0, margin: self.tolerance.margin, tolerance: self.tolerance.clip };
        if reference_is_a {
            let reference = self.a.polygon(face, &Pose::IDENTITY);
            let toward_b = self.b_in_a.rotation.inverse() * reference.normal;
            let incident = self.b.polygon(self.b.incident_face(toward_b), self.b_in_a);
            clip.points(&reference, &incident, points);
            -reference.normal
        } else {
            let reference = self.b.polygon(face, self.b_in_a);
            let incident = self.a.polygon(self.a.incident_face(reference.normal), &Pose::IDENTITY);
            clip.points(&reference, &incident, points);
            reference.normal
        }
    }
}

impl Points for Pair<'_> {
    fn along(&self, axis: &Axis, points: &mut Candidates) -> Vec3 {
        match axis.source {
            Source::FaceA(face) => self.face_points(face as usize, true, points),
            Source::FaceB(face) => self.face_points(face as usize, false, points),
            Source::Edges(edge_a, edge_b) => {
                let of_b = self.b.edge_points(edge_b as usize).map(|p| *self.b_in_a * p);
                points.push(edge_point((edge_a, self.a.edge_points(edge_a as usize)), (edge_b, of_b), axis.direction));
                -axis.direction
            }
        }
    }

    fn deepest(&self, axis: &Axis) -> LocalPoint {
        let into_b = self.b_in_a.rotation.inverse() * axis.direction;
        let depth = axis.direction * axis.separation;
        if matches!(axis.source, Source::FaceB(_)) {
            let vertex = self.a.support(axis.direction);
            let on_a = self.a.vertices[vertex];
            let face = Feature::face(self.b.face_along(-into_b) as u32);
            let id = FeatureId::new(Feature::vertex(vertex as u32), face);
            LocalPoint { on_a, on_b: on_a + depth, separation: axis.separation, id }
        } else {
            let vertex = self.b.support(-into_b);
            let on_b = *self.b_in_a * self.b.vertices[vertex];
            let face = Feature::face(self.a.face_along(axis.direction) as u32);
            let id = FeatureId::new(face, Feature::vertex(vertex as u32));
            LocalPoint { on_a: on_b - depth, on_b, separation: axis.separation, id }
        }
    }
}
