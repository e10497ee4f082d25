//! Constraints as rows; joints composed of parts. TALK B5–B12.
//!
//! # How a joint is composed
//!
//! Whatever a joint is, the solver sees rows: w = J u + γλ + bias, λ ∈ \[lower, upper\] ([`row::RowSpec`]). On the way
//! there every file knows one thing:
//!
//! 1. [`joint::Joint`]: what the user wrote. [`joint_rows::ResolvedJoint`]: the same, placed on two bodies, and the
//!    angles it has counted.
//! 2. [`frame::FramePair`]: the joint's frame on A and on B in world, at this moment. All that a part may look at.
//! 3. Parts, each one geometric condition with its C and its exact derivative J:
//!    [`Point`](part::point::Point) (3 rows), [`Axis`](part::axis::Axis) (2), [`Angle`](part::angle::Angle) (3),
//!    [`Turns`](part::turns::Turns) (3 − k), and [`Coordinate`](part::limit_motor::Coordinate): what remains free,
//!    and may have a range, a motor, dry friction, a spring.
//! 4. Joints put parts together: hinge = Point + Axis + one angle; slider = Angle + two displacements held + one free;
//!    fixed = Angle + Point; ball = Point + swing and twist; distance = one length; generic = Turns + three
//!    displacements.
//!
//! Rules that all parts keep:
//! * Locked rows are of A relative to B, as contacts are; coordinates of B relative to A, right-handed.
//! * Recovery bias is βC/h; relax sweeps leave it out. A coordinate inside its range keeps its rows, with the
//!   speculative bias C/h.
//! * Drives come first, locks last: the row visited last is kept best.
//! * The number and order of rows depend on the definition alone, so that λ finds its row again (D4).
//! * J is finite and not zero at every pose, poles included; a row that has lost its meaning has lower = upper = 0.
//! * Forces and torques on A and B are opposite, and the forces on one line where the anchors meet: momentum is
//!   conserved by construction (B10).
//!
//! ```
//! use ishigaki::constraint::joint_rows::{BodyFrame, JointStep, ResolvedJoint, reaction};
//! use ishigaki::{BodyHandle, Joint, Quat, Vec3};
//!
//! // A door 1 m wide, hung on a post at the origin, half a radian open.
//! let (post, door) = (BodyHandle::from((0, 0)), BodyHandle::from((1, 0)));
//! let hinge = Joint::hinge(post, door, Vec3::ZERO, Vec3::Y).limit(0.0..=1.5);
//! let at_post = BodyFrame::at_rest(Vec3::ZERO, Quat::IDENTITY);
//! let closed = BodyFrame::at_rest(0.5 * Vec3::X, Quat::IDENTITY);
//! let mut resolved = ResolvedJoint::new(&hinge, &at_post, Vec3::ZERO, &closed, Vec3::ZERO);
//!
//! let turn = Quat::from_rotation_y(0.5);
//! let open = BodyFrame::at_rest(turn * (0.5 * Vec3::X), turn);
//! let mut rows = Vec::new();
//! resolved.rows(&hinge.kind, &at_post, &open, &JointStep { h: 1.0 / 240.0, recovery_rate: 0.3 }, &mut rows);
//! assert_eq!(rows.len(), 2 + 2 + 3); // both ends of the range, the axis, the point
//! assert!((resolved.coordinates()[0] - 0.5).abs() < 1e-6);
//! // 2 N·s upward on A through the pivot: no torque about it. λ are in the order of the rows.
//! let lambdas = rows.iter().map(|row| row.jacobian).zip([0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0]);
//! let (impulse, angular) = reaction(lambdas, resolved.arm_a(&at_post));
//! assert_eq!((impulse, angular), (2.0 * Vec3::Y, Vec3::ZERO));
//! ```

pub(crate) mod ball;
pub mod contact;
pub(crate) mod distance;
pub(crate) mod fixed;
pub mod frame;
pub mod friction;
pub(crate) mod generic;
pub(crate) mod hinge;
pub mod joint;
pub mod joint_rows;
pub mod part;
pub mod row;
pub(crate) mod slider;
