//! What happened in a step.

use crate::body::ShapeId;
use crate::handle::JointHandle;
use serde::{Deserialize, Serialize};

/// What happened in a step; in the order of pairs and joints.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Event {
    /// Two shapes began to touch.
    ContactBegan {
        /// First shape.
        a: ShapeId,
        /// Second shape.
        b: ShapeId,
    },
    /// Two shapes no longer touch.
    ContactEnded {
        /// First shape.
        a: ShapeId,
        /// Second shape.
        b: ShapeId,
    },
    /// A shape began to overlap a sensor.
    SensorEntered {
        /// The sensor.
        sensor: ShapeId,
        /// The shape.
        other: ShapeId,
    },
    /// A shape no longer overlaps a sensor.
    SensorLeft {
        /// The sensor.
        sensor: ShapeId,
        /// The shape.
        other: ShapeId,
    },
    /// A contact carried more than its threshold ([`World::set_force_threshold`](crate::World::set_force_threshold)).
    ContactForce {
        /// First shape.
        a: ShapeId,
        /// Second shape.
        b: ShapeId,
        /// Mean normal force over the step, N.
        force: f32,
    },
    /// A joint carried more than it can and was removed.
    JointBroke {
        /// The joint; its handle is stale now.
        joint: JointHandle,
        /// N.
        force: f32,
        /// N·m.
        torque: f32,
    },
}
