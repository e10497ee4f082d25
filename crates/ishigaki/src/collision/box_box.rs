//! Two boxes: the separating axis test in closed form.
//!
//! 15 axes: three normals of each box and nine cross products of edges. Along axis l the separation is
//! |t·l| − (reach of A) − (reach of B), where a box with half extents h and axes uₖ reaches Σ hₖ |uₖ·l|
//! (Gottschalk et al. 1996, "OBBTree"). Everything in the frame of A, where its axes are the coordinate axes.
//! Test: `tests/narrow_phase.rs` against a search over all axes in f64.

use crate::collision::narrow_phase::LocalManifolds;
use crate::collision::polyhedron::{BoxPolyhedron, box_edge, box_face};
use crate::collision::sat::{Axis, Pair, Source, Tolerance, choose_axis};
use crate::math::{Mat3, Pose, Vec3};
use arrayvec::ArrayVec;

/// Sine of the angle below which two edges count as parallel: their faces find the same axes.
const PARALLEL: f32 = 1e-3;

/// Manifold of two boxes with these half extents, m.
pub(crate) fn box_box(
    half_a: Vec3,
    half_b: Vec3,
    b_in_a: &Pose,
    margin: f32,
    length_scale: f32,
    hint: &mut u32,
    out: &mut LocalManifolds,
) {
    let test = BoxTest { half_a, half_b, turn: Mat3::from_quat(b_in_a.rotation), center: b_in_a.translation };
    let faces = test.faces();
    if let Some(apart) = faces.iter().find(|axis| axis.separation > margin) {
        *hint = apart.source.to_hint(true);
        return;
    }
    let (edges, last_edges) = test.edges(*hint);
    if let Some(apart) = edges.filter(|axis| axis.separation > margin) {
        *hint = apart.source.to_hint(true);
        return;
    }
    let tolerance = Tolerance::new(margin, length_scale, half_a.min_element().min(half_b.min_element()));
    match choose_axis(&faces, edges, last_edges, &tolerance, *hint) {
        Some(axis) => {
            *hint = axis.source.to_hint(axis.separation > 0.0);
            let (a, b) = (BoxPolyhedron::new(half_a), BoxPolyhedron::new(half_b));
            Pair { a: a.view(), b: b.view(), b_in_a, part: (0, 0), tolerance }.push_contact(&axis, &faces, edges, out);
        }
        None => {
            let apart = faces.iter().max_by(|p, q| p.separation.total_cmp(&q.separation));
            if let Some(apart) = apart.filter(|axis| axis.separation > 0.0) {
                *hint = apart.source.to_hint(true);
            }
        }
    }
}

struct BoxTest {
    half_a: Vec3,
    half_b: Vec3,
    /// Its columns are the axes of B.
    turn: Mat3,
    center: Vec3,
}

impl BoxTest {
    /// The six axes of faces, each with the face that looks at the other box.
    fn faces(&self) -> ArrayVec<Axis, 6> {
        let axes = [self.turn.x_axis, self.turn.y_axis, self.turn.z_axis];
        let mut out = ArrayVec::new();
        for (k, unit) in Vec3::AXES.into_iter().enumerate() {
            let reach_b = self.half_b.dot(Vec3::new(axes[0][k], axes[1][k], axes[2][k]).abs());
            let positive = self.center[k] >= 0.0;
            let sign = if positive { 1.0 } else { -1.0 };
            out.push(Axis {
                source: Source::FaceA(box_face(k, positive) as u32),
                direction: sign * unit,
                separation: self.center[k].abs() - self.half_a[k] - reach_b,
            });
        }
        for (k, &axis) in axes.iter().enumerate() {
            let along = self.center.dot(axis);
            let positive = along < 0.0;
            let sign = if positive { -1.0 } else { 1.0 };
            out.push(Axis {
                source: Source::FaceB(box_face(k, positive) as u32),
                direction: sign * axis,
                separation: along.abs() - self.half_b[k] - self.half_a.dot(axis.abs()),
            });
        }
        out
    }

    /// The best of the nine cross products, and that of the last step.
    fn edges(&self, hint: u32) -> (Option<Axis>, Option<Axis>) {
        let last = match Source::from_hint(hint) {
            Some((Source::Edges(a, b), _)) => Some((a / 4, b / 4)),
            _ => None,
        };
        let axes = [self.turn.x_axis, self.turn.y_axis, self.turn.z_axis];
        let mut best: Option<(f32, Vec3, usize, usize)> = None;
        let mut last_edges = None;
        for (i, axis_a) in Vec3::AXES.into_iter().enumerate() {
            for (j, axis_b) in axes.into_iter().enumerate() {
                let cross = axis_a.cross(axis_b);
                let sine = cross.length();
                if sine < PARALLEL {
                    continue;
                }
                // eᵢ × uⱼ dotted with the other axes of B: ± the i-th component of the third one.
                let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
                let reach_b = self.half_b[j1] * axes[j2][i].abs() + self.half_b[j2] * axes[j1][i].abs();
                let reach = self.half_a.dot(cross.abs()) + reach_b;
                let along = self.center.dot(cross);
                let separation = (along.abs() - reach) / sine;
                let is_last = last == Some((i as u32, j as u32));
                if is_last || best.is_none_or(|best| separation > best.0) {
                    let direction = if along >= 0.0 { cross / sine } else { -cross / sine };
                    if best.is_none_or(|best| separation > best.0) {
                        best = Some((separation, direction, i, j));
                    }
                    if is_last {
                        last_edges = Some(self.edge_axis(separation, direction, i, j));
                    }
                }
            }
        }
        (best.map(|(separation, direction, i, j)| self.edge_axis(separation, direction, i, j)), last_edges)
    }

    /// The axis with the two edges that lie farthest along it, toward each other.
    fn edge_axis(&self, separation: f32, direction: Vec3, i: usize, j: usize) -> Axis {
        let edge = |axis: usize, outward: Vec3| {
            let positive = |k: usize| (outward[k % 3] > 0.0) as usize;
            box_edge(axis, positive(axis + 1), positive(axis + 2)) as u32
        };
        let toward_a = self.turn.transpose() * -direction;
        Axis { source: Source::Edges(edge(i, direction), edge(j, toward_a)), direction, separation }
    }
}
