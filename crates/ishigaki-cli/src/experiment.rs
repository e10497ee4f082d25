//! `ishigaki experiment`: the claims of the talk, put to the test.

use crate::failure::{At, Failure};
use crate::output::{self, AtomicFile};
use crate::progress::now;
use clap::Args;
use ishigaki_experiments::{Effort, Experiment, Output, Verdict, find, index, list, markdown};
use serde_json::json;
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

#[derive(Args)]
pub struct RunExperiment {
    /// An experiment, or `all`; without it, the experiments are listed.
    name: Option<String>,
    /// The folder for plots (SVG, PNG), data (CSV), verdicts (Markdown) and, with `all`, index.html; made if need be.
    #[arg(long, value_name = "DIR", requires = "name")]
    out: Option<PathBuf>,
    /// A short version of each: less data, weaker figures.
    #[arg(long, requires = "name")]
    quick: bool,
    /// The verdicts (or the list) as JSON.
    #[arg(long)]
    json: bool,
    /// No progress on stderr; errors stay.
    #[arg(long)]
    quiet: bool,
}

impl RunExperiment {
    pub fn execute(&self) -> Result<(), Failure> {
        let Some(name) = &self.name else {
            return output::print(&if self.json { list_as_json() } else { list_as_text() });
        };
        let chosen = chosen(name)?;
        let Some(folder) = &self.out else {
            return Err(Failure::input("--out DIR is missing: where shall plots and data go?"));
        };
        std::fs::create_dir_all(folder).input_at(folder.display())?;
        let mut verdicts: Vec<(&Experiment, Verdict)> = Vec::new();
        for (i, experiment) in chosen.iter().enumerate() {
            let done = self.perform(experiment, i, chosen.len())?;
            write_files(folder, experiment, &done)?;
            if !self.json {
                output::print(&as_text(experiment, &done.verdict))?;
            }
            verdicts.push((experiment, done.verdict));
        }
        if name == "all" {
            let results: Vec<(&Experiment, &Verdict)> = verdicts.iter().map(|(e, v)| (*e, v)).collect();
            write(folder, "index.html", index::page(&results).as_bytes())?;
        }
        if self.json {
            let results: Vec<_> = verdicts.iter().map(|(e, v)| as_json(e, v)).collect();
            output::print(&format!("{:#}", json!(results)))?;
        }
        Ok(())
    }

    fn perform(&self, experiment: &Experiment, index: usize, count: usize) -> Result<Output, Failure> {
        let mut progress = Voice::new(self.quiet, format!("[{}/{count}] {}", index + 1, experiment.name));
        let effort = if self.quick { Effort::Quick } else { Effort::Full };
        let done = experiment.perform(effort, &mut |part, what| progress.say(part, what));
        progress.finish();
        done.other_at(experiment.name)
    }
}

/// One experiment or all; the message of an unknown name says what there is.
fn chosen(name: &str) -> Result<Vec<&'static Experiment>, Failure> {
    if name == "all" {
        return Ok(list().to_vec());
    }
    find(name).map(|experiment| vec![experiment]).ok_or_else(|| {
        let names: Vec<&str> = list().iter().map(|e| e.name).collect();
        Failure::input(format!("there is no experiment `{name}`; there are `all`, {}", names.join(", ")))
    })
}

fn write_files(folder: &Path, experiment: &Experiment, done: &Output) -> Result<(), Failure> {
    let name = experiment.name;
    write(folder, &format!("{name}.svg"), done.svg.as_bytes())?;
    write(folder, &format!("{name}.png"), &done.png)?;
    write(folder, &format!("{name}.csv"), done.csv.as_bytes())?;
    write(folder, &format!("{name}.md"), markdown::verdict(&done.verdict).as_bytes())
}

fn write(folder: &Path, name: &str, bytes: &[u8]) -> Result<(), Failure> {
    let mut file = AtomicFile::create(&folder.join(name))?;
    file.write_all(bytes).other_at(file.path().display())?;
    file.commit()
}

fn as_text(experiment: &Experiment, verdict: &Verdict) -> String {
    format!("{}: {verdict}", experiment.name)
}

fn as_json(experiment: &Experiment, verdict: &Verdict) -> serde_json::Value {
    json!({ "name": experiment.name, "rows": experiment.rows, "title": experiment.title, "talk": verdict.talk,
            "predicted": verdict.predicted(), "measured": verdict.measured(), "agrees": verdict.agrees(),
            "figures": verdict.figures, "note": verdict.note })
}

fn list_as_json() -> String {
    let entry = |e: &&Experiment| json!({ "name": e.name, "rows": e.rows, "title": e.title });
    format!("{:#}", list().iter().map(entry).collect::<serde_json::Value>())
}

fn list_as_text() -> String {
    let width = list().iter().map(|e| e.name.len()).max().unwrap_or(0);
    let line = |e: &&Experiment| format!("{:width$}  {:8}  {}", e.name, e.rows.join(" "), e.title);
    list().iter().map(line).collect::<Vec<_>>().join("\n")
}

/// Says how far an experiment is: one line that is written over on a terminal, a line now and then elsewhere.
struct Voice {
    quiet: bool,
    terminal: bool,
    label: String,
    start: Instant,
    last: Option<Instant>,
}

impl Voice {
    fn new(quiet: bool, label: String) -> Self {
        let voice = Self { quiet, terminal: std::io::stderr().is_terminal(), label, start: now(), last: None };
        if !voice.quiet && !voice.terminal {
            eprintln!("{} …", voice.label);
        }
        voice
    }

    fn say(&mut self, part: f64, what: &str) {
        let pause = if self.terminal { Duration::from_millis(100) } else { Duration::from_secs(5) };
        let since = self.last.unwrap_or(self.start).elapsed();
        if self.quiet || (since < pause && (self.last.is_some() || !self.terminal)) {
            return;
        }
        self.last = Some(now());
        let line = format!("{}: {:.0} %, {what}", self.label, 100.0 * part.clamp(0.0, 1.0));
        if self.terminal {
            eprint!("\r\x1b[2K{line}");
        } else {
            eprintln!("{line}");
        }
    }

    fn finish(&self) {
        if self.quiet {
            return;
        }
        let seconds = self.start.elapsed().as_secs_f64();
        let clear = if self.terminal { "\r\x1b[2K" } else { "" };
        eprintln!("{clear}{}: {seconds:.1} s", self.label);
    }
}
