//! Contact points of two boxes over a face of one of them.
//!
//! As `clip.rs`, for the pair that worlds are full of: in the frame of the reference box the sides of its face are
//! planes of coordinates, so clipping compares numbers and needs neither products nor roots. The sides are taken in
//! the same order and named in the same way. Tests: `tests/narrow_phase.rs`, `tests/feature_ids.rs`.

use crate::collision::clip::{Candidates, REFERENCE, Sides, features};
use crate::collision::feature_id::FeatureId;
use crate::collision::manifold::LocalPoint;
use crate::collision::polyhedron::{BOX_CORNER_EDGES, BOX_CORNER_VERTICES, box_corner, box_face};
use crate::collision::sat::Tolerance;
use crate::math::{Mat3, Vec3};
use arrayvec::ArrayVec;

/// A face of a box by its number.
struct BoxFace(usize);

impl Sides for BoxFace {
    fn face(&self) -> u32 {
        self.0 as u32
    }

    fn count(&self) -> usize {
        4
    }

    fn vertex(&self, corner: usize) -> u32 {
        BOX_CORNER_VERTICES[4 * self.0 + corner]
    }

    fn edge(&self, corner: usize) -> u32 {
        BOX_CORNER_EDGES[4 * self.0 + corner]
    }
}

/// Two boxes in the frame of the first, whose face is the reference.
struct BoxesOnFace {
    /// Half extents, m.
    half: Vec3,
    other_half: Vec3,
    /// Turns from the frame of the other box into this one.
    turn: Mat3,
    /// Center of the other box, m.
    center: Vec3,
}

/// A corner of the polygon that is being clipped; `side` as in `clip.rs`.
#[derive(Clone, Copy)]
struct Corner {
    /// Along the axes of the reference box, m.
    point: [f32; 3],
    side: u32,
}

/// A quadrilateral gains at most a corner by each of four sides.
type Ring = ArrayVec<Corner, 8>;

impl BoxesOnFace {
    /// Calls `emit` with each point: on the reference face, on the other box, separation, name (reference first).
    fn points(&self, face: usize, tolerance: &Tolerance, mut emit: impl FnMut(Vec3, Vec3, f32, FeatureId)) {
        let (axis, positive) = (face / 2, face % 2 == 1);
        let sign = if positive { 1.0 } else { -1.0 };
        let incident = self.incident_face(axis, sign);
        let mut ring = Ring::new();
        let mut lowest = f32::INFINITY;
        for (i, vertex) in (0..).zip(&BOX_CORNER_VERTICES[4 * incident..4 * incident + 4]) {
            let point = (self.turn * box_corner(self.other_half, *vertex) + self.center).to_array();
            lowest = lowest.min(sign * point[axis]);
            ring.push(Corner { point, side: i });
        }
        if lowest - self.half[axis] > tolerance.margin {
            return;
        }
        self.clip(&mut ring, axis, positive, tolerance.clip);
        for (i, corner) in ring.iter().enumerate() {
            let separation = sign * corner.point[axis] - self.half[axis];
            if separation <= tolerance.margin {
                let before = ring[if i == 0 { ring.len() - 1 } else { i - 1 }].side;
                let (a, b) = features(&BoxFace(face), &BoxFace(incident), before, corner.side);
                let on_other = Vec3::from_array(corner.point);
                let mut on_face = on_other;
                on_face[axis] = sign * self.half[axis];
                emit(on_face, on_other, separation, FeatureId::new(a, b));
            }
        }
    }

    /// The face of the other box that looks most against the reference face.
    fn incident_face(&self, axis: usize, sign: f32) -> usize {
        let along = [self.turn.x_axis[axis], self.turn.y_axis[axis], self.turn.z_axis[axis]];
        let mut best = 0;
        for k in 1..3 {
            if along[k].abs() > along[best].abs() {
                best = k;
            }
        }
        box_face(best, sign * along[best] < 0.0)
    }

    /// Clips by the four sides of the reference face, in the order of its corners.
    fn clip(&self, ring: &mut Ring, axis: usize, positive: bool, tolerance: f32) {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        // Counter-clockwise seen from outside, from the corner where both coordinates are least.
        let sides = if positive {
            [(v, -1.0), (u, 1.0), (v, 1.0), (u, -1.0)]
        } else {
            [(u, -1.0), (v, 1.0), (u, 1.0), (v, -1.0)]
        };
        for (side, (k, outward)) in (REFERENCE..).zip(sides) {
            clip_by_side(ring, k, outward, self.half[k] + tolerance, side);
        }
    }
}

/// Keeps what lies below the plane `outward xₖ = offset`.
fn clip_by_side(ring: &mut Ring, k: usize, outward: f32, offset: f32, side: u32) {
    let height = |corner: &Corner| outward * corner.point[k] - offset;
    if ring.iter().all(|corner| height(corner) <= 0.0) {
        return;
    }
    let Some(mut here) = ring.first().copied() else { return };
    let mut d_here = height(&here);
    let mut kept = Ring::new();
    for i in 0..ring.len() {
        let next = ring[if i + 1 == ring.len() { 0 } else { i + 1 }];
        let d_next = height(&next);
        // More corners than the ring holds come from numbers that are not finite: those are dropped later.
        if d_here <= 0.0 {
            let _ = kept.try_push(here);
        }
        if (d_here <= 0.0) != (d_next <= 0.0) {
            let part = d_here / (d_here - d_next);
            let point = std::array::from_fn(|j| here.point[j] + (next.point[j] - here.point[j]) * part);
            // Leaving, the polygon goes on along the clipping side; entering, along the side it was on.
            let _ = kept.try_push(Corner { point, side: if d_here <= 0.0 { side } else { here.side } });
        }
        (here, d_here) = (next, d_next);
    }
    *ring = kept;
}

/// The points over a face as those of A and B, in the frame of A.
#[inline(always)]
pub(crate) fn face_points(
    (half_a, half_b): (Vec3, Vec3),
    (turn, center): (Mat3, Vec3),
    (face, face_is_of_a): (usize, bool),
    tolerance: &Tolerance,
    out: &mut Candidates,
) {
    if face_is_of_a {
        let boxes = BoxesOnFace { half: half_a, other_half: half_b, turn, center };
        boxes.points(face, tolerance, |on_a, on_b, separation, id| {
            out.push(LocalPoint { on_a, on_b, separation, id });
        });
    } else {
        let back = turn.transpose();
        let boxes = BoxesOnFace { half: half_b, other_half: half_a, turn: back, center: -(back * center) };
        boxes.points(face, tolerance, |on_b, on_a, separation, id| {
            let [on_a, on_b] = [on_a, on_b].map(|p| turn * p + center);
            out.push(LocalPoint { on_a, on_b, separation, id: id.swapped() });
        });
    }
}
