//! The scene file says all the engine can do, and says it again the same.

use ishigaki_scenes::{SceneFile, scene_schema};

/// Every kind of shape, joint, drive and frame, with numbers that are no defaults.
const EVERYTHING: &str = include_str!("data/everything.json");

#[test]
fn everything_round_trips() {
    let file = SceneFile::from_json(EVERYTHING, "everything.json").unwrap();
    let text = file.to_json();
    assert_eq!(SceneFile::from_json(&text, "again").unwrap(), file);
    // What was written is laid out as it is in the repository, so that nothing was lost on the way in either.
    assert_eq!(text, EVERYTHING);
}

#[test]
fn an_empty_object_is_an_empty_scene() {
    let file = SceneFile::from_json("{}", "empty").unwrap();
    assert_eq!(file, SceneFile::default());
    assert_eq!(SceneFile::from_json(&file.to_json(), "again").unwrap(), file);
}

#[test]
fn the_published_schema_is_current() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../schema/scene.schema.json");
    let mut text = serde_json::to_string_pretty(&scene_schema()).unwrap();
    text.push('\n');
    if std::env::var_os("ISHIGAKI_BLESS").is_some() {
        std::fs::write(path, &text).unwrap();
    }
    let published = std::fs::read_to_string(path).unwrap_or_default();
    assert!(
        published == text,
        "schema/scene.schema.json is not what the types say: run \
         `ISHIGAKI_BLESS=1 cargo test -p ishigaki-scenes --test scene_file` and commit the file"
    );
}
