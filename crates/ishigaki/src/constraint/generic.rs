//! Generic joint: any of six coordinates. TALK B6–B9.
//!
//! Displacements along A's x, y, z, then up to three turns in sequence (`part/turns.rs`); what is not free is locked at
//! zero. Rows: drives of the free coordinates (linear first), locked rotations, locked displacements. Three locked
//! displacements are a point in common and use its world axes; otherwise they lie along A's axes.
//! k hinges between the same two bodies, as robot descriptions have them, are one generic joint, with no bodies without
//! mass in between.
//!
//! Test: `joint_rows::jacobians_are_derivatives`, `joint_rows::coordinates_are_recovered`.

use crate::constraint::frame::{Composed, FramePair, JointStep};
use crate::constraint::joint::{Drive, Freedom, TurnAxis};
use crate::constraint::part::limit_motor::{Coordinate, drive_row_count, middle, violation};
use crate::constraint::part::point::{Point, displacement};
use crate::constraint::part::turns::{Turns, first_angles};
use crate::constraint::row::RowSpec;
use crate::math::Vec3;
use arrayvec::ArrayVec;
use smallvec::SmallVec;

/// What a generic joint's definition says.
#[derive(Clone, Copy)]
pub(crate) struct Freedoms<'a> {
    pub linear: &'a [Freedom; 3],
    pub angular: &'a [TurnAxis],
}

/// A generic joint at one moment.
pub(crate) struct Generic<'a> {
    freedoms: Freedoms<'a>,
    slides: [Coordinate; 3],
    turns: Turns,
    point: Point,
}

impl<'a> Freedoms<'a> {
    /// Free coordinates: linear first.
    fn coordinate_count(self) -> usize {
        self.slides().count() + self.angular.len().min(3)
    }

    pub fn row_count(self) -> usize {
        let drives = self.slides().map(|(_, drive)| drive).chain(self.angular.iter().map(|turn| &turn.drive));
        let locked = 3 - self.slides().count();
        drives.map(drive_row_count).sum::<usize>() + Turns::lock_row_count(self.angular.len()) + locked
    }

    /// The free displacements: axis and drive.
    fn slides(self) -> impl Iterator<Item = (usize, &'a Drive)> {
        self.linear.iter().enumerate().filter_map(|(i, freedom)| match freedom {
            Freedom::Locked => None,
            Freedom::Free(drive) => Some((i, drive)),
        })
    }

    fn axes(self) -> ArrayVec<Vec3, 3> {
        self.angular.iter().take(3).map(|turn| turn.axis.normalize_or(Vec3::X)).collect()
    }

    /// Angles to start from.
    fn first_angles(self, pair: &FramePair) -> ArrayVec<f32, 3> {
        let middles: ArrayVec<f32, 3> =
            self.angular.iter().take(3).map(|turn| middle(turn.drive.limit.as_ref())).collect();
        first_angles(pair, &self.axes(), &middles)
    }
}

impl<'a> Generic<'a> {
    /// `last`: the last known coordinates; if they are not of these freedoms (a new joint, an edited one) the angles
    /// are searched for.
    pub fn new(pair: &FramePair, freedoms: Freedoms<'a>, last: &[f32]) -> Self {
        let axes = freedoms.axes();
        let turns = if last.len() == freedoms.coordinate_count() {
            Turns::new(pair, &axes, &last[last.len() - axes.len()..])
        } else {
            Turns::new(pair, &axes, &freedoms.first_angles(pair))
        };
        let slides = Vec3::AXES.map(|axis| displacement(pair, pair.frame_a * axis));
        Self { freedoms, slides, turns, point: Point::new(pair) }
    }

    fn locked(&self) -> impl Iterator<Item = &Coordinate> {
        self.slides.iter().zip(self.freedoms.linear).filter(|(_, freedom)| **freedom == Freedom::Locked).map(|(s, _)| s)
    }
}

impl Composed for Generic<'_> {
    fn coordinates(&self) -> SmallVec<[f32; 6]> {
        let slides = self.freedoms.slides().map(|(i, _)| self.slides[i].value);
        slides.chain(self.turns.angles.iter().map(|angle| angle.value)).collect()
    }

    fn rows(&self, step: &JointStep, out: &mut Vec<RowSpec>) {
        for (i, drive) in self.freedoms.slides() {
            self.slides[i].drive_rows(drive, step, out);
        }
        for (angle, turn) in self.turns.angles.iter().zip(self.freedoms.angular) {
            angle.drive_rows(&turn.drive, step, out);
        }
        self.turns.lock_rows(step, out);
        if self.freedoms.slides().next().is_none() {
            self.point.rows(step, out);
        } else {
            out.extend(self.locked().map(|slide| slide.lock_row(0.0, step)));
        }
    }

    fn anchor_error(&self) -> f32 {
        self.locked().map(|slide| slide.value * slide.value).sum::<f32>().sqrt()
    }

    fn angle_error(&self) -> f32 {
        let ranges = self.turns.angles.iter().zip(self.freedoms.angular);
        ranges.map(|(angle, turn)| violation(angle.value, turn.drive.limit.as_ref())).fold(self.turns.error(), f32::max)
    }
}
