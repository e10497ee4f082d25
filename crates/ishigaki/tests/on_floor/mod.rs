//! A world with a floor in which nothing falls asleep.

use ishigaki::{Body, Shape, Vec3, World, WorldOptions};

/// s.
pub const DT: f32 = 1.0 / 60.0;

pub fn world(edit: impl FnOnce(&mut WorldOptions)) -> World {
    let mut options = WorldOptions::default();
    options.rest.sleep.enabled = false;
    edit(&mut options);
    let mut world = World::new(options).unwrap();
    world.add_body(Body::fixed(Shape::half_space(Vec3::Y))).unwrap();
    world
}
