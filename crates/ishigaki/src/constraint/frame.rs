//! Where the two bodies of a joint are, and where the joint's frame is on each.

use crate::constraint::row::{Jacobian, RowSpec};
use crate::math::{Quat, Vec3};
use smallvec::SmallVec;

/// Pose and velocity of a body at one moment, of its center of mass, in world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyFrame {
    /// Center of mass, m.
    pub center: Vec3,
    /// `world_from_body`; the axes of the body, not of its inertia.
    pub rotation: Quat,
    /// Of the center of mass, m/s.
    pub velocity: Vec3,
    /// rad/s.
    pub angular_velocity: Vec3,
    /// Angular acceleration of free turning, −I⁻¹(ω×L), rad/s². TALK A5.
    pub gyration: Vec3,
}

impl BodyFrame {
    /// A body that does not move.
    pub fn at_rest(center: Vec3, rotation: Quat) -> Self {
        Self { center, rotation, velocity: Vec3::ZERO, angular_velocity: Vec3::ZERO, gyration: Vec3::ZERO }
    }
}

/// What every joint asks of one substep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointStep {
    /// Length of the substep, s.
    pub h: f32,
    /// Part of an error taken back in this substep, in [0, 1]; 0 switches recovery off. TALK B9.
    pub recovery_rate: f32,
}

impl JointStep {
    /// The bias that takes back the error `c` (m or rad): β c / h.
    pub fn recovery(&self, c: f32) -> f32 {
        self.recovery_rate * c / self.h
    }
}

/// The joint's frame on both bodies at one moment, in world.
#[derive(Clone, Copy, Debug)]
pub struct FramePair {
    /// First body.
    pub a: BodyFrame,
    /// Second body.
    pub b: BodyFrame,
    /// From A's center of mass to the anchor on A, m.
    pub arm_a: Vec3,
    /// From B's center of mass to the anchor on B, m.
    pub arm_b: Vec3,
    /// Anchor on B minus anchor on A, m.
    pub offset: Vec3,
    /// `world_from_frame` on A.
    pub frame_a: Quat,
    /// `world_from_frame` on B.
    pub frame_b: Quat,
}

impl FramePair {
    /// Rotation of B's frame seen from A's frame.
    pub fn relative(&self) -> Quat {
        self.frame_a.conjugate() * self.frame_b
    }

    /// From A's center of mass to the anchor on **B**, m: the arm of everything measured along axes of A.
    pub fn arm_a_to_b(&self) -> Vec3 {
        self.arm_a + self.offset
    }

    /// J u at the velocities of the two bodies.
    pub fn rate(&self, jacobian: &Jacobian) -> f32 {
        jacobian.linear.dot(self.a.velocity - self.b.velocity)
            + jacobian.angular_a.dot(self.a.angular_velocity)
            + jacobian.angular_b.dot(self.b.angular_velocity)
    }
}

/// A joint at one moment: its parts, measured at a [`FramePair`].
pub(crate) trait Composed {
    /// The free coordinates that the joint reports, rad or m.
    fn coordinates(&self) -> SmallVec<[f32; 6]>;
    /// Appends its rows: always as many, in the same order.
    fn rows(&self, step: &JointStep, out: &mut Vec<RowSpec>);
    /// How far anchors are from where they must be, m.
    fn anchor_error(&self) -> f32;
    /// How far rotations are from where they must be, rad; the worst one.
    fn angle_error(&self) -> f32;
}
