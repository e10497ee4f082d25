//! C7: clamp λ after every row update: that is all.

use crate::chart::{Chart, Mark};
use crate::setup::{DT, G, add_column, plain, world};
use crate::{Experiment, Lab, Result, Verdict};

pub const EXPERIMENT: Experiment = Experiment {
    name: "pgs-two-body",
    rows: &["C7"],
    title: "Two equal bodies on each other: what k sweeps leave of v = gΔt",
    run,
};

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let (mut seen, mut predicted, mut worst) = (Vec::new(), Vec::new(), 0.0_f64);
    for sweeps in 1..=16_u32 {
        lab.progress(f64::from(sweeps) / 16.0, "sweeping");
        let mut world = world(plain(|s| s.sweeps = sweeps))?;
        add_column(&mut world, 2)?;
        let left = f64::from(world.step(DT).max_speed / (G * DT));
        let law = 0.5_f64.powi(sweeps as i32);
        worst = worst.max((left / law - 1.0).abs());
        seen.push((f64::from(sweeps), left));
        predicted.push((f64::from(sweeps), law));
    }
    lab.chart(
        Chart::curves("Speed left after a step, from a cold start", "sweeps", "greatest speed / gΔt")
            .log(false, true)
            .series("engine", Mark::Points, seen)
            .series("2⁻ᵏ", Mark::Law, predicted),
    );
    Ok(Verdict::on("projected Gauss–Seidel converges: k sweeps leave v/2ᵏ of two bodies").at_most(
        "relative deviation from v/2ᵏ, k = 1 … 16",
        "",
        0.01,
        worst,
    ))
}
