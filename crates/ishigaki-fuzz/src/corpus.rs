//! What the mutations start from: the test data of the scene crate and all named scenes.

use crate::{Outcome, Target, check};
use ishigaki_scenes::{list, named};
use std::path::{Path, PathBuf};

/// One good input.
pub struct Seed {
    /// A file, or the name of a scene.
    pub name: String,
    /// What reads it.
    pub target: Target,
    /// The text.
    pub data: Vec<u8>,
}

/// All seeds, in a fixed order; inputs that are too large to be tried are left out.
pub fn all() -> Vec<Seed> {
    let mut seeds = files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../ishigaki-scenes/tests/data"));
    for scene in list() {
        if let Ok(file) = named(scene.name, &[]) {
            let data = file.to_json().into_bytes();
            let small = !crate::is_too_large(&file);
            if let (true, Ok(built)) = (small, file.build()) {
                seeds.push(Seed { name: scene.name.into(), target: Target::Snapshot, data: built.world.snapshot() });
            }
            seeds.push(Seed { name: scene.name.into(), target: Target::SceneJson, data });
        }
    }
    seeds.retain(|seed| check(seed.target, &seed.data) != Outcome::TooLarge);
    seeds
}

fn files(folder: &Path) -> Vec<Seed> {
    let mut paths: Vec<PathBuf> = Vec::new();
    collect(folder, &mut paths);
    paths.sort();
    let seed = |path: PathBuf| {
        let data = std::fs::read(&path).ok()?;
        let target = target_of(&path, &data)?;
        Some(Seed { name: path.strip_prefix(folder).unwrap_or(&path).display().to_string(), target, data })
    };
    paths.into_iter().filter_map(seed).collect()
}

fn collect(folder: &Path, paths: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() { collect(&path, paths) } else { paths.push(path) }
    }
}

fn target_of(path: &Path, data: &[u8]) -> Option<Target> {
    let is_robot = || data.windows(6).any(|w| w == b"<robot");
    match path.extension()?.to_str()? {
        "json" => Some(Target::SceneJson),
        "urdf" => Some(Target::Urdf),
        "xml" if is_robot() => Some(Target::Urdf),
        "xml" => Some(Target::Mjcf),
        _ => None,
    }
}
