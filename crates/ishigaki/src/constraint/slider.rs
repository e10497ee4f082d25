//! Slider: B moves along A's x axis and does not turn. TALK B6, B9.
//!
//! Rows: drive of the displacement, rotation lock (3), anchor of B on A's axis (2). The two perpendicular rows lie
//! along A's y and z with the arm of A reaching to B's anchor (see `part/point.rs`): at full stroke the bearing force
//! still acts on one line.
//!
//! Test: `joint_rows::jacobians_are_derivatives`, `joint_rows::rows_conserve_momentum`.

use crate::constraint::frame::{Composed, FramePair, JointStep};
use crate::constraint::joint::Drive;
use crate::constraint::part::angle::Angle;
use crate::constraint::part::limit_motor::{Coordinate, drive_row_count};
use crate::constraint::part::point::displacement;
use crate::constraint::row::RowSpec;
use crate::math::Vec3;
use smallvec::SmallVec;

/// A slider at one moment.
pub(crate) struct Slider<'a> {
    drive: &'a Drive,
    slide: Coordinate,
    across: [Coordinate; 2],
    angle: Angle,
}

impl<'a> Slider<'a> {
    pub fn new(pair: &FramePair, drive: &'a Drive) -> Self {
        let [slide, y, z] = Vec3::AXES.map(|axis| displacement(pair, pair.frame_a * axis));
        Self { drive, slide, across: [y, z], angle: Angle::new(pair) }
    }

    pub fn row_count(drive: &Drive) -> usize {
        drive_row_count(drive) + Angle::ROWS + 2
    }
}

impl Composed for Slider<'_> {
    fn coordinates(&self) -> SmallVec<[f32; 6]> {
        SmallVec::from_slice(&[self.slide.value])
    }

    fn rows(&self, step: &JointStep, out: &mut Vec<RowSpec>) {
        self.slide.drive_rows(self.drive, step, out);
        self.angle.rows(step, out);
        out.extend(self.across.map(|across| across.lock_row(0.0, step)));
    }

    fn anchor_error(&self) -> f32 {
        let [y, z] = self.across;
        (y.value * y.value + z.value * z.value).sqrt()
    }

    fn angle_error(&self) -> f32 {
        self.angle.error()
    }
}
