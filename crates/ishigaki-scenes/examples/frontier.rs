//! Quality against time for the scenes that must stand: the table from which the default substeps and sweeps follow.
//!
//! `cargo run --release -p ishigaki-scenes --example frontier > frontier.md`

use ishigaki_scenes::{Meter, named};
use std::time::Instant;

/// Substeps, sweeps, relax sweeps.
const CONFIGURATIONS: [(u32, u32, u32); 7] =
    [(4, 2, 1), (4, 4, 1), (6, 2, 1), (8, 1, 1), (8, 2, 1), (8, 4, 1), (12, 2, 1)];
/// Scene, parameters, seconds.
type Trial = (&'static str, &'static [(&'static str, f64)], f64);
const SCENES: [Trial; 8] = [
    ("tower", &[("n", 20.0)], 60.0),
    ("wall", &[], 20.0),
    ("arch", &[], 20.0),
    ("arch", &[("thickness", 0.118_25)], 20.0),
    ("card_house", &[], 20.0),
    ("pyramid", &[("base", 30.0)], 8.0),
    ("plank_on_two_towers", &[], 10.0),
    ("chain", &[("links", 20.0)], 10.0),
];

#[expect(clippy::disallowed_methods, reason = "a benchmark reads the clock; the engine does not")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!(
        "| substeps × (sweeps + relax) | scene | stands | drift, mm | penetration, mm | joint gap, mm | ms/step |"
    );
    println!("|---|---|---|---|---|---|---|");
    for (substeps, sweeps, relax) in CONFIGURATIONS {
        for (name, parameters, seconds) in SCENES {
            let parameters: Vec<(String, f64)> = parameters.iter().map(|&(k, v)| (k.to_string(), v)).collect();
            let mut file = named(name, &parameters)?;
            let solver = &mut file.options.solver;
            (solver.substeps, solver.sweeps, solver.relax_sweeps) = (substeps, sweeps, relax);
            file.options.rest.sleep.enabled = false;
            let mut scene = file.build()?;
            let mut meter = Meter::new(&scene.world);
            let steps = (seconds / f64::from(scene.dt)) as usize;
            let start = Instant::now();
            for _ in 0..steps {
                scene.world.step(scene.dt);
                meter.observe(&scene.world);
            }
            let ms = 1e3 * start.elapsed().as_secs_f64() / steps as f64;
            let m = meter.measure();
            let label: Vec<String> = parameters.iter().map(|(k, v)| format!(" {k}={v}")).collect();
            println!(
                "| {substeps} × ({sweeps} + {relax}) | {name}{} | {} | {:.1} | {:.2} | {:.2} | {ms:.2} |",
                label.concat(),
                if m.stands { "yes" } else { "no" },
                1e3 * m.drift,
                1e3 * m.pen,
                1e3 * m.joint_gap,
            );
        }
    }
    Ok(())
}
