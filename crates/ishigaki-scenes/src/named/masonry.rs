//! Stones without mortar.

use super::Builder;
use crate::file::SceneFile;
use ishigaki::math::{cos, sin};
use ishigaki::{Body, Quat, Shape, Vec3};

/// Bricks of 1 × 0.5 × 0.5 m, 250 kg, flush, `rows` courses of `columns` m; every second course is set off by half
/// a brick and has half bricks at its ends, so that the ends are upright.
pub fn wall(columns: usize, rows: usize) -> SceneFile {
    let (wide, high) = (columns as f32, 0.5 * rows as f32);
    let eye = [0.3 * wide, 0.6 * high + 2.0, 0.9 * wide + 1.2 * high + 4.0];
    let mut scene = Builder::on_ground(10, eye, [0.0, 0.5 * high, 0.0]);
    let mut brick = |left: f32, length: f32, row: usize| {
        let center = Vec3::new(left + 0.5 * (length - wide), 0.5 * row as f32 + 0.25, 0.0);
        scene.add(Body::dynamic(Shape::cuboid(0.5 * length, 0.25, 0.25)).at(center));
    };
    for row in 0..rows {
        if row % 2 == 0 {
            (0..columns).for_each(|i| brick(i as f32, 1.0, row));
        } else {
            brick(0.0, 0.5, row);
            (1..columns).for_each(|i| brick(i as f32 - 0.5, 1.0, row));
            brick(wide - 0.5, 0.5, row);
        }
    }
    scene.finish()
}

/// Mean radius of the arch, m.
const RADIUS: f32 = 10.0;
/// Neighboring stones overlap this much: the slop of a world at length scale 1, so that support starts at once, m.
const OVERLAP: f32 = 0.005;

/// A semicircular arch of `stones` equal wedges: mean radius R = 10 m, thickness `thickness`·R, depth 2 m,
/// 1000 kg/m³, friction 1 so that thickness alone decides; center at the origin, springing at y = 0 from two fixed
/// blocks (`left`, `right`) 1 m high. Side faces stand out by 2.5 mm, so that neighbors overlap by 5 mm, the slop;
/// the blocks' tops are at y = +2.5 mm for the same reason. The ground is at y = −1 m.
///
/// Thrust inside the stones is possible from t/R = 0.1075 up (Milankovitch 1907); thinner arches hinge and fall.
pub fn arch(stones: usize, thickness: f32) -> SceneFile {
    let t = thickness * RADIUS;
    let mut scene = Builder::new(10, [0.0, 6.0, 26.0], [0.0, 5.0, 0.0]);
    scene.add(Body::fixed(Shape::half_space(Vec3::Y)).at(Vec3::new(0.0, -1.0, 0.0)).named("ground"));
    let block = Shape::cuboid(0.5 * t + 0.5, 0.5, 1.5).friction(1.0);
    let top = 0.5 * OVERLAP;
    for (name, x) in [("left", -RADIUS), ("right", RADIUS)] {
        scene.add(Body::fixed(block.clone()).at(Vec3::new(x, top - 0.5, 0.0)).named(name));
    }
    let half_angle = std::f32::consts::PI / (2 * stones) as f32;
    let points = wedge(half_angle, t);
    for k in 0..stones {
        // From the left springing over the crown: the stone's own y axis points away from the center.
        let lean = std::f32::consts::FRAC_PI_2 - (2 * k + 1) as f32 * half_angle;
        let rotation = Quat::from_xyzw(0.0, 0.0, sin(0.5 * lean), cos(0.5 * lean));
        let center = RADIUS * Vec3::new(-sin(lean), cos(lean), 0.0);
        if let Ok(stone) = Shape::convex_hull(&points) {
            scene.add(Body::dynamic(stone.friction(1.0)).at(center).rotated(rotation));
        }
    }
    scene.finish()
}

/// Corners of a stone about the point of the mean circle at its middle, y away from the arch's center.
fn wedge(half_angle: f32, t: f32) -> Vec<Vec3> {
    let along = Vec3::new(sin(half_angle), cos(half_angle), 0.0);
    let outward = 0.5 * OVERLAP * Vec3::new(cos(half_angle), -sin(half_angle), 0.0);
    let mut points = Vec::with_capacity(8);
    for radius in [RADIUS - 0.5 * t, RADIUS + 0.5 * t] {
        let corner = radius * along + outward - RADIUS * Vec3::Y;
        for side in [-1.0, 1.0] {
            for z in [-1.0, 1.0] {
                points.push(Vec3::new(side * corner.x, corner.y, z));
            }
        }
    }
    points
}
