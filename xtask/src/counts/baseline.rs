//! The stored figures: JSON with one figure in a line, which is all that is read back.

use super::Counts;
use std::fmt::Write;
use std::path::Path;

/// Figures and who made them.
pub struct Baseline {
    /// As `rustc --version` says.
    pub compiler: String,
    pub counts: Counts,
}

impl Baseline {
    pub fn read(file: &Path) -> Result<Self, String> {
        let text = std::fs::read_to_string(file);
        let text = text.map_err(|e| format!("{}: {e}; make it: cargo xtask counts --bless", file.display()))?;
        Self::parse(&text).ok_or_else(|| format!("{}: not as `cargo xtask counts --bless` writes it", file.display()))
    }

    pub fn write(&self, file: &Path) -> Result<(), String> {
        std::fs::write(file, self.text()).map_err(|e| format!("{}: {e}", file.display()))
    }

    fn text(&self) -> String {
        let mut text = format!("{{\n  \"compiler\": \"{}\"", self.compiler);
        for (scene, kernels) in &self.counts {
            let _ = write!(text, ",\n  \"{scene}\": {{");
            for (i, (kernel, count)) in kernels.iter().enumerate() {
                let _ = write!(text, "{}\n    \"{kernel}\": {count}", if i == 0 { "" } else { "," });
            }
            text += "\n  }";
        }
        text + "\n}\n"
    }

    fn parse(text: &str) -> Option<Self> {
        let mut found = Self { compiler: String::new(), counts: Counts::new() };
        let mut scene = String::new();
        for line in text.lines() {
            let Some((name, value)) = line.trim().trim_end_matches(',').split_once("\": ") else { continue };
            let name = name.trim_matches('"').to_string();
            match value {
                "{" => scene = name,
                _ if scene.is_empty() => found.compiler = value.trim_matches('"').to_string(),
                _ => {
                    found.counts.entry(scene.clone()).or_default().insert(name, value.parse().ok()?);
                }
            }
        }
        (!found.compiler.is_empty() && !found.counts.is_empty()).then_some(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn what_is_written_is_read() {
        let kernels = BTreeMap::from([("joint trees: factors".to_string(), 7), ("step".to_string(), 12_345)]);
        let counts = Counts::from([("a b".to_string(), kernels.clone()), ("c".to_string(), kernels)]);
        let baseline = Baseline { compiler: "rustc 1.95.0 (59807616e 2026-04-14)".into(), counts };
        let read = Baseline::parse(&baseline.text()).unwrap();
        assert_eq!((read.compiler, read.counts), (baseline.compiler, baseline.counts));
        assert!(Baseline::parse("{}").is_none());
    }
}
