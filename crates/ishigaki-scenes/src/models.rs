//! Models of robots as scenes: MuJoCo's MJCF and ROS's URDF.
//!
//! The file's frame is kept (Z up in both formats) and gravity is set from it; nothing that would change the motion is
//! dropped silently: what the engine does otherwise is said in [`Import::warnings`].
//!
//! ```no_run
//! use ishigaki_scenes::models::{ImportOptions, import};
//! let import = import("ant.xml".as_ref(), &ImportOptions { ground: true, ..Default::default() })?;
//! for warning in &import.warnings {
//!     eprintln!("{warning}");
//! }
//! let scene = import.scene.build()?;
//! # Ok::<(), ishigaki_scenes::SceneError>(())
//! ```

mod assemble;
mod contact;
pub(crate) mod inertia;
mod stage;
pub(crate) mod tree;
pub(crate) mod xml;

use crate::error::SceneError;
use crate::file::SceneFile;
use glamx::{DPose3, DVec3};
use ishigaki::{Geometry, Vec3};
use std::path::Path;

pub(crate) use assemble::assemble;

/// How a model is imported.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ImportOptions {
    /// Adds a floor under the lowest point of a model that has none.
    pub ground: bool,
    /// URDF: the root link is fixed to the world. A root link named `world` always is; others float freely.
    pub fixed_base: bool,
}

/// A model as a scene, and what of it the engine does otherwise.
#[derive(Clone, Debug)]
pub struct Import {
    /// Bodies and joints in the file's order.
    pub scene: SceneFile,
    /// Whatever affects the motion and was approximated or left out; each with its place.
    pub warnings: Vec<String>,
}

/// Reads a model: MJCF if the root element is `mujoco`, URDF if it is `robot`.
///
/// # Errors
/// A file that cannot be read or is neither of the two; all that [`import_mjcf_str`] and [`import_urdf_str`] refuse.
pub fn import(path: &Path, options: &ImportOptions) -> Result<Import, SceneError> {
    let name = path.display().to_string();
    let text =
        std::fs::read_to_string(path).map_err(|e| SceneError::File { path: name.clone(), message: e.to_string() })?;
    let base = path.parent().unwrap_or(Path::new("."));
    let file = path.file_name().map_or_else(|| name.clone(), |f| f.to_string_lossy().into_owned());
    read(&text, &name, &file, base, options)
}

/// Reads the text of a model, MJCF or URDF by its root element; `name` is what errors call it, `base_dir` is where
/// included files and assets are.
///
/// # Errors
/// Text that is neither of the two; all that [`import_mjcf_str`] and [`import_urdf_str`] refuse.
pub fn import_text(name: &str, text: &str, base_dir: &Path, options: &ImportOptions) -> Result<Import, SceneError> {
    read(text, name, name, base_dir, options)
}

/// Errors about the whole text name `path`, those in it `file`.
fn read(text: &str, path: &str, file: &str, base: &Path, options: &ImportOptions) -> Result<Import, SceneError> {
    // Well-formed or not, the root's tag says what was meant; the reader names what is wrong.
    match root_tag(text) {
        Some("mujoco") => crate::mjcf::import(text, file, base, options),
        Some("robot") => crate::urdf::import(text, file, base, options),
        Some(other) => {
            let message = format!("the root element is <{other}>: MJCF has <mujoco>, URDF has <robot>");
            Err(SceneError::invalid(path, message))
        }
        None => Err(SceneError::invalid(path, "is not XML: MJCF has the root element <mujoco>, URDF has <robot>")),
    }
}

/// Reads MJCF; `base_dir` is where included files and assets are.
///
/// # Errors
/// What is not well-formed, a number that makes no sense, a reference to something that is not there, a file that
/// cannot be read, a moving body without mass; each with its file, line and element.
pub fn import_mjcf_str(xml: &str, base_dir: &Path, options: &ImportOptions) -> Result<Import, SceneError> {
    crate::mjcf::import(xml, "model.xml", base_dir, options)
}

/// Reads URDF; `base_dir` is where relative paths start and packages are looked for, there and above.
///
/// # Errors
/// What is not well-formed, a number that makes no sense, a link that is not there, links that are not a tree; each
/// with its file, line and element.
pub fn import_urdf_str(xml: &str, base_dir: &Path, options: &ImportOptions) -> Result<Import, SceneError> {
    crate::urdf::import(xml, "model.urdf", base_dir, options)
}

/// The tag of the first element, without reading the rest.
fn root_tag(text: &str) -> Option<&str> {
    let mut rest = text;
    loop {
        let (_, after) = rest.split_once('<')?;
        if let Some(comment) = after.strip_prefix("!--") {
            rest = comment.split_once("-->")?.1;
        } else if after.starts_with('?') || after.starts_with('!') {
            rest = after.split_once('>')?.1;
        } else {
            let end = after.find(|c: char| c.is_whitespace() || c == '>' || c == '/')?;
            return Some(&after[..end]);
        }
    }
}

/// Height of the lowest point of a shape along `up`, m; `None` for what has no lowest point.
pub(crate) fn lowest(geometry: &Geometry, world_from_shape: DPose3, up: DVec3) -> Option<f64> {
    let center = world_from_shape.translation.dot(up);
    let local = world_from_shape.rotation.inverse() * up;
    let across = (local.x * local.x + local.z * local.z).sqrt();
    let points = |points: &mut dyn Iterator<Item = Vec3>| {
        points.map(|p| local.dot(DVec3::new(p.x.into(), p.y.into(), p.z.into()))).fold(f64::INFINITY, f64::min)
    };
    let below = match geometry {
        Geometry::Ball { radius } => -f64::from(*radius),
        Geometry::Cuboid { half_extents: h } => -(local.abs().dot(DVec3::new(h.x.into(), h.y.into(), h.z.into()))),
        Geometry::Capsule { half_length, radius } => -f64::from(*half_length) * local.y.abs() - f64::from(*radius),
        Geometry::Cylinder { half_height, radius } => {
            -f64::from(*half_height) * local.y.abs() - f64::from(*radius) * across
        }
        Geometry::ConvexHull(hull) => points(&mut hull.points().iter().copied()),
        _ => return None,
    };
    Some(center + below)
}
