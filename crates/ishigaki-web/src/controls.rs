//! One control for each option of the engine, made from the schema of the scene file: no option is forgotten, and a new
//! one needs no line here.

use ishigaki::WorldOptions;
use ishigaki_scenes::{list_options, scene_schema};
use serde::Serialize;
use serde_json::Value;

/// How an option is shown and set.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ControlKind {
    /// On or off.
    Switch,
    /// A whole number ≥ 0.
    Whole,
    /// A number.
    Number,
    /// One of these names, each with what it means.
    Choice(Vec<(String, String)>),
    /// Numbers in a list.
    Vector,
}

/// An option of the engine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Control {
    /// As [`ishigaki_scenes::set_option`] takes it.
    pub path: String,
    /// How it is shown.
    pub kind: ControlKind,
    /// Its value if nothing is said, as text.
    pub default: String,
    /// What it does, with unit and range.
    pub doc: String,
    /// What the group does that it belongs to; empty at the root.
    pub group_doc: String,
}

/// All options in the order of their paths.
pub fn controls() -> Vec<Control> {
    let schema = scene_schema();
    let options = list_options(&WorldOptions::default());
    options.into_iter().filter_map(|(path, default)| control(&schema, path, default)).collect()
}

fn control(schema: &Value, path: String, default: String) -> Option<Control> {
    let mut at = schema.pointer("/$defs/WorldOptions")?;
    let (mut doc, mut group_doc) = (String::new(), String::new());
    for part in path.split('.') {
        let property = at.get("properties")?.get(part)?;
        group_doc = std::mem::replace(&mut doc, description(property));
        at = match property.get("$ref").and_then(Value::as_str) {
            Some(reference) => schema.pointer(reference.trim_start_matches('#'))?,
            None => property,
        };
    }
    Some(Control { kind: kind(at)?, path, default, doc, group_doc })
}

fn kind(at: &Value) -> Option<ControlKind> {
    if let Some(choices) = at.get("oneOf").and_then(Value::as_array) {
        let name = |c: &Value| Some((c.get("const")?.as_str()?.to_string(), description(c)));
        return Some(ControlKind::Choice(choices.iter().filter_map(name).collect()));
    }
    match at.get("type")?.as_str()? {
        "boolean" => Some(ControlKind::Switch),
        "integer" => Some(ControlKind::Whole),
        "number" => Some(ControlKind::Number),
        "array" => Some(ControlKind::Vector),
        _ => None,
    }
}

fn description(value: &Value) -> String {
    value.get("description").and_then(Value::as_str).unwrap_or_default().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ishigaki_scenes::set_option;

    #[test]
    fn every_option_has_a_control_that_sets_it() {
        let listed = list_options(&WorldOptions::default());
        let controls = controls();
        assert_eq!(listed.len(), controls.len(), "an option has no control: its schema is of a new form");
        for (control, (path, value)) in controls.iter().zip(&listed) {
            assert_eq!((&control.path, &control.default), (path, value));
            assert!(!control.doc.is_empty(), "{path} is not explained");
            let mut options = WorldOptions::default();
            set_option(&mut options, path, &control.default).unwrap();
        }
    }
}
