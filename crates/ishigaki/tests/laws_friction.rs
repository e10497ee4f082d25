//! Laws of dry friction: sliding, sticking, rolling, tipping, conveyors. TALK C2.

mod laws;

use ishigaki::{Body, BodyHandle, FrictionModel, Material, Quat, Shape, Vec3, World};
use laws::{DEFAULT_STEPS, G, STEPS, body, converges, default_world, options, relative, run, world};

/// A half-space that falls toward +x by `angle` and the direction of steepest descent.
fn slope(world: &mut World, angle: f32, friction: f32) -> (Vec3, Vec3) {
    let (sine, cosine) = (f64::from(angle).sin() as f32, f64::from(angle).cos() as f32);
    let normal = Vec3::new(sine, cosine, 0.0);
    world.add_body(Body::fixed(Shape::half_space(normal).friction(friction))).unwrap();
    (normal, Vec3::new(cosine, -sine, 0.0))
}

/// A flat block of 1 × 0.2 × 1 m that lies on the slope.
fn block_on_slope(world: &mut World, angle: f32, friction: f32) -> (BodyHandle, Vec3) {
    let (normal, down) = slope(world, angle, friction);
    let block = Body::dynamic(Shape::cuboid(0.5, 0.1, 0.5).friction(friction));
    let block = block.at(0.1 * normal).rotated(Quat::from_rotation_z(-angle));
    (world.add_body(block).unwrap(), down)
}

fn floor(world: &mut World, friction: f32) {
    world.add_body(Body::fixed(Shape::half_space(Vec3::Y).friction(friction))).unwrap();
}

/// a = g (sin θ − μ cos θ). Once the block carries its weight its speed has no error but rounding; its way is that of
/// symplectic Euler. Gives the error of the way.
fn slide_down(mut world: World, dt: f32) -> f64 {
    let (angle, friction) = (30.0_f32.to_radians(), 0.3);
    let acceleration = G * (f64::from(angle).sin() - f64::from(friction) * f64::from(angle).cos());
    let (block, down) = block_on_slope(&mut world, angle, friction);
    run(&mut world, 0.1, dt);
    let (start, speed) = (body(&world, block).center(), f64::from(body(&world, block).velocity().dot(down)));
    let t = run(&mut world, 1.0, dt);
    let state = body(&world, block);
    let speed_error = relative(f64::from(state.velocity().dot(down)) - speed, acceleration * t);
    eprintln!("sliding speed off by {speed_error:.1e} at 1/{:.0} s", 1.0 / dt);
    assert!(speed_error < 2e-4, "speed off by {speed_error}");
    relative((state.center() - start).dot(down).into(), speed * t + 0.5 * acceleration * t * t)
}

#[test]
fn block_slides_down_a_slope() {
    let law = "sliding v₀t + ½g(sinθ − μcosθ)t²";
    // One substep: with more, rounding of their many impulses hides the order at 1/960 s.
    let mut one = laws::options();
    one.solver.substeps = 1;
    let world = || World::new(one.clone()).unwrap();
    converges(law, STEPS.map(|dt| slide_down(world(), dt)), 1.0, 1e-5, 0.02);
    converges(law, DEFAULT_STEPS.map(|dt| slide_down(default_world(), dt)), 1.0, 1e-5, 0.01);
}

/// tan θ < μ: nothing moves, not even slowly.
fn stick(mut world: World, dt: f32) {
    // 98 % of the slope at which it would slide.
    let (angle, friction) = ((0.98_f64 * 0.6).atan() as f32, 0.6);
    let (block, down) = block_on_slope(&mut world, angle, friction);
    run(&mut world, 0.1, dt);
    let start = body(&world, block).center();
    run(&mut world, 5.0, dt);
    let creep = (body(&world, block).center() - start).dot(down);
    eprintln!("creep in 5 s at 1/{:.0} s: {creep:.1e} m", 1.0 / dt);
    assert!(creep.abs() < 1e-5, "crept {creep} m in 5 s");
}

#[test]
fn block_sticks_on_a_slope() {
    STEPS.iter().for_each(|&dt| stick(world(), dt));
    DEFAULT_STEPS.iter().for_each(|&dt| stick(default_world(), dt));
}

/// v²/(2 μ g).
fn stop(mut world: World, dt: f32) -> f64 {
    let friction = 0.5;
    floor(&mut world, friction);
    let block = Body::dynamic(Shape::cuboid(0.5, 0.1, 0.5).friction(friction));
    let block = world.add_body(block.at(0.1 * Vec3::Y).velocity(4.0 * Vec3::X)).unwrap();
    run(&mut world, 1.0, dt);
    let state = body(&world, block);
    assert!(state.velocity().length() < 1e-5, "still moves with {}", state.velocity());
    relative(state.center().x.into(), 16.0 / (2.0 * f64::from(friction) * G))
}

#[test]
fn sliding_block_stops() {
    converges("stop distance v²/2μg", STEPS.map(|dt| stop(world(), dt)), 1.0, 1e-5, 0.01);
    converges("stop distance v²/2μg", DEFAULT_STEPS.map(|dt| stop(default_world(), dt)), 1.0, 1e-5, 0.01);
}

/// A ball that rolls without slipping gains 5/7 g sin θ.
fn roll_down(mut world: World, dt: f32) -> f64 {
    let angle = 20.0_f32.to_radians();
    let acceleration = 5.0 / 7.0 * G * f64::from(angle).sin();
    let (normal, down) = slope(&mut world, angle, 0.6);
    let ball = world.add_body(Body::dynamic(Shape::ball(0.25)).at(0.25 * normal)).unwrap();
    let start = body(&world, ball).center();
    let t = run(&mut world, 1.0, dt);
    let state = body(&world, ball);
    let speed = f64::from(state.velocity().dot(down));
    let rolling = f64::from(0.25 * state.angular_velocity().dot(-Vec3::Z));
    assert!(relative(speed, acceleration * t) < 1e-4, "{speed} m/s instead of {}", acceleration * t);
    assert!(relative(rolling, speed) < 1e-4, "it slips: {rolling} {speed}");
    relative((state.center() - start).dot(down).into(), 0.5 * acceleration * t * t)
}

#[test]
fn ball_rolls_down_a_slope() {
    let law = "rolling ½·5/7·g·sinθ·t²";
    converges(law, STEPS.map(|dt| roll_down(world(), dt)), 1.0, 1e-5, 0.01);
    converges(law, DEFAULT_STEPS.map(|dt| roll_down(default_world(), dt)), 1.0, 1e-5, 0.01);
}

/// A ball of radius 0.5 m whose material resists spin and rolling by these lengths, m, on a floor or slope.
fn resisted_ball(world: &mut World, angle: f32, torsional: f32, rolling: f32) -> (BodyHandle, Vec3) {
    let (normal, down) = slope(world, angle, 0.6);
    let material = Material { torsional_friction: torsional, rolling_friction: rolling, ..Material::default() };
    let ball = Body::dynamic(Shape::ball(0.5).material(material)).at(0.5 * normal);
    (world.add_body(ball).unwrap(), down)
}

/// Torsional friction ℓ: a ball that spins about the normal is slowed by ℓ m g, by 5ℓg/2r² that is, and turns ω²/2α.
#[test]
fn a_spinning_ball_stops() {
    let (length, spin) = (0.02_f32, 2.0_f32);
    let slowing = 5.0 * f64::from(length) * G / (2.0 * 0.25);
    let errors = STEPS.map(|dt| {
        let mut world = world();
        let (ball, _) = resisted_ball(&mut world, 0.0, length, 0.0);
        world.body_mut(ball).unwrap().set_angular_velocity(spin * Vec3::Y).unwrap();
        run(&mut world, 0.5, dt);
        let left = f64::from(body(&world, ball).angular_velocity().y);
        assert!((left - (f64::from(spin) - 0.5 * slowing)).abs() < 0.02, "{left} rad/s after half a second");
        run(&mut world, 1.0, dt);
        let state = body(&world, ball);
        assert!(state.angular_velocity().length() < 1e-4, "still turns with {}", state.angular_velocity());
        assert!(state.velocity().length() < 1e-5, "wanders with {}", state.velocity());
        relative(state.rotation().to_scaled_axis().y.into(), f64::from(spin).powi(2) / (2.0 * slowing))
    });
    converges("angle of a spinning ball ω²/2α", errors, 1.0, 1e-4, 0.01);
}

/// Rolling friction ℓ: a ball that rolls is slowed by 5/7 g ℓ/r, straight ahead in whatever direction it goes.
#[test]
fn a_rolling_ball_stops() {
    let (length, speed) = (0.04_f32, 0.6_f32);
    let exact = f64::from(speed).powi(2) / (2.0 * 5.0 / 7.0 * G * f64::from(length) / 0.5);
    for degrees in [0.0_f64, 30.0] {
        let along = Vec3::new(degrees.to_radians().cos() as f32, 0.0, degrees.to_radians().sin() as f32);
        let across = along.cross(Vec3::Y);
        let errors = STEPS.map(|dt| {
            let mut world = world();
            let (ball, _) = resisted_ball(&mut world, 0.0, 0.0, length);
            let mut edit = world.body_mut(ball).unwrap();
            edit.set_velocity(speed * along).unwrap();
            edit.set_angular_velocity(-speed / 0.5 * across).unwrap();
            run(&mut world, 2.0, dt);
            let state = body(&world, ball);
            assert!(state.velocity().length() < 1e-4, "still rolls with {}", state.velocity());
            assert!(state.center().dot(across).abs() < 1e-3, "leaves its line: {}", state.center());
            relative(state.center().dot(along).into(), exact)
        });
        converges(&format!("way of a rolling ball at {degrees}°"), errors, 1.0, 1e-4, 0.01);
    }
}

/// tan θ < ℓ/r: a ball lies still on a slope; above it rolls with 5/7 g (sin θ − ℓ/r cos θ).
#[test]
fn a_resisted_ball_rolls_only_on_a_steep_slope() {
    let length = 0.05_f32;
    let critical = f64::from(length) / 0.5;
    for dt in STEPS {
        for part in [0.95, 1.2] {
            let angle = (part * critical).atan();
            let mut world = world();
            let (ball, down) = resisted_ball(&mut world, angle as f32, 0.0, length);
            run(&mut world, 0.1, dt);
            let start = body(&world, ball).velocity().dot(down);
            let t = run(&mut world, 2.0, dt);
            let gained = f64::from(body(&world, ball).velocity().dot(down) - start);
            let exact = 5.0 / 7.0 * G * (angle.sin() - critical * angle.cos()).max(0.0) * t;
            eprintln!("{part} of the slope at 1/{:.0} s: {gained:.5} m/s, exact {exact:.5}", 1.0 / dt);
            assert!((gained - exact).abs() < 1e-4 + 0.005 * exact, "{gained} m/s instead of {exact}");
        }
    }
}

/// A box pushed at a height: it slides above μmg, tips above mg·a/height. 2 % to either side of the lesser threshold
/// tell which comes first.
#[test]
fn box_tips_or_slides() {
    const HALF_WIDTH: f32 = 0.5;
    const HALF_HEIGHT: f32 = 1.0;
    let friction = 0.4;
    // Above a/μ it tips first.
    let even = HALF_WIDTH / friction;
    for dt in STEPS {
        for (height, tips) in [(0.9 * even, false), (1.1 * even, true)] {
            for part in [0.98, 1.02] {
                let mut world = world();
                floor(&mut world, friction);
                let tall = Shape::cuboid(HALF_WIDTH, HALF_HEIGHT, 0.5).friction(friction);
                let tall = world.add_body(Body::dynamic(tall).at(HALF_HEIGHT * Vec3::Y)).unwrap();
                let weight = body(&world, tall).mass() * G as f32;
                let push = part * weight * f32::min(friction, HALF_WIDTH / height);
                for _ in 0..(1.0 / dt).round() as usize {
                    let center = body(&world, tall).center();
                    let point = Vec3::new(center.x, height, center.z);
                    world.body_mut(tall).unwrap().apply_force_at(push * Vec3::X, point).unwrap();
                    world.step(dt);
                }
                let state = body(&world, tall);
                let lean = -state.rotation().to_scaled_axis().z;
                // Where the foot about which it tips has gone.
                let foot = state.pose() * Vec3::new(HALF_WIDTH, -HALF_HEIGHT, 0.0);
                let slid = foot.x - HALF_WIDTH;
                eprintln!("push at {height:.3} m, {part} of the threshold: slid {slid:.1e} m, leans {lean:.1e} rad");
                assert_eq!(lean > 0.01, tips && part > 1.0, "lean {lean} rad at {height} m, {part}, dt {dt}");
                assert_eq!(slid > 0.02, !tips && part > 1.0, "slid {slid} m at {height} m, {part}, dt {dt}");
            }
        }
    }
}

/// Pushes a box on the floor for a second with 1.2 μN at `degrees` from the first tangent; gives its velocity along
/// both tangents.
fn pushed(model: FrictionModel, degrees: f32, dt: f32) -> (f32, f32) {
    let mut options = options();
    options.solver.friction = model;
    let mut world = World::new(options).unwrap();
    floor(&mut world, 0.5);
    let block = Body::dynamic(Shape::cuboid(0.5, 0.1, 0.5).friction(0.5)).at(0.1 * Vec3::Y);
    let block = world.add_body(block).unwrap();
    let (t1, t2) = ishigaki::math::tangents(Vec3::Y);
    let angle = f64::from(degrees).to_radians();
    let direction = angle.cos() as f32 * t1 + angle.sin() as f32 * t2;
    let push = 1.2 * 0.5 * body(&world, block).mass() * G as f32 * direction;
    for _ in 0..(1.0 / dt).round() as usize {
        world.body_mut(block).unwrap().apply_force(push).unwrap();
        world.step(dt);
    }
    let velocity = body(&world, block).velocity();
    (velocity.dot(t1), velocity.dot(t2))
}

/// The disk is Coulomb's law: the block moves along the push with a = 0.2 μg, whatever the direction.
#[test]
fn disk_slides_along_the_push() {
    for dt in STEPS {
        for degrees in [0.0, 22.5, 45.0, 70.0] {
            let (x, y) = pushed(FrictionModel::Disk, degrees, dt);
            let direction = f64::from(y).atan2(f64::from(x)).to_degrees();
            let speed = f64::from(x).hypot(f64::from(y));
            eprintln!("disk, push at {degrees}°: {speed:.4} m/s at {direction:.3}°");
            assert!((direction - f64::from(degrees)).abs() < 1.0, "goes {direction}° when pushed at {degrees}°");
            assert!(relative(speed, 0.2 * 0.5 * G) < 0.005, "{speed} m/s");
        }
    }
}

/// The box overestimates by up to √2: at 45° it sticks, at 22.5° it slides along the major axis alone.
#[test]
fn box_friction_depends_on_the_direction() {
    for dt in STEPS {
        let (x, y) = pushed(FrictionModel::Box, 45.0, dt);
        assert!(x.hypot(y) < 1e-4, "slides at 45°: {x} {y}");
        let (x, y) = pushed(FrictionModel::Box, 22.5, dt);
        eprintln!("box, push at 22.5°: {x:.4} m/s along the major axis, {y:.1e} across");
        assert!(y.abs() < 0.01 * x, "slides across: {x} {y}");
        let acceleration = 0.5 * G * (1.2 * 22.5_f64.to_radians().cos() - 1.0);
        assert!(relative(x.into(), acceleration) < 0.01, "{x} m/s instead of {acceleration}");
    }
}

/// A box set on a belt of speed v slips for v/(μg), is carried half as far as the belt goes meanwhile, then rides.
#[test]
fn conveyor_carries() {
    let (friction, belt) = (0.4_f32, 2.0_f32);
    let errors = STEPS.map(|dt| {
        let mut world = world();
        let mut shape = Shape::half_space(Vec3::Y).friction(friction);
        shape.material.surface_velocity = belt * Vec3::X;
        world.add_body(Body::fixed(shape)).unwrap();
        let parcel = Body::dynamic(Shape::cuboid(0.5, 0.1, 0.5).friction(friction)).at(0.1 * Vec3::Y);
        let parcel = world.add_body(parcel).unwrap();
        let t = run(&mut world, 1.0, dt);
        let state = body(&world, parcel);
        assert!((state.velocity() - belt * Vec3::X).length() < 1e-4, "rides with {}", state.velocity());
        let slip_time = f64::from(belt) / (f64::from(friction) * G);
        let exact = f64::from(belt) * (t - 0.5 * slip_time);
        relative(state.center().x.into(), exact)
    });
    converges("way on a conveyor", errors, 1.0, 1e-5, 0.01);
}
