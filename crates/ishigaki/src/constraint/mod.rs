//! Constraints as rows; joints composed of parts.

pub(crate) mod ball;
pub(crate) mod distance;
pub(crate) mod fixed;
pub mod frame;
pub(crate) mod generic;
pub(crate) mod hinge;
pub mod joint;
pub mod joint_rows;
pub mod part;
pub mod row;
pub(crate) mod slider;
