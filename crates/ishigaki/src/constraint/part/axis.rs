//! An axis in common, and the angle about it. TALK B8.
//!
//! a, b: the joint's axis on A and on B, unit, in world. σ: angle between them; n = a×b/sin σ. The error is the vector
//! e = σ n (rad), the rotation of B relative to A that has turned a into b. Its two components along tangents t₁, t₂
//! fixed to A are the rows, so that λ turns with A, as the load of a door does. Turning about b itself leaves b where
//! it is, so J must be ⟂ b: the row is t' = t turned by the shortest rotation from a to b, w = t'·(ω_A − ω_B). At σ =
//! 0, t' = t. (ė has t' with a factor σ/sin σ along b×n, where e has no component; it would change the scale of λ,
//! not the solution.) With t instead of t', or sin σ instead of σ, a hinge opened by 90° would never find back.
//!
//! The angle about the axis is the twist of R_rel = swing · twist: θ = 2 atan2(q·axis, q_w), with the exact rate
//! θ̇ = g·(ω_B − ω_A), g = (a + b)/(1 + a·b), of length 1/cos(σ/2). g is bounded for σ > 168°, where twist loses its
//! meaning.
//!
//! Test: `joint_rows::jacobians_are_derivatives`, `joint_rows::axis_recovers_from_any_angle`.

use crate::constraint::frame::{FramePair, JointStep};
use crate::constraint::part::limit_motor::{Coordinate, nearest_turn};
use crate::constraint::row::{Jacobian, RowSpec};
use crate::math::{Vec3, atan2, tangents};

/// Below this cos(σ/2) the twist fades out: σ > 168.5°.
const LEAST_HALF_COSINE: f32 = 0.1;

/// One axis fixed to both bodies: 2 rows.
#[derive(Clone, Copy, Debug)]
pub struct Axis {
    /// The rows' directions, unit, ⟂ axis_b.
    tangents: [Vec3; 2],
    /// Rotation of B relative to A, rad.
    error: [f32; 2],
}

impl Axis {
    /// Rows it takes.
    pub const ROWS: usize = 2;

    /// At this moment; `axis` is a unit vector in the joint's frame.
    pub fn new(pair: &FramePair, axis: Vec3) -> Self {
        let (a, b) = (pair.frame_a * axis, pair.frame_b * axis);
        let (t1, t2) = tangents(axis);
        let (t1, t2) = (pair.frame_a * t1, pair.frame_a * t2);
        let cross = a.cross(b);
        let (sine, cosine) = (cross.length(), a.dot(b));
        if cosine > -0.5 {
            // σ/sin σ = 1 + σ²/6 + …
            let scale = if sine > 1e-4 { atan2(sine, cosine) / sine } else { 1.0 };
            let turned = |t: Vec3| t - (a + b) * (b.dot(t) / (1.0 + cosine));
            return Self { tangents: [turned(t1), turned(t2)], error: [scale * t1.dot(cross), scale * t2.dot(cross)] };
        }
        // Near antiparallel the arc's formula divides by zero; the turn about n does not. At σ = π any n will do.
        let n = if sine > 1e-3 { cross / sine } else { t1 };
        let (m, m_turned) = (a.cross(n), b.cross(n));
        let turned = |t: Vec3| n * t.dot(n) + m_turned * t.dot(m);
        let angle = atan2(sine, cosine);
        Self { tangents: [turned(t1), turned(t2)], error: [angle * t1.dot(n), angle * t2.dot(n)] }
    }

    /// Angle between the axes, rad.
    pub fn error(&self) -> f32 {
        (self.error[0] * self.error[0] + self.error[1] * self.error[1]).sqrt()
    }

    // ANCHOR: rows
    /// Two rows.
    pub fn rows(&self, step: &JointStep, out: &mut Vec<RowSpec>) {
        for (tangent, error) in self.tangents.into_iter().zip(self.error) {
            // The row is of A relative to B, the error of B relative to A.
            out.push(RowSpec::equality(Jacobian::rotation(tangent), step.recovery(-error)));
        }
    }
    // ANCHOR_END: rows
}

/// The angle of B relative to A about `axis` (unit, in the joint's frame), rad; of all turns the one nearest to
/// `reference`.
pub fn twist(pair: &FramePair, axis: Vec3, reference: f32) -> Coordinate {
    let q = pair.relative();
    let angle = 2.0 * atan2(q.xyz().dot(axis), q.w);
    let (a, b) = (pair.frame_a * axis, pair.frame_b * axis);
    let half_cosine = 0.5 * (a + b).length();
    // (a + b)/(1 + a·b) = (a + b)/(2 cos²(σ/2))
    let g = if half_cosine > 1e-4 { (a + b) / (2.0 * half_cosine * half_cosine.max(LEAST_HALF_COSINE)) } else { a };
    Coordinate::new(nearest_turn(angle, reference), Jacobian::rotation(g).negated(), pair)
}

/// How far a twist can be believed: 1, and falling to 0 as B's axis turns opposite to A's, where it is undefined.
pub fn twist_trust(pair: &FramePair, axis: Vec3) -> f32 {
    let sum = pair.frame_a * axis + pair.frame_b * axis;
    (0.5 * sum.length() / LEAST_HALF_COSINE).min(1.0)
}

/// The angle between the `axis` (unit, in the joint's frame) on A and on B, in [0, π] rad, with its derivative.
pub fn swing(pair: &FramePair, axis: Vec3) -> Coordinate {
    let (a, b) = (pair.frame_a * axis, pair.frame_b * axis);
    let cross = a.cross(b);
    let sine = cross.length();
    // At 0 and at π every direction across is as good: moving about any changes the angle the same way.
    let n = if sine > 1e-5 { cross / sine } else { pair.frame_a * tangents(axis).0 };
    Coordinate::new(atan2(sine, a.dot(b)), Jacobian::rotation(n).negated(), pair)
}
