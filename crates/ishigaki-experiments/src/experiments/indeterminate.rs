//! C6: a box on four points has many solutions; Gauss–Seidel comes to the averaged one.

use crate::chart::{Chart, Mark};
use crate::setup::{DT, G, MASS, add_stack, plain, run as advance, world};
use crate::{Experiment, Lab, Result, Verdict};
use ishigaki::FrictionModel;
use ishigaki::lcp::{Method, Settings};

pub const EXPERIMENT: Experiment = Experiment {
    name: "indeterminate",
    rows: &["C6"],
    title: "A box on four points: three equations for four loads",
    run,
};

/// Greatest deviation from the mean, as a part of it.
fn unevenness(loads: &[f64]) -> f64 {
    let mean = loads.iter().sum::<f64>() / loads.len() as f64;
    loads.iter().map(|l| (l / mean - 1.0).abs()).fold(0.0, f64::max)
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let mut world = world(plain(|s| (s.friction, s.warm_start.enabled, s.sweeps) = (FrictionModel::Off, true, 40)))?;
    add_stack(&mut world, 1)?;
    let problem = world.export_lcp(DT)?.problem;
    let share = 0.25 * f64::from(MASS * G * DT);
    let names = ["corner 1", "corner 2", "corner 3", "corner 4"];
    let mut settings = Settings { tolerance: 0.0, ..Settings::sweeps(1) };
    let mut curves = vec![Vec::new(); 4];
    for sweep in 1..=30 {
        let solution = Method::ProjectedGaussSeidel.solve(&problem, &settings);
        for (curve, lambda) in curves.iter_mut().zip(&solution.lambda) {
            curve.push((f64::from(sweep), lambda / share));
        }
        settings.start = Some(solution.lambda);
    }
    let mut chart = Chart::curves(
        "Projected Gauss–Seidel from a cold start, fixed order",
        "sweeps",
        "load / quarter of the weight",
    );
    for (name, curve) in names.iter().zip(curves) {
        chart = chart.series(*name, Mark::Dotted, curve);
    }
    lab.chart(chart.level(1.0, "even"));

    let mut bars = Chart::bars("Loads by method", "load / quarter of the weight", names);
    let mut verdict = Verdict::on("on indeterminate systems Gauss–Seidel tends to the averaged solution");
    for (name, method) in [
        ("Gauss–Seidel", Method::ProjectedGaussSeidel),
        ("Jacobi, ω ½", Method::ProjectedJacobi),
        ("NNCG", Method::Nncg),
        ("Lemke", Method::Lemke),
        ("Dantzig", Method::Dantzig),
    ] {
        let relaxation = if method == Method::ProjectedJacobi { 0.5 } else { 1.0 };
        let solution = method.solve(&problem, &Settings { relaxation, ..Settings::default() });
        let loads: Vec<f64> = solution.lambda.iter().map(|l| l / share).collect();
        let sum = loads.iter().sum::<f64>();
        if name == "Gauss–Seidel" {
            verdict = verdict.at_most("Gauss–Seidel: greatest deviation from the mean", "", 0.05, unevenness(&loads));
        } else {
            verdict = verdict.open(format!("{name}: greatest deviation"), "", unevenness(&loads));
        }
        verdict = verdict.near(format!("{name}: sum of the loads"), "quarters", 4.0, 1e-5, sum);
        bars = bars.group(name, loads);
    }
    advance(&mut world, 60);
    let points: Vec<f64> =
        world.contacts().flat_map(|c| c.manifolds).flat_map(|m| &m.points).map(|p| f64::from(p.impulse)).collect();
    bars = bars.group("engine, 1 s", points.iter().map(|p| p / share));
    lab.chart(bars);
    Ok(verdict.at_most("engine after a second: greatest deviation", "", 0.05, unevenness(&points)).note(
        "Every solution carries the weight; direct methods stop at a corner of the set of solutions, with \
            one point idle. The engine spreads the loads of four points evenly before each step.",
    ))
}
