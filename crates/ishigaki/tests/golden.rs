//! The same bits everywhere: hashes of the states of four scenes against stored ones.
//!
//! `golden.txt` holds a line for each scene and each twentieth step. It is the same for every build profile.
//! A change of the engine that changes results on purpose is blessed:
//! `ISHIGAKI_BLESS=1 cargo test -p ishigaki --test golden`.
use ishigaki::math::rotation_from_vector;
use ishigaki::*;
use std::fmt::Write;
use std::path::Path;

const DT: f32 = 1.0 / 60.0;
const STEPS: usize = 200;
const EVERY: usize = 20;

/// Eight boxes on each other, each a little off.
fn stack() -> World {
    let mut world = World::default();
    world.add_body(Body::fixed(Shape::cuboid(10.0, 0.5, 10.0)).at(Vec3::Y * -0.5)).unwrap();
    for i in 0..8 {
        let at = Vec3::new(0.03 * (i % 3) as f32, 0.3 + 0.51 * i as f32, 0.02 * (i % 2) as f32);
        let turn = rotation_from_vector(Vec3::Y * (0.2 * i as f32));
        world.add_body(Body::dynamic(Shape::cuboid(0.25, 0.25, 0.25)).at(at).rotated(turn)).unwrap();
    }
    world
}

/// Capsules on every kind of joint, thrown onto a slope.
fn chain() -> World {
    let mut world = World::default();
    let slope = rotation_from_vector(Vec3::new(0.0, 0.0, -0.3));
    world.add_body(Body::fixed(Shape::half_space(Vec3::Y)).rotated(slope)).unwrap();
    let limb = |i: usize| {
        let along = rotation_from_vector(Vec3::Z * std::f32::consts::FRAC_PI_2);
        Body::dynamic(Shape::capsule(0.15, 0.08)).at(Vec3::new(0.5 * i as f32, 2.0, 0.0)).rotated(along)
    };
    let limbs: Vec<_> = (0..7).map(|i| world.add_body(limb(i).velocity(Vec3::new(0.0, 0.0, 1.0))).unwrap()).collect();
    let drive = Drive { limit: Some(Range::from(-0.4..=0.4)), ..Drive::default() };
    for (i, pair) in limbs.windows(2).enumerate() {
        let (a, b, at) = (pair[0], pair[1], Vec3::new(0.25 + 0.5 * i as f32, 2.0, 0.0));
        let joint = match i {
            0 => Joint::ball_about(a, b, at, Vec3::X).cone(0.6).limit(-0.3..=0.3),
            1 => Joint::hinge(a, b, at, Vec3::Z).limit(-1.0..=0.2).motor(1.0, 5.0),
            2 => Joint::slider(a, b, at, Vec3::X).limit(-0.1..=0.1).spring(0.0, 500.0, 5.0),
            3 => Joint::fixed(a, b, at),
            4 => Joint::rope(a, b, Vec3::ZERO, Vec3::ZERO, 0.7),
            _ => {
                let axes = [Vec3::X, Vec3::Z].map(|axis| TurnAxis { axis, drive });
                Joint::generic(a, b, Pose::from_translation(at), [Freedom::Locked; 3], axes.to_vec())
            }
        };
        world.add_joint(joint).unwrap();
    }
    world
}

/// Every kind of shape, falling into a bumpy pit.
fn pile() -> World {
    let mut world = World::default();
    let bumps = (0..81).map(|i| 0.15 * ((i * 7) % 5) as f32).collect();
    world.add_body(Body::fixed(Shape::height_field(9, 9, bumps, 6.0, 6.0).unwrap())).unwrap();
    let wall = vec![Vec3::new(-3.0, -1.0, -3.0), Vec3::new(-3.0, -1.0, 3.0), Vec3::new(-3.0, 4.0, 0.0)];
    world.add_body(Body::fixed(Shape::triangle_mesh(wall, vec![[0, 2, 1]]).unwrap())).unwrap();
    let corners = [1.0_f32, -1.0];
    let gem: Vec<Vec3> =
        corners.iter().flat_map(|&s| [Vec3::X * 0.3 * s, Vec3::Y * 0.2 * s, Vec3::new(0.1, 0.1, 0.25) * s]).collect();
    let shapes = [
        Shape::ball(0.2),
        Shape::cuboid(0.2, 0.15, 0.25),
        Shape::capsule(0.2, 0.12),
        Shape::cylinder(0.2, 0.15),
        Shape::cone(0.25, 0.2),
        Shape::convex_hull(&gem).unwrap(),
        Shape::compound(vec![Shape::cuboid(0.3, 0.05, 0.05), Shape::ball(0.12).at(Vec3::X * 0.3)]),
    ];
    for i in 0..21 {
        let at = Vec3::new(-1.5 + 0.5 * (i % 7) as f32, 1.0 + 0.6 * (i / 7) as f32, -0.5 + 0.4 * (i % 3) as f32);
        let turn = rotation_from_vector(Vec3::new(0.3, 0.5, 0.1) * i as f32);
        world.add_body(Body::dynamic(shapes[i % 7].clone()).at(at).rotated(turn)).unwrap();
    }
    world
}

/// Tops, a tumbling card, bouncing and swept balls, a turning paddle.
fn spin() -> World {
    let mut world = World::default();
    world.add_body(Body::fixed(Shape::half_space(Vec3::Y)).restitution(0.6)).unwrap();
    world.add_body(Body::fixed(Shape::cuboid(0.02, 2.0, 2.0)).at(Vec3::new(6.0, 2.0, 0.0))).unwrap();
    let paddle = Body::kinematic(Shape::cuboid(1.5, 0.1, 0.2)).at(Vec3::Y * 0.5).angular_velocity(Vec3::Y * 3.0);
    world.add_body(paddle).unwrap();
    let top = Body::dynamic(Shape::cone(0.3, 0.3)).rotated(rotation_from_vector(Vec3::X * 3.0));
    world.add_body(top.at(Vec3::new(-2.0, 0.4, 0.0)).angular_velocity(Vec3::Y * 60.0)).unwrap();
    let card = Body::dynamic(Shape::cuboid(0.3, 0.01, 0.2)).at(Vec3::new(0.0, 3.0, 0.0));
    world.add_body(card.angular_velocity(Vec3::new(0.1, 5.0, 20.0)).damping(0.1, 0.2)).unwrap();
    for i in 0..5 {
        let ball = Body::dynamic(Shape::ball(0.1)).at(Vec3::new(0.5, 1.0 + 0.25 * i as f32, 0.1 * i as f32));
        world.add_body(ball.velocity(Vec3::new(40.0 * i as f32, 1.0, 0.0)).restitution(0.7).continuous()).unwrap();
    }
    world
}

type Scene = (&'static str, fn() -> World);
const SCENES: [Scene; 4] = [("stack", stack), ("chain", chain), ("pile", pile), ("spin", spin)];

fn hashes((name, make): Scene) -> String {
    let mut world = make();
    let mut text = String::new();
    for step in 1..=STEPS {
        let report = world.step(DT);
        assert!(report.non_finite.is_empty(), "{name}: not finite after step {step}");
        if step % EVERY == 0 {
            writeln!(text, "{name} {step} {:016x}", world.state_hash()).unwrap();
        }
    }
    text
}

#[test]
fn states_are_the_stored_ones_to_the_last_bit() {
    const BLESS: &str = "ISHIGAKI_BLESS=1 cargo test -p ishigaki --test golden";
    // Another package runs this file as well.
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../ishigaki/tests/golden.txt");
    let now: String = SCENES.into_iter().map(hashes).collect();
    if std::env::var_os("ISHIGAKI_BLESS").is_some() {
        std::fs::write(&path, &now).unwrap();
        return;
    }
    let stored = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}; make it: {BLESS}", path.display()));
    let mut stored = stored.lines();
    let mut differing: Vec<(&str, &str)> = Vec::new();
    for line in now.lines() {
        let (scene, rest) = line.split_once(' ').unwrap();
        let (step, _) = rest.split_once(' ').unwrap();
        if stored.next() != Some(line) && differing.last().is_none_or(|(last, _)| *last != scene) {
            differing.push((scene, step));
        }
    }
    let mut message = String::new();
    for (scene, step) in &differing {
        let before = step.parse::<usize>().unwrap() - EVERY;
        writeln!(message, "scene {scene}: the state differs at step {step}, and was the stored one at step {before}")
            .unwrap();
    }
    assert!(differing.is_empty() && stored.next().is_none(), "\n{message}If this is meant to be, bless it: {BLESS}\n");
}
