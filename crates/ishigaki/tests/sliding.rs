//! Contacts keep their names while a stack settles, and nothing bumps where surfaces are only cut into pieces.

use ishigaki::{Body, BodyHandle, Shape, Vec3, World, WorldOptions};

const DT: f32 = 1.0 / 60.0;

fn world() -> World {
    let mut options = WorldOptions::default();
    options.rest.sleep.enabled = false;
    // Frozen pairs keep their points without asking for names: every step shall ask.
    options.rest.aggressive_sleep.enabled = false;
    World::new(options).unwrap()
}

#[test]
fn points_of_a_settling_stack_are_found_again() {
    let mut world = world();
    world.add_body(Body::fixed(Shape::half_space(Vec3::Y))).unwrap();
    for i in 0..8 {
        // Dropped from 2 cm onto each other, a little aside.
        let place = Vec3::new(0.03 * (i % 3) as f32, 0.52 + 1.02 * i as f32, 0.02 * (i % 2) as f32);
        world.add_body(Body::dynamic(Shape::cuboid(0.5, 0.5, 0.5)).at(place)).unwrap();
    }
    let (mut matched, mut expected) = (0, 0);
    for _ in 0..300 {
        let report = world.step(DT);
        matched += report.ids_matched;
        expected += report.ids_expected;
    }
    eprintln!("settling stack: {matched} of {expected} points found again");
    assert!(expected > 5000, "{expected}: the stack fell apart");
    assert!(matched as f32 > 0.95 * expected as f32, "{matched} of {expected}");
}

/// Slides a box at 4 m/s for a second; gives the greatest lift and the error of its speed against v − μgt.
fn slide(world: &mut World, body: BodyHandle) -> (f32, f32) {
    let friction = 0.2;
    for _ in 0..30 {
        world.step(DT); // let it settle first
    }
    world.body_mut(body).unwrap().set_velocity(Vec3::new(4.0, 0.0, 0.0)).unwrap();
    let start = world.body(body).unwrap().center().y;
    let mut lift = 0.0_f32;
    for _ in 0..60 {
        world.step(DT);
        lift = lift.max((world.body(body).unwrap().center().y - start).abs());
    }
    let speed = world.body(body).unwrap().velocity().x;
    (lift, (speed - (4.0 - friction * 9.81)).abs())
}

fn sled(x: f32) -> Body {
    Body::dynamic(Shape::cuboid(0.25, 0.25, 0.25)).at(Vec3::new(x, 0.25, 0.1)).friction(0.2)
}

#[test]
fn a_box_slides_over_a_flat_mesh_without_a_bump() {
    let mut world = world();
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for i in 0..21_u32 {
        for z in [-1.0, 1.0] {
            vertices.push(Vec3::new(0.5 * i as f32 - 2.0, 0.0, z));
        }
        if i > 0 {
            let k = 2 * i;
            triangles.extend([[k - 2, k - 1, k], [k, k - 1, k + 1]]);
        }
    }
    let mesh = Shape::triangle_mesh(vertices, triangles).unwrap();
    world.add_body(Body::fixed(mesh).friction(0.2)).unwrap();
    let body = world.add_body(sled(-1.0)).unwrap();
    let (lift, error) = slide(&mut world, body);
    eprintln!("flat mesh: lift {:.3} mm, speed off by {error:.4} m/s", 1e3 * lift);
    assert!(lift < 1e-3, "{lift} m");
    assert!(error < 0.02, "{error} m/s");
}

#[test]
fn a_box_slides_over_flush_boxes_without_a_bump() {
    let mut world = world();
    for i in 0..16 {
        let tile = Body::fixed(Shape::cuboid(0.25, 0.25, 1.0)).at(Vec3::new(0.5 * i as f32 - 2.0, -0.25, 0.0));
        world.add_body(tile.friction(0.2)).unwrap();
    }
    let body = world.add_body(sled(-1.0)).unwrap();
    let (lift, error) = slide(&mut world, body);
    eprintln!("flush boxes: lift {:.3} mm, speed off by {error:.4} m/s", 1e3 * lift);
    assert!(lift < 1e-3, "{lift} m");
    assert!(error < 0.02, "{error} m/s");
}
