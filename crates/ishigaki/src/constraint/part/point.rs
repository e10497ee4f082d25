//! A point in common, or a point on a line or plane. TALK B5, B7.
//!
//! With p the anchors in world, C = p_A − p_B = 0 (3 rows, m). Along a fixed world axis e,
//! Ċ = e·(v_A + ω_A×r_A − v_B − ω_B×r_B): [`Jacobian::point`]. The three rows lie along the *world* axes: the three λ
//! are then one force in world, and what a joint carries is mostly weight, whose direction does not turn with the
//! bodies; so last substep's λ is the best first guess (D4).
//!
//! Along an axis e fixed to A, s = e·(p_B − p_A) also changes because e turns:
//! ṡ = e·(v_B + ω_B×r_B − v_A − ω_A×(r_A + p_B − p_A)). The arm of A reaches to the anchor of **B**. With A's own
//! anchor as arm a long slider would gain angular momentum out of nothing, for the two forces would not be on one
//! line.
//!
//! Test: `joint_rows::jacobians_are_derivatives`, `joint_rows::rows_conserve_momentum`.

use crate::constraint::frame::{BodyFrame, FramePair, JointStep};
use crate::constraint::part::limit_motor::Coordinate;
use crate::constraint::row::{Jacobian, RowSpec};
use crate::math::Vec3;

/// The two anchors coincide: 3 rows.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    arm_a: Vec3,
    arm_b: Vec3,
    gap: Vec3,
    /// What the turning of the arms adds to the acceleration of the gap, m/s².
    turning: Vec3,
}

impl Point {
    /// Rows it takes.
    pub const ROWS: usize = 3;

    /// At this moment.
    pub fn new(pair: &FramePair) -> Self {
        let turning = turning(&pair.a, pair.arm_a) - turning(&pair.b, pair.arm_b);
        Self { arm_a: pair.arm_a, arm_b: pair.arm_b, gap: -pair.offset, turning }
    }

    /// Distance of the anchors, m.
    pub fn error(&self) -> f32 {
        self.gap.length()
    }

    // ANCHOR: rows
    /// Three rows along world x, y, z.
    pub fn rows(&self, step: &JointStep, out: &mut Vec<RowSpec>) {
        for axis in Vec3::AXES {
            let jacobian = Jacobian::point(axis, self.arm_a, self.arm_b);
            // Bodies move along straight lines in a substep and arms along arcs: C(h) = C + hJu + ½h²·turning.
            let arc = 0.5 * step.h * self.turning.dot(axis);
            out.push(RowSpec::equality(jacobian, step.recovery(self.gap.dot(axis))).along(arc));
        }
    }
    // ANCHOR_END: rows
}

/// Acceleration of the end of an arm by the free turning of its body: ω×(ω×r) + ω̇×r, m/s².
fn turning(body: &BodyFrame, arm: Vec3) -> Vec3 {
    body.angular_velocity.cross(body.angular_velocity.cross(arm)) + body.gyration.cross(arm)
}

/// The displacement of B's anchor from A's along a world `axis` that turns with A; B relative to A, m.
pub fn displacement(pair: &FramePair, axis: Vec3) -> Coordinate {
    let jacobian = Jacobian::point(axis, pair.arm_a_to_b(), pair.arm_b).negated();
    Coordinate::new(axis.dot(pair.offset), jacobian, pair)
}
