//! The same bits on any number of threads.
#![cfg(feature = "threads")]

use ishigaki::{Body, Joint, Shape, Vec3, World};

const DT: f32 = 1.0 / 60.0;

/// Towers, a wall that is hit, a heap of balls and boxes, and limbs that fall apart from each other: many islands, one of
/// them wide.
fn scene(world: &mut World) {
    world.add_body(Body::fixed(Shape::half_space(Vec3::Y))).unwrap();
    let mut add = |shape: Shape, at: Vec3, velocity: Vec3| {
        world.add_body(Body::dynamic(shape).at(at).velocity(velocity)).unwrap();
    };
    let half = 0.5_f32;
    for t in 0..60_u16 {
        for i in 0..20_u16 {
            let at = Vec3::new(3.0 * f32::from(t % 8), half + f32::from(i), 3.0 * f32::from(t / 8) - 40.0);
            add(Shape::cuboid(half, half, half), at, Vec3::ZERO);
        }
    }
    for row in 0..12_u16 {
        for i in 0..20_u16 {
            let at = Vec3::new(f32::from(i) + half * f32::from(row % 2), half + f32::from(row), 0.0);
            add(Shape::cuboid(half, half, half), at, Vec3::ZERO);
        }
    }
    add(Shape::ball(1.0), Vec3::new(10.0, 6.0, 8.0), Vec3::new(0.0, 0.0, -15.0));
    for i in 0..200_u16 {
        let at = Vec3::new(f32::from(i % 5) * 1.1, 1.0 + f32::from(i / 25), 20.0 + 1.1 * f32::from(i / 5 % 5));
        add(if i % 2 == 0 { Shape::ball(half) } else { Shape::cuboid(0.4, 0.4, 0.4) }, at, Vec3::ZERO);
    }
    for i in 0..400_u16 {
        let at = Vec3::new(-3.0 * f32::from(i % 20), 0.6, 3.0 * f32::from(i / 20));
        let limb = |at: Vec3| Body::dynamic(Shape::capsule(0.3, 0.2)).at(at);
        let (upper, lower) = (world.add_body(limb(at + Vec3::Y)).unwrap(), world.add_body(limb(at)).unwrap());
        world.add_joint(Joint::ball_about(upper, lower, at + 0.5 * Vec3::Y, Vec3::Y).cone(0.5)).unwrap();
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let hash = |threads: usize| {
        let mut world = World::default();
        world.set_threads(threads).unwrap();
        scene(&mut world);
        (0..60).for_each(|_| drop(world.step(DT)));
        assert_eq!(world.report().wide_rows, world.report().rows);
        (world.state_hash(), world.report().work)
    };
    let alone = hash(1);
    for threads in [2, 3, 8] {
        assert_eq!(hash(threads), alone, "{threads} threads");
    }
}

#[test]
fn no_threads_at_all_are_refused() {
    let error = World::default().set_threads(0).unwrap_err();
    assert!(error.to_string().starts_with("threads:"), "{error}");
}
