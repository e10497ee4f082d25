//! Hinge: a point and an axis (x) in common; one angle remains. TALK B8, B9.
//!
//! Rows: drive of the angle, axis (2), point (3). The angle is remembered from substep to substep, so that it counts
//! on beyond ±π and a range may span several turns; it is measured from the poses each time, so it does not drift.
//! Without the two axis rows the door would sag about its one point.
//!
//! Test: `joint_rows::jacobians_are_derivatives`, `joint_rows::hinge_counts_turns`.

use crate::constraint::frame::{Composed, FramePair, JointStep};
use crate::constraint::joint::Drive;
use crate::constraint::part::axis::{Axis, twist};
use crate::constraint::part::limit_motor::{Coordinate, drive_row_count, middle, violation};
use crate::constraint::part::point::Point;
use crate::constraint::row::RowSpec;
use crate::math::Vec3;
use smallvec::SmallVec;

/// A hinge at one moment.
pub(crate) struct Hinge<'a> {
    drive: &'a Drive,
    turn: Coordinate,
    axis: Axis,
    pivot: Point,
}

impl<'a> Hinge<'a> {
    /// `last`: the last known angle; without one, the middle of the range to count turns from.
    pub fn new(pair: &FramePair, drive: &'a Drive, last: Option<f32>) -> Self {
        let reference = last.unwrap_or_else(|| middle(drive.limit.as_ref()));
        Self { drive, turn: twist(pair, Vec3::X, reference), axis: Axis::new(pair, Vec3::X), pivot: Point::new(pair) }
    }

    pub fn row_count(drive: &Drive) -> usize {
        drive_row_count(drive) + Axis::ROWS + Point::ROWS
    }
}

impl Composed for Hinge<'_> {
    fn coordinates(&self) -> SmallVec<[f32; 6]> {
        SmallVec::from_slice(&[self.turn.value])
    }

    fn rows(&self, step: &JointStep, out: &mut Vec<RowSpec>) {
        self.turn.drive_rows(self.drive, step, out);
        self.axis.rows(step, out);
        self.pivot.rows(step, out);
    }

    fn anchor_error(&self) -> f32 {
        self.pivot.error()
    }

    fn angle_error(&self) -> f32 {
        self.axis.error().max(violation(self.turn.value, self.drive.limit.as_ref()))
    }
}
