//! `cargo xtask fuzz`: the seeded mutation runner, built with debug assertions.

use crate::run::{cargo, execute};

pub fn run(arguments: &[String]) -> Result<(), String> {
    let mut command = cargo(None, &["run", "--quiet", "--package", "ishigaki-fuzz", "--"]);
    execute("fuzz", command.args(arguments))
}
