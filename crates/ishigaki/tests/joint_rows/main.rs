//! Joints as rows: every J is the derivative of its constraint, every bias pulls the right way. TALK B5–B12.

mod laws;
mod oracle;
mod poles;

use ishigaki::constraint::joint_rows::{BodyFrame, JointStep, ResolvedJoint};
use ishigaki::constraint::row::RowSpec;
use ishigaki::{BodyHandle, Drive, Freedom, Joint, JointFrames, JointKind, Motor, Pose, Range, Spring, TurnAxis, Vec3};
use oracle::{Placed, Random, narrow, narrow_rotation, product, wide};
use parry3d::glamx::{DQuat, DVec3};

pub(crate) const STEP: JointStep = JointStep { h: 1.0 / 240.0, recovery_rate: 0.3 };

/// One joint, two bodies, and the coordinates they were placed at.
pub(crate) struct Case {
    pub(crate) kind: JointKind,
    pub(crate) joint: ResolvedJoint,
    pub(crate) a: BodyFrame,
    pub(crate) b: BodyFrame,
    pub(crate) angles: Vec<f64>,
}

impl Case {
    pub(crate) fn rows(&mut self) -> Vec<RowSpec> {
        let mut rows = Vec::new();
        self.joint.rows(&self.kind, &self.a, &self.b, &STEP, &mut rows);
        rows
    }
}

/// Everything at once on one coordinate.
pub(crate) fn full_drive() -> Drive {
    Drive {
        limit: Some(Range { lower: -0.4, upper: 0.7 }),
        motor: Some(Motor { speed: 1.5, max_effort: 20.0 }),
        spring: Some(Spring { target: 0.2, stiffness: 300.0, damping: 5.0 }),
        armature: 0.3,
        friction: 0.2,
    }
}

pub(crate) fn turn(axis: Vec3, drive: Drive) -> TurnAxis {
    TurnAxis { axis, drive }
}

/// All kinds of joints, with everything that may act on them.
pub(crate) fn kinds() -> Vec<JointKind> {
    let full = full_drive();
    let (free, locked) = (Freedom::Free(full), Freedom::Locked);
    let spring = full.spring;
    let (p, q, r) = (Vec3::new(0.9, 0.1, -0.2), Vec3::new(0.1, 1.0, 0.3), Vec3::new(-0.2, 0.3, 0.8));
    let axes = [p, q, r].map(|axis| turn(axis.normalize(), full));
    let generic = |linear, k: usize| JointKind::Generic { linear, angular: axes[..k].to_vec() };
    let euler = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| turn(axis, full)).to_vec();
    vec![
        JointKind::Ball { cone: None, twist: None, friction: 0.0, damping: 0.0 },
        JointKind::Ball { cone: Some(0.8), twist: full.limit, friction: 0.4, damping: 2.0 },
        JointKind::Hinge { drive: Drive::default() },
        JointKind::Hinge { drive: full },
        JointKind::Slider { drive: Drive::default() },
        JointKind::Slider { drive: full },
        JointKind::Fixed,
        JointKind::Distance { range: (0.3..=1.2).into(), spring },
        JointKind::Distance { range: (0.7..=0.7).into(), spring: None },
        JointKind::Distance { range: (0.0..=1.2).into(), spring: None },
        generic([locked; 3], 0),
        generic([locked; 3], 1),
        generic([locked; 3], 2),
        generic([locked; 3], 3),
        generic([free, locked, locked], 0),
        generic([locked, free, free], 1),
        generic([free, free, locked], 2),
        generic([free; 3], 3),
        JointKind::Generic { linear: [locked; 3], angular: euler },
    ]
}

/// Two bodies at random coordinates the joint allows; locked displacements off by about `gap` (m), locked
/// rotations by about `tilt` (rad).
pub(crate) fn case(kind: JointKind, random: &mut Random, gap: f64, tilt: f64) -> Case {
    let mut offset = random.vector(1.0) * gap;
    let mut angles = Vec::new();
    let relative = match &kind {
        JointKind::Ball { .. } => {
            let swing_axis = DVec3::new(0.0, random.within(-1.0, 1.0), random.within(-1.0, 1.0)).normalize();
            let swing = DQuat::from_axis_angle(swing_axis, random.within(0.15, 2.6));
            swing * DQuat::from_rotation_x(random.within(-3.0, 3.0))
        }
        JointKind::Hinge { .. } => DQuat::from_rotation_x(random.within(-3.0, 3.0)),
        JointKind::Slider { .. } => {
            offset.x = random.within(-2.0, 2.0);
            DQuat::IDENTITY
        }
        JointKind::Fixed => DQuat::IDENTITY,
        JointKind::Distance { .. } => {
            offset = random.direction() * random.within(0.1, 2.0);
            random.rotation()
        }
        JointKind::Generic { linear, angular } => {
            for i in 0..3 {
                if linear[i] != Freedom::Locked {
                    offset[i] = random.within(-1.0, 1.0);
                }
            }
            let axes: Vec<DVec3> = angular.iter().map(|turn| wide(turn.axis).normalize()).collect();
            // The middle one stays away from gimbal lock.
            let reach = [2.5, 0.6, 2.5];
            angles = (0..axes.len()).map(|i| random.within(-reach[i], reach[i])).collect();
            product(&axes, &angles).0
        }
    };
    let relative = relative * DQuat::from_scaled_axis(random.vector(1.0) * tilt);
    let frame_a = Pose::from_parts(narrow(random.vector(1.0)), narrow_rotation(random.rotation()));
    let frame_b = Pose::from_parts(narrow(random.vector(1.0)), narrow_rotation(random.rotation()));
    let placed_a = Placed { center: random.vector(3.0), rotation: random.rotation() };
    let world_a = placed_a.rotation * oracle::wide_rotation(frame_a.rotation);
    let rotation_b = world_a * relative * oracle::wide_rotation(frame_b.rotation).conjugate();
    let anchor_b = placed_a.center + placed_a.rotation * wide(frame_a.translation) + world_a * offset;
    let placed_b = Placed { center: anchor_b - rotation_b * wide(frame_b.translation), rotation: rotation_b };
    let mut joint = definition(kind);
    joint.frames = JointFrames::Local { a: frame_a, b: frame_b };
    joint.validate().expect("a sensible joint");
    let (mut a, mut b) = (placed_a.frame(), placed_b.frame());
    (a.velocity, b.velocity) = (narrow(random.vector(1.0)), narrow(random.vector(1.0)));
    (a.angular_velocity, b.angular_velocity) = (narrow(random.vector(1.0)), narrow(random.vector(1.0)));
    let resolved = ResolvedJoint::new(&joint, &a, Vec3::ZERO, &b, Vec3::ZERO);
    Case { kind: joint.kind, joint: resolved, a, b, angles }
}

pub(crate) fn definition(kind: JointKind) -> Joint {
    Joint::new(BodyHandle::from((0, 0)), BodyHandle::from((1, 0)), kind, Pose::IDENTITY)
}

/// A joint with its frames at both bodies' centers of mass.
pub(crate) fn centered(kind: JointKind, relative: DQuat, offset: DVec3) -> Case {
    let a = BodyFrame::at_rest(Vec3::ZERO, ishigaki::Quat::IDENTITY);
    let b = BodyFrame::at_rest(narrow(offset), narrow_rotation(relative));
    let mut joint = definition(kind);
    joint.frames = JointFrames::Local { a: Pose::IDENTITY, b: Pose::IDENTITY };
    let resolved = ResolvedJoint::new(&joint, &a, Vec3::ZERO, &b, Vec3::ZERO);
    Case { kind: joint.kind, joint: resolved, a, b, angles: Vec::new() }
}

/// TALK B4, B5: every row's J against the central difference of its function, at random poses with small errors.
#[test]
fn jacobians_are_derivatives() {
    let mut random = Random(1);
    let mut worst = 0.0f64;
    for kind in kinds() {
        for _ in 0..60 {
            let mut case = case(kind.clone(), &mut random, 0.01, 5e-4);
            let rows = case.rows();
            let (a, b) = (Placed::of(&case.a), Placed::of(&case.b));
            // Angles are known up to turns: the nearest to what the engine found.
            let angles: Vec<f64> = case.joint.coordinates()[case.joint.coordinates().len() - case.angles.len()..]
                .iter()
                .map(|&c| c.into())
                .collect();
            let value = |direction: usize, time: f64| {
                let mut u = [DVec3::ZERO; 4];
                u[direction / 3][direction % 3] = 1.0;
                oracle::values(&case.kind, &case.joint, &a.moved(u[0], u[1], time), &b.moved(u[2], u[3], time), &angles)
            };
            let mut difference = vec![[0.0f64; 12]; rows.len()];
            for direction in 0..12 {
                let (up, down) = (value(direction, 1e-5), value(direction, -1e-5));
                assert_eq!(up.len(), rows.len(), "{:?}", case.kind);
                for (((row, difference), up), down) in rows.iter().zip(&mut difference).zip(up).zip(down) {
                    let Some((up, down)) = up.zip(down) else { continue };
                    let j = oracle::jacobian(row)[direction / 3][direction % 3];
                    difference[direction] = j - (up - down) / 2e-5;
                }
            }
            for (row, difference) in rows.iter().zip(&difference) {
                let norm = oracle::jacobian(row).iter().map(|v| v.length_squared()).sum::<f64>().sqrt();
                let error = difference.iter().map(|d| d * d).sum::<f64>().sqrt() / norm;
                worst = worst.max(error);
                assert!(error < 1e-5, "relative error {error:e} of {row:?} in {:?}", case.kind);
            }
        }
    }
    println!("worst relative error of J: {worst:.1e}");
}

/// Friction and damping of a ball: no coordinate, but the relative angular velocity itself.
#[test]
fn ball_friction_rows_measure_relative_rotation() {
    let mut random = Random(2);
    let kind = JointKind::Ball { cone: None, twist: None, friction: 0.4, damping: 2.0 };
    let mut case = case(kind, &mut random, 0.0, 0.0);
    let rows = case.rows();
    let u = [random.vector(1.0), random.vector(1.0), random.vector(1.0), random.vector(1.0)];
    for (i, row) in rows[..6].iter().enumerate() {
        assert!((oracle::rate(row, &u) - (u[3] - u[1])[i % 3]).abs() < 1e-6);
    }
    // γ = 1/(h d): λ = −h d ω.
    assert!((rows[3].softness - 1.0 / (STEP.h * 2.0)).abs() < 1e-3);
    assert_eq!((rows[0].lower, rows[0].upper), (-STEP.h * 0.4, STEP.h * 0.4));
}

/// The count depends on the definition alone, whatever the pose.
#[test]
fn row_count_is_constant() {
    let mut random = Random(3);
    for kind in kinds() {
        for _ in 0..20 {
            let mut case = case(kind.clone(), &mut random, 0.5, 1.0);
            let rows = case.rows();
            assert_eq!(rows.len(), case.joint.row_count(&case.kind));
            oracle::assert_sound(&rows, &format!("{kind:?}"));
        }
    }
    let drive = Drive { limit: Some((0.0..=f32::INFINITY).into()), armature: 0.1, ..Drive::default() };
    let one_sided = centered(JointKind::Hinge { drive }, DQuat::IDENTITY, DVec3::ZERO);
    assert_eq!(one_sided.joint.row_count(&one_sided.kind), 5 + 2);
}

/// Local frames are measured from the body's origin, a world frame is taken over as the bodies stand.
#[test]
fn frames_resolve_to_the_same_anchor() {
    let mut random = Random(4);
    for _ in 0..50 {
        let (origin_a, origin_b) = (
            Placed { center: random.vector(3.0), rotation: random.rotation() },
            Placed { center: random.vector(3.0), rotation: random.rotation() },
        );
        let (local_a, local_b) = (random.vector(0.5), random.vector(0.5));
        let at = |origin: &Placed, local: DVec3| {
            Placed { center: origin.center + origin.rotation * local, ..*origin }.frame()
        };
        let (a, b) = (at(&origin_a, local_a), at(&origin_b, local_b));
        let (anchor, rotation) = (random.vector(2.0), random.rotation());
        let in_body = |origin: &Placed| {
            Pose::from_parts(
                narrow(origin.rotation.conjugate() * (anchor - origin.center)),
                narrow_rotation(origin.rotation.conjugate() * rotation),
            )
        };
        let mut joint = definition(JointKind::Fixed);
        joint.frames = JointFrames::World(Pose::from_parts(narrow(anchor), narrow_rotation(rotation)));
        let from_world = ResolvedJoint::new(&joint, &a, narrow(local_a), &b, narrow(local_b));
        joint.frames = JointFrames::Local { a: in_body(&origin_a), b: in_body(&origin_b) };
        let from_local = ResolvedJoint::new(&joint, &a, narrow(local_a), &b, narrow(local_b));
        for joint in [&from_world, &from_local] {
            assert!((wide(a.center + joint.arm_a(&a)) - anchor).length() < 3e-6);
            assert!((wide(b.center + joint.arm_b(&b)) - anchor).length() < 3e-6);
            assert!(joint.anchor_error(&JointKind::Fixed, &a, &b) < 3e-6);
            assert!(joint.angle_error(&JointKind::Fixed, &a, &b) < 3e-6);
        }
    }
}

/// gᵢ·wⱼ = δᵢⱼ away from gimbal lock; bounded everywhere.
#[test]
fn dual_basis() {
    use ishigaki::constraint::part::turns::dual;
    let mut random = Random(5);
    let mut regular = 0;
    for _ in 0..2000 {
        let w = [narrow(random.direction()), narrow(random.direction()), narrow(random.direction())];
        let g = dual(w);
        for g in g {
            assert!(g.is_finite() && g.length() < 30.0, "{g} of {w:?}");
        }
        if w[0].cross(w[1]).dot(w[2]).abs() < 0.05 {
            continue;
        }
        regular += 1;
        for i in 0..3 {
            for j in 0..3 {
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((g[i].dot(w[j]) - expected).abs() < 1e-5, "{:?} {:?}", g, w);
            }
        }
    }
    assert!(regular > 1000);
}

/// A joint's coordinates follow the poses through several turns, without drift, for axes that are not perpendicular too.
#[test]
fn coordinates_are_recovered() {
    let mut random = Random(6);
    for kind in kinds() {
        let JointKind::Generic { linear, angular } = kind else { continue };
        // Limits only choose the turn to start on; these start at zero.
        let angular: Vec<TurnAxis> = angular.iter().map(|t| turn(t.axis, Drive::default())).collect();
        let axes: Vec<DVec3> = angular.iter().map(|turn| wide(turn.axis).normalize()).collect();
        let mut case = centered(JointKind::Generic { linear, angular }, DQuat::IDENTITY, DVec3::ZERO);
        let speed = random.vector(0.12);
        let mut highest = 0.0f64;
        for step in 0..300 {
            let t = f64::from(step);
            // The oblique axes lock at −0.98 rad.
            let middle = 0.6 * (0.05 * t).sin();
            let angles = [speed.x * t, middle, speed.z * t];
            let angles = &angles[..axes.len()];
            let slides = DVec3::new(0.3, -0.2, 0.1) * (0.01 * t);
            let offset =
                DVec3::from_array(std::array::from_fn(|i| if linear[i] == Freedom::Locked { 0.0 } else { slides[i] }));
            case.b = Placed { center: offset, rotation: product(&axes, angles).0 }.frame();
            case.rows();
            let free = (0..3).filter(|&i| linear[i] != Freedom::Locked).map(|i| offset[i]);
            let expected: Vec<f64> = free.chain(angles.iter().copied()).collect();
            assert_eq!(case.joint.coordinates().len(), expected.len());
            for (&found, expected) in case.joint.coordinates().iter().zip(&expected) {
                assert!((f64::from(found) - expected).abs() < 2e-5, "step {step}: {found} for {expected}");
                highest = highest.max(expected.abs());
            }
            assert!(case.joint.angle_error(&case.kind, &case.a, &case.b) < 1e-5);
        }
        assert!(axes.is_empty() || highest > 4.0 || speed.x.abs() < 0.02);
    }
}

/// A hinge counts on beyond ±π, in both directions; a new one starts on the turn nearest to its range.
#[test]
fn hinge_counts_turns() {
    let mut case = centered(JointKind::Hinge { drive: Drive::default() }, DQuat::IDENTITY, DVec3::ZERO);
    for step in (0..400).chain((-300..400).rev()) {
        let angle = 0.05 * f64::from(step);
        case.b = Placed { center: DVec3::ZERO, rotation: DQuat::from_rotation_x(angle) }.frame();
        case.rows();
        let found = f64::from(case.joint.coordinates()[0]);
        assert!((found - angle).abs() < 5e-6, "{found} for {angle}");
    }
    let drive = Drive { limit: Some((0.0..=3.5).into()), ..Drive::default() };
    let opened = centered(JointKind::Hinge { drive }, DQuat::from_rotation_x(3.4), DVec3::ZERO);
    assert!((opened.joint.coordinates()[0] - 3.4).abs() < 1e-6);
    assert_eq!(opened.joint.angle_error(&opened.kind, &opened.a, &opened.b), 0.0);
}
