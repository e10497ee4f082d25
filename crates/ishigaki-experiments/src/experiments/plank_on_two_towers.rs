//! D5: hops mislead: a brick that carries a plank may be higher than the plank.

use crate::chart::Chart;
use crate::setup::{DT, body, scene};
use crate::{Experiment, Lab, Result, Verdict};
use ishigaki::{ShockPropagation, SolverOptions, WeightAmplification};
use ishigaki_scenes::Meter;

pub const EXPERIMENT: Experiment = Experiment {
    name: "plank-on-two-towers",
    rows: &["D5"],
    title: "A plank of 60 t on two towers of 3 m: three bricks on the left, six on the right",
    run,
};

/// Greatest move of a center over its body's smallest edge, %, over time.
fn moves(solver: SolverOptions, seconds: f64) -> Result<Vec<(f64, f64)>> {
    let mut scene = scene("plank_on_two_towers", &[], |o| o.solver = solver)?;
    let mut meter = Meter::new(&scene.world);
    let mut seen = Vec::new();
    while scene.world.time() < seconds {
        scene.world.step(DT);
        meter.observe(&scene.world);
        seen.push((scene.world.time(), 100.0 * f64::from(meter.measure().greatest_move)));
    }
    Ok(seen)
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let mut still = scene("plank_on_two_towers", &[], |_| {})?;
    still.world.step(DT);
    let heights: Vec<Option<u32>> =
        still.bodies.iter().filter_map(|(_, h)| body(&still.world, *h).ok()).map(|b| b.height()).collect();
    // The ground, three bricks, six bricks, the plank.
    let cell = |h: &Option<u32>| (h.map_or(0.0, f64::from), h.map_or("none".to_string(), |h| h.to_string()));
    let pad = |mut cells: Vec<(f64, String)>| {
        cells.resize(6, (0.0, " ".to_string()));
        cells
    };
    lab.chart(
        Chart::table("Heights in hops, from the ground up", "hops", (1..=6).map(|i| format!("brick {i}")))
            .row("left tower", pad(heights[1..4].iter().map(cell).collect()))
            .row("right tower", pad(heights[4..10].iter().map(cell).collect()))
            .row("plank", pad(heights[10..11].iter().map(cell).collect())),
    );
    let seconds = lab.choose(10.0, 1.5);
    let base = || SolverOptions {
        weight_amplification: WeightAmplification { enabled: false, ..WeightAmplification::default() },
        ..SolverOptions::talk()
    };
    let shock = |blend| SolverOptions { shock_propagation: ShockPropagation { enabled: true, blend }, ..base() };
    let mut chart =
        Chart::curves("Greatest move of a body: 25 % of its smallest edge is a fall", "time, s", "move, % of the edge")
            .log(false, true)
            .y_range(0.01, 1e4);
    let mut last = Vec::new();
    for (i, (name, solver)) in [
        ("talk without amplification", base()),
        ("talk, WA 1.4", SolverOptions::talk()),
        ("talk, shock propagation", shock(1.0)),
        ("talk, blended shock 0.5", shock(0.5)),
        ("default", SolverOptions::default()),
    ]
    .into_iter()
    .enumerate()
    {
        lab.progress(i as f64 / 5.0, name);
        let seen = moves(solver, seconds)?;
        last.push(seen.last().map_or(f64::NAN, |s| s.1));
        chart = chart.line(name, seen);
    }
    lab.chart(chart.level(25.0, "falls"));
    let height = |i: usize| heights.get(i).copied().flatten().map_or(f64::NAN, f64::from);
    Ok(Verdict::on("heights say which of two bodies in contact is the lower one")
        .near("height of the plank", "hops", 4.0, 0.0, height(10))
        .near("height of the brick that carries its right end", "hops", 5.0, 0.0, height(9))
        .at_most("default: move", "%", 25.0, last[4])
        .open("talk without amplification: move", "%", last[0])
        .open("talk with WA: move", "%", last[1])
        .open("talk with shock propagation: move", "%", last[2])
        .note(
            "A known pathology: hops go over the plank too, so the brick below it counts as the upper body, \
            and amplification works against it there.",
        ))
}
