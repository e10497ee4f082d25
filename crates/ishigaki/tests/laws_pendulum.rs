//! Laws of bodies on joints: the pendulum at any amplitude, the top that precesses.

mod laws;

use ishigaki::{Body, BodyKind, Joint, MassProperties, Quat, Shape, Vec3, World};
use laws::{DEFAULT_STEPS, G, STEPS, body, converges, default_world, relative, world};

/// T over T₀ of small swings: 2K(sin ½θ)/π.
const AMPLITUDES: [(f64, f64); 5] =
    [(30.0, 1.01741), (60.0, 1.07318), (90.0, 1.18034), (120.0, 1.37288), (170.0, 2.43936)];
const RADIUS: f64 = 0.1;

/// A ball of radius 0.1 m whose center hangs 1 m below a hinge (or ball joint): its period over the T₀ of the compound pendulum.
fn period_ratio(mut world: World, degrees: f64, dt: f32, hinge: bool) -> f64 {
    let hook = world.add_body(Body::empty(BodyKind::Fixed)).unwrap();
    let angle = degrees.to_radians();
    let center = Vec3::new(angle.sin() as f32, -angle.cos() as f32, 0.0);
    let bob = Body::dynamic(Shape::ball(RADIUS as f32)).at(center);
    let bob = world.add_body(bob).unwrap();
    let joint = if hinge { Joint::hinge(hook, bob, Vec3::ZERO, Vec3::Z) } else { Joint::ball(hook, bob, Vec3::ZERO) };
    world.add_joint(joint).unwrap();

    // From the first to the third way through the lowest point: once there and back.
    let (mut crossings, mut last) = (Vec::new(), f64::from(center.x));
    while crossings.len() < 3 {
        let before = world.time();
        world.step(dt);
        let x = f64::from(body(&world, bob).center().x);
        if last * x < 0.0 {
            crossings.push(before + f64::from(dt) * last / (last - x));
        }
        last = x;
        assert!(world.time() < 20.0);
    }
    let inertia = 1.0 + 0.4 * RADIUS * RADIUS; // of 1 kg about the hinge
    let small_swings = std::f64::consts::TAU * (inertia / G).sqrt();
    (crossings[2] - crossings[0]) / small_swings
}

/// What f32 leaves of a period: near the upright it feels every rounding of the energy.
fn rounding(degrees: f64) -> f64 {
    if degrees > 150.0 { 1e-4 } else { 2e-5 }
}

#[test]
fn pendulum_keeps_its_period() {
    for (degrees, ratio) in AMPLITUDES {
        let errors = STEPS.map(|dt| relative(period_ratio(world(), degrees, dt, true), ratio));
        converges(&format!("period at {degrees}°, hinge"), errors, 1.0, rounding(degrees), 1e-3);
    }
}

#[test]
fn pendulum_keeps_its_period_with_default_options() {
    for (degrees, ratio) in AMPLITUDES {
        for hinge in [true, false] {
            let errors = DEFAULT_STEPS.map(|dt| relative(period_ratio(default_world(), degrees, dt, hinge), ratio));
            converges(&format!("period at {degrees}° by default, hinge {hinge}"), errors, 1.0, rounding(degrees), 1e-3);
        }
    }
}

#[test]
fn pendulum_on_a_ball_joint_keeps_its_period() {
    for (degrees, ratio) in [AMPLITUDES[1], AMPLITUDES[3]] {
        let errors = STEPS.map(|dt| relative(period_ratio(world(), degrees, dt, false), ratio));
        converges(&format!("period at {degrees}°, ball joint"), errors, 1.0, 2e-5, 1e-3);
    }
}

/// A top on its tip, started in the slow regular precession:
/// Ω is the lesser root of I₁ cosθ Ω² − I₃ ω₃ Ω + m g d = 0, near m g d/(I₃ ω₃) for a fast one.
#[test]
fn top_precesses() {
    const D: f64 = 0.2; // from the tip to the center, m
    const AXIAL: f64 = 0.02; // kg·m²
    const ACROSS: f64 = 0.0125; // about the center, kg·m²
    for (spin, lean) in [(60.0_f64, 0.35_f64), (150.0, 0.8)] {
        let about_tip = (ACROSS + D * D) * lean.cos();
        let momentum = AXIAL * spin;
        let exact = (momentum - (momentum * momentum - 4.0 * about_tip * G * D).sqrt()) / (2.0 * about_tip);
        let fast = G * D / momentum;
        let errors = STEPS.map(|dt| {
            let mut world = world();
            let stand = world.add_body(Body::empty(BodyKind::Fixed)).unwrap();
            let axis = Vec3::new(lean.sin() as f32, lean.cos() as f32, 0.0);
            let angular_velocity = exact as f32 * Vec3::Y + (spin - exact * lean.cos()) as f32 * axis;
            let properties = MassProperties {
                mass: 1.0,
                center: D as f32 * Vec3::Y,
                principal_inertia: Vec3::new(ACROSS as f32, AXIAL as f32, ACROSS as f32),
                principal_frame: Quat::IDENTITY,
            };
            let top = Body::empty(BodyKind::Dynamic)
                .mass_properties(properties)
                .rotated(Quat::from_rotation_z(-lean as f32))
                .angular_velocity(angular_velocity)
                .velocity(angular_velocity.cross(D as f32 * axis));
            let top = world.add_body(top).unwrap();
            world.add_joint(Joint::ball(stand, top, Vec3::ZERO)).unwrap();
            let azimuth = |world: &ishigaki::World| {
                let center = body(world, top).center();
                f64::from(-center.z).atan2(center.x.into())
            };
            // Less than half a turn, so that the azimuth needs no count of turns.
            let t = laws::run(&mut world, 2.5 / exact, dt);
            let tilt = f64::from(body(&world, top).center().y / D as f32).acos();
            eprintln!("top, {spin} rad/s: leans {tilt:.4} rad instead of {lean}");
            relative(azimuth(&world) / t, exact)
        });
        eprintln!("top, {spin} rad/s: Ω = {exact:.4} rad/s, fast-top approximation {fast:.4}");
        // The faster top is within 2e-4 already at 1/60 s: what is left of 1e-4 shows no order.
        converges(&format!("precession at {spin} rad/s"), errors, 1.0, 1e-4, 1e-3);
    }
}
