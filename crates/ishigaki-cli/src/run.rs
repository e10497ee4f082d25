//! `ishigaki run`: steps a scene and says what happened.

use crate::failure::{At, Failure, INTERRUPTED};
use crate::lcp_file::LcpExport;
use crate::number;
use crate::output::{self, AtomicFile};
use crate::progress::{Progress, now};
use crate::recordings::{Films, Recordings};
use crate::source::{self, Source};
use crate::states::StateTable;
use crate::summary::Record;
use clap::Args;
use ishigaki::{StepContext, World};

use ishigaki_scenes::file::CameraFile;
use ishigaki_scenes::models::ImportOptions;
use ishigaki_scenes::set_option;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// Length of a step where no scene suggests one, s.
const DEFAULT_DT: f32 = 1.0 / 60.0;
/// Steps where no scene suggests a number.
const DEFAULT_STEPS: u64 = 600;

#[derive(Args)]
pub struct Run {
    /// A named scene (see `ishigaki scenes`), a scene file (.json, or - for stdin), or a model (.xml, .urdf).
    #[arg(required_unless_present = "from")]
    scene: Option<String>,
    /// How many steps; default: as the scene suggests.
    #[arg(long, value_name = "N", value_parser = number::steps, allow_hyphen_values = true)]
    steps: Option<u64>,
    /// Length of a step in seconds; default: as the scene suggests.
    #[arg(long, value_name = "S", value_parser = number::time_step, allow_hyphen_values = true)]
    dt: Option<f32>,
    /// An option of the engine by its path, such as solver.weight_amplification.factor=1.4.
    #[arg(long = "set", value_name = "PATH=VALUE", value_parser = number::assignment)]
    options: Vec<(String, String)>,
    /// A parameter of a named scene, such as n=40.
    #[arg(long = "param", value_name = "KEY=NUMBER", value_parser = number::parameter)]
    parameters: Vec<(String, f64)>,
    /// Threads that a step may use; the result does not depend on it.
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u16).range(1..=256))]
    threads: u16,
    /// Write poses and velocities of all bodies as comma-separated values.
    #[arg(long, value_name = "FILE.csv")]
    states: Option<PathBuf>,
    /// With --states: only every Kth step.
    #[arg(long, value_name = "K", default_value = "1", value_parser = number::steps, requires = "states",
          allow_hyphen_values = true)]
    every: u64,
    #[command(flatten)]
    recordings: Recordings,
    /// Write a snapshot of the world after the last step.
    #[arg(long, value_name = "FILE.snap")]
    snapshot: Option<PathBuf>,
    /// Write the box LCP of a step, before it is taken, as a file for `ishigaki lcp`.
    #[arg(long, value_name = "STEP:FILE.json", value_parser = number::step_and_file, allow_hyphen_values = true)]
    export_lcp: Option<(u64, PathBuf)>,
    /// Continue from a snapshot, bit for bit; with SCENE, check that it is one of that scene.
    #[arg(long, value_name = "FILE.snap")]
    from: Option<PathBuf>,
    /// Write the result as one JSON object to stdout.
    #[arg(long)]
    json: bool,
    /// No progress and no warnings on stderr; errors stay.
    #[arg(long)]
    quiet: bool,
    /// Put a floor under an imported model.
    #[arg(long)]
    ground: bool,
    /// Fix the root link of an imported URDF model to the world.
    #[arg(long)]
    fixed_base: bool,
}

/// A world that is ready, and how to run it.
struct Job {
    world: World,
    name: String,
    steps: u64,
    dt: f32,
    warnings: Vec<String>,
    /// Where the scene would like to be looked at from.
    camera: Option<CameraFile>,
}

impl Run {
    pub fn execute(&self) -> Result<(), Failure> {
        self.check_outputs()?;
        let mut job = self.prepare()?;
        if !self.quiet {
            job.warnings.iter().for_each(|warning| eprintln!("warning: {warning}"));
        }
        job.world.set_threads(usize::from(self.threads)).input_at("--threads")?;
        let mut states = self.states.as_deref().map(|path| StateTable::create(path, self.every)).transpose()?;
        let snapshot = self.snapshot.as_deref().map(AtomicFile::create).transpose()?;

        let export = self.export_lcp.as_ref();
        let mut export = export.map(|(step, path)| LcpExport::create(*step, path, job.steps)).transpose()?;
        let mut films = self.recordings.start(&job.world, &job.name, job.dt, job.camera)?;

        let record = self.advance(&mut job, states.as_mut(), &mut films, export.as_mut())?;

        if let Some(states) = states {
            states.commit()?;
        }
        if let Some(mut file) = snapshot {
            file.write_all(&job.world.snapshot()).other_at(file.path().display())?;
            file.commit()?;
        }
        films.commit(&job.world)?;
        let summary = record.summarize(job.name, job.steps, job.dt, job.warnings, &job.world);
        output::print(&if self.json { summary.json() } else { summary.text() })?;
        if summary.non_finite.is_empty() {
            Ok(())
        } else {
            Err(Failure::other(format!("not finite after the run: {}", summary.non_finite.join(", "))))
        }
    }

    /// Two results in one file would leave only the later.
    fn check_outputs(&self) -> Result<(), Failure> {
        let exported = self.export_lcp.as_ref().map(|(_, path)| path.clone());
        let outputs = [
            ("--states", &self.states),
            ("--snapshot", &self.snapshot),
            ("--record", &self.recordings.record),
            ("--html", &self.recordings.html),
            ("--export-lcp", &exported),
        ];
        for (i, (name, path)) in outputs.iter().enumerate() {
            let same = outputs[i + 1..].iter().find(|(_, other)| path.is_some() && path == other);
            if let Some((other, _)) = same {
                return Err(Failure::input(format!("{name} and {other} name the same file; give each its own")));
            }
        }
        Ok(())
    }

    fn prepare(&self) -> Result<Job, Failure> {
        let import = ImportOptions { ground: self.ground, fixed_base: self.fixed_base };
        let load = |what: &String| source::load(what, &self.parameters, import);
        let mut source = self.scene.as_ref().map(load).transpose()?;
        if let Some(source) = &mut source {
            for (path, value) in &self.options {
                set_option(&mut source.scene.options, path, value).map_err(|e| Failure::input(format!("--set {e}")))?;
            }
        }
        match (source, &self.from) {
            (Some(source), None) => self.job_of_scene(source),
            (source, Some(path)) => self.job_of_snapshot(source, path),
            (None, None) => Err(Failure::input("nothing to run: name a scene or give --from")),
        }
    }

    fn job_of_scene(&self, source: Source) -> Result<Job, Failure> {
        let Source { scene, origin, warnings } = source;
        let camera = scene.camera;
        let built = scene.build().input_at(&origin)?;
        let steps = self.steps.unwrap_or(u64::from(built.steps).max(1));
        Ok(Job { world: built.world, name: origin, steps, dt: self.dt.unwrap_or(built.dt), warnings, camera })
    }

    fn job_of_snapshot(&self, source: Option<Source>, path: &Path) -> Result<Job, Failure> {
        let shown = path.display();
        let bytes = std::fs::read(path).input_at(&shown)?;
        let mut world = World::restore(&bytes).input_at(&shown)?;
        if !self.options.is_empty() {
            let mut options = world.options().clone();
            for (path, value) in &self.options {
                set_option(&mut options, path, value).map_err(|e| Failure::input(format!("--set {e}")))?;
            }
            world.set_options(options).input_at("--set")?;
        }
        let Some(source) = source else {
            if !self.parameters.is_empty() || self.ground || self.fixed_base {
                let message = "--param, --ground and --fixed-base belong to a scene, and --from alone names none";
                return Err(Failure::input(message));
            }
            let (steps, dt) = (self.steps.unwrap_or(DEFAULT_STEPS), self.dt.unwrap_or(DEFAULT_DT));
            return Ok(Job { world, name: shown.to_string(), steps, dt, warnings: Vec::new(), camera: None });
        };
        let job = self.job_of_scene(source)?;
        if !world.bodies().map(|(_, b)| b.name()).eq(job.world.bodies().map(|(_, b)| b.name())) {
            return Err(Failure::input(format!(
                "{shown}: is no snapshot of {}: its bodies are others; leave the scene out to run the snapshot alone",
                job.name
            )));
        }
        Ok(Job { world, ..job })
    }

    /// Takes the steps.
    fn advance(
        &self,
        job: &mut Job,
        mut states: Option<&mut StateTable>,
        films: &mut Films,
        mut export: Option<&mut LcpExport>,
    ) -> Result<Record, Failure> {
        let interrupted = interrupt_flag()?;
        let mut record = Record::new();
        let mut progress = Progress::new(job.steps, self.quiet);
        let start = now();
        let mut clock = || start.elapsed().as_secs_f64();
        if let Some(states) = &mut states {
            states.record(0, &job.world)?;
        }
        for done in 1..=job.steps {
            if let Some(export) = &mut export {
                export.before(done, &job.world, job.dt)?;
            }
            let begin = start.elapsed();
            let report =
                job.world.step_with(job.dt, &mut StepContext { clock: Some(&mut clock), ..Default::default() });
            let seconds = (start.elapsed() - begin).as_secs_f64();
            if let Some(why) = report.rejected {
                return Err(Failure::input(format!("step {done}: {why}")));
            }
            record.add(seconds, report);
            if let Some(states) = &mut states {
                states.record(done, &job.world)?;
            }
            films.step(&job.world)?;
            progress.update(done, job.steps);
            if interrupted.load(Ordering::Relaxed) {
                return Err(Failure { code: INTERRUPTED, ..Failure::other(format!("interrupted after step {done}")) });
            }
        }
        progress.finish();
        Ok(record)
    }
}

/// Turns true on Ctrl-C, so that temporary files are removed; a second Ctrl-C ends at once.
fn interrupt_flag() -> Result<&'static AtomicBool, Failure> {
    static FLAG: AtomicBool = AtomicBool::new(false);
    ctrlc::set_handler(|| {
        if FLAG.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(INTERRUPTED));
        }
    })
    .other_at("cannot listen for Ctrl-C")?;
    Ok(&FLAG)
}
