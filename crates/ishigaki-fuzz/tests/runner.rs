//! The runner itself: a few cases of each kind, one case again, and what it says to a mistake.

use ishigaki_fuzz::Target;
use std::process::{Command, Output};

fn run(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ishigaki-fuzz"));
    // Where it keeps its inputs.
    command.args(arguments).env("CARGO_TARGET_DIR", env!("CARGO_TARGET_TMPDIR")).output().unwrap()
}

#[test]
fn cases_of_each_target_run() {
    for target in Target::ALL {
        let output = run(&["--seed", "7", "--iterations", "20", "--target", target.name()]);
        assert!(output.status.success(), "{}: {output:?}", target.name());
    }
    assert!(run(&["--seed", "7", "--case", "19"]).status.success());
}

#[test]
fn a_mistake_is_refused_with_the_usage() {
    for arguments in [["--target", "nothing"], ["--iterations", "many"], ["--speed", "1"]] {
        let output = run(&arguments);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(
            output.status.code() == Some(2) && said.contains("usage: cargo xtask fuzz"),
            "{arguments:?}: {output:?}"
        );
    }
}
