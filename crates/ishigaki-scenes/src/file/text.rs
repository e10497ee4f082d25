//! JSON for people: short lists on one line, options that differ from their defaults only.

use ishigaki::WorldOptions;
use serde::{Serialize, Serializer};
use serde_json::Value;

/// Objects and lists that fit into this many characters stay on one line.
const LINE: usize = 100;

/// Lays out compact JSON: two spaces of indentation, what fits on a line on one line.
pub(super) fn pretty(compact: &str) -> String {
    let bytes = compact.as_bytes();
    let ends = matching_ends(bytes);
    let mut out = String::with_capacity(compact.len() * 2);
    let mut depth = 0;
    let mut i = 0;
    // Index of the end of the bracket that is being written on one line.
    let mut flat_until = 0;
    while i < bytes.len() {
        match bytes[i] {
            b'"' => {
                let end = ends[i];
                out.push_str(&compact[i..=end]);
                i = end;
            }
            open @ (b'{' | b'[') => {
                let end = ends[i];
                let brace = open == b'{';
                let short = depth > 0 && end - i + 2 * depth < LINE;
                if i >= flat_until && (short || end == i + 1) {
                    flat_until = end;
                }
                out.push(open as char);
                if i >= flat_until {
                    depth += 1;
                    new_line(&mut out, depth);
                } else if brace && end > i + 1 {
                    out.push(' ');
                }
            }
            close @ (b'}' | b']') => {
                if i > flat_until {
                    depth -= 1;
                    new_line(&mut out, depth);
                } else if close == b'}' && !out.ends_with('{') {
                    out.push(' ');
                }
                out.push(close as char);
            }
            b',' if i > flat_until => {
                out.push(',');
                new_line(&mut out, depth);
            }
            b',' => out.push_str(", "),
            b':' => out.push_str(": "),
            // 1.0 is 1 for people; both read back as the same number.
            b'.' if matches!(bytes[i..], [_, b'0', b',' | b']' | b'}', ..]) => i += 1,
            other => out.push(other as char),
        }
        i += 1;
    }
    out.push('\n');
    out
}

fn new_line(out: &mut String, depth: usize) {
    out.push('\n');
    for _ in 0..depth {
        out.push_str("  ");
    }
}

/// For every opening bracket or quote the index of its end.
fn matching_ends(bytes: &[u8]) -> Vec<usize> {
    let mut ends = vec![0; bytes.len()];
    let mut open = Vec::new();
    let mut i = 0;
    while i < bytes.len() {
        match bytes[i] {
            b'"' => {
                let start = i;
                i += 1;
                while i < bytes.len() && bytes[i] != b'"' {
                    i += if bytes[i] == b'\\' { 2 } else { 1 };
                }
                ends[start] = i;
            }
            b'{' | b'[' => open.push(i),
            b'}' | b']' => {
                if let Some(start) = open.pop() {
                    ends[start] = i;
                }
            }
            _ => {}
        }
        i += 1;
    }
    ends
}

/// Writes only the options that differ from their defaults.
pub(super) fn only_changed<S: Serializer>(options: &WorldOptions, serializer: S) -> Result<S::Ok, S::Error> {
    use serde::ser::Error;
    let mut value = serde_json::to_value(options).map_err(S::Error::custom)?;
    let default = serde_json::to_value(WorldOptions::default()).map_err(S::Error::custom)?;
    remove_equal(&mut value, &default);
    shorten(&mut value);
    value.serialize(serializer)
}

fn remove_equal(value: &mut Value, default: &Value) {
    if let (Value::Object(map), Value::Object(defaults)) = (value, default) {
        map.retain(|key, v| defaults.get(key) != Some(v));
        for (key, v) in map.iter_mut() {
            if let Some(d) = defaults.get(key) {
                remove_equal(v, d);
            }
        }
    }
}

/// An f32 inside a `Value` is an f64 with a long tail: 1.4 is 1.399999976158142. Gives it the shortest digits that
/// read back as the same f32.
pub(crate) fn shorten(value: &mut Value) {
    match value {
        Value::Number(n) if n.is_f64() => {
            if let Some(short) = n.as_f64().and_then(|f| (f as f32).to_string().parse::<f64>().ok()) {
                *value = Value::from(short);
            }
        }
        Value::Array(items) => items.iter_mut().for_each(shorten),
        Value::Object(map) => map.values_mut().for_each(shorten),
        _ => {}
    }
}
