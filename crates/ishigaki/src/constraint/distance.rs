//! Distance joint, rope, rod, spring between two points. TALK B5, B6.
//!
//! d = |p_B − p_A| (m), ḋ = n·(ṗ_B − ṗ_A), n = (p_B − p_A)/d. Rows: spring (soft, its target a length), then each end
//! of the range that can be reached: lower > 0, upper finite; one equality (a rod) if they are equal. At d = 0 the
//! direction is A's x axis, any being as good: a rope of slack zero must not give NaN.
//!
//! Test: `joint_rows::jacobians_are_derivatives`, `joint_rows::distance_is_finite_at_zero`.

use crate::constraint::frame::{Composed, FramePair, JointStep};
use crate::constraint::joint::{Range, Spring};
use crate::constraint::part::limit_motor::{Coordinate, limit_row_count, violation};
use crate::constraint::row::{Jacobian, RowSpec};
use crate::math::Vec3;
use smallvec::SmallVec;

/// A distance joint at one moment.
pub(crate) struct Distance<'a> {
    range: &'a Range,
    spring: Option<&'a Spring>,
    length: Coordinate,
}

impl<'a> Distance<'a> {
    pub fn new(pair: &FramePair, range: &'a Range, spring: Option<&'a Spring>) -> Self {
        let distance = pair.offset.length();
        let n = if distance > 1e-9 { pair.offset / distance } else { pair.frame_a * Vec3::X };
        let jacobian = Jacobian::point(n, pair.arm_a, pair.arm_b).negated();
        Self { range, spring, length: Coordinate::new(distance, jacobian, pair) }
    }

    pub fn row_count(range: &Range, spring: Option<&Spring>) -> usize {
        usize::from(spring.is_some()) + limit_row_count(&reachable(range))
    }
}

impl Composed for Distance<'_> {
    fn coordinates(&self) -> SmallVec<[f32; 6]> {
        SmallVec::from_slice(&[self.length.value])
    }

    fn rows(&self, step: &JointStep, out: &mut Vec<RowSpec>) {
        if let Some(spring) = self.spring {
            out.push(self.length.passive_row(spring, 0.0, step));
        }
        self.length.limit_rows(&reachable(self.range), step, out);
    }

    fn anchor_error(&self) -> f32 {
        violation(self.length.value, Some(self.range))
    }

    fn angle_error(&self) -> f32 {
        0.0
    }
}

/// The range without a lower end that no distance can fall below.
fn reachable(range: &Range) -> Range {
    let lower = if range.lower > 0.0 || range.lower == range.upper { range.lower } else { f32::NEG_INFINITY };
    Range { lower, upper: range.upper }
}
