//! D: every technique switched alone, on scenes that need it.

use crate::chart::Chart;
use crate::course::rounded;
use crate::setup::{DT, scene};
use crate::{Experiment, Lab, Result, Verdict};
use ishigaki::{FrictionModel, Permutation, SolverOptions, WorldOptions};
use ishigaki_scenes::Meter;

pub const EXPERIMENT: Experiment = Experiment {
    name: "technique-matrix",
    rows: &["D1", "D2", "D3", "D4", "D6", "D7", "D8", "D10"],
    title: "Every technique on and off, from the talk's options, on five scenes",
    run,
};

type Switch = fn(&mut WorldOptions);

/// From `SolverOptions::talk()`, what differs.
const VARIANTS: [(&str, Switch); 13] = [
    ("the talk's options", |_| {}),
    ("− recovery", |o| o.solver.penetration_recovery.enabled = false),
    ("− slop", |o| o.solver.slop.enabled = false),
    ("− permutation", |o| o.solver.permutation = Permutation::None),
    ("− warm start", |o| o.solver.warm_start.enabled = false),
    ("− WA", |o| o.solver.weight_amplification.enabled = false),
    ("shock for WA", |o| {
        o.solver.weight_amplification.enabled = false;
        o.solver.shock_propagation.enabled = true;
    }),
    ("blended shock for WA", |o| {
        o.solver.weight_amplification.enabled = false;
        o.solver.shock_propagation.enabled = true;
        o.solver.shock_propagation.blend = 0.5;
    }),
    ("− aggressive sleep", |o| o.rest.aggressive_sleep.enabled = false),
    ("box friction", |o| o.solver.friction = FrictionModel::Box),
    ("one substep", |o| o.solver.substeps = 1),
    ("+ manifold blocks", |o| o.solver.manifold_block.enabled = true),
    ("default options", |o| o.solver = SolverOptions::default()),
];

/// Label, scene, parameters.
type Trial = (&'static str, &'static str, &'static [(&'static str, f64)]);

const SCENES: [Trial; 5] = [
    ("tower of 20", "tower", &[("n", 20.0)]),
    ("wall 8 × 6", "wall", &[("columns", 8.0), ("rows", 6.0)]),
    ("pyramid of 8", "pyramid", &[("base", 8.0)]),
    ("heavy on light", "heavy_on_light", &[]),
    ("4 ragdolls", "ragdolls", &[("n", 4.0)]),
];

/// What a run was like.
#[derive(Clone, Copy, Default)]
struct Seen {
    /// Until it fell; for ragdolls until the end, s.
    survival: f64,
    /// Mean over the last second, mm/s.
    rms: f64,
    /// Deepest overlap, mm.
    pen: f64,
    /// Median of a step, ms.
    cost: f64,
}

fn watch(lab: &Lab<'_>, name: &str, parameters: &[(&str, f64)], switch: Switch, seconds: f64) -> Result<Seen> {
    let mut scene = scene(name, parameters, |o| {
        o.solver = SolverOptions::talk();
        o.rest.aggressive_sleep.enabled = true;
        o.report.residual = false;
        switch(o);
    })?;
    let falls = name == "ragdolls";
    let mut meter = Meter::new(&scene.world);
    let (mut seen, mut times, mut squares, mut count) =
        (Seen { survival: seconds, ..Seen::default() }, vec![], 0.0, 0.0);
    while scene.world.time() < seconds {
        times.push(lab.time(|| scene.world.step(DT)).1);
        meter.observe(&scene.world);
        if !falls && !meter.measure().stands && seen.survival == seconds {
            seen.survival = scene.world.time();
        }
        if scene.world.time() > seconds - 1.0 {
            for (_, body) in scene.world.bodies().filter(|(_, b)| b.kind() == ishigaki::BodyKind::Dynamic) {
                squares += f64::from(body.velocity().length_squared());
                count += 1.0;
            }
        }
    }
    times.sort_by(f64::total_cmp);
    seen.rms = 1e3 * (squares / f64::max(count, 1.0)).sqrt();
    seen.pen = 1e3 * f64::from(meter.measure().pen);
    seen.cost = 1e3 * times[times.len() / 2];
    Ok(seen)
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let seconds = lab.choose(6.0, 0.6);
    let scenes = lab.choose(5, 2);
    let variants = lab.choose(VARIANTS.len(), 2);
    let mut seen = Vec::new();
    for (i, (name, switch)) in VARIANTS[..variants].iter().enumerate() {
        let mut row = Vec::new();
        for (k, (label, scene, parameters)) in SCENES[..scenes].iter().enumerate() {
            let done = (i as f64 + k as f64 / scenes as f64) / variants as f64;
            lab.progress(done, &format!("{name}: {label}"));
            row.push(watch(lab, scene, parameters, *switch, seconds)?);
        }
        seen.push((*name, row));
    }
    type Measure = fn(&Seen) -> f64;
    type Shade = fn(f64) -> f64;
    let logarithm: Shade = |v| (1e-3 + v).ln();
    let measures: [(String, Measure, Shade); 4] = [
        (
            format!(
                "Survival: seconds until a body has moved by ¼ of its edge (of {seconds}; ragdolls need not \
                stand)"
            ),
            |s| s.survival,
            |v| -v,
        ),
        ("Root mean square of the speeds in the last second, mm/s".to_string(), |s| s.rms, logarithm),
        ("Deepest overlap after 0.5 s, mm".to_string(), |s| s.pen, logarithm),
        ("Time of a step, median, ms (on this machine)".to_string(), |s| s.cost, logarithm),
    ];
    for (title, value, shade) in measures {
        let mut table = Chart::table(title, "value", SCENES[..scenes].iter().map(|s| s.0)).shade(shade);
        for (name, row) in &seen {
            table = table.row(*name, row.iter().map(|s| (value(s), rounded(value(s)))));
        }
        lab.chart(table);
    }
    let all = |i: usize| seen[i].1.iter().take(4).filter(|s| s.survival >= seconds).count() as f64;
    let mut verdict = Verdict::on("the techniques together make piles stable; each mends what the others leave");
    if variants == VARIANTS.len() {
        verdict = verdict
            .at_least("the talk's options: scenes that stand, of 4", "", 4.0, all(0))
            .at_least("default options: scenes that stand, of 4", "", 4.0, all(variants - 1))
            .at_most("fewest that stand with one technique left out", "", 3.0, (1..6).map(all).fold(4.0, f64::min))
            .open("without warm start", "", all(4))
            .open("without WA", "", all(5))
            .open("without permutation", "", all(3));
    } else {
        verdict = verdict.open("scenes that stand", "", all(0));
    }
    Ok(verdict)
}
