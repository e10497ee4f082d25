//! Ishigaki and its peers side by side: the same scenes, one meter, turn by turn. See README.md.

mod convert;
mod engine;
mod lockstep;
mod memory;
mod meter;
mod plot;
mod progress;
mod report;
mod scaling;
mod scene;
mod scenes;
mod solid;
mod stats;

use anyhow::{Context, Result, bail, ensure};
use clap::Parser;
use engine::{DT, KINDS, Kind, Setup};
use ishigaki::WorldOptions;
use lockstep::{Course, Looks};
use progress::Progress;
use report::Row;
use scenes::Entry;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Ishigaki and its peers side by side: the same scenes, one meter, turn by turn.
#[derive(Parser, Debug)]
#[command(version)]
struct Arguments {
    /// Scenes of the table, scenes of Ishigaki's with parameters (pyramid:base=40), or scene files (x.json).
    #[arg(long, value_delimiter = ',', value_name = "A,B,…")]
    scenes: Vec<String>,
    /// Engines; all that were built by default.
    #[arg(long, value_delimiter = ',', value_name = "A,B,…")]
    engines: Vec<String>,
    /// Steps of 1/60 s; each scene has its own number otherwise.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    steps: Option<u32>,
    /// Steps in a turn.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    turn: u32,
    /// Threads, for engines that use them: 1, or 1 and 2 with --scaling, which takes several numbers.
    #[arg(long, value_delimiter = ',', value_name = "N", value_parser = clap::value_parser!(u32).range(1..=32))]
    threads: Vec<u32>,
    /// Let bodies fall asleep.
    #[arg(long)]
    sleep: bool,
    /// Time only what comes after so many seconds of the scene.
    #[arg(long, default_value_t = 0.0, value_name = "SECONDS")]
    rest_after: f64,
    /// An engine that has stepped longer than this in a scene stops there, with a note: 60, with --scaling 300.
    #[arg(long, value_name = "SECONDS")]
    limit: Option<f64>,
    /// Set an option of Ishigaki's by its path: solver.substeps=2.
    #[arg(long, value_name = "PATH=VALUE")]
    set: Vec<String>,
    /// Time the stages of Ishigaki's step.
    #[arg(long)]
    phases: bool,
    /// Cost of a body in series of growing scenes, instead of the table.
    #[arg(long, conflicts_with_all = ["scenes", "rest_after"])]
    scaling: bool,
    /// Series to measure; all by default.
    #[arg(long, value_delimiter = ',', value_name = "A,B,…", requires = "scaling")]
    series: Vec<String>,
    /// Bodies in a world, for series in which these grow: 1000,3000,10000,30000,100000.
    #[arg(long, value_delimiter = ',', value_name = "N,M,…", requires = "scaling",
          value_parser = clap::value_parser!(u32).range(100..=i64::from(scenes::MOST)))]
    sizes: Vec<u32>,
    /// Leave out worlds with more bodies.
    #[arg(long, default_value_t = 100_000, value_name = "N",
          value_parser = clap::value_parser!(u32).range(100..=i64::from(scenes::MOST)))]
    max_bodies: u32,
    /// Do not measure memory: saves two processes for each engine and scene.
    #[arg(long)]
    no_memory: bool,
    /// One JSON array on stdout instead of the table.
    #[arg(long)]
    json: bool,
    /// Write the rows to a file.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Draw the ratios.
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
    /// No progress on stderr.
    #[arg(long)]
    quiet: bool,
    /// What scenes and engines there are, with versions and compiler flags.
    #[arg(long)]
    list: bool,
    /// For the bench itself: print the peak memory of one engine in one scene (full) or without bodies (empty).
    #[arg(long, hide = true)]
    memory_child: Option<String>,
}

/// Of stepping, for an engine and a scene of the table, s.
const LIMIT: f64 = 60.0;

/// Arguments that make sense.
struct Plan {
    entries: Vec<Entry>,
    kinds: Vec<Kind>,
    setup: Setup,
    scaling: Option<scaling::Plan>,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let plan = match plan(&arguments) {
        Ok(plan) => plan,
        Err(error) => {
            eprintln!("error: {error:#}");
            return ExitCode::from(2);
        }
    };
    match perform(&arguments, &plan) {
        Ok(()) => ExitCode::SUCCESS,
        // Whoever reads has had enough: `--list | head`.
        Err(error) if error.downcast_ref::<io::Error>().is_some_and(|e| e.kind() == io::ErrorKind::BrokenPipe) => {
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn plan(arguments: &Arguments) -> Result<Plan> {
    let entries = match arguments.scenes.is_empty() {
        true if arguments.scaling => Vec::new(),
        true => scenes::list(),
        false => arguments.scenes.iter().map(|name| scenes::find(name)).collect::<Result<_>>()?,
    };
    for entry in &entries {
        entry.build()?;
    }
    let kinds = kinds(arguments)?;
    ensure!(arguments.rest_after >= 0.0, "--rest-after must be ≥ 0, is {}", arguments.rest_after);
    ensure!(
        arguments.limit.is_none_or(|limit| limit > 0.0),
        "--limit must be > 0, is {}",
        arguments.limit.unwrap_or(0.0)
    );
    let threads = &arguments.threads;
    ensure!(arguments.scaling || threads.len() < 2, "--threads takes several numbers only with --scaling");
    for (i, number) in threads.iter().enumerate() {
        ensure!(!threads[..i].contains(number), "--threads {number} is given twice");
    }
    let mut options = WorldOptions::default();
    for text in &arguments.set {
        let (path, value) = text.split_once('=').with_context(|| format!("--set {text}: must be PATH=VALUE"))?;
        ishigaki_scenes::set_option(&mut options, path, value).with_context(|| format!("--set {text}"))?;
    }
    let setup = Setup {
        threads: threads.first().copied().unwrap_or(1),
        sleep: arguments.sleep,
        phases: arguments.phases,
        ishigaki: options,
    };
    let scaling = match arguments.scaling {
        true => Some(scaling::Plan::new(arguments, &kinds, &setup)?),
        false => None,
    };
    Ok(Plan { entries, kinds, setup, scaling })
}

fn kinds(arguments: &Arguments) -> Result<Vec<Kind>> {
    let mut kinds = Vec::new();
    for name in &arguments.engines {
        let Some(kind) = KINDS.iter().find(|k| k.name == name) else {
            let known: Vec<&str> = KINDS.iter().map(|k| k.name).collect();
            bail!("there is no engine `{name}` in this build; there are {}", known.join(", "));
        };
        ensure!(!kinds.iter().any(|k: &Kind| k.name == name), "engine `{name}` is given twice");
        kinds.push(*kind);
    }
    Ok(if kinds.is_empty() { KINDS.to_vec() } else { kinds })
}

fn perform(arguments: &Arguments, plan: &Plan) -> Result<()> {
    if arguments.list {
        return print_list();
    }
    if let Some(world) = &arguments.memory_child {
        return memory_child(arguments, plan, world == "empty");
    }
    for kind in &plan.kinds {
        Progress::new(arguments.quiet).say(&format!("{:<9} {}", kind.name, (kind.about)()));
    }
    if let Some(plan) = &plan.scaling {
        return scaling::perform(arguments, plan);
    }
    if !arguments.json {
        say(&report::table_head())?;
    }
    let mut rows = Vec::new();
    for entry in &plan.entries {
        let new = run_scene(arguments, plan, entry)?;
        if !arguments.json {
            for row in &new {
                say(&report::table_line(row))?;
            }
        }
        rows.extend(new);
    }
    if arguments.json {
        say(&serde_json::to_string_pretty(&rows)?)?;
    }
    if let Some(path) = &arguments.csv {
        write(path, &report::csv(&rows))?;
    }
    if let Some(path) = &arguments.plot {
        write(path, &plot::draw(&rows))?;
    }
    Ok(())
}

fn run_scene(arguments: &Arguments, plan: &Plan, entry: &Entry) -> Result<Vec<Row>> {
    let scene = entry.build()?;
    let warm_up = (arguments.rest_after / f64::from(DT)).round() as u32;
    let course = Course {
        // What is asked for is what counts.
        steps: arguments.steps.unwrap_or(entry.steps) + warm_up,
        turn: arguments.turn,
        warm_up,
        limit: arguments.limit.unwrap_or(LIMIT),
        looks: Looks::Always,
    };
    let progress = Progress::new(arguments.quiet);
    let (bodies, joints) = (scene.bodies.len(), scene.joints.len());
    progress.log(&format!("{}: {bodies} bodies, {joints} joints, {} steps", entry.name, course.steps));
    let players = lockstep::players(&plan.kinds, &[plan.setup.threads]);
    let mut done = |steps: u32| progress.tell(&format!("{}: step {steps} of {}", entry.name, course.steps));
    let runs = lockstep::run(&scene, &players, &plan.setup, &course, &mut done);
    progress.tell("");
    let runs = runs.with_context(|| format!("scene `{}`", entry.name))?;
    let memory = |engine: &str| {
        if arguments.no_memory {
            return None;
        }
        progress.tell(&format!("{}: memory of {engine}", entry.name));
        let Setup { threads, sleep, .. } = plan.setup;
        let child = memory::Child { scene: &entry.name, threads, sleep, set: &arguments.set, steps: course.steps };
        let peak = memory::measure(&child.arguments(course.limit.min(10.0)), engine);
        progress.tell("");
        peak
    };
    Ok(report::rows(entry, &runs, memory))
}

fn memory_child(arguments: &Arguments, plan: &Plan, empty: bool) -> Result<()> {
    let (Some(entry), Some(kind)) = (plan.entries.first(), plan.kinds.first()) else {
        bail!("one scene and one engine");
    };
    let steps = arguments.steps.unwrap_or(entry.steps);
    let threads = if kind.threaded { plan.setup.threads } else { 1 };
    let setup = Setup { threads, ..plan.setup.clone() };
    memory::child(&entry.build()?, kind, &setup, empty, steps, arguments.limit.unwrap_or(LIMIT))
}

fn print_list() -> Result<()> {
    say("engines:")?;
    for kind in KINDS {
        say(&format!("  {:<9} {}", kind.name, (kind.about)()))?;
    }
    say("scenes:")?;
    for entry in scenes::list() {
        say(&format!("  {:<18} {} steps", entry.name, entry.steps))?;
    }
    say("series of --scaling:")?;
    for series in scaling::SERIES {
        say(&format!("  {:<18} {}", series.name, series.about))?;
    }
    Ok(())
}

/// A line on stdout, which may be a pipe that is closed.
fn say(line: &str) -> Result<()> {
    Ok(writeln!(io::stdout(), "{line}")?)
}

/// Writes a file that appears only when it is complete.
fn write(path: &Path, text: &str) -> Result<()> {
    let mut part = path.as_os_str().to_owned();
    part.push(".part");
    let place = || path.display().to_string();
    std::fs::write(&part, text).with_context(place)?;
    std::fs::rename(&part, path).with_context(place)
}
