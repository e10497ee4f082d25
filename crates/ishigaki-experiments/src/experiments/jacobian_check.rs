//! B4, B5: J against finite differences, for the talk's arm, for contacts and for joints.

use crate::chart::{Chart, Mark};
use crate::{Experiment, Lab, Result, Verdict};
use glam::{DQuat, DVec3};
use ishigaki::collision::narrow_phase::{LocalManifolds, find_manifolds};
use ishigaki::collision::pair_memory::PairMemory;
use ishigaki::constraint::frame::{BodyFrame, JointStep};
use ishigaki::constraint::joint_rows::ResolvedJoint;
use ishigaki::constraint::row::Jacobian;
use ishigaki::{BodyHandle, Geometry, Joint, Pose, Quat, Vec3};
use ishigaki_scenes::named::Random;

pub const EXPERIMENT: Experiment = Experiment {
    name: "jacobian-check",
    rows: &["B4", "B5"],
    title: "J against central differences in f64, at random poses",
    run,
};

/// Step of the central difference, s.
const STEP: f64 = 1e-5;

/// v_A, ω_A, v_B, ω_B.
type Velocities = [DVec3; 4];

/// Center and orientation in f64.
#[derive(Clone, Copy)]
struct Placed {
    center: DVec3,
    rotation: DQuat,
}

impl Placed {
    fn of(center: Vec3, rotation: Quat) -> Self {
        let q = DQuat::from_xyzw(rotation.x.into(), rotation.y.into(), rotation.z.into(), rotation.w.into());
        Self { center: center.as_dvec3(), rotation: q.normalize() }
    }

    fn moved(&self, v: DVec3, omega: DVec3, t: f64) -> Self {
        let rotation = (DQuat::from_scaled_axis(omega * t) * self.rotation).normalize();
        Self { center: self.center + t * v, rotation }
    }
}

/// d/dt of `value` for each of the twelve unit velocities.
fn differences(a: &Placed, b: &Placed, value: impl Fn(&Placed, &Placed) -> f64) -> [f64; 12] {
    std::array::from_fn(|i| {
        let mut u: Velocities = [DVec3::ZERO; 4];
        u[i / 3][i % 3] = 1.0;
        let at = |t: f64| value(&a.moved(u[0], u[1], t), &b.moved(u[2], u[3], t));
        (at(STEP) - at(-STEP)) / (2.0 * STEP)
    })
}

fn entries(j: &Jacobian) -> [f64; 12] {
    let parts = [j.linear, j.angular_a, -j.linear, j.angular_b];
    std::array::from_fn(|i| f64::from(parts[i / 3][i % 3]))
}

/// ‖J − J'‖ / ‖J'‖.
fn error(j: &[f64], exact: &[f64]) -> f64 {
    let size = exact.iter().map(|x| x * x).sum::<f64>().sqrt();
    j.iter().zip(exact).map(|(x, y)| (x - y).powi(2)).sum::<f64>().sqrt() / size
}

fn vector(random: &mut Random, size: f32) -> Vec3 {
    Vec3::from_array([(); 3].map(|()| random.between(-size, size)))
}

/// The talk's example: four joint rates to the velocity of a planar hand, a 2 × 4 matrix.
fn arm(random: &mut Random) -> f64 {
    const LENGTHS: [f64; 4] = [1.0, 0.8, 0.6, 0.3];
    let angles = [(); 4].map(|()| f64::from(random.between(-2.0, 2.0)));
    // The joints from the shoulder on, the hand last.
    let points = |angles: &[f64; 4]| {
        let (mut at, mut heading, mut points) = (DVec3::ZERO, 0.0, vec![DVec3::ZERO]);
        for (length, angle) in LENGTHS.iter().zip(angles) {
            heading += angle;
            at += length * DVec3::new(heading.cos(), heading.sin(), 0.0);
            points.push(at);
        }
        points
    };
    let at = points(&angles);
    let (mut j, mut exact) = (Vec::new(), Vec::new());
    for axis in [Vec3::X, Vec3::Y] {
        for joint in 0..4 {
            let row = Jacobian::point(axis, (at[4] - at[joint]).as_vec3(), Vec3::ZERO);
            j.push(f64::from(row.angular_a.z));
            let moved = |by: f64| {
                let mut angles = angles;
                angles[joint] += by;
                points(&angles)[4].dot(axis.as_dvec3())
            };
            exact.push((moved(STEP) - moved(-STEP)) / (2.0 * STEP));
        }
    }
    error(&j, &exact)
}

/// Errors of all contact points of two shapes that touch somewhere; n turns with B.
fn contact(a: &Geometry, b: &Geometry, random: &mut Random) -> Vec<f64> {
    let mut errors = Vec::new();
    let world_from_a = Pose::from_parts(vector(random, 3.0), random.rotation());
    let mut b_in_a = Pose::from_parts(vector(random, 1.0).normalize_or(Vec3::Y) * 3.0, random.rotation());
    let mut manifolds = LocalManifolds::new();
    // Toward each other until they are near.
    for _ in 0..200 {
        find_manifolds(a, b, &b_in_a, 0.02, 1.0, &mut PairMemory::default(), &mut manifolds);
        if manifolds.iter().any(|m| !m.points.is_empty()) {
            break;
        }
        b_in_a.translation *= 0.99;
    }
    let world_from_b = world_from_a * b_in_a;
    let placed = |p: &Pose| Placed::of(p.translation, p.rotation);
    let (a, b) = (placed(&world_from_a), placed(&world_from_b));
    for manifold in &manifolds {
        for point in &manifold.points {
            let normal = world_from_a.rotation * manifold.normal;
            let (on_a, on_b) = (world_from_a * point.on_a, world_from_a * point.on_b);
            let (arm_a, arm_b) = (on_a - world_from_a.translation, on_b - world_from_b.translation);
            // The same points and the same normal, carried along in f64.
            let local = |placed: &Placed, v: Vec3| placed.rotation.conjugate() * v.as_dvec3();
            let (point_a, point_b, n) = (local(&a, arm_a), local(&b, arm_b), local(&b, normal));
            let gap = |a: &Placed, b: &Placed| {
                let apart = a.center + a.rotation * point_a - b.center - b.rotation * point_b;
                (b.rotation * n).dot(apart)
            };
            errors.push(error(&entries(&Jacobian::point(normal, arm_a, arm_b)), &differences(&a, &b, gap)));
        }
    }
    errors
}

/// Errors of the rows of a ball joint or a hinge whose anchors coincide.
fn joint(hinge: bool, random: &mut Random) -> Vec<f64> {
    let mut errors = Vec::new();
    let (a, b) = ((vector(random, 2.0), random.rotation()), (vector(random, 2.0), random.rotation()));
    let (anchor, axis) = (vector(random, 2.0), vector(random, 1.0).normalize_or(Vec3::X));
    let handles = [0, 1].map(|i| BodyHandle::from((i, 0)));
    let joint = if hinge {
        Joint::hinge(handles[0], handles[1], anchor, axis)
    } else {
        Joint::ball(handles[0], handles[1], anchor)
    };
    let (frame_a, frame_b) = (BodyFrame::at_rest(a.0, a.1), BodyFrame::at_rest(b.0, b.1));
    let mut resolved = ResolvedJoint::new(&joint, &frame_a, Vec3::ZERO, &frame_b, Vec3::ZERO);
    let mut rows = Vec::new();
    resolved.rows(&joint.kind, &frame_a, &frame_b, &JointStep { h: 1.0 / 60.0, recovery_rate: 0.3 }, &mut rows);
    let (a, b) = (Placed::of(a.0, a.1), Placed::of(b.0, b.1));
    let local = |placed: &Placed| placed.rotation.conjugate() * (anchor.as_dvec3() - placed.center);
    let (anchor_a, anchor_b) = (local(&a), local(&b));
    let turned = |placed: &Placed| placed.rotation.conjugate() * axis.as_dvec3();
    let (axis_a, axis_b) = (turned(&a), turned(&b));
    for row in rows {
        let exact = differences(&a, &b, |a, b| {
            if row.jacobian.linear == Vec3::ZERO {
                // t·(ω_A − ω_B): how the axes turn apart.
                let across = (b.rotation * axis_b).cross(a.rotation * axis_a);
                across.dot(row.jacobian.angular_a.as_dvec3())
            } else {
                let apart = a.center + a.rotation * anchor_a - b.center - b.rotation * anchor_b;
                apart.dot(row.jacobian.linear.as_dvec3())
            }
        });
        errors.push(error(&entries(&row.jacobian), &exact));
    }
    errors
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let trials = lab.choose(300, 30);
    let mut random = Random::new(5);
    let cuboid = Geometry::Cuboid { half_extents: Vec3::new(0.5, 0.3, 0.4) };
    let ball = Geometry::Ball { radius: 0.4 };
    let capsule = Geometry::Capsule { half_length: 0.3, radius: 0.2 };
    type Trial<'a> = Box<dyn Fn(&mut Random) -> Vec<f64> + 'a>;
    let kinds: Vec<(&str, Trial<'_>)> = vec![
        ("arm of 4 joints", Box::new(|r| vec![arm(r)])),
        ("box on box", Box::new(|r| contact(&cuboid, &cuboid, r))),
        ("ball on box", Box::new(|r| contact(&ball, &cuboid, r))),
        ("ball on ball", Box::new(|r| contact(&ball, &ball, r))),
        ("capsule on box", Box::new(|r| contact(&capsule, &cuboid, r))),
        ("ball joint", Box::new(|r| joint(false, r))),
        ("hinge", Box::new(|r| joint(true, r))),
    ];
    let count = kinds.len();
    let mut chart = Chart::curves("Relative error of each row of J, sorted", "part of the rows, %", "relative error")
        .log(false, true);
    let mut verdict = Verdict::on(
        "J maps velocities between frames; w = J u is the velocity along a \
        constraint's axis",
    );
    for (i, (name, trial)) in kinds.iter().enumerate() {
        lab.progress(i as f64 / count as f64, name);
        let mut errors: Vec<f64> = (0..trials).flat_map(|_| trial(&mut random)).collect();
        errors.sort_by(f64::total_cmp);
        let worst = errors.last().copied().unwrap_or(f64::NAN);
        let most = errors.get(errors.len() * 99 / 100).copied().unwrap_or(f64::NAN);
        verdict = verdict.at_most(format!("{name}, 99 % of the rows"), "", 1e-5, most);
        if worst > 1e-5 {
            verdict = verdict.open(format!("{name}, worst row"), "", worst);
        }
        let size = errors.len().max(1) as f64;
        let sorted = errors.iter().enumerate().map(|(k, e)| (100.0 * (k + 1) as f64 / size, *e)).collect();
        chart = chart.series(*name, Mark::Line, sorted);
    }
    lab.chart(chart.level(1e-5, "1e-5: the most that f32 may cost"));
    Ok(verdict.note(
        "The rows are those of the engine in f32, the differences those of the same points in f64. \
        Where a row of boxes is worse, the two points of an edge's end are not exactly opposite each other: as \
        n turns with B it sees their distance along the surface, which J leaves out.",
    ))
}
