//! Laws of free motion, through a world: falling, and turning without torque.

mod laws;

use ishigaki::{Body, MassProperties, Pose, Quat, Shape, Vec3, World};
use laws::{G, STEPS, body, converges, options, relative, run, world};

/// TALK A1: symplectic Euler falls g h² n(n+1)/2 in n substeps of h, to rounding, and so ½ g t² to first order.
#[test]
fn free_fall() {
    let errors = STEPS.map(|dt| {
        let mut world = world();
        let ball = world.add_body(Body::dynamic(Shape::ball(0.1))).unwrap();
        let time = run(&mut world, 1.0, dt);
        let fallen = -f64::from(body(&world, ball).center().y);
        let substeps = world.options().solver.substeps;
        let h = f64::from(dt) / f64::from(substeps);
        let n = (time / h).round();
        let discrete = G * h * h * n * (n + 1.0) / 2.0;
        // n sums in f32 each round by half a unit in the last place of at most `fallen`.
        let rounding = relative(fallen, discrete);
        eprintln!("fall of {n} substeps: {fallen:.6} m, off the discrete sum by {rounding:.1e}");
        assert!(rounding < 1e-8 * n + 1e-6, "{fallen} m instead of {discrete} m");
        relative(fallen, 0.5 * G * time * time)
    });
    converges("free fall ½gt²", errors, 1.0, 1e-6, 0.01);
}

/// Substeps are steps: four in one step fall as far as four steps.
#[test]
fn substeps_fall_like_steps() {
    let fallen = [(1, 1.0 / 240.0), (4, 1.0 / 60.0)].map(|(substeps, dt)| {
        let mut options = options();
        options.solver.substeps = substeps;
        let mut world = World::new(options).unwrap();
        let ball = world.add_body(Body::dynamic(Shape::ball(0.1))).unwrap();
        run(&mut world, 0.5, dt);
        f64::from(body(&world, ball).center().y)
    });
    assert!(relative(fallen[0], fallen[1]) < 1e-5, "{fallen:?}");
}

/// Time between flips of a free body with moments (1, 2, 3) kg·m²: 2K(k)/ω_p, from Jacobi's solution of Euler's
/// equations (Landau, Lifshitz, Mechanics, § 37). `omega` in the body's axes, rad/s.
fn flip_interval(omega: [f64; 3]) -> f64 {
    let [w1, w2, w3] = omega;
    let double_energy = w1 * w1 + 2.0 * w2 * w2 + 3.0 * w3 * w3;
    let square_momentum = w1 * w1 + 4.0 * w2 * w2 + 9.0 * w3 * w3;
    // Turning about axis 3 on the whole, or about axis 1: the same with the axes exchanged.
    let (i1, i3) = if square_momentum > 2.0 * double_energy { (1.0, 3.0) } else { (3.0, 1.0) };
    let (far, near) = (square_momentum - double_energy * i1, double_energy * i3 - square_momentum);
    let rate = ((i3 - 2.0) * far / (i1 * 2.0 * i3)).sqrt();
    let square_modulus = (2.0 - i1) * near / ((i3 - 2.0) * far);
    // K(k) = π / (2 agm(1, √(1 − k²)))
    let (mut a, mut b) = (1.0_f64, (1.0 - square_modulus).sqrt());
    for _ in 0..20 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    std::f64::consts::PI / (a * rate)
}

/// Mean interval of the first flips of such a body, s; L and energy are watched on the way.
fn measured_interval(omega: [f64; 3], dt: f32, substeps: u32, flips: usize, energy_error: f64) -> f64 {
    let mut options = options();
    options.gravity = Vec3::ZERO;
    options.solver.substeps = substeps;
    let mut world = World::new(options).unwrap();
    let properties = MassProperties {
        mass: 1.0,
        center: Vec3::ZERO,
        principal_inertia: Vec3::new(1.0, 2.0, 3.0),
        principal_frame: Quat::IDENTITY,
    };
    let spin = Vec3::from_array(omega.map(|w| w as f32));
    let plate = Body::dynamic(Shape::cuboid(2.4, 1.7, 0.1)).mass_properties(properties).angular_velocity(spin);
    let plate = world.add_body(plate).unwrap();
    let (momentum, energy) = (body(&world, plate).angular_momentum(), body(&world, plate).kinetic_energy());

    let (mut times, mut last, mut worst) = (Vec::new(), omega[1], 0.0_f64);
    while times.len() <= flips {
        let before = world.time();
        let report = world.step(dt);
        let state = body(&world, plate);
        let about_middle = f64::from((state.rotation().conjugate() * state.angular_velocity()).y);
        if last * about_middle < 0.0 {
            times.push(before + f64::from(dt) * last / (last - about_middle));
        }
        last = about_middle;
        worst = worst.max(relative(report.kinetic_energy.into(), energy.into()));
        assert_eq!(state.angular_momentum(), momentum, "nothing pushes: L is kept to the bit");
        assert!((report.angular_momentum - momentum).length() <= 1e-6 * momentum.length());
        assert!(world.time() < 30.0);
    }
    let interval = (times[flips] - times[0]) / flips as f64;
    eprintln!("flip every {interval:.6} s at 1/{:.0} s, energy within {worst:.1e}", 1.0 / dt);
    assert!(worst < energy_error, "energy off by {worst}");
    interval
}

/// Dzhanibekov: a body that turns about its middle axis flips every 1.95529 s. TALK A7.
///
/// This one is so near to the unstable axis that rounding alone decides the third digit: its energy differs by 4e-5
/// from that of the separatrix, where the interval is infinite, and f32 keeps 3e-6 of it.
#[test]
fn tumbling_body_flips() {
    const OMEGA: [f64; 3] = [0.1, 10.0, 0.1];
    let exact = flip_interval(OMEGA);
    assert!((exact - 1.955_29).abs() < 5e-6, "{exact}");
    let errors = STEPS.map(|dt| relative(measured_interval(OMEGA, dt, 4, 2, 2e-5), exact));
    converges("Dzhanibekov's interval", errors, 2.0, 4e-3, 4e-3);
}

/// Away from the separatrix the order shows: two. One substep, so that there is an error to see.
#[test]
fn flips_come_with_order_two() {
    for omega in [[1.0, 8.0, 2.0], [4.0, 6.0, 1.0]] {
        let exact = flip_interval(omega);
        let errors = STEPS.map(|dt| relative(measured_interval(omega, dt, 1, 4, 1e-2), exact));
        converges(&format!("flip interval, {exact:.5} s"), errors, 2.0, 2e-5, 1e-4);
    }
}

/// A thrown body flies a parabola, whatever it does about its center.
#[test]
fn a_spinning_stone_flies_a_parabola() {
    let errors = STEPS.map(|dt| {
        let mut world = world();
        let (velocity, spin) = (Vec3::new(3.0, 6.0, 1.0), Vec3::new(5.0, -8.0, 3.0));
        let stone = Shape::cuboid(0.3, 0.2, 0.1).at(Vec3::new(0.5, 0.0, 0.0));
        let stone = world.add_body(Body::dynamic(stone).velocity(velocity).angular_velocity(spin)).unwrap();
        let start = body(&world, stone).center();
        let t = run(&mut world, 1.0, dt);
        let center = body(&world, stone).center() - start;
        // 3840 sums in f32 at the most.
        assert!(relative(center.x.into(), 3.0 * t) < 1e-4 && relative(center.z.into(), t) < 1e-4, "{center}");
        (f64::from(center.y) - (6.0 * t - 0.5 * G * t * t)).abs()
    });
    converges("height of a thrown stone, m", errors, 1.0, 1e-5, 0.01);
}

/// Between two steps a pose is between the two poses; at the ends it is one of them, and a body that is set elsewhere
/// does not slide there.
#[test]
fn poses_between_steps_are_between() {
    let mut world = world();
    // Its center is not its origin: the origin goes along an arc.
    let shape = Shape::cuboid(0.3, 0.2, 0.1).at(Vec3::new(0.5, 0.0, 0.0));
    let stone = Body::dynamic(shape).velocity(Vec3::new(3.0, 6.0, 1.0)).angular_velocity(Vec3::new(5.0, -8.0, 3.0));
    let stone = world.add_body(stone).unwrap();
    let added = body(&world, stone).pose();
    assert_eq!(body(&world, stone).interpolated_pose(0.5), added, "no step yet: it is where it was put");
    let mut before = added;
    for _ in 0..30 {
        world.step(STEPS[0]);
        let (state, after) = (body(&world, stone), body(&world, stone).pose());
        let (first, last) = (state.interpolated_pose(0.0), state.interpolated_pose(1.0));
        // Not the angle between: its arc cosine magnifies rounding to a milliradian.
        let near = |a: Pose, b: Pose| {
            (a.translation - b.translation).length() < 1e-5 && 1.0 - a.rotation.dot(b.rotation).abs() < 1e-6
        };
        assert!(near(first, before) && near(last, after), "{first:?} {last:?}");
        let half = state.interpolated_pose(0.5);
        let (back, ahead) = (half.rotation.angle_between(before.rotation), half.rotation.angle_between(after.rotation));
        assert!((back - ahead).abs() < 2e-3, "{back} rad and {ahead} rad");
        assert!((half.translation - 0.5 * (before.translation + after.translation)).length() < 1e-5);
        before = after;
    }
    let elsewhere = Pose::from_translation(Vec3::new(100.0, 0.0, 0.0));
    world.body_mut(stone).unwrap().set_pose(elsewhere).unwrap();
    assert_eq!(body(&world, stone).interpolated_pose(0.5), elsewhere);
}
