//! Bodies that their user moves: targets are met exactly, what they touch is moved by their velocity.
use ishigaki::*;

const DT: f32 = 1.0 / 60.0;

fn plate(world: &mut World) -> BodyHandle {
    world.add_body(Body::kinematic(Shape::cuboid(2.0, 0.25, 2.0)).at(Vec3::Y * -0.25)).unwrap()
}

#[test]
fn a_target_is_reached_exactly_and_then_it_stops() {
    let mut world = World::default();
    // Its center of mass is not its origin.
    let body = Body::kinematic(Shape::cuboid(0.5, 0.5, 0.5).at(Vec3::new(0.3, 0.2, 0.1)));
    let body = world.add_body(body).unwrap();
    for i in 1..=20 {
        let turn = Quat::from_rotation_y(0.2 * i as f32) * Quat::from_rotation_x(0.1 * i as f32);
        let target = Pose::from_parts(Vec3::new(0.1 * i as f32, 1.0, -0.05 * i as f32), turn);
        world.body_mut(body).unwrap().set_kinematic_target(target).unwrap();
        world.step(DT);
        let pose = world.body(body).unwrap().pose();
        assert!((pose.translation - target.translation).length() < 1e-6);
        assert!(pose.rotation.angle_between(target.rotation) < 1e-3);
        // The velocity is that of the motion: of the center.
        assert!(world.body(body).unwrap().velocity().length() > 1.0);
    }
    let stop = world.body(body).unwrap().pose();
    for _ in 0..10 {
        world.step(DT);
        let now = world.body(body).unwrap();
        assert_eq!((now.pose(), now.velocity(), now.angular_velocity()), (stop, Vec3::ZERO, Vec3::ZERO));
    }
}

#[test]
fn a_velocity_given_by_hand_lasts_even_after_a_target() {
    let mut world = World::default();
    let body = plate(&mut world);
    world.body_mut(body).unwrap().set_kinematic_target(Pose::from_translation(Vec3::Y * -0.2)).unwrap();
    world.step(DT);
    world.body_mut(body).unwrap().set_velocity(Vec3::X).unwrap();
    for _ in 0..60 {
        world.step(DT);
    }
    let x = world.body(body).unwrap().position().x;
    assert!((x - 1.0).abs() < 1e-4, "{x}");
}

#[test]
fn a_box_is_carried_by_friction() {
    let mut world = World::default();
    let plate = plate(&mut world);
    let cube = world.add_body(Body::dynamic(Shape::cuboid(0.2, 0.2, 0.2)).at(Vec3::Y * 0.2)).unwrap();
    // Speeds up by 2 m/s² < μg, then goes on at 1 m/s.
    let (mut x, mut v) = (0.0, 0.0_f32);
    for _ in 0..120 {
        v = (v + 2.0 * DT).min(1.0);
        x += v * DT;
        world.body_mut(plate).unwrap().set_kinematic_target(Pose::from_translation(Vec3::new(x, -0.25, 0.0))).unwrap();
        world.step(DT);
    }
    let state = world.body(cube).unwrap();
    assert!((state.position().x - x).abs() < 0.01, "{} of {x}", state.position().x);
    assert!((state.velocity() - Vec3::X).length() < 0.01, "{}", state.velocity());
}

#[test]
fn a_turntable_carries_a_box_around() {
    let mut world = World::default();
    let table = plate(&mut world);
    // −Z is the way the table goes at +X; from rest it would slip at first.
    let cube = Body::dynamic(Shape::cuboid(0.1, 0.1, 0.1)).at(Vec3::new(1.0, 0.1, 0.0));
    let cube = world.add_body(cube.velocity(-Vec3::Z).angular_velocity(Vec3::Y)).unwrap();
    world.body_mut(table).unwrap().set_angular_velocity(Vec3::Y).unwrap();
    for _ in 0..120 {
        world.step(DT);
    }
    let state = world.body(cube).unwrap();
    // ω²r = 1 m/s² < μg: it stays where it lies, two radians further.
    let place = Quat::from_rotation_y(2.0) * Vec3::X;
    let error = (Vec3::new(state.position().x, 0.0, state.position().z) - place).length();
    assert!(error < 0.05, "{error}");
    assert!((state.angular_velocity() - Vec3::Y).length() < 0.05, "{}", state.angular_velocity());
}

#[test]
fn it_pushes_with_its_velocity_and_is_not_pushed_back() {
    let mut world = World::default();
    world.add_body(Body::fixed(Shape::half_space(Vec3::Y)).friction(0.0)).unwrap();
    let pusher = world.add_body(Body::kinematic(Shape::cuboid(0.1, 0.5, 0.5)).at(Vec3::new(-1.0, 0.5, 0.0))).unwrap();
    let cube = Body::dynamic(Shape::cuboid(0.25, 0.25, 0.25)).at(Vec3::Y * 0.25).friction(0.0);
    let cube = world.add_body(cube).unwrap();
    for i in 1..=90 {
        let x = -1.0 + 2.0 * DT * i as f32;
        world.body_mut(pusher).unwrap().set_kinematic_target(Pose::from_translation(Vec3::new(x, 0.5, 0.0))).unwrap();
        world.step(DT);
    }
    let speed = world.body(cube).unwrap().velocity().x;
    // The sweeps of one step leave 5 % of an impact that meets four points unevenly.
    assert!((speed - 2.0).abs() < 0.12, "{speed}");
    assert!((world.body(pusher).unwrap().position().x - 2.0).abs() < 1e-5);
    // Without a new target it stops; the cube slides on.
    for _ in 0..30 {
        world.step(DT);
    }
    assert_eq!(world.body(pusher).unwrap().velocity(), Vec3::ZERO);
    assert!((world.body(cube).unwrap().velocity().x - speed).abs() < 1e-3);
}

#[test]
fn only_kinematic_bodies_have_targets() {
    let mut world = World::default();
    let ball = world.add_body(Body::dynamic(Shape::ball(0.5))).unwrap();
    let error = world.body_mut(ball).unwrap().set_kinematic_target(Pose::IDENTITY).unwrap_err();
    assert_eq!(error.to_string(), "kinematic_target: only a kinematic body has a target: use set_pose or forces");
}
