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
    refused(&["--threads", "1,2"], "--scaling");
    refused(&["--series", "pile"], "--scaling");
    refused(&["--scaling", "--scenes", "tower20"], "--scenes");
    refused(&["--scaling", "--series", "heap"], "pile, pyramids, sparse, islands");
    refused(&["--scaling", "--series", "pile,pile"], "twice");
    refused(&["--scaling", "--sizes", "300,100"], "rise");
    refused(&["--scaling", "--sizes", "10"], "--sizes");
    refused(&["--scaling", "--max-bodies", "500"], "--max-bodies");
    refused(&["--scaling", "--threads", "2,2"], "twice");
    refused(&["--scaling", "--threads", "0"], "--threads");
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

#[test]
fn scaling_gives_a_row_for_each_point_and_number_of_threads() {
    let arguments = ["--scaling", "--series", "sparse,islands", "--sizes", "200", "--max-bodies", "200"];
    let more = ["--engines", "ishigaki", "--steps", "10", "--json", "--quiet", "--phases", "--no-memory"];
    let output = bench(&[&arguments[..], &more[..]].concat());
    assert!(output.status.success() && output.stderr.is_empty());
    let rows: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let places: Vec<_> = rows.as_array().unwrap().iter().map(|r| (&r["series"], &r["number"], &r["threads"])).collect();
    let islands = [1, 10, 100, 200].into_iter().flat_map(|size| [("islands", size, 1), ("islands", size, 2)]);
    let expected: Vec<_> = [("sparse", 200, 1), ("sparse", 200, 2)].into_iter().chain(islands).collect();
    assert_eq!(places.len(), expected.len());
    for (place, (series, number, threads)) in places.iter().zip(expected) {
        assert_eq!(*place, (&series.into(), &number.into(), &threads.into()));
    }
    assert_eq!((&rows[0]["bodies"], &rows[0]["awake"], &rows[0]["sleep"]), (&200.into(), &2.into(), &true.into()));
    assert_eq!(rows[0]["phases"].as_array().unwrap().len(), 10);
    assert!(rows[1]["speedup"].as_f64().unwrap() > 0.0 && rows[1]["us_per_body"].as_f64().unwrap() > 0.0);
}

#[test]
fn who_has_no_time_for_a_world_is_not_asked_for_a_larger_one() {
    let arguments = ["--scaling", "--series", "pile", "--sizes", "200,300", "--threads", "1", "--engines", "ishigaki"];
    let output = bench(&[&arguments[..], &["--limit", "0.000001", "--json", "--quiet", "--no-memory"]].concat());
    let rows: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(rows.as_array().unwrap().len(), 1, "{rows}");
    assert!(rows[0]["ms_median"].is_null() && rows[0]["note"].as_str().unwrap().contains("limit"));
}
