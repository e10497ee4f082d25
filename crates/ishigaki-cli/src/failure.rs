//! What ends the program early, and with which exit code.

use std::fmt::Display;

/// A message and the exit code that goes with it.
#[derive(Debug)]
pub struct Failure {
    pub code: u8,
    pub error: anyhow::Error,
}

/// The input is wrong: its writer can mend it.
pub const BAD_INPUT: u8 = 2;
/// The input is right, something else is wrong.
pub const OTHER: u8 = 1;
/// Ctrl-C, by the convention of shells.
pub const INTERRUPTED: u8 = 130;

impl Failure {
    pub fn input(message: impl Display) -> Self {
        Self { code: BAD_INPUT, error: anyhow::anyhow!("{message}") }
    }

    pub fn other(message: impl Display) -> Self {
        Self { code: OTHER, error: anyhow::anyhow!("{message}") }
    }
}

/// The place of an error, in front of its message.
pub trait At<T> {
    /// Exit code 2.
    fn input_at(self, place: impl Display) -> Result<T, Failure>;
    /// Exit code 1.
    fn other_at(self, place: impl Display) -> Result<T, Failure>;
}

impl<T, E: Display> At<T> for Result<T, E> {
    fn input_at(self, place: impl Display) -> Result<T, Failure> {
        self.map_err(|e| Failure::input(format!("{place}: {e}")))
    }

    fn other_at(self, place: impl Display) -> Result<T, Failure> {
        self.map_err(|e| Failure::other(format!("{place}: {e}")))
    }
}
