//! No relative rotation: 3 rows. TALK B6.
//!
//! The error is the rotation vector e = log(R_Aᵀ R_B), rad. Its exact rate is ė = Jₗ⁻¹(e) R_Aᵀ(ω_B − ω_A), and
//! Jₗ⁻¹(e)ᵀ = exp(½e) up to |e|²/24: the rows therefore lie along the axes of the frame *halfway* between the two,
//! where J is the derivative to second order in the error and neither body is preferred. e has the same components in
//! A's, B's and the halfway frame, so recovery turns B home about e by the shortest way, from 170° as from 1°. The λ
//! turn with the bodies. With cross products of axes as error (sin instead of angle) a joint turned by more than 90°
//! would be pushed away.
//!
//! Test: `joint_rows::jacobians_are_derivatives`, `joint_rows::fixed_recovers_from_any_angle`.

use crate::constraint::frame::{FramePair, JointStep};
use crate::constraint::row::{Jacobian, RowSpec};
use crate::math::{Mat3, Vec3, vector_from_rotation};

/// Two frames are parallel: 3 rows.
#[derive(Clone, Copy, Debug)]
pub struct Angle {
    halfway: Mat3,
    error: Vec3,
}

impl Angle {
    /// Rows it takes.
    pub const ROWS: usize = 3;

    /// At this moment.
    pub fn new(pair: &FramePair) -> Self {
        // q and −q are one rotation: of B's two take the one on A's side; the mean is then at least 1/√2 long.
        let same_side = if pair.frame_a.dot(pair.frame_b) < 0.0 { -pair.frame_b } else { pair.frame_b };
        let halfway = (pair.frame_a + same_side).normalize();
        Self { halfway: Mat3::from_quat(halfway), error: vector_from_rotation(pair.relative()) }
    }

    /// Angle between the frames, rad.
    pub fn error(&self) -> f32 {
        self.error.length()
    }

    /// Three rows along the halfway frame's axes.
    pub fn rows(&self, step: &JointStep, out: &mut Vec<RowSpec>) {
        for i in 0..3 {
            // The row is of A relative to B, the error of B relative to A.
            out.push(RowSpec::equality(Jacobian::rotation(self.halfway.col(i)), step.recovery(-self.error[i])));
        }
    }
}
