//! What is said on stderr while the bench runs.

use std::io::{self, IsTerminal};

/// Who listens: nobody, a file, or people who watch.
#[derive(Clone, Copy)]
pub struct Progress {
    quiet: bool,
    /// A line that is written over again and again is for people who watch, not for files.
    watched: bool,
}

impl Progress {
    pub fn new(quiet: bool) -> Self {
        Self { quiet, watched: !quiet && io::stderr().is_terminal() }
    }

    /// A line that stays.
    pub fn say(self, text: &str) {
        if !self.quiet {
            eprintln!("{text}");
        }
    }

    /// A line in a file; who watches is told by [`Self::tell`].
    pub fn log(self, text: &str) {
        if !self.watched {
            self.say(text);
        }
    }

    /// Writes over what was told before.
    pub fn tell(self, text: &str) {
        if self.watched {
            eprint!("\r\x1b[K{text}");
        }
    }
}
