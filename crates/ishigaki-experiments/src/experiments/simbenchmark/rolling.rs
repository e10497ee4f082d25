//! Rolling: a box on the ground is pushed, 25 balls on it roll. Coulomb's cone, sliding below, sticking above.

use super::bench::{Course, DT, G, Setting, add_ground};
use crate::Result;
use crate::setup::body;
use glam::DVec3;
use ishigaki::{Body, BodyHandle, Shape, Vec3, World};

/// Ground and box, ball and box.
pub const FRICTION: [f64; 2] = [0.4, 0.8];
/// Of the box and of a ball, kg.
pub const MASSES: [f64; 2] = [10.0, 1.0];
/// On the box, N.
pub const FORCE: f64 = 150.0;
/// Balls in a row of the square of balls.
pub const ROW: usize = 5;
/// With which the source begins, m.
const OVERLAP: f32 = 2e-5;

/// Of the push.
#[derive(Clone, Copy, Debug)]
pub enum Direction {
    /// 60° from x.
    Oblique,
    /// Along an axis.
    Y,
}

impl Direction {
    pub fn unit(self) -> [f64; 2] {
        match self {
            Self::Oblique => [0.5, 0.75_f64.sqrt()],
            Self::Y => [0.0, 1.0],
        }
    }
}

/// Exact accelerations of the box and of a ball: the box slides, the balls stick and roll, m/s².
pub fn exact() -> [f64; 2] {
    let ([mu, _], [m_box, m_ball], n) = (FRICTION, MASSES, (ROW * ROW) as f64);
    let sliding = mu * (m_box + n * m_ball) * G;
    // A ball driven by f at its bottom: a = f/m, α r = 5f/2m, and the box moves with its lowest point: 7f/2m.
    let rolling = ((FORCE - sliding) / m_box) / (3.5 / m_ball + n / m_box);
    [(FORCE - sliding - n * rolling) / m_box, rolling / m_ball]
}

fn scene(setting: Setting) -> Result<(World, BodyHandle, BodyHandle)> {
    let mut world = setting.world(1.0)?;
    add_ground(&mut world, FRICTION[0] as f32)?;
    let shape = Shape::cuboid(10.0, 10.0, 0.5).friction(FRICTION[1] as f32);
    let slab = Body::dynamic(shape).mass(MASSES[0] as f32).at((0.5 - OVERLAP) * Vec3::Z);
    let slab = world.add_body(slab)?;
    let mut first = None;
    for i in 0..ROW * ROW {
        let (x, y) = ((i / ROW) as f32 * 2.0 - 4.0, (i % ROW) as f32 * 2.0 - 4.0);
        let shape = Shape::ball(0.5).friction(FRICTION[1] as f32);
        let ball = Body::dynamic(shape).mass(MASSES[1] as f32).at(Vec3::new(x, y, 1.5 - 3.0 * OVERLAP));
        let ball = world.add_body(ball)?;
        first.get_or_insert(ball);
    }
    Ok((world, slab, first.unwrap_or(slab)))
}

/// |Δv|² of the box and of a ball together, of velocities at the time `t`, m²/s².
pub fn error(t: f64, direction: Direction, velocities: [DVec3; 2]) -> f64 {
    let [x, y] = direction.unit();
    let off = |(v, a): (DVec3, f64)| (v - a * t * DVec3::new(x, y, 0.0)).length_squared();
    velocities.into_iter().zip(exact()).map(off).sum()
}

/// [`error`] of the box and the first ball together, before each step.
pub fn run(setting: Setting, direction: Direction, seconds: f64) -> Result<Course> {
    let (mut world, slab, ball) = scene(setting)?;
    let [x, y] = direction.unit();
    let push = Vec3::new((FORCE * x) as f32, (FORCE * y) as f32, 0.0);
    let steps = (seconds / DT).round() as usize;
    let mut course = Course::new(steps);
    for step in 0..steps {
        let t = step as f64 * DT;
        let velocities = [body(&world, slab)?.velocity(), body(&world, ball)?.velocity()];
        course.add(t, error(t, direction, velocities.map(|v| v.as_dvec3())));
        if let Some(mut slab) = world.body_mut(slab) {
            slab.apply_force(push)?;
        }
        world.step(DT as f32);
    }
    Ok(course)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// M a_box = F − f₁ − 25 f₂ and a ball's lowest point has the acceleration of the box.
    #[test]
    fn exact_motion_obeys_newton() {
        let [slab, ball] = exact();
        assert!((slab - 0.7385).abs() < 5e-5 && (ball - 0.211).abs() < 5e-5);
        assert!((MASSES[0] * slab + 25.0 * MASSES[1] * ball - (FORCE - 137.34)).abs() < 1e-9);
        assert!((3.5 * ball - slab).abs() < 1e-9);
    }
}
