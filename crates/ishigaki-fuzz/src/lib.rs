//! Hostile input for everything that reads a file: parse, build, a few steps, snapshot.
//!
//! [`check`] is the entry of both drivers: the coverage-guided targets in `fuzz/` (long runs by hand) and the seeded
//! mutations of `cargo xtask fuzz` (the same cases on every machine). It must never panic, abort or hang.

pub mod corpus;
pub mod mutate;

use ishigaki::World;
use ishigaki_recording::Recording;
use ishigaki_scenes::SceneFile;
use ishigaki_scenes::file::{GeometryFile, ShapeFile};
use ishigaki_scenes::models::{self, ImportOptions};
use std::path::Path;

/// Steps of each world that could be built.
const STEPS: usize = 5;
/// Larger inputs are refused: they would test patience, not correctness.
const MOST_BYTES: usize = 1 << 20;
/// The same for bodies, for shapes with points and triangles, and for joints.
const MOST_PARTS: usize = 300;
/// The same for sweeps in a step.
const MOST_SWEEPS: u64 = 400;

/// What reads the input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// The scene file.
    SceneJson,
    /// A MuJoCo model.
    Mjcf,
    /// A robot description.
    Urdf,
    /// A snapshot of a world.
    Snapshot,
    /// A recording of a run.
    Recording,
}

impl Target {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::SceneJson, Self::Mjcf, Self::Urdf, Self::Snapshot, Self::Recording];

    /// As on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::SceneJson => "scene_json",
            Self::Mjcf => "mjcf",
            Self::Urdf => "urdf",
            Self::Snapshot => "snapshot",
            Self::Recording => "recording",
        }
    }
}

/// How far an input came.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Outcome {
    /// Refused with an error, as it should be.
    Refused,
    /// Right, but too large to be tried here.
    TooLarge,
    /// A world was built and stepped, or every frame of a recording was read.
    Stepped,
}

/// Feeds `data` to a reader and steps what comes out. Panics only on a defect.
pub fn check(target: Target, data: &[u8]) -> Outcome {
    if data.len() > MOST_BYTES {
        return Outcome::TooLarge;
    }
    if target == Target::Snapshot {
        return World::restore(data).map_or(Outcome::Refused, step);
    }
    if target == Target::Recording {
        // Once as it is, once with right checksums: else nothing wrong would get past them.
        return read(data).max(read(&with_right_checksums(data)));
    }
    let Ok(text) = std::str::from_utf8(data) else { return Outcome::Refused };
    let options = ImportOptions { ground: true, ..ImportOptions::default() };
    // Nothing is there: assets that a mutated model names are not found.
    let here = Path::new("no/such/folder");
    let scene = match target {
        Target::SceneJson => SceneFile::from_json(text, "fuzz.json").ok(),
        Target::Mjcf => models::import_mjcf_str(text, here, &options).ok().map(|import| import.scene),
        Target::Urdf => models::import_urdf_str(text, here, &options).ok().map(|import| import.scene),
        Target::Snapshot | Target::Recording => None,
    };
    let Some(scene) = scene else { return Outcome::Refused };
    if is_too_large(&scene) {
        return Outcome::TooLarge;
    }
    let Ok(built) = scene.build() else { return Outcome::Refused };
    assert_rewrites(scene);
    step(built.world)
}

/// Reads all frames of a recording.
fn read(data: &[u8]) -> Outcome {
    let Ok((recording, _)) = Recording::recover(data) else { return Outcome::Refused };
    for frame in 0..recording.len() {
        let frame = recording.frame(frame).expect("it is within the recording");
        assert_eq!(frame.bodies.len(), recording.scene().bodies.len(), "a record for each body");
    }
    Outcome::Stepped
}

/// As `docs/recording-format.md` lays them out: after a head of 16 bytes, chunks of tag, length, content, checksum.
fn with_right_checksums(data: &[u8]) -> Vec<u8> {
    let mut data = data.to_vec();
    let mut mend = |from: usize, to: usize| {
        let sum = crc32fast::hash(data.get(from..to)?).to_le_bytes();
        data.get_mut(to..to + 4)?.copy_from_slice(&sum);
        let length = data.get(to + 8..to + 12)?;
        Some(u32::from_le_bytes([length[0], length[1], length[2], length[3]]) as usize)
    };
    let (mut from, mut to) = (0, 12);
    while let Some(length) = mend(from, to) {
        (from, to) = (to + 4, to + 12 + length);
    }
    data
}

fn step(mut world: World) -> Outcome {
    for _ in 0..STEPS {
        let report = world.step(1.0 / 60.0);
        assert_eq!(report.rejected, None, "a good Δt was rejected");
    }
    // What was written must be read again, and be the same world.
    let restored = World::restore(&world.snapshot()).expect("an own snapshot");
    assert_eq!(restored.state_hash(), world.state_hash(), "a snapshot changed the state");
    Outcome::Stepped
}

/// A scene that could be built can be written and read again.
fn assert_rewrites(mut scene: SceneFile) {
    // The only numbers that building does not look at.
    scene.camera = None;
    let again = SceneFile::from_json(&scene.to_json(), "rewritten.json").expect("an own scene file");
    assert!(again == scene, "writing and reading changed the scene: {}", scene.to_json());
}

fn is_too_large(scene: &SceneFile) -> bool {
    let solver = &scene.options.solver;
    let passes = if solver.manifold_block.enabled { u64::from(solver.manifold_block.passes) } else { 1 };
    let sweeps = (u64::from(solver.sweeps) + u64::from(solver.relax_sweeps)) * passes;
    let sweeps = u64::from(solver.substeps) * (1 + sweeps + u64::from(solver.restitution.passes));
    let shared = scene.hulls.values().map(|hull| hull.points.len()).sum::<usize>()
        + scene.meshes.values().map(|mesh| mesh.triangles.len()).sum::<usize>();
    let parts: usize = scene.bodies.iter().flat_map(|body| &body.shapes).map(size).sum();
    sweeps > MOST_SWEEPS || scene.bodies.len() + scene.joints.len() > MOST_PARTS || parts + shared > 20 * MOST_PARTS
}

fn size(shape: &ShapeFile) -> usize {
    match &shape.geometry {
        GeometryFile::ConvexHull(hull) => hull.points.len(),
        GeometryFile::TriangleMesh(mesh) => mesh.triangles.len(),
        GeometryFile::HeightField { heights, .. } => heights.len(),
        GeometryFile::Compound { shapes } => shapes.iter().map(size).sum(),
        _ => 1,
    }
}
