//! Real models of robots, fetched by `scripts/fetch-models.sh`: all are read, their masses are those of an independent
//! sum over the XML and of MuJoCo, and they move without leaving the numbers.
//!
//! Skipped, and said so, where the models are not there; an error if `ISHIGAKI_REQUIRE` names `models`.

mod common;

use common::models;
use ishigaki::{BodyKind, World};
use ishigaki_scenes::SceneFile;
use ishigaki_scenes::file::{BodyRef, DriveFile, FreedomFile, JointKindFile, MassFile};
use ishigaki_scenes::models::{Import, ImportOptions, import};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == extension) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

fn gymnasium(name: &str) -> Option<Import> {
    let path = models("gymnasium")?.join(name);
    Some(import(&path, &ImportOptions::default()).unwrap_or_else(|e| panic!("{e}")))
}

fn total_mass(scene: &SceneFile) -> f64 {
    let mass = |b: &ishigaki_scenes::file::BodyFile| match b.mass {
        Some(MassFile::Properties(p)) => f64::from(p.mass),
        _ => 0.0,
    };
    scene.bodies.iter().filter(|b| b.kind == BodyKind::Dynamic).map(mass).sum()
}

/// All drives of a scene's joints: one for each hinge and slide of the file.
fn drives(scene: &SceneFile) -> Vec<DriveFile> {
    let mut all = Vec::new();
    for joint in &scene.joints {
        match &joint.kind {
            JointKindFile::Hinge(d) | JointKindFile::Slider(d) => all.push(*d),
            JointKindFile::Generic { linear, angular } => {
                all.extend(linear.iter().filter_map(|f| match f {
                    FreedomFile::Free(d) => Some(*d),
                    FreedomFile::Locked => None,
                }));
                all.extend(angular.iter().map(|t| t.drive));
            }
            _ => {}
        }
    }
    all
}

/// The mass of an MJCF file by its geoms alone: straight from the XML, with the one level of defaults these files have.
fn mass_in_xml(path: &Path) -> f64 {
    let text = std::fs::read_to_string(path).unwrap();
    let document = roxmltree::Document::parse(&text).unwrap();
    let class = document.descendants().find(|n| n.has_tag_name("geom") && n.parent().unwrap().has_tag_name("default"));
    let mut total = 0.0;
    for geom in document.descendants().filter(|n| n.has_tag_name("geom")) {
        // The world's own geoms do not count.
        if !geom.parent().unwrap().has_tag_name("body") {
            continue;
        }
        let text = |name: &str| geom.attribute(name).or_else(|| class.and_then(|c| c.attribute(name)));
        let numbers = |name: &str| -> Option<Vec<f64>> {
            text(name).map(|t| t.split_whitespace().map(|w| w.parse().unwrap()).collect())
        };
        let size = numbers("size").unwrap();
        let length = match numbers("fromto") {
            Some(f) => ((f[0] - f[3]).powi(2) + (f[1] - f[4]).powi(2) + (f[2] - f[5]).powi(2)).sqrt(),
            None => 2.0 * size.get(1).copied().unwrap_or(0.0),
        };
        let ball = 4.0 / 3.0 * PI * size[0].powi(3);
        let cylinder = PI * size[0].powi(2) * length;
        let volume = match text("type").unwrap_or("sphere") {
            "sphere" => ball,
            "capsule" => ball + cylinder,
            "cylinder" => cylinder,
            "box" => 8.0 * size[0] * size[1] * size[2],
            other => panic!("{other}"),
        };
        let density = numbers("density").map_or(1000.0, |d| d[0]);
        total += numbers("mass").map_or(density * volume, |m| m[0]);
    }
    let compiler = document.descendants().find(|n| n.has_tag_name("compiler"));
    compiler.and_then(|c| c.attribute("settotalmass")).map_or(total, |m| m.parse().unwrap())
}

#[test]
fn masses_are_those_of_the_xml_and_of_mujoco() {
    let Some(folder) = models("gymnasium") else { return };
    let files = files(&folder, "xml");
    assert!(files.len() >= 14, "{files:?}");
    // As MuJoCo 4.0.0 adds them up, kg.
    let mujoco = [
        ("ant.xml", 0.9108800827),
        ("half_cheetah.xml", 14.0),
        ("hopper.xml", 15.8200134059),
        ("humanoid.xml", 42.1160304921),
        ("pusher.xml", 13.6729966401),
        ("swimmer.xml", 106.8141502221),
        ("walker2d.xml", 23.6771366326),
    ];
    for path in files {
        let name = path.file_name().unwrap().to_str().unwrap();
        let Import { scene, .. } = import(&path, &ImportOptions::default()).unwrap();
        let (ours, xml) = (total_mass(&scene), mass_in_xml(&path));
        assert!((ours - xml).abs() < 1e-6 * xml, "{name}: {ours} {xml}");
        if let Some((_, theirs)) = mujoco.iter().find(|(n, _)| *n == name) {
            assert!((ours - theirs).abs() < 1e-6 * theirs, "{name}: {ours} {theirs}");
        }
    }
}

#[test]
fn the_humanoid_has_its_joints() {
    let Some(Import { scene, warnings }) = gymnasium("humanoid.xml") else { return };
    // 13 bodies in the file; the two feet are welded to the shins. And the floor.
    let moving = scene.bodies.iter().filter(|b| b.kind == BodyKind::Dynamic).count();
    assert_eq!((moving, scene.bodies.len()), (11, 12));
    let drives = drives(&scene);
    assert_eq!(drives.len(), 17);
    assert!(drives.iter().all(|d| d.limit.is_some()), "every hinge has a range");
    assert_eq!(scene.joints.len(), 10);
    let hip = scene.joints.iter().find(|j| j.name == "right_hip_x+right_hip_z+right_hip_y").unwrap();
    let JointKindFile::Generic { angular, .. } = &hip.kind else { panic!("{:?}", hip.kind) };
    let limit =
        |i: usize| angular[i].drive.limit.map(|l| (l.lower.unwrap().to_degrees(), l.upper.unwrap().to_degrees()));
    let expected = [(-25.0, 5.0), (-60.0, 35.0), (-110.0, 20.0)];
    for (i, (lower, upper)) in expected.into_iter().enumerate() {
        let (l, u) = limit(i).unwrap();
        assert!((l - lower).abs() < 1e-3 && (u - upper).abs() < 1e-3, "{l} {u}");
    }
    assert_eq!(angular[2].drive.armature, 0.008);
    assert_eq!(angular[2].drive.spring.map(|s| (s.stiffness, s.damping)), Some((20.0, 5.0)));
    assert_eq!(scene.dt, 0.003);
    let places: Vec<&str> = warnings.iter().map(|w| w.split_once(": ").unwrap().0).collect();
    assert_eq!(places.len(), 6, "{warnings:#?}");
    for what in
        ["17 actuators", "<geom margin>", "<option integrator>", "<option iterations>", "<option solver>", "<tendon>"]
    {
        assert!(warnings.iter().any(|w| w.contains(what)), "{what}: {warnings:#?}");
    }
}

#[test]
fn planar_robots_are_joined_to_the_world_and_touch_its_floor() {
    for name in ["hopper.xml", "walker2d.xml", "half_cheetah.xml"] {
        let Some(Import { scene, .. }) = gymnasium(name) else { return };
        let root = &scene.joints[0];
        let BodyRef::Index(world) = root.body_a else { panic!() };
        assert_eq!(scene.bodies[world].kind, BodyKind::Fixed);
        assert!(root.collide, "{name}");
        let JointKindFile::Generic { linear, angular } = &root.kind else { panic!("{name}: {:?}", root.kind) };
        assert_eq!((linear.iter().filter(|f| **f != FreedomFile::Locked).count(), angular.len()), (2, 1));
    }
    // The foot is rougher than the floor; the other shapes take the floor's friction and have none with each other.
    let Some(Import { scene, .. }) = gymnasium("hopper.xml") else { return };
    let friction = |name: &str| {
        let shape = &scene.bodies.iter().find(|b| b.name == name).unwrap().shapes[0];
        (shape.friction, shape.friction_combine)
    };
    let mix = |a: &str, b: &str| friction(a).1.mix(friction(b).1, friction(a).0, friction(b).0);
    assert_eq!((mix("foot", "world"), mix("torso", "world"), mix("foot", "torso")), (2.0, 1.0, 0.0));
}

/// Steps a scene at its own dt.
fn steps(path: &Path, options: &ImportOptions, count: u32) {
    let name = path.file_name().unwrap().to_string_lossy().into_owned();
    let import = import(path, options).unwrap_or_else(|e| panic!("{e}"));
    // What is written and read again is the same scene.
    let again = SceneFile::from_json(&import.scene.to_json(), &name).unwrap();
    assert_eq!(again, import.scene, "{name}");
    let mut scene = again.build().unwrap_or_else(|e| panic!("{name}: {e}"));
    for step in 0..count {
        scene.world.step(scene.dt);
        if let Some((_, body)) = scene.world.bodies().find(|(_, b)| !finite(b)) {
            panic!("{name}: {} is not finite after step {step}", body.name());
        }
    }
    sane(&name, &scene.world);
}

fn finite(body: &ishigaki::BodyState) -> bool {
    body.position().is_finite() && body.velocity().is_finite() && body.angular_velocity().is_finite()
}

/// Nothing has flown away.
fn sane(name: &str, world: &World) {
    for (_, body) in world.bodies() {
        assert!(body.position().length() < 100.0, "{name}: {} is at {}", body.name(), body.position());
    }
}

#[test]
fn mjcf_models_move_without_leaving_the_numbers() {
    let Some(folder) = models("gymnasium") else { return };
    for path in files(&folder, "xml") {
        steps(&path, &ImportOptions::default(), 200);
    }
}

#[test]
fn urdf_models_move_without_leaving_the_numbers() {
    let Some(folder) = models("example-robot-data") else { return };
    for robot in
        ["a1_description", "double_pendulum_description", "panda_description", "bolt_description", "solo_description"]
    {
        for path in files(&folder.join("robots").join(robot), "urdf") {
            steps(&path, &ImportOptions { ground: true, ..Default::default() }, 60);
        }
    }
}

#[test]
fn urdf_models_are_read_and_have_the_masses_of_their_links() {
    let Some(folder) = models("example-robot-data") else { return };
    let mut read = 0;
    for path in files(&folder, "urdf") {
        // A file with nothing but a comment, kept as in the package.
        let Ok(robot) = urdf_rs::read_file(&path) else { continue };
        let Import { scene, warnings } = import(&path, &ImportOptions::default()).unwrap_or_else(|e| panic!("{e}"));
        let links: f64 = robot.links.iter().map(|l| l.inertial.mass.value).sum();
        // Links that move without a mass are given 10 g each; the world does not count.
        let given = 0.01 * warnings.iter().filter(|w| w.contains("moves but has no mass")).count() as f64;
        let ours = total_mass(&scene);
        if scene.bodies.iter().all(|b| b.kind == BodyKind::Dynamic) {
            assert!(
                (ours - links - given).abs() < 1e-5 * links.max(1e-3),
                "{}: {ours} {links} {given}",
                path.display()
            );
        }
        read += 1;
    }
    assert!(read >= 30, "{read}");
}
