//! `ishigaki experiment`: what it lists, what it writes, what it refuses.

mod common;

use common::{Folder, stderr};

#[test]
fn one_experiment_leaves_plot_data_and_verdict() {
    let folder = Folder::new("experiment-one");
    let text = folder.ok(&["experiment", "free-fall", "--out", "plots", "--quick", "--quiet"]);
    for part in ["free-fall: the talk says: ", " | predicted: ", " | measured: ", " | they agree"] {
        assert!(text.contains(part), "{text}");
    }
    let mut names: Vec<_> =
        std::fs::read_dir(folder.path().join("plots")).unwrap().map(|e| e.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["free-fall.csv", "free-fall.md", "free-fall.png", "free-fall.svg"]);
}

#[test]
fn verdicts_are_json_and_progress_is_not() {
    let folder = Folder::new("experiment-json");
    let output = folder.run(&["experiment", "free-fall", "--out", ".", "--quick", "--json"]);
    let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(result[0]["name"], "free-fall");
    assert_eq!(result[0]["agrees"], true);
    assert!(result[0]["figures"][0]["measured"].is_number());
    assert!(stderr(&output).contains("free-fall"));
    let quiet = folder.run(&["experiment", "free-fall", "--out", ".", "--quick", "--json", "--quiet"]);
    assert_eq!(stderr(&quiet), "");
}

#[test]
fn without_a_name_they_are_listed() {
    let folder = Folder::new("experiment-list");
    assert!(folder.ok(&["experiment"]).contains("free-fall"));
    let list = folder.json(&["experiment", "--json"]);
    assert!(list.as_array().unwrap().iter().any(|e| e["name"] == "slop" && e["rows"][0] == "D2"));
}

#[test]
fn what_is_wrong_is_named() {
    let folder = Folder::new("experiment-wrong");
    folder.write("file", "");
    for (arguments, message) in [
        (&["experiment", "freefall", "--out", "."][..], "free-fall"),
        (&["experiment", "free-fall"], "--out"),
        (&["experiment", "free-fall", "--out", "file", "--quick"], "file"),
    ] {
        let output = folder.run(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(stderr(&output).contains(message), "{}", stderr(&output));
    }
    assert_eq!(folder.files(), ["file"]);
}
