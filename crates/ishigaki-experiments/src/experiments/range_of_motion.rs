//! B9: a neck does not turn backwards.

use crate::chart::Chart;
use crate::setup::{DT, plain, world};
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

/// Angle over time, degrees; the end carries a ball of `load` times the arm's mass.
fn fall(load: f32, solver: SolverOptions, seconds: f64) -> Result<Vec<(f64, f64)>> {
    let mut world = world(solver)?;
    let wall = world.add_body(Body::empty(BodyKind::Fixed))?;
    let arm = Body::dynamic(Shape::cuboid(0.5, 0.05, 0.05)).mass(5.0).at(0.5 * Vec3::X);
    let arm = world.add_body(arm)?;
    let hinge = world.add_joint(Joint::hinge(wall, arm, Vec3::ZERO, Vec3::Z).limit(END..=1.0))?;
    if load > 0.0 {
        let ball = world.add_body(Body::dynamic(Shape::ball(0.1)).mass(5.0 * load).at(Vec3::X))?;
        world.add_joint(Joint::fixed(arm, ball, Vec3::X))?;
    }
    let mut angles = Vec::new();
    while world.time() < seconds {
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
    for (i, load) in [0.0_f32, 1.0, 10.0, 100.0].into_iter().enumerate() {
        let name = format!("load of {load} arms");
        lab.progress(i as f64 / 4.0, &name);
        let angles = fall(load, SolverOptions::default(), seconds)?;
        let beyond: Vec<(f64, f64)> = angles.iter().map(|a| (a.0, (end - a.1).max(1e-5))).collect();
        let rest = beyond.last().map_or(f64::NAN, |b| b.1);
        let worst = beyond.iter().map(|b| b.1).fold(0.0, f64::max);
        verdict = verdict.at_most(format!("{name}: beyond the range at rest"), "°", 0.1, rest);
        if load == 100.0 {
            verdict = verdict.at_most(format!("{name}: at the impact"), "°", 2.0, worst);
        }
        chart = chart.line(&name, angles);
        over = over.line(name, beyond);
    }
    let plain = fall(10.0, plain(|s| s.warm_start.enabled = true), seconds)?;
    let beyond = plain.iter().map(|a| (a.0, (end - a.1).max(1e-5))).collect();
    over = over.line("load of 10 arms, one substep of 10 sweeps", beyond);
    lab.chart(chart.level(end, "end of the range"));
    lab.chart(over);
    Ok(verdict)
}
