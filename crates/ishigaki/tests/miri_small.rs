//! A world small enough for Miri: everything a step touches, under the eyes of an interpreter that finds undefined
//! behavior in us and in what we depend on.

use ishigaki::{Body, Joint, Jointed, Shape, Vec3, World, WorldOptions};

/// A box on the ground, a ball on the box, and a pendulum.
fn small_world() -> World {
    // One substep touches all that four touch, in a quarter of the interpreter's time.
    let mut options = WorldOptions::default();
    options.solver.substeps = 1;
    options.solver.jointed = Jointed::ALIKE;
    let mut world = World::new(options).unwrap();
    let ground = world.add_body(Body::fixed(Shape::half_space(Vec3::Y))).unwrap();
    world.add_body(Body::dynamic(Shape::cuboid(0.5, 0.5, 0.5)).at(Vec3::new(0.0, 0.5, 0.0))).unwrap();
    world.add_body(Body::dynamic(Shape::ball(0.25)).at(Vec3::new(0.1, 1.25, 0.0))).unwrap();
    let bob = world.add_body(Body::dynamic(Shape::ball(0.1)).at(Vec3::new(5.0, 2.0, 0.0))).unwrap();
    world.add_joint(Joint::hinge(ground, bob, Vec3::new(4.0, 2.0, 0.0), Vec3::Z)).unwrap();
    world
}

#[test]
fn a_step_a_snapshot_and_a_removal() {
    let mut world = small_world();
    for _ in 0..2 {
        let report = world.step(1.0 / 60.0);
        assert!(report.rejected.is_none() && report.non_finite.is_empty());
    }
    assert!(world.contacts().count() >= 2, "the box on the ground, the ball on the box");

    let mut restored = World::restore(&world.snapshot()).unwrap();
    world.step(1.0 / 60.0);
    restored.step(1.0 / 60.0);
    assert_eq!(world.state_hash(), restored.state_hash());

    let (top, _) = world.bodies().nth(2).unwrap();
    assert!(world.remove_body(top));
    world.step(1.0 / 60.0);
    assert_eq!(world.bodies().count(), 3);
}
