//! The map of the repository names only places that exist.

use std::path::Path;

/// Repository paths between backticks: with a slash, or with the ending of a source file.
fn paths(text: &str) -> Vec<&str> {
    let mut fenced = false;
    let mut found = Vec::new();
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            fenced = !fenced;
        } else if !fenced {
            found.extend(line.split('`').skip(1).step_by(2).filter(|word| is_path(word)));
        }
    }
    found
}

fn is_path(word: &str) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_-./".contains(c);
    let named = [".rs", ".md", ".toml", ".sh"].iter().any(|ending| word.ends_with(ending));
    !word.is_empty() && word.chars().all(plain) && (named || word.contains('/'))
}

#[test]
fn every_path_of_the_map_exists() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let map = root.join("ARCHITECTURE.md");
    let text = std::fs::read_to_string(&map).unwrap_or_else(|e| panic!("{}: {e}", map.display()));
    let engine = root.join("crates/ishigaki/src");
    let exists = |path: &str| root.join(path).exists() || engine.join(path).exists();
    let missing: Vec<&str> = paths(&text).into_iter().filter(|path| !exists(path)).collect();
    assert!(missing.is_empty(), "ARCHITECTURE.md names what is not there: {missing:?}");
}

#[test]
fn paths_are_told_from_code() {
    let text = "`a/b.rs` and `World::step`, `x / y`, `Cargo.toml`, `m/s²`\n```\n`not/this.rs`\n```\n`docs/`";
    assert_eq!(paths(text), ["a/b.rs", "Cargo.toml", "docs/"]);
}
