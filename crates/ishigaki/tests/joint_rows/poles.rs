//! Places where a formula divides by zero: the rows stay finite and useful.

use crate::oracle::{Placed, Random, assert_sound, product, solve, wide, wide_rotation};
use crate::{STEP, centered, full_drive, turn};
use ishigaki::{Drive, JointKind, Vec3};
use parry3d::glamx::{DQuat, DVec3};
use std::f64::consts::{FRAC_PI_2, PI};

/// Anchors that coincide have no direction between them.
#[test]
fn distance_is_finite_at_zero() {
    let spring = full_drive().spring;
    for range in [(0.0, 1.0), (0.5, 1.0), (0.7, 0.7), (0.0, 0.0), (0.0, f32::INFINITY)] {
        for offset in [DVec3::ZERO, DVec3::X * 1e-30, DVec3::Y * 1e-20, DVec3::Z * 1e-8] {
            let kind = JointKind::Distance { range: (range.0..=range.1).into(), spring };
            let mut case = centered(kind, DQuat::from_rotation_y(0.3), offset);
            let rows = case.rows();
            assert_eq!(rows.len(), case.joint.row_count(&case.kind));
            assert_sound(&rows, &format!("{range:?} at {offset}"));
        }
    }
    // A strut of at least 0.5 m whose ends have fallen together pushes them apart again.
    let kind = JointKind::Distance { range: (0.5..=1.0).into(), spring: None };
    let mut case = centered(kind, DQuat::IDENTITY, DVec3::ZERO);
    let mut u = [DVec3::ZERO; 4];
    solve(&case.rows(), [0.0, 0.0, 1.0, 1.0], &mut u);
    assert!((u[2].length() - 0.3 * 0.5 * 240.0).abs() < 1e-3);
}

/// Cone and twist where the axes are parallel and antiparallel, exactly and nearly.
#[test]
fn ball_is_finite_at_poles() {
    for cone in [0.0f32, 1e-6, 0.5, 3.0, std::f32::consts::PI] {
        let kind = JointKind::Ball { cone: Some(cone), twist: Some((-0.5..=0.5).into()), friction: 1.0, damping: 1.0 };
        for pole in [0.0, PI] {
            for near in [0.0, 1e-9, 1e-7, 1e-5, 1e-3, -1e-3] {
                for about in [DVec3::Y, DVec3::Z, DVec3::new(0.0, 0.6, -0.8)] {
                    for turned in [0.0, 0.4, 3.0] {
                        let relative = DQuat::from_axis_angle(about, pole + near) * DQuat::from_rotation_x(turned);
                        let mut case = centered(kind.clone(), relative, DVec3::ZERO);
                        let rows = case.rows();
                        assert_eq!(rows.len(), case.joint.row_count(&case.kind));
                        assert_sound(&rows, &format!("cone {cone} at {pole} + {near}"));
                    }
                }
            }
        }
    }
}

/// A cone that was turned inside out (σ = π) finds home.
#[test]
fn cone_recovers_from_antiparallel() {
    let kind = JointKind::Ball { cone: Some(0.5), twist: None, friction: 0.0, damping: 0.0 };
    let mut case = centered(kind, DQuat::from_rotation_z(PI), DVec3::ZERO);
    for _ in 0..30 {
        let mut u = [DVec3::ZERO; 4];
        solve(&case.rows(), [0.0, 0.0, 1.0, 1.0], &mut u);
        case.b = Placed::of(&case.b).moved(u[2], u[3], STEP.h.into()).frame();
    }
    assert!(case.joint.angle_error(&case.kind, &case.a, &case.b) < 1e-3);
}

/// A hinge exactly and nearly opposite to itself.
#[test]
fn hinge_is_finite_when_antiparallel() {
    for near in [0.0, 1e-8, 1e-6, 1e-4, 1e-2, 1.0, 1.5, 2.0] {
        for about in [DVec3::Y, DVec3::Z, DVec3::new(0.0, 0.6, -0.8)] {
            let mut case = centered(
                JointKind::Hinge { drive: full_drive() },
                DQuat::from_axis_angle(about, PI - near),
                DVec3::ZERO,
            );
            let rows = case.rows();
            assert_sound(&rows, &format!("π − {near}"));
            let (t1, t2) = (wide(rows[5].jacobian.angular_a), wide(rows[6].jacobian.angular_a));
            assert!((t1.length() - 1.0).abs() < 1e-5 && (t2.length() - 1.0).abs() < 1e-5 && t1.dot(t2).abs() < 1e-5);
        }
    }
}

/// Three turns whose first and last axes have become parallel; and through that point to the other side.
#[test]
fn gimbal_lock_is_finite() {
    let angular = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| turn(axis, full_drive())).to_vec();
    let kind = JointKind::Generic { linear: Default::default(), angular };
    let mut case = centered(kind, DQuat::IDENTITY, DVec3::ZERO);
    for step in 0..=200 {
        let angle = FRAC_PI_2 * f64::from(step) / 100.0;
        case.b = Placed { center: DVec3::ZERO, rotation: DQuat::from_rotation_y(angle) }.frame();
        assert_sound(&case.rows(), &format!("at {angle}"));
        // Straight through: the middle angle counts on, the others stay.
        let [x, y, z] = *case.joint.coordinates() else { panic!("three angles") };
        assert!((f64::from(y) - angle).abs() < 1e-3 && x.abs() < 1e-3 && z.abs() < 1e-3, "({x}, {y}, {z}) at {angle}");
    }
}

/// Wild paths near gimbal lock: coordinates may lag there, and describe the orientation again afterwards.
#[test]
fn coordinates_return_after_gimbal_lock() {
    let mut random = Random(21);
    let angular = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| turn(axis, Drive::default())).to_vec();
    for _ in 0..40 {
        let kind = JointKind::Generic { linear: Default::default(), angular: angular.clone() };
        let mut case = centered(kind, DQuat::IDENTITY, DVec3::ZERO);
        let (tilt, spin) = (random.direction(), random.direction());
        let mut rotation = DQuat::IDENTITY;
        for step in 0..400 {
            let omega = tilt * (0.05 * f64::from(step)).sin() + spin * (0.031 * f64::from(step)).cos();
            rotation = (DQuat::from_scaled_axis(omega * 0.04) * rotation).normalize();
            case.b = Placed { center: DVec3::ZERO, rotation }.frame();
            assert_sound(&case.rows(), "path");
            let angles: Vec<f64> = case.joint.coordinates().iter().map(|&c| c.into()).collect();
            let described = product(&[DVec3::X, DVec3::Y, DVec3::Z], &angles).0;
            let off = described.angle_between(wide_rotation(case.b.rotation));
            let away_from_lock = angles[1].cos().abs() > 0.2;
            assert!(off < if away_from_lock { 1e-4 } else { 0.2 }, "step {step}: off by {off} at {angles:?}");
        }
    }
}

/// Two turns whose axes have become parallel (the lock is far off): finite, and found back.
#[test]
fn universal_joint_is_finite_when_axes_meet() {
    for near in [0.0, 1e-7, 1e-5, 1e-3, 0.1] {
        let angular = vec![turn(Vec3::X, full_drive()), turn(Vec3::Y, full_drive())];
        let kind = JointKind::Generic { linear: Default::default(), angular };
        // B's y axis on A's x axis.
        let mut case = centered(kind, DQuat::from_rotation_z(-FRAC_PI_2 + near), DVec3::ZERO);
        let rows = case.rows();
        assert_sound(&rows, &format!("{near}"));
        assert!(case.joint.angle_error(&case.kind, &case.a, &case.b) > 1.4);
    }
}

/// A drive that asks for nothing, and ranges without ends, are rows that do nothing or no rows.
#[test]
fn empty_drives_are_harmless() {
    let spring = ishigaki::Spring { target: 1.0, stiffness: 0.0, damping: 0.0 };
    let drive =
        Drive { spring: Some(spring), limit: Some((f32::NEG_INFINITY..=f32::INFINITY).into()), ..Drive::default() };
    let mut case = centered(JointKind::Hinge { drive }, DQuat::from_rotation_x(0.2), DVec3::ZERO);
    let rows = case.rows();
    assert_eq!(rows.len(), 6);
    assert_sound(&rows, "empty");
    let mut u = [DVec3::ZERO, DVec3::ZERO, DVec3::ZERO, DVec3::X * 3.0];
    solve(&rows, [0.0, 0.0, 1.0, 1.0], &mut u);
    assert!((u[3].x - 3.0).abs() < 1e-9);
}
