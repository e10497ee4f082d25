//! What the tests of importers share: finding things in a scene, and real models with the word for where they are not.
#![allow(dead_code, reason = "each test file uses its own part")]

use ishigaki::MassProperties;
use ishigaki_scenes::SceneFile;
use ishigaki_scenes::file::{BodyFile, JointFile, MassFile};
use ishigaki_scenes::models::{Import, ImportOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

/// A reader of the text of a model whose files lie in a folder.
pub type Reader = fn(&str, &Path, &ImportOptions) -> ishigaki_scenes::Result<Import>;

/// The folder of files for tests.
pub fn data() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data")
}

/// Reads what must be readable.
pub fn read_with(reader: Reader, xml: &str) -> Import {
    reader(xml, &data(), &ImportOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// The message for what must be refused.
pub fn error_of(reader: Reader, xml: &str) -> String {
    match reader(xml, &data(), &ImportOptions::default()) {
        Ok(_) => panic!("was read: {xml}"),
        Err(e) => e.to_string(),
    }
}

pub fn body<'a>(scene: &'a SceneFile, name: &str) -> &'a BodyFile {
    scene.bodies.iter().find(|b| b.name == name).unwrap_or_else(|| panic!("no body {name}"))
}

pub fn joint<'a>(scene: &'a SceneFile, name: &str) -> &'a JointFile {
    scene.joints.iter().find(|j| j.name == name).unwrap_or_else(|| panic!("no joint {name}"))
}

pub fn mass(body: &BodyFile) -> MassProperties {
    match body.mass {
        Some(MassFile::Properties(p)) => p.into(),
        other => panic!("{}: {other:?}", body.name),
    }
}

/// The folder of a set of models, or `None` after saying that the test is skipped; an error if `ISHIGAKI_REQUIRE` names
/// the set.
pub fn models(set: &str) -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models").join(set);
    if folder.join(".version").is_file() {
        return Some(folder);
    }
    // URDF is optional: its download is large.
    let (needed, command) = match set {
        "gymnasium" => ("models", "scripts/fetch-models.sh"),
        _ => ("models-urdf", "scripts/fetch-models.sh --urdf"),
    };
    let message = format!("SKIPPED {needed}: run {command}");
    let required = std::env::var("ISHIGAKI_REQUIRE").unwrap_or_default();
    assert!(!required.split([',', ' ']).any(|word| word == needed), "{message}");
    eprintln!("{message}");
    if let Some(log) = std::env::var_os("ISHIGAKI_SKIP_LOG")
        && let Ok(mut file) = std::fs::OpenOptions::new().append(true).create(true).open(log)
    {
        // In one piece: other tests append, too.
        let _ = file.write_all(format!("{message}\n").as_bytes());
    }
    None
}
