//! The same scenes in other engines: where `ISHIGAKI_BENCH` names a built `ishigaki-bench` (`scripts/bench.sh` builds
//! it), it is run once and its figures stand beside ours. It is no dependency: it builds C and C++.

use crate::Lab;
use crate::chart::Chart;
use crate::course::rounded;
use serde::Deserialize;
use std::ffi::OsString;
use std::process::Command;

/// Names the program.
const VARIABLE: &str = "ISHIGAKI_BENCH";
/// Those the bench has names and times for, and some of ours.
const SCENES: &str = "tower20,tower80,tower:n=160,pyramid30,pyramid100,heavy_on_light10,\
    heavy_on_light:n=10:ratio=1000,chain20,chain100_heavy,chain:links=100:end_mass_ratio=1000:swing=1,\
    joint_grid30,ragdolls200,pile4000,free_body";
/// Engines stop in a scene after this, s.
const LIMIT: &str = "30";

/// One engine in one scene, as the bench writes it; null where it is not finite.
#[derive(Debug, Deserialize)]
struct Row {
    scene: String,
    engine: String,
    stands: bool,
    penetration_max: Option<f64>,
    drift_max: Option<f64>,
    joint_gap_max: Option<f64>,
    energy_change: Option<f64>,
}

/// Adds the tables of the peers, if there is a bench; what is to be said about them.
pub fn add(lab: &mut Lab<'_>) -> String {
    let Some(program) = std::env::var_os(VARIABLE) else {
        return format!(
            "Peers: {VARIABLE} does not name a built ishigaki-bench (scripts/bench.sh builds it), so there are no \
             tables of them."
        );
    };
    match measure(program, lab.choose(SCENES, "tower:n=3")) {
        Ok(rows) => {
            tables(&rows).into_iter().for_each(|chart| lab.chart(chart));
            "Peers: figures of ishigaki-bench, whose meter judges all engines alike and looks at every fifth step; its \
             scenes last 3 to 20 s."
                .to_string()
        }
        Err(reason) => format!("Peers: the bench that {VARIABLE} names gave no figures: {reason}."),
    }
}

fn measure(program: OsString, scenes: &str) -> Result<Vec<Row>, String> {
    let arguments = ["--json", "--quiet", "--no-memory", "--limit", LIMIT, "--scenes", scenes];
    let output = Command::new(program).args(arguments).output().map_err(|e| e.to_string())?;
    if !output.status.success() {
        let words = String::from_utf8_lossy(&output.stderr);
        return Err(words.lines().last().unwrap_or("it failed without a word").to_string());
    }
    let rows: Vec<Row> = serde_json::from_slice(&output.stdout).map_err(|e| e.to_string())?;
    // Times of parts of a scene have the figures of the whole.
    Ok(rows.into_iter().filter(|row| !row.scene.ends_with(":falling") && !row.scene.ends_with(":resting")).collect())
}

/// Names in the order in which they come.
fn names(rows: &[Row], name: impl Fn(&Row) -> &String) -> Vec<String> {
    let mut names = Vec::new();
    for row in rows {
        if !names.contains(name(row)) {
            names.push(name(row).clone());
        }
    }
    names
}

fn has_joints(scene: &str) -> bool {
    ["chain", "joint_grid", "ragdolls"].iter().any(|s| scene.starts_with(s))
}

fn stands(scene: &str) -> bool {
    ["tower", "pyramid", "heavy_on_light"].iter().any(|s| scene.starts_with(s))
}

/// Value and text of a cell.
type Cell = fn(&Row) -> (f64, String);

/// Title, scenes it is about, cell.
type Kind = (&'static str, fn(&str) -> bool, Cell);

fn tables(rows: &[Row]) -> Vec<Chart> {
    let yes = |row: &Row| if row.stands { (0.0, "yes".to_string()) } else { (1.0, "no".to_string()) };
    let kinds: [Kind; 5] = [
        ("Peers: does it stand?", stands, yes),
        ("Peers: drift, mm", stands, |row| millimeters(row.drift_max)),
        (
            "Peers: overlap, mm",
            |scene| stands(scene) || ["ragdolls", "pile"].iter().any(|s| scene.starts_with(s)),
            |row| millimeters(row.penetration_max),
        ),
        ("Peers: joint gap, mm", has_joints, |row| millimeters(row.joint_gap_max)),
        (
            "Peers: change of the energy, %",
            |scene| scene == "free_body",
            |row| {
                let change = 100.0 * row.energy_change.map_or(f64::INFINITY, f64::abs);
                (change, rounded(change))
            },
        ),
    ];
    kinds.iter().filter_map(|(title, applies, cell)| table(rows, title, *applies, *cell)).collect()
}

/// Scenes by engines; none if it applies to no scene.
fn table(rows: &[Row], title: &str, applies: fn(&str) -> bool, cell: Cell) -> Option<Chart> {
    let engines = names(rows, |row| &row.engine);
    let mut chart = Chart::table(title, "value", engines.clone()).shade(|v| (1e-3 + v).ln());
    let scenes: Vec<String> = names(rows, |row| &row.scene).into_iter().filter(|s| applies(s)).collect();
    for scene in &scenes {
        let cells = engines.iter().map(|engine| {
            let row = rows.iter().find(|row| row.scene == *scene && row.engine == *engine);
            row.map_or((0.0, "–".to_string()), cell)
        });
        chart = chart.row(scene.as_str(), cells.collect::<Vec<_>>());
    }
    (!scenes.is_empty()).then_some(chart)
}

fn millimeters(meters: Option<f64>) -> (f64, String) {
    let value = 1e3 * meters.unwrap_or(f64::INFINITY);
    let text = if value.is_finite() { rounded(value) } else { "∞".to_string() };
    (value, text)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROWS: &str = r#"[
        {"scene": "tower20", "engine": "a", "stands": true, "penetration_max": 0.004, "drift_max": 0.001,
         "joint_gap_max": 0.0, "energy_change": 0.0, "threads": 1},
        {"scene": "tower20", "engine": "b", "stands": false, "penetration_max": null, "drift_max": 0.1,
         "joint_gap_max": 0.0, "energy_change": 0.0}]"#;

    #[test]
    fn rows_of_the_bench_become_tables() {
        let rows: Vec<Row> = serde_json::from_str(ROWS).unwrap();
        let charts = tables(&rows);
        assert_eq!(charts.len(), 3, "nothing of joints or free bodies");
        let csv = crate::chart::csv(&charts);
        assert!(csv.contains("\"Peers: drift, mm\",b,,tower20,value,100"), "{csv}");
        assert!(csv.contains("\"Peers: overlap, mm\",b,,tower20,value,inf"), "{csv}");
    }

    #[test]
    fn a_bench_that_is_not_there_says_so() {
        assert!(measure("no such program".into(), "tower20").is_err());
    }
}
