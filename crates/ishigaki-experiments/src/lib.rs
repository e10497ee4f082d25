//! The talk as a laboratory: one experiment for each of its claims, run on the engine itself.
//!
//! An experiment is a file in `experiments/`: a name, the rows of the talk it is about, and a function that fills a
//! [`Lab`] with charts and gives a [`Verdict`]. [`Experiment::perform`] makes of it a plot (SVG and PNG from one
//! drawing), the data as CSV, and the verdict: the talk says, predicted, measured.
//!
//! ```
//! let experiment = ishigaki_experiments::find("free-fall").expect("it is in the list");
//! let output = experiment.perform(ishigaki_experiments::Effort::Quick, &mut |_, _| {})?;
//! assert!(output.verdict.agrees() && output.svg.starts_with("<svg"));
//! # Ok::<(), ishigaki_experiments::Error>(())
//! ```

pub mod chart;
mod course;
mod direct;
mod experiments;
pub mod index;
mod lab;
pub mod markdown;
mod picture;
mod setup;
pub mod talk;
mod verdict;

pub use experiments::list;
pub use lab::{Effort, Lab};
pub use verdict::{Expected, Figure, Verdict};

/// What can go wrong in an experiment.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The engine refused a definition.
    #[error(transparent)]
    Engine(#[from] ishigaki::Error),
    /// A named scene or its parameters.
    #[error(transparent)]
    Scene(#[from] ishigaki_scenes::SceneError),
    /// The plot could not be drawn.
    #[error("the plot of {name} could not be drawn: {reason}")]
    Picture {
        /// Of the experiment.
        name: &'static str,
        /// As the plot library says it.
        reason: String,
    },
    /// What the experiment needs did not happen.
    #[error("{0}")]
    Missing(String),
}

/// Results of experiments.
pub type Result<T> = std::result::Result<T, Error>;

/// One claim of the talk, and how it is put to the test.
#[derive(Clone, Copy, Debug)]
pub struct Experiment {
    /// In lower case with hyphens: the name of its files.
    pub name: &'static str,
    /// Rows of [`talk::ROWS`] it is about; empty for what goes beyond the talk.
    pub rows: &'static [&'static str],
    /// What is looked at, in a line.
    pub title: &'static str,
    /// Fills the charts and judges.
    pub run: fn(&mut Lab<'_>) -> Result<Verdict>,
}

/// What an experiment leaves behind.
#[derive(Clone, Debug)]
pub struct Output {
    /// The plot.
    pub svg: String,
    /// The same plot, rasterized.
    pub png: Vec<u8>,
    /// The data of the plot, one line for each point.
    pub csv: String,
    /// The talk says, predicted, measured.
    pub verdict: Verdict,
}

impl Experiment {
    /// Runs it. `progress` hears the part that is done, in [0, 1], and what is being done.
    ///
    /// # Errors
    /// What the engine, the scenes or the plot library refuse.
    pub fn perform(&self, effort: Effort, progress: &mut dyn FnMut(f64, &str)) -> Result<Output> {
        let mut lab = Lab::new(effort, progress);
        let verdict = (self.run)(&mut lab)?;
        let charts = lab.into_charts();
        let (svg, png) =
            picture::draw(self.title, &charts).map_err(|reason| Error::Picture { name: self.name, reason })?;
        Ok(Output { svg, png, csv: chart::csv(&charts), verdict })
    }
}

/// The experiment of this name.
pub fn find(name: &str) -> Option<&'static Experiment> {
    list().iter().copied().find(|experiment| experiment.name == name)
}
