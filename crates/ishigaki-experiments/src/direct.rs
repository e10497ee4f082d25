//! What experiments on direct solutions share: a cold step sweep by sweep, with and without the technique, and what a
//! scene comes to at how much work.

use crate::chart::{Chart, Mark};
use crate::course::{Course, follow};
use crate::setup::{DT, scene};
use crate::{Lab, Result};
use ishigaki::{Jointed, SolverOptions, StepReport};
use std::ops::Range;

/// Switches a technique.
pub type Switch = fn(&mut SolverOptions);

/// A named scene.
#[derive(Clone, Copy)]
pub struct Subject {
    /// For legends and figures.
    pub label: &'static str,
    /// Its name.
    pub scene: &'static str,
    /// What differs from its defaults.
    pub parameters: &'static [(&'static str, f64)],
}

/// Below this a residual is rounding of f32.
pub const ROUNDING: f64 = 1e-7;

/// Residual over that of the first sweep without the technique, by work in sweeps without it.
pub type Curve = Vec<(f64, f64)>;

/// The first step of a scene in one substep of so many sweeps: its impulses start from nothing.
fn cold_step(subject: &Subject, sweeps: usize, switch: Switch) -> Result<StepReport> {
    let mut scene = scene(subject.scene, subject.parameters, |o| {
        let solver = &mut o.solver;
        (solver.substeps, solver.sweeps, solver.relax_sweeps) = (1, sweeps as u32, 0);
        solver.jointed = Jointed::ALIKE;
        // Soft recovery would be another problem, with another solution.
        switch(solver);
        o.report.residual_by_sweep = true;
    })?;
    Ok(scene.world.step(DT).clone())
}

/// Without and with the technique, the same cold step: `sweeps` and `sweeps_with` of them.
pub fn cold_curves(subject: &Subject, sweeps: usize, sweeps_with: usize, without: Switch) -> Result<(Curve, Curve)> {
    let (first, plain) = (cold_step(subject, 1, without)?, cold_step(subject, sweeps, without)?);
    let (first_with, with) = (cold_step(subject, 1, |_| {})?, cold_step(subject, sweeps_with, |_| {})?);
    let one_sweep = per_sweep(&first, &plain, sweeps);
    // All but the sweeps, which both prepare alike.
    let before = first.work as f64 - one_sweep;
    let scale = f64::from(plain.residual_by_sweep.first().copied().unwrap_or(f32::NAN));
    let curve = |first: &StepReport, all: &StepReport, count: usize| {
        let (start, each) = (first.work as f64 - before, per_sweep(first, all, count));
        let sweeps = all.residual_by_sweep.iter().enumerate();
        let point =
            |(k, r): (usize, &f32)| ((start + k as f64 * each) / one_sweep, (f64::from(*r) / scale).max(ROUNDING));
        sweeps.map(point).collect()
    };
    Ok((curve(&first, &plain, sweeps), curve(&first_with, &with, sweeps_with)))
}

/// Multiply-adds of a sweep, from steps of one and of `count` of them.
fn per_sweep(one: &StepReport, all: &StepReport, count: usize) -> f64 {
    (all.work as f64 - one.work as f64) / (count as f64 - 1.0)
}

/// Sweeps from a hundredth of the first residual to a thousandth, where only the slowest error is left.
pub fn sweeps_for_a_decade(curve: &Curve) -> f64 {
    let reached = |part: f64| curve.iter().find(|p| p.1 <= part).map_or(f64::NAN, |p| p.0);
    reached(1e-3) - reached(1e-2)
}

/// Sweeps in which an error that falls by cos²θ in each falls to a tenth.
pub fn decade(theta: f64) -> f64 {
    std::f64::consts::LN_10 / (-2.0 * theta.cos().ln())
}

/// Sweeps that turn back at both ends visit the row there twice running, once for nothing: n rows get n − 1 visits.
pub fn turning(rows: f64) -> f64 {
    rows / (rows - 1.0)
}

/// An empty chart of [`cold_curves`] down to this residual.
pub fn cold_chart(title: &str, least: f64) -> Chart {
    let chart = Chart::curves(title, "work, in sweeps of the rows alone", "residual / that of one sweep");
    chart.log(true, true).y_range(0.5 * least, 2.0)
}

/// Both curves of a subject: every second sweep, since what is left goes up and down with the direction, and no more
/// points than a logarithmic axis shows.
pub fn add_cold(chart: Chart, subject: &Subject, (without, with): (Curve, Curve)) -> Chart {
    let mut last = 0.0;
    let mut is_shown = |i: usize, x: f64| {
        let shown = i < 8 || (i.is_multiple_of(2) && x > 1.02 * last);
        last = if shown { x } else { last };
        shown
    };
    let thinned = without.iter().enumerate().filter(|(i, p)| is_shown(*i, p.0)).map(|(_, p)| *p).collect();
    let name = |how: &str| format!("{}, {how}", subject.label);
    chart.line(name("without"), thinned).series(name("with"), Mark::Dotted, with)
}

/// Figures of a scene run with each of some (substeps, sweeps), by the work for it: work over the budget, mm. What
/// fell is [`FALLEN`].
pub fn by_work(
    lab: &mut Lab<'_>,
    subject: &Subject,
    seconds: f64,
    settings: &[(u32, u32)],
    switch: Switch,
    figure: fn(&Course) -> f64,
    part: Range<f64>,
) -> Result<Vec<(f64, f64)>> {
    let mut seen = Vec::new();
    for (i, &(substeps, sweeps)) in settings.iter().enumerate() {
        let mut scene = scene(subject.scene, subject.parameters, |o| {
            (o.solver.substeps, o.solver.sweeps) = (substeps, sweeps);
            switch(&mut o.solver);
        })?;
        let at = |i: usize| part.start + (part.end - part.start) * i as f64 / settings.len() as f64;
        let label = format!("{}: {substeps} substeps of {sweeps} sweeps", subject.label);
        let course = follow(lab, &mut scene, seconds, at(i)..at(i + 1), &label);
        seen.push((course.work, figure(&course).clamp(NOTHING, FALLEN)));
    }
    seen.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(seen)
}

/// More than this is not looked at: it fell, or came apart, mm.
const FALLEN: f64 = 1000.0;
/// Less than this is not looked at either, mm.
const NOTHING: f64 = 0.01;

/// Greatest horizontal way, mm; of what does not stand [`FALLEN`].
pub fn drift(course: &Course) -> f64 {
    if course.stands { course.drift } else { FALLEN }
}

/// Greatest overlap, mm; of what does not stand [`FALLEN`].
pub fn overlap(course: &Course) -> f64 {
    if course.stands { course.pen } else { FALLEN }
}

/// Least value of a curve.
pub fn least(curve: &[(f64, f64)]) -> f64 {
    curve.iter().map(|p| p.1).fold(f64::MAX, f64::min)
}

/// Seeds give new contacts the weight above them: without them both start from nothing.
pub fn unseeded(solver: &mut SolverOptions) {
    solver.wide.seed = false;
}

/// An empty chart of [`by_work`].
pub fn work_chart(title: impl Into<String>, y_label: &str) -> Chart {
    // Room above for marks on the line of what fell.
    let chart = Chart::curves(title, "work / work of twelve sweeps", y_label).log(true, true);
    chart.y_range(0.5 * NOTHING, 2.0 * FALLEN).level(FALLEN, "fell or came apart")
}

/// Both curves of a subject.
pub fn add_pair(chart: Chart, subject: &Subject, without: Curve, with: Curve) -> Chart {
    let name = |how: &str| format!("{}, {how}", subject.label);
    chart.series(name("without"), Mark::Dotted, without).series(name("with"), Mark::Dotted, with)
}
