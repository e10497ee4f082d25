//! D7: a mean of both solutions feels part of the weight and takes twice the time.

use crate::chart::{Chart, Mark};
use crate::setup::{DT, G, MASS, add_stack, force_between, plain, run as advance, world};
use crate::{Experiment, Lab, Result, Verdict};
use ishigaki::{ShockPropagation, SolverOptions};

pub const EXPERIMENT: Experiment =
    Experiment {
        name: "blended-shock", rows: &["D7"], title: "Blended shock propagation: λ = (1−c)λ₀ + cλ₁", run
    };

fn solver(blend: f32, sweeps: u32) -> SolverOptions {
    plain(|s| {
        s.shock_propagation = ShockPropagation { enabled: blend > 0.0, blend };
        s.sweeps = sweeps;
    })
}

/// What a scale under `n` boxes reads, as a part of their weight.
fn reading(n: usize, blend: f32, steps: usize) -> Result<f64> {
    let mut world = world(solver(blend, 400))?;
    let (ground, boxes) = add_stack(&mut world, n)?;
    advance(&mut world, steps);
    let mut sum = 0.0;
    for _ in 0..10 {
        world.step(DT);
        sum += force_between(&world, ground, boxes[0]) / (10.0 * n as f32 * MASS * G);
    }
    Ok(f64::from(sum))
}

/// Least time of a step of a stack of 20, ms.
fn step_time(lab: &Lab<'_>, blend: f32) -> Result<f64> {
    let mut world = world(solver(blend, 40))?;
    crate::setup::change_options(&mut world, |o| o.report.residual = false)?;
    add_stack(&mut world, 20)?;
    advance(&mut world, 10);
    Ok((0..40).map(|_| lab.time(|| world.step(DT)).1).fold(f64::MAX, f64::min) * 1e3)
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let blends: &[f32] = lab.choose(&[0.0, 0.25, 0.5, 0.75, 1.0], &[0.5, 1.0]);
    let steps = lab.choose(60, 20);
    let mut chart = Chart::curves("What a scale under n boxes reads", "c", "reading / weight");
    let mut worst = 0.0_f64;
    for n in [2_usize, 5, 10] {
        let (mut seen, mut predicted) = (Vec::new(), Vec::new());
        for (i, &c) in blends.iter().enumerate() {
            lab.progress(i as f64 / blends.len() as f64 * 0.8, &format!("n = {n}, c = {c}"));
            let found = reading(n, c, steps)?;
            let c = f64::from(c);
            let expected = (1.0 - c) + c / n as f64;
            worst = worst.max((found - expected).abs());
            seen.push((c, found));
            predicted.push((c, expected));
        }
        chart =
            chart.series(format!("n = {n}"), Mark::Points, seen).series(format!("(1−c) + c/{n}"), Mark::Law, predicted);
    }
    lab.chart(chart);
    lab.progress(0.9, "timing");
    let times = [step_time(lab, 0.0)?, step_time(lab, 1.0)?, step_time(lab, 0.5)?];
    lab.chart(
        Chart::bars("Time of a step, stack of 20, 40 sweeps (on this machine)", "ms", ["time"])
            .group("plain", [times[0]])
            .group("shock propagation", [times[1]])
            .group("blended, c = 0.5", [times[2]]),
    );
    Ok(Verdict::on("blending the plain and the shock solution gives back part of the weight at twice the time")
        .at_most("deviation of the reading from (1−c) + c/n", "", 0.01, worst)
        .near("time of blended over plain", "×", 2.0, 0.6, times[2] / times[0]))
}
