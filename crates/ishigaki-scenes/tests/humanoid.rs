//! MuJoCo's humanoid as Gymnasium has it dies: alone and in a heap of twenty it comes to rest with its joints together.
//! Sleep is off, so that rest is the solver's. Run with `--nocapture` to see the measured figures.
//!
//! Skipped, and said so, where the models are not there; an error if `ISHIGAKI_REQUIRE` names `models`.

mod common;

use common::models;
use ishigaki::{BodyKind, Combine, Vec3};
use ishigaki_scenes::SceneFile;
use ishigaki_scenes::file::{BodyRef, FramesFile};
use ishigaki_scenes::measure::REST_SPEED;
use ishigaki_scenes::models::{ImportOptions, import};

/// The humanoid on a floor, or `None` after saying that the test is skipped.
fn humanoid() -> Option<SceneFile> {
    let path = models("gymnasium")?.join("humanoid.xml");
    let mut scene = import(&path, &ImportOptions { ground: true, ..ImportOptions::default() }).unwrap().scene;
    scene.options.rest.sleep.enabled = false;
    Some(scene)
}

/// The scene with `count` copies of all that moves, each a little aside of and 2 m above the one before.
fn heap(one: &SceneFile, count: usize) -> SceneFile {
    let mut heap = one.clone();
    let moves: Vec<bool> = one.bodies.iter().map(|b| b.kind != BodyKind::Fixed).collect();
    for k in 1..count {
        let (layer, place) = (k / 4, k % 4);
        let across = Vec3::new((place % 2) as f32, (place / 2) as f32, 0.0) * 1.2 + 0.2 * Vec3::X * layer as f32;
        let shift = across + 2.0 * Vec3::Z * layer as f32;
        let mut index_of: Vec<usize> = (0..one.bodies.len()).collect();
        for (i, body) in one.bodies.iter().enumerate().filter(|(i, _)| moves[*i]) {
            index_of[i] = heap.bodies.len();
            let mut copy = body.clone();
            copy.name = format!("{}_{k}", body.name);
            copy.position += shift;
            heap.bodies.push(copy);
        }
        let moved = |body: &BodyRef| match body {
            BodyRef::Index(i) => BodyRef::Index(index_of[*i]),
            BodyRef::Name(name) => panic!("the importer names bodies by index, not `{name}`"),
        };
        for joint in &one.joints {
            let mut copy = joint.clone();
            copy.name = format!("{}_{k}", joint.name);
            (copy.body_a, copy.body_b) = (moved(&joint.body_a), moved(&joint.body_b));
            if let FramesFile::World(frame) = &mut copy.frame {
                frame.position += shift;
            }
            heap.joints.push(copy);
        }
        heap.excluded_pairs.extend(one.excluded_pairs.iter().map(|[a, b]| [moved(a), moved(b)]));
    }
    heap
}

/// What was seen of one or more humanoids that fell; times from the start, s.
#[derive(Debug)]
struct Fall {
    /// When the last humanoid had touched something.
    landing: f64,
    /// From when on nothing was faster than 0.05 m/s.
    rest: Option<f64>,
    /// Greatest gap of a joint from 1 s after landing on, m.
    gap: f32,
    /// Greatest angle beyond a range from 1 s after landing on, degrees.
    angle: f32,
}

fn fall(name: &str, file: &SceneFile, count: usize, seconds: f64) -> Fall {
    let mut world = file.build().unwrap().world;
    let movers: Vec<_> = world.bodies().filter(|(_, b)| b.kind() != BodyKind::Fixed).map(|(h, _)| h).collect();
    let each = movers.len() / count;
    let mut touched = vec![None; count];
    let mut fall = Fall { landing: f64::INFINITY, rest: None, gap: 0.0, angle: 0.0 };
    while world.time() < seconds {
        let report = world.step(1.0 / 60.0);
        assert!(report.non_finite.is_empty(), "{name} is not finite at {} s", world.time());
        for contact in world.contacts() {
            for body in [contact.a.body, contact.b.body] {
                if let Some(i) = movers.iter().position(|&m| m == body) {
                    touched[i / each].get_or_insert(world.time());
                }
            }
        }
        if touched.iter().all(Option::is_some) {
            fall.landing = touched.iter().flatten().fold(0.0, |a: f64, &b| a.max(b));
        }
        fall.rest = (report.max_speed <= REST_SPEED).then(|| fall.rest.unwrap_or(world.time()));
        if world.time() > fall.landing + 1.0 {
            fall.gap = fall.gap.max(report.max_joint_error);
            let beyond = world.joints().map(|(_, j)| j.angle_error().to_degrees());
            fall.angle = beyond.fold(fall.angle, f32::max);
        }
    }
    eprintln!("{name}: {fall:?}, speed at the end {:.4} m/s", world.report().max_speed);
    fall
}

fn assert_dead(fall: &Fall, within: f64) {
    assert!(fall.rest.is_some_and(|r| r < fall.landing + within), "not at rest within {within} s of landing: {fall:?}");
    assert!(fall.gap < 2e-3, "joints came apart: {fall:?}");
    assert!(fall.angle < 2.0, "ranges were left: {fall:?}");
}

#[test]
fn a_humanoid_dies() {
    let Some(file) = humanoid() else { return };
    assert_dead(&fall("humanoid", &file, 1, 8.0), 5.0);
}

/// Falls of heaps of twelve sizes: how long one of them trembles, or how far a limb is bent that others lie on, is chance,
/// and any change of rounding is another throw.
fn falls(name: &str, file: &SceneFile) -> Vec<Fall> {
    let sizes = (10..33).step_by(2);
    sizes.map(|count| fall(&format!("{count} humanoids, {name}"), &heap(file, count), count, 10.0)).collect()
}

/// The upper median: what half of the heaps keep.
fn usual(falls: &[Fall], figure: impl Fn(&Fall) -> f64) -> f64 {
    let mut figures: Vec<f64> = falls.iter().map(figure).collect();
    figures.sort_by(f64::total_cmp);
    figures[figures.len() / 2]
}

/// How long after landing, s.
fn time_to_rest(fall: &Fall) -> f64 {
    fall.rest.unwrap_or(f64::INFINITY) - fall.landing
}

/// With the floor's friction between limbs too. In the file they have none (`condim="1"`).
#[test]
fn heaps_of_humanoids_with_friction_die() {
    let Some(mut file) = humanoid() else { return };
    for shape in file.bodies.iter_mut().flat_map(|body| &mut body.shapes) {
        (shape.friction, shape.friction_combine) = (1.0, Combine::Maximum);
    }
    let falls = falls("with friction", &file);
    assert!(usual(&falls, time_to_rest) < 5.0, "not at rest within 5 s of landing: {falls:?}");
    assert!(usual(&falls, |fall| fall.gap.into()) < 2e-3, "joints came apart: {falls:?}");
    assert!(usual(&falls, |fall| fall.angle.into()) < 3.0, "ranges were left: {falls:?}");
    // A shin or a head under the heap is held by a ratio of masses of ten.
    assert!(falls.iter().all(|fall| fall.gap < 6e-3 && fall.angle < 7.0), "a joint came apart: {falls:?}");
}

/// As filed the limbs have no friction against each other, and joints have an armature of 1 kg·m² with a damping of
/// 1 N·m·s: their motion fades with a time constant of a second or more, and in some heaps a limb that creeps on another
/// topples after 6 or 10 s (`decisions/023-joints-in-lanes.md`).
#[test]
fn heaps_of_humanoids_die() {
    let Some(file) = humanoid() else { return };
    let falls = falls("as filed", &file);
    assert!(usual(&falls, time_to_rest) < 8.0, "not at rest within 8 s of landing: {falls:?}");
    assert!(usual(&falls, |fall| fall.gap.into()) < 2e-3, "joints came apart: {falls:?}");
    assert!(usual(&falls, |fall| fall.angle.into()) < 2.0, "ranges were left: {falls:?}");
    assert!(falls.iter().all(|fall| fall.gap < 6e-3 && fall.angle < 4.0), "a joint came apart: {falls:?}");
}
