//! What to run: a named scene, a scene file or a robot model.

use crate::failure::{At, Failure};
use ishigaki_scenes::models::{self, ImportOptions};
use ishigaki_scenes::{SceneFile, named};
use std::io::Read;
use std::path::Path;

/// A scene and where it came from.
pub struct Source {
    pub scene: SceneFile,
    /// For messages: the name of the scene or the path of the file.
    pub origin: String,
    /// What an importer could not take over.
    pub warnings: Vec<String>,
}

/// Reads a scene by its name or from a file; `-` is a scene file on stdin.
pub fn load(what: &str, parameters: &[(String, f64)], import: ImportOptions) -> Result<Source, Failure> {
    let kind = Kind::of(what);
    if kind != Kind::Named && !parameters.is_empty() {
        return Err(Failure::input(format!("{what}: --param belongs to named scenes; edit the file instead")));
    }
    if kind != Kind::Model && import != ImportOptions::default() {
        return Err(Failure::input(format!("{what}: --ground and --fixed-base belong to imported models")));
    }
    let mut warnings = Vec::new();
    let (scene, origin) = match kind {
        Kind::Named if what.contains('.') => {
            return Err(Failure::input(format!("{what}: names of files end in .json, .xml, .mjcf or .urdf")));
        }
        Kind::Named => (named(what, parameters).map_err(Failure::input)?, what.to_string()),
        Kind::Stdin => {
            let mut json = String::new();
            std::io::stdin().read_to_string(&mut json).input_at("stdin")?;
            (SceneFile::from_json(&json, "stdin").map_err(Failure::input)?, "stdin".to_string())
        }
        Kind::Scene => (read_scene(what)?, what.to_string()),
        Kind::Model => {
            check_file(what)?;
            let imported = models::import(Path::new(what), &import).map_err(Failure::input)?;
            warnings = imported.warnings;
            (imported.scene, what.to_string())
        }
    };
    Ok(Source { scene, origin, warnings })
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Named,
    Stdin,
    Scene,
    Model,
}

impl Kind {
    fn of(what: &str) -> Self {
        let path = Path::new(what);
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_lowercase();
        match extension.as_str() {
            _ if what == "-" => Self::Stdin,
            "xml" | "mjcf" | "urdf" => Self::Model,
            "json" => Self::Scene,
            _ if what.contains(['/', '\\']) => Self::Scene,
            _ => Self::Named,
        }
    }
}

fn read_scene(path: &str) -> Result<SceneFile, Failure> {
    check_file(path)?;
    let json = std::fs::read_to_string(path).input_at(path)?;
    SceneFile::from_json(&json, path).map_err(Failure::input)
}

/// The system's own words for a folder or a missing file help little.
fn check_file(path: &str) -> Result<(), Failure> {
    match std::fs::metadata(path) {
        Ok(found) if found.is_dir() => Err(Failure::input(format!("{path}: is a directory; name a file in it"))),
        Ok(_) => Ok(()),
        Err(e) => Err(Failure::input(format!("{path}: {e}; `ishigaki scenes` lists the scenes that need no file"))),
    }
}
