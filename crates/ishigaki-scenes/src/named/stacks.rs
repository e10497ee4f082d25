//! Boxes on boxes.

use super::{Builder, cube};
use crate::file::SceneFile;
use ishigaki::{Body, Shape, Vec3};

/// `n` cubes of 1 m, 1000 kg each, exactly one above the other: the k-th has its center at y = k + ½.
pub fn tower(n: usize) -> SceneFile {
    let height = n as f32;
    let mut scene =
        Builder::on_ground(10, [0.8 * height + 5.0, 0.5 * height + 2.0, 0.8 * height + 5.0], [0.0, 0.5 * height, 0.0]);
    for k in 0..n {
        scene.add(cube().at(Vec3::new(0.0, k as f32 + 0.5, 0.0)));
    }
    scene.finish()
}

/// An upright triangle of base (base + 1)/2 cubes of 1 m, 1000 kg each: neighbors in a row are flush, each row is
/// set back by half a cube, centered on x = 0. Base 100 has 5,050 boxes and 14,950 touching pairs.
pub fn pyramid(base: usize) -> SceneFile {
    let size = base as f32;
    let mut scene = Builder::on_ground(10, [0.0, 0.6 * size + 2.0, 1.6 * size + 6.0], [0.0, 0.4 * size, 0.0]);
    add_pyramid(&mut scene, base, Vec3::ZERO);
    scene.finish()
}

fn add_pyramid(scene: &mut Builder, base: usize, foot: Vec3) {
    for row in 0..base {
        let cubes = base - row;
        for i in 0..cubes {
            let x = i as f32 - 0.5 * (cubes - 1) as f32;
            scene.add(cube().at(foot + Vec3::new(x, row as f32 + 0.5, 0.0)));
        }
    }
}

/// `rows` × `columns` of [`pyramid`]: 3 m from row to row (2 m of air), base + 2 m from column to column.
pub fn many_pyramids(rows: usize, columns: usize, base: usize) -> SceneFile {
    let spacing = Vec3::new(base as f32 + 2.0, 0.0, 3.0);
    let (wide, deep) = (columns as f32 * spacing.x, rows as f32 * spacing.z);
    let mut scene = Builder::on_ground(
        10,
        [0.0, 0.5 * (wide + deep) + 3.0, 0.7 * (wide + deep) + 5.0],
        [0.0, 0.3 * base as f32, 0.0],
    );
    for row in 0..rows {
        for column in 0..columns {
            let x = column as f32 - 0.5 * (columns as f32 - 1.0);
            let z = row as f32 - 0.5 * (rows as f32 - 1.0);
            add_pyramid(&mut scene, base, spacing * Vec3::new(x, 0.0, z));
        }
    }
    scene.finish()
}

/// A tower of `n` cubes of 1 m, 1000 kg each but the top one (`top`), which has `ratio` × 1000 kg.
pub fn heavy_on_light(n: usize, ratio: f32) -> SceneFile {
    let mut file = tower(n);
    if let Some(top) = file.bodies.last_mut() {
        top.name = "top".to_string();
        for shape in &mut top.shapes {
            shape.density = 1000.0 * ratio;
        }
    }
    file
}

/// Two towers 3 m high, their axes at x = ±2 m, of `left` and `right` bricks 1 m wide and deep and 3/count m high,
/// 1000 kg/m³; across them a plank (`plank`) of 6 × 0.5 × 1 m, 20,000 kg/m³ = 60 t.
///
/// With left < right the plank is left + 1 hops from the ground and lies on a brick that is right ≥ left + 1 hops
/// away: a supporter above its load.
pub fn plank_on_two_towers(left: usize, right: usize) -> SceneFile {
    const HEIGHT: f32 = 3.0;
    let mut scene = Builder::on_ground(10, [0.0, 4.0, 11.0], [0.0, 1.7, 0.0]);
    for (x, count) in [(-2.0, left), (2.0, right)] {
        let brick = HEIGHT / count as f32;
        for k in 0..count {
            let center = Vec3::new(x, (k as f32 + 0.5) * brick, 0.0);
            scene.add(Body::dynamic(Shape::cuboid(0.5, 0.5 * brick, 0.5)).at(center));
        }
    }
    let plank = Body::dynamic(Shape::cuboid(3.0, 0.25, 0.5)).density(20_000.0);
    scene.add(plank.at(Vec3::new(0.0, HEIGHT + 0.25, 0.0)).named("plank"));
    scene.finish()
}

/// `n` cubes of 1 m, 1000 kg each, on a fixed plate of 1.5 × 0.2 × 1.5 m called `scale`, its top at y = 0.2 m.
///
/// What the scale reads is [`contact_force`](crate::measure::contact_force) on it: n × 9810 N at rest. Shock
/// propagation makes it read the lowest box alone. Sleep is off: contacts of sleeping bodies report no force.
pub fn scale_under_stack(n: usize) -> SceneFile {
    let height = n as f32;
    let mut scene =
        Builder::on_ground(10, [0.8 * height + 4.0, 0.5 * height + 2.0, 0.8 * height + 4.0], [0.0, 0.5 * height, 0.0]);
    scene.file.options.rest.sleep.enabled = false;
    scene.add(Body::fixed(Shape::cuboid(0.75, 0.1, 0.75)).at(Vec3::new(0.0, 0.1, 0.0)).named("scale"));
    for k in 0..n {
        scene.add(cube().at(Vec3::new(0.0, k as f32 + 0.7, 0.0)));
    }
    scene.finish()
}
