//! Aggressive sleep (TALK D10): resting pairs keep their rows, and there is no wrong rest.
use ishigaki::*;

const DT: f32 = 1.0 / 60.0;

fn world(aggressive: bool) -> World {
    let mut options = WorldOptions::default();
    options.rest.sleep.enabled = false;
    options.rest.aggressive_sleep.enabled = aggressive;
    World::new(options).unwrap()
}

fn floor(world: &mut World) -> BodyHandle {
    world.add_body(Body::fixed(Shape::cuboid(20.0, 0.5, 20.0)).at(Vec3::new(0.0, -0.5, 0.0))).unwrap()
}

fn tower(world: &mut World, count: usize) -> Vec<BodyHandle> {
    let cube = |i: usize| Body::dynamic(Shape::cuboid(0.25, 0.25, 0.25)).at(Vec3::new(0.0, 0.25 + 0.5 * i as f32, 0.0));
    (0..count).map(|i| world.add_body(cube(i)).unwrap()).collect()
}

/// Five rows of bricks in running bond.
fn wall(world: &mut World) -> Vec<BodyHandle> {
    let mut bricks = Vec::new();
    for row in 0..5 {
        for column in 0..(5 - row % 2) {
            let x = 0.42 * column as f32 + 0.21 * (row % 2) as f32;
            let at = Vec3::new(x, 0.1 + 0.2 * row as f32, 0.0);
            bricks.push(world.add_body(Body::dynamic(Shape::cuboid(0.2, 0.1, 0.1)).at(at)).unwrap());
        }
    }
    bricks
}

fn run(world: &mut World, steps: usize) {
    for _ in 0..steps {
        world.step(DT);
    }
}

fn ids(world: &World) -> Vec<u64> {
    let points = world.contacts().flat_map(|c| c.manifolds.iter().flat_map(|m| m.points.iter()));
    points
        .map(|p| serde_json::to_string(&p.id).unwrap().bytes().fold(7, |h: u64, b| h.wrapping_mul(31) + u64::from(b)))
        .collect()
}

/// What a settled wall does in a second: narrow phase calls, changes of the set of ids, mean of the greatest speeds.
fn settled_wall(aggressive: bool) -> (usize, usize, f32) {
    let mut world = world(aggressive);
    floor(&mut world);
    wall(&mut world);
    run(&mut world, 720);
    let (mut calls, mut changes, mut speed) = (0, 0, 0.0);
    let mut last = ids(&world);
    for _ in 0..60 {
        let report = world.step(DT);
        calls += report.narrow_phase_calls;
        speed += report.max_speed / 60.0;
        let now = ids(&world);
        changes += usize::from(now != last);
        last = now;
    }
    (calls, changes, speed)
}

#[test]
fn a_settled_wall_needs_no_narrow_phase_and_is_no_less_calm() {
    let (calls, changes, speed) = settled_wall(true);
    let (all_calls, _, all_speed) = settled_wall(false);
    assert!(calls * 10 <= all_calls, "{calls} of {all_calls}");
    assert_eq!(changes, 0, "contact ids churn");
    // Both rest, to a tenth of a millimeter a second: how far below that is up to the last bits.
    assert!(speed <= all_speed.max(1e-4), "{speed} against {all_speed}");
}

#[test]
fn impulses_are_those_of_an_unfrozen_run() {
    let sums = |aggressive| {
        let mut world = world(aggressive);
        floor(&mut world);
        tower(&mut world, 5);
        run(&mut world, 300);
        assert_eq!(world.report().frozen > 0, aggressive);
        let sum = |c: ContactView<'_>| -> f32 { c.manifolds.iter().flat_map(|m| &m.points).map(|p| p.impulse).sum() };
        world.contacts().map(sum).collect::<Vec<f32>>()
    };
    let (frozen, free) = (sums(true), sums(false));
    assert_eq!(frozen.len(), 5);
    let weight = 1000.0 * 0.125 * 9.81 * DT;
    for (i, (a, b)) in frozen.iter().zip(&free).enumerate() {
        let carried = weight * (5 - i) as f32;
        assert!((a - b).abs() < 0.01 * carried, "contact {i}: {a} frozen, {b} free");
        assert!((a - carried).abs() < 0.01 * carried, "contact {i}: {a} of {carried} N·s");
    }
}

/// A tower whose pairs are all frozen.
fn frozen_tower() -> (World, BodyHandle, Vec<BodyHandle>) {
    let mut world = world(true);
    let ground = floor(&mut world);
    let cubes = tower(&mut world, 3);
    run(&mut world, 120);
    assert_eq!(world.report().frozen, 3);
    (world, ground, cubes)
}

#[test]
fn a_pile_falls_in_the_step_after_its_support_is_removed() {
    let (mut world, _, cubes) = frozen_tower();
    world.remove_body(cubes[0]);
    world.step(DT);
    for &cube in &cubes[1..] {
        let fall = world.body(cube).unwrap().velocity().y;
        assert!((fall + 9.81 * DT).abs() < 5e-3, "{fall}");
    }
}

#[test]
fn a_conveyor_started_under_a_frozen_box_moves_it() {
    let mut world = world(true);
    let ground = floor(&mut world);
    let cube = tower(&mut world, 1)[0];
    run(&mut world, 60);
    assert_eq!(world.report().frozen, 1);
    let belt = Material { surface_velocity: Vec3::X, ..Material::default() };
    world.body_mut(ground).unwrap().set_material(0, belt).unwrap();
    run(&mut world, 60);
    let velocity = world.body(cube).unwrap().velocity();
    assert!((velocity - Vec3::X).length() < 0.02, "{velocity}");
}

#[test]
fn a_slope_tilted_beyond_friction_lets_the_box_slide() {
    let slide = |angle: f32| {
        let mut world = world(true);
        let slope = world.add_body(Body::kinematic(Shape::cuboid(5.0, 0.5, 5.0)).at(Vec3::Y * -0.5)).unwrap();
        let cube = tower(&mut world, 1)[0];
        run(&mut world, 60);
        assert_eq!(world.report().frozen, 1);
        for i in 1..=240 {
            let tilt = Quat::from_rotation_z(angle * (i as f32 / 240.0).min(1.0));
            // About the middle of its upper side.
            let pose = Pose::from_parts(tilt * (Vec3::Y * -0.5), tilt);
            world.body_mut(slope).unwrap().set_kinematic_target(pose).unwrap();
            world.step(DT);
        }
        let before = world.body(cube).unwrap().position();
        run(&mut world, 60);
        (world.body(cube).unwrap().position() - before).length()
    };
    // μ = 0.6 = tan 31°.
    let (holds, slides) = (slide(28_f32.to_radians()), slide(36_f32.to_radians()));
    assert!(holds < 1e-3, "{holds}");
    assert!(slides > 0.3, "{slides}");
}

#[test]
fn what_is_pushed_or_edited_thaws() {
    let (mut world, _, cubes) = frozen_tower();
    world.body_mut(cubes[2]).unwrap().apply_force(Vec3::ZERO).unwrap();
    assert_eq!(world.step(DT).frozen, 2, "the pair of the edited cube thaws, the others stay");
    run(&mut world, 30);
    assert_eq!(world.report().frozen, 3);
    let weight = 125.0 * 9.81;
    for _ in 0..30 {
        world.body_mut(cubes[2]).unwrap().apply_force(Vec3::X * (0.8 * weight)).unwrap();
        world.step(DT);
    }
    assert!(world.body(cubes[2]).unwrap().position().x > 0.1, "stuck");
}

#[test]
fn a_new_contact_thaws_the_pairs_of_its_body() {
    let (mut world, _, cubes) = frozen_tower();
    let ball = world.add_body(Body::dynamic(Shape::ball(0.1)).at(Vec3::new(0.0, 1.65, 0.0))).unwrap();
    for _ in 0..60 {
        world.step(DT);
        let began = world.events().iter().any(|e| matches!(e, Event::ContactBegan { b, .. } if b.body == ball));
        if began {
            // Seen in this step, thawed in the next at the latest.
            let report = world.step(DT);
            assert!(report.frozen <= 2, "{}", report.frozen);
            let pair = world.contacts().find(|c| c.a.body == cubes[1] && c.b.body == cubes[2]).unwrap();
            assert!(!pair.frozen);
            return;
        }
    }
    panic!("never landed");
}

#[test]
fn nothing_creeps_in_half_a_minute() {
    let mut world = world(true);
    floor(&mut world);
    let mut bodies = wall(&mut world);
    // A box on a slope of 20° is held by friction alone.
    let tilt = Quat::from_rotation_z(20_f32.to_radians());
    let place = Vec3::new(6.0, 2.0, 0.0);
    world.add_body(Body::fixed(Shape::cuboid(2.0, 0.5, 2.0)).at(place).rotated(tilt)).unwrap();
    let above = place + tilt * Vec3::Y * 0.75;
    bodies.push(world.add_body(Body::dynamic(Shape::cuboid(0.25, 0.25, 0.25)).at(above).rotated(tilt)).unwrap());
    run(&mut world, 180);
    let before: Vec<Vec3> = bodies.iter().map(|&b| world.body(b).unwrap().position()).collect();
    run(&mut world, 1800);
    for (i, (&body, before)) in bodies.iter().zip(before).enumerate() {
        let drift = (world.body(body).unwrap().position() - before).length();
        assert!(drift < 1e-3, "body {i} crept {drift} m");
    }
}
