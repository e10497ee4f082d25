//! A heap of everything.

use super::{Builder, Random};
use crate::file::SceneFile;
use ishigaki::{Body, Shape, Vec3};

/// Distance of neighbors in the grid they fall from, m: more than the diagonal of the largest box.
const SPACING: f32 = 0.9;

/// `n` bodies of 1000 kg/m³, boxes, balls and capsules in turn, of greatest extent uniform in 0.25…0.5 m (box edges
/// and capsule lengths; capsules are half as thick as long), turned at random, dropped from a grid of 0.9 m into
/// an open container of fixed walls. Seed 7. The grid is k × k wide, k the least with 2 k³ ≥ n, but ≥ 3; the
/// container is k × 0.9 m wide inside and half as high plus 1 m, its walls 1 m thick.
pub fn pile(n: usize) -> SceneFile {
    let mut columns = 3;
    while 2 * columns * columns * columns < n {
        columns += 1;
    }
    let width = columns as f32 * SPACING;
    let mut scene =
        Builder::on_ground(10, [0.8 * width, 1.2 * width + 2.0, 1.6 * width + 2.0], [0.0, 0.2 * width, 0.0]);
    let (half_height, out) = (0.25 * width + 0.5, 0.5 * width + 0.5);
    for (name, x, z) in [("west", -1.0, 0.0), ("east", 1.0, 0.0), ("north", 0.0, -1.0), ("south", 0.0, 1.0)] {
        // Walls along x reach over the corners.
        let (half_x, half_z) = if x == 0.0 { (0.5 * width + 1.0, 0.5) } else { (0.5, 0.5 * width) };
        let wall = Body::fixed(Shape::cuboid(half_x, half_height, half_z));
        scene.add(wall.at(Vec3::new(x * out, half_height, z * out)).named(name));
    }
    let mut random = Random::new(7);
    for k in 0..n {
        let (layer, place) = (k / (columns * columns), k % (columns * columns));
        let middle = 0.5 * (columns as f32 - 1.0);
        let cell = Vec3::new((place % columns) as f32 - middle, layer as f32 + 0.6, (place / columns) as f32 - middle);
        let size = random.between(0.25, 0.5);
        let shape = match k % 3 {
            0 => Shape::cuboid(0.5 * size, 0.5 * random.between(0.25, size), 0.5 * random.between(0.25, size)),
            1 => Shape::ball(0.5 * size),
            _ => Shape::capsule(0.25 * size, 0.25 * size),
        };
        scene.add(Body::dynamic(shape).at(SPACING * cell).rotated(random.rotation()));
    }
    scene.finish()
}
