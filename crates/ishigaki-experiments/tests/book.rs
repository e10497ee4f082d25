//! The book names only what there is: chapters, code by anchors, plots of experiments, links, paths; and it misses no
//! row of the talk. Plots are made by `scripts/book.sh`: here it is enough that the experiment exists.

use ishigaki_experiments::find;
use ishigaki_experiments::talk::{Proof, ROWS};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn source() -> PathBuf {
    root().join("book/src")
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Name and text of each chapter, SUMMARY.md included.
fn chapters() -> Vec<(String, String)> {
    let mut found: Vec<_> = std::fs::read_dir(source())
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "md"))
        .map(|path| (path.file_name().unwrap().to_string_lossy().into_owned(), read(&path)))
        .collect();
    found.sort();
    assert!(found.len() > 20, "only {} chapters", found.len());
    found
}

/// What stands between `start` and `end`, wherever that is.
fn between<'a>(text: &'a str, start: &'a str, end: char) -> impl Iterator<Item = &'a str> {
    text.split(start).skip(1).filter_map(move |rest| rest.split_once(end)).map(|(inside, _)| inside)
}

fn includes(text: &str) -> impl Iterator<Item = &str> {
    between(text, "{{#include ", '}')
}

/// Lines outside of code blocks.
fn prose(text: &str) -> impl Iterator<Item = &str> {
    let mut fenced = false;
    text.lines().filter(move |line| {
        let fence = line.starts_with("```");
        fenced ^= fence;
        !fenced && !fence
    })
}

/// The experiment behind `plots/NAME.EXTENSION`.
fn experiment_of(path: &str) -> Option<&str> {
    let (name, extension) = path.strip_prefix("plots/")?.rsplit_once('.')?;
    ["svg", "md"].contains(&extension).then_some(name)
}

#[test]
fn every_chapter_is_in_the_summary_once() {
    let summary = read(&source().join("SUMMARY.md"));
    let listed: Vec<&str> = between(&summary, "](", ')').collect();
    let files: BTreeSet<String> = chapters().into_iter().map(|c| c.0).filter(|name| name != "SUMMARY.md").collect();
    assert_eq!(listed.iter().map(|name| name.to_string()).collect::<BTreeSet<_>>(), files);
    assert_eq!(listed.len(), files.len(), "a chapter is listed twice");
}

#[test]
fn every_include_has_its_file_and_anchor() {
    for (chapter, text) in chapters() {
        for include in includes(&text) {
            if let Some(name) = experiment_of(include) {
                assert!(find(name).is_some(), "{chapter}: no experiment {name}");
                continue;
            }
            let (path, anchor) = include.split_once(':').unwrap_or_else(|| panic!("{chapter}: {include}: no anchor"));
            let code = read(&source().join(path));
            for mark in ["ANCHOR", "ANCHOR_END"] {
                let line = format!("// {mark}: {anchor}");
                let count = code.lines().filter(|l| l.trim() == line).count();
                assert_eq!(count, 1, "{chapter}: `{line}` in {path}");
            }
        }
    }
}

#[test]
fn every_anchor_is_in_the_book() {
    let wanted: BTreeSet<String> = chapters()
        .iter()
        .flat_map(|(_, text)| includes(text).filter_map(|include| include.split_once(':')))
        .map(|(path, anchor)| format!("{}:{anchor}", path.trim_start_matches("../")))
        .collect();
    let mut folders = vec![root().join("crates")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                for line in read(&path).lines() {
                    let Some(anchor) = line.trim().strip_prefix("// ANCHOR: ") else { continue };
                    let place = format!("{}:{anchor}", path.strip_prefix(root()).unwrap().display());
                    assert!(wanted.contains(&place), "no chapter includes {place}");
                }
            }
        }
    }
}

#[test]
fn every_link_leads_somewhere() {
    for (chapter, text) in chapters() {
        for target in prose(&text).flat_map(|line| between(line, "](", ')')) {
            match experiment_of(target) {
                Some(name) => assert!(find(name).is_some(), "{chapter}: no experiment {name}"),
                None => assert!(source().join(target).exists(), "{chapter}: {target} is not there"),
            }
        }
    }
}

#[test]
fn every_path_in_the_text_exists() {
    let endings = [".rs", ".md", ".sh", ".toml"];
    for (chapter, text) in chapters() {
        for word in prose(&text).flat_map(|line| line.split('`').skip(1).step_by(2)) {
            let is_path = word.contains('/') && !word.contains(' ') && endings.iter().any(|e| word.ends_with(e));
            assert!(!is_path || root().join(word).exists(), "{chapter}: {word} is not there");
        }
    }
}

#[test]
fn every_row_of_the_talk_has_a_section_with_its_proof() {
    for row in ROWS {
        let mention = |heading: &str| {
            let (_, ids) = heading.rsplit_once('(')?;
            ids.trim_end_matches(')').split(", ").find(|id| *id == row.id).map(|_| ())
        };
        let about: Vec<String> = chapters()
            .into_iter()
            .map(|c| c.1)
            .filter(|text| prose(text).any(|line| line.starts_with('#') && mention(line).is_some()))
            .collect();
        assert!(!about.is_empty(), "no heading of the book is about {} {}", row.id, row.technique);
        match row.proof {
            // The technique matrix is about many rows and has a chapter of its own.
            Proof::Experiments(names) => {
                for name in names {
                    let plot = format!("(plots/{name}.svg)");
                    assert!(
                        chapters().iter().any(|c| c.1.contains(&plot)),
                        "{}: the book does not show {name}",
                        row.id
                    );
                }
            }
            Proof::Test(place) => {
                let function = place.rsplit_once("::").unwrap().1;
                assert!(about.iter().any(|text| text.contains(function)), "{}: no mention of {function}", row.id);
            }
        }
    }
}
