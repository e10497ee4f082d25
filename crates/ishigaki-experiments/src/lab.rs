//! What an experiment works with: how thorough it should be, a place for its charts, a voice for its progress.

use crate::chart::Chart;
use std::time::{Duration, Instant};

/// How much an experiment should take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// All of it: a few seconds in a release build.
    Full,
    /// A short version that shows that it works: for tests.
    Quick,
}

/// The bench of an experiment.
pub struct Lab<'a> {
    effort: Effort,
    charts: Vec<Chart>,
    progress: &'a mut dyn FnMut(f64, &str),
}

impl<'a> Lab<'a> {
    pub(crate) fn new(effort: Effort, progress: &'a mut dyn FnMut(f64, &str)) -> Self {
        Self { effort, charts: Vec::new(), progress }
    }

    /// One of two amounts, by the effort.
    pub fn choose<T>(&self, full: T, quick: T) -> T {
        match self.effort {
            Effort::Full => full,
            Effort::Quick => quick,
        }
    }

    /// Says that `part` of the work, in [0, 1], is done, and what comes now.
    pub fn progress(&mut self, part: f64, now: &str) {
        (self.progress)(part, now);
    }

    /// Adds a chart below the others; its data go to the CSV.
    pub fn chart(&mut self, chart: Chart) {
        self.charts.push(chart);
    }

    /// How long `work` takes on this machine, s.
    #[expect(clippy::disallowed_methods, reason = "the ban is the engine's; an experiment may measure time")]
    pub fn time<T>(&self, work: impl FnOnce() -> T) -> (T, f64) {
        let start = Instant::now();
        let result = work();
        (result, start.elapsed().max(Duration::from_nanos(1)).as_secs_f64())
    }

    pub(crate) fn into_charts(self) -> Vec<Chart> {
        self.charts
    }
}
