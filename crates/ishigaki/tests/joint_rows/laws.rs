//! What the rows do: conserve momentum, pull errors back, hold limits, integrate springs implicitly.

use crate::oracle::{Placed, Random, Velocities, narrow, rate, solve, wide};
use crate::{Case, STEP, case, centered, definition, kinds};
use ishigaki::constraint::joint_rows::{JointStep, reaction};
use ishigaki::constraint::row::RowSpec;
use ishigaki::{Drive, Freedom, JointFrames, JointKind, Motor, Pose, Range, Spring};
use parry3d::glamx::{DQuat, DVec3};

/// Inverse masses of v_A, ω_A, v_B, ω_B.
const MASSES: [f64; 4] = [1.0, 2.5, 0.5, 1.7];
const A_IS_FIXED: [f64; 4] = [0.0, 0.0, 1.0, 2.5];

/// TALK B10: λ on a row changes neither linear nor angular momentum of the two bodies together.
#[test]
fn rows_conserve_momentum() {
    let mut random = Random(11);
    for kind in kinds() {
        for _ in 0..30 {
            // Forces act at the two anchors: they must coincide where the joint locks them, here to f32's rounding.
            let mut case = case(kind.clone(), &mut random, 0.0, 0.3);
            let (a, b) = (wide(case.a.center), wide(case.b.center));
            for row in case.rows() {
                let j = row.jacobian;
                let (force, torque_a, torque_b) = (wide(j.linear), wide(j.angular_a), wide(j.angular_b));
                // The force on B is −linear by definition of the row.
                let total = a.cross(force) + torque_a - b.cross(force) + torque_b;
                assert!(total.length() < 5e-6, "{total} of {row:?} in {:?}", case.kind);
            }
        }
    }
}

/// One step at the velocities the rows ask for takes back the `rate` of the error, to first order.
#[test]
fn recovery_reduces_errors() {
    let mut random = Random(12);
    let mut locked = vec![
        JointKind::Ball { cone: None, twist: None, friction: 0.0, damping: 0.0 },
        JointKind::Hinge { drive: Drive::default() },
        JointKind::Slider { drive: Drive::default() },
        JointKind::Fixed,
        JointKind::Distance { range: (0.7..=0.7).into(), spring: None },
    ];
    for kind in kinds() {
        // Full drives would fight each other; the locked rows alone are the question here.
        if matches!(kind, JointKind::Generic { .. }) {
            locked.push(undriven(kind));
        }
    }
    for kind in locked {
        for _ in 0..10 {
            check_recovery(case(kind.clone(), &mut random, 0.02, 0.1));
        }
    }
    let ball = |cone: f32, twist| JointKind::Ball { cone: Some(cone), twist: Some(twist), friction: 0.0, damping: 0.0 };
    let hinge = |limit| JointKind::Hinge { drive: Drive { limit: Some(limit), ..Drive::default() } };
    for kind in [
        ball(0.0, (0.0..=0.0).into()),
        ball(0.1, (-0.1..=0.1).into()),
        hinge((0.2..=0.2).into()),
        hinge((-0.1..=0.1).into()),
    ] {
        for _ in 0..10 {
            let relative = DQuat::from_scaled_axis(random.vector(0.4));
            check_recovery(centered(kind.clone(), relative, random.vector(0.02)));
        }
    }
}

fn check_recovery(mut case: Case) {
    let before = errors(&case);
    advance(&mut case, MASSES, &mut [DVec3::ZERO; 4]);
    let after = errors(&case);
    for (before, after) in before.into_iter().zip(after) {
        let expected = (1.0 - STEP.recovery_rate) * before;
        assert!((after - expected).abs() < 0.1 * before + 1e-4, "{before} → {after} in {:?}", case.kind);
    }
}

fn errors(case: &Case) -> [f32; 2] {
    [case.joint.anchor_error(&case.kind, &case.a, &case.b), case.joint.angle_error(&case.kind, &case.a, &case.b)]
}

/// Solves the rows and moves the bodies for one substep.
fn advance(case: &mut Case, masses: [f64; 4], u: &mut Velocities) -> Vec<RowSpec> {
    let rows = case.rows();
    solve(&rows, masses, u);
    let h = f64::from(STEP.h);
    case.a = Placed::of(&case.a).moved(u[0], u[1], h).frame();
    case.b = Placed::of(&case.b).moved(u[2], u[3], h).frame();
    rows
}

/// Two seconds of swinging from a fixed body: joints stay together, and no energy comes out of nothing.
#[test]
fn swinging_bodies_stay_joined() {
    let mut random = Random(18);
    let h = f64::from(STEP.h);
    for kind in kinds() {
        let kind = undriven(kind);
        let mut case = case(kind, &mut random, 0.0, 0.0);
        if let JointKind::Distance { range, .. } = &mut case.kind {
            // A rod as long as the anchors are apart.
            let length = case.joint.coordinates()[0];
            *range = (length..=length).into();
        }
        let energy = |case: &Case, u: &Velocities| {
            0.5 * u[2].length_squared() / MASSES[2]
                + 0.5 * u[3].length_squared() / MASSES[3]
                + 9.81 * f64::from(case.b.center.y) / MASSES[2]
        };
        let masses = [0.0, 0.0, MASSES[2], MASSES[3]];
        let mut u = [DVec3::ZERO; 4];
        solve(&case.rows(), masses, &mut u);
        let start = energy(&case, &u);
        let (mut anchor, mut angle, mut gain) = (0.0f32, 0.0f32, f64::MIN);
        for _ in 0..480 {
            u[2].y -= 9.81 * h;
            advance(&mut case, masses, &mut u);
            let [anchor_now, angle_now] = errors(&case);
            (anchor, angle) = (anchor.max(anchor_now), angle.max(angle_now));
            gain = gain.max(energy(&case, &u) - start);
        }
        println!("anchor {anchor:.1e} m, angle {angle:.1e} rad, energy {gain:+.2} J");
        assert!(anchor < 0.01 && angle < 0.02 && gain < 1.0, "{anchor} {angle} {gain} in {:?}", case.kind);
    }
}

fn undriven(kind: JointKind) -> JointKind {
    match kind {
        JointKind::Ball { .. } => JointKind::Ball { cone: None, twist: None, friction: 0.0, damping: 0.0 },
        JointKind::Hinge { .. } => JointKind::Hinge { drive: Drive::default() },
        JointKind::Slider { .. } => JointKind::Slider { drive: Drive::default() },
        JointKind::Fixed => JointKind::Fixed,
        JointKind::Distance { .. } => JointKind::Distance { range: (0.7..=0.7).into(), spring: None },
        JointKind::Generic { linear, angular } => JointKind::Generic {
            linear: linear.map(|f| if f == Freedom::Locked { f } else { Freedom::Free(Drive::default()) }),
            angular: angular.iter().map(|turn| crate::turn(turn.axis, Drive::default())).collect(),
        },
    }
}

/// A weld that is 170° off turns home the short way, at the rate it should.
#[test]
fn fixed_recovers_from_any_angle() {
    let mut random = Random(13);
    for kind in [JointKind::Fixed, JointKind::Slider { drive: Drive::default() }] {
        for degrees in [1.0f64, 60.0, 90.0, 120.0, 170.0, 179.9] {
            let relative = DQuat::from_axis_angle(random.direction(), degrees.to_radians());
            let mut case = centered(kind.clone(), relative, DVec3::ZERO);
            assert!((case.joint.angle_error(&kind, &case.a, &case.b) - degrees.to_radians() as f32).abs() < 1e-5);
            for n in 1..=20 {
                advance(&mut case, MASSES, &mut [DVec3::ZERO; 4]);
                let expected = degrees.to_radians() * 0.7f64.powi(n);
                let error = f64::from(case.joint.angle_error(&kind, &case.a, &case.b));
                assert!((error - expected).abs() < 1e-3 * expected + 2e-6, "{degrees}°, {n}: {error} for {expected}");
            }
        }
    }
}

/// A hinge whose axes are 170° apart finds back; what is free stays free: no turning about B's axis.
#[test]
fn axis_recovers_from_any_angle() {
    let mut random = Random(14);
    let kind = JointKind::Hinge { drive: Drive::default() };
    for degrees in [1.0f64, 60.0, 89.0, 91.0, 120.0, 170.0, 180.0] {
        let across = DVec3::X.cross(random.direction()).normalize();
        let relative = DQuat::from_axis_angle(across, degrees.to_radians()) * DQuat::from_rotation_x(0.4);
        let mut case = centered(kind.clone(), relative, DVec3::ZERO);
        for n in 1..=20 {
            let axis_b = wide(case.b.rotation * ishigaki::Vec3::X);
            for row in &case.rows()[..2] {
                let free = [DVec3::ZERO, DVec3::ZERO, DVec3::ZERO, axis_b];
                assert!(rate(row, &free).abs() < 1e-6);
            }
            advance(&mut case, MASSES, &mut [DVec3::ZERO; 4]);
            let expected = degrees.to_radians() * 0.7f64.powi(n);
            let error = f64::from(case.joint.angle_error(&kind, &case.a, &case.b));
            assert!((error - expected).abs() < 1e-2 * expected + 2e-6, "{degrees}°, {n}: {error} for {expected}");
        }
    }
}

/// TALK B9: inside, a limit lets the coordinate arrive but not cross; outside it is pulled back, never pushed on.
#[test]
fn limits_push_inward() {
    let h = f64::from(STEP.h);
    let drive = Drive { limit: Some(Range { lower: -0.3, upper: 0.5 }), ..Drive::default() };
    let axes = vec![crate::turn(ishigaki::Vec3::X, drive)];
    let generic = JointKind::Generic { linear: Default::default(), angular: axes };
    for kind in [JointKind::Hinge { drive }, generic, JointKind::Slider { drive }] {
        for (q, speed, expected) in [
            (0.1, 2.0, 2.0),             // inside and slow: free
            (0.499, 10.0, 0.001 / h),    // would cross the upper end: arrives
            (-0.299, -10.0, -0.001 / h), // the lower end
            (0.6, 0.0, -0.3 * 0.1 / h),  // outside: pulled back at the rate
            (-0.4, 0.0, 0.3 * 0.1 / h),  // outside, below
            (0.6, -20.0, -20.0),         // outside and returning fast: left alone
            (-0.4, 20.0, 20.0),
        ] {
            let slider = matches!(kind, JointKind::Slider { .. });
            let (relative, offset) =
                if slider { (DQuat::IDENTITY, DVec3::X * q) } else { (DQuat::from_rotation_x(q), DVec3::ZERO) };
            let mut case = centered(kind.clone(), relative, offset);
            let motion = DVec3::X * speed;
            let mut u = if slider {
                [DVec3::ZERO, DVec3::ZERO, motion, DVec3::ZERO]
            } else {
                [DVec3::ZERO, DVec3::ZERO, DVec3::ZERO, motion]
            };
            let rows = case.rows();
            let lambdas = solve(&rows, A_IS_FIXED, &mut u);
            let found = if slider { u[2].x } else { u[3].x };
            assert!(
                (found - expected).abs() < 1e-3 * expected.abs() + 1e-4,
                "q {q}: {found} for {expected} in {kind:?}"
            );
            assert!(lambdas[0] >= 0.0 && lambdas[1] >= 0.0);
        }
    }
}

/// A relax sweep keeps limits from being crossed but adds no recovery velocity.
#[test]
fn relax_bias_has_no_recovery() {
    let mut random = Random(15);
    for kind in kinds() {
        let mut case = case(kind, &mut random, 0.05, 0.2);
        // A point's bias also looks ahead along the arcs of its arms; without spin there are none.
        for body in [&mut case.a, &mut case.b] {
            (body.angular_velocity, body.gyration) = (ishigaki::Vec3::ZERO, ishigaki::Vec3::ZERO);
        }
        let mut joint = case.joint.clone();
        let with = case.rows();
        let mut without = Vec::new();
        let step = JointStep { recovery_rate: 0.0, ..STEP };
        joint.rows(&case.kind, &case.a, &case.b, &step, &mut without);
        for (with, without) in with.iter().zip(&without) {
            assert_eq!(with.relax_bias, without.bias);
            assert_eq!(with.relax_bias, without.relax_bias);
        }
    }
}

/// A rope slack stays slack, taut stops; a cone stops the nod in its own plane.
#[test]
fn rope_and_cone_hold() {
    let h = f64::from(STEP.h);
    let rope = JointKind::Distance { range: (0.0..=1.0).into(), spring: None };
    for (length, expected) in [(0.5, 3.0), (0.999, 0.001 / h), (1.1, -0.3 * 0.1 / h)] {
        let along = DVec3::new(0.0, 0.6, 0.8);
        let mut case = centered(rope.clone(), DQuat::IDENTITY, along * length);
        let mut u = [DVec3::ZERO, DVec3::ZERO, along * 3.0, DVec3::ZERO];
        assert_eq!(case.rows().len(), 1);
        solve(&case.rows(), A_IS_FIXED, &mut u);
        assert!((u[2].dot(along) - expected).abs() < 1e-3, "{length}: {} for {expected}", u[2].dot(along));
    }
    let cone = JointKind::Ball { cone: Some(0.5), twist: None, friction: 0.0, damping: 0.0 };
    for (angle, expected) in [(0.2, 5.0), (0.49, 0.01 / h), (0.6, -0.3 * 0.1 / h)] {
        let mut case = centered(cone.clone(), DQuat::from_rotation_z(angle), DVec3::ZERO);
        let mut u = [DVec3::ZERO, DVec3::ZERO, DVec3::ZERO, DVec3::new(1.0, 0.0, 5.0)];
        solve(&case.rows(), A_IS_FIXED, &mut u);
        assert!((u[3].z - expected).abs() < 1e-3, "{angle}: {} for {expected}", u[3].z);
        assert!((u[3].x - 1.0).abs() < 1e-6);
    }
}

/// Spring, damping and armature on a hinge with a load: (I + m)(ω⁺ − ω) = hτ − h d ω⁺ − h k(θ + hω⁺ − target).
#[test]
fn passive_row_is_implicit_euler() {
    let (h, inertia, load) = (f64::from(STEP.h), 1.0 / 2.5, 0.8);
    for (stiffness, damping, armature) in
        [(40.0, 0.3, 0.0), (40.0, 0.3, 0.7), (0.0, 0.0, 0.7), (1e7, 0.0, 0.1), (0.0, 2.0, 0.0)]
    {
        let spring = Spring { target: 0.4, stiffness, damping };
        let drive = Drive { spring: Some(spring), armature, ..Drive::default() };
        let mut case = centered(JointKind::Hinge { drive }, DQuat::IDENTITY, DVec3::ZERO);
        let (mut angle, mut omega) = (0.0f64, 0.5f64);
        let mut u = [DVec3::ZERO, DVec3::ZERO, DVec3::ZERO, DVec3::X * omega];
        for step in 0..300 {
            let (k, d, m) = (f64::from(stiffness), f64::from(damping), f64::from(armature));
            let target = f64::from(spring.target);
            omega = ((inertia + m) * omega + h * load - h * k * (angle - target)) / (inertia + m + h * d + h * h * k);
            angle += h * omega;
            case.b.angular_velocity = narrow(u[3]);
            let rows = case.rows();
            u[3].x += h * load / inertia;
            solve(&rows, A_IS_FIXED, &mut u);
            case.b = Placed::of(&case.b).moved(u[2], u[3], h).frame();
            assert!((u[3].x - omega).abs() < 1e-3, "step {step}, k {k}, m {m}: {} for {omega}", u[3].x);
            assert!((f64::from(case.joint.coordinates()[0]) + h * u[3].x - angle).abs() < 1e-3);
        }
    }
}

/// A motor holds its speed as long as its effort suffices, then slips; dry friction gives way above its effort.
#[test]
fn motor_and_friction_are_bounded() {
    let (h, inertia) = (f64::from(STEP.h), 1.0 / 2.5);
    let motor = Drive { motor: Some(Motor { speed: 2.0, max_effort: 10.0 }), ..Drive::default() };
    let friction = Drive { friction: 10.0, ..Drive::default() };
    for (drive, load, expected) in [
        (motor, -8.0, 2.0),
        (motor, -100.0, 90.0 * -h / inertia),
        (friction, 8.0, 0.0),
        (friction, 25.0, 15.0 * h / inertia),
        (friction, -25.0, -15.0 * h / inertia),
    ] {
        let mut case = centered(JointKind::Hinge { drive }, DQuat::IDENTITY, DVec3::ZERO);
        let start = if drive.motor.is_some() && load == -8.0 { 2.0 } else { 0.0 };
        let mut u = [DVec3::ZERO, DVec3::ZERO, DVec3::ZERO, DVec3::X * (start + h * load / inertia)];
        solve(&case.rows(), A_IS_FIXED, &mut u);
        assert!((u[3].x - expected).abs() < 1e-4, "load {load}: {} for {expected}", u[3].x);
    }
}

/// Efforts on a coordinate of oblique axes do work on that coordinate alone: the others see no acceleration from a massless view.
#[test]
fn dual_rows_pick_one_coordinate() {
    let mut random = Random(16);
    for kind in kinds() {
        let JointKind::Generic { angular, .. } = &kind else { continue };
        if angular.len() < 2 {
            continue;
        }
        let axes: Vec<DVec3> = angular.iter().map(|turn| wide(turn.axis).normalize()).collect();
        let kind = JointKind::Generic {
            linear: Default::default(),
            angular: angular.iter().map(|t| crate::turn(t.axis, Drive { friction: 1.0, ..Drive::default() })).collect(),
        };
        let mut case = case(kind, &mut random, 0.0, 0.0);
        let rows = case.rows();
        let current = crate::product(&axes, &case.angles).1;
        let world = Placed::of(&case.a).rotation * crate::oracle::wide_rotation(case.joint.frame_a);
        for (i, row) in rows[..axes.len()].iter().enumerate() {
            // B turns about axis j alone: only coordinate j moves, at rate 1.
            for (j, axis) in current.iter().enumerate() {
                let u = [DVec3::ZERO, DVec3::ZERO, DVec3::ZERO, world * *axis];
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((rate(row, &u) - expected).abs() < 2e-5);
            }
        }
    }
}

/// A weight hung off a weld: the reaction is its weight and the lever's torque.
#[test]
fn reaction_is_weight_and_lever() {
    let h = f64::from(STEP.h);
    let mut joint = definition(JointKind::Fixed);
    joint.frames = JointFrames::World(Pose::from_translation(ishigaki::Vec3::new(1.0, 2.0, 0.0)));
    let a = Placed { center: DVec3::new(0.0, 2.0, 0.0), rotation: DQuat::IDENTITY }.frame();
    let b = Placed { center: DVec3::new(3.0, 2.0, 0.0), rotation: DQuat::IDENTITY }.frame();
    let zero = ishigaki::Vec3::ZERO;
    let mut resolved = ishigaki::constraint::joint_rows::ResolvedJoint::new(&joint, &a, zero, &b, zero);
    let mut rows = Vec::new();
    resolved.rows(&joint.kind, &a, &b, &STEP, &mut rows);
    let mut u = [DVec3::ZERO, DVec3::ZERO, DVec3::new(0.0, -9.81 * h, 0.0), DVec3::ZERO];
    let lambdas: Vec<f32> = solve(&rows, A_IS_FIXED, &mut u).into_iter().map(|l| l as f32).collect();
    let with_impulses = rows.iter().zip(&lambdas).map(|(row, &lambda)| (row.jacobian, lambda));
    let (impulse, angular) = reaction(with_impulses, resolved.arm_a(&a));
    let (force, torque) = (wide(impulse) / h, wide(angular) / h);
    assert!((force - DVec3::new(0.0, -9.81, 0.0)).length() < 1e-3, "{force}");
    assert!((torque - DVec3::new(0.0, 0.0, -2.0 * 9.81)).length() < 1e-3, "{torque}");
}

/// Coordinates and poses saved and read again give the same rows, bit for bit.
#[test]
fn resolved_joint_survives_serialization() {
    let mut random = Random(17);
    for kind in kinds() {
        let mut case = case(kind, &mut random, 0.01, 0.01);
        let text = serde_json::to_string(&case.joint).expect("serializable");
        let mut read: ishigaki::constraint::joint_rows::ResolvedJoint = serde_json::from_str(&text).expect("readable");
        let mut rows = Vec::new();
        read.rows(&case.kind, &case.a, &case.b, &STEP, &mut rows);
        assert_eq!(rows, case.rows());
    }
}
