//! 666 and elastic 666: a block of 6³ balls, not quite in line, falls and scatters; overlap, or energy.

use super::bench::{Course, DT, Setting, add_ground};
use super::bouncing::energy;
use crate::Result;
use crate::setup::body;
use ishigaki::{Body, BodyHandle, Shape, Vec3, World};
use ishigaki_scenes::named::Random;

/// m.
const RADIUS: f64 = 0.1;
/// kg.
const MASS: f64 = 10.0;
/// Between centers at the start, m.
const GAP: f32 = 0.21;
/// Each coordinate at the start is up to this much greater, m.
const PERTURBATION: f32 = 0.001;
/// Of the source's generator, whose numbers are not ours.
const SEED: u64 = 42;

fn scene(setting: Setting, row: usize, restitution: f32, height: f32) -> Result<(World, Vec<BodyHandle>)> {
    let mut world = setting.world(2.0 * RADIUS as f32)?;
    add_ground(&mut world, 0.0)?;
    let ball = Body::dynamic(Shape::ball(RADIUS as f32).friction(0.0).restitution(restitution)).mass(MASS as f32);
    let (mut random, mut balls) = (Random::new(SEED), Vec::new());
    for i in 0..row.pow(3) {
        let place = [i / (row * row), i / row % row, i % row];
        let at = Vec3::from_array(place.map(|k| k as f32 * GAP + PERTURBATION * random.unit()));
        balls.push(world.add_body(ball.clone().at(at + height * Vec3::Z))?);
    }
    Ok((world, balls))
}

/// Σ of the squares of all overlaps, of balls with each other and with the ground, m².
fn overlap(world: &World, balls: &[BodyHandle]) -> Result<f64> {
    let mut centers = Vec::with_capacity(balls.len());
    for &ball in balls {
        centers.push(body(world, ball)?.center().as_dvec3());
    }
    let mut sum = 0.0;
    for (i, a) in centers.iter().enumerate() {
        for b in &centers[i + 1..] {
            let square = (*a - *b).length_squared();
            if square < 4.0 * RADIUS * RADIUS {
                sum += (2.0 * RADIUS - square.sqrt()).powi(2);
            }
        }
        sum += (RADIUS - a.z).max(0.0).powi(2);
    }
    Ok(sum)
}

/// The overlap of `row`³ balls that do not bounce, before each step.
pub fn run(setting: Setting, row: usize, seconds: f64) -> Result<Course> {
    let (mut world, balls) = scene(setting, row, 0.0, 0.101)?;
    let steps = (seconds / DT).round() as usize;
    let mut course = Course::new(steps);
    for step in 0..steps {
        course.add(step as f64 * DT, overlap(&world, &balls)?);
        world.step(DT as f32);
    }
    Ok(course)
}

/// (E − E₀)² of `row`³ balls that bounce without loss, before each step.
pub fn run_elastic(setting: Setting, row: usize, seconds: f64) -> Result<Course> {
    let (mut world, balls) = scene(setting, row, 1.0, 1.101)?;
    let start = energy(&world, &balls, MASS)?;
    let steps = (seconds / DT).round() as usize;
    let mut course = Course::new(steps);
    for step in 0..steps {
        course.add(step as f64 * DT, (energy(&world, &balls, MASS)? - start).powi(2));
        world.step(DT as f32);
    }
    Ok(course)
}
