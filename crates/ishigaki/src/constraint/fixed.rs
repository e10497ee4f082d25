//! Fixed joint: no relative motion. TALK B6.
//!
//! Rows: rotation lock (3), point (3). A glued pair that may break, or a weld whose reaction is wanted; two shapes
//! that never part are better one body.
//!
//! Test: `joint_rows::jacobians_are_derivatives`, `joint_rows::fixed_recovers_from_any_angle`.

use crate::constraint::frame::{Composed, FramePair, JointStep};
use crate::constraint::part::angle::Angle;
use crate::constraint::part::point::Point;
use crate::constraint::row::RowSpec;
use smallvec::SmallVec;

/// A fixed joint at one moment.
pub(crate) struct Fixed {
    angle: Angle,
    point: Point,
}

impl Fixed {
    pub const ROWS: usize = Angle::ROWS + Point::ROWS;

    pub fn new(pair: &FramePair) -> Self {
        Self { angle: Angle::new(pair), point: Point::new(pair) }
    }
}

impl Composed for Fixed {
    fn coordinates(&self) -> SmallVec<[f32; 6]> {
        SmallVec::new()
    }

    fn rows(&self, step: &JointStep, out: &mut Vec<RowSpec>) {
        self.angle.rows(step, out);
        self.point.rows(step, out);
    }

    fn anchor_error(&self) -> f32 {
        self.point.error()
    }

    fn angle_error(&self) -> f32 {
        self.angle.error()
    }
}
