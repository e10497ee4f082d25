//! A segment and a polyhedron: the nearest points, or the axis of least overlap. What a capsule's core needs.
//!
//! The planes of the faces say most: nothing is nearer than the best of them, and where the end of the segment lies over
//! that face, nothing else needs to be looked at. Test: `tests/narrow_phase.rs`.

use crate::collision::clip::nearest_on_segments;
use crate::collision::feature_id::Feature;
use crate::collision::polyhedron::Polyhedron;
use crate::collision::round::{is_over, nearest_on_polyhedron, sine};
use crate::math::Vec3;
use crate::shape::hull::Face;
use smallvec::SmallVec;

/// How a segment lies to a polyhedron.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SegmentGap {
    /// From the polyhedron to the segment, unit.
    pub direction: Vec3,
    /// m; negative where the segment is inside.
    pub distance: f32,
    /// Of the polyhedron.
    pub feature: Feature,
    pub on_solid: Vec3,
    /// Part of the segment.
    pub part: f32,
}

/// How a segment may lie to a polyhedron: on its best face, or otherwise if that is clearly better.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SegmentGaps {
    over_face: SegmentGap,
    other: Option<SegmentGap>,
}

impl SegmentGaps {
    /// The nearest points, or the axis of least overlap; faces are preferred by `tolerance` (m).
    pub fn choose(&self, tolerance: f32) -> SegmentGap {
        match self.other {
            // A capsule on a face stays on the face: two points instead of one.
            Some(gap) if gap.distance > self.over_face.distance + tolerance => gap,
            _ => self.over_face,
        }
    }
}

/// The nearest points of a segment and a polyhedron, or the axes of least overlap; `None` beyond `reach`.
pub(crate) fn segment_gaps(solid: &Polyhedron, ends: [Vec3; 2], reach: f32) -> Option<SegmentGaps> {
    // The best face: distance of the nearer end from its plane.
    let mut face = (0, f32::NEG_INFINITY);
    for (i, plane) in solid.faces.iter().enumerate() {
        let low = plane.normal.dot(ends[0]).min(plane.normal.dot(ends[1])) - plane.offset;
        if low > face.1 {
            face = (i, low);
        }
    }
    if face.1 > reach {
        return None;
    }
    let normal = solid.faces[face.0].normal;
    let near = (normal.dot(ends[1]) < normal.dot(ends[0])) as usize;
    let over_face = SegmentGap {
        direction: normal,
        distance: face.1,
        feature: Feature::face(face.0 as u32),
        on_solid: ends[near] - normal * face.1,
        part: near as f32,
    };
    let other = if face.1 > 0.0 {
        // Nothing is nearer than the plane, and the end over the face is as near.
        (!is_over(solid, face.0, ends[near])).then(|| nearest_apart(solid, ends, normal))
    } else {
        let crossing = edge_crossing(solid, ends);
        let apart = crossing.is_some_and(|gap| gap.distance > 0.0);
        if apart { Some(nearest_apart(solid, ends, normal)) } else { crossing }
    };
    Some(SegmentGaps { over_face, other })
}

/// The best axis across an edge of the polyhedron and the segment.
fn edge_crossing(solid: &Polyhedron, ends: [Vec3; 2]) -> Option<SegmentGap> {
    let along = ends[1] - ends[0];
    let mut best: Option<(f32, usize, Vec3)> = None;
    for (i, edge) in solid.edges.iter().enumerate() {
        let [start, end] = solid.edge_points(i);
        let cross = (end - start).cross(along);
        let normals = edge.faces.map(|f| solid.faces[f as usize].normal);
        let outward = cross.dot(normals[0] + normals[1]) >= 0.0;
        // Nothing else than a better axis is worth a root; signs tell most edges that look away.
        let ahead = if outward { cross } else { -cross };
        if ahead.dot(ends[0] - start) < 0.0 && best.is_some_and(|best| best.0 >= 0.0) {
            continue;
        }
        if sine(end - start, along) < 1e-3 {
            continue;
        }
        let Some(direction) = ahead.try_normalize() else { continue };
        // On the arc between the normals of the two faces.
        let cosine = normals[0].dot(normals[1]);
        if direction.dot(normals[0]) < cosine || direction.dot(normals[1]) < cosine {
            continue;
        }
        let distance = direction.dot(ends[0] - start);
        if best.is_none_or(|best| distance > best.0) {
            best = Some((distance, i, direction));
        }
    }
    best.map(|(distance, i, direction)| {
        let [start, end] = solid.edge_points(i);
        let (s, t) = nearest_on_segments([start, end], ends);
        let feature = Feature::edge(i as u32);
        SegmentGap { direction, distance, feature, on_solid: start.lerp(end, s), part: t }
    })
}

/// Nearest points of a polyhedron and a segment that does not enter it.
fn nearest_apart(solid: &Polyhedron, ends: [Vec3; 2], fallback: Vec3) -> SegmentGap {
    let of_end = |i: usize| {
        let nearest = nearest_on_polyhedron(solid, ends[i]);
        SegmentGap {
            direction: nearest.normal,
            distance: nearest.distance,
            feature: nearest.feature,
            on_solid: nearest.point,
            part: i as f32,
        }
    };
    let (first, second) = (of_end(0), of_end(1));
    let mut best = if second.distance < first.distance { second } else { first };
    let beyond = faces_beyond(solid, ends, best.distance);
    for (i, edge) in solid.edges.iter().enumerate() {
        if edge.faces.iter().any(|&face| beyond[face as usize]) {
            continue;
        }
        let [start, end] = solid.edge_points(i);
        let (s, t) = nearest_on_segments([start, end], ends);
        let on_solid = start.lerp(end, s);
        let gap = ends[0].lerp(ends[1], t) - on_solid;
        let distance = gap.length();
        // Clearly nearer, or the ends found it already.
        if distance < (1.0 - 1e-6) * best.distance {
            let feature = match s {
                s if s <= 0.0 => Feature::vertex(edge.vertices[0]),
                s if s >= 1.0 => Feature::vertex(edge.vertices[1]),
                _ => Feature::edge(i as u32),
            };
            let direction = if distance > 1e-9 { gap / distance } else { fallback };
            best = SegmentGap { direction, distance, feature, on_solid, part: t };
        }
    }
    best
}

/// Faces between which no edge is within `distance` (m) of the segment: it is that far behind or in front of the plane.
fn faces_beyond(solid: &Polyhedron, ends: [Vec3; 2], distance: f32) -> SmallVec<[bool; 32]> {
    let is_beyond = |face: &Face| {
        let [first, second] = ends.map(|end| face.normal.dot(end) - face.offset);
        first.min(second) > distance || first.max(second) < -distance
    };
    solid.faces.iter().map(is_beyond).collect()
}
