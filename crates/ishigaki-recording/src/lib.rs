//! Recordings (`.ishi`): what a viewer needs to show a run again.
//!
//! A [`Recorder`] watches a [`World`](ishigaki::World) and writes as it steps; a [`Recording`] reads the bytes back.
//! No files, no clock: it works on any [`Write`](std::io::Write) and in wasm. The bytes are described in
//! `docs/recording-format.md`; this code follows its words.
//!
//! ```
//! use ishigaki::{Body, Shape, World};
//! use ishigaki_recording::{About, Recorder, Recording};
//!
//! let mut world = World::default();
//! world.add_body(Body::dynamic(Shape::ball(0.5)))?;
//! let about = About { name: "a falling ball".into(), dt: 0.01, ..About::default() };
//! let mut recorder = Recorder::new(Vec::new(), &world, &about)?;
//! for _ in 0..10 {
//!     world.step(about.dt);
//!     recorder.step(&world)?;
//! }
//! let bytes = recorder.finish(&world)?;
//!
//! let recording = Recording::read(&bytes)?;
//! assert_eq!(recording.len(), 11, "the start and ten steps");
//! let last = recording.frame(10).expect("it is there");
//! assert!(last.bodies[0].position.y < 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod chunk;
mod error;
mod frame;
mod recorder;
mod recording;
mod scene;

pub use chunk::VERSION;
pub use error::{Error, Result};
pub use frame::{BodyRecord, Contact, Frame, Measures};
pub use recorder::{About, KEY_INTERVAL, Recorder};
pub use recording::Recording;
pub use scene::{BodyEntry, Camera, Geometry, JointEntry, Placement, Scene, ShapeEntry};
