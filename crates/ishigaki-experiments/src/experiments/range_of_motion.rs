//! B9: a neck does not turn backwards.

use crate::chart::Chart;
use crate::setup::{DT, G, plain, world};
use crate::{Experiment, Lab, Result, Verdict};
use ishigaki::{Body, BodyKind, Joint, Shape, SolverOptions, Vec3};

pub const EXPERIMENT: Experiment = Experiment {
    name: "range-of-motion",
    rows: &["B9"],
    title: "An arm of 1 m falls on the end of its range, 30° below level",
    run,
};

/// Where the range ends, rad.
const END: f32 = -std::f32::consts::FRAC_PI_6;

/// What pulls at the end of the arm.
#[derive(Clone, Copy)]
enum Load {
    /// A force of so many weights of the arm.
    Force(f32),
    /// A ball of so many times its mass, welded on.
    Ball(f32),
}

/// Angle over time, degrees.
fn fall(load: Load, solver: SolverOptions, seconds: f64) -> Result<Vec<(f64, f64)>> {
    let mut world = world(solver)?;
    let wall = world.add_body(Body::empty(BodyKind::Fixed))?;
    let arm = Body::dynamic(Shape::cuboid(0.5, 0.05, 0.05)).mass(5.0).at(0.5 * Vec3::X);
    let arm = world.add_body(arm)?;
    let hinge = world.add_joint(Joint::hinge(wall, arm, Vec3::ZERO, Vec3::Z).limit(END..=1.0))?;
    if let Load::Ball(ratio) = load {
        let ball = world.add_body(Body::dynamic(Shape::ball(0.1)).mass(5.0 * ratio).at(Vec3::X))?;
        world.add_joint(Joint::fixed(arm, ball, Vec3::X))?;
    }
    let mut angles = Vec::new();
    while world.time() < seconds {
        if let (Load::Force(weights), Some(mut arm)) = (load, world.body_mut(arm)) {
            let end = arm.state().pose() * (0.5 * Vec3::X);
            arm.apply_force_at(-weights * 5.0 * G * Vec3::Y, end)?;
        }
        world.step(DT);
        let angle = world.joint(hinge).and_then(|j| j.coordinates().first()).map_or(f32::NAN, |a| *a);
        angles.push((world.time(), f64::from(angle).to_degrees()));
    }
    Ok(angles)
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let seconds = lab.choose(4.0, 1.5);
    let mut chart = Chart::curves("Angle of the arm", "time, s", "angle, °");
    let mut over = Chart::curves("Beyond the range", "time, s", "angle, °").log(false, true);
    let mut verdict = Verdict::on("±axis·(ω_A − ω_B) ≥ k θ_err/Δt with λ ≥ 0 keeps a joint in its range");
    let end = f64::from(END).to_degrees();
    let default = SolverOptions::default;
    let ten = || plain(|s| s.warm_start.enabled = true);
    for (i, (name, load, solver)) in [
        ("alone", Load::Force(0.0), default()),
        ("pulled by its weight", Load::Force(1.0), default()),
        ("pulled by 10 weights", Load::Force(10.0), default()),
        ("pulled by 100 weights", Load::Force(100.0), default()),
        ("10 × ball welded on", Load::Ball(10.0), default()),
        ("10 × ball, 10 sweeps", Load::Ball(10.0), ten()),
    ]
    .into_iter()
    .enumerate()
    {
        lab.progress(i as f64 / 6.0, name);
        let angles = fall(load, solver, seconds)?;
        let beyond: Vec<(f64, f64)> = angles.iter().map(|a| (a.0, (end - a.1).max(1e-5))).collect();
        let worst = beyond.iter().map(|b| b.1).fold(0.0, f64::max);
        // How far it still bounces in the last quarter.
        let late = angles.iter().filter(|a| a.0 > 0.75 * seconds).map(|a| (a.1 - end).abs()).fold(0.0, f64::max);
        if i < 5 {
            verdict = verdict.at_most(format!("{name}: beyond the range"), "°", 0.5, worst).at_most(
                format!("{name}: from the end when it should rest"),
                "°",
                0.5,
                late,
            );
        }
        chart = chart.line(name, angles);
        over = over.line(name, beyond);
    }
    lab.chart(chart.level(end, "end of the range"));
    lab.chart(over);
    Ok(verdict.note(
        "With the talk's ten sweeps a heavy ball welded to the light arm swings far through the end of the range: a row \
        that sees the arm alone is too weak. The engine's limit sees through the weld, and no speed of its recovery stays.",
    ))
}
