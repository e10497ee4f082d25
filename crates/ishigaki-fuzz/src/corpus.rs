//! What the mutations start from: the test data of the scene crate and all named scenes.

use crate::{Target, is_too_large};
use ishigaki_recording::{About, Recorder};
use ishigaki_scenes::SceneFile;
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
    // As cargo says at run time: clones that share a target folder share this program too.
    let here = std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_else(|| env!("CARGO_MANIFEST_DIR").into());
    let mut seeds = files(&Path::new(&here).join("../ishigaki-scenes/tests/data"));
    for scene in list() {
        // The default sizes are for people to look at: small ones are mutated more often in the same time.
        let small: Vec<(String, f64)> = scene
            .parameters
            .iter()
            .filter(|p| p.whole && p.default > 3.0)
            .map(|p| (p.name.into(), p.range.0.max(3.0)))
            .collect();
        if let Ok(file) = named(scene.name, &small) {
            seeds.extend(seeds_of(scene.name, &file));
        }
    }
    seeds
}

fn seeds_of(name: &str, file: &SceneFile) -> Vec<Seed> {
    if is_too_large(file) {
        return Vec::new();
    }
    let seed = |target, data| Seed { name: name.into(), target, data };
    let snapshot = file.build().ok().map(|mut built| {
        built.world.step(built.dt);
        seed(Target::Snapshot, built.world.snapshot())
    });
    let recording = record(file).map(|data| seed(Target::Recording, data));
    let scene = seed(Target::SceneJson, file.to_json().into_bytes());
    snapshot.into_iter().chain(recording).chain([scene]).collect()
}

/// A recording of a few steps.
fn record(file: &SceneFile) -> Option<Vec<u8>> {
    let mut built = file.build().ok()?;
    let about = About { dt: built.dt, contacts: true, ..About::default() };
    let mut recorder = Recorder::new(Vec::new(), &built.world, &about).ok()?;
    for _ in 0..3 {
        built.world.step(built.dt);
        recorder.step(&built.world).ok()?;
    }
    recorder.finish(&built.world).ok()
}

fn files(folder: &Path) -> Vec<Seed> {
    let mut paths: Vec<PathBuf> = Vec::new();
    collect(folder, &mut paths);
    paths.sort();
    let seed = |path: PathBuf| {
        let data = std::fs::read(&path).ok()?;
        let target = target_of(&path, &data)?;
        (data.len() <= crate::MOST_BYTES).then_some(())?;
        Some(Seed { name: path.strip_prefix(folder).unwrap_or(&path).display().to_string(), target, data })
    };
    paths.into_iter().filter_map(seed).collect()
}

fn collect(folder: &Path, paths: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            collect(&path, paths);
        } else {
            paths.push(path);
        }
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
