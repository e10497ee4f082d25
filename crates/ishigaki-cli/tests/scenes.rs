//! The named scenes on the command line.

mod common;

use common::Folder;
use serde_json::Value;
use std::process::Stdio;

#[test]
fn every_listed_scene_is_a_scene_file_that_runs() {
    let folder = Folder::new("listed");
    let list: Value = folder.json(&["scenes", "--json"]);
    let names: Vec<&str> = list.as_array().unwrap().iter().map(|scene| scene["name"].as_str().unwrap()).collect();
    assert!(names.contains(&"wall"), "{names:?}");
    let text = folder.ok(&["scenes"]);
    for name in &names {
        assert!(text.contains(name), "{name} is missing in\n{text}");
        let scene: Value = serde_json::from_str(&folder.ok(&["scenes", name])).unwrap();
        assert!(!scene["bodies"].as_array().unwrap().is_empty(), "{name} has no bodies");
    }
    for scene in list.as_array().unwrap() {
        assert!(!scene["summary"].as_str().unwrap().is_empty(), "{scene}");
        assert!(scene["parameters"].as_array().unwrap().iter().all(|p| p["name"].is_string()), "{scene}");
    }
}

#[test]
fn a_written_scene_runs_like_the_named_one() {
    let folder = Folder::new("written");
    folder.write("wall.json", folder.ok(&["scenes", "wall"]));
    let hash = |what| folder.json(&["run", what, "--steps", "3", "--json", "--quiet"])["state_hash"].clone();
    assert_eq!(hash("wall"), hash("wall.json"));
}

#[test]
fn the_schema_describes_bodies() {
    let schema = Folder::new("schema").json(&["scenes", "--schema"]);
    assert!(schema["properties"]["bodies"].is_object(), "{schema}");
}

#[test]
fn a_reader_that_has_seen_enough_is_no_failure() {
    let folder = Folder::new("closed");
    let mut child = folder.command(&["scenes", "--schema"]).stdout(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    assert!(child.wait().unwrap().success());
}

#[test]
fn every_listed_option_can_be_set_to_its_default() {
    let folder = Folder::with_small("options");
    let text = folder.ok(&["options"]);
    let words = text.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
    let mut assignments: Vec<String> = words.map(|w| format!("{}={}", w[0], w[1..].concat())).collect();
    // Setting a number of a technique switches it on: the switches have the last word.
    assignments.sort_by_key(|a| a.contains(".enabled="));
    assert!(assignments.iter().any(|a| a.starts_with("solver.weight_amplification.factor=1.4")), "{text}");
    let run = ["run", "small.json", "--json", "--quiet", "--steps", "40"];
    let set: Vec<&str> = assignments.iter().flat_map(|a| ["--set", a]).collect();
    assert_eq!(folder.json(&run)["state_hash"], folder.json(&[&run[..], &set].concat())["state_hash"]);
}
