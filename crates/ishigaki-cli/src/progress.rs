//! Says how far a run is: a bar on a terminal, a line every few seconds elsewhere, nothing when quiet.

use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// Between two lines, where stderr is no terminal.
const PAUSE: Duration = Duration::from_secs(5);

/// The clock of this program. The engine reads none: it is handed this one.
#[expect(clippy::disallowed_methods, reason = "the ban is the engine's; a front end measures time")]
pub fn now() -> Instant {
    Instant::now()
}

pub enum Progress {
    Quiet,
    Bar(ProgressBar),
    Lines { start: Instant, last: Instant },
}

impl Progress {
    pub fn new(steps: u64, quiet: bool) -> Self {
        if quiet {
            Self::Quiet
        } else if std::io::stderr().is_terminal() {
            let style = ProgressStyle::with_template("{wide_bar} step {pos}/{len}, {per_sec}, {eta} left");
            Self::Bar(ProgressBar::new(steps).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar())))
        } else {
            Self::Lines { start: now(), last: now() }
        }
    }

    pub fn update(&mut self, done: u64, of: u64) {
        match self {
            Self::Quiet => {}
            Self::Bar(bar) => bar.set_position(done),
            Self::Lines { start, last } => {
                if last.elapsed() >= PAUSE {
                    *last = now();
                    eprintln!("step {done} of {of} after {:.0} s", start.elapsed().as_secs_f64());
                }
            }
        }
    }

    pub fn finish(&self) {
        if let Self::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}
