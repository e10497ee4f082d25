//! `cargo xtask counts`: instructions of a step, whole and by kernel, held to a stored baseline.
//!
//! Clocks of shared machines are off by tens of percent; valgrind counts what a program executes, and counts the same in
//! each run. It runs the release build of the command line and counts inside `World::step` only: reading a scene and
//! printing a result are not in the figures. These depend on the width of lanes, so [`missing`] wants AVX2, and on the
//! compiler, so the baseline names its own. Under another one kernels may be inlined elsewhere: then only whole steps are
//! judged, with [`FOREIGN_TOLERANCE`], until somebody blesses. Fewer instructions fail as well: what a change gains, the
//! next one could lose unseen.

mod baseline;
mod callgrind;

use crate::run::{cargo, execute, root, target_directory};
use baseline::Baseline;
use std::collections::BTreeMap;
use std::process::{Command, Stdio};

/// Greatest change of a figure, as a part of the stored one. The same program gives the same figures to some ten
/// instructions; this is for allocators and `memcpy` of other systems, and for changes too small to talk about.
const TOLERANCE: f64 = 0.02;
/// The same of a whole step, where another compiler made the baseline.
const FOREIGN_TOLERANCE: f64 = 0.15;
/// Kernels below this part of a step are not in the figures.
const LEAST_SHARE: f64 = 0.005;
/// How the figure of a whole step is called among those of kernels.
const STEP: &str = "step";

/// What runs: a name, arguments of `ishigaki run`, steps.
struct Scene(&'static str, &'static [&'static str], u32);

const SCENES: [Scene; 7] = [
    Scene("tower80", &["tower", "--param", "n=80"], 30),
    Scene("pyramid30", &["pyramid", "--param", "base=30"], 30),
    // As on a machine without AVX2.
    Scene("pyramid30 narrow", &["pyramid", "--param", "base=30", "--set", "solver.wide.narrow=true"], 10),
    Scene("pile200", &["pile", "--param", "n=200"], 90),
    Scene("ragdolls10", &["ragdolls", "--param", "n=10"], 60),
    Scene("joint_grid30", &["joint_grid", "--param", "n=30"], 10),
    // The reference, which solves it at once.
    Scene("chain20", &["chain", "--param", "swing=1"], 20),
];

/// What it does, and the end of its function's path; what that calls is counted with it. Smaller ones are inlined.
const KERNELS: [(&str, &str); 19] = [
    ("find pairs", "::World::find_pairs"),
    ("update contacts", "::World::update_contacts"),
    ("search for points", "::update::Search::find"),
    ("build islands", "::World::build_islands"),
    ("build rows", "::World::build_rows"),
    ("batches", "::batch::Batch::build"),
    ("colors", "::batch::Batch::color"),
    ("lanes of contacts", "::domain::Part::fill"),
    ("waves and blocks of joints", "::joints::Joints::arrange"),
    ("solve batches", "::World::solve_batches::{{closure}}"),
    ("warm start", "::batch::Batch::warm_start"),
    ("sweeps", "::batch::Batch::sweep"),
    ("rows and sweeps of joints", "::joint_part::visit_all"),
    ("rows and recovery of joints", "::batch::Batch::aim_joints"),
    ("residual", "::domain::Part::inspect"),
    ("level correction", "::World::correct_levels"),
    ("hand-down", "::hand_down::HandDown::solve"),
    ("joint trees: factors", "::joint_tree::JointTree::factor"),
    ("joint trees: solution", "::joint_tree::JointTree::solve"),
];

/// Instructions of a step, by scene, by kernel.
type Counts = BTreeMap<String, BTreeMap<String, u64>>;

/// Counts, then compares or stores.
pub fn run(bless: bool) -> Result<(), String> {
    if let Some(why) = missing() {
        return Err(format!("instructions cannot be counted: {why}"));
    }
    execute("release build", &mut cargo(None, &["build", "--release", "--quiet", "--bin", "ishigaki"]))?;
    let mut now = Baseline { compiler: compiler()?, counts: count_all()? };
    let file = root().join("xtask/counts.json");
    if bless {
        now.counts.values_mut().for_each(forget_small);
        return find_kernels(&now.counts).and_then(|()| now.write(&file));
    }
    let failures = compare(&Baseline::read(&file)?, &now);
    let advice = "if this is meant to be: cargo xtask counts --bless";
    if failures.is_empty() { Ok(()) } else { Err(format!("{}\n  {advice}", failures.join("\n  "))) }
}

fn forget_small(kernels: &mut BTreeMap<String, u64>) {
    let least = LEAST_SHARE * kernels[STEP] as f64;
    kernels.retain(|_, count| *count as f64 >= least);
}

/// A kernel that no scene has is a name in [`KERNELS`] that checks nothing.
fn find_kernels(counts: &Counts) -> Result<(), String> {
    let is_lost = |kernel: &str| !counts.values().any(|kernels| kernels.contains_key(kernel));
    let lost: Vec<_> = KERNELS.iter().filter(|(kernel, _)| is_lost(kernel)).map(|(_, path)| *path).collect();
    let remedy = "renamed or inlined? KERNELS in xtask/src/counts.rs names them";
    if lost.is_empty() { Ok(()) } else { Err(format!("no scene spends much in {}: {remedy}", lost.join(", "))) }
}

/// What instructions cannot be counted without, or `None`.
pub fn missing() -> Option<&'static str> {
    // What it answers with is no sign: the reader's status is 255.
    let answers =
        |program| Command::new(program).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok();
    if !has_avx2() {
        return Some("the baseline is of an x86-64 processor with AVX2; run it on one");
    }
    if answers("valgrind") && answers("callgrind_annotate") {
        None
    } else {
        Some("no valgrind: `apt-get install valgrind`")
    }
}

#[cfg(target_arch = "x86_64")]
fn has_avx2() -> bool {
    std::arch::is_x86_feature_detected!("avx2")
}

#[cfg(not(target_arch = "x86_64"))]
fn has_avx2() -> bool {
    false
}

fn compiler() -> Result<String, String> {
    let answer = Command::new("rustc").arg("--version").current_dir(root()).output();
    let answer = answer.map_err(|e| format!("rustc --version: {e}"))?;
    Ok(String::from_utf8_lossy(&answer.stdout).trim().to_string())
}

fn count_all() -> Result<Counts, String> {
    let folder = target_directory().join("counts");
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let program = target_directory().join("release/ishigaki");
    let mut counts = Counts::new();
    for Scene(name, arguments, steps) in SCENES {
        let length = steps.to_string();
        let arguments = [&["run"], arguments, &["--quiet", "--steps", &length]].concat();
        let profile = callgrind::run(&program, &arguments, &folder.join(name.replace(' ', "-")))?;
        let mut kernels = BTreeMap::from([(STEP.to_string(), profile.total / u64::from(steps))]);
        for (kernel, path) in KERNELS {
            kernels.insert(kernel.to_string(), profile.inclusive(path) / u64::from(steps));
        }
        counts.insert(name.to_string(), kernels);
    }
    Ok(counts)
}

/// Prints stored figures and today's side by side; gives those that changed too much.
fn compare(stored: &Baseline, now: &Baseline) -> Vec<String> {
    let foreign = stored.compiler != now.compiler;
    if foreign {
        println!("stored by {}, now {}: only whole steps are judged, with 15 %", stored.compiler, now.compiler);
    }
    println!("{:<18}{:<30}{:>12}{:>12}{:>10}", "scene", "instructions of a step", "stored", "now", "change");
    let mut failures = Vec::new();
    for (scene, kernels) in &now.counts {
        let Some(before) = stored.counts.get(scene) else {
            failures.push(format!("{scene}: nothing is stored"));
            continue;
        };
        for (kernel, before) in before {
            let after = kernels.get(kernel).copied().unwrap_or(0);
            let change = after as f64 / *before as f64 - 1.0;
            let percent = format!("{:+.2} %", 100.0 * change);
            println!("{scene:<18}{kernel:<30}{before:>12}{after:>12}{percent:>10}");
            let tolerance = if foreign { FOREIGN_TOLERANCE } else { TOLERANCE };
            // Written so that no number fails too.
            let holds = change.abs() <= tolerance || (foreign && kernel != STEP);
            if !holds {
                failures.push(format!("{scene}, {kernel}: {after} instructions, stored {before}, {percent}"));
            }
        }
    }
    failures
}

#[cfg(test)]
mod tests {
    use super::*;

    fn baseline(compiler: &str, step: u64, solve: u64) -> Baseline {
        let kernels = BTreeMap::from([(STEP.to_string(), step), ("solve".to_string(), solve)]);
        Baseline { compiler: compiler.into(), counts: Counts::from([("wall".into(), kernels)]) }
    }

    #[test]
    fn a_figure_beyond_its_tolerance_is_named() {
        let stored = baseline("a", 1000, 100);
        assert!(compare(&stored, &baseline("a", 1019, 99)).is_empty());
        assert_eq!(compare(&stored, &baseline("a", 1000, 103)), ["wall, solve: 103 instructions, stored 100, +3.00 %"]);
        assert_eq!(compare(&stored, &baseline("a", 970, 100)).len(), 1);
    }

    #[test]
    fn another_compiler_may_inline_but_not_double_a_step() {
        let stored = baseline("a", 1000, 100);
        assert!(compare(&stored, &baseline("b", 1100, 0)).is_empty());
        assert_eq!(compare(&stored, &baseline("b", 2000, 100)).len(), 1);
    }

    #[test]
    fn a_scene_without_stored_figures_fails() {
        let stored = Baseline { compiler: "a".into(), counts: Counts::new() };
        assert_eq!(compare(&stored, &baseline("a", 1, 1)), ["wall: nothing is stored"]);
    }
}
