//! D1: overlap is taken back at the rate k, as powers of 1 − k.

use crate::chart::{Chart, Mark};
use crate::setup::{DT, add_ground, body, plain, world};
use crate::{Experiment, Lab, Result, Verdict};
use ishigaki::{Body, PenetrationRecovery, Shape, Vec3};

pub const EXPERIMENT: Experiment = Experiment {
    name: "penetration-recovery",
    rows: &["D1"],
    title: "A ball that starts 20 mm deep in the ground",
    run,
};

/// Depth, mm, and upward speed, m/s, after each step.
fn rise(rate: f32, relax_sweeps: u32, steps: usize) -> Result<Vec<(f64, f64)>> {
    let mut world = world(plain(|s| {
        s.penetration_recovery = PenetrationRecovery { enabled: rate > 0.0, rate, ..PenetrationRecovery::default() };
        s.relax_sweeps = relax_sweeps;
    }))?;
    add_ground(&mut world)?;
    let ball = world.add_body(Body::dynamic(Shape::ball(0.5)).at(0.48 * Vec3::Y))?;
    let mut seen = Vec::new();
    for _ in 0..steps {
        world.step(DT);
        let state = body(&world, ball)?;
        seen.push((1e3 * (0.5 - f64::from(state.center().y)), f64::from(state.velocity().y)));
    }
    Ok(seen)
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let curve = |values: Vec<f64>| values.into_iter().enumerate().map(|(i, y)| ((i + 1) as f64, y)).collect::<Vec<_>>();
    let mut depths = Chart::curves("Overlap with a relax sweep", "steps", "overlap, mm").y_range(-1.0, 21.0);
    let mut worst = 0.0_f64;
    for k in [0.0_f32, 0.1, 0.3, 0.8, 1.0] {
        let seen = rise(k, 1, 30)?;
        let predicted = |n: usize| 20.0 * (1.0 - f64::from(k)).powi(n as i32 + 1);
        worst = seen.iter().enumerate().map(|(n, s)| (s.0 - predicted(n)).abs()).fold(worst, f64::max);
        depths = depths.series(format!("k = {k}"), Mark::Dotted, curve(seen.iter().map(|s| s.0).collect()));
    }
    lab.chart(depths);
    let (with, without) = (rise(0.5, 1, 30)?, rise(0.5, 0, 30)?);
    lab.chart(
        Chart::curves("k = 0.5: does the push stay in the velocity?", "steps", "height above the ground, mm")
            .line("one relax sweep", curve(with.iter().map(|s| -s.0).collect()))
            .line("none, as in the talk", curve(without.iter().map(|s| -s.0).collect())),
    );
    let push = 0.5 * 0.02 / f64::from(DT);
    Ok(Verdict::on("v_error = k d/Δt with k ≤ 1 takes overlap back")
        .at_most("deviation from d₀(1−k)ⁿ", "mm", 0.002, worst)
        .near("upward speed after a step without a relax sweep", "m/s", push, 1e-4, without[0].1)
        .near("the same with a relax sweep", "m/s", 0.0, 1e-4, with[0].1)
        .note(
            "The talk leaves the push in the velocity: the ball jumps off the ground. A sweep without recovery \
            after the motion takes it out again.",
        ))
}
