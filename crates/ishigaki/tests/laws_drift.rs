//! Laws of the trapezoidal drift: free fall without error, bounces that keep the energy, rest that stays rest.

mod laws;

use ishigaki::{Body, BodyHandle, DriftScheme, Shape, Vec3, World, WorldOptions};
use laws::{G, body};

fn world(drift: DriftScheme, substeps: u32, gravity: Vec3) -> World {
    let mut options = WorldOptions { gravity, ..laws::options() };
    options.motion.drift = drift;
    options.solver.substeps = substeps;
    options.solver.restitution.threshold = 0.0;
    World::new(options).unwrap()
}

/// ½v² + gy, J/kg.
fn energy(world: &World, ball: BodyHandle) -> f64 {
    let state = body(world, ball);
    let (v, y) = (state.velocity().as_dvec3(), f64::from(state.center().y));
    0.5 * v.length_squared() - f64::from(world.options().gravity.y) * y
}

/// x = x₀ + v₀t + ½at² after any number of steps. All numbers are binary fractions: no rounding at all.
#[test]
fn constant_forces_are_followed_exactly() {
    for substeps in [1, 4] {
        let mut world = world(DriftScheme::Trapezoidal, substeps, 8.0 * Vec3::NEG_Y);
        let ball = Body::dynamic(Shape::ball(0.5)).mass(2.0).velocity(Vec3::new(1.0, 4.0, 0.0));
        let ball = world.add_body(ball).unwrap();
        for step in 1..=640 {
            world.body_mut(ball).unwrap().apply_force(4.0 * Vec3::Z).unwrap();
            world.step(1.0 / 64.0);
            let t = step as f32 / 64.0;
            let exact = Vec3::new(t, 4.0 * t - 4.0 * t * t, t * t);
            assert_eq!(body(&world, ball).center(), exact, "{substeps} substeps, {t} s");
        }
    }
}

/// e = 1: a hundred bounces from 1 m end with the energy they began with; the scheme by default swings by ½gh|v|.
#[test]
fn perfect_bounces_keep_the_energy() {
    let worst = |drift, substeps| {
        let mut world = world(drift, substeps, laws::options().gravity);
        world.add_body(Body::fixed(Shape::half_space(Vec3::Y))).unwrap();
        let ball = world.add_body(Body::dynamic(Shape::ball(0.1).restitution(1.0)).at(1.1 * Vec3::Y)).unwrap();
        let start = energy(&world, ball);
        let mut worst = 0.0_f64;
        // A hundred times up and down.
        let seconds = 200.0 * (2.0 / G).sqrt();
        while world.time() < seconds {
            world.step(1.0 / 240.0);
            worst = worst.max((energy(&world, ball) - start).abs() / G);
        }
        worst
    };
    for substeps in [1, 4] {
        let (exact, usual) = (worst(DriftScheme::Trapezoidal, substeps), worst(DriftScheme::Symplectic, substeps));
        eprintln!("{substeps} substeps: {exact:.1e} m trapezoidal, {usual:.1e} m symplectic");
        assert!(exact < 1e-4, "{substeps} substeps: off by {exact} m of height");
        assert!(usual > 20.0 * exact);
    }
}

/// Two balls of different mass meet in the air while they fall: energy and momentum as if nothing pulled.
#[test]
fn balls_that_meet_in_flight_keep_the_energy() {
    let mut world = world(DriftScheme::Trapezoidal, 1, laws::options().gravity);
    let ball = |mass, x: f32, v: f32| {
        let shape = Shape::ball(0.1).restitution(1.0).friction(0.0);
        Body::dynamic(shape).mass(mass).at(Vec3::new(x, 0.0, 0.02 * x)).velocity(v * Vec3::X)
    };
    let pair = [(1.0, -0.5, 2.0), (5.0, 0.5, -1.0)].map(|(m, x, v)| (m, world.add_body(ball(m, x, v)).unwrap()));
    let total = |world: &World| pair.iter().map(|(m, b)| f64::from(*m) * energy(world, *b)).sum::<f64>();
    let (start, met) = (total(&world), |world: &World| body(world, pair[0].1).velocity().x < 0.0);
    for _ in 0..240 {
        world.step(1.0 / 240.0);
        assert!((total(&world) - start).abs() < 2e-5 * 240.0, "{} J too much", total(&world) - start);
    }
    assert!(met(&world));
}

/// What rests is pushed and moves by its velocity, which is zero: it neither rises nor sinks.
#[test]
fn resting_block_stays() {
    let place = |drift| {
        let mut world = world(drift, 1, laws::options().gravity);
        world.add_body(Body::fixed(Shape::half_space(Vec3::Y))).unwrap();
        let block = world.add_body(Body::dynamic(Shape::cuboid(0.5, 0.5, 0.5)).at(0.5 * Vec3::Y)).unwrap();
        laws::run(&mut world, 2.0, 1.0 / 60.0);
        body(&world, block).center()
    };
    // The trapezoid is solved by the reference, the other by the wide path: rounding may differ.
    let apart = (place(DriftScheme::Trapezoidal) - place(DriftScheme::Symplectic)).length();
    assert!(apart < 1e-6, "{apart} m apart");
}
