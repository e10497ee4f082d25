//! Beyond the talk: what each configuration of the solver holds, at how much work and time; the defaults follow from it.

use crate::chart::{Chart, Mark};
use crate::course::{Course, follow};
use crate::setup::scene;
use crate::{Experiment, Lab, Result, Verdict};
use ishigaki::{Jointed, SolverOptions};

pub const EXPERIMENT: Experiment = Experiment {
    name: "frontier",
    rows: &[],
    title: "Quality against work: the table from which the default options follow",
    run,
};

/// Substeps, sweeps, relax sweeps.
type Sweeps = (u32, u32, u32);

/// Configurations that differ in their sweeps alone.
struct Family {
    name: &'static str,
    switch: fn(&mut SolverOptions),
    sweeps: &'static [Sweeps],
}

const fn family(name: &'static str, switch: fn(&mut SolverOptions), sweeps: &'static [Sweeps]) -> Family {
    Family { name, switch, sweeps }
}

const FAMILIES: [Family; 8] = [
    family("all techniques", |_| {}, &[(4, 1, 1), (1, 1, 1), (2, 1, 1), (3, 1, 1), (6, 1, 1), (8, 1, 1)]),
    family("sweeps alone", sweeps_alone, &[(4, 1, 1), (4, 2, 1), (8, 2, 1)]),
    family("all, 2 + 1 sweeps", |_| {}, &[(2, 2, 1), (4, 2, 1)]),
    family("no level correction", |s| s.level_correction.enabled = false, &[(4, 1, 1)]),
    family("no hand-down", |s| s.hand_down.enabled = false, &[(4, 1, 1)]),
    family("no joint trees", |s| s.joint_tree.enabled = false, &[(4, 1, 1)]),
    family("no over-relaxation", |s| s.over_relaxation.enabled = false, &[(4, 1, 1)]),
    family("joints as all else", |s| s.jointed = Jointed::ALIKE, &[(4, 1, 1), (8, 1, 1)]),
];

fn sweeps_alone(solver: &mut SolverOptions) {
    solver.level_correction.enabled = false;
    solver.hand_down.enabled = false;
    solver.joint_tree.enabled = false;
}

/// A scene and what is looked at: how far it drifts, or how far its joints open.
struct Subject {
    label: &'static str,
    scene: &'static str,
    parameters: &'static [(&'static str, f64)],
    seconds: f64,
    /// Joints may open by this, mm; without it the scene must stand.
    gap: Option<f64>,
}

const fn standing(
    label: &'static str,
    scene: &'static str,
    parameters: &'static [(&'static str, f64)],
    seconds: f64,
) -> Subject {
    Subject { label, scene, parameters, seconds, gap: None }
}

const SUBJECTS: [Subject; 12] = [
    standing("tower", "tower", &[("n", 20.0)], 20.0),
    standing("heavy", "heavy_on_light", &[], 10.0),
    standing("wall", "wall", &[], 10.0),
    standing("arch", "arch", &[], 10.0),
    standing("thin arch", "arch", &[("thickness", 0.118_25)], 10.0),
    standing("cards", "card_house", &[], 10.0),
    standing("pyramid", "pyramid", &[("base", 30.0)], 5.0),
    standing("plank", "plank_on_two_towers", &[], 10.0),
    standing("overhang", "overhang", &[], 10.0),
    Subject { label: "chain", scene: "chain", parameters: &[("links", 20.0)], seconds: 10.0, gap: Some(10.0) },
    Subject { label: "net", scene: "joint_grid", parameters: &[("n", 20.0)], seconds: 4.0, gap: Some(15.0) },
    Subject { label: "ragdolls", scene: "ragdolls", parameters: &[("n", 20.0)], seconds: 4.0, gap: Some(40.0) },
];

/// More than this is not looked at: it fell, or came apart, mm.
const FALLEN: f64 = 1000.0;
/// Less than this is as good as nothing, mm.
const NOTHING: f64 = 0.01;

/// One configuration in all scenes.
struct Seen {
    label: String,
    family: usize,
    is_default: bool,
    courses: Vec<Course>,
}

impl Subject {
    fn holds(&self, course: &Course) -> bool {
        self.gap.map_or(course.stands, |most| course.gap <= most)
    }

    /// Drift or gap, mm.
    fn error(&self, course: &Course) -> f64 {
        match self.gap {
            Some(_) => course.gap.clamp(NOTHING, FALLEN),
            None if course.stands => course.drift.max(NOTHING),
            None => FALLEN,
        }
    }
}

impl Seen {
    fn held(&self) -> usize {
        SUBJECTS.iter().zip(&self.courses).filter(|(subject, course)| subject.holds(course)).count()
    }

    /// Geometric mean, mm.
    fn error(&self) -> f64 {
        let logarithms = SUBJECTS.iter().zip(&self.courses).map(|(subject, course)| subject.error(course).ln());
        (logarithms.sum::<f64>() / self.courses.len() as f64).exp()
    }

    fn mean(&self, of: impl Fn(&Course) -> f64) -> f64 {
        self.courses.iter().map(of).sum::<f64>() / self.courses.len() as f64
    }

    fn work(&self) -> f64 {
        self.mean(|course| course.work)
    }

    /// Geometric mean: no scene counts for more than another, ms.
    fn time(&self) -> f64 {
        self.mean(|course| course.step_ms.ln()).exp()
    }
}

fn measure(lab: &mut Lab<'_>) -> Result<Vec<Seen>> {
    let families = &FAMILIES[..lab.choose(FAMILIES.len(), 2)];
    let subjects = &SUBJECTS[..lab.choose(SUBJECTS.len(), 2)];
    let most = lab.choose(usize::MAX, 1);
    let configurations: Vec<(usize, Sweeps)> = families
        .iter()
        .enumerate()
        .flat_map(|(i, family)| family.sweeps.iter().take(most).map(move |sweeps| (i, *sweeps)))
        .collect();
    let runs = (configurations.len() * subjects.len()) as f64;
    let mut all = Vec::new();
    for (k, &(family, sweeps)) in configurations.iter().enumerate() {
        let label = label_of(&families[family], sweeps);
        let mut seen = Seen { label, family, is_default: false, courses: Vec::new() };
        for (i, subject) in subjects.iter().enumerate() {
            let mut scene = scene(subject.scene, subject.parameters, |o| {
                (o.solver.substeps, o.solver.sweeps, o.solver.relax_sweeps) = sweeps;
                (families[family].switch)(&mut o.solver);
                seen.is_default = o.solver == SolverOptions::default();
            })?;
            let done = (k * subjects.len() + i) as f64;
            let now = format!("{}: {}", seen.label, subject.label);
            let seconds = lab.choose(subject.seconds, 0.6);
            seen.courses.push(follow(lab, &mut scene, seconds, done / runs..(done + 1.0) / runs, &now));
        }
        all.push(seen);
    }
    Ok(all)
}

fn label_of(family: &Family, (substeps, sweeps, relax): Sweeps) -> String {
    let sweeps = format!("{substeps} × ({sweeps} + {relax})");
    if family.name.starts_with("all") { sweeps } else { format!("{sweeps}, {}", family.name) }
}

/// Each family a line, the defaults a point on it, and what nothing beats joined.
fn plot(all: &[Seen], title: &str, x_label: &str, y_label: &str, x: fn(&Seen) -> f64, y: fn(&Seen) -> f64) -> Chart {
    let values = || all.iter().map(y);
    let (least, most) = (values().fold(f64::MAX, f64::min), values().fold(f64::MIN, f64::max));
    // Work and time of the means span less than a decade: a logarithmic axis would have hardly a tick.
    let chart = Chart::curves(title, x_label, y_label).log(false, true);
    let mut chart = chart.y_range(0.7 * least, 1.4 * most);
    let sorted = |chosen: &dyn Fn(&Seen) -> bool| {
        let mut points: Vec<(f64, f64)> = all.iter().filter(|s| chosen(s)).map(|s| (x(s), y(s))).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points
    };
    // The seventh color is black: it marks the defaults.
    const BEFORE_BLACK: usize = 6;
    let add = |chart: Chart, i: usize| chart.series(FAMILIES[i].name, Mark::Dotted, sorted(&|s| s.family == i));
    for i in 0..BEFORE_BLACK {
        chart = add(chart, i);
    }
    let frontier = sorted(&|s| !all.iter().any(|other| x(other) < x(s) && y(other) < y(s)));
    chart = chart.series("default options", Mark::Points, sorted(&|s| s.is_default)).series(
        "frontier",
        Mark::Law,
        frontier,
    );
    (BEFORE_BLACK..FAMILIES.len()).fold(chart, add)
}

/// Configurations by scenes.
fn table(all: &[Seen], title: &str, text: impl Fn(&Subject, &Course) -> (f64, String)) -> Chart {
    let scenes = all.first().map_or(0, |seen| seen.courses.len());
    let mut chart = Chart::table(title, "value", SUBJECTS[..scenes].iter().map(|s| s.label)).shade(|v| (1e-2 + v).ln());
    for seen in all {
        let mark = if seen.is_default { " (default)" } else { "" };
        let cells: Vec<_> = SUBJECTS.iter().zip(&seen.courses).map(|(subject, course)| text(subject, course)).collect();
        chart = chart.row(format!("{}{mark}", seen.label), cells);
    }
    chart
}

fn charts(lab: &mut Lab<'_>, all: &[Seen]) {
    const ERROR: &str = "drift or gap, mm";
    let title = "Drift of what stands and gap of joints, geometric mean of the scenes; what fell counts as 1 m";
    const WORK: &str = "work / work of twelve sweeps";
    lab.chart(plot(all, title, WORK, ERROR, Seen::work, Seen::error));
    lab.chart(plot(all, "The same by the time of a step (on this machine)", "ms", ERROR, Seen::time, Seen::error));
    let overlap: fn(&Seen) -> f64 = |s| s.mean(|c| c.pen.clamp(NOTHING, FALLEN).ln()).exp();
    lab.chart(plot(all, "Greatest overlap, geometric mean of the scenes", WORK, "overlap, mm", Seen::work, overlap));
    let fallen = |subject: &Subject, course: &Course| subject.gap.is_none() && !course.stands;
    lab.chart(table(all, "Drift, mm; of chain, net and ragdolls the greatest gap of a joint", |subject, course| {
        let error = subject.error(course);
        (error, if fallen(subject, course) { "fell".to_string() } else { shorter(error) })
    }));
    lab.chart(table(all, "Greatest overlap, mm", |_, course| (course.pen, shorter(course.pen))));
    lab.chart(table(all, "Work over that of twelve sweeps", |_, course| (course.work, shorter(course.work))));
    lab.chart(table(all, "Time of a step, median, ms (on this machine)", |_, course| {
        (course.step_ms, shorter(course.step_ms))
    }));
}

/// Two digits are enough, and fit.
fn shorter(value: f64) -> String {
    match value {
        0.0 => "0".to_string(),
        v if v <= NOTHING => format!("< {NOTHING}"),
        v if v < 0.1 => format!("{v:.3}"),
        v if v < 10.0 => format!("{v:.2}"),
        v => format!("{v:.0}"),
    }
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let all = measure(lab)?;
    charts(lab, &all);
    let verdict =
        Verdict::on("nothing: beyond it. The rule of our defaults: of what holds every scene, the least work");
    let Some(default) = all.iter().find(|seen| seen.is_default) else {
        return Ok(verdict.open("default options among the configurations", "", f64::NAN));
    };
    let names = |chosen: &dyn Fn(&Seen) -> bool| -> Vec<&str> {
        all.iter().filter(|seen| chosen(seen)).map(|seen| seen.label.as_str()).collect()
    };
    let cheaper = names(&|s| s.held() >= default.held() && s.work() < default.work());
    let better = names(&|s| s.error() < default.error() && s.work() < default.work());
    let faster = names(&|s| s.error() < default.error() && s.time() < default.time());
    let scenes = default.courses.len() as f64;
    let note = format!(
        "As many scenes at less work: {}. Less error and less work: {}. Less error and less time: {}. A scene of \
         joints holds while no gap exceeds {}. Not among these scenes is what the default options spend more on: \
         heaps of jointed bodies that come to rest late (more substeps and sweeps for joints) and the first steps of \
         wide stacks (`hand-down` has them).",
        listed(&cheaper),
        listed(&better),
        listed(&faster),
        listed(&gaps())
    );
    Ok(verdict
        .at_least("default options: scenes that hold", "", scenes, default.held() as f64)
        .at_most("configurations that hold as many at less work", "", 0.0, cheaper.len() as f64)
        .at_most("configurations with less error and less work", "", 0.0, better.len() as f64)
        .open("configurations with less error and less time", "", faster.len() as f64)
        .open("default options: work", "", default.work())
        .open("default options: error", "mm", default.error())
        .note(note))
}

/// Limits of the joints.
fn gaps() -> Vec<String> {
    let limit = |s: &Subject| s.gap.map(|most| format!("{most} mm ({})", s.label));
    SUBJECTS.iter().filter_map(limit).collect()
}

fn listed(names: &[impl AsRef<str>]) -> String {
    let names: Vec<&str> = names.iter().map(AsRef::as_ref).collect();
    if names.is_empty() { "none".to_string() } else { names.join("; ") }
}
