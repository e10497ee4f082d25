//! A joint in a world: where its frame sits on each body, its coordinates, and its rows for a substep. TALK B5–B12.
//!
//! Plain values in, [`RowSpec`]s out: no world, no masses, no impulses. Called once per substep for every awake joint,
//! with the poses and velocities at the start of the substep, before forces: J is exact there, and the rate an armature
//! remembers is the one it really had.

use crate::constraint::ball::{Ball, BallLimits};
use crate::constraint::distance::Distance;
use crate::constraint::fixed::Fixed;
use crate::constraint::frame::Composed;
pub use crate::constraint::frame::{BodyFrame, FramePair, JointStep};
use crate::constraint::generic::{Freedoms, Generic};
use crate::constraint::hinge::Hinge;
use crate::constraint::joint::{Joint, JointFrames, JointKind};
use crate::constraint::row::{Jacobian, RowSpec};
use crate::constraint::slider::Slider;
use crate::math::{Quat, Vec3};
use serde::{Deserialize, Serialize};
use smallvec::SmallVec;

/// A joint's frame relative to each body's center of mass, and its coordinates.
///
/// Its own state are the angles, which count on beyond ±π; all else follows from the poses.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResolvedJoint {
    /// Anchor on A, from its center of mass, in A's axes, m.
    pub anchor_a: Vec3,
    /// `body_from_frame` on A.
    pub frame_a: Quat,
    /// Anchor on B, from its center of mass, in B's axes, m.
    pub anchor_b: Vec3,
    /// `body_from_frame` on B.
    pub frame_b: Quat,
    coordinates: SmallVec<[f32; 6]>,
}

impl ResolvedJoint {
    /// Places a joint on two bodies. `local_center_*`: center of mass from the body's origin, in the body's axes, m.
    pub fn new(joint: &Joint, a: &BodyFrame, local_center_a: Vec3, b: &BodyFrame, local_center_b: Vec3) -> Self {
        let in_body = |body: &BodyFrame, point: Vec3| body.rotation.conjugate() * (point - body.center);
        let (anchor_a, frame_a, anchor_b, frame_b) = match joint.frames {
            JointFrames::World(frame) => (
                in_body(a, frame.translation),
                a.rotation.conjugate() * frame.rotation,
                in_body(b, frame.translation),
                b.rotation.conjugate() * frame.rotation,
            ),
            JointFrames::Local { a, b } => {
                (a.translation - local_center_a, a.rotation, b.translation - local_center_b, b.rotation)
            }
        };
        let mut resolved = Self {
            anchor_a,
            frame_a: frame_a.normalize(),
            anchor_b,
            frame_b: frame_b.normalize(),
            coordinates: SmallVec::new(),
        };
        resolved.refresh(&joint.kind, a, b);
        resolved
    }

    /// Angle (hinge, rad), displacement (slider, m), distance (m), or the generic joint's free coordinates, linear
    /// first; empty for ball and fixed joints. As of the last call of [`Self::rows`] or [`Self::refresh`].
    pub fn coordinates(&self) -> &[f32] {
        &self.coordinates
    }

    /// From A's center of mass to the anchor on A, world, m.
    pub fn arm_a(&self, a: &BodyFrame) -> Vec3 {
        a.rotation * self.anchor_a
    }

    /// From B's center of mass to the anchor on B, world, m.
    pub fn arm_b(&self, b: &BodyFrame) -> Vec3 {
        b.rotation * self.anchor_b
    }

    /// The joint's frame on both bodies.
    pub fn pair(&self, a: &BodyFrame, b: &BodyFrame) -> FramePair {
        let (arm_a, arm_b) = (self.arm_a(a), self.arm_b(b));
        FramePair {
            a: *a,
            b: *b,
            arm_a,
            arm_b,
            // Centers first: far from the origin their difference is exact, the sums would not be.
            offset: (b.center - a.center) + (arm_b - arm_a),
            frame_a: a.rotation * self.frame_a,
            frame_b: b.rotation * self.frame_b,
        }
    }

    /// Rows that [`Self::rows`] appends: constant until the definition gains or loses a drive, an end of a range, an
    /// axis.
    pub fn row_count(&self, kind: &JointKind) -> usize {
        match kind {
            JointKind::Ball { cone, twist, friction, damping } => {
                BallLimits { cone: *cone, twist: twist.as_ref(), friction: *friction, damping: *damping }.row_count()
            }
            JointKind::Hinge { drive } => Hinge::row_count(drive),
            JointKind::Slider { drive } => Slider::row_count(drive),
            JointKind::Fixed => Fixed::ROWS,
            JointKind::Distance { range, spring } => Distance::row_count(range, spring.as_ref()),
            JointKind::Generic { linear, angular } => Freedoms { linear, angular }.row_count(),
        }
    }

    /// Appends the rows of one substep, always as many and in the same order, and refreshes the coordinates.
    /// `a`, `b`: at the start of the substep, before forces.
    pub fn rows(&mut self, kind: &JointKind, a: &BodyFrame, b: &BodyFrame, step: &JointStep, out: &mut Vec<RowSpec>) {
        let before = out.len();
        self.coordinates = self.measure(kind, a, b, |joint| {
            joint.rows(step, out);
            joint.coordinates()
        });
        debug_assert_eq!(out.len() - before, self.row_count(kind), "rows and row_count of {kind:?} disagree");
    }

    /// Brings the coordinates to the poses of `a` and `b`; call it at the end of a step.
    pub fn refresh(&mut self, kind: &JointKind, a: &BodyFrame, b: &BodyFrame) {
        self.coordinates = self.measure(kind, a, b, |joint| joint.coordinates());
    }

    /// Distance of the anchors where they must coincide, m: for a slider across its axis, for a generic joint along
    /// its locked displacements, for a distance joint how far it is out of its range.
    pub fn anchor_error(&self, kind: &JointKind, a: &BodyFrame, b: &BodyFrame) -> f32 {
        self.measure(kind, a, b, |joint| joint.anchor_error())
    }

    /// How far locked rotations, or angles out of their ranges, are off, rad; the worst of them.
    pub fn angle_error(&self, kind: &JointKind, a: &BodyFrame, b: &BodyFrame) -> f32 {
        self.measure(kind, a, b, |joint| joint.angle_error())
    }

    /// Composes the joint at the poses of `a` and `b` and asks it something.
    fn measure<T>(&self, kind: &JointKind, a: &BodyFrame, b: &BodyFrame, ask: impl FnOnce(&dyn Composed) -> T) -> T {
        let pair = self.pair(a, b);
        match kind {
            JointKind::Ball { cone, twist, friction, damping } => {
                let limits = BallLimits { cone: *cone, twist: twist.as_ref(), friction: *friction, damping: *damping };
                ask(&Ball::new(&pair, limits))
            }
            JointKind::Hinge { drive } => ask(&Hinge::new(&pair, drive, self.coordinates.first().copied())),
            JointKind::Slider { drive } => ask(&Slider::new(&pair, drive)),
            JointKind::Fixed => ask(&Fixed::new(&pair)),
            JointKind::Distance { range, spring } => ask(&Distance::new(&pair, range, spring.as_ref())),
            JointKind::Generic { linear, angular } => {
                ask(&Generic::new(&pair, Freedoms { linear, angular }, &self.coordinates))
            }
        }
    }
}

/// Impulse on A, N·s, and angular impulse on A about the point at `arm_a` from its center of mass, N·m·s (world), that
/// rows with these Jacobians and impulses make. Divide by the time they acted for N and N·m.
///
/// A force through the point gives no torque.
pub fn reaction(rows: impl Iterator<Item = (Jacobian, f32)>, arm_a: Vec3) -> (Vec3, Vec3) {
    let mut impulse = Vec3::ZERO;
    let mut angular_impulse = Vec3::ZERO;
    for (jacobian, lambda) in rows {
        impulse += jacobian.linear * lambda;
        angular_impulse += (jacobian.angular_a - arm_a.cross(jacobian.linear)) * lambda;
    }
    (impulse, angular_impulse)
}
