//! D4: what was solved in the last step need not be solved again.

use crate::chart::Chart;
use crate::setup::{DT, G, add_column, add_stack, counted, plain, world};
use crate::{Experiment, Lab, Result, Verdict};
use ishigaki::FrictionModel;
use ishigaki::lcp::{Settings, projected_gauss_seidel};

pub const EXPERIMENT: Experiment =
    Experiment { name: "warm-start", rows: &["D4"], title: "Ten sweeps a step, started cold and warm", run };

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

/// The same step of a column of ten solved again and again with ten sweeps, from zero or from the last λ: the greatest
/// speed left after each, over gΔt.
fn repeated(warm: bool, frames: usize) -> Result<Vec<f32>> {
    let mut world = world(plain(|s| s.friction = FrictionModel::Off))?;
    add_column(&mut world, 10)?;
    let problem = world.export_lcp(DT)?.problem;
    let (mut settings, mut left) = (Settings { tolerance: 0.0, ..Settings::sweeps(10) }, Vec::new());
    for _ in 0..frames {
        let solution = projected_gauss_seidel(&problem, &settings);
        // Contacts from the ground up: the speed of a ball is the sum of the gaps' rates below it.
        let mut speed = 0.0;
        let speeds = solution.w.iter().map(|w| {
            speed += w;
            f64::abs(speed)
        });
        left.push((speeds.fold(0.0, f64::max) / f64::from(G * DT)) as f32);
        settings.start = warm.then_some(solution.lambda);
    }
    Ok(left)
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let frames = lab.choose(60, 35);
    let mut chart = Chart::curves("Residual after each step", "steps", "residual / share of a weight").log(false, true);
    let mut column = Vec::new();
    for (i, (name, warm, boxes)) in [
        ("10 balls, cold", false, false),
        ("10 balls, warm", true, false),
        ("10 boxes, cold", false, true),
        ("10 boxes, warm", true, true),
    ]
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
    let (cold_again, warm_again) = (repeated(false, frames)?, repeated(true, frames)?);
    lab.chart(
        Chart::curves("The same step of 10 balls solved again and again", "times", "speed left / gΔt")
            .log(false, true)
            .line("cold", counted(cold_again.iter().copied()))
            .line("warm", counted(warm_again.iter().copied())),
    );
    let at = |seen: &[f32], frame: usize| f64::from(seen[frame - 1]);
    Ok(Verdict::on("starting from the last step's λ, found again by semantic id, a few sweeps a step are enough")
        .near("the same step again, cold: speed left", "gΔt", 0.877, 0.005, at(&cold_again, 30))
        .near("warm, after 10 times", "gΔt", 0.096, 0.005, at(&warm_again, 10))
        .near("warm, after 30 times", "gΔt", 6.8e-4, 1e-4, at(&warm_again, 30))
        .at_most("in motion: residual warm over cold after 30 steps", "", 0.05, at(&column[1], 30) / at(&column[0], 30))
        .note(
            "In motion the balls have fallen a little before the impulses have grown: the residual first \
            rises, and then falls as fast.",
        ))
}
