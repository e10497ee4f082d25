//! Options by path, for command lines: `solver.weight_amplification.factor=1.4`.
//!
//! - A path names an option as the JSON of [`WorldOptions`] does, its parts separated by dots.
//! - Setting a number of a technique (a struct with `enabled`) switches the technique on, unless it is `enabled`
//!   itself that is set: who says `solver.weight_amplification.factor=1.4` wants weight amplification.
//! - A technique itself takes `on` or `off`: `solver.warm_start=off` is `solver.warm_start.enabled=false`.
//! - `solver` takes the presets `plain`, `talk` and `default`; set it first, it replaces all solver options.
//! - Enums are set by name: `solver.permutation=per_sweep`. Vectors by JSON: `gravity=[0,0,-9.81]`.

use crate::error::{Result, SceneError, unknown, with_guess};
use crate::file::shorten;
use ishigaki::{SolverOptions, WorldOptions};
use serde_json::{Map, Value};

/// The presets of `solver`.
pub const SOLVER_PRESETS: [&str; 3] = ["plain", "talk", "default"];

/// Sets one option, given as text, by its path.
///
/// ```
/// use ishigaki::WorldOptions;
/// let mut options = WorldOptions::default();
/// ishigaki_scenes::set_option(&mut options, "solver", "plain")?;
/// ishigaki_scenes::set_option(&mut options, "solver.weight_amplification.factor", "1.7")?;
/// assert!(options.solver.weight_amplification.enabled);
/// # Ok::<(), ishigaki_scenes::SceneError>(())
/// ```
///
/// # Errors
/// A path that does not exist (the names at that level are listed), a value that does not fit; the options stay as
/// they were.
pub fn set_option(options: &mut WorldOptions, path: &str, value: &str) -> Result<()> {
    let value = value.trim();
    if path == "solver" && !value.starts_with('{') {
        options.solver = match value {
            "plain" => SolverOptions::plain(),
            "talk" => SolverOptions::talk(),
            "default" => SolverOptions::default(),
            other => return Err(SceneError::invalid(path, unknown("preset", other, SOLVER_PRESETS))),
        };
        return Ok(());
    }
    let refuse = |e: serde_json::Error| SceneError::invalid(path, with_guess(&e.to_string()));
    let mut tree = serde_json::to_value(&*options).map_err(refuse)?;
    set(&mut tree, path, value)?;
    let changed: WorldOptions = serde_json::from_value(tree).map_err(refuse)?;
    changed.validate().map_err(|e| SceneError::from_engine("", e))?;
    *options = changed;
    Ok(())
}

/// Every option as (path, value in words), in the order of the paths: what `set_option` can set.
pub fn list_options(options: &WorldOptions) -> Vec<(String, String)> {
    let mut list = Vec::new();
    if let Ok(mut tree) = serde_json::to_value(options) {
        shorten(&mut tree);
        collect("", &tree, &mut list);
    }
    list
}

fn collect(path: &str, value: &Value, list: &mut Vec<(String, String)>) {
    match value {
        Value::Object(map) => {
            for (key, child) in map {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                collect(&path, child, list);
            }
        }
        Value::String(name) => list.push((path.to_string(), name.clone())),
        other => list.push((path.to_string(), other.to_string())),
    }
}

fn set(tree: &mut Value, path: &str, text: &str) -> Result<()> {
    let parts: Vec<&str> = path.split('.').collect();
    let (last, groups) = parts.split_last().unwrap_or((&"", &[]));
    let mut group = as_group(tree, "", path)?;
    let mut walked = String::new();
    for part in groups {
        let place = walked.clone();
        push(&mut walked, part);
        let names = names(group);
        let child = group.get_mut(*part).ok_or_else(|| no_option(&place, part, &names))?;
        group = as_group(child, &walked, path)?;
    }
    let names = names(group);
    let old = group.get(*last).ok_or_else(|| no_option(&walked, last, &names))?;
    if let Value::Object(children) = old {
        return set_group(group, last, children.clone(), path, text);
    }
    let new = parse(path, old, text)?;
    group.insert((*last).to_string(), new);
    if *last != "enabled"
        && let Some(enabled) = group.get_mut("enabled")
    {
        *enabled = Value::Bool(true);
    }
    Ok(())
}

/// A technique takes on/off, any group takes a JSON object of some of its options.
fn set_group(
    parent: &mut Map<String, Value>,
    key: &str,
    mut children: Map<String, Value>,
    path: &str,
    text: &str,
) -> Result<()> {
    if let Ok(Value::Object(changes)) = serde_json::from_str(text) {
        let names: Vec<String> = names(&children);
        for (name, value) in changes {
            if !children.contains_key(&name) {
                return Err(no_option(path, &name, &names));
            }
            children.insert(name, value);
        }
    } else if let (true, Some(on)) = (children.contains_key("enabled"), switch(text)) {
        children.insert("enabled".to_string(), Value::Bool(on));
    } else {
        let how = if children.contains_key("enabled") {
            "takes on or off, or one of its options is set"
        } else {
            "is a group of options: set one of them"
        };
        let message =
            format!("{how}, as in `{path}.{}=…`; there are: {}", first(&children), names(&children).join(", "));
        return Err(SceneError::invalid(path, message));
    }
    parent.insert(key.to_string(), Value::Object(children));
    Ok(())
}

fn first(map: &Map<String, Value>) -> &str {
    map.keys().next().map_or("", String::as_str)
}

fn names(map: &Map<String, Value>) -> Vec<String> {
    map.keys().cloned().collect()
}

fn push(path: &mut String, part: &str) {
    if !path.is_empty() {
        path.push('.');
    }
    path.push_str(part);
}

fn no_option(place: &str, name: &str, names: &[String]) -> SceneError {
    let place = if place.is_empty() { "options" } else { place };
    SceneError::invalid(place, unknown("option", name, names.iter().map(String::as_str)))
}

fn as_group<'a>(value: &'a mut Value, walked: &str, path: &str) -> Result<&'a mut Map<String, Value>> {
    match value {
        Value::Object(map) => Ok(map),
        _ => Err(SceneError::invalid(path, format!("`{walked}` is an option, not a group: nothing is inside it"))),
    }
}

fn switch(text: &str) -> Option<bool> {
    match text {
        "true" | "on" => Some(true),
        "false" | "off" => Some(false),
        _ => None,
    }
}

/// The text as a value of the same type as the old one.
fn parse(path: &str, old: &Value, text: &str) -> Result<Value> {
    let wrong = |expected: &str| SceneError::invalid(path, format!("expects {expected}, got `{text}`"));
    match old {
        Value::Bool(_) => switch(text).map(Value::Bool).ok_or_else(|| wrong("true or false")),
        Value::Number(n) if n.is_f64() => {
            // Through f32: 1e39 is infinite there, and so it is refused here.
            let number = text.parse::<f32>().ok().filter(|f| f.is_finite()).ok_or_else(|| wrong("a number"))?;
            Ok(Value::from(number))
        }
        Value::Number(_) => text.parse::<u64>().map(Value::from).map_err(|_| wrong("a whole number ≥ 0")),
        Value::String(_) => Ok(Value::String(text.to_string())),
        // Lists, and options that may be absent.
        _ => match serde_json::from_str(text) {
            Ok(value) => Ok(value),
            Err(_) if old.is_null() => Ok(Value::String(text.to_string())),
            Err(_) => Err(wrong("a list, as in [0, -9.81, 0]")),
        },
    }
}
