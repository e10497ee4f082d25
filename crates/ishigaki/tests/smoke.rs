//! First light: a world that falls, swings and is restored.
use ishigaki::*;

#[test]
fn pendulum_keeps_its_length_and_energy() {
    let mut world = World::default();
    let hook = world.add_body(Body::fixed(Shape::ball(0.05))).unwrap();
    let bob = world.add_body(Body::dynamic(Shape::ball(0.05)).at(Vec3::X).sleepless()).unwrap();
    world.add_joint(Joint::ball(hook, bob, Vec3::ZERO)).unwrap();
    let first = world.step(1.0 / 240.0);
    let start = first.kinetic_energy + first.potential_energy;
    for _ in 0..480 {
        let report = world.step(1.0 / 240.0);
        assert!(report.max_joint_error < 1e-4, "{}", report.max_joint_error);
    }
    let report = world.report();
    let scale = world.body(bob).unwrap().mass() * 9.81;
    assert!((report.kinetic_energy + report.potential_energy - start).abs() < 0.02 * scale);
}
