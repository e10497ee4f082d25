//! The talk says, predicted, measured: figures that are held to what was expected of them.

use serde::Serialize;
use std::fmt;

/// What a figure should be.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Expected {
    /// This value, give or take `tolerance`.
    Near {
        /// The prediction.
        value: f64,
        /// How far from it still counts.
        tolerance: f64,
    },
    /// No more than this.
    AtMost(f64),
    /// No less than this.
    AtLeast(f64),
    /// Nobody said: it is only reported.
    Open,
}

/// A number that was measured, and what was expected of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figure {
    /// What was measured.
    pub what: String,
    /// Of the numbers; empty for counts and ratios.
    pub unit: &'static str,
    /// What it should be.
    pub expected: Expected,
    /// What it is.
    pub measured: f64,
}

impl Figure {
    /// Whether it is what it should be. Not a number never is.
    pub fn holds(&self) -> bool {
        match self.expected {
            Expected::Near { value, tolerance } => (self.measured - value).abs() <= tolerance,
            Expected::AtMost(most) => self.measured <= most,
            Expected::AtLeast(least) => self.measured >= least,
            Expected::Open => self.measured.is_finite(),
        }
    }
}

/// The outcome of an experiment.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// The talk's claim, in our words.
    pub talk: &'static str,
    /// What was predicted and what was measured.
    pub figures: Vec<Figure>,
    /// Why they differ, what is corrected, what else was seen; may be empty.
    pub note: String,
}

impl Verdict {
    /// A verdict on a claim.
    pub fn on(talk: &'static str) -> Self {
        Self { talk, figures: Vec::new(), note: String::new() }
    }

    fn figure(mut self, what: impl Into<String>, unit: &'static str, expected: Expected, measured: f64) -> Self {
        self.figures.push(Figure { what: what.into(), unit, expected, measured });
        self
    }

    /// Should be `value`, give or take `tolerance`.
    #[must_use]
    pub fn near(self, what: impl Into<String>, unit: &'static str, value: f64, tolerance: f64, measured: f64) -> Self {
        self.figure(what, unit, Expected::Near { value, tolerance }, measured)
    }

    /// Should not exceed `most`.
    #[must_use]
    pub fn at_most(self, what: impl Into<String>, unit: &'static str, most: f64, measured: f64) -> Self {
        self.figure(what, unit, Expected::AtMost(most), measured)
    }

    /// Should reach `least`.
    #[must_use]
    pub fn at_least(self, what: impl Into<String>, unit: &'static str, least: f64, measured: f64) -> Self {
        self.figure(what, unit, Expected::AtLeast(least), measured)
    }

    /// Is only reported.
    #[must_use]
    pub fn open(self, what: impl Into<String>, unit: &'static str, measured: f64) -> Self {
        self.figure(what, unit, Expected::Open, measured)
    }

    /// Adds to what is to be said about it.
    #[must_use]
    pub fn note(mut self, text: impl AsRef<str>) -> Self {
        if !self.note.is_empty() {
            self.note.push(' ');
        }
        self.note.push_str(text.as_ref());
        self
    }

    /// Whether every figure is what it should be.
    pub fn agrees(&self) -> bool {
        self.figures.iter().all(Figure::holds)
    }

    /// Each figure's expectation.
    pub fn predicted(&self) -> String {
        join(self.figures.iter().filter(|f| f.expected != Expected::Open), |f| {
            format!("{} {}{}", f.what, f.expected, unit(f))
        })
    }

    /// Each figure's value.
    pub fn measured(&self) -> String {
        join(self.figures.iter(), |f| {
            let mark = if f.holds() { "" } else { " (!)" };
            format!("{} {}{}{mark}", f.what, short(f.measured), unit(f))
        })
    }
}

/// `the talk says … | predicted … | measured … | agrees`.
impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let outcome = if self.agrees() { "they agree" } else { "they differ" };
        let (predicted, measured) = (self.predicted(), self.measured());
        write!(f, "the talk says: {} | predicted: {predicted} | measured: {measured} | {outcome}", self.talk)?;
        if !self.note.is_empty() {
            write!(f, " | {}", self.note)?;
        }
        Ok(())
    }
}

impl fmt::Display for Expected {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Near { value, tolerance } if *tolerance == 0.0 => write!(f, "{}", short(*value)),
            Self::Near { value, tolerance } => write!(f, "{} ± {}", short(*value), short(*tolerance)),
            Self::AtMost(most) => write!(f, "≤ {}", short(*most)),
            Self::AtLeast(least) => write!(f, "≥ {}", short(*least)),
            Self::Open => write!(f, "–"),
        }
    }
}

fn join<'a>(figures: impl Iterator<Item = &'a Figure>, text: impl Fn(&Figure) -> String) -> String {
    figures.map(text).collect::<Vec<_>>().join("; ")
}

fn unit(figure: &Figure) -> String {
    if figure.unit.is_empty() { String::new() } else { format!(" {}", figure.unit) }
}

/// Four significant digits; powers of ten where zeros would be counted.
pub(crate) fn short(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || !value.is_finite() {
        format!("{value}")
    } else if value.fract() == 0.0 && size < 1e6 {
        format!("{value:.0}")
    } else if (1e-3..1e6).contains(&size) {
        let decimals = (3 - size.log10().floor() as i32).clamp(0, 6) as usize;
        let text = format!("{value:.decimals$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_string() } else { text }
    } else {
        format!("{value:.1e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (value, text) in [(0.0, "0"), (192.0, "192"), (2.0417, "2.042"), (1.955_29, "1.955"), (0.05, "0.05")] {
            assert_eq!(short(value), text);
        }
        assert_eq!(short(1.234e-7), "1.2e-7");
        assert_eq!(short(1_234_567.8), "1.2e6");
        assert_eq!(short(1234.56), "1235");
    }

    #[test]
    fn figures_hold_what_was_expected() {
        let verdict = Verdict::on("x").near("a", "m", 2.0, 0.1, 2.05).at_most("b", "", 1.0, 0.5).open("c", "", 3.0);
        assert!(verdict.agrees());
        assert_eq!(verdict.predicted(), "a 2 ± 0.1 m; b ≤ 1");
        assert_eq!(verdict.measured(), "a 2.05 m; b 0.5; c 3");
        let verdict = verdict.at_least("d", "", 1.0, f64::NAN);
        assert!(!verdict.agrees());
        assert!(verdict.to_string().ends_with("they differ"));
    }
}
