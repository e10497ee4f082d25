//! Mutations that keep most of an input right, so that what is wrong gets far.

use serde_json::{Map, Value};

/// Numbers at the edges of what f32 and the formats can hold.
const EXTREMES: [&str; 24] = [
    "0",
    "-0.0",
    "1",
    "-1",
    "0.5",
    "2",
    "1e-3",
    "-1e-3",
    "1e-38",
    "-1e-38",
    "1e-45",
    "1e6",
    "1e7",
    "1e19",
    "1e38",
    "-1e38",
    "3.5e38",
    "1e999",
    "-1e999",
    "2147483648",
    "4294967295",
    "4294967296",
    "18446744073709551616",
    "-2147483649",
];

/// Frames what is no JSON value: `1e999`, a key that is there twice.
const MARK: char = '\u{1}';

/// A stream of numbers (SplitMix64, Steele et al. 2014).
pub struct Random(u64);

impl Random {
    /// The stream of case `case` in a run with a seed.
    pub fn new(seed: u64, case: u64) -> Self {
        let mut random = Self(seed ^ case.wrapping_mul(0xd134_2543_de82_ef95));
        random.next();
        random
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// In [0, n); 0 if n is 0.
    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }

    fn pick<'a, T>(&mut self, items: &'a [T]) -> &'a T {
        &items[self.below(items.len())]
    }
}

/// One to three changes to the tree of a JSON text: extreme numbers, other types, lost and doubled entries, values
/// from elsewhere in the tree.
pub fn json(random: &mut Random, original: &Value) -> String {
    let mut tree = original.clone();
    for _ in 0..=random.below(3) {
        let donor = nth(&tree, &mut random.below(count(&tree))).cloned().unwrap_or(Value::Null);
        let mut place = random.below(count(&tree));
        change(random, &mut tree, &mut place, &donor);
    }
    let mark = "\\u0001";
    tree.to_string().replace(&format!("\"{mark}"), "").replace(&format!("{mark}\""), "").replace(mark, "\"")
}

/// Nodes of a tree, the root included.
fn count(tree: &Value) -> usize {
    1 + match tree {
        Value::Array(items) => items.iter().map(count).sum(),
        Value::Object(map) => map.values().map(count).sum(),
        _ => 0,
    }
}

/// The nth node, depth first.
fn nth<'a>(tree: &'a Value, n: &mut usize) -> Option<&'a Value> {
    if *n == 0 {
        return Some(tree);
    }
    *n -= 1;
    match tree {
        Value::Array(items) => items.iter().find_map(|item| nth_or_pass(item, n)),
        Value::Object(map) => map.values().find_map(|item| nth_or_pass(item, n)),
        _ => None,
    }
}

fn nth_or_pass<'a>(tree: &'a Value, n: &mut usize) -> Option<&'a Value> {
    let size = count(tree);
    if *n < size {
        return nth(tree, n);
    }
    *n -= size;
    None
}

/// Changes the nth node, or its entry in the list or object around it. True when it is done.
fn change(random: &mut Random, tree: &mut Value, n: &mut usize, donor: &Value) -> bool {
    if *n == 0 {
        *tree = replacement(random, tree, donor);
        return true;
    }
    *n -= 1;
    match tree {
        Value::Array(items) => {
            for i in 0..items.len() {
                if *n == 0 && random.below(6) == 0 {
                    if random.below(2) == 0 {
                        items.remove(i);
                    } else {
                        items.insert(i, items[i].clone());
                    }
                    return true;
                }
                if change(random, &mut items[i], n, donor) {
                    return true;
                }
            }
        }
        Value::Object(map) => {
            let keys: Vec<String> = map.keys().cloned().collect();
            for key in keys {
                if *n == 0 && random.below(6) == 0 {
                    change_entry(random, map, &key, donor);
                    return true;
                }
                if map.get_mut(&key).is_some_and(|value| change(random, value, n, donor)) {
                    return true;
                }
            }
        }
        _ => {}
    }
    false
}

fn change_entry(random: &mut Random, map: &mut Map<String, Value>, key: &str, donor: &Value) {
    let value = map.get(key).cloned().unwrap_or(Value::Null);
    match random.below(4) {
        0 => {
            map.remove(key);
        }
        // The same key twice: unmarked, `\1key\1` becomes `"key"` beside the first.
        1 => {
            map.insert(format!("{MARK}{MARK}{key}{MARK}{MARK}"), value);
        }
        2 => {
            map.remove(key);
            map.insert(format!("{key}_"), value);
        }
        _ => {
            map.insert(key.to_string(), donor.clone());
        }
    }
}

fn replacement(random: &mut Random, old: &Value, donor: &Value) -> Value {
    let raw = |text: &str| Value::String(format!("{MARK}{text}{MARK}"));
    // One in eight gets another type, and is mostly refused; the rest goes further.
    match (random.below(8), old) {
        (0..=2, Value::Number(_)) => raw(random.pick::<&str>(&EXTREMES)),
        (3..=5, Value::Number(n)) => scaled(random, n.as_f64().unwrap_or(0.0), n.is_f64()),
        (6, Value::Number(_)) if donor.is_number() => donor.clone(),
        (0..=6, Value::Bool(b)) => Value::Bool(!b),
        (0..=2, Value::String(_)) => {
            Value::String(["", "world", "body0", "ground", "\u{0}", "ü…\n", "a\"b"][random.below(7)].into())
        }
        (3..=6, Value::String(_)) if donor.is_string() => donor.clone(),
        (0..=5, Value::Array(items)) => {
            let mut items = items.clone();
            items.iter_mut().for_each(|item| {
                if let (0, Some(x)) = (random.below(2), item.as_f64()) {
                    *item = scaled(random, x, true);
                }
            });
            Value::Array(items)
        }
        _ => match random.below(9) {
            0 => Value::Null,
            1 => Value::Bool(true),
            2 => Value::from(0),
            3 => Value::from("x"),
            4 => Value::Array(Vec::new()),
            5 => Value::Object(Map::new()),
            6 => Value::Array(vec![old.clone(); 3]),
            _ => donor.clone(),
        },
    }
}

/// Something like `x`: from −x to 10 x, or a little beside it.
fn scaled(random: &mut Random, x: f64, fraction: bool) -> Value {
    let factor = [-1.0, 0.0, 0.001, 0.5, 0.999, 1.001, 2.0, 10.0][random.below(8)];
    let shift = [0.0, 0.0, 0.0, 1e-3, 1.0, -1.0][random.below(6)];
    let changed = x * factor + shift;
    if fraction { Value::from(changed) } else { Value::from(changed as i64) }
}

/// One to four changes to a text that is mostly left alone: extreme numbers, lost, doubled, moved and broken pieces.
pub fn text(random: &mut Random, original: &[u8]) -> Vec<u8> {
    let mut bytes = original.to_vec();
    for _ in 0..=random.below(4) {
        let at = random.below(bytes.len());
        let end = (at + 1 + random.below(40)).min(bytes.len());
        match random.below(16) {
            0..=11 => replace_number(random, &mut bytes, at),
            12 => drop(bytes.drain(at..end)),
            13 => {
                let piece = bytes[at..end].to_vec();
                let to = random.below(bytes.len());
                bytes.splice(to..to, piece);
            }
            14 if at < end => bytes[at] = *random.pick(b"<>/\"= 0-.eE\n&;"),
            _ if at < end => bytes[at] ^= 1 << random.below(8),
            _ => {}
        }
    }
    bytes
}

/// The first number after `at` becomes another or an extreme one.
fn replace_number(random: &mut Random, bytes: &mut Vec<u8>, at: usize) {
    let in_number = |b: &u8| b.is_ascii_digit() || b".-+eE".contains(b);
    let Some(start) = bytes[at..].iter().position(u8::is_ascii_digit).map(|i| at + i) else { return };
    let length = bytes[start..].iter().take_while(|b| in_number(b)).count();
    let old = std::str::from_utf8(&bytes[start..start + length]).ok().and_then(|digits| digits.parse::<f64>().ok());
    let new = match (random.below(3), old) {
        (0, _) | (_, None) => {
            random.pick(&[EXTREMES.as_slice(), &["nan", "inf", "-inf", "", "1 2"]].concat()).to_string()
        }
        (_, Some(x)) => scaled(random, x, true).to_string(),
    };
    bytes.splice(start..start + length, new.bytes());
}

/// One to four broken bytes, or a cut.
pub fn bytes(random: &mut Random, original: &[u8]) -> Vec<u8> {
    let mut bytes = original.to_vec();
    if random.below(4) == 0 {
        bytes.truncate(random.below(original.len()));
    }
    for _ in 0..=random.below(4) {
        let at = random.below(bytes.len());
        if let Some(byte) = bytes.get_mut(at) {
            *byte = random.next() as u8;
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_case_is_the_same_mutation() {
        let tree: Value = serde_json::from_str(r#"{"bodies":[{"mass":1.5,"name":"a"}],"dt":0.1}"#).unwrap();
        let all = |seed| (0..200).map(|i| json(&mut Random::new(seed, i), &tree)).collect::<Vec<_>>();
        assert_eq!(all(1), all(1));
        assert_ne!(all(1), all(2));
    }

    #[test]
    fn mutations_reach_what_json_values_cannot_hold() {
        let tree: Value = serde_json::from_str(r#"{"dt":0.1,"steps":5}"#).unwrap();
        let texts: Vec<String> = (0..2000).map(|i| json(&mut Random::new(1, i), &tree)).collect();
        assert!(texts.iter().any(|t| t.contains(":1e999,")), "no infinity");
        assert!(texts.iter().any(|t| t.matches("\"dt\"").count() == 2), "no doubled key");
        assert!(texts.iter().all(|t| !t.contains("u0001")), "a mark was left");
        let right = texts.iter().filter(|t| serde_json::from_str::<Value>(t).is_ok()).count();
        assert!(right > 1000, "only {right} of 2000 are still JSON");
    }

    #[test]
    fn every_node_can_be_found() {
        let tree: Value = serde_json::from_str(r#"[1,[2,{"a":3}],4]"#).unwrap();
        assert_eq!(count(&tree), 7);
        let found: Vec<_> = (0..8).map(|mut n| nth(&tree, &mut n).cloned()).collect();
        assert_eq!(found[1], Some(Value::from(1)));
        assert_eq!(found[5], Some(Value::from(3)));
        assert_eq!(found[6], Some(Value::from(4)));
        assert_eq!(found[7], None);
    }
}
