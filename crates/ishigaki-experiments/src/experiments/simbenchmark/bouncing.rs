//! Bouncing: 49 balls fall from 5 m on the ground and bounce without loss; their energy.

use super::bench::{Course, DT, G, Setting, add_ground};
use crate::Result;
use crate::setup::body;
use ishigaki::{Body, BodyHandle, DriftScheme, Shape, Vec3, World};

/// Balls in a row.
const ROW: usize = 7;
/// kg.
const MASS: f64 = 10.0;
/// m.
const RADIUS: f64 = 0.1;
/// Of the centers at the start, m.
const HEIGHT: f64 = 5.0;

/// Σ m(½v² + gz), J, from velocities and places as they are.
pub fn energy(world: &World, balls: &[BodyHandle], mass: f64) -> Result<f64> {
    let mut sum = 0.0;
    for &ball in balls {
        let state = body(world, ball)?;
        sum += mass * (0.5 * state.velocity().as_dvec3().length_squared() + G * f64::from(state.center().z));
    }
    Ok(sum)
}

/// (E − E₀)² with E₀ = 49 mgH before each step.
pub fn run(setting: Setting, seconds: f64) -> Result<Course> {
    let mut world = setting.world(2.0 * RADIUS as f32)?;
    add_ground(&mut world, 0.0)?;
    let ball = Body::dynamic(Shape::ball(RADIUS as f32).friction(0.0).restitution(1.0)).mass(MASS as f32);
    let mut balls = Vec::new();
    for i in 0..ROW * ROW {
        let at = Vec3::new(2.0 * (i / ROW) as f32, 2.0 * (i % ROW) as f32, HEIGHT as f32);
        balls.push(world.add_body(ball.clone().at(at))?);
    }
    let start = (ROW * ROW) as f64 * MASS * G * HEIGHT;
    let steps = (seconds / DT).round() as usize;
    let mut course = Course::new(steps);
    for step in 0..steps {
        course.add(step as f64 * DT, (energy(&world, &balls, MASS)? - start).powi(2));
        world.step(DT as f32);
    }
    Ok(course)
}

/// The same with the engine's integrator in f64: what its scheme leaves when rounding is away.
pub fn replay(drift: DriftScheme, seconds: f64) -> Course {
    let start = (ROW * ROW) as f64 * MASS * G * HEIGHT;
    let steps = (seconds / DT).round() as usize;
    let mut course = Course::new(steps);
    let (mut z, mut v) = (HEIGHT, 0.0_f64);
    for step in 0..steps {
        let energy = (ROW * ROW) as f64 * MASS * (0.5 * v * v + G * z);
        course.add(step as f64 * DT, (energy - start).powi(2));
        let (before, forced) = (v, -G * DT);
        v += forced;
        if z - RADIUS + DT * v <= 0.0 {
            v = match drift {
                DriftScheme::Symplectic => -before,
                DriftScheme::Trapezoidal => -before + forced,
            };
        }
        z += match drift {
            DriftScheme::Symplectic => DT * v,
            DriftScheme::Trapezoidal => DT * (v - 0.5 * forced),
        };
    }
    course
}
