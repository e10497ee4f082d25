//! Scenes for the Ishigaki physics engine: a JSON file that can say all the engine can do, named parametric
//! scenes, options by path, importers, and the words in which scenes are judged.
//!
//! ```
//! use ishigaki_scenes::SceneFile;
//! let text = r#"{ "bodies": [{ "position": [0, 2, 0], "shapes": [{ "geometry": { "ball": { "radius": 0.5 } } }] }] }"#;
//! let scene = SceneFile::from_json(text, "ball.json")?.build()?;
//! assert_eq!(scene.bodies[0].0, "body0");
//! # Ok::<(), ishigaki_scenes::SceneError>(())
//! ```

pub mod error;
pub mod file;
pub mod measure;
mod mesh;
mod mjcf;
pub mod models;
pub mod named;
pub mod options;
mod urdf;

pub use error::{Result, SceneError};
pub use file::{Scene, SceneFile, scene_schema};
pub use measure::{Measure, Meter};
pub use named::{Parameter, SceneInfo, list, named};
pub use options::{list_options, set_option};
