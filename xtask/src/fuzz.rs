//! `cargo xtask fuzz`: the seeded mutation runner, built with debug assertions.

use crate::run::{execute, program, root};
use std::process::Command;

pub fn run(arguments: &[String]) -> Result<(), String> {
    let mut command = Command::new(program("ishigaki-fuzz", "runner")?);
    execute("fuzz", command.args(arguments).current_dir(root()))
}
