//! The command line of Ishigaki: runs scenes and says what happened.
//!
//! Results go to stdout or to files, everything else to stderr. Exit code 2: the input is wrong and the message
//! says where; 1: anything else went wrong (a disk, a body that is no longer finite); 130: interrupted.

mod experiment;
mod failure;
mod lcp;
mod lcp_file;
mod number;
mod options;
mod output;
mod page;
mod picture;
mod progress;
mod recordings;
mod run;
mod samples;
mod scenes;
mod source;
mod states;
mod summary;
mod view;

use clap::{Parser, Subcommand};
use failure::Failure;
use std::process::ExitCode;

#[derive(Parser)]
#[command(name = "ishigaki", version, about = "A rigid-body physics engine that holds", max_term_width = 110)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run a scene and report times, contacts, errors and energies.
    Run(run::Run),
    /// Draw a frame of a recording as PNG.
    Picture(picture::Picture),
    /// Show a recording in a browser; without one, the engine live in the page.
    View(view::View),
    /// Put the claims of the talk to the test: plots, data and verdicts.
    Experiment(experiment::RunExperiment),
    /// Solve a box LCP, such as `run --export-lcp` writes, with a method of the laboratory.
    Lcp(lcp::Lcp),
    /// List the named scenes, or write one as a scene file.
    Scenes(scenes::Scenes),
    /// List every option of the engine with its default, as `run --set` takes it.
    Options,
}

fn main() -> ExitCode {
    let done = match Arguments::parse().command {
        Command::Run(run) => run.execute(),
        Command::Picture(picture) => picture.execute(),
        Command::View(view) => view.execute(),
        Command::Experiment(experiment) => experiment.execute(),
        Command::Lcp(lcp) => lcp.execute(),
        Command::Scenes(scenes) => scenes.execute(),
        Command::Options => options::execute(),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure { code, error }) => {
            eprintln!("error: {error:#}");
            ExitCode::from(code)
        }
    }
}
