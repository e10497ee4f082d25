//! The program as it is called: what it prints, what it refuses.

use std::process::{Command, Output};

fn bench(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_ishigaki-bench")).args(arguments).output().unwrap()
}

#[track_caller]
fn refused(arguments: &[&str], word: &str) {
    let output = bench(arguments);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
    assert!(message.contains(word) && output.stdout.is_empty(), "{arguments:?}: {message}");
}

#[test]
fn bad_arguments_exit_with_2_and_say_why() {
    refused(&["--scenes", "towr"], "tower20");
    refused(&["--scenes", "tower:n=0"], "[1, 10000]");
    refused(&["--engines", "havok"], "ishigaki");
    refused(&["--engines", "ishigaki,ishigaki"], "twice");
    refused(&["--set", "solver.substep=2"], "substeps");
    refused(&["--set", "solver.substeps"], "PATH=VALUE");
    refused(&["--limit", "0"], "--limit");
    refused(&["--rest-after", "NaN"], "--rest-after");
    refused(&["--steps", "0"], "--steps");
}

#[test]
fn json_is_one_array_of_rows() {
    let output = bench(&[
        "--scenes",
        "tower:n=3,free_body",
        "--engines",
        "ishigaki",
        "--steps",
        "40",
        "--json",
        "--quiet",
        "--phases",
        "--no-memory",
    ]);
    assert!(output.status.success() && output.stderr.is_empty());
    let rows: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(rows.as_array().unwrap().len(), 2);
    let tower = rows[0].as_object().unwrap();
    for key in ["ms_median", "ratio_to_box3d", "ratio_low", "ratio_high", "drift_max", "joint_gap_max", "rss_mib"] {
        assert!(tower.contains_key(key), "{key}");
    }
    assert_eq!((&tower["scene"], &tower["engine"]), (&"tower:n=3".into(), &"ishigaki".into()));
    assert_eq!((&tower["stands"], &tower["threads"], &tower["steps"]), (&true.into(), &1.into(), &40.into()));
    assert!(tower["penetration_max"].as_f64().unwrap() < 0.02);
    assert_eq!(tower["phases"].as_array().unwrap().len(), 10);
}

#[test]
fn an_engine_over_its_limit_stops_with_a_note() {
    let output = bench(&[
        "--scenes",
        "pyramid:base=8",
        "--engines",
        "ishigaki",
        "--steps",
        "100000",
        "--limit",
        "0.05",
        "--json",
        "--quiet",
        "--no-memory",
    ]);
    let rows: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(rows[0]["note"].as_str().unwrap().contains("limit"), "{rows}");
}

#[cfg(target_os = "linux")]
#[test]
fn memory_is_that_of_the_scene_alone() {
    let output = bench(&["--scenes", "pyramid:base=20", "--engines", "ishigaki", "--steps", "5", "--json", "--quiet"]);
    let rows: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let mib = rows[0]["rss_mib"].as_f64().unwrap();
    assert!((0.1..100.0).contains(&mib), "{mib} MiB for 210 boxes");
}
