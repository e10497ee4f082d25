//! # Ishigaki: a rigid-body physics engine that holds
//!
//! Reading order: [`world`](crate::World) owns all state; `step.rs` runs the ten stages; each folder is one of their rooms.
//!
//! Conventions: SI units; right-handed, Y up by default; `world_from_local` names a transform; a contact normal is
//! B's surface normal, so w = J u is the velocity of A away from B; λ is an impulse.

pub mod body;
pub mod collision;
pub mod constraint;
pub mod debug_draw;
mod edit;
pub mod error;
pub mod event;
pub mod handle;
pub mod hooks;
mod island;
pub mod lcp;
pub mod mass;
pub mod math;
mod measure;
pub mod motion;
mod number;
pub mod options;
pub mod query;
pub mod report;
pub mod shape;
mod snapshot;
pub mod solver;
mod step;
mod threads;
mod union_find;
mod validate;
pub mod world;

pub use body::{Body, BodyKind, BodyState, MassSource, NO_HEIGHT, ShapeId};
pub use constraint::joint::{Drive, Freedom, Joint, JointFrames, JointKind, Motor, Range, Spring, TurnAxis};
pub use error::{Error, Result};
pub use event::Event;
pub use handle::{BodyHandle, JointHandle};
pub use hooks::{ContactHooks, PairView, StepContext};
pub use mass::MassProperties;
pub use math::{Mat3, Pose, Quat, Vec3};
pub use options::*;
pub use query::{PointHit, QueryFilter, RayHit, ShapeHit};
pub use report::{Stage, StepReport};
pub use shape::{Combine, ConvexHull, Geometry, Groups, HeightField, Material, Shape, TriangleMesh};
pub use world::{BodyMut, ContactView, JointState, World};

/// The examples of the readme, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
