//! The named scenes are what their documentation says.

use ishigaki::{BodyKind, Vec3};
use ishigaki_scenes::{Meter, Scene, SceneFile, list, named};

fn scene(name: &str, parameters: &[(&str, f64)]) -> (SceneFile, Scene) {
    let parameters: Vec<(String, f64)> = parameters.iter().map(|(n, v)| (n.to_string(), *v)).collect();
    let file = named(name, &parameters).unwrap();
    let scene = file.build().unwrap_or_else(|e| panic!("{name} {parameters:?}: {e}"));
    (file, scene)
}

/// Dynamic bodies and their mass, kg.
fn dynamic(scene: &Scene) -> (usize, f64) {
    let bodies = scene.world.bodies().filter(|(_, b)| b.kind() == BodyKind::Dynamic);
    bodies.fold((0, 0.0), |(n, mass), (_, b)| (n + 1, mass + b.mass() as f64))
}

#[track_caller]
fn assert_near(value: f64, expected: f64, relative: f64) {
    assert!((value - expected).abs() <= relative * expected.abs(), "{value} is not {expected}");
}

/// The smallest scene each parameter allows, the largest of moderate size, and the defaults.
#[test]
fn every_scene_builds_and_round_trips() {
    for info in list() {
        let with = |pick: &dyn Fn(&ishigaki_scenes::Parameter) -> f64| -> Vec<(String, f64)> {
            info.parameters.iter().map(|p| (p.name.to_string(), pick(p))).collect()
        };
        // The greatest counts are for people with time: here all counts of a scene together stay moderate.
        let most = [1000.0, 30.0, 12.0][info.parameters.iter().filter(|p| p.whole).count().clamp(1, 3) - 1];
        for parameters in
            [Vec::new(), with(&|p| p.range.0), with(&|p| if p.whole { p.range.1.min(most) } else { p.range.1 })]
        {
            // n × n balls, base²/2 boxes.
            let parameters: Vec<(String, f64)> = parameters
                .into_iter()
                .map(
                    |(n, v)| {
                        if info.name == "joint_grid" || info.name == "pyramid" { (n, v.min(60.0)) } else { (n, v) }
                    },
                )
                .map(|(n, v)| if info.name == "card_house" { (n, v.min(20.0)) } else { (n, v) })
                .collect();
            let file = named(info.name, &parameters).unwrap();
            assert_eq!(file.name, info.name);
            assert_eq!(file.description, info.summary);
            assert_eq!(SceneFile::from_json(&file.to_json(), info.name).unwrap(), file, "{} {parameters:?}", info.name);
            let scene = file.build().unwrap_or_else(|e| panic!("{} {parameters:?}: {e}", info.name));
            assert_eq!(scene.bodies.len(), file.bodies.len());
            assert_eq!(scene.joints.len(), file.joints.len());
        }
    }
}

#[test]
fn equal_calls_give_equal_scenes() {
    for info in list() {
        assert_eq!(named(info.name, &[]).unwrap(), named(info.name, &[]).unwrap());
    }
}

#[test]
fn defaults_are_within_range_and_names_are_unique() {
    for (i, info) in list().iter().enumerate() {
        assert!(list()[..i].iter().all(|other| other.name != info.name));
        for (j, p) in info.parameters.iter().enumerate() {
            assert!(p.range.0 <= p.default && p.default <= p.range.1, "{}.{}", info.name, p.name);
            assert!(!p.whole || p.default.fract() == 0.0, "{}.{}", info.name, p.name);
            assert!(info.parameters[..j].iter().all(|other| other.name != p.name));
        }
    }
}

#[test]
fn the_scenes_are_those_of_the_documentation() {
    let names: Vec<&str> = list().iter().map(|s| s.name).collect();
    let mut expected = vec![
        "tower",
        "wall",
        "pyramid",
        "many_pyramids",
        "arch",
        "card_house",
        "dominoes",
        "overhang",
        "ragdoll",
        "ragdolls",
        "chain",
        "joint_grid",
        "bridge",
        "newtons_cradle",
        "heavy_on_light",
        "pile",
        "dzhanibekov",
        "spinning_top",
        "sliding_block",
        "plank_on_two_towers",
        "scale_under_stack",
    ];
    expected.sort_unstable();
    let mut sorted = names.clone();
    sorted.sort_unstable();
    assert_eq!(sorted, expected);
}

/// Scene, parameters; dynamic bodies, their mass in kg, joints.
type Census<'a> = (&'a str, &'a [(&'a str, f64)], usize, f64, usize);

#[test]
fn counts_and_masses() {
    let cases: &[Census] = &[
        ("tower", &[("n", 7.0)], 7, 7_000.0, 0),
        // Two courses of 4 bricks of 250 kg, one with two halves.
        ("wall", &[("columns", 4.0), ("rows", 2.0)], 4 + 5, 2_000.0, 0),
        ("pyramid", &[("base", 100.0)], 5_050, 5_050_000.0, 0),
        ("many_pyramids", &[("rows", 2.0), ("columns", 3.0), ("base", 4.0)], 60, 60_000.0, 0),
        ("card_house", &[("floors", 3.0)], 15, 15.0 * 0.88 * 0.63 * 0.03 * 800.0, 0),
        ("dominoes", &[("n", 9.0)], 9, 900.0, 0),
        ("overhang", &[("n", 6.0)], 6, 300.0, 0),
        ("ragdoll", &[], 11, 70.0, 10),
        ("ragdolls", &[("n", 3.0)], 33, 210.0, 30),
        // A link is a cylinder of 0.8 m and a ball, radius 0.1 m.
        ("chain", &[("links", 5.0), ("end_mass_ratio", 100.0)], 6, 105.0 * 29.3215, 6),
        ("joint_grid", &[("n", 4.0)], 12, 12.0 * 268.083, 9 + 12),
        ("bridge", &[("planks", 8.0)], 8 + 3, 8.0 * 180.0 + 3.0 * 62.5, 9),
        ("newtons_cradle", &[("balls", 5.0)], 5, 5.0 * 7800.0 * 4.18879e-3, 5),
        ("heavy_on_light", &[("n", 3.0), ("ratio", 50.0)], 3, 52_000.0, 0),
        ("dzhanibekov", &[], 1, 1.0, 0),
        ("spinning_top", &[], 1, 1.0, 1),
        ("sliding_block", &[], 1, 200.0, 0),
        // Two towers of 3 m³, a plank of 3 m³.
        ("plank_on_two_towers", &[("left", 2.0), ("right", 5.0)], 8, 6_000.0 + 60_000.0, 0),
        ("scale_under_stack", &[("n", 4.0)], 4, 4_000.0, 0),
    ];
    for &(name, parameters, bodies, mass, joints) in cases {
        let (_, scene) = scene(name, parameters);
        let (count, sum) = dynamic(&scene);
        assert_eq!(count, bodies, "{name}");
        assert_eq!(scene.joints.len(), joints, "{name}");
        assert_near(sum, mass, 1e-4);
    }
}

/// The arch's stones are a half ring: volume π R t d, a little more for the overlap of 5 mm at each of n + 1 joints.
#[test]
fn an_arch_is_a_half_ring() {
    let (stones, thickness) = (41, 0.2);
    let (_, scene) = scene("arch", &[("stones", stones as f64), ("thickness", thickness)]);
    let (count, mass) = dynamic(&scene);
    assert_eq!(count, stones);
    let (radius, depth, t) = (10.0, 2.0, 10.0 * thickness);
    // A polygon of n trapezoids: its area is that of the ring times sin(2h)/(2h), h = π/(2n).
    let angle = std::f64::consts::PI / stones as f64;
    let ring = std::f64::consts::PI * radius * t * angle.sin() / angle;
    let overlap = stones as f64 * 0.005 * t;
    assert_near(mass, 1000.0 * depth * (ring + overlap), 1e-3);
}

/// No scene starts with more overlap than the slop, and none explodes: the first step moves nothing by itself.
#[test]
fn scenes_start_without_overlap() {
    for info in list() {
        let mut scene = named(info.name, &[]).unwrap().build().unwrap();
        let slop = scene.world.options().solver.slop.depth * scene.world.options().length_scale;
        scene.world.step(scene.dt);
        let report = scene.world.report();
        assert!(report.max_penetration < slop + 1e-3, "{}: {} m", info.name, report.max_penetration);
        assert!(report.max_joint_error < 1e-3, "{}: {} m", info.name, report.max_joint_error);
        assert!(report.non_finite.is_empty(), "{}", info.name);
    }
}

/// A tower at rest stands; one that is thrown down does not.
#[test]
fn the_meter_sees_what_stands() {
    let (_, mut standing) = scene("tower", &[("n", 2.0)]);
    let mut meter = Meter::new(&standing.world);
    for _ in 0..90 {
        standing.world.step(standing.dt);
        meter.observe(&standing.world);
    }
    let seen = meter.measure();
    assert!(seen.stands && seen.greatest_move < 0.02 && seen.drift < 0.01 && seen.pen < 0.01, "{seen:?}");
    assert!(seen.rest_time.is_some_and(|t| t < 1.0), "{seen:?}");

    let (_, mut thrown) = scene("tower", &[("n", 2.0)]);
    let top = thrown.bodies[2].1;
    thrown.world.body_mut(top).unwrap().set_velocity(Vec3::new(3.0, 0.0, 4.0)).unwrap();
    let mut meter = Meter::new(&thrown.world);
    for _ in 0..20 {
        thrown.world.step(thrown.dt);
        meter.observe(&thrown.world);
    }
    let seen = meter.measure();
    assert!(!seen.stands && seen.rest_time.is_none(), "{seen:?}");
    // A cube of 1 m: the greatest move is at least the drift, in edges and in meters alike.
    assert!(seen.drift > 0.5 && seen.greatest_move >= seen.drift, "{seen:?}");
}

/// Neighbors in a row touch, each box above the ground touches two below: base + 3 base (base − 1)/2 pairs.
#[test]
fn a_pyramid_has_as_many_manifolds_as_it_should() {
    let (_, mut scene) = scene("pyramid", &[("base", 100.0)]);
    assert_eq!(scene.world.step(scene.dt).contacts, 14_950);
}

/// One in, one out, for ten seconds: nine times a ball rises to the height from which the first one fell.
#[test]
fn a_cradle_goes_on() {
    let (_, mut scene) = scene("newtons_cradle", &[]);
    let height = |scene: &Scene, k: usize| {
        f64::from(scene.world.body(scene.body(&format!("body{k}")).unwrap()).unwrap().center().y) - 1.0
    };
    let start = height(&scene, 1);
    let (mut peaks, mut before) = (Vec::new(), [start, start]);
    while scene.world.time() < 10.0 {
        scene.world.step(scene.dt);
        let outer = height(&scene, 1).max(height(&scene, 5));
        if before[1] > before[0] && before[1] > outer && before[1] > 0.5 * start {
            peaks.push(before[1] / start);
        }
        before = [before[1], outer];
        assert!((2..=4).all(|k| height(&scene, k) < 1e-3 * start), "a middle ball moved at {} s", scene.world.time());
    }
    eprintln!("cradle: {peaks:.4?} of the height");
    assert!(peaks.len() == 9 && peaks.iter().all(|peak| (peak - 1.0).abs() < 0.02), "{peaks:?}");
}

/// A fixed scale under boxes at rest reads their weight.
#[test]
fn a_scale_reads_the_weight() {
    let (_, mut scene) = scene("scale_under_stack", &[("n", 3.0)]);
    let scale = scene.body("scale").unwrap();
    for _ in 0..60 {
        scene.world.step(scene.dt);
    }
    let force = ishigaki_scenes::measure::contact_force(&scene.world, scale, scene.dt);
    assert_near(-force.y as f64, 3.0 * 9810.0, 0.01);
}
