//! D11: a ragdoll must come to rest.

use crate::chart::Chart;
use crate::setup::{DT, scene};
use crate::{Experiment, Lab, Result, Verdict};
use ishigaki::SolverOptions;

pub const EXPERIMENT: Experiment =
    Experiment { name: "ragdoll-dies", rows: &["D11"], title: "Ragdolls fall and come to rest; sleep is off", run };

struct Fall {
    speed: Vec<(f64, f64)>,
    gap: Vec<(f64, f64)>,
    landing: f64,
    rest: f64,
}

fn fall(name: &str, n: Option<f64>, solver: SolverOptions, seconds: f64) -> Result<Fall> {
    let parameters: Vec<(&str, f64)> = n.map(|n| ("n", n)).into_iter().collect();
    let mut scene = scene(name, &parameters, |o| o.solver = solver)?;
    let world = &mut scene.world;
    let mut fall = Fall { speed: vec![], gap: vec![], landing: f64::NAN, rest: f64::NAN };
    while world.time() < seconds {
        let report = world.step(DT).clone();
        let now = world.time();
        if fall.landing.is_nan() && world.contacts().next().is_some() {
            fall.landing = now;
        }
        fall.speed.push((now, f64::from(report.max_speed).max(1e-6)));
        fall.gap.push((now, (1e3 * f64::from(report.max_joint_error)).max(1e-4)));
        if report.max_speed > 0.05 || fall.landing.is_nan() {
            fall.rest = f64::NAN;
        } else if fall.rest.is_nan() {
            fall.rest = now;
        }
    }
    // What never rests is counted as resting at the end.
    fall.rest = if fall.rest.is_nan() { seconds } else { fall.rest };
    Ok(fall)
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let seconds = lab.choose(12.0, 2.0);
    let n = lab.choose(20.0, 2.0);
    let heap = format!("{n} ragdolls, default");
    let mut speeds = Chart::curves("Greatest speed", "time, s", "speed, m/s").log(false, true);
    let mut gaps = Chart::curves("Greatest gap of a joint", "time, s", "gap, mm").log(false, true);
    let mut falls = Vec::new();
    for (i, (label, name, n, solver)) in [
        ("one ragdoll, default", "ragdoll", None, SolverOptions::default()),
        (heap.as_str(), "ragdolls", Some(n), SolverOptions::default()),
        ("one ragdoll, the talk's options", "ragdoll", None, SolverOptions::talk()),
    ]
    .into_iter()
    .enumerate()
    {
        lab.progress(i as f64 / 3.0, label);
        let fall = fall(name, n, solver, seconds)?;
        speeds = speeds.line(label, fall.speed.clone());
        gaps = gaps.line(label, fall.gap.clone());
        falls.push(fall);
    }
    lab.chart(speeds.level(0.05, "at rest"));
    lab.chart(gaps);
    let settled = |fall: &Fall| fall.gap.iter().filter(|g| g.0 > fall.rest).map(|g| g.1).fold(0.0, f64::max);
    Ok(Verdict::on("ragdolls must die: they come to rest")
        .at_most("one ragdoll: rest after landing", "s", 5.0, falls[0].rest - falls[0].landing)
        .at_most("a heap: rest after the first landing", "s", 11.0, falls[1].rest - falls[1].landing)
        .at_most("one ragdoll: gap at rest", "mm", 5.0, settled(&falls[0]))
        .at_most("a heap: gap at rest", "mm", 10.0, settled(&falls[1]))
        .open("one ragdoll, the talk's options: rest after landing", "s", falls[2].rest - falls[2].landing))
}
