//! Hinge: a point and an axis (x) in common; one angle remains. TALK B8, B9.
//!
//! Rows: drive of the angle, axis (2), point (3). The angle is remembered from substep to substep, so that it counts
//! on beyond ±π and a range may span several turns; it is measured from the poses each time, so it does not drift.
//! Without the two axis rows the door would sag about its one point.
//!
//! Test: `joint_rows::jacobians_are_derivatives`, `joint_rows::hinge_counts_turns`.

use crate::constraint::frame::{FramePair, JointStep};
use crate::constraint::joint::Drive;
use crate::constraint::part::axis::{Axis, twist};
use crate::constraint::part::limit_motor::{Coordinate, drive_row_count, violation};
use crate::constraint::part::point::Point;
use crate::constraint::row::RowSpec;
use crate::math::Vec3;

/// A hinge at one moment.
pub(crate) struct Hinge {
    pub turn: Coordinate,
    axis: Axis,
    pivot: Point,
}

impl Hinge {
    /// `angle`: the last known one.
    pub fn new(pair: &FramePair, angle: f32) -> Self {
        Self { turn: twist(pair, Vec3::X, angle), axis: Axis::new(pair, Vec3::X), pivot: Point::new(pair) }
    }

    pub fn row_count(drive: &Drive) -> usize {
        drive_row_count(drive) + Axis::ROWS + Point::ROWS
    }

    pub fn rows(&self, drive: &Drive, step: &JointStep, out: &mut Vec<RowSpec>) {
        self.turn.drive_rows(drive, step, out);
        self.axis.rows(step, out);
        self.pivot.rows(step, out);
    }

    pub fn anchor_error(&self) -> f32 {
        self.pivot.error()
    }

    pub fn angle_error(&self, drive: &Drive) -> f32 {
        self.axis.error().max(violation(self.turn.value, drive.limit.as_ref()))
    }
}
