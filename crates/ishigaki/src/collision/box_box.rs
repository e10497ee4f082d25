//! Two boxes: the separating axis test in closed form.
//!
//! 15 axes: three normals of each box and nine cross products of edges. Along axis l the separation is
//! |t·l| − (reach of A) − (reach of B), where a box with half extents h and axes uₖ reaches Σ hₖ |uₖ·l|
//! (Gottschalk et al. 1996, "OBBTree"). Everything in the frame of A, where its axes are the coordinate axes.
//! Test: `tests/narrow_phase.rs` against a search over all axes in f64.

use crate::collision::box_clip::face_points;
use crate::collision::clip::Candidates;
use crate::collision::manifold::LocalPoint;
use crate::collision::narrow_phase::LocalManifolds;
use crate::collision::polyhedron::{BoxPolyhedron, box_edge, box_edge_points, box_face};
use crate::collision::sat::{
    Axis, Pair, Points, Source, Tolerance, choose_axis, edge_point, greatest_separation, push_contact,
};
use crate::math::{Mat3, Pose, Vec3};

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
    let test = BoxTest::new(half_a, half_b, b_in_a);
    let faces = test.faces();
    if let Some(apart) = faces.iter().find(|axis| axis.separation > margin) {
        *hint = apart.source.to_hint(true);
        return;
    }
    let greatest = greatest_separation(&faces);
    let (edges, last_edges) = test.edges(*hint, greatest);
    if let Some(apart) = edges.filter(|axis| axis.separation > margin) {
        *hint = apart.source.to_hint(true);
        return;
    }
    let tolerance = Tolerance::new(margin, length_scale, half_a.min_element().min(half_b.min_element()));
    match choose_axis(&faces, edges, last_edges, &tolerance, *hint) {
        Some(axis) => {
            let last = std::mem::replace(hint, axis.source.to_hint(axis.separation > 0.0));
            let greatest = edges.map_or(greatest, |edges| edges.separation.max(greatest));
            let all_edges = || test.edges(last, f32::NEG_INFINITY).0;
            let pair = BoxPair { test: &test, b_in_a, tolerance: &tolerance };
            push_contact(&pair, (&axis, greatest), all_edges, (0, &tolerance), out);
        }
        None => {
            let apart = faces.iter().max_by(|p, q| p.separation.total_cmp(&q.separation));
            if let Some(apart) = apart.filter(|axis| axis.separation > 0.0) {
                *hint = apart.source.to_hint(true);
            }
        }
    }
}

/// Two boxes with what contact points are made from.
struct BoxPair<'a> {
    test: &'a BoxTest,
    b_in_a: &'a Pose,
    tolerance: &'a Tolerance,
}

impl Points for BoxPair<'_> {
    fn along(&self, axis: &Axis, points: &mut Candidates) -> Vec3 {
        let BoxTest { half_a, half_b, turn, center, .. } = *self.test;
        let (face, of_a) = match axis.source {
            Source::FaceA(face) => (face as usize, true),
            Source::FaceB(face) => (face as usize, false),
            Source::Edges(edge_a, edge_b) => {
                let of_a = box_edge_points(half_a, edge_a as usize);
                let of_b = box_edge_points(half_b, edge_b as usize).map(|p| turn * p + center);
                points.push(edge_point((edge_a, of_a), (edge_b, of_b), axis.direction));
                return -axis.direction;
            }
        };
        face_points((half_a, half_b), (turn, center), (face, of_a), self.tolerance, points);
        -axis.direction
    }

    fn deepest(&self, axis: &Axis) -> LocalPoint {
        // Hardly ever needed: as for any polyhedra.
        let (a, b) = (BoxPolyhedron::new(self.test.half_a), BoxPolyhedron::new(self.test.half_b));
        let tolerance = *self.tolerance;
        Pair { a: a.view(), b: b.view(), b_in_a: self.b_in_a, part: 0, tolerance }.deepest(axis)
    }
}

struct BoxTest {
    half_a: Vec3,
    half_b: Vec3,
    /// Its columns are the axes of B.
    turn: Mat3,
    center: Vec3,
    /// The same as numbers: `cosines[i][j]` is axis i of A · axis j of B; and without signs.
    cosines: [[f32; 3]; 3],
    magnitudes: [[f32; 3]; 3],
}

/// The other two axes of each.
const OTHERS: [[usize; 2]; 3] = [[1, 2], [2, 0], [0, 1]];

impl BoxTest {
    fn new(half_a: Vec3, half_b: Vec3, b_in_a: &Pose) -> Self {
        let turn = Mat3::from_quat(b_in_a.rotation);
        let rows = turn.transpose();
        let cosines = [rows.x_axis.to_array(), rows.y_axis.to_array(), rows.z_axis.to_array()];
        let magnitudes = [rows.x_axis, rows.y_axis, rows.z_axis].map(|row| row.abs().to_array());
        Self { half_a, half_b, turn, center: b_in_a.translation, cosines, magnitudes }
    }

    /// The six axes of faces, each with the face that looks at the other box. One by one: left to a closure, whether the
    /// compiler unrolls them depends on edits far away.
    fn faces(&self) -> [Axis; 6] {
        [
            self.face_of_a(0),
            self.face_of_a(1),
            self.face_of_a(2),
            self.face_of_b(0),
            self.face_of_b(1),
            self.face_of_b(2),
        ]
    }

    #[inline(always)]
    fn face_of_a(&self, k: usize) -> Axis {
        let positive = self.center[k] >= 0.0;
        let sign = if positive { 1.0 } else { -1.0 };
        Axis {
            source: Source::FaceA(box_face(k, positive) as u32),
            direction: sign * Vec3::AXES[k],
            separation: self.center[k].abs() - self.half_a[k] - self.half_b.dot(Vec3::from_array(self.magnitudes[k])),
        }
    }

    #[inline(always)]
    fn face_of_b(&self, k: usize) -> Axis {
        let axis = self.turn.col(k);
        let along = self.center.dot(axis);
        let positive = along < 0.0;
        let sign = if positive { -1.0 } else { 1.0 };
        Axis {
            source: Source::FaceB(box_face(k, positive) as u32),
            direction: sign * axis,
            separation: along.abs() - self.half_b[k] - self.half_a.dot(axis.abs()),
        }
    }

    /// The cross products of edges: center · (eᵢ × uⱼ), and its magnitude less what both boxes reach, by 3 i + j.
    fn crossings(&self) -> ([f32; 9], [f32; 9]) {
        let (center, half_a, half_b) = (self.center.to_array(), self.half_a.to_array(), self.half_b.to_array());
        let (mut along, mut scaled) = ([0.0; 9], [0.0; 9]);
        for (i, [i1, i2]) in OTHERS.into_iter().enumerate() {
            for (j, [j1, j2]) in OTHERS.into_iter().enumerate() {
                let across = center[i2] * self.cosines[i1][j] - center[i1] * self.cosines[i2][j];
                let reach_a = half_a[i1] * self.magnitudes[i2][j] + half_a[i2] * self.magnitudes[i1][j];
                // eᵢ × uⱼ dotted with the other axes of B: ± the i-th component of the third one.
                let reach_b = half_b[j1] * self.magnitudes[i][j2] + half_b[j2] * self.magnitudes[i][j1];
                along[3 * i + j] = across;
                scaled[3 * i + j] = across.abs() - (reach_a + reach_b);
            }
        }
        (along, scaled)
    }

    /// The best of the nine cross products, and that of the last step.
    ///
    /// Those whose separation is below `least` may be left out: where faces are better, most need no root.
    fn edges(&self, hint: u32, least: f32) -> (Option<Axis>, Option<Axis>) {
        let last = match Source::from_hint(hint) {
            Some((Source::Edges(a, b), _)) => 3 * (a / 4) + b / 4,
            _ => u32::MAX,
        };
        let (along, scaled) = self.crossings();
        // A sine is at most 1 (in numbers, nearly): a negative separation is no greater than the scaled one.
        let limit = (1.000_01 * least).min(0.0);
        let mut best: Option<(f32, usize)> = None;
        let mut last_edges = None;
        for (pair, &scaled) in scaled.iter().enumerate() {
            if scaled < limit {
                continue;
            }
            let [i1, i2] = OTHERS[pair / 3];
            let (u, v) = (self.cosines[i1][pair % 3], self.cosines[i2][pair % 3]);
            let square = u * u + v * v;
            if square < PARALLEL * PARALLEL {
                continue;
            }
            let separation = scaled / square.sqrt();
            if best.is_none_or(|best| separation > best.0) {
                best = Some((separation, pair));
            }
            if last == pair as u32 {
                last_edges = Some(self.edge_axis(separation, along[pair], pair));
            }
        }
        (best.map(|(separation, pair)| self.edge_axis(separation, along[pair], pair)), last_edges)
    }

    /// The axis with the two edges that lie farthest along it, toward each other.
    fn edge_axis(&self, separation: f32, along: f32, pair: usize) -> Axis {
        let (i, j) = (pair / 3, pair % 3);
        let cross = Vec3::AXES[i].cross(self.turn.col(j));
        let sine = cross.length();
        let direction = if along >= 0.0 { cross / sine } else { -cross / sine };
        let edge = |axis: usize, outward: Vec3| {
            let positive = |k: usize| (outward[k % 3] > 0.0) as usize;
            box_edge(axis, positive(axis + 1), positive(axis + 2)) as u32
        };
        let toward_a = self.turn.transpose() * -direction;
        Axis { source: Source::Edges(edge(i, direction), edge(j, toward_a)), direction, separation }
    }
}
