//! What others published: `data/simbenchmark.csv`, one line for each figure, with its source at the head.

use crate::{Error, Result};

const TEXT: &str = include_str!("../../../data/simbenchmark.csv");

/// A figure that an engine was published with.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    pub engine: &'static str,
    /// Of the solver, where the source says it.
    pub iterations: Option<f64>,
    /// An error, or the steps that a tower stood.
    pub value: f64,
}

/// All figures of a task, in the order of the file.
pub fn of(task: &str) -> Result<Vec<Figure>> {
    let lines = TEXT.lines().filter(|line| !line.is_empty() && !line.starts_with('#'));
    lines.filter(|line| line.split(',').next() == Some(task)).map(figure).collect()
}

/// The figure of one engine for a task; `None` where it has none.
pub fn best(task: &str, engine: &str, better: fn(f64, f64) -> f64) -> Result<Option<f64>> {
    Ok(of(task)?.into_iter().filter(|f| f.engine == engine).map(|f| f.value).reduce(better))
}

fn figure(line: &'static str) -> Result<Figure> {
    let wrong = || Error::Missing(format!("data/simbenchmark.csv: `{line}` is no figure"));
    let number = |text: &str| text.parse::<f64>().map_err(|_| wrong());
    let [_, engine, iterations, value] = line.split(',').collect::<Vec<_>>()[..] else { return Err(wrong()) };
    let iterations = if iterations.is_empty() { None } else { Some(number(iterations)?) };
    Ok(Figure { engine, iterations, value: number(value)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_is_a_figure_of_a_known_task() {
        let tasks = ["rolling-oblique", "rolling-y", "bouncing", "666", "666-elastic", "kapla"];
        let count: usize = tasks.iter().map(|task| of(task).unwrap().len()).sum();
        assert_eq!(count, TEXT.lines().filter(|line| !line.starts_with('#')).count());
        for task in tasks {
            assert!(of(task).unwrap().iter().all(|f| f.value > 0.0));
            assert!(best(task, "RaiSim", f64::min).unwrap().is_some(), "{task}");
        }
        assert_eq!(best("kapla", "RaiSim", f64::max).unwrap(), Some(60000.0));
        assert_eq!(best("bouncing", "MuJoCo", f64::min).unwrap(), None);
    }
}
