//! Constraints as rows; joints composed of parts.

pub mod joint;
pub mod row;
