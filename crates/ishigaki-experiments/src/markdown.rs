//! A verdict as Markdown: a table that a document can include.

use crate::verdict::{Expected, Verdict, short};
use std::fmt::Write;

/// The claim, a table of figures (expected, measured, whether it holds), and the note. Ends with a line break.
pub fn verdict(verdict: &Verdict) -> String {
    let mut text = format!("**The talk says:** {}.\n\n", escaped(verdict.talk));
    text.push_str("| Figure | Expected | Measured | |\n|---|---|---|---|\n");
    for figure in &verdict.figures {
        let unit = if figure.unit.is_empty() { String::new() } else { format!(" {}", figure.unit) };
        let open = figure.expected == Expected::Open;
        let expected = if open { "–".to_string() } else { format!("{}{unit}", figure.expected) };
        let mark = match (open, figure.holds()) {
            (true, _) => "",
            (false, true) => "✓",
            (false, false) => "**differs**",
        };
        let (what, measured) = (escaped(&figure.what), short(figure.measured));
        let _ = writeln!(text, "| {what} | {} | {measured}{} | {mark} |", escaped(&expected), escaped(&unit));
    }
    if !verdict.note.is_empty() {
        let _ = write!(text, "\n{}\n", escaped(&verdict.note));
    }
    text
}

/// What Markdown would take for its own.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '|' | '*' | '_' | '<' | '[' | ']' | '\\' => out.extend(['\\', c]),
            _ => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_become_rows_of_a_table() {
        let seen = Verdict::on("a | b").near("x", "m", 2.0, 0.1, 2.05).at_most("y", "", 1.0, 3.0).open("z", "s", 4.0);
        let text = verdict(&seen.note("c_d"));
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "**The talk says:** a \\| b.");
        assert_eq!(lines[4], "| x | 2 ± 0.1 m | 2.05 m | ✓ |");
        assert_eq!(lines[5], "| y | ≤ 1 | 3 | **differs** |");
        assert_eq!(lines[6], "| z | – | 4 s |  |");
        assert_eq!(lines.last(), Some(&"c\\_d"));
    }
}
