//! Kapla: a tower of 102 blocks without mortar; the steps until its last block has come down.

use super::bench::{Setting, add_ground};
use crate::Result;
use crate::setup::body;
use ishigaki::{Body, BodyHandle, Shape, Vec3, World};

const FLOORS: usize = 6;
const BASES: usize = 8;
/// s.
const DT: f32 = 0.01;
/// kg.
const MASS: f32 = 10.0;
/// The source leaves it to each engine.
const FRICTION: f32 = 0.8;
/// Below it the last block has come down, m.
const FALLEN: f32 = 1.0;

fn scene(setting: Setting) -> Result<(World, BodyHandle)> {
    let mut world = setting.world(0.1)?;
    add_ground(&mut world, FRICTION)?;
    let mut last = None;
    let mut add = |half: Vec3, x: f32, y: f32, z: f32| -> Result<()> {
        let shape = Shape::cuboid(half.x, half.y, half.z).friction(FRICTION);
        last = Some(world.add_body(Body::dynamic(shape).mass(MASS).at(Vec3::new(x, y, z)))?);
        Ok(())
    };
    let (base, wall, walls) = (Vec3::new(0.025, 0.125, 0.05), Vec3::new(0.1, 0.025, 0.05), BASES / 2);
    for floor in 0..FLOORS {
        let z = 0.2 * floor as f32;
        for j in 0..BASES {
            add(base, 0.2 * j as f32, 0.0, z + 0.05)?;
        }
        // On one side walls join bases 0–1, 2–3 …, on the other 1–2, 3–4 …; there two more close the ends.
        let right = (0..walls).map(|j| (0.4 * j as f32 + 0.1, -0.1));
        let left = (0..walls - 1).map(|j| (0.4 * j as f32 + 0.3, 0.1));
        let ends = [0, walls - 1].map(|j| (0.4 * j as f32 + 0.1, 0.1));
        for (x, y) in right.chain(left).chain(ends) {
            add(wall, x, y, z + 0.15)?;
        }
    }
    let last = last.ok_or_else(|| crate::Error::Missing("the tower has no block".to_string()))?;
    Ok((world, last))
}

/// Steps until the tower has fallen, `most` at most; `progress` hears the part that is done.
pub fn run(setting: Setting, most: usize, mut progress: impl FnMut(f64)) -> Result<usize> {
    let (mut world, last) = scene(setting)?;
    for step in 0..most {
        if step.is_multiple_of(500) {
            progress(step as f64 / most as f64);
        }
        if body(&world, last)?.center().z < FALLEN {
            return Ok(step);
        }
        world.step(DT);
    }
    Ok(most)
}
