//! Two convex polyhedra: the separating axis test, with pairs of edges pruned on the Gauss map.
//!
//! An edge is an arc between the normals of its two faces on the unit sphere. Two edges can make a face of the
//! Minkowski difference A − B, and so a separating axis, only if the arc of one crosses the negated arc of the
//! other; most pairs are rejected by four dot products (Gregorius 2013, "The separating axis test between
//! convex polyhedra"). Most edges, and faces, do not even come to that: along a direction d in which a face or edge of A
//! lies outermost, B is no farther from it than a ball inside B, whose center is at some height above the faces of A.
//! Test: `tests/narrow_phase.rs` against a search over all axes in f64.

use crate::collision::clip::Candidates;
use crate::collision::narrow_phase::LocalManifolds;
use crate::collision::pair_memory::{AxisBounds, Known, PairMemory};
use crate::collision::polyhedron::Polyhedron;
use crate::collision::reduce::push_manifold;
use crate::collision::sat::{Axis, Pair, Points, Source, Tolerance, choose_axis, greatest_separation, reach_deepest};
use crate::collision::side_by_side::{EdgeAxis, Lane, Numbers, SIDE_BY_SIDE, SideBySide, Vectors, at_least};
use crate::math::{Mat3, Pose, Vec3};
use smallvec::{SmallVec, smallvec};
use std::borrow::Cow;

/// Square of the sine of the angle below which two edges count as parallel.
const PARALLEL_SQUARED: f32 = 1e-6;
/// Axes worse than the best by this part, and twice the tolerance, matter to nobody: more than any lead in `sat.rs`.
const LEAD: f32 = 0.1;
/// Cosine to another axis below which it lies across that, or would with a little motion; .7 in `sat.rs`.
const NEARLY_ACROSS: f32 = 0.75;
/// The last axis is known to be the best only until B has moved so far, × `Tolerance::axis`: what lies across it does so
/// still.
const MOST_MOTION: f32 = 5.0;

/// Manifold of two polyhedra; `known` is what `memory` says of them. Once in a program, not where boxes and hulls are told
/// apart.
#[inline(never)]
pub(crate) fn hull_hull(
    (a, b): (Polyhedron, Polyhedron),
    b_in_a: &Pose,
    (margin, length_scale): (f32, f32),
    (known, memory): (Known, &mut PairMemory),
    out: &mut LocalManifolds,
) {
    let tolerance = Tolerance::new(margin, length_scale, a.inner_radius.min(b.inner_radius));
    let pair = Pair { a, b, b_in_a, part: 0, tolerance };
    let last = Source::from_hint(memory.axis).map(|(source, _)| source);
    let test = HullTest::new(&pair, last);
    if let Known::Axis(bounds, moved) = known
        && moved <= MOST_MOTION * tolerance.axis
        && test.push_along_last(&bounds, &mut memory.axis, out)
    {
        return;
    }
    memory.forget();
    let mut axes = Axes::default();
    if let Some(apart) = test.find_axes(&mut axes) {
        memory.axis = apart.source.to_hint(true);
        memory.learn_gap(b_in_a, apart.separation);
        return;
    }
    match choose_axis(&axes.faces, axes.edges, axes.last_edges, &tolerance, memory.axis) {
        Some(axis) => {
            memory.axis = axis.source.to_hint(axis.separation > 0.0);
            pair.push_contact(&axis, &axes.faces, axes.edges, out);
            let points = out.iter().flat_map(|manifold| &manifold.points);
            let nearest = points.map(|p| p.on_a.distance(p.on_b)).min_by(f32::total_cmp);
            if let Some(bounds) = axes.bounds(&axis, nearest, &tolerance) {
                memory.learn_axis(b_in_a, bounds);
            }
        }
        None => {
            let apart = axes.faces.iter().max_by(|p, q| p.separation.total_cmp(&q.separation));
            if let Some(apart) = apart.filter(|axis| axis.separation > 0.0) {
                memory.axis = apart.source.to_hint(true);
            }
        }
    }
}

/// The axes of a pair that matter; large, so it is filled where it is.
#[derive(Default)]
struct Axes {
    /// Those of faces, A's first.
    faces: SmallVec<[Axis; 16]>,
    /// The best of two edges.
    edges: Option<Axis>,
    /// The axis of the last step, if that was, and still is, one of two edges.
    last_edges: Option<Axis>,
}

/// How much worse than the best an axis must be to matter to nobody, m.
fn lead(best: f32, tolerance: &Tolerance) -> f32 {
    LEAD * best.abs() + 2.0 * tolerance.axis
}

/// One of two polyhedra.
struct Solid<'a> {
    parts: &'a Polyhedron<'a>,
    side_by_side: Cow<'a, SideBySide>,
}

impl<'a> Solid<'a> {
    fn new(parts: &'a Polyhedron<'a>) -> Self {
        let side_by_side = parts.side_by_side.map_or_else(|| Cow::Owned(SideBySide::of(parts)), Cow::Borrowed);
        Self { parts, side_by_side }
    }
}

/// The search for axes of a pair.
struct HullTest<'a> {
    pair: &'a Pair<'a>,
    a: Solid<'a>,
    b: Solid<'a>,
    a_in_b: Pose,
    /// The axis of the last step.
    last: Option<Source>,
}

/// Heights of the center of each shape above the faces of the other, m.
struct Heights {
    above_a: SmallVec<[f32; 32]>,
    above_b: SmallVec<[f32; 32]>,
}

impl<'a> HullTest<'a> {
    fn new(pair: &'a Pair<'a>, last: Option<Source>) -> Self {
        Self { pair, a: Solid::new(&pair.a), b: Solid::new(&pair.b), a_in_b: pair.b_in_a.inverse(), last }
    }

    /// All axes that may matter to `sat.rs`, into `axes`; or one along which the shapes are apart.
    fn find_axes(&self, axes: &mut Axes) -> Option<Axis> {
        let tolerance = &self.pair.tolerance;
        let is_gap = |axis: &Axis| axis.separation > tolerance.margin;
        // Most that are apart still are so along the axis of the last step.
        if let Some(apart) = self.last.and_then(|last| self.face_axis(last)).filter(is_gap) {
            return Some(apart);
        }
        let heights = Heights {
            above_a: self.a.side_by_side.heights_above(*self.pair.b_in_a * self.b.parts.center),
            above_b: self.b.side_by_side.heights_above(self.a_in_b * self.a.parts.center),
        };
        if let Some(apart) = self.find_face_axes(&heights, &mut axes.faces) {
            return Some(apart);
        }
        let greatest = greatest_separation(&axes.faces);
        (axes.edges, axes.last_edges) = self.edge_axes(&heights, greatest - lead(greatest, tolerance));
        axes.edges.filter(is_gap)
    }

    /// The axes of all faces that may matter to `sat.rs`, into `faces`; or one along which the shapes are apart.
    fn find_face_axes(&self, heights: &Heights, faces: &mut SmallVec<[Axis; 16]>) -> Option<Axis> {
        let (a, b, tolerance) = (self.a.parts, self.b.parts, &self.pair.tolerance);
        // The separation along a face is no greater than the height less a radius.
        let (above_a, above_b) = (&heights.above_a[..a.faces.len()], &heights.above_b[..b.faces.len()]);
        let (in_a, in_b) = (a.inner_radius, b.inner_radius);
        let nearest = match (highest(above_a), highest(above_b)) {
            ((face, height), (_, other)) if height - in_b >= other - in_a => Source::FaceA(face),
            (_, (face, _)) => Source::FaceB(face),
        };
        let nearest = self.face_axis(nearest)?;
        if nearest.separation > tolerance.margin {
            return Some(nearest);
        }
        // What is farther on the other side is neither a normal nor a sliver.
        let far = (nearest.separation - lead(nearest.separation, tolerance)).min(-2.0 * tolerance.sliver);
        // Where there was a last axis it is asked for, and what is near; else how many faces lie along each other.
        let bar = if self.last.is_some() { far } else { f32::NEG_INFINITY };
        let (near_a, near_b) = (at_least(above_a, bar + in_b), at_least(above_b, bar + in_a));
        let of_a = near_a.iter().map(|&face| (Source::FaceA(face), above_a[face as usize] - in_b));
        let of_b = near_b.iter().map(|&face| (Source::FaceB(face), above_b[face as usize] - in_a));
        for (source, bound) in of_a.chain(of_b) {
            let axis = if self.last.is_some() || bound >= far {
                self.face_axis(source)?
            } else {
                Axis { source, direction: self.direction(source), separation: bound }
            };
            if axis.separation > tolerance.margin {
                return Some(axis);
            }
            faces.push(axis);
        }
        let is_last = |axis: &Axis| self.last == Some(axis.source);
        if !faces.iter().any(is_last) {
            faces.extend(self.last.and_then(|last| self.face_axis(last)));
        }
        None
    }

    /// Along a face, from A to B.
    fn direction(&self, source: Source) -> Vec3 {
        match source {
            Source::FaceB(face) => -(self.pair.b_in_a.rotation * self.b.parts.faces[face as usize].normal),
            Source::FaceA(face) | Source::Edges(face, _) => self.a.parts.faces[face as usize].normal,
        }
    }

    /// The axis of one face; `None` if there is no such face, or it is no face.
    fn face_axis(&self, source: Source) -> Option<Axis> {
        let (direction, separation) = match source {
            Source::FaceA(face) => {
                let face = self.a.parts.faces.get(face as usize)?;
                let (normal, offset) = plane_in(&self.a_in_b, face.normal, face.offset);
                (face.normal, self.b.side_by_side.least_along(normal) - offset)
            }
            Source::FaceB(face) => {
                let face = self.b.parts.faces.get(face as usize)?;
                let (normal, offset) = plane_in(self.pair.b_in_a, face.normal, face.offset);
                (-normal, self.a.side_by_side.least_along(normal) - offset)
            }
            Source::Edges(..) => return None,
        };
        Some(Axis { source, direction, separation })
    }

    /// The best axis of two edges, and that of the last step if it still is one; of those with a greater separation than
    /// `least`.
    fn edge_axes(&self, heights: &Heights, least: f32) -> (Option<Axis>, Option<Axis>) {
        let (above_a, above_b) =
            (&heights.above_a[..self.a.parts.faces.len()], &heights.above_b[..self.b.parts.faces.len()]);
        let near_a = self.a.side_by_side.edges_in_reach(above_a, least + self.b.parts.inner_radius);
        let near_b = self.b.side_by_side.edges_in_reach(above_b, least + self.a.parts.inner_radius);
        self.axes_of_edges(&near_a, near_b)
    }

    /// The same of these edges of A and of B.
    fn axes_of_edges(&self, of_a: &[u32], of_b: Numbers) -> (Option<Axis>, Option<Axis>) {
        let (edges_a, edges_b) = (&self.a.side_by_side.edges, &self.b.side_by_side.edges);
        let mut placed = PlacedEdges::default();
        placed.place(edges_b, of_b, self.pair.b_in_a);
        let mut best: Option<Axis> = None;
        let mut last_axis = None;
        for &i in of_a {
            let edge_a = &edges_a[i as usize];
            placed.for_each_crossing(edge_a, |j, edge_b| {
                let start = *self.pair.b_in_a * edges_b[j as usize].start;
                let Some((direction, separation)) = edge_axis(edge_a, &edge_b, start) else { return };
                let source = Source::Edges(i, j);
                let (is_best, is_last) =
                    (best.is_none_or(|best| separation > best.separation), self.last == Some(source));
                if (is_best || is_last) && edge_b.is_same_half(edge_a) {
                    let axis = Axis { source, direction, separation };
                    best = if is_best { Some(axis) } else { best };
                    last_axis = if is_last { Some(axis) } else { last_axis };
                }
            });
        }
        (best, last_axis)
    }

    /// The axis of the last step as it is now; `None` if it is one no more.
    fn last_axis(&self) -> Option<Axis> {
        match self.last? {
            Source::Edges(i, j) => {
                let counts = [&self.a, &self.b].map(|solid| solid.side_by_side.edges.len());
                let exist = (i as usize) < counts[0] && (j as usize) < counts[1];
                if exist { self.axes_of_edges(&[i], smallvec![j]).0 } else { None }
            }
            face => self.face_axis(face),
        }
    }

    /// Appends the manifold along the axis of the last step if that must be chosen again; `false` if it need not be, or has
    /// not the deepest points, so that others may be needed.
    ///
    /// See `choose_axis`: the last axis stays while it is no worse than the best by `tolerance.axis`, and an edge while no
    /// face is better.
    fn push_along_last(&self, bounds: &AxisBounds, hint: &mut u32, out: &mut LocalManifolds) -> bool {
        let Some(axis) = self.last_axis() else { return false };
        let tolerance = &self.pair.tolerance;
        let is_edge = matches!(axis.source, Source::Edges(..));
        let is_beaten = axis.separation + tolerance.axis < bounds.best || is_edge && axis.separation < bounds.faces;
        if is_beaten || axis.separation > tolerance.margin {
            return false;
        }
        let mut points = Candidates::new();
        let normal = self.pair.along(&axis, &mut points);
        if !reach_deepest(&points, &axis, tolerance) {
            return false;
        }
        *hint = axis.source.to_hint(axis.separation > 0.0);
        push_manifold(normal, self.pair.part, &mut points, tolerance.clip, out);
        true
    }
}

impl Axes {
    /// What other axes of the pair reach, if what follows from `chosen` can be known again from that.
    ///
    /// Of shapes that overlap no direction has a greater separation than the best axis; of others none has more than
    /// their distance, and that is no more than between two of their points, `nearest`.
    fn bounds(&self, chosen: &Axis, nearest: Option<f32>, tolerance: &Tolerance) -> Option<AxisBounds> {
        let faces = greatest_separation(&self.faces);
        let mut best = self.edges.map_or(faces, |edges| faces.max(edges.separation));
        if best > 0.0 {
            best = best.max(nearest?);
        }
        let across = self.faces.iter().filter(|axis| axis.direction.dot(chosen.direction).abs() < NEARLY_ACROSS);
        (greatest_separation(across) < -2.0 * tolerance.sliver).then_some(AxisBounds { best, faces })
    }
}

/// A plane in another frame.
fn plane_in(pose: &Pose, normal: Vec3, offset: f32) -> (Vec3, f32) {
    let normal = pose.rotation * normal;
    (normal, offset + normal.dot(pose.translation))
}

/// The face with the greatest height, and that.
fn highest(heights: &[f32]) -> (u32, f32) {
    let greatest =
        heights.iter().fold(f32::NEG_INFINITY, |greatest, &height| if height > greatest { height } else { greatest });
    (heights.iter().position(|&height| height == greatest).unwrap_or(0) as u32, greatest)
}

/// Direction of an edge of B in the frame of A, and normals of its faces.
struct PlacedEdge {
    along: Vec3,
    normals: [Vec3; 2],
}

impl PlacedEdge {
    /// Whether its negated arc, if that and the one of A's edge separate each other's ends, crosses it in the same half of the
    /// sphere, not in the opposite point.
    fn is_same_half(&self, a: &EdgeAxis) -> bool {
        let ([a0, a1], [b0, b1]) = (a.normals, self.normals.map(|normal| -normal));
        // The arc b meets the plane of a in this direction (its ends are on both sides).
        let plane = a0.cross(a1);
        let (d0, d1) = (b0.dot(plane), b1.dot(plane));
        let meet = b0 * d1.abs() + b1 * d0.abs();
        meet.dot(a0 + a1) > 0.0
    }
}

/// Some edges of B by coordinates; a place without an edge crosses nothing.
#[derive(Clone, Copy, Default)]
struct EdgeLanes {
    along: Vectors,
    normals: [Vectors; 2],
}

impl EdgeLanes {
    /// Below 0 where an edge has an arc (−b₀, −b₁) that crosses the plane of the arc (a₀, a₁) as that crosses its own: each
    /// has its ends on both sides of the other's plane. An edge is along a₀ × a₁ up to a positive factor, so it stands for
    /// the plane.
    fn crossing(&self, edge: &EdgeAxis) -> Lane {
        let (b0, b1) = (self.normals[0].dots(edge.along), self.normals[1].dots(edge.along));
        let (a0, a1) = (self.along.dots(edge.normals[0]), self.along.dots(edge.normals[1]));
        let mut worse = [0.0; SIDE_BY_SIDE];
        for k in 0..SIDE_BY_SIDE {
            let (b, a) = (b0[k] * b1[k], a0[k] * a1[k]);
            worse[k] = if b > a { b } else { a };
        }
        worse
    }
}

/// The edges of B that may be nearest to A, in the frame of A; large, so it is filled where it is.
#[derive(Default)]
struct PlacedEdges {
    numbers: Numbers,
    lanes: SmallVec<[EdgeLanes; 2]>,
}

impl PlacedEdges {
    fn place(&mut self, edges: &[EdgeAxis], numbers: Numbers, pose: &Pose) {
        for chunk in numbers.chunks(SIDE_BY_SIDE) {
            let mut lanes = EdgeLanes::default();
            for (lane, &number) in chunk.iter().enumerate() {
                let edge = &edges[number as usize];
                lanes.along.set(lane, edge.along);
                lanes.normals[0].set(lane, edge.normals[0]);
                lanes.normals[1].set(lane, edge.normals[1]);
            }
            self.lanes.push(lanes);
        }
        self.numbers = numbers;
        let turn = Mat3::from_quat(pose.rotation);
        for lanes in &mut self.lanes {
            lanes.along = lanes.along.turned(&turn);
            lanes.normals = lanes.normals.map(|normals| normals.turned(&turn));
        }
    }

    /// The edges that cross the plane of an edge of A as that crosses theirs, with their numbers.
    fn for_each_crossing(&self, edge_a: &EdgeAxis, mut visit: impl FnMut(u32, PlacedEdge)) {
        for (lanes, numbers) in self.lanes.iter().zip(self.numbers.chunks(SIDE_BY_SIDE)) {
            let crossing = lanes.crossing(edge_a);
            for ((lane, &number), _) in numbers.iter().enumerate().zip(crossing).filter(|&(_, worse)| worse < 0.0) {
                let normals = lanes.normals.each_ref().map(|normals| normals.get(lane));
                visit(number, PlacedEdge { along: lanes.along.get(lane), normals });
            }
        }
    }
}

/// Direction and separation of the axis of two edges, if they are not parallel; that of B begins at `start`.
fn edge_axis(a: &EdgeAxis, b: &PlacedEdge, start: Vec3) -> Option<(Vec3, f32)> {
    let cross = a.along.cross(b.along);
    let square = cross.length_squared();
    if square < PARALLEL_SQUARED * a.along.length_squared() * b.along.length_squared() {
        return None;
    }
    let unit = cross / square.sqrt();
    // Outward from A: on the side of the normals of the edge.
    let direction = if unit.dot(a.normals[0] + a.normals[1]) >= 0.0 { unit } else { -unit };
    Some((direction, direction.dot(start - a.start)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::narrow_phase::find_manifolds;
    use crate::math::{Quat, rotation_from_vector};
    use crate::shape::{ConvexHull, Geometry};
    use crate::solver::permutation::Random;
    use std::sync::Arc;

    const MARGIN: f32 = 0.02;

    /// In [−1, 1).
    fn number(random: &mut Random) -> f32 {
        (random.bits() >> 40) as f32 / (1 << 23) as f32 - 1.0
    }

    fn vector(random: &mut Random) -> Vec3 {
        Vec3::new(number(random), number(random), number(random))
    }

    /// On an ellipsoid, or a box.
    fn solid(random: &mut Random) -> Geometry {
        let half_axes = Vec3::splat(0.2) + 0.1 * vector(random);
        if number(random) > 0.5 {
            return Geometry::Cuboid { half_extents: half_axes };
        }
        let points: Vec<Vec3> = (0..14).map(|_| half_axes * vector(random).normalize()).collect();
        Geometry::ConvexHull(Arc::new(ConvexHull::new(&points).unwrap()))
    }

    /// What a pair remembers changes no bit: slow bodies against those whose pairs forget all but the axis. They sink into
    /// each other, part, slide and turn.
    #[test]
    fn what_is_remembered_changes_nothing() {
        let mut random = Random(3);
        let (mut along_known, mut skipped, mut searched, mut differ) = (0, 0, 0, 0);
        for _ in 0..400 {
            let (a, b) = (solid(&mut random), solid(&mut random));
            if !matches!((&a, &b), (Geometry::ConvexHull(_), _) | (_, Geometry::ConvexHull(_))) {
                continue;
            }
            let direction = vector(&mut random).normalize();
            let mut pose = Pose::from_parts(direction * 0.5, rotation_from_vector(3.0 * vector(&mut random)));
            let mut memories = [PairMemory::default(); 2];
            let mut out = [LocalManifolds::new(), LocalManifolds::new()];
            // Together quickly, then slowly and at random.
            for step in 0..120 {
                let speed = if step < 20 { 1e-2 } else { 10.0_f32.powi(-2 - step % 4) };
                let inward = if out[0].is_empty() { 0.5 } else { 0.0 };
                pose.translation += speed * (0.5 * vector(&mut random) - inward * direction);
                let turn: Quat = rotation_from_vector(speed * vector(&mut random));
                pose.rotation = (turn * pose.rotation).normalize();
                let known = memories[0].recall(&pose, b.outer_radius());
                memories[1].forget();
                for (memory, out) in memories.iter_mut().zip(&mut out) {
                    find_manifolds(&a, &b, &pose, MARGIN, 1.0, memory, out);
                }
                match memories[0].recall(&pose, b.outer_radius()) {
                    _ if known.is_gap_beyond(MARGIN) => skipped += 1,
                    Known::Axis(_, moved) if moved > 0.0 => along_known += 1,
                    _ => searched += 1,
                }
                differ += u32::from(out[0] != out[1]);
                memories[1].axis = memories[0].axis;
            }
        }
        assert_eq!(differ, 0, "of {along_known} along the known axis, {skipped} apart, {searched} searched");
        assert!(along_known > 5000 && skipped > 5000, "{along_known} and {skipped} of {searched} needed no search");
    }
}
