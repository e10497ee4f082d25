//! Beyond the talk: tall, heavy and long things with the default options, and the work of the solver for them.

use crate::chart::Chart;
use crate::setup::{DT, scene};
use crate::verdict::short;
use crate::{Experiment, Lab, Result, Verdict};
use ishigaki_scenes::Meter;

pub const EXPERIMENT: Experiment = Experiment {
    name: "it-holds",
    rows: &[],
    title: "Tall, heavy and long: what the default options hold, and at how much work",
    run,
};

/// What a scene is held to.
#[derive(Clone, Copy, PartialEq)]
enum Rule {
    /// It stands with at most this overlap and this drift, mm.
    Stands { pen: f64, drift: f64 },
    /// No joint opens further than this, mm.
    Joints { gap: f64 },
    /// It tumbles and comes to rest: at most this overlap in the last second, mm.
    Rests { pen: f64 },
}

struct Trial {
    label: &'static str,
    scene: &'static str,
    parameters: &'static [(&'static str, f64)],
    seconds: f64,
    rule: Rule,
}

const fn trial(
    label: &'static str,
    scene: &'static str,
    parameters: &'static [(&'static str, f64)],
    seconds: f64,
    rule: Rule,
) -> Trial {
    Trial { label, scene, parameters, seconds, rule }
}

/// The first are cheap enough for tests.
const TRIALS: [Trial; 14] = [
    trial("tower of 40", "tower", &[("n", 40.0)], 60.0, Rule::Stands { pen: 8.0, drift: 10.0 }),
    trial(
        "10 boxes, top 1000 ×",
        "heavy_on_light",
        &[("n", 10.0), ("ratio", 1000.0)],
        30.0,
        Rule::Stands { pen: 10.0, drift: 250.0 },
    ),
    trial(
        "chain of 100, end 1000 ×, hanging",
        "chain",
        &[("links", 100.0), ("end_mass_ratio", 1000.0)],
        10.0,
        Rule::Joints { gap: 10.0 },
    ),
    trial("tower of 160", "tower", &[("n", 160.0)], 60.0, Rule::Stands { pen: 8.0, drift: 10.0 }),
    trial("tower of 400", "tower", &[("n", 400.0)], 20.0, Rule::Stands { pen: 8.0, drift: 10.0 }),
    trial(
        "10 boxes, top 100 ×",
        "heavy_on_light",
        &[("n", 10.0), ("ratio", 100.0)],
        30.0,
        Rule::Stands { pen: 10.0, drift: 250.0 },
    ),
    trial(
        "10 boxes, top 10000 ×",
        "heavy_on_light",
        &[("n", 10.0), ("ratio", 10_000.0)],
        30.0,
        Rule::Stands { pen: 10.0, drift: 250.0 },
    ),
    trial(
        "chain of 100, end 1000 ×, swinging",
        "chain",
        &[("links", 100.0), ("end_mass_ratio", 1000.0), ("swing", 1.0)],
        10.0,
        Rule::Joints { gap: 50.0 },
    ),
    trial("net 30 × 30", "joint_grid", &[("n", 30.0)], 5.0, Rule::Joints { gap: 15.0 }),
    trial("wall", "wall", &[], 30.0, Rule::Stands { pen: 10.0, drift: 10.0 }),
    trial("pyramid of 30", "pyramid", &[("base", 30.0)], 10.0, Rule::Stands { pen: 10.0, drift: 250.0 }),
    trial("100 ragdolls", "ragdolls", &[("n", 100.0)], 5.0, Rule::Joints { gap: 40.0 }),
    trial("pile of 1000", "pile", &[("n", 1000.0)], 8.0, Rule::Rests { pen: 40.0 }),
    trial("pyramid of 100", "pyramid", &[("base", 100.0)], 3.0, Rule::Stands { pen: 10.0, drift: 250.0 }),
];

/// What a run was like.
struct Seen {
    /// Until a body had moved by a quarter of its edge, s; the whole time if none did.
    stood: f64,
    /// Greatest overlap, mm.
    pen: f64,
    /// Greatest overlap in the last second, mm.
    last_pen: f64,
    /// Greatest horizontal way, mm.
    drift: f64,
    /// Greatest opening of a joint, mm.
    gap: f64,
    /// Multiply-adds over those of twelve visits to every row alone: mean, and 95th percentile of the steps.
    work: (f64, f64),
}

fn watch(trial: &Trial, seconds: f64, mut progress: impl FnMut(f64)) -> Result<Seen> {
    let mut scene = scene(trial.scene, trial.parameters, |o| {
        *o = ishigaki::WorldOptions { gravity: o.gravity, ..Default::default() };
        o.rest.sleep.enabled = false;
    })?;
    let mut meter = Meter::new(&scene.world);
    let (mut stood, mut last_pen, mut work, mut budget, mut parts) = (seconds, 0.0_f32, 0, 0, Vec::new());
    while scene.world.time() < seconds {
        let report = scene.world.step(DT);
        meter.observe(&scene.world);
        if !meter.measure().stands && stood == seconds {
            stood = scene.world.time();
        }
        if scene.world.time() > seconds - 1.0 {
            last_pen = last_pen.max(report.max_penetration);
        }
        (work, budget) = (work + report.work, budget + report.work_budget);
        if report.work_budget > 0 {
            parts.push(report.work as f64 / report.work_budget as f64);
        }
        progress(scene.world.time() / seconds);
    }
    parts.sort_by(f64::total_cmp);
    let p95 = parts.get(parts.len() * 95 / 100).copied().unwrap_or(0.0);
    let m = meter.measure();
    Ok(Seen {
        stood,
        pen: 1e3 * f64::from(m.pen),
        last_pen: 1e3 * f64::from(last_pen),
        drift: 1e3 * f64::from(m.drift),
        gap: 1e3 * f64::from(m.joint_gap),
        work: (work as f64 / (budget as f64).max(1.0), p95),
    })
}

/// What is too small to see is so said.
fn rounded(value: f64) -> String {
    if value > 0.0 && value < 1e-3 { "< 0.001".to_string() } else { short(value) }
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let trials = lab.choose(TRIALS.len(), 3);
    let mut verdict = Verdict::on("nothing: beyond it. What stands on paper should stand");
    let columns = ["stood, s", "overlap, mm", "drift, mm", "joint gap, mm", "work, mean", "work, 95 %"];
    let mut table = Chart::table("Default options, sleep off, 60 Hz; work in units of twelve sweeps", "value", columns)
        .shade(|v| (1e-3 + v).ln());
    for (i, trial) in TRIALS[..trials].iter().enumerate() {
        let seconds = lab.choose(trial.seconds, 0.5);
        let seen = watch(trial, seconds, |part| {
            lab.progress((i as f64 + part.min(1.0)) / trials as f64, trial.label);
        })?;
        let stands = matches!(trial.rule, Rule::Stands { .. });
        let last = if let Rule::Rests { .. } = trial.rule { seen.last_pen } else { seen.pen };
        let dash = |shown: bool, v: f64| if shown { (v, rounded(v)) } else { (0.0, "–".to_string()) };
        table = table.row(
            trial.label,
            [
                dash(stands, seen.stood),
                (last, rounded(last)),
                dash(stands, seen.drift),
                dash(matches!(trial.rule, Rule::Joints { .. }), seen.gap),
                (seen.work.0, rounded(seen.work.0)),
                (seen.work.1, rounded(seen.work.1)),
            ],
        );
        verdict = match trial.rule {
            Rule::Stands { pen, drift } => verdict
                .at_least(format!("{}: stood", trial.label), "s", seconds, seen.stood)
                .at_most(format!("{}: overlap", trial.label), "mm", pen, seen.pen)
                .at_most(format!("{}: drift", trial.label), "mm", drift, seen.drift),
            Rule::Joints { gap } => verdict.at_most(format!("{}: joint gap", trial.label), "mm", gap, seen.gap),
            Rule::Rests { pen } => {
                verdict.at_most(format!("{}: overlap at rest", trial.label), "mm", pen, seen.last_pen)
            }
        };
        verdict = verdict.open(format!("{}: work", trial.label), "", seen.work.0);
    }
    lab.chart(table);
    Ok(verdict
        .note("Work counts every multiply-add of the solver, preparation included; above 1 a scene is over budget."))
}
