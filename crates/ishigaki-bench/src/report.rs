//! Rows of the result: table, JSON, CSV.

use crate::lockstep::{Run, Turn};
use crate::scenes::Entry;
use crate::stats::{ratios, spread};
use serde::Serialize;
use std::fmt::Write;

/// The engine that the others are compared with.
pub const REFERENCE: &str = "box3d";

/// One engine in one scene, or in a part of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Name of the scene, with `:part` for a part of it.
    pub scene: String,
    /// Engine.
    pub engine: String,
    /// Threads it used.
    pub threads: u32,
    /// Median of the turns, ms for each step.
    pub ms_median: Option<f64>,
    /// Median over turns of its time over Box3D's.
    pub ratio_to_box3d: Option<f64>,
    /// 16th percentile of the same.
    pub ratio_low: Option<f64>,
    /// 84th percentile of the same.
    pub ratio_high: Option<f64>,
    /// Deepest overlap after 0.5 s, m; null if not finite. Of the whole scene, also in the rows of parts.
    pub penetration_max: f64,
    /// Greatest horizontal displacement, m.
    pub drift_max: f64,
    /// Greatest distance between anchors, m.
    pub joint_gap_max: f64,
    /// No body moved more than ¼ of its smallest edge.
    pub stands: bool,
    /// Energy at the end over energy at the start, less 1.
    pub energy_change: f64,
    /// Peak memory, less that with an empty world, MiB.
    pub rss_mib: Option<f64>,
    /// Steps it took.
    pub steps: u32,
    /// Why it took fewer than it should.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
    /// Milliseconds of a step in each stage, with --phases.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub phases: Vec<(&'static str, f64)>,
}

/// The rows of a scene: the whole of each engine, then its parts.
pub fn rows(entry: &Entry, runs: &[Run], memory: impl Fn(&str) -> Option<f64>) -> Vec<Row> {
    let mut rows: Vec<Row> = runs.iter().map(|run| row(entry, run, runs, None, memory(run.engine))).collect();
    for part in entry.parts {
        let part = runs.iter().map(|run| row(entry, run, runs, Some(*part), None));
        // An engine that stopped before, or steps that were not asked for: nothing to report.
        rows.extend(part.filter(|row| row.ms_median.is_some()));
    }
    rows
}

fn row(entry: &Entry, run: &Run, runs: &[Run], part: Option<(&str, u32, u32)>, rss_mib: Option<f64>) -> Row {
    let inside = |turn: &&Turn| part.is_none_or(|(_, from, to)| (from..to).contains(&turn.start));
    let times = |run: &Run| -> Vec<f64> { run.turns.iter().filter(inside).map(|t| t.ms).collect() };
    let own = times(run);
    let reference = runs.iter().find(|r| r.engine == REFERENCE).map(times).unwrap_or_default();
    let ratio = spread(&ratios(&own, &reference));
    Row {
        scene: part.map_or_else(|| entry.name.clone(), |(name, ..)| format!("{}:{name}", entry.name)),
        engine: run.engine.to_string(),
        threads: run.threads,
        ms_median: spread(&own).map(|s| s.median),
        ratio_to_box3d: ratio.map(|r| r.median),
        ratio_low: ratio.map(|r| r.low),
        ratio_high: ratio.map(|r| r.high),
        penetration_max: run.quality.penetration_max,
        drift_max: run.quality.drift_max,
        joint_gap_max: run.quality.joint_gap_max,
        stands: run.quality.stands,
        energy_change: run.quality.energy_change,
        rss_mib,
        steps: run.steps,
        note: run.note.clone(),
        phases: if part.is_none() { run.phases.clone() } else { Vec::new() },
    }
}

/// Head of the table.
pub fn table_head() -> String {
    format!(
        "{:<22} {:<9} {:>2} {:>9} {:>7} {:>13} {:>8} {:>9} {:>8} {:>6} {:>8} {:>7}",
        "scene",
        "engine",
        "th",
        "ms/step",
        "ratio",
        "16…84 %",
        "pen mm",
        "drift mm",
        "gap mm",
        "stands",
        "energy",
        "MiB"
    )
}

/// A line of the table.
pub fn table_line(row: &Row) -> String {
    let or_dash = |value: Option<f64>, digits: usize| value.map_or("–".to_string(), |v| format!("{v:.digits$}"));
    let range = match (row.ratio_low, row.ratio_high) {
        (Some(low), Some(high)) => format!("{low:.2}…{high:.2}"),
        _ => "–".to_string(),
    };
    let mut line = format!(
        "{:<22} {:<9} {:>2} {:>9} {:>7} {:>13} {:>8} {:>9} {:>8} {:>6} {:>8} {:>7}",
        row.scene,
        row.engine,
        row.threads,
        or_dash(row.ms_median, 3),
        or_dash(row.ratio_to_box3d, 2),
        range,
        millimeters(row.penetration_max),
        millimeters(row.drift_max),
        millimeters(row.joint_gap_max),
        if row.stands { "yes" } else { "no" },
        format!("{:+.3}", row.energy_change),
        or_dash(row.rss_mib, 1),
    );
    if let Some(note) = &row.note {
        let _ = write!(line, "  {note}");
    }
    if !row.phases.is_empty() {
        let stages: Vec<String> = row.phases.iter().map(|(name, ms)| format!("{name} {ms:.3}")).collect();
        let _ = write!(line, "\n    ms/step: {}", stages.join(", "));
    }
    line
}

fn millimeters(meters: f64) -> String {
    if meters.is_finite() { format!("{:.2}", 1e3 * meters) } else { "∞".to_string() }
}

/// All rows as CSV, with a head.
pub fn csv(rows: &[Row]) -> String {
    let mut text = String::from(
        "scene,engine,threads,ms_median,ratio_to_box3d,ratio_low,ratio_high,penetration_max,drift_max,joint_gap_max,\
         stands,energy_change,rss_mib,steps,note\n",
    );
    for r in rows {
        let number = |value: Option<f64>| value.filter(|v| v.is_finite()).map_or(String::new(), |v| v.to_string());
        let cells = [
            r.scene.clone(),
            r.engine.clone(),
            r.threads.to_string(),
            number(r.ms_median),
            number(r.ratio_to_box3d),
            number(r.ratio_low),
            number(r.ratio_high),
            number(Some(r.penetration_max)),
            number(Some(r.drift_max)),
            number(Some(r.joint_gap_max)),
            r.stands.to_string(),
            number(Some(r.energy_change)),
            number(r.rss_mib),
            r.steps.to_string(),
            r.note.clone().unwrap_or_default(),
        ];
        let _ = writeln!(text, "{}", cells.map(quoted).join(","));
    }
    text
}

/// A cell of a CSV file.
pub fn quoted(cell: String) -> String {
    if cell.contains([',', '"', '\n']) { format!("\"{}\"", cell.replace('"', "\"\"")) } else { cell }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::meter::Quality;

    fn run(engine: &'static str, ms: &[f64]) -> Run {
        let turns = ms.iter().enumerate().map(|(i, &ms)| Turn { start: 50 * i as u32, ms }).collect();
        let quality = Quality {
            penetration_max: 0.001,
            drift_max: f64::INFINITY,
            joint_gap_max: 0.0,
            stands: false,
            energy_change: 0.0,
        };
        Run { engine, threads: 1, turns, steps: 300, quality, counts: None, phases: Vec::new(), note: None }
    }

    #[test]
    fn parts_take_their_own_turns_and_ratios_are_by_turn() {
        let entry = crate::scenes::find("pile4000").unwrap();
        let runs = [run("ishigaki", &[2.0, 2.0, 2.0, 1.0, 1.0, 1.0]), run("box3d", &[1.0, 1.0, 1.0, 2.0, 2.0, 2.0])];
        let rows = rows(&entry, &runs, |_| Some(7.0));
        let find = |scene: &str, engine: &str| rows.iter().find(|r| r.scene == scene && r.engine == engine).unwrap();
        assert_eq!(find("pile4000:falling", "ishigaki").ratio_to_box3d, Some(2.0));
        assert_eq!(find("pile4000:resting", "ishigaki").ratio_to_box3d, Some(0.5));
        assert_eq!(find("pile4000", "box3d").ratio_to_box3d, Some(1.0));
        assert_eq!(find("pile4000", "ishigaki").rss_mib, Some(7.0));
    }

    #[test]
    fn json_writes_null_for_what_is_not_finite() {
        let entry = crate::scenes::find("tower20").unwrap();
        let rows = rows(&entry, &[run("ishigaki", &[1.0])], |_| None);
        let json = serde_json::to_value(&rows).unwrap();
        assert!(json[0]["drift_max"].is_null() && json[0]["ratio_to_box3d"].is_null());
        assert_eq!(json[0]["ms_median"], 1.0);
        assert!(csv(&rows).lines().nth(1).unwrap().starts_with("tower20,ishigaki,1,1,,,,0.001,,0,false"));
    }
}
