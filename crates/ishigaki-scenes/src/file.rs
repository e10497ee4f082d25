//! The scene file: JSON that can say all the engine can do.
//!
//! Everything has a sensible default, so a scene says only what matters; unknown fields are errors, so a slip of the
//! pen is found. SI units, `[x, y, z]` vectors, `[x, y, z, w]` quaternions, snake_case tags. The JSON Schema is
//! published as `schema/scene.schema.json` and made by [`scene_schema`].

mod body;
mod build;
mod joint;
mod shape;
mod text;

pub use body::{BodyFile, MassFile, MassPropertiesFile};
pub use build::Scene;
pub use joint::{
    BodyRef, DriveFile, FrameFile, FramesFile, FreedomFile, JointFile, JointKindFile, LimitFile, MotorFile, SpringFile,
    TurnFile,
};
pub use shape::{GeometryFile, HullFile, MeshFile, ShapeFile};

pub(crate) use text::shorten;

use crate::error::{Result, SceneError, with_guess};
use ishigaki::{Vec3, WorldOptions};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The version of the format this crate reads and writes.
pub const FORMAT_VERSION: u32 = 1;

/// A scene as it is written in a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(title = "Ishigaki scene")]
pub struct SceneFile {
    /// Version of the format: 1.
    pub version: u32,
    /// A short name.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// What it shows, for people.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub description: String,
    /// Suggested length of a step, s.
    pub dt: f32,
    /// Suggested number of steps.
    pub steps: u32,
    /// Options of the engine; what is not said keeps its default.
    #[serde(skip_serializing_if = "is_default", serialize_with = "text::only_changed")]
    pub options: WorldOptions,
    /// Convex hulls that shapes refer to by name (`shared_hull`).
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub hulls: BTreeMap<String, HullFile>,
    /// Triangle meshes that shapes refer to by name (`shared_mesh`).
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub meshes: BTreeMap<String, MeshFile>,
    /// Bodies, added in this order.
    pub bodies: Vec<BodyFile>,
    /// Joints, added in this order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub joints: Vec<JointFile>,
    /// Pairs of bodies that never touch each other.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub excluded_pairs: Vec<[BodyRef; 2]>,
    /// Where a viewer should look from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera: Option<CameraFile>,
}

impl Default for SceneFile {
    fn default() -> Self {
        Self {
            version: FORMAT_VERSION,
            name: String::new(),
            description: String::new(),
            dt: 1.0 / 60.0,
            steps: 600,
            options: WorldOptions::default(),
            hulls: BTreeMap::new(),
            meshes: BTreeMap::new(),
            bodies: Vec::new(),
            joints: Vec::new(),
            excluded_pairs: Vec::new(),
            camera: None,
        }
    }
}

/// A hint for viewers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CameraFile {
    /// Where the eye is, world, m.
    #[schemars(with = "[f32; 3]")]
    pub position: Vec3,
    /// What it looks at, world, m.
    #[schemars(with = "[f32; 3]")]
    pub target: Vec3,
}

impl SceneFile {
    /// Reads the JSON of a scene; `origin` (a file's path, usually) is what errors call it.
    ///
    /// # Errors
    /// Text that is not JSON or not a scene (line, column, JSON path and remedy are named), a version that is not
    /// [`FORMAT_VERSION`]. Numbers and references are checked by [`SceneFile::build`].
    pub fn from_json(json: &str, origin: &str) -> Result<Self> {
        // serde would take a list for a struct: its fields by position.
        if json.trim_start().starts_with('[') {
            return Err(SceneError::invalid(origin, "a scene is an object { … }, not a list"));
        }
        let mut deserializer = serde_json::Deserializer::from_str(json);
        let mut track = serde_path_to_error::Track::new();
        let read = Self::deserialize(serde_path_to_error::Deserializer::new(&mut deserializer, &mut track));
        let file = read.map_err(|e| json_error(origin, &track.path().to_string(), &e))?;
        deserializer.end().map_err(|e| json_error(origin, "", &e))?;
        if file.version != FORMAT_VERSION {
            let message = format!("this program reads version {FORMAT_VERSION}, the file has version {}", file.version);
            return Err(SceneError::invalid(format!("{origin}: version"), message));
        }
        Ok(file)
    }

    /// Reads a file.
    ///
    /// # Errors
    /// A file that cannot be read, and all that [`SceneFile::from_json`] refuses.
    pub fn load(path: impl AsRef<std::path::Path>) -> Result<Self> {
        let path = path.as_ref();
        let origin = path.display().to_string();
        let json = std::fs::read_to_string(path)
            .map_err(|e| SceneError::File { path: origin.clone(), message: e.to_string() })?;
        Self::from_json(&json, &origin)
    }

    /// The scene as JSON for people: what has its default value is left out, short lists stay on one line.
    ///
    /// Reading it back gives an equal scene, bit for bit, if all its numbers are finite.
    pub fn to_json(&self) -> String {
        // Only a map whose keys are no strings could fail; there is none.
        text::pretty(&serde_json::to_string(self).unwrap_or_default())
    }
}

/// The JSON Schema of the scene file (draft 2020-12), as published in `schema/scene.schema.json`.
pub fn scene_schema() -> serde_json::Value {
    let mut schema = schemars::schema_for!(SceneFile).to_value();
    text::shorten(&mut schema);
    schema
}

fn json_error(origin: &str, path: &str, error: &serde_json::Error) -> SceneError {
    let (line, column) = (error.line(), error.column());
    let text = error.to_string();
    let message = text.strip_suffix(&format!(" at line {line} column {column}")).unwrap_or(&text);
    let path = if path == "." || path == "?" { "" } else { path };
    let mut message = with_guess(message);
    if message == "expected value" {
        // serde_json's words for `{}` where the name of a form should be, too.
        message.push_str(": where one of several forms is meant, say its name, as in {\"ball\": {\"radius\": 1}}");
    }
    if message.starts_with("recursion limit exceeded") {
        message.push_str(": compounds are nested too deep; lay them out flat");
    }
    SceneError::Json { origin: origin.to_string(), line, column, path: path.to_string(), message }
}

pub(crate) fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// A number that may be left out. One that an f32 cannot hold would be read as infinity and written as nothing.
pub(crate) fn finite_or_none<'de, D: serde::Deserializer<'de>>(
    deserializer: D,
) -> std::result::Result<Option<f32>, D::Error> {
    match Option::<f32>::deserialize(deserializer)? {
        Some(value) if !value.is_finite() => {
            Err(serde::de::Error::custom("must be finite and fit 32 bits: leave it out for no bound"))
        }
        value => Ok(value),
    }
}

pub(crate) fn is_zero(value: &f32) -> bool {
    *value == 0.0
}

pub(crate) fn is_one(value: &f32) -> bool {
    *value == 1.0
}

pub(crate) fn is_true(value: &bool) -> bool {
    *value
}

pub(crate) fn is_false(value: &bool) -> bool {
    !*value
}
