//! Memory of an engine in a scene: the peak of a process of its own, less that of one with an empty world.

use crate::engine::{Kind, Setup};
use crate::scene::Scene;
use anyhow::{Context, Result, bail};
use std::process::{Command, Stdio};
use std::time::Instant;

/// Peak resident memory of this process so far, MiB; `None` where the system does not say.
fn peak_mib() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib / 1024.0)
}

/// What the child does: steps a world of one engine, alone and unmeasured, and prints its peak.
///
/// The scene is described in the child with the empty world, too, so that the difference is the engine's alone.
///
/// # Errors
/// A scene that the engine cannot build, a system that does not say what a process uses.
pub fn child(scene: &Scene, kind: &Kind, setup: &Setup, empty: bool, steps: u32, limit: f64) -> Result<()> {
    let nothing = Scene { gravity: scene.gravity, ..Scene::default() };
    let mut engine = (kind.build)(if empty { &nothing } else { scene }, setup)?;
    let clock = Instant::now();
    for _ in 0..steps {
        engine.step(1);
        if clock.elapsed().as_secs_f64() > limit {
            break;
        }
    }
    let Some(peak) = peak_mib() else { bail!("this system does not say how much memory a process used") };
    println!("{peak}");
    Ok(())
}

/// What a child is to do.
pub struct Child<'a> {
    /// As `--scenes` takes it.
    pub scene: &'a str,
    /// Threads, for an engine that uses them.
    pub threads: u32,
    /// Whether bodies may fall asleep.
    pub sleep: bool,
    /// Options of Ishigaki's.
    pub set: &'a [String],
    /// Steps.
    pub steps: u32,
}

impl Child<'_> {
    /// What makes a child describe the same scene and step it as long, though never longer than `limit` seconds.
    pub fn arguments(&self, limit: f64) -> Vec<String> {
        let mut list = vec!["--scenes".to_string(), self.scene.to_string(), "--quiet".to_string()];
        list.extend(["--steps".to_string(), self.steps.to_string(), "--limit".to_string(), limit.to_string()]);
        list.extend(["--threads".to_string(), self.threads.to_string()]);
        list.extend(self.set.iter().flat_map(|set| ["--set".to_string(), set.clone()]));
        if self.sleep {
            list.push("--sleep".to_string());
        }
        list
    }
}

/// MiB of an engine in a scene; `None` if a child fails.
///
/// `arguments` make the child describe the same scene; it is told by two more what to do.
pub fn measure(arguments: &[String], engine: &str) -> Option<f64> {
    let full = peak_of_child(arguments, engine, "full").ok()?;
    let empty = peak_of_child(arguments, engine, "empty").ok()?;
    Some(full - empty)
}

fn peak_of_child(arguments: &[String], engine: &str, world: &str) -> Result<f64> {
    let mut child = Command::new(std::env::current_exe()?);
    child.args(arguments).args(["--engines", engine, "--memory-child", world]).stderr(Stdio::null());
    let output = child.output()?;
    let text = String::from_utf8_lossy(&output.stdout);
    text.trim().parse().context("the child says no number")
}
