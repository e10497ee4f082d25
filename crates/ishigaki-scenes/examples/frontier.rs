//! Quality against time for the scenes that must stand: the table from which the default substeps and sweeps follow.
//!
//! `cargo run --release -p ishigaki-scenes --example frontier > frontier.md`

use ishigaki_scenes::{Meter, named};
use std::time::Instant;

/// Substeps, sweeps, relax sweeps, and whether whole stacks and joint trees are solved at once.
const CONFIGURATIONS: [(u32, u32, u32, bool); 7] = [
    (4, 2, 1, false),
    (8, 2, 1, false),
    (1, 2, 1, true),
    (2, 2, 1, true),
    (3, 2, 1, true),
    (4, 1, 1, true),
    (4, 2, 1, true),
];
/// Scene, parameters, seconds.
type Trial = (&'static str, &'static [(&'static str, f64)], f64);
const SCENES: [Trial; 12] = [
    ("tower", &[("n", 20.0)], 30.0),
    ("wall", &[], 10.0),
    ("arch", &[], 10.0),
    ("arch", &[("thickness", 0.118_25)], 10.0),
    ("card_house", &[], 10.0),
    ("pyramid", &[("base", 30.0)], 5.0),
    ("plank_on_two_towers", &[], 10.0),
    ("heavy_on_light", &[], 10.0),
    ("overhang", &[], 10.0),
    ("chain", &[("links", 20.0)], 10.0),
    ("joint_grid", &[("n", 30.0)], 4.0),
    ("ragdolls", &[("n", 30.0)], 4.0),
];

#[expect(clippy::disallowed_methods, reason = "a benchmark reads the clock; the engine does not")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!(
        "| substeps × (sweeps + relax) | scene | stands | drift, mm | penetration, mm | joint gap, mm | work | ms/step |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for (substeps, sweeps, relax, direct) in CONFIGURATIONS {
        for (name, parameters, seconds) in SCENES {
            let parameters: Vec<(String, f64)> = parameters.iter().map(|&(k, v)| (k.to_string(), v)).collect();
            let mut file = named(name, &parameters)?;
            let solver = &mut file.options.solver;
            (solver.substeps, solver.sweeps, solver.relax_sweeps) = (substeps, sweeps, relax);
            (solver.level_correction.enabled, solver.joint_tree.enabled) = (direct, direct);
            file.options.rest.sleep.enabled = false;
            let mut scene = file.build()?;
            let mut meter = Meter::new(&scene.world);
            let steps = (seconds / f64::from(scene.dt)) as usize;
            let (mut work, mut budget) = (0, 0);
            let start = Instant::now();
            for _ in 0..steps {
                let report = scene.world.step(scene.dt);
                (work, budget) = (work + report.work, budget + report.work_budget);
                meter.observe(&scene.world);
            }
            let ms = 1e3 * start.elapsed().as_secs_f64() / steps as f64;
            let m = meter.measure();
            let label: Vec<String> = parameters.iter().map(|(k, v)| format!(" {k}={v}")).collect();
            println!(
                "| {substeps} × ({sweeps} + {relax}){} | {name}{} | {} | {:.1} | {:.2} | {:.2} | {:.2} | {ms:.2} |",
                if direct { " direct" } else { "" },
                label.concat(),
                if m.stands { "yes" } else { "no" },
                1e3 * m.drift,
                1e3 * m.pen,
                1e3 * m.joint_gap,
                work as f64 / budget.max(1) as f64,
            );
        }
    }
    Ok(())
}
