//! Island sleep (TALK D9): who falls asleep, what it costs, what wakes whom.
use ishigaki::*;

const DT: f32 = 1.0 / 60.0;

fn floor(world: &mut World) -> BodyHandle {
    world.add_body(Body::fixed(Shape::cuboid(20.0, 0.5, 20.0)).at(Vec3::new(0.0, -0.5, 0.0))).unwrap()
}

/// Cubes of 0.5 m on each other, lowest first.
fn stack(world: &mut World, x: f32, count: usize) -> Vec<BodyHandle> {
    let cube = |i: usize| Body::dynamic(Shape::cuboid(0.25, 0.25, 0.25)).at(Vec3::new(x, 0.25 + 0.5 * i as f32, 0.0));
    (0..count).map(|i| world.add_body(cube(i)).unwrap()).collect()
}

fn run(world: &mut World, steps: usize) {
    for _ in 0..steps {
        world.step(DT);
    }
}

fn asleep(world: &World, bodies: &[BodyHandle]) -> bool {
    bodies.iter().all(|&b| world.body(b).unwrap().is_asleep())
}

fn awake(world: &World, bodies: &[BodyHandle]) -> bool {
    bodies.iter().all(|&b| !world.body(b).unwrap().is_asleep())
}

/// A floor and three cubes that sleep on it.
fn sleeping() -> (World, BodyHandle, Vec<BodyHandle>) {
    let mut world = World::default();
    let ground = floor(&mut world);
    let cubes = stack(&mut world, 0.0, 3);
    run(&mut world, 120);
    assert!(asleep(&world, &cubes));
    (world, ground, cubes)
}

#[test]
fn an_island_sleeps_after_its_time_and_then_costs_nothing() {
    let mut world = World::default();
    floor(&mut world);
    let cubes = stack(&mut world, 0.0, 3);
    let steps = (world.options().rest.sleep.time / DT) as usize;
    run(&mut world, steps - 2);
    assert!(awake(&world, &cubes), "asleep before its time");
    run(&mut world, 62);
    assert!(asleep(&world, &cubes));
    let hash = world.state_hash();
    for _ in 0..100 {
        let report = world.step(DT);
        assert_eq!((report.rows, report.narrow_phase_calls, report.islands, report.asleep), (0, 0, 0, 3));
        assert!(world.events().is_empty());
    }
    assert_eq!(world.state_hash(), hash);
}

#[test]
fn a_ball_that_lands_on_it_wakes_all_of_it_and_not_before() {
    let (mut world, _, cubes) = sleeping();
    let ball = world.add_body(Body::dynamic(Shape::ball(0.2)).at(Vec3::new(0.0, 4.0, 0.0))).unwrap();
    for step in 0..120 {
        let was_asleep = asleep(&world, &cubes);
        world.step(DT);
        let touched = world.events().iter().any(|e| matches!(e, Event::ContactBegan { b, .. } if b.body == ball));
        if touched {
            assert!(awake(&world, &cubes));
            return;
        }
        // It wakes with the step in which they meet, one or two before the overlap is seen.
        let height = world.body(ball).unwrap().position().y - 0.2 - 1.5;
        assert!(was_asleep || height < 0.2, "woke at step {step}, {height} m above it");
    }
    panic!("never touched");
}

#[test]
fn a_support_that_goes_wakes_what_stood_on_it() {
    let (mut world, ground, cubes) = sleeping();
    assert!(world.remove_body(cubes[0]));
    world.step(DT);
    for &cube in &cubes[1..] {
        assert!(world.body(cube).unwrap().velocity().y < -0.1);
    }
    let (mut second, other_ground, cubes) = sleeping();
    assert!(second.remove_body(other_ground));
    second.step(DT);
    assert!(second.body(cubes[2]).unwrap().velocity().y < -0.1);
    let _ = ground;
}

#[test]
fn ground_that_is_moved_by_hand_wakes_what_stood_on_it() {
    let (mut world, ground, cubes) = sleeping();
    world.body_mut(ground).unwrap().set_pose(Pose::from_translation(Vec3::new(0.0, -3.0, 0.0))).unwrap();
    run(&mut world, 2);
    assert!(awake(&world, &cubes));
    assert!(world.body(cubes[0]).unwrap().velocity().y < -0.1);
}

#[test]
fn a_conveyor_started_under_it_wakes_and_moves_it() {
    let (mut world, ground, cubes) = sleeping();
    let belt = Material { surface_velocity: Vec3::X, ..Material::default() };
    assert!(world.body_mut(ground).unwrap().set_material(0, belt).unwrap());
    run(&mut world, 60);
    assert!(world.body(cubes[0]).unwrap().position().x > 0.3);
}

#[test]
fn forces_impulses_velocities_and_poses_wake_the_island() {
    let edits: [fn(&mut BodyMut); 7] = [
        |b| b.apply_force(Vec3::X).unwrap(),
        |b| b.apply_torque(Vec3::X).unwrap(),
        |b| b.apply_force_at(Vec3::X, Vec3::Y).unwrap(),
        |b| b.apply_impulse(Vec3::X).unwrap(),
        |b| b.apply_angular_impulse(Vec3::X).unwrap(),
        |b| b.set_velocity(Vec3::X).unwrap(),
        |b| b.set_pose(Pose::from_translation(Vec3::new(0.0, 1.3, 0.0))).unwrap(),
    ];
    for (i, edit) in edits.into_iter().enumerate() {
        let (mut world, _, cubes) = sleeping();
        edit(&mut world.body_mut(cubes[2]).unwrap());
        run(&mut world, 1);
        assert!(awake(&world, &cubes), "edit {i}");
    }
}

#[test]
fn joints_that_change_wake_what_hangs_on_them() {
    let hanging = || {
        let mut world = World::default();
        let hook = world.add_body(Body::fixed(Shape::ball(0.05)).at(Vec3::Y * 3.0)).unwrap();
        let arm = Body::dynamic(Shape::cuboid(0.05, 0.5, 0.05)).at(Vec3::Y * 2.5);
        let arm = world.add_body(arm).unwrap();
        let joint = world.add_joint(Joint::hinge(hook, arm, Vec3::Y * 3.0, Vec3::Z)).unwrap();
        run(&mut world, 60);
        assert!(asleep(&world, &[arm]));
        (world, arm, joint)
    };
    let (mut world, arm, joint) = hanging();
    assert!(world.remove_joint(joint));
    run(&mut world, 2);
    assert!(world.body(arm).unwrap().velocity().y < -0.1);

    let (mut world, arm, joint) = hanging();
    world.edit_joint(joint, |j| *j = j.clone().motor(2.0, 1000.0)).unwrap();
    run(&mut world, 10);
    assert!((world.body(arm).unwrap().angular_velocity().z - 2.0).abs() < 0.05);

    let (mut world, arm, _) = hanging();
    let post = world.add_body(Body::fixed(Shape::ball(0.05)).at(Vec3::new(3.0, 2.0, 0.0))).unwrap();
    world.add_joint(Joint::ball(post, arm, Vec3::new(3.0, 2.0, 0.0))).unwrap();
    assert!(awake(&world, &[arm]));
}

#[test]
fn a_platform_that_starts_under_it_wakes_it() {
    for by_velocity in [false, true] {
        let mut world = World::default();
        let platform = world.add_body(Body::kinematic(Shape::cuboid(1.0, 0.1, 1.0)).at(Vec3::Y * -0.1)).unwrap();
        let cubes = stack(&mut world, 0.0, 2);
        run(&mut world, 90);
        assert!(asleep(&world, &cubes));
        for i in 1..=30 {
            let mut body = world.body_mut(platform).unwrap();
            if by_velocity {
                body.set_velocity(Vec3::Y).unwrap();
            } else {
                let height = -0.1 + i as f32 * DT;
                body.set_kinematic_target(Pose::from_translation(Vec3::Y * height)).unwrap();
            }
            world.step(DT);
            assert!(awake(&world, &cubes));
        }
        let top = world.body(cubes[1]).unwrap();
        assert!((top.velocity().y - 1.0).abs() < 0.1, "{}", top.velocity().y);
        assert!((top.position().y - 0.75 - 0.5).abs() < 0.05, "{}", top.position().y);
    }
}

#[test]
fn a_slow_pull_by_a_joint_is_not_slept_through() {
    // 2 cm/s is under the speed of rest, but the hook moves on.
    let mut world = World::default();
    let hook = world.add_body(Body::kinematic(Shape::ball(0.05)).at(Vec3::Y)).unwrap();
    let bob = world.add_body(Body::dynamic(Shape::ball(0.1)).at(Vec3::Y * 0.5)).unwrap();
    world.add_joint(Joint::ball(hook, bob, Vec3::Y)).unwrap();
    world.body_mut(hook).unwrap().set_velocity(Vec3::X * 0.02).unwrap();
    run(&mut world, 300);
    let x = world.body(bob).unwrap().position().x;
    assert!((x - 0.1).abs() < 0.01, "{x}");
}

#[test]
fn new_options_wake_everything() {
    let (mut world, _, cubes) = sleeping();
    let mut options = world.options().clone();
    options.gravity = -options.gravity;
    world.set_options(options).unwrap();
    run(&mut world, 2);
    assert!(world.body(cubes[2]).unwrap().velocity().y > 0.1);

    let (mut world, _, cubes) = sleeping();
    let mut options = world.options().clone();
    options.rest.sleep.enabled = false;
    world.set_options(options).unwrap();
    run(&mut world, 120);
    assert!(awake(&world, &cubes));
}

#[test]
fn a_body_that_passes_without_touching_wakes_nobody() {
    let (mut world, _, cubes) = sleeping();
    // Its side runs 1 cm past the cubes: within the margin in which contacts are made.
    let start = Vec3::new(0.25 + 0.01 + 0.1, 0.75, -0.6);
    let body = Body::dynamic(Shape::ball(0.1)).at(start).velocity(Vec3::Z * 0.6).gravity_scale(0.0);
    let passer = world.add_body(body).unwrap();
    let mut near = false;
    for _ in 0..120 {
        let report = world.step(DT);
        near |= report.contacts > 3;
        assert!(asleep(&world, &cubes));
    }
    assert!(near, "never came near");
    assert!((world.body(passer).unwrap().velocity() - Vec3::Z * 0.6).length() < 1e-5);
}

#[test]
fn the_ground_connects_no_islands() {
    let (mut world, _, first) = sleeping();
    let second = stack(&mut world, 3.0, 2);
    let report = world.step(DT);
    assert_eq!(report.islands, 1);
    assert!(asleep(&world, &first) && awake(&world, &second));
    world.body_mut(first[0]).unwrap().apply_impulse(Vec3::Y).unwrap();
    assert_eq!(world.step(DT).islands, 2);
}

#[test]
fn a_sleepless_body_keeps_its_island_awake_and_no_other() {
    let mut world = World::default();
    floor(&mut world);
    let first = stack(&mut world, 0.0, 2);
    let other = stack(&mut world, 3.0, 2);
    let guard = Body::dynamic(Shape::cuboid(0.25, 0.25, 0.25)).at(Vec3::new(0.0, 1.25, 0.0)).sleepless();
    let guard = world.add_body(guard).unwrap();
    run(&mut world, 180);
    assert!(awake(&world, &[first[0], first[1], guard]));
    assert!(asleep(&world, &other));
}

#[test]
fn a_user_may_put_a_body_to_sleep() {
    let mut world = World::default();
    let ball = world.add_body(Body::dynamic(Shape::ball(0.5)).at(Vec3::Y * 5.0)).unwrap();
    world.body_mut(ball).unwrap().sleep();
    run(&mut world, 60);
    assert_eq!(world.body(ball).unwrap().position(), Vec3::Y * 5.0);
    world.body_mut(ball).unwrap().apply_force(Vec3::ZERO).unwrap();
    run(&mut world, 1);
    assert!(world.body(ball).unwrap().velocity().y < 0.0);
}

/// What rests keeps its entry in the search for contacts from step to step: it must be made anew when a shelf is moved,
/// when a sleeper wakes, when a slot is used again; and a restored world, which has no entries, must go on with the same bits.
#[test]
fn what_rests_is_found_where_it_is() {
    let mut world = World::default();
    floor(&mut world);
    let shelf = |at: Vec3| Body::fixed(Shape::cuboid(1.0, 0.1, 1.0)).at(at);
    let moved = world.add_body(shelf(Vec3::new(-8.0, 3.0, 0.0))).unwrap();
    let removed = world.add_body(shelf(Vec3::new(8.0, 3.0, 0.0))).unwrap();
    let sleeper = stack(&mut world, 0.0, 1)[0];
    run(&mut world, 120);
    assert!(asleep(&world, &[sleeper]));
    let from_snapshot = World::restore(&world.snapshot()).unwrap();
    let places = [Vec3::new(-4.0, 2.0, 0.0), Vec3::new(4.0, 1.0, 0.0), Vec3::new(0.0, 0.0, 0.0)];
    let heights = [2.1, 1.1, 0.5].map(|top| top + 0.25);
    let go_on = |mut world: World| {
        let at = Pose::from_parts(places[0], Quat::IDENTITY);
        world.body_mut(moved).unwrap().set_pose(at).unwrap();
        world.remove_body(removed);
        world.add_body(shelf(places[1])).unwrap();
        let ball = |at: Vec3| Body::dynamic(Shape::ball(0.25)).at(at + 4.0 * Vec3::Y);
        let balls = places.map(|at| world.add_body(ball(at)).unwrap());
        run(&mut world, 180);
        for (ball, height) in balls.into_iter().zip(heights) {
            let center = world.body(ball).unwrap().center();
            assert!((center.y - height).abs() < 0.01, "rests at {center}, not at {height}");
        }
        world.state_hash()
    };
    assert_eq!(go_on(world), go_on(from_snapshot));
}
