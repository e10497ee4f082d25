//! Laws of what acts in a joint, in whole worlds: spring, motor, range, dry friction, armature, rope, and the force that
//! the joint says it carries. TALK B9.

mod laws;

use ishigaki::{
    Body, BodyHandle, BodyKind, Drive, Joint, JointHandle, JointKind, MassProperties, Quat, Shape, Vec3, World,
};
use laws::{G, STEPS, body, converges, relative, run, weightless, world};

/// A body of 2 kg without a form and 0.5 kg·m² about each axis.
fn mass() -> Body {
    Body::empty(BodyKind::Dynamic).mass_properties(MassProperties {
        mass: MASS as f32,
        center: Vec3::ZERO,
        principal_inertia: Vec3::splat(INERTIA as f32),
        principal_frame: Quat::IDENTITY,
    })
}
const MASS: f64 = 2.0;
const INERTIA: f64 = 0.5;

/// The mass on a joint to a fixed body at the origin.
fn hang(world: &mut World, joint: impl Fn(BodyHandle, BodyHandle) -> Joint) -> (BodyHandle, JointHandle) {
    let base = world.add_body(Body::empty(BodyKind::Fixed)).unwrap();
    let mass = world.add_body(mass()).unwrap();
    let joint = world.add_joint(joint(base, mass)).unwrap();
    (mass, joint)
}

fn slider(a: BodyHandle, b: BodyHandle, axis: Vec3) -> Joint {
    Joint::slider(a, b, Vec3::ZERO, axis)
}

fn hinge(a: BodyHandle, b: BodyHandle) -> Joint {
    Joint::hinge(a, b, Vec3::ZERO, Vec3::Z)
}

fn coordinate(world: &World, joint: JointHandle) -> f64 {
    world.joint(joint).unwrap().coordinates()[0].into()
}

/// x = e^(−δt) (cos νt + δ/ν sin νt) from rest at 1 m: springs on sliders, angles and distances are the same spring.
#[test]
fn springs_swing_as_they_should() {
    for (stiffness, damping) in [(50.0_f32, 0.0_f32), (50.0, 4.0)] {
        let decay = f64::from(damping) / (2.0 * MASS);
        let frequency = (f64::from(stiffness) / MASS - decay * decay).sqrt();
        let exact = |t: f64| (-decay * t).exp() * ((frequency * t).cos() + decay / frequency * (frequency * t).sin());
        let errors = STEPS.map(|dt| {
            let mut world = weightless();
            let (mass, joint) = hang(&mut world, |a, b| slider(a, b, Vec3::X).spring(-1.0, stiffness, damping));
            let t = run(&mut world, 1.0, dt);
            let x = f64::from(body(&world, mass).center().x) + 1.0;
            assert!((coordinate(&world, joint) + 1.0 - x).abs() < 1e-4, "the coordinate is the displacement");
            (x - exact(t)).abs()
        });
        converges(&format!("spring on a slider, damping {damping}"), errors, 1.0, 1e-5, 0.01);

        // The same by scale: k I/m about a hinge.
        let errors = STEPS.map(|dt| {
            let mut world = weightless();
            let part = (INERTIA / MASS) as f32;
            let (_, joint) = hang(&mut world, |a, b| hinge(a, b).spring(-1.0, part * stiffness, part * damping));
            let t = run(&mut world, 1.0, dt);
            (coordinate(&world, joint) + 1.0 - exact(t)).abs()
        });
        converges(&format!("spring on a hinge, damping {damping}"), errors, 1.0, 1e-5, 0.01);

        let errors = STEPS.map(|dt| {
            let mut world = weightless();
            let base = world.add_body(Body::empty(BodyKind::Fixed)).unwrap();
            let mass = world.add_body(mass().at(3.0 * Vec3::X)).unwrap();
            let spring = Joint::distance(base, mass, Vec3::ZERO, Vec3::ZERO, 0.0..=f32::INFINITY);
            world.add_joint(spring.spring(2.0, stiffness, damping)).unwrap();
            let t = run(&mut world, 1.0, dt);
            (f64::from(body(&world, mass).center().x) - 2.0 - exact(t)).abs()
        });
        converges(&format!("spring of a distance, damping {damping}"), errors, 1.0, 1e-5, 0.01);
    }
}

/// A motor gives its greatest effort until the speed is there, then what it takes to keep it: ω(t − Iω/2τ).
#[test]
fn motors_run_up_with_their_effort() {
    let (speed, effort) = (4.0_f32, 5.0_f32);
    let errors = STEPS.map(|dt| {
        let mut world = weightless();
        let (_, joint) = hang(&mut world, |a, b| hinge(a, b).motor(speed, effort));
        run(&mut world, 0.2, dt);
        let torque = f64::from(world.joint(joint).unwrap().torque().length());
        assert!(relative(torque, effort.into()) < 1e-3, "{torque} N·m while it runs up");
        let t = 0.2 + run(&mut world, 0.8, dt);
        let state = world.joint(joint).unwrap();
        assert!(state.torque().length() < 1e-3, "{} N·m at speed, without load", state.torque());
        let run_up = INERTIA * f64::from(speed) / f64::from(effort);
        relative(coordinate(&world, joint), f64::from(speed) * (t - 0.5 * run_up))
    });
    converges("motor that runs up", errors, 1.0, 1e-5, 0.01);
}

/// A rotor geared to an axis adds its inertia to it: α = τ/(I + A).
#[test]
fn armature_adds_inertia() {
    let (armature, torque) = (1.5_f32, 3.0_f32);
    for dt in STEPS {
        let mut world = weightless();
        let drive = Drive { armature, ..Drive::default() };
        let (wheel, _) = hang(&mut world, |a, b| Joint { kind: JointKind::Hinge { drive }, ..hinge(a, b) });
        let mut t = 0.0;
        for _ in 0..(1.0 / dt).round() as usize {
            world.body_mut(wheel).unwrap().apply_torque(torque * Vec3::Z).unwrap();
            world.step(dt);
            t += f64::from(dt);
        }
        let speed = f64::from(body(&world, wheel).angular_velocity().z);
        assert!(relative(speed, f64::from(torque) * t / (INERTIA + f64::from(armature))) < 1e-4, "{speed} rad/s");
    }
}

/// What falls to the end of its range stays there, and the joint carries its weight; so does a rope.
#[test]
fn ranges_and_ropes_hold_the_weight() {
    for dt in STEPS {
        let range = |a, b| slider(a, b, Vec3::NEG_Y).limit(0.0..=0.3);
        let rope = |a, b| Joint::rope(a, b, Vec3::ZERO, Vec3::ZERO, 0.3);
        for (name, joint) in [("range", &range as &dyn Fn(_, _) -> Joint), ("rope", &rope)] {
            let mut world = world();
            let (mass, joint) = hang(&mut world, joint);
            run(&mut world, 2.0, dt);
            let (y, state) = (body(&world, mass).center().y, world.joint(joint).unwrap());
            eprintln!("{name} at 1/{:.0} s: {y} m, carries {} N", 1.0 / dt, state.force());
            assert!((y + 0.3).abs() < 1e-3, "{name}: ends at {y} m");
            // On body A, which is above: it is drawn down.
            let weight = f64::from(-state.force().y);
            assert!(relative(weight, MASS * G) < 1e-3, "{name}: carries {} N", state.force());
        }
    }
}

/// A light arm with a heavy ball welded on that falls on the end of its range stops there: a limit without restitution
/// gives no energy back, however little of the load its own two bodies are.
#[test]
fn the_end_of_a_range_gives_nothing_back() {
    for (ratio, dt) in [1.0, 10.0, 100.0].into_iter().flat_map(|ratio| STEPS.map(|dt| (ratio, dt))) {
        let mut world = world();
        let wall = world.add_body(Body::empty(BodyKind::Fixed)).unwrap();
        let arm = Body::dynamic(Shape::cuboid(0.5, 0.05, 0.05)).mass(5.0).at(0.5 * Vec3::X);
        let arm = world.add_body(arm).unwrap();
        let hinge = world.add_joint(Joint::hinge(wall, arm, Vec3::ZERO, Vec3::Z).limit(-0.5..=1.0)).unwrap();
        let ball = world.add_body(Body::dynamic(Shape::ball(0.1)).mass(5.0 * ratio).at(Vec3::X)).unwrap();
        world.add_joint(Joint::fixed(arm, ball, Vec3::X)).unwrap();
        let mut landed = false;
        while world.time() < 2.0 {
            world.step(dt);
            let above = coordinate(&world, hinge) + 0.5;
            landed |= above < 1e-3;
            let worst = if landed { 1e-3 } else { f64::INFINITY };
            assert!(
                (-1e-3..=worst).contains(&above),
                "ball of {ratio} arms: {above} rad from the end at {} s",
                world.time()
            );
        }
        assert!(landed);
    }
}

/// Dry friction F holds what pulls less, and takes F from what pulls more.
#[test]
fn dry_friction_of_a_joint_is_a_bounded_effort() {
    for dt in STEPS {
        for part in [1.01, 0.5] {
            let mut world = world();
            let effort = (part * MASS * G) as f32;
            let (mass, _) = hang(&mut world, |a, b| slider(a, b, Vec3::NEG_Y).dry_friction(effort));
            let t = run(&mut world, 1.0, dt);
            let speed = -f64::from(body(&world, mass).velocity().y);
            let exact = (G - f64::from(effort) / MASS).max(0.0) * t;
            assert!(
                (speed - exact).abs() < 1e-3 * (1.0 + exact),
                "{speed} m/s instead of {exact}, friction {effort} N"
            );
        }
    }
}
