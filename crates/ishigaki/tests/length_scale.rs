//! A scene behaves the same at 1/64, 1 and 64 m: lengths × k, times × √k, with `length_scale` = k.
//!
//! k is a power of four, so every product with k and √k is exact in floating point: two scaled runs must agree to the
//! bit wherever each tolerance of the engine scales as it should. Margins and tolerances that forgot to scale show here.

use ishigaki::{Body, BodyHandle, Joint, Shape, Vec3, World, WorldOptions};

fn scaled_scene(k: f32) -> (World, Vec<BodyHandle>) {
    let options = WorldOptions { length_scale: k, ..WorldOptions::default() };
    let mut world = World::new(options).unwrap();
    world.add_body(Body::fixed(Shape::cuboid(20.0 * k, 1.0 * k, 20.0 * k)).at(-Vec3::Y * k)).unwrap();
    let corners: Vec<Vec3> = [(0.0, 0.6, 0.0), (0.5, -0.3, 0.4), (-0.5, -0.3, 0.4), (0.0, -0.3, -0.6)]
        .map(|(x, y, z)| Vec3::new(x, y, z) * k)
        .to_vec();
    let mut bodies = Vec::new();
    for i in 0..12 {
        let shape = match i % 4 {
            0 => Shape::cuboid(0.5 * k, 0.3 * k, 0.4 * k),
            1 => Shape::ball(0.4 * k).restitution(0.5),
            2 => Shape::capsule(0.4 * k, 0.25 * k),
            _ => Shape::convex_hull(&corners).unwrap(),
        };
        let place = Vec3::new(0.3 * (i % 3) as f32, 1.0 + 1.1 * i as f32, 0.2 * (i % 5) as f32) * k;
        let spin = Vec3::new(1.0, 0.5 * i as f32, -0.7) / k.sqrt();
        bodies.push(world.add_body(Body::dynamic(shape).at(place).angular_velocity(spin)).unwrap());
    }
    world.add_joint(Joint::ball(bodies[0], bodies[1], Vec3::new(0.2, 1.6, 0.1) * k)).unwrap();
    (world, bodies)
}

fn run(k: f32, steps: usize) -> Vec<Vec3> {
    let (mut world, bodies) = scaled_scene(k);
    for _ in 0..steps {
        world.step(k.sqrt() / 64.0);
    }
    bodies.iter().map(|&b| world.body(b).unwrap().center() / k).collect()
}

#[test]
fn small_and_large_worlds_behave_alike() {
    let reference = run(1.0, 240);
    for k in [1.0 / 64.0, 1.0 / 4.0, 4.0, 64.0] {
        let scaled = run(k, 240);
        for (i, (a, b)) in reference.iter().zip(&scaled).enumerate() {
            assert!(a == b, "scale {k}, body {i}: {a} at scale 1, {b} scaled back: some tolerance does not scale");
        }
    }
}
