//! What a pair of shapes remembers from step to step: the axis of its contact, what a search found out about all others, and
//! whether aggressive sleep keeps its rows.
//!
//! No separation along any direction changes by more than B's farthest point moves in the frame of A. So a pair knows
//! without a search that its shapes are still apart, and often that the axis of its contact must be chosen again.
//! Test: `hull_hull.rs`, against searches in every step.

use crate::math::{Pose, Quat, Vec3};
use serde::{Deserialize, Serialize};

/// What the narrow phase remembers of a pair; the default knows nothing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PairMemory {
    /// The axis of the last step in a form of its own, 0 without one; whatever stands here, nothing panics.
    pub axis: u32,
    /// Where B was in the frame of A when it was searched for axes, or frozen.
    b_in_a: PackedPose,
    /// What the search found, m: the gap, or the bounds.
    found: AxisBounds,
    lesson: Lesson,
    /// Aggressive sleep keeps the rows that it had at `b_in_a`.
    pub(crate) frozen: bool,
    /// Its bounds came apart, and the pair only makes room: `room.rs`.
    #[serde(skip)]
    pub(crate) gone: bool,
}

/// A pose in 28 bytes, not 32: there are many pairs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct PackedPose {
    translation: Vec3,
    rotation: Quat,
}

impl From<&Pose> for PackedPose {
    fn from(pose: &Pose) -> Self {
        Self { translation: pose.translation, rotation: pose.rotation }
    }
}

/// What no separation exceeds, m.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct AxisBounds {
    /// Along any direction.
    pub best: f32,
    /// Along normals of faces.
    pub faces: f32,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
enum Lesson {
    #[default]
    Nothing,
    /// There is a gap `found.best` along some direction.
    Apart,
    /// `axis` was chosen.
    Chosen,
}

impl Default for PairMemory {
    fn default() -> Self {
        let found = AxisBounds::default();
        Self { axis: 0, b_in_a: (&Pose::IDENTITY).into(), found, lesson: Lesson::Nothing, frozen: false, gone: false }
    }
}

impl PairMemory {
    /// What is sure with B here, whose points are no farther than `radius` (m) from its origin.
    pub(crate) fn recall(&self, b_in_a: &Pose, radius: f32) -> Known {
        let AxisBounds { best, faces } = self.found;
        match self.lesson {
            Lesson::Nothing => Known::Nothing,
            Lesson::Apart => Known::Apart(best - greatest_motion(&self.b_in_a, b_in_a, radius)),
            Lesson::Chosen => {
                let moved = greatest_motion(&self.b_in_a, b_in_a, radius);
                Known::Axis(AxisBounds { best: best + moved, faces: faces + moved }, moved)
            }
        }
    }

    /// The shapes have this gap along some axis, m.
    pub(crate) fn learn_gap(&mut self, b_in_a: &Pose, gap: f32) {
        self.b_in_a = b_in_a.into();
        self.found = AxisBounds { best: gap, faces: 0.0 };
        self.lesson = Lesson::Apart;
    }

    /// `axis` was chosen, where this is what others reach.
    pub(crate) fn learn_axis(&mut self, b_in_a: &Pose, others: AxisBounds) {
        (self.b_in_a, self.found, self.lesson) = (b_in_a.into(), others, Lesson::Chosen);
    }

    /// All but the axis.
    pub(crate) fn forget(&mut self) {
        self.lesson = Lesson::Nothing;
    }

    /// Rows are kept as they are with B here; what a search found is lost.
    pub(crate) fn freeze(&mut self, b_in_a: &Pose) {
        (self.b_in_a, self.lesson, self.frozen) = (b_in_a.into(), Lesson::Nothing, true);
    }

    /// How far B has come since rows were frozen: way (m) and the sine of half its turn.
    pub(crate) fn motion_since_frozen(&self, b_in_a: &Pose) -> (f32, f32) {
        let (shift, turn) = motion(&self.b_in_a, b_in_a);
        (shift.length(), turn.length())
    }
}

/// What a search would find.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Known {
    Nothing,
    /// A gap along some axis at least this wide, m.
    Apart(f32),
    /// What no separation exceeds, and how far B has moved at most since the axis of the last step was chosen, m.
    Axis(AxisBounds, f32),
}

impl Known {
    pub fn is_gap_beyond(self, margin: f32) -> bool {
        matches!(self, Self::Apart(gap) if gap > margin)
    }
}

/// How far points within `radius` (m) of the origin move at most from one pose to another, m.
fn greatest_motion(from: &PackedPose, to: &Pose, radius: f32) -> f32 {
    let (shift, turn) = motion(from, to);
    // A turn by θ moves a point at the distance r from its axis by 2 r sin θ/2.
    shift.length() + 2.0 * radius * turn.length()
}

/// Way, and axis of the turn times the sine of half its angle.
fn motion(from: &PackedPose, to: &Pose) -> (Vec3, Vec3) {
    let turn: Quat = from.rotation.inverse() * to.rotation;
    (to.translation - from.translation, turn.xyz())
}
