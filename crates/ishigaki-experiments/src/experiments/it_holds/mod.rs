//! Beyond the talk: tall, heavy, wide and long things with the default options, and the work of the solver for them.

mod laws;
mod peers;
mod trials;

use crate::chart::Chart;
use crate::course::{Course, follow, rounded};
use crate::setup::scene;
use crate::{Experiment, Lab, Result, Verdict};
use ishigaki::World;
use trials::{Rule, TRIALS, Trial};

pub const EXPERIMENT: Experiment = Experiment {
    name: "it-holds",
    rows: &[],
    title: "Tall, heavy, wide and long: what the default options hold, and at how much work",
    run,
};

/// Above these a scene is over budget: of the work of all its steps, and of the 95th percentile of them.
const BUDGET: (f64, f64) = (1.0, 2.0);
/// Where the trials end and the laws begin, where these end and the peers begin.
const PARTS: (f64, f64) = (0.9, 0.95);

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let trials = &TRIALS[..lab.choose(TRIALS.len(), 3)];
    let columns = ["stood, s", "overlap, mm", "drift, mm", "joint gap, mm", "work, mean", "work, 95 %"];
    let title = "Default options, sleep off, 60 Hz; work over that of twelve sweeps; (!): beyond a limit";
    // What is good in one column is bad in another: no cell is darker than the next.
    let mut table = Chart::table(title, "value", columns).shade(|_| 0.0);
    let mut verdict = Verdict::on("nothing: beyond it. What stands on paper should stand");
    let mut over = Vec::new();
    for (i, trial) in trials.iter().enumerate() {
        let part = |i: usize| PARTS.0 * i as f64 / trials.len() as f64;
        let seconds = lab.choose(trial.seconds, 0.5);
        let (course, overlap) = perform(lab, trial, seconds, part(i)..part(i + 1))?;
        table = table.row(trial.label, cells(trial, seconds, &course, &overlap));
        verdict = judged(verdict, trial, seconds, &course, &overlap);
        if course.work > BUDGET.0 || course.work_95 > BUDGET.1 {
            over.push(trial.label);
        }
    }
    lab.chart(table);
    lab.progress(PARTS.0, "laws");
    let verdict = laws::run(lab, verdict)?;
    lab.progress(PARTS.1, "peers");
    let peers = peers::add(lab);
    Ok(verdict.note(budget_note(&over)).note(peers))
}

/// With the default options of today, whatever the scene's own.
fn perform(lab: &mut Lab<'_>, trial: &Trial, seconds: f64, part: std::ops::Range<f64>) -> Result<(Course, Overlap)> {
    let mut scene = scene(trial.scene, trial.parameters, |o| {
        *o = ishigaki::WorldOptions { gravity: o.gravity, ..Default::default() };
        o.rest.sleep.enabled = false;
    })?;
    let course = follow(lab, &mut scene, seconds, part, trial.label);
    let overlap = Overlap::of(&scene.world);
    Ok((course, overlap))
}

/// Overlaps of the points that touch, at the end.
struct Overlap {
    /// mm.
    mean: f64,
    /// mm.
    most: f64,
}

impl Overlap {
    fn of(world: &World) -> Self {
        let points = world.contacts().flat_map(|c| c.manifolds).flat_map(|m| &m.points);
        let (mut sum, mut most, mut count) = (0.0, 0.0_f64, 0.0_f64);
        for depth in points.map(|p| -1e3 * f64::from(p.separation)).filter(|depth| *depth >= 0.0) {
            (sum, most, count) = (sum + depth, most.max(depth), count + 1.0);
        }
        Self { mean: sum / count.max(1.0), most }
    }
}

/// A cell of the table.
type Cell = (f64, String);

fn cell(value: f64, holds: bool) -> Cell {
    (value, format!("{}{}", rounded(value), if holds { "" } else { " (!)" }))
}

/// A row of the table; what makes no sense for a scene is a dash.
fn cells(trial: &Trial, seconds: f64, course: &Course, overlap: &Overlap) -> [Cell; 6] {
    let dash = || (0.0, "–".to_string());
    let within = |value: f64, most: Option<f64>| cell(value, most.is_none_or(|most| value <= most));
    let work = [within(course.work, Some(BUDGET.0)), within(course.work_95, Some(BUDGET.1))];
    let [stood, pen, drift, gap] = match trial.rule {
        Rule::Stands { pen, drift } => {
            [cell(course.stood, course.stood >= seconds), within(course.pen, pen), within(course.drift, drift), dash()]
        }
        Rule::ShouldStand => {
            [cell(course.stood, course.stood >= seconds), within(course.pen, None), within(course.drift, None), dash()]
        }
        Rule::Joints { gap } => {
            // Chains and nets touch nothing.
            let pen = if course.pen > 0.0 { within(course.pen, None) } else { dash() };
            [dash(), pen, dash(), within(course.gap, Some(gap))]
        }
        Rule::Rests { mean, most } => {
            let (value, text) = cell(overlap.most, overlap.most <= most && overlap.mean <= mean);
            [dash(), (value, format!("{text}, mean {}", rounded(overlap.mean))), dash(), dash()]
        }
    };
    let [work, work_95] = work;
    [stood, pen, drift, gap, work, work_95]
}

fn judged(verdict: Verdict, trial: &Trial, seconds: f64, course: &Course, overlap: &Overlap) -> Verdict {
    let what = |figure: &str| format!("{}: {figure}", trial.label);
    let verdict =
        match trial.rule {
            Rule::Stands { pen, drift } => {
                let verdict = verdict.at_least(what("stood"), "s", seconds, course.stood);
                let verdict = limited(verdict, what("overlap"), pen, course.pen);
                limited(verdict, what("drift"), drift, course.drift)
            }
            Rule::ShouldStand => verdict.open(what("stood"), "s", course.stood),
            Rule::Joints { gap } => verdict.at_most(what("joint gap"), "mm", gap, course.gap),
            Rule::Rests { mean, most } => verdict
                .at_most(what("mean overlap at rest"), "mm", mean, overlap.mean)
                .at_most(what("greatest overlap at rest"), "mm", most, overlap.most),
        };
    verdict.open(what("work"), "", course.work)
}

/// What has no limit is in the table alone.
fn limited(verdict: Verdict, what: String, most: Option<f64>, measured: f64) -> Verdict {
    match most {
        Some(most) => verdict.at_most(what, "mm", most, measured),
        None => verdict,
    }
}

fn budget_note(over: &[&str]) -> String {
    let names = if over.is_empty() { "none".to_string() } else { over.join("; ") };
    format!(
        "Work counts every multiply-add of the solver, preparation included, over twelve visits to every row alone. \
         Over budget (mean above {}, or 95 % above {}): {names}. Of piles the table has overlaps at the end.",
        BUDGET.0, BUDGET.1
    )
}
