//! What a run gives: numbers, files, and the same bits again.

mod common;

use common::{Folder, SMALL, stderr};
use serde_json::Value;
use std::io::Write;
use std::process::Stdio;

const STAGES: [&str; 10] = [
    "begin",
    "find_pairs",
    "update_contacts",
    "build_islands",
    "gather_forces",
    "build_rows",
    "plan_sweep",
    "solve",
    "finish_motion",
    "put_to_rest",
];

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

#[test]
fn json_is_one_object_with_every_field() {
    let folder = Folder::with_small("json_fields");
    let text = folder.ok(&["run", "small.json", "--json", "--quiet", "--steps", "60"]);
    assert_eq!(text.trim_end().lines().count(), 1);
    let result: Value = serde_json::from_str(&text).unwrap();

    assert_eq!(result["scene"], "small.json");
    assert_eq!(result["steps"], 60);
    assert!((0.0..60.0).contains(&number(&result["steps_not_taken"])));
    assert!((number(&result["dt"]) - 1.0 / 60.0).abs() < 1e-6);
    assert_eq!(result["bodies"], 4);
    let [median, p95, max] = ["median", "p95", "max"].map(|key| number(&result["ms_per_step"][key]));
    assert!(0.0 < median && median <= p95 && p95 <= max, "{median} {p95} {max}");
    assert_eq!(result["stages_ms"].as_object().unwrap().len(), STAGES.len());
    let stages: f64 = STAGES.iter().map(|stage| number(&result["stages_ms"][stage])).sum();
    assert!(0.0 < stages && stages < max, "the stages take {stages} ms, the slowest step {max} ms");

    // Something lies on the ground (a normal and two friction rows), and the door hangs on five rows.
    assert!(number(&result["contacts"]) >= 1.0 && number(&result["rows"]) >= 3.0 + 5.0, "{result}");
    for (key, most) in [("max_penetration", 0.02), ("max_joint_error", 0.01), ("max_speed", 20.0)] {
        assert!((0.0..most).contains(&number(&result[key])), "{key}: {}", result[key]);
    }
    assert!(number(&result["worst_penetration"]) >= number(&result["max_penetration"]));
    assert!(number(&result["worst_joint_error"]) >= number(&result["max_joint_error"]));
    assert!(number(&result["work_per_step"]) > 0.0 && number(&result["work_over_budget"]) > 0.0);
    assert!(number(&result["kinetic_energy"]) >= 0.0);
    assert!(number(&result["potential_energy"]) > 0.0, "all of it is above the ground");
    for key in ["momentum", "angular_momentum"] {
        assert_eq!(result[key].as_array().unwrap().len(), 3);
    }
    assert!(number(&result["asleep"]) <= 3.0 && number(&result["frozen"]) <= number(&result["contacts"]));
    let hash = result["state_hash"].as_str().unwrap();
    assert!(hash.len() == 16 && u64::from_str_radix(hash, 16).is_ok(), "{hash}");
    assert_eq!(result["non_finite"], Value::Array(vec![]));
    assert_eq!(result["warnings"], Value::Array(vec![]));
}

#[test]
fn free_fall_is_reported_as_the_discrete_sum() {
    let folder = Folder::new("free_fall");
    let ball = r#"{ "bodies": [{ "position": [0, 100, 0], "mass": { "total": 2 },
                    "shapes": [{ "geometry": { "ball": { "radius": 0.5 } } }] }] }"#;
    folder.write("ball.json", ball);
    let result = folder.json(&["run", "ball.json", "--json", "--steps", "50", "--dt", "0.01"]);
    // Velocity after n steps: n g Δt; energy m v²/2; momentum m v.
    let speed = 50.0 * 9.81 * 0.01;
    assert!((number(&result["max_speed"]) - speed).abs() < 1e-4);
    assert!((number(&result["kinetic_energy"]) - speed * speed).abs() < 1e-3);
    assert!((number(&result["momentum"][1]) + 2.0 * speed).abs() < 1e-4);
}

#[test]
fn the_same_run_gives_the_same_bits() {
    let folder = Folder::with_small("same_bits");
    let hash = |extra: &[&str]| {
        let arguments = [&["run", "small.json", "--json", "--quiet", "--steps", "40"], extra].concat();
        folder.json(&arguments)["state_hash"].clone()
    };
    let first = hash(&[]);
    assert_eq!(first, hash(&[]));
    assert_eq!(first, hash(&["--states", "a.csv", "--snapshot", "a.snap"]), "recording must not change the result");
    assert_ne!(first, hash(&["--set", "gravity=[0, -1, 0]"]), "--set had no effect");
    assert_ne!(first, hash(&["--dt", "0.01"]), "--dt had no effect");
    assert_eq!(folder.files(), ["a.csv", "a.snap", "small.json"]);
}

#[test]
fn states_have_a_line_for_each_body_and_recorded_step() {
    let folder = Folder::with_small("states");
    folder.ok(&["run", "small.json", "--quiet", "--steps", "20", "--states", "out.csv", "--every", "5"]);
    let text = folder.read("out.csv");
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("step,time,body,name,px,py,pz,qx,qy,qz,qw,vx,vy,vz,wx,wy,wz"));
    let rows: Vec<&str> = lines.collect();
    assert_eq!(rows.len(), 5 * 4, "steps 0, 5, 10, 15, 20 of four bodies");
    assert!(rows[2].starts_with("0,0.0,2,\"box, \"\"tilted\"\"\",0.1,1.8,0.0,"), "{}", rows[2]);
    assert!(rows[17].starts_with("20,0.33"), "{}", rows[17]);
    for row in rows.iter().filter(|row| !row.contains('"')) {
        let fields: Vec<&str> = row.split(',').collect();
        assert_eq!(fields.len(), 17, "{row}");
        let q: Vec<f64> = fields[7..11].iter().map(|field| field.parse().unwrap()).collect();
        let length: f64 = q.iter().map(|x| x * x).sum();
        assert!((length - 1.0).abs() < 1e-5, "{row}");
    }
}

#[test]
fn a_snapshot_continues_bit_for_bit() {
    let folder = Folder::with_small("continue");
    let base = ["--json", "--quiet"];
    let run = |arguments: &[&str]| folder.json(&[&["run"], arguments, &base].concat());
    let whole = run(&["small.json", "--steps", "60", "--snapshot", "whole.snap"]);
    run(&["small.json", "--steps", "30", "--snapshot", "half.snap"]);
    let alone = run(&["--from", "half.snap", "--steps", "30", "--snapshot", "alone.snap", "--states", "alone.csv"]);
    let with_scene = run(&["small.json", "--from", "half.snap", "--steps", "30"]);
    assert_eq!(whole["state_hash"], alone["state_hash"]);
    assert_eq!(whole["state_hash"], with_scene["state_hash"]);
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert!(bytes("whole.snap") == bytes("alone.snap"), "the snapshots differ");
    let states = folder.read("alone.csv");
    assert!(states.lines().nth(1).unwrap().starts_with("30,0.5"), "the count of steps goes on");
    assert!(states.lines().last().unwrap().starts_with("60,1.0"));
}

#[test]
fn an_older_result_is_replaced_only_by_a_whole_one() {
    let folder = Folder::with_small("replace");
    folder.write("out.csv", "older");
    let failing = folder.run(&["run", "small.json", "--states", "out.csv", "--snapshot", "nowhere/out.snap"]);
    assert_eq!(failing.status.code(), Some(2));
    assert_eq!(folder.read("out.csv"), "older");
    folder.ok(&["run", "small.json", "--states", "out.csv"]);
    assert!(folder.read("out.csv").starts_with("step,time"));
    assert_eq!(folder.files(), ["out.csv", "small.json"]);
}

#[test]
fn a_device_is_written_and_stays_a_device() {
    let folder = Folder::with_small("device");
    let text = folder.ok(&["run", "small.json", "--quiet", "--steps", "1", "--states", "/dev/stdout"]);
    assert!(text.starts_with("step,time"), "{text}");
    folder.ok(&["run", "small.json", "--quiet", "--steps", "1", "--snapshot", "/dev/null"]);
    assert!(!std::fs::metadata("/dev/null").unwrap().is_file());
}

#[test]
fn the_summary_for_people_names_what_it_measured() {
    let folder = Folder::with_small("summary");
    let text = folder.ok(&["run", "small.json", "--quiet", "--steps", "10"]);
    for word in ["10 steps", "ms median", "penetration", "joint error", "kinetic", "kg·m/s", "state hash"] {
        assert!(text.contains(word), "no {word} in\n{text}");
    }
    assert!(STAGES.iter().all(|stage| text.contains(stage)), "{text}");
}

#[test]
fn quiet_is_silent_and_chatter_stays_off_stdout() {
    let folder = Folder::with_small("quiet");
    let output = folder.run(&["run", "small.json", "--quiet", "--json", "--steps", "5"]);
    assert_eq!(stderr(&output), "");
    let output = folder.run(&["run", "small.json", "--json", "--steps", "5"]);
    assert!(serde_json::from_slice::<Value>(&output.stdout).is_ok());
}

#[test]
fn a_scene_comes_through_a_pipe() {
    let folder = Folder::with_small("pipe");
    let mut child = folder
        .command(&["run", "-", "--json", "--quiet", "--steps", "40"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(SMALL.as_bytes()).unwrap();
    let output = child.wait_with_output().unwrap();
    let piped: Value = serde_json::from_slice(&output.stdout).unwrap();
    let read = folder.json(&["run", "small.json", "--json", "--quiet", "--steps", "40"]);
    assert_eq!(piped["state_hash"], read["state_hash"]);
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_leaves_no_files() {
    let folder = Folder::with_small("interrupt");
    let mut child = folder
        .command(&[
            "run",
            "small.json",
            "--steps",
            "1000000000",
            "--states",
            "out.csv",
            "--every",
            "1000000",
            "--snapshot",
            "out.snap",
        ])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    // It has begun when its temporary files are there; the handler is set soon after.
    for _ in 0..200 {
        if folder.files().len() >= 3 {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    std::thread::sleep(std::time::Duration::from_millis(300));
    let killed = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert_eq!(folder.files(), ["small.json"]);
}
