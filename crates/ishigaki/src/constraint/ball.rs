//! Ball joint: a point in common; cone and twist range keep the neck from turning backwards. TALK B7, B9.
//!
//! Rows: friction (3), damping (3), twist range, cone, point (3). The cone bounds the angle σ ∈ [0, π] between the
//! frames' x axes, σ̇ = n·(ω_B − ω_A), n = x_A×x_B/sin σ; a cone of 0 is an axis in common. The twist about x is that
//! of R_rel = swing·twist; its recovery fades where B's axis is opposite to A's and twist has no meaning. Friction
//! and damping act along the world axes, λ being a torque in world; friction is bounded for each axis by itself, by
//! up to √3 too much along diagonals. Without the ranges a ragdoll folds through itself.
//!
//! Test: `joint_rows::jacobians_are_derivatives`, `joint_rows::ball_is_finite_at_poles`.

use crate::constraint::frame::{Composed, FramePair, JointStep};
use crate::constraint::joint::{Range, Spring};
use crate::constraint::part::axis::{Axis, swing, twist, twist_trust};
use crate::constraint::part::limit_motor::{Coordinate, limit_row_count, middle, violation};
use crate::constraint::part::point::Point;
use crate::constraint::row::{Jacobian, RowSpec};
use crate::math::Vec3;
use smallvec::SmallVec;

/// What a ball joint's definition says.
#[derive(Clone, Copy)]
pub(crate) struct BallLimits<'a> {
    pub cone: Option<f32>,
    pub twist: Option<&'a Range>,
    pub friction: f32,
    pub damping: f32,
}

impl BallLimits<'_> {
    pub fn row_count(self) -> usize {
        let cone = self.cone.map_or(0, |cone| if cone > 0.0 { 1 } else { Axis::ROWS });
        let twist = self.twist.map_or(0, limit_row_count);
        3 * usize::from(self.friction > 0.0) + 3 * usize::from(self.damping > 0.0) + twist + cone + Point::ROWS
    }
}

/// A ball joint at one moment.
pub(crate) struct Ball<'a> {
    limits: BallLimits<'a>,
    pair: &'a FramePair,
    /// Measured only where there is a range for it.
    swing: Option<Coordinate>,
    twist: Option<Coordinate>,
    point: Point,
}

impl<'a> Ball<'a> {
    pub fn new(pair: &'a FramePair, limits: BallLimits<'a>) -> Self {
        Self {
            limits,
            pair,
            swing: limits.cone.map(|_| swing(pair, Vec3::X)),
            twist: limits.twist.map(|range| twist(pair, Vec3::X, middle(Some(range)))),
            point: Point::new(pair),
        }
    }

    fn about(&self, axis: Vec3) -> Coordinate {
        Coordinate::new(0.0, Jacobian::rotation(axis).negated(), self.pair)
    }
}

impl Composed for Ball<'_> {
    fn coordinates(&self) -> SmallVec<[f32; 6]> {
        SmallVec::new()
    }

    fn rows(&self, step: &JointStep, out: &mut Vec<RowSpec>) {
        let BallLimits { cone, twist, friction, damping } = self.limits;
        if friction > 0.0 {
            out.extend(Vec3::AXES.map(|axis| self.about(axis).friction_row(friction, step)));
        }
        if damping > 0.0 {
            let spring = Spring { target: 0.0, stiffness: 0.0, damping };
            out.extend(Vec3::AXES.map(|axis| self.about(axis).passive_row(&spring, 0.0, step)));
        }
        if let (Some(range), Some(coordinate)) = (twist, &self.twist) {
            let faded = JointStep { recovery_rate: step.recovery_rate * twist_trust(self.pair, Vec3::X), ..*step };
            coordinate.limit_rows(range, &faded, out);
        }
        match (cone, &self.swing) {
            (Some(cone), Some(swing)) if cone > 0.0 => {
                swing.limit_rows(&Range { lower: f32::NEG_INFINITY, upper: cone }, step, out);
            }
            (Some(_), _) => Axis::new(self.pair, Vec3::X).rows(step, out),
            (None, _) => {}
        }
        self.point.rows(step, out);
    }

    fn anchor_error(&self) -> f32 {
        self.point.error()
    }

    fn angle_error(&self) -> f32 {
        let cone = self.limits.cone.zip(self.swing.as_ref()).map_or(0.0, |(cone, swing)| (swing.value - cone).max(0.0));
        cone.max(self.twist.as_ref().map_or(0.0, |twist| violation(twist.value, self.limits.twist)))
    }
}
