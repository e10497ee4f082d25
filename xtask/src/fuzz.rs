//! `cargo xtask fuzz`: the seeded mutation runner, built with debug assertions.

use crate::run::{execute, program, root};
use std::process::Command;

pub fn run(arguments: &[String]) -> Result<(), String> {
    let mut command = Command::new(program("ishigaki-fuzz", "runner")?);
    // As `cargo run` would say: the seeds are found from there.
    command.env("CARGO_MANIFEST_DIR", root().join("crates/ishigaki-fuzz"));
    execute("fuzz", command.args(arguments).current_dir(root()))
}
