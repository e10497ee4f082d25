//! B10: a constraint between two bodies is internal; whatever its kind, it changes neither momentum.

use crate::chart::Chart;
use crate::setup::{DT, G, plain};
use crate::{Experiment, Lab, Result, Verdict};
use ishigaki::{
    Body, BodyHandle, Drive, Freedom, Joint, Pose, Quat, Range, Shape, SolverOptions, TurnAxis, Vec3, World,
    WorldOptions,
};

pub const EXPERIMENT: Experiment = Experiment {
    name: "momentum",
    rows: &["B10"],
    title: "Momentum and angular momentum of bodies that only constraints act on",
    run,
};

fn weightless(solver: SolverOptions) -> Result<World> {
    let mut options = WorldOptions { gravity: 0.0 * G * Vec3::Y, solver, ..WorldOptions::default() };
    options.rest.sleep.enabled = false;
    options.rest.aggressive_sleep.enabled = false;
    Ok(World::new(options)?)
}

/// Momentum and angular momentum about the origin, in f64, and the sum of their sizes body by body.
fn totals(world: &World) -> ([f64; 6], [f64; 2]) {
    let (mut sum, mut sizes) = ([0.0; 6], [0.0; 2]);
    for (_, body) in world.bodies() {
        let d = |v: Vec3| v.as_dvec3();
        let p = f64::from(body.mass()) * d(body.velocity());
        let l = d(body.angular_momentum()) + d(body.center()).cross(p);
        for i in 0..3 {
            sum[i] += p[i];
            sum[3 + i] += l[i];
        }
        sizes[0] += p.length();
        sizes[1] += d(body.angular_momentum()).length() + d(body.center()).length() * p.length();
    }
    (sum, sizes)
}

/// Drift of P and L over their sizes, step by step.
fn drift(world: &mut World, seconds: f64) -> Vec<(f64, [f64; 2])> {
    let (start, mut sizes) = totals(world);
    let mut seen = Vec::new();
    while world.time() < seconds {
        world.step(DT);
        let (now, size) = totals(world);
        sizes = [sizes[0].max(size[0]), sizes[1].max(size[1])];
        let apart = |range: std::ops::Range<usize>| range.map(|i| (now[i] - start[i]).powi(2)).sum::<f64>().sqrt();
        seen.push((world.time(), [apart(0..3) / sizes[0], apart(3..6) / sizes[1]]));
    }
    seen
}

/// A stick 1 m long at x = `k`, with a velocity of its own.
fn stick(world: &mut World, k: usize) -> Result<BodyHandle> {
    let wave = |a: f64| (a + 1.7 * k as f64).sin() as f32;
    let body = Body::dynamic(Shape::cuboid(0.5, 0.1, 0.15))
        .at(Vec3::new(k as f32, 0.0, 0.0))
        .velocity(Vec3::new(wave(0.3), wave(1.1), wave(2.3)))
        .angular_velocity(2.0 * Vec3::new(wave(0.7), wave(1.9), wave(3.1)));
    Ok(world.add_body(body)?)
}

type MakeJoint = fn(BodyHandle, BodyHandle) -> Joint;

const AT: Vec3 = Vec3::new(0.5, 0.0, 0.0);
const KINDS: [(&str, MakeJoint); 8] = [
    ("ball", |a, b| Joint::ball(a, b, AT)),
    ("ball, limits", |a, b| Joint::ball_about(a, b, AT, Vec3::X).cone(0.6).limit(-0.3..=0.3).dry_friction(0.5)),
    ("hinge", |a, b| Joint::hinge(a, b, AT, Vec3::Y).limit(-0.3..=0.6).spring(0.2, 200.0, 5.0)),
    ("hinge, motor", |a, b| Joint::hinge(a, b, AT, Vec3::Z).motor(3.0, 50.0)),
    ("slider", |a, b| Joint::slider(a, b, AT, Vec3::X).limit(-0.2..=0.8)),
    ("fixed", |a, b| Joint::fixed(a, b, AT)),
    ("rope", |a, b| Joint { collide: false, ..Joint::rope(a, b, AT, -AT, 0.5) }),
    ("three turns", |a, b| {
        let drive = Drive { limit: Some(Range::from(-0.4..=0.5)), friction: 3.0, armature: 0.5, ..Drive::default() };
        let axes = [Vec3::X, Vec3::Z, Vec3::Y].map(|axis| TurnAxis { axis, drive });
        Joint::generic(a, b, Pose::from_translation(AT), [Freedom::Locked; 3], axes.to_vec())
    }),
];

/// Boxes, balls and capsules that fly into each other.
fn crowd(solver: SolverOptions) -> Result<World> {
    let mut world = weightless(solver)?;
    for k in 0..27_usize {
        let cell = Vec3::new((k % 3) as f32 - 1.0, (k / 3 % 3) as f32 - 1.0, (k / 9) as f32 - 1.0);
        let shape = match k % 3 {
            0 => Shape::cuboid(0.3, 0.2, 0.4),
            1 => Shape::ball(0.3),
            _ => Shape::capsule(0.2, 0.2),
        };
        // Toward the middle, and each its own way round.
        let body = Body::dynamic(shape.friction(0.5))
            .at(1.2 * cell)
            .rotated(Quat::from_rotation_y(k as f32))
            .velocity(-1.5 * cell + 0.1 * Vec3::new(1.0, 2.0, -1.0))
            .angular_velocity(Vec3::new(cell.y, -cell.z, cell.x));
        world.add_body(body)?;
    }
    Ok(world)
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let seconds = lab.choose(5.0, 1.0);
    let mut chart = Chart::bars(
        format!("Greatest drift in {seconds} s, as a part of what is there"),
        "relative drift",
        ["momentum", "angular momentum"],
    )
    .log(false, true);
    let (mut worst_joint, mut worst_contact) = ([0.0_f64; 2], [0.0_f64; 2]);
    let greatest = |seen: &[(f64, [f64; 2])], i: usize| seen.iter().map(|s| s.1[i]).fold(1e-12, f64::max);
    for (i, (name, joint)) in KINDS.iter().enumerate() {
        lab.progress(i as f64 / (KINDS.len() + 2) as f64, name);
        let mut world = weightless(SolverOptions::default())?;
        let (a, b) = (stick(&mut world, 0)?, stick(&mut world, 1)?);
        world.add_joint(joint(a, b))?;
        let seen = drift(&mut world, seconds);
        let worst = [greatest(&seen, 0), greatest(&seen, 1)];
        worst_joint = [worst_joint[0].max(worst[0]), worst_joint[1].max(worst[1])];
        chart = chart.group(*name, worst);
    }
    let one = plain(|s| (s.warm_start.enabled, s.slop.enabled, s.penetration_recovery.enabled) = (true, true, true));
    let mut later = Chart::curves("27 bodies that collide: drift of angular momentum", "time, s", "relative drift")
        .log(false, true);
    for (name, solver) in [("one substep", one), ("default, 8 substeps", SolverOptions::default())] {
        lab.progress(0.9, name);
        let seen = drift(&mut crowd(solver)?, seconds);
        if name == "one substep" {
            worst_contact = [greatest(&seen, 0), greatest(&seen, 1)];
            chart = chart.group("contacts", worst_contact);
        }
        later = later.line(name, seen.iter().map(|s| (s.0, s.1[1].max(1e-9))).collect());
    }
    lab.chart(chart);
    lab.chart(later);
    Ok(Verdict::on("a constraint force has the direction Jᵀ and the magnitude λ, equal and opposite on the two bodies")
        .at_most("joints: momentum drifts by", "", 1e-5, worst_joint[0])
        .at_most("joints: angular momentum drifts by", "", 1e-4, worst_joint[1])
        .at_most("contacts, one substep: momentum drifts by", "", 1e-5, worst_contact[0])
        .at_most("contacts, one substep: angular momentum drifts by", "", 1e-4, worst_contact[1])
        .note(
            "Contacts keep their arms for a whole step: with several substeps the two impulses of a sliding \
            contact are off each other's line, and angular momentum is kept to first order in the step only.",
        ))
}
