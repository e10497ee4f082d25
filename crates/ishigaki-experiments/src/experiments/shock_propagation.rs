//! D6: with the lower body infinitely heavy forces travel upward only: one sweep is enough, and the weight is lost.

use crate::chart::{Chart, Mark};
use crate::setup::{DT, G, MASS, add_column, add_stack, body, force_between, plain, run as advance, world};
use crate::{Experiment, Lab, Result, Verdict};
use ishigaki::{ShockPropagation, SolverOptions};

pub const EXPERIMENT: Experiment = Experiment {
    name: "shock-propagation",
    rows: &["D6"],
    title: "Shock propagation: the lower body of a contact counts as infinitely heavy",
    run,
};

/// With or without it.
pub fn solver(shock: bool, sweeps: u32) -> SolverOptions {
    plain(|s| {
        s.sweeps = sweeps;
        s.shock_propagation = ShockPropagation { enabled: shock, blend: 1.0 };
    })
}

/// Greatest speed after a step of a column of 20, over gΔt.
fn speed(shock: bool, sweeps: u32) -> Result<f64> {
    let mut world = world(solver(shock, sweeps))?;
    add_column(&mut world, 20)?;
    Ok(f64::from(world.step(DT).max_speed / (G * DT)))
}

/// What the ground carries under `n` boxes, in weights of one.
fn reading(shock: bool, n: usize) -> Result<f64> {
    let mut options = solver(shock, 40);
    options.warm_start.enabled = !shock;
    let mut world = world(options)?;
    let (ground, boxes) = add_stack(&mut world, n)?;
    advance(&mut world, 90);
    Ok((0..30)
        .map(|_| {
            world.step(DT);
            f64::from(force_between(&world, ground, boxes[0]) / (30.0 * MASS * G))
        })
        .sum())
}

/// Lean of the top of a tower over time, m, with ten sweeps in each of four substeps.
fn lean(shock: bool, n: usize, seconds: f64) -> Result<Vec<(f64, f64)>> {
    let mut options = SolverOptions::talk();
    options.weight_amplification.enabled = false;
    options.shock_propagation = ShockPropagation { enabled: shock, blend: 1.0 };
    let mut world = world(options)?;
    let (_, boxes) = add_stack(&mut world, n)?;
    let mut seen = Vec::new();
    while world.time() < seconds {
        world.step(DT);
        let top = body(&world, boxes[n - 1])?.center();
        seen.push((world.time(), f64::from((top - (n as f32 - 0.5) * ishigaki::Vec3::Y).length()).clamp(1e-6, 1e3)));
    }
    Ok(seen)
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let mut chart =
        Chart::curves("Column of 20 balls from a cold start", "sweeps", "greatest speed / gΔt").log(true, true);
    for (name, shock) in [("plain", false), ("shock propagation", true)] {
        let mut seen = Vec::new();
        for sweeps in [1, 2, 3, 5, 10, 20, 50, 100, 200, 500, 1000] {
            seen.push((f64::from(sweeps), speed(shock, sweeps)?.max(1e-7)));
        }
        chart = chart.series(name, Mark::Dotted, seen);
    }
    lab.chart(chart);
    lab.progress(0.2, "scales");
    let sizes: &[usize] = lab.choose(&[1, 2, 3, 5, 7, 10], &[2, 5]);
    let (mut plain, mut with) = (Vec::new(), Vec::new());
    for &n in sizes {
        plain.push((n as f64, reading(false, n)?));
        with.push((n as f64, reading(true, n)?));
    }
    let lost = with.last().map_or(f64::NAN, |r| r.1);
    lab.chart(
        Chart::curves("What a scale reads under n boxes", "boxes", "reading, weights of a box")
            .series("plain", Mark::Dotted, plain)
            .series("shock propagation", Mark::Dotted, with),
    );
    let (n, seconds) = lab.choose((40, 8.0), (8, 1.0));
    let mut chart =
        Chart::curves(format!("Tower of {n}: how far its top has moved"), "time, s", "distance, m").log(false, true);
    let mut last = Vec::new();
    for (i, (name, shock)) in [("plain", false), ("shock propagation", true)].into_iter().enumerate() {
        lab.progress(0.4 + 0.3 * i as f64, name);
        let seen = lean(shock, n, seconds)?;
        last.push(seen.last().map_or(f64::NAN, |s| s.1));
        chart = chart.line(name, seen);
    }
    lab.chart(chart);
    Ok(Verdict::on("with the lower body's mass infinite, forces travel upward only: stacks converge at once")
        .at_most("column of 20, one sweep: speed left", "gΔt", 1e-4, speed(true, 1)?)
        .near("scale under the largest stack", "boxes", 1.0, 0.01, lost)
        .open("tower, plain: top has moved", "m", last[0])
        .open("tower, shock propagation: top has moved", "m", last[1])
        .note("The price is the weight-feeling problem: whatever stands on it, a scale reads the lowest box alone."))
}
