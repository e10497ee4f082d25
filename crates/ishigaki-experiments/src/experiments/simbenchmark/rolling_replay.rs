//! The rolling task once more in f64: same scheme, same sweeps, to tell the method from its rounding.

use super::bench::{Course, DT, G};
use super::rolling::{Direction, FORCE, FRICTION, MASSES, ROW, error};
use glam::DVec3;

/// When velocities are rounded to f32; all else is f64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rounding {
    /// Never.
    Never,
    /// Once, when the step is over.
    EachStep,
    /// Whenever something pushes: as in the engine, which adds each impulse to the velocity.
    EachPush,
}

#[derive(Clone, Copy, Default)]
struct Body {
    center: DVec3,
    velocity: DVec3,
    spin: DVec3,
    inverse_mass: f64,
    inverse_inertia: DVec3,
}

impl Body {
    fn push(&mut self, impulse: DVec3, arm: DVec3, rounds: bool) {
        self.velocity += impulse * self.inverse_mass;
        self.spin += arm.cross(impulse) * self.inverse_inertia;
        if rounds {
            self.round();
        }
    }

    fn round(&mut self) {
        self.velocity = self.velocity.as_vec3().as_dvec3();
        self.spin = self.spin.as_vec3().as_dvec3();
    }

    fn speed_at(&self, arm: DVec3) -> DVec3 {
        self.velocity + self.spin.cross(arm)
    }

    /// n·K n of a unit impulse along `axis`.
    fn softness(&self, arm: DVec3, axis: DVec3) -> f64 {
        let turn = arm.cross(axis);
        self.inverse_mass + (turn * self.inverse_inertia).dot(turn)
    }
}

/// A point of the upper body on the lower one, or on the ground (index 0). The normal is z.
struct Touch {
    upper: usize,
    lower: usize,
    upper_arm: DVec3,
    lower_arm: DVec3,
    friction: f64,
    /// Tangents and normal.
    lambda: DVec3,
}

impl Touch {
    fn apply(&self, impulse: DVec3, bodies: &mut [Body], rounds: bool) {
        bodies[self.upper].push(impulse, self.upper_arm, rounds);
        bodies[self.lower].push(-impulse, self.lower_arm, rounds);
    }

    fn solve(&mut self, bodies: &mut [Body], rounds: bool) {
        let softness = |axis| {
            bodies[self.upper].softness(self.upper_arm, axis) + bodies[self.lower].softness(self.lower_arm, axis)
        };
        let k = DVec3::new(softness(DVec3::X), softness(DVec3::Y), softness(DVec3::Z));
        let w = bodies[self.upper].speed_at(self.upper_arm) - bodies[self.lower].speed_at(self.lower_arm);
        let normal = (self.lambda.z - w.z / k.z).max(0.0);
        self.apply((normal - self.lambda.z) * DVec3::Z, bodies, rounds);
        self.lambda.z = normal;

        let w = bodies[self.upper].speed_at(self.upper_arm) - bodies[self.lower].speed_at(self.lower_arm);
        // One step length for both tangents keeps friction opposite to the sliding.
        let wanted =
            (self.lambda - w / k.x.max(k.y)).truncate().clamp_length_max(self.friction * normal).extend(normal);
        self.apply(wanted - self.lambda, bodies, rounds);
        self.lambda = wanted;
    }
}

fn scene() -> (Vec<Body>, Vec<Touch>) {
    let box_inertia = MASSES[0] / 12.0 * DVec3::new(401.0, 401.0, 800.0);
    let slab = Body { inverse_mass: 1.0 / MASSES[0], inverse_inertia: box_inertia.recip(), ..Body::default() };
    let mut bodies = vec![Body::default(), Body { center: 0.5 * DVec3::Z, ..slab }];
    let corner = |x: f64, y: f64| Touch {
        upper: 1,
        lower: 0,
        upper_arm: DVec3::new(10.0 * x, 10.0 * y, -0.5),
        lower_arm: DVec3::ZERO,
        friction: FRICTION[0],
        lambda: DVec3::ZERO,
    };
    let mut touches = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    for i in 0..ROW * ROW {
        let center = DVec3::new((i / ROW) as f64 * 2.0 - 4.0, (i % ROW) as f64 * 2.0 - 4.0, 1.5);
        // ⅖mr² with r = ½.
        let inverse_inertia = DVec3::splat(10.0 / MASSES[1]);
        bodies.push(Body { center, inverse_mass: 1.0 / MASSES[1], inverse_inertia, ..Body::default() });
        let (upper_arm, lower_arm) = (-0.5 * DVec3::Z, DVec3::ZERO);
        touches.push(Touch {
            upper: 2 + i,
            lower: 1,
            upper_arm,
            lower_arm,
            friction: FRICTION[1],
            lambda: DVec3::ZERO,
        });
    }
    (bodies, touches)
}

/// As `rolling::run` with `sweeps` sweeps in one substep.
pub fn run(rounding: Rounding, sweeps: u32, direction: Direction, seconds: f64) -> Course {
    let rounds = rounding == Rounding::EachPush;
    let (mut bodies, mut touches) = scene();
    let [x, y] = direction.unit();
    let push = FORCE * DVec3::new(x, y, 0.0);
    let steps = (seconds / DT).round() as usize;
    let mut course = Course::new(steps);
    for step in 0..steps {
        let t = step as f64 * DT;
        course.add(t, error(t, direction, [bodies[1].velocity, bodies[2].velocity]));
        let weight = |body: &Body| -DT * G / body.inverse_mass * DVec3::Z;
        for body in &mut bodies[1..] {
            body.push(weight(body), DVec3::ZERO, rounds);
        }
        bodies[1].push(DT * push, DVec3::ZERO, rounds);
        for touch in &mut touches {
            if touch.lower == 1 {
                touch.lower_arm = bodies[touch.upper].center + touch.upper_arm - bodies[1].center;
            }
            touch.apply(touch.lambda, &mut bodies, rounds);
        }
        for _ in 0..sweeps {
            touches.iter_mut().for_each(|touch| touch.solve(&mut bodies, rounds));
        }
        for body in &mut bodies[1..] {
            if rounding == Rounding::EachStep {
                body.round();
            }
            body.center += DT * body.velocity;
        }
    }
    course
}
