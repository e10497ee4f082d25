//! Rows of the scaling series: table, stages, JSON, CSV.

use super::{Axis, Series, distinct};
use crate::lockstep::{Player, Run};
use crate::report::{REFERENCE, quoted};
use crate::stats::{exponent, ratios, spread};
use serde::Serialize;
use std::fmt::Write;

/// A scene of a series.
pub struct Point<'a> {
    pub series: &'a Series,
    /// What grows.
    pub number: u32,
    pub scene: &'a str,
    /// Dynamic ones.
    pub bodies: usize,
    pub sleep: bool,
}

/// One engine with so many threads at one point of a series.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Name of the series.
    pub series: String,
    /// What grows along it.
    pub axis: Axis,
    /// Where on it: bodies as asked for, or bodies in an island.
    pub number: u32,
    /// As `--scenes` takes it.
    pub scene: String,
    /// Whether bodies may fall asleep.
    pub sleep: bool,
    /// Dynamic bodies.
    pub bodies: usize,
    /// Engine.
    pub engine: String,
    /// Threads it used.
    pub threads: u32,
    /// Islands awake in the last step, if the engine says.
    pub islands: Option<usize>,
    /// Pairs with contact points in the last step, if the engine says.
    pub contacts: Option<usize>,
    /// Bodies awake after the last step, if the engine says.
    pub awake: Option<usize>,
    /// Median of the turns, ms for each step.
    pub ms_median: Option<f64>,
    /// The same for each body, µs.
    pub us_per_body: Option<f64>,
    /// Median over turns of the time of the same engine with the fewest threads over its own.
    pub speedup: Option<f64>,
    /// Median over turns of its time over that of Box3D with as many threads.
    pub ratio_to_box3d: Option<f64>,
    /// 16th percentile of the same.
    pub ratio_low: Option<f64>,
    /// 84th percentile of the same.
    pub ratio_high: Option<f64>,
    /// Peak memory, less that with an empty world, for each body, bytes.
    pub bytes_per_body: Option<f64>,
    /// Deepest overlap at the end, m; null if not finite.
    pub penetration_max: f64,
    /// Whether no body is far from its start at the end.
    pub stands: bool,
    /// Steps it took.
    pub steps: u32,
    /// Why it took fewer than it should.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
    /// Milliseconds of a step in each stage, with --phases.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub phases: Vec<(&'static str, f64)>,
}

impl Row {
    /// Whether it is this player's.
    pub fn is_of(&self, player: &Player) -> bool {
        self.engine == player.kind.name && self.threads == player.threads
    }

    /// Series, engine and threads: a line of the plot.
    pub fn line(&self) -> (&str, &str, u32) {
        (&self.series, &self.engine, self.threads)
    }
}

/// A row for each run. `memory` says MiB of an engine with so many threads, and is asked once for each engine.
pub fn rows(point: &Point, runs: &[Run], memory: impl Fn(&str, u32) -> Option<f64>) -> Vec<Row> {
    let mut rows: Vec<Row> = runs.iter().map(|run| row(point, run, runs)).collect();
    for i in 0..rows.len() {
        let earlier = rows[..i].iter().find(|r| r.engine == rows[i].engine);
        rows[i].bytes_per_body = match earlier {
            Some(row) => row.bytes_per_body,
            // What it would use without a limit is not known.
            None if rows[i].note.is_some() => None,
            None => memory(&rows[i].engine, rows[i].threads).map(|mib| mib * 1048576.0 / point.bodies as f64),
        };
    }
    rows
}

fn row(point: &Point, run: &Run, runs: &[Run]) -> Row {
    let times = |run: &Run| run.turns.iter().map(|t| t.ms).collect::<Vec<f64>>();
    let ms_median = spread(&times(run)).map(|s| s.median);
    let over = |other: &Run| spread(&ratios(&times(run), &times(other)));
    let fewest = runs.iter().filter(|r| r.engine == run.engine).min_by_key(|r| r.threads);
    // An engine without threads stands against the reference with one.
    let reference = runs.iter().find(|r| r.engine == REFERENCE && r.threads == run.threads);
    let ratio = reference.and_then(over);
    let counts = run.counts;
    Row {
        series: point.series.name.to_string(),
        axis: point.series.axis,
        number: point.number,
        scene: point.scene.to_string(),
        sleep: point.sleep,
        bodies: point.bodies,
        engine: run.engine.to_string(),
        threads: run.threads,
        islands: counts.map(|c| c.islands),
        contacts: counts.map(|c| c.contacts),
        awake: counts.map(|c| point.bodies - c.asleep),
        ms_median,
        us_per_body: ms_median.map(|ms| 1e3 * ms / point.bodies as f64),
        speedup: fewest.and_then(|f| spread(&ratios(&times(f), &times(run)))).map(|s| s.median),
        ratio_to_box3d: ratio.map(|r| r.median),
        ratio_low: ratio.map(|r| r.low),
        ratio_high: ratio.map(|r| r.high),
        bytes_per_body: None,
        penetration_max: run.quality.penetration_max,
        stands: run.quality.stands,
        steps: run.steps,
        note: run.note.clone(),
        phases: run.phases.clone(),
    }
}

/// "1 thread", "2 threads".
pub fn with_threads(threads: u32) -> String {
    format!("{threads} thread{}", if threads == 1 { "" } else { "s" })
}

/// Head of the table.
pub fn table_head() -> String {
    format!(
        "{:<9} {:>7} {:>7} {:>7} {:>8} {:>7} {:<9} {:>2} {:>9} {:>9} {:>7} {:>6} {:>13} {:>7} {:>7}",
        "series",
        "number",
        "bodies",
        "islands",
        "contacts",
        "awake",
        "engine",
        "th",
        "ms/step",
        "µs/body",
        "speedup",
        "ratio",
        "16…84 %",
        "B/body",
        "pen mm"
    )
}

/// A line of the table.
pub fn table_line(row: &Row) -> String {
    let number = |value: Option<f64>, digits: usize| value.map_or("–".to_string(), |v| format!("{v:.digits$}"));
    let count = |value: Option<usize>| value.map_or("–".to_string(), |v| v.to_string());
    let range = match (row.ratio_low, row.ratio_high) {
        (Some(low), Some(high)) => format!("{low:.2}…{high:.2}"),
        _ => "–".to_string(),
    };
    let mut line = format!(
        "{:<9} {:>7} {:>7} {:>7} {:>8} {:>7} {:<9} {:>2} {:>9} {:>9} {:>7} {:>6} {:>13} {:>7} {:>7}",
        row.series,
        row.number,
        row.bodies,
        count(row.islands),
        count(row.contacts),
        count(row.awake),
        row.engine,
        row.threads,
        number(row.ms_median, 3),
        number(row.us_per_body, 4),
        number(row.speedup, 2),
        number(row.ratio_to_box3d, 2),
        range,
        number(row.bytes_per_body, 0),
        if row.penetration_max.is_finite() { format!("{:.1}", 1e3 * row.penetration_max) } else { "∞".to_string() },
    );
    if let Some(note) = &row.note {
        let _ = write!(line, "  {note}");
    }
    line
}

/// For each series, engine and number of threads: nanoseconds for each body and step, by stage and number, and the
/// power of the number that they grow with.
pub fn stage_tables(rows: &[Row]) -> String {
    let told: Vec<&Row> = rows.iter().filter(|r| !r.phases.is_empty()).collect();
    let lines = distinct(told.iter().map(|r| r.line()));
    let of_line = |line| told.iter().copied().filter(|r| r.line() == line).collect::<Vec<_>>();
    lines.into_iter().map(|line| stage_table(&of_line(line))).collect()
}

fn stage_table(rows: &[&Row]) -> String {
    let (series, engine, threads) = rows[0].line();
    let numbers: String = rows.iter().map(|r| format!(" {:>9}", r.number)).collect();
    let title = format!("{series}, {engine}, {}: ns for each body and step", with_threads(threads));
    let mut text = format!("\n{title}\n{:<16}{numbers} {:>9}\n", "stage", "power");
    for (i, (name, _)) in rows[0].phases.iter().enumerate() {
        text.push_str(&stage_line(name, rows, |row| row.phases[i].1));
    }
    text + &stage_line("all", rows, |row| row.ms_median.unwrap_or(f64::NAN))
}

fn stage_line(name: &str, rows: &[&Row], ms: impl Fn(&Row) -> f64) -> String {
    let point = |r: &&Row| (f64::from(r.number), 1e6 * ms(r) / r.bodies as f64);
    let points: Vec<(f64, f64)> = rows.iter().map(point).collect();
    let cells: String = points.iter().map(|(_, ns)| format!(" {ns:>9.1}")).collect();
    let power = exponent(&points).map_or("–".to_string(), |p| format!("{p:+.2}"));
    format!("{name:<16}{cells} {power:>9}\n")
}

/// All rows as CSV, with a head; a column for each stage if there are any.
pub fn csv(rows: &[Row]) -> String {
    let stages: Vec<&str> = rows
        .iter()
        .map(|r| &r.phases)
        .find(|p| !p.is_empty())
        .map_or(Vec::new(), |phases| phases.iter().map(|(name, _)| *name).collect());
    let mut text = String::from(
        "series,number,scene,sleep,bodies,engine,threads,islands,contacts,awake,ms_median,us_per_body,speedup,\
         ratio_to_box3d,ratio_low,ratio_high,bytes_per_body,penetration_max,stands,steps,note",
    );
    text.extend(stages.iter().map(|stage| format!(",{stage}_ms")));
    text.push('\n');
    for row in rows {
        let mut cells = cells(row);
        cells.extend(stages.iter().map(|stage| {
            let found = row.phases.iter().find(|(name, _)| name == stage);
            found.map_or(String::new(), |(_, ms)| ms.to_string())
        }));
        let _ = writeln!(text, "{}", cells.into_iter().map(quoted).collect::<Vec<_>>().join(","));
    }
    text
}

fn cells(row: &Row) -> Vec<String> {
    let number = |value: Option<f64>| value.filter(|v| v.is_finite()).map_or(String::new(), |v| v.to_string());
    let count = |value: Option<usize>| value.map_or(String::new(), |v| v.to_string());
    vec![
        row.series.clone(),
        row.number.to_string(),
        row.scene.clone(),
        row.sleep.to_string(),
        row.bodies.to_string(),
        row.engine.clone(),
        row.threads.to_string(),
        count(row.islands),
        count(row.contacts),
        count(row.awake),
        number(row.ms_median),
        number(row.us_per_body),
        number(row.speedup),
        number(row.ratio_to_box3d),
        number(row.ratio_low),
        number(row.ratio_high),
        number(row.bytes_per_body),
        number(Some(row.penetration_max)),
        row.stands.to_string(),
        row.steps.to_string(),
        row.note.clone().unwrap_or_default(),
    ]
}

#[cfg(test)]
mod tests {
    use super::super::SERIES;
    use super::*;
    use crate::engine::Counts;
    use crate::lockstep::Turn;
    use crate::meter::Quality;

    fn run(engine: &'static str, threads: u32, ms: f64) -> Run {
        let quality =
            Quality { penetration_max: 0.001, drift_max: 0.0, joint_gap_max: 0.0, stands: true, energy_change: 0.0 };
        // The machine slows down: ratios do not.
        let turns = (0..3).map(|i| Turn { start: 5 * i, ms: ms * f64::from(1 + i) }).collect();
        let counts = (engine == "ishigaki").then_some(Counts { islands: 5, contacts: 70, asleep: 990 });
        let phases = vec![("solve", ms), ("begin", 0.1)];
        Run { engine, threads, turns, steps: 15, quality, counts, phases, note: None }
    }

    fn rows_of(number: u32, ms: f64) -> Vec<Row> {
        let runs = [run("ishigaki", 1, 2.0 * ms), run("ishigaki", 2, ms), run("box3d", 1, 4.0 * ms)];
        let point = Point { series: &SERIES[2], number, scene: "sparse:n=1000", bodies: number as usize, sleep: true };
        rows(&point, &runs, |_, threads| Some(f64::from(threads)))
    }

    #[test]
    fn speedup_and_ratio_are_by_turn_and_memory_is_asked_once() {
        let rows = rows_of(1000, 1.0);
        assert_eq!(rows[0].us_per_body, Some(4.0));
        assert_eq!(rows.iter().map(|r| r.speedup).collect::<Vec<_>>(), [Some(1.0), Some(2.0), Some(1.0)]);
        assert_eq!(rows.iter().map(|r| r.ratio_to_box3d).collect::<Vec<_>>(), [Some(0.5), None, Some(1.0)]);
        assert_eq!((rows[0].awake, rows[2].awake), (Some(10), None));
        assert_eq!(rows[1].bytes_per_body, Some(1048.576));
    }

    #[test]
    fn stages_grow_by_a_power() {
        // Ten times the bodies, a hundred times the time: ten times the time of a body.
        let rows = [rows_of(1000, 1.0), rows_of(10_000, 100.0)].concat();
        let text = stage_tables(&rows);
        assert_eq!(text.matches("stage").count(), 3, "{text}");
        let line = |name: &str| text.lines().find(|l| l.starts_with(name)).unwrap().to_string();
        assert!(line("solve").ends_with("+1.00"), "{text}");
        assert!(line("begin").ends_with("-1.00"), "{text}");
        assert!(line("solve").contains(" 2000.0   20000.0"), "{text}");
    }

    #[test]
    fn csv_has_a_column_for_each_stage() {
        let rows = rows_of(1000, 1.0);
        let text = csv(&rows);
        let columns = |i: usize| text.lines().nth(i).unwrap().split(',').count();
        assert!(text.lines().next().unwrap().ends_with("note,solve_ms,begin_ms"));
        assert!((1..=3).all(|i| columns(i) == columns(0)), "{text}");
    }
}
