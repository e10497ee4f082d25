//! D4: what was solved in the last step need not be solved again.

use crate::chart::Chart;
use crate::setup::{DT, G, add_column, add_stack, counted, plain, world};
use crate::{Experiment, Lab, Result, Verdict};

pub const EXPERIMENT: Experiment =
    Experiment { name: "warm-start", rows: &["D4"], title: "Ten sweeps a step, started cold and warm", run };

/// Greatest speed after each step over gΔt: how much of the weight is still not carried.
fn speeds(warm: bool, boxes: bool, frames: usize) -> Result<Vec<f32>> {
    let mut world = world(plain(|s| s.warm_start.enabled = warm))?;
    if boxes {
        add_stack(&mut world, 10)?;
    } else {
        add_column(&mut world, 10)?;
    }
    let mut before = 0.0_f32;
    Ok((0..frames)
        .map(|_| {
            // What this step added to the speed: the weight that its λ did not carry.
            let now = world.step(DT).max_speed;
            let gained = (now - before).max(0.0);
            before = now;
            if warm { now / (G * DT) } else { gained / (G * DT) }
        })
        .collect())
}

/// Residual after each step, N·s over the weight of a box times Δt.
fn residuals(warm: bool, boxes: bool, frames: usize) -> Result<Vec<f32>> {
    let mut world = world(plain(|s| s.warm_start.enabled = warm))?;
    let share = if boxes { 0.25 } else { 1.0 };
    if boxes {
        add_stack(&mut world, 10)?;
    } else {
        add_column(&mut world, 10)?;
    }
    Ok((0..frames).map(|_| world.step(DT).residual / (share * crate::setup::MASS * G * DT)).collect())
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let frames = lab.choose(60, 35);
    let mut chart = Chart::curves("Residual after each step", "steps", "residual / share of a weight").log(false, true);
    let mut column = Vec::new();
    for (i, (name, warm, boxes)) in
        [("10 balls, cold", false, false), ("10 balls, warm", true, false), ("10 boxes, cold", false, true), ("10 boxes, warm", true, true)]
            .into_iter()
            .enumerate()
    {
        lab.progress(i as f64 / 4.0, name);
        let seen = residuals(warm, boxes, frames)?;
        if !boxes {
            column.push(seen.clone());
        }
        chart = chart.line(name, counted(seen));
    }
    lab.chart(chart);
    let (cold_speed, warm_speed) = (speeds(false, false, frames)?, speeds(true, false, frames)?);
    lab.chart(
        Chart::curves("10 balls: speed that the step did not take away", "steps", "speed / gΔt")
            .log(false, true)
            .line("cold: gained in this step", counted(cold_speed.iter().copied()))
            .line("warm: in all", counted(warm_speed.iter().copied())),
    );
    let at = |seen: &[f32], frame: usize| f64::from(seen[frame - 1]);
    Ok(Verdict::on("starting from the last step's λ, found again by semantic id, a few sweeps a step are enough")
        .near("cold: unsupported part of the weight after a step", "", 0.877, 0.03, at(&cold_speed, 1))
        .near("warm, after 10 steps", "", 0.096, 0.02, at(&warm_speed, 10))
        .at_most("warm, after 30 steps", "", 6.8e-4 * 1.2, at(&warm_speed, 30))
        .at_most("residual warm over cold after 30 steps", "", 0.05, at(&column[1], 30) / at(&column[0], 30)))
}
