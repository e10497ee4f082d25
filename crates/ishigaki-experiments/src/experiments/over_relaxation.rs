//! Beyond the talk: joints that step farther than each alone asks for.

use crate::chart::{Chart, Mark};
use crate::course::follow;
use crate::direct::Subject;
use crate::setup::{DT, scene};
use crate::{Experiment, Lab, Result, Verdict};
use ishigaki::OverRelaxation;
use ishigaki::lcp::{BoxLcp, Method, Settings};

pub const EXPERIMENT: Experiment =
    Experiment { name: "over-relaxation", rows: &[], title: "Over-relaxation: nets in fewer sweeps", run };

const CHAIN: Subject = Subject { label: "chain of 20", scene: "chain", parameters: &[("links", 20.0)] };
const NET: Subject = Subject { label: "net of 6 × 6", scene: "joint_grid", parameters: &[("n", 6.0)] };

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let verdict = Verdict::on("nothing: beyond it. Its sweeps pass an impulse on from joint to joint");
    let verdict = cold(lab, verdict)?;
    running(lab, verdict)
}

/// The step after so many of a scene.
fn problem(subject: &Subject, steps: usize) -> Result<BoxLcp> {
    let mut world = scene(subject.scene, subject.parameters, |_| {})?.world;
    for _ in 0..steps {
        world.step(DT);
    }
    Ok(world.export_lcp(DT)?.problem)
}

/// Residual after each of so many sweeps, over that of the first at ω = 1.
fn residuals(problem: &BoxLcp, relaxation: f64, sweeps: usize) -> Vec<f64> {
    let solve = |relaxation: f64, sweeps: usize| {
        let settings = Settings { tolerance: 1e-13, relaxation, ..Settings::sweeps(sweeps) };
        Method::GaussSeidel.solve(problem, &settings).residuals
    };
    let first = solve(1.0, 1).first().copied().unwrap_or(f64::NAN);
    solve(relaxation, sweeps).into_iter().map(|r| r / first).collect()
}

/// What is left of the error by one sweep, in the second half of the list.
fn rate(residuals: &[f64]) -> f64 {
    let n = residuals.len();
    if n < 2 {
        return f64::NAN;
    }
    let begin = n / 2;
    (residuals[n - 1] / residuals[begin]).powf(1.0 / (n - 1 - begin) as f64)
}

/// Young 1954: for rows in a line √λ is the greater root of x² − ωμx + ω − 1 = 0, where μ² is λ at ω = 1, as long as it
/// is real.
fn young(at_one: f64, omega: f64) -> f64 {
    let half = 0.5 * omega * at_one.sqrt();
    (half + (half * half - omega + 1.0).max(0.0).sqrt()).powi(2)
}

fn cold(lab: &mut Lab<'_>, mut verdict: Verdict) -> Result<Verdict> {
    let omega = f64::from(OverRelaxation::default().factor);
    // A net begins flat, where it bears nothing: it is looked at when it hangs.
    for (i, (subject, steps)) in [(CHAIN, 0), (NET, 60)].iter().enumerate() {
        lab.progress(0.05 * i as f64, subject.label);
        let problem = problem(subject, *steps)?;
        let title = format!("Step {} of a {} from a cold start", steps + 1, subject.label);
        let mut chart = Chart::curves(title, "sweeps", "residual / that of one sweep").log(false, true);
        let sweeps = lab.choose(400, 200);
        let plain = residuals(&problem, 1.0, sweeps);
        let over = residuals(&problem, omega, sweeps);
        for (name, list) in [("Gauss–Seidel".to_string(), &plain), (format!("ω = {omega:.1}"), &over)] {
            let curve = list.iter().enumerate().map(|(k, r)| ((k + 1) as f64, *r)).collect();
            chart = chart.line(name, curve);
        }
        lab.chart(chart);
        let (slow, fast) = (rate(&plain), rate(&over));
        verdict = if i == 0 {
            let what = format!("{}, ω = {omega:.1}: part of the error left by a sweep", subject.label);
            verdict.near(what, "", young(slow, omega), 0.002, fast)
        } else {
            let what = format!("{}, ω = {omega:.1}: sweeps in place of one at ω = 1", subject.label);
            verdict.at_most(what, "", 0.5, slow.ln() / fast.ln())
        };
    }
    Ok(verdict)
}

fn running(lab: &mut Lab<'_>, verdict: Verdict) -> Result<Verdict> {
    let seconds = lab.choose(5.0, 0.3);
    let sizes: &[f64] = lab.choose(&[10.0, 20.0, 30.0], &[6.0]);
    let factors: &[f32] = lab.choose(&[1.0, 1.2, 1.4, 1.6, 1.8, 1.9], &[1.0, 1.6]);
    let title = format!("Greatest gap of a joint in {seconds} s");
    let mut chart = Chart::curves(title, "ω after the motion", "gap, mm").log(false, true);
    let (mut before, mut after, mut twice) = (1.0, 1.0, 1.0);
    for (i, &n) in sizes.iter().enumerate() {
        let label = format!("net of {n} × {n}");
        let at = |k: f64| 0.1 + 0.9 * (i as f64 + k) / sizes.len() as f64;
        let gap = |lab: &mut Lab<'_>, factor: f32, sweeps: u32, part: f64| -> Result<f64> {
            let mut scene = scene("joint_grid", &[("n", n)], |o| {
                o.solver.over_relaxation = OverRelaxation { enabled: factor > 1.0, factor };
                o.solver.sweeps = sweeps;
            })?;
            Ok(follow(lab, &mut scene, seconds, at(part)..at(part + 0.1), &label).gap)
        };
        let mut curve = Vec::new();
        for (k, &factor) in factors.iter().enumerate() {
            let seen = gap(lab, factor, 1, 0.1 * k as f64)?;
            curve.push((f64::from(factor), seen));
            before *= if factor == 1.0 { seen } else { 1.0 };
            after *= if factor == OverRelaxation::default().factor { seen } else { 1.0 };
        }
        let two = gap(lab, 1.0, 2, 0.8)?;
        twice *= two;
        chart = chart.line(label.clone(), curve).series(format!("{label}, two sweeps"), Mark::Dotted, vec![(1.0, two)]);
    }
    lab.chart(chart);
    let mean = |product: f64| product.powf(1.0 / sizes.len() as f64);
    let factor = OverRelaxation::default().factor;
    let (before, after, twice) = (mean(before), mean(after), mean(twice));
    Ok(verdict
        .open("nets at ω = 1: gap, geometric mean", "mm", before)
        .open("nets at ω = 1, two sweeps before the motion", "mm", twice)
        .at_most(format!("nets at ω = {factor:.1}"), "mm", before.min(twice), after)
        .note(
            "The sweeps after the motion step farther; the one before it does not, since what overshoots there is a gap. \
            Nets whip when they turn over, and how far they then open is chance by a third.",
        ))
}
