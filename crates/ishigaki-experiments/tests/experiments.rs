//! Every experiment runs and judges in its short version; every row of the talk has one, or a test of the engine.

use ishigaki_experiments::talk::{Proof, ROWS};
use ishigaki_experiments::{Effort, find, index, list};
use std::path::Path;

#[test]
fn every_row_of_the_talk_is_put_to_the_test() {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("../ishigaki/tests");
    for row in ROWS {
        match row.proof {
            Proof::Experiments(names) => {
                assert!(!names.is_empty(), "{}", row.id);
                for name in names {
                    let experiment = find(name).unwrap_or_else(|| panic!("{}: no experiment {name}", row.id));
                    assert!(experiment.rows.contains(&row.id), "{name} does not say that it is about {}", row.id);
                }
            }
            Proof::Test(place) => {
                let (file, function) = place.split_once("::").unwrap();
                let text =
                    std::fs::read_to_string(tests.join(file)).unwrap_or_else(|e| panic!("{}: {file}: {e}", row.id));
                assert!(text.contains(&format!("fn {function}()")), "{}: no {function} in {file}", row.id);
            }
        }
    }
}

#[test]
fn rows_are_in_order_and_experiments_name_rows_that_exist() {
    let key = |id: &str| (id.chars().next(), id[1..].parse::<u32>().unwrap());
    assert!(ROWS.windows(2).all(|w| key(w[0].id) < key(w[1].id)));
    for (i, experiment) in list().iter().enumerate() {
        assert!(list()[..i].iter().all(|e| e.name != experiment.name), "{} is there twice", experiment.name);
        assert!(experiment.name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-'));
        for id in experiment.rows {
            let row =
                ROWS.iter().find(|row| row.id == *id).unwrap_or_else(|| panic!("{}: no row {id}", experiment.name));
            let names = matches!(row.proof, Proof::Experiments(names) if names.contains(&experiment.name));
            assert!(names, "row {id} does not name {}", experiment.name);
        }
    }
}

/// A share of the experiments, so that they run side by side.
fn run_every(of: usize, first: usize) {
    let mut page = Vec::new();
    for experiment in list().iter().skip(first).step_by(of) {
        let name = experiment.name;
        let mut parts = Vec::new();
        let output = experiment
            .perform(Effort::Quick, &mut |part, _| parts.push(part))
            .unwrap_or_else(|e| panic!("{name}: {e}"));
        assert!(parts.iter().all(|p| (0.0..=1.0).contains(p)), "{name}: progress {parts:?}");
        assert!(output.svg.starts_with("<svg") && output.svg.trim_end().ends_with("</svg>"), "{name}");
        assert!(
            !output.svg.contains("NaN") && !output.svg.contains("inf\""),
            "{name}: the plot has no place for a point"
        );
        assert_eq!(&output.png[..8], b"\x89PNG\r\n\x1a\n", "{name}");
        assert!(output.csv.lines().count() > 2, "{name}: hardly any data");
        assert!(!output.verdict.figures.is_empty(), "{name} measures nothing");
        for figure in &output.verdict.figures {
            assert!(figure.measured.is_finite(), "{name}: {} is {}", figure.what, figure.measured);
        }
        eprintln!("{name}: {}", output.verdict);
        page.push((*experiment, output.verdict));
    }
    let results: Vec<_> = page.iter().map(|(e, v)| (*e, v)).collect();
    let html = index::page(&results);
    assert!(results.iter().all(|(e, _)| html.contains(&format!("src=\"{}.svg\"", e.name))));
}

#[test]
fn experiments_run_quickly_1_of_3() {
    run_every(3, 0);
}

#[test]
fn experiments_run_quickly_2_of_3() {
    run_every(3, 1);
}

#[test]
fn experiments_run_quickly_3_of_3() {
    run_every(3, 2);
}
