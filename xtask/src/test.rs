//! `cargo xtask test`: every test there is, and at its end the list of what was skipped.
//!
//! A test that needs more than Rust skips itself by appending `SKIPPED kind: how to get it` to the file named
//! by `ISHIGAKI_SKIP_LOG`, unless its kind is in `ISHIGAKI_REQUIRE`: then a skip is a failure.

use crate::counts;
use crate::run::{cargo, execute, execute_beside, root, target_directory};
use crate::web;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

pub fn run() -> Result<(), String> {
    let log = target_directory().join("skipped.txt");
    fs::create_dir_all(target_directory()).map_err(|e| format!("{}: {e}", target_directory().display()))?;
    fs::write(&log, "").map_err(|e| format!("{}: {e}", log.display()))?;

    let mut failures = Vec::new();
    let miri = match miri_missing() {
        None => Some(execute_beside("miri", miri(&log))),
        Some(why) => {
            skip(&log, &format!("SKIPPED miri: {why}"))?;
            None
        }
    };
    // First: the command line has the page inside, and its tests look at it.
    match web::missing().or_else(web::browser_missing) {
        None => failures.extend(web::build().err()),
        Some(why) => skip(&log, &format!("SKIPPED web: {why}"))?,
    }
    let mut suite = |title: &str, arguments: &[&str]| {
        let mut command = cargo(None, arguments);
        command.env("ISHIGAKI_SKIP_LOG", &log);
        failures.extend(execute(title, &mut command).err());
    };

    suite("workspace", &["test", "--workspace", "--no-fail-fast"]);
    if root().join("crates/ishigaki/tests/golden.rs").exists() {
        // The engine alone as a plain debug build compiles it, beside the dependencies that are there already.
        let engine = ["--config", "profile.dev.package.ishigaki.opt-level=0"];
        let unoptimized = [&["test", "--workspace", "--test", "golden"][..], &engine].concat();
        suite("golden hashes, unoptimized", &unoptimized);
    }
    if let Some(miri) = miri {
        failures.extend(miri.join().unwrap_or_else(|_| Err("miri: its thread panicked".into())).err());
    }
    match counts::missing() {
        None => failures.extend(counts::run(false).err()),
        Some(why) => skip(&log, &format!("SKIPPED valgrind: {why}"))?,
    }
    if web::missing().or_else(web::browser_missing).is_none() {
        failures.extend(web::test().err());
    }

    let text = fs::read_to_string(&log).map_err(|e| format!("{}: {e}", log.display()))?;
    let mut skipped: Vec<&str> = text.lines().collect();
    skipped.sort_unstable();
    skipped.dedup();
    let required = std::env::var("ISHIGAKI_REQUIRE").unwrap_or_default();
    for line in &skipped {
        if is_required(line, &required) {
            failures.push(format!("skipped, but ISHIGAKI_REQUIRE={required}: {line}"));
        }
    }
    summarize(&skipped, &failures)
}

/// Whether the kind of a line of the skip log is in the comma list.
fn is_required(line: &str, required: &str) -> bool {
    let kind = line.split(':').next().unwrap_or(line).trim_start_matches("SKIPPED ").trim();
    required.split(',').map(str::trim).any(|r| !r.is_empty() && r == kind)
}

fn skip(log: &Path, line: &str) -> Result<(), String> {
    use std::io::Write;
    let mut file = fs::OpenOptions::new().append(true).open(log).map_err(|e| format!("{}: {e}", log.display()))?;
    file.write_all(format!("{line}\n").as_bytes()).map_err(|e| format!("{}: {e}", log.display()))
}

fn miri(log: &Path) -> Command {
    // Miri does not know libm's assembly; its soft floats give the same bits.
    let soft = ["--features", "libm/force-soft-floats"];
    let arguments = [
        &[
            "miri",
            "test",
            "--package",
            "ishigaki-miri",
            "--package",
            "ishigaki-team",
            "--test",
            "small",
            "--test",
            "meetings",
        ][..],
        &soft,
    ]
    .concat();
    let mut command = cargo(Some("nightly"), &arguments);
    command.env("ISHIGAKI_SKIP_LOG", log).env("MIRIFLAGS", "-Zmiri-strict-provenance");
    command
}

/// Why Miri cannot run, or `None`.
fn miri_missing() -> Option<&'static str> {
    let remedy = "no nightly toolchain with Miri; `rustup toolchain install nightly` then \
                  `rustup +nightly component add miri rust-src`";
    let answer = cargo(Some("nightly"), &["miri", "--version"]).stdout(Stdio::null()).stderr(Stdio::null()).status();
    if answer.is_ok_and(|status| status.success()) { None } else { Some(remedy) }
}

fn summarize(skipped: &[&str], failures: &[String]) -> Result<(), String> {
    if skipped.is_empty() {
        println!("nothing was skipped");
    } else {
        println!("skipped:");
        skipped.iter().for_each(|line| println!("  {}", line.trim_start_matches("SKIPPED ")));
    }
    if failures.is_empty() { Ok(()) } else { Err(format!("failed:\n  {}", failures.join("\n  "))) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_required_kind_is_matched_whole() {
        assert!(is_required("SKIPPED models: run x", "miri, models"));
        assert!(!is_required("models: not fetched", "model"));
        assert!(!is_required("models: not fetched", ""));
        assert!(!is_required("", ""));
    }

    #[test]
    fn a_failure_wins_over_skips() {
        assert!(summarize(&["miri: x"], &[]).is_ok());
        assert!(summarize(&[], &["y".to_string()]).unwrap_err().contains('y'));
    }
}
