//! The parts joints are composed of: each knows one geometric condition, its J and its error.

pub mod angle;
pub mod axis;
pub mod limit_motor;
pub mod point;
pub mod turns;
