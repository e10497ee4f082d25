//! Locked axes, gravity scale, damping and the guard on speeds.
use ishigaki::*;

const DT: f32 = 1.0 / 60.0;

fn weightless() -> World {
    World::new(WorldOptions { gravity: Vec3::ZERO, ..WorldOptions::default() }).unwrap()
}

#[test]
fn locked_axes_hold_under_contacts_and_joints() {
    let mut world = World::default();
    world.add_body(Body::fixed(Shape::half_space(Vec3::Y))).unwrap();
    // Moves in the plane z = 0, turns about z only.
    let flat = |at: Vec3| {
        Body::dynamic(Shape::cuboid(0.2, 0.2, 0.2))
            .at(at)
            .lock_translation([false, false, true])
            .lock_rotation([true, true, false])
            .sleepless()
    };
    let first = world.add_body(flat(Vec3::new(0.0, 1.0, 0.0))).unwrap();
    let second = world.add_body(flat(Vec3::new(0.1, 2.0, 0.0))).unwrap();
    // A free one falls on them from the side and pulls the first by a rope.
    let free = Body::dynamic(Shape::ball(0.3)).at(Vec3::new(0.1, 3.0, 0.25)).velocity(Vec3::new(0.0, -5.0, -3.0));
    let free = world.add_body(free).unwrap();
    world.add_joint(Joint::rope(first, free, Vec3::new(0.2, 0.2, 0.2), Vec3::ZERO, 1.5)).unwrap();
    let mut turned = 0.0_f32;
    for _ in 0..240 {
        world.step(DT);
        for body in [first, second] {
            let state = world.body(body).unwrap();
            assert_eq!(state.position().z, 0.0);
            assert_eq!(state.velocity().z, 0.0);
            assert!(state.angular_velocity().x.abs() + state.angular_velocity().y.abs() < 1e-6);
            let axis = state.rotation() * Vec3::Z;
            assert!((axis - Vec3::Z).length() < 1e-5, "{axis}");
            turned = turned.max(state.angular_velocity().z.abs());
        }
    }
    assert!(turned > 0.05, "nothing happened about the free axis");
}

#[test]
fn a_body_locked_in_all_axes_is_a_wall() {
    let mut world = World::default();
    let wall = Body::dynamic(Shape::cuboid(1.0, 0.1, 1.0)).lock_translation([true; 3]).lock_rotation([true; 3]);
    let wall = world.add_body(wall.sleepless()).unwrap();
    let ball = world.add_body(Body::dynamic(Shape::ball(0.2)).at(Vec3::new(0.8, 1.0, 0.0))).unwrap();
    for _ in 0..120 {
        world.step(DT);
    }
    assert_eq!(world.body(wall).unwrap().pose(), Pose::IDENTITY);
    assert!((world.body(ball).unwrap().position().y - 0.3).abs() < 0.01);
}

#[test]
fn gravity_acts_by_its_scale() {
    let mut world = World::default();
    let scales = [0.0, 0.5, -1.0, 2.0];
    let bodies: Vec<_> = scales
        .iter()
        .enumerate()
        .map(|(i, &s)| Body::dynamic(Shape::ball(0.1)).at(Vec3::X * i as f32).gravity_scale(s))
        .map(|body| world.add_body(body).unwrap())
        .collect();
    for _ in 0..60 {
        world.step(DT);
    }
    for (body, scale) in bodies.into_iter().zip(scales) {
        let speed = world.body(body).unwrap().velocity().y;
        assert!((speed + 9.81 * scale).abs() < 1e-3, "{speed} at {scale}");
    }
}

#[test]
fn damping_is_exponential_at_any_step() {
    for dt in [1.0_f32 / 240.0, 1.0 / 30.0, 0.5] {
        let mut world = weightless();
        let body = Body::dynamic(Shape::cuboid(0.1, 0.1, 0.1)).velocity(Vec3::X * 8.0).angular_velocity(Vec3::Y * 3.0);
        let body = world.add_body(body.damping(0.7, 1.3).sleepless()).unwrap();
        let steps = (2.0_f32 / dt).round() as usize;
        for _ in 0..steps {
            world.step(dt);
        }
        let state = world.body(body).unwrap();
        let (linear, angular) = (8.0 * (-1.4_f64).exp(), 3.0 * (-2.6_f64).exp());
        assert!((f64::from(state.velocity().x) / linear - 1.0).abs() < 1e-4, "{} of {linear}", state.velocity().x);
        assert!((f64::from(state.angular_velocity().y) / angular - 1.0).abs() < 1e-4);
    }
}

#[test]
fn no_body_is_faster_than_the_guard_allows() {
    let mut options = WorldOptions { gravity: Vec3::ZERO, ..WorldOptions::default() };
    options.motion.max_speed = 20.0;
    options.motion.max_angular_speed = 10.0;
    let mut world = World::new(options).unwrap();
    let body =
        Body::dynamic(Shape::ball(0.5)).velocity(Vec3::new(3.0e30, 4.0e30, 0.0)).angular_velocity(Vec3::Z * 100.0);
    let body = world.add_body(body).unwrap();
    for _ in 0..10 {
        world.body_mut(body).unwrap().apply_force(Vec3::X * 1e30).unwrap();
        world.body_mut(body).unwrap().apply_torque(Vec3::Z * 1e30).unwrap();
        world.step(DT);
        let state = world.body(body).unwrap();
        assert!(state.velocity().length() < 20.001 && state.velocity().length() > 19.0, "{}", state.velocity());
        assert!((state.angular_velocity().z - 10.0).abs() < 1e-3, "{}", state.angular_velocity());
    }
    // The direction stays.
    let mut world = weightless();
    let fast = Body::dynamic(Shape::ball(0.5)).velocity(Vec3::new(3.0e30, 4.0e30, 0.0));
    let fast = world.add_body(fast).unwrap();
    world.step(DT);
    let direction = world.body(fast).unwrap().velocity().normalize();
    assert!((direction - Vec3::new(0.6, 0.8, 0.0)).length() < 1e-5, "{direction}");
}
