//! Hostile input for everything that reads a file: parse, build, a few steps, snapshot.
//!
//! [`check`] is the entry of both drivers: the coverage-guided targets in `fuzz/` (long runs by hand) and the seeded
//! mutations of `cargo xtask fuzz` (the same cases on every machine). It must never panic, abort or hang.

pub mod corpus;
pub mod mutate;

use ishigaki::World;
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
}

impl Target {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::SceneJson, Self::Mjcf, Self::Urdf, Self::Snapshot];

    /// As on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::SceneJson => "scene_json",
            Self::Mjcf => "mjcf",
            Self::Urdf => "urdf",
            Self::Snapshot => "snapshot",
        }
    }
}

/// How far an input came.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Refused with an error, as it should be.
    Refused,
    /// Right, but too large to be tried here.
    TooLarge,
    /// A world was built and stepped.
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
    let Ok(text) = std::str::from_utf8(data) else { return Outcome::Refused };
    let options = ImportOptions { ground: true, ..ImportOptions::default() };
    // Nothing is there: assets that a mutated model names are not found.
    let here = Path::new("no/such/folder");
    let scene = match target {
        Target::SceneJson => SceneFile::from_json(text, "fuzz.json").ok(),
        Target::Mjcf => models::import_mjcf_str(text, here, &options).ok().map(|import| import.scene),
        Target::Urdf => models::import_urdf_str(text, here, &options).ok().map(|import| import.scene),
        Target::Snapshot => None,
    };
    let Some(scene) = scene else { return Outcome::Refused };
    if is_too_large(&scene) {
        return Outcome::TooLarge;
    }
    let Ok(built) = scene.build() else { return Outcome::Refused };
    assert_rewrites(scene);
    step(built.world)
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
