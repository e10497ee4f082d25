//! Two convex polyhedra: the separating axis test, with pairs of edges pruned on the Gauss map.
//!
//! An edge is an arc between the normals of its two faces on the unit sphere. Two edges can make a face of the
//! Minkowski difference A − B, and so a separating axis, only if the arc of one crosses the negated arc of the
//! other; most pairs are rejected by four dot products (Gregorius 2013, "The separating axis test between
//! convex polyhedra"). Most edges, and faces, do not even come to that: along a direction d the shapes are no farther
//! apart than d·(c_B − c_A) − r_A − r_B, with balls of radii r about c inside them. Test: `tests/narrow_phase.rs` against a
//! search over all axes in f64.

use crate::collision::narrow_phase::LocalManifolds;
use crate::collision::polyhedron::Polyhedron;
use crate::collision::sat::{Axis, Pair, Source, Tolerance, choose_axis, greatest_separation};
use crate::math::{Mat3, Pose, Vec3};
use smallvec::SmallVec;

/// Square of the sine of the angle below which two edges count as parallel.
const PARALLEL_SQUARED: f32 = 1e-6;
/// Axes worse than the best by this part, and twice the tolerance, matter to nobody: more than any lead in `sat.rs`.
const LEAD: f32 = 0.1;

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
    let tolerance = Tolerance::new(margin, length_scale, a.inner_radius.min(b.inner_radius));
    let mut faces = SmallVec::new();
    if let Some(apart) = face_axes((&a, &b), (b_in_a, &a_in_b), &tolerance, *hint, &mut faces) {
        *hint = apart.to_hint(true);
        return;
    }
    let greatest = greatest_separation(&faces);
    let (edges, last_edges) = edge_axes(&a, &b, b_in_a, greatest - lead(greatest, &tolerance), *hint);
    if let Some(apart) = edges.filter(|axis| axis.separation > margin) {
        *hint = apart.source.to_hint(true);
        return;
    }
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

/// How much worse than the best an axis must be to matter to nobody, m.
fn lead(best: f32, tolerance: &Tolerance) -> f32 {
    LEAD * best.abs() + 2.0 * tolerance.axis
}

/// The axes of all faces that may matter to `sat.rs`, A's first; or one along which the shapes are apart.
fn face_axes(
    (a, b): (&Polyhedron, &Polyhedron),
    (b_in_a, a_in_b): (&Pose, &Pose),
    tolerance: &Tolerance,
    hint: u32,
    faces: &mut SmallVec<[Axis; 64]>,
) -> Option<Source> {
    let centers = Centers { of_a_in_b: *a_in_b * a.center, of_b_in_a: *b_in_a * b.center };
    let sources_a = (0..a.faces.len() as u32).map(Source::FaceA);
    let sources = sources_a.chain((0..b.faces.len() as u32).map(Source::FaceB));
    let bounds: SmallVec<[f32; 64]> = sources.clone().map(|source| centers.bound(a, b, source)).collect();
    let (nearest, _) = sources.clone().zip(&bounds).max_by(|p, q| p.1.total_cmp(q.1))?;
    let nearest = face_axis(a, b, b_in_a, a_in_b, nearest)?.separation;
    // What is farther on the other side is neither a normal nor a sliver.
    let far = (nearest - lead(nearest, tolerance)).min(-2.0 * tolerance.sliver);
    let last = Source::from_hint(hint).map(|(source, _)| source);
    for (source, &bound) in sources.zip(&bounds) {
        // Where there was a last axis it is asked for, and what is near; else how many faces lie along each other.
        let is_far = bound < far && last != Some(source);
        if is_far && last.is_some() {
            continue;
        }
        let axis = match source {
            Source::FaceA(face) if is_far => {
                Axis { source, direction: a.faces[face as usize].normal, separation: bound }
            }
            Source::FaceB(face) if is_far => {
                let normal = b_in_a.rotation * b.faces[face as usize].normal;
                Axis { source, direction: -normal, separation: bound }
            }
            _ => face_axis(a, b, b_in_a, a_in_b, source)?,
        };
        if axis.separation > tolerance.margin {
            return Some(source);
        }
        faces.push(axis);
    }
    None
}

/// Centers of both shapes, each in the frame of the other, m.
struct Centers {
    of_a_in_b: Vec3,
    of_b_in_a: Vec3,
}

impl Centers {
    /// The separation along a face is no greater, m.
    fn bound(&self, a: &Polyhedron, b: &Polyhedron, source: Source) -> f32 {
        let (face, center, radius) = match source {
            Source::FaceA(face) => (&a.faces[face as usize], self.of_b_in_a, b.inner_radius),
            Source::FaceB(face) => (&b.faces[face as usize], self.of_a_in_b, a.inner_radius),
            Source::Edges(..) => return f32::INFINITY,
        };
        face.normal.dot(center) - face.offset - radius
    }
}

/// The axis of one face; `None` if the hint names a face that does not exist, or no face.
fn face_axis(a: &Polyhedron, b: &Polyhedron, b_in_a: &Pose, a_in_b: &Pose, source: Source) -> Option<Axis> {
    let (direction, separation) = match source {
        Source::FaceA(face) => {
            let face = a.faces.get(face as usize)?;
            let (normal, offset) = plane_in(a_in_b, face.normal, face.offset);
            (face.normal, b.least_along(normal) - offset)
        }
        Source::FaceB(face) => {
            let face = b.faces.get(face as usize)?;
            let (normal, offset) = plane_in(b_in_a, face.normal, face.offset);
            (-normal, a.least_along(normal) - offset)
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

/// Edges that are tested side by side.
const SIDE_BY_SIDE: usize = 8;

/// A number of each of some edges.
type Lane = [f32; SIDE_BY_SIDE];

/// Some edges of B by coordinates; a place without an edge crosses nothing.
#[derive(Clone, Copy, Default)]
struct EdgeLanes {
    along: [Lane; 3],
    normals: [[Lane; 3]; 2],
}

impl EdgeLanes {
    fn set(&mut self, lane: usize, edge: &PlacedEdge) {
        let [of_first, of_second] = &mut self.normals;
        let lanes = [(&mut self.along, edge.along), (of_first, edge.normals[0]), (of_second, edge.normals[1])];
        for (lanes, vector) in lanes {
            for (lanes, value) in lanes.iter_mut().zip(vector.to_array()) {
                lanes[lane] = value;
            }
        }
    }

    /// Below 0 where an edge has an arc (−b₀, −b₁) that crosses the plane of the arc (a₀, a₁) as that crosses its own: each
    /// has its ends on both sides of the other's plane. An edge is along a₀ × a₁ up to a positive factor, so it stands for
    /// the plane.
    fn crossing(&self, edge: &PlacedEdge) -> Lane {
        let (b0, b1) = (dots(&self.normals[0], edge.along), dots(&self.normals[1], edge.along));
        let (a0, a1) = (dots(&self.along, edge.normals[0]), dots(&self.along, edge.normals[1]));
        let mut worse = [0.0; SIDE_BY_SIDE];
        for k in 0..SIDE_BY_SIDE {
            let (b, a) = (b0[k] * b1[k], a0[k] * a1[k]);
            worse[k] = if b > a { b } else { a };
        }
        worse
    }
}

#[inline(always)]
fn dots(vectors: &[Lane; 3], by: Vec3) -> Lane {
    let [x, y, z] = vectors;
    let mut dots = [0.0; SIDE_BY_SIDE];
    for k in 0..SIDE_BY_SIDE {
        dots[k] = x[k] * by.x + y[k] * by.y + z[k] * by.z;
    }
    dots
}

/// The edges of B that may be nearest to A, in the frame of A.
struct PlacedEdges {
    edges: SmallVec<[(u32, PlacedEdge); 40]>,
    lanes: SmallVec<[EdgeLanes; 5]>,
}

/// What tells edges that are too far on the other side of their shape, in the frame of that.
struct Reach {
    /// From the center of the one shape to that of the other, m.
    between: Vec3,
    /// Directions that matter go along with `between` at least so far, m.
    least: f32,
}

impl Reach {
    /// Whether any direction on the arc between two normals goes far enough: αn₀ + βn₁ with α + β = 1 is no shorter than in
    /// the middle.
    fn may_matter(&self, normals: [Vec3; 2]) -> bool {
        let most = normals[0].dot(self.between).max(normals[1].dot(self.between)).max(0.0);
        let middle = 0.25 * (normals[0] + normals[1]).length_squared();
        self.least <= 0.0 || most * most >= self.least * self.least * middle
    }
}

impl PlacedEdges {
    fn new(polyhedron: &Polyhedron, pose: &Pose, reach: &Reach) -> Self {
        let turn = Mat3::from_quat(pose.rotation);
        let place = |edge: u32| {
            let normals = polyhedron.edges[edge as usize].faces.map(|face| polyhedron.faces[face as usize].normal);
            if !reach.may_matter(normals) {
                return None;
            }
            let [start, end] = polyhedron.edge_points(edge as usize);
            let (start, along) = (turn * start + pose.translation, turn * (end - start));
            Some((edge, PlacedEdge { start, along, normals: normals.map(|normal| turn * normal) }))
        };
        let edges: SmallVec<[(u32, PlacedEdge); 40]> = (0..polyhedron.edges.len() as u32).filter_map(place).collect();
        let mut lanes: SmallVec<[EdgeLanes; 5]> = SmallVec::new();
        lanes.resize(edges.len().div_ceil(SIDE_BY_SIDE), EdgeLanes::default());
        for (k, (_, edge)) in edges.iter().enumerate() {
            lanes[k / SIDE_BY_SIDE].set(k % SIDE_BY_SIDE, edge);
        }
        Self { edges, lanes }
    }
}

/// The best axis of two edges, and that of the last step if it still is one; of those with a greater separation than
/// `least`.
fn edge_axes(a: &Polyhedron, b: &Polyhedron, b_in_a: &Pose, least: f32, hint: u32) -> (Option<Axis>, Option<Axis>) {
    let of_a = Reach { between: *b_in_a * b.center - a.center, least: least + a.inner_radius + b.inner_radius };
    let of_b = Reach { between: b_in_a.rotation.inverse() * -of_a.between, ..of_a };
    let edges_b = PlacedEdges::new(b, b_in_a, &of_b);
    let last = Source::from_hint(hint).map(|(source, _)| source);
    let mut best: Option<Axis> = None;
    let mut last_axis = None;
    for i in 0..a.edges.len() {
        let normals = a.edges[i].faces.map(|face| a.faces[face as usize].normal);
        if !of_a.may_matter(normals) {
            continue;
        }
        let [start, end] = a.edge_points(i);
        let edge_a = PlacedEdge { start, along: end - start, normals };
        for (first, lanes) in (0..).step_by(SIDE_BY_SIDE).zip(&edges_b.lanes) {
            let crossing = lanes.crossing(&edge_a);
            for (k, _) in (first..).zip(crossing).filter(|&(_, worse)| worse < 0.0) {
                let (j, edge_b) = &edges_b.edges[k];
                let Some((direction, separation)) = edge_axis(&edge_a, edge_b) else { continue };
                let axis = Axis { source: Source::Edges(i as u32, *j), direction, separation };
                if best.is_none_or(|best| separation > best.separation) {
                    best = Some(axis);
                }
                if last == Some(axis.source) {
                    last_axis = Some(axis);
                }
            }
        }
    }
    (best, last_axis)
}

/// Direction and separation of the axis of two edges whose arcs cross each other's planes, if they cross in the same
/// half of the sphere and the edges are not parallel.
fn edge_axis(a: &PlacedEdge, b: &PlacedEdge) -> Option<(Vec3, f32)> {
    if !same_half(a.normals[0], a.normals[1], -b.normals[0], -b.normals[1]) {
        return None;
    }
    let cross = a.along.cross(b.along);
    let square = cross.length_squared();
    if square < PARALLEL_SQUARED * a.along.length_squared() * b.along.length_squared() {
        return None;
    }
    let unit = cross / square.sqrt();
    // Outward from A: on the side of the normals of the edge.
    let direction = if unit.dot(a.normals[0] + a.normals[1]) >= 0.0 { unit } else { -unit };
    Some((direction, direction.dot(b.start - a.start)))
}

/// Whether two arcs whose planes separate each other's ends cross in the same half, not in opposite points.
fn same_half(a0: Vec3, a1: Vec3, b0: Vec3, b1: Vec3) -> bool {
    // The arc b meets the plane of a in this direction (its ends are on both sides).
    let plane = a0.cross(a1);
    let (d0, d1) = (b0.dot(plane), b1.dot(plane));
    let meet = b0 * d1.abs() + b1 * d0.abs();
    meet.dot(a0 + a1) > 0.0
}
