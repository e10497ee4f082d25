//! Beyond the talk: the impulses of whole towers and arches found at once, where sweeps need n² of them.

use crate::chart::Mark;
use crate::direct::{
    self, Subject, add_pair, by_work, cold_chart, cold_curves, decade, sweeps_for_a_decade, work_chart,
};
use crate::{Experiment, Lab, Result, Verdict};
use ishigaki::SolverOptions;
use std::f64::consts::PI;

pub const EXPERIMENT: Experiment = Experiment {
    name: "level-correction",
    rows: &[],
    title: "Level correction: towers and arches with it and without",
    run,
};

const fn tower(label: &'static str, parameters: &'static [(&'static str, f64)]) -> Subject {
    Subject { label, scene: "tower", parameters }
}

const TOWER_5: Subject = tower("tower of 5", &[("n", 5.0)]);
const TOWER_20: Subject = tower("tower of 20", &[("n", 20.0)]);
const TOWER_40: Subject = tower("tower of 40", &[("n", 40.0)]);
const ARCH: Subject = Subject { label: "arch", scene: "arch", parameters: &[] };

fn without(solver: &mut SolverOptions) {
    solver.level_correction.enabled = false;
}

/// The slowest error of a column of n fades by cos²(π/2n) in a sweep: a standing wave of a quarter of its length.
fn predicted(n: f64) -> f64 {
    decade(0.5 * PI / n)
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let verdict = Verdict::on("nothing: beyond it. Its sweeps need some n² to carry a load down a tower of n");
    let verdict = cold(lab, verdict)?;
    running(lab, verdict)
}

fn cold(lab: &mut Lab<'_>, mut verdict: Verdict) -> Result<Verdict> {
    let towers: &[(Subject, f64)] = lab.choose(&[(TOWER_20, 20.0), (TOWER_40, 40.0)], &[(TOWER_5, 5.0)]);
    let mut chart = cold_chart("The first step from a cold start: correction and sweeps, and sweeps alone");
    let mut costs = Vec::new();
    for (i, (subject, n)) in towers.iter().enumerate() {
        lab.progress(0.1 * i as f64, &format!("{}: cold", subject.label));
        let expected = predicted(*n);
        let (plain, with) = cold_curves(subject, (4.0 * expected) as usize, 20, without)?;
        let label = subject.label;
        let seen = sweeps_for_a_decade(&plain);
        verdict = verdict
            .near(format!("{label}, without: sweeps for a tenth of the residual"), "", expected, 0.1 * expected, seen)
            .at_most(format!("{label}, with: residual after correction and one sweep"), "", 1e-3, with[0].1);
        costs.push(with[0].0);
        chart = add_pair(chart, subject, Mark::Line, plain, with);
    }
    lab.progress(0.2, "arch: cold");
    let (plain, with) = cold_curves(&ARCH, lab.choose(4000, 50), 20, without)?;
    verdict = verdict.open("arch, without: residual after all sweeps", "", plain[plain.len() - 1].1).open(
        "arch, with: residual after correction and one sweep",
        "",
        with[0].1,
    );
    lab.chart(add_pair(chart, &ARCH, Mark::Line, plain, with).level(1e-3, "a thousandth"));
    if let [short, tall] = costs[..] {
        // Block-tridiagonal: linear in n, as a sweep is.
        verdict = verdict.near("cost of the correction in sweeps, 40 boxes over 20", "", 1.0, 0.15, tall / short);
    }
    let cost = costs.last().copied().unwrap_or(f64::NAN);
    Ok(verdict.open("work of correction and one sweep from cold, in sweeps", "", cost))
}

fn running(lab: &mut Lab<'_>, mut verdict: Verdict) -> Result<Verdict> {
    let seconds = lab.choose(20.0, 0.6);
    let settings_with = lab.choose(&[(1, 1), (2, 1), (3, 1), (4, 1), (8, 1), (8, 4)][..], &[(4, 1)]);
    let settings = lab.choose(&[(4, 1), (8, 1), (8, 4), (8, 16), (16, 16), (16, 32)][..], &[(4, 1)]);
    let subjects: &[Subject] = lab.choose(&[TOWER_40, ARCH], &[TOWER_5]);
    let mut chart = work_chart(format!("Drift in {seconds} s with more and more substeps and sweeps"), "drift, mm");
    for (i, subject) in subjects.iter().enumerate() {
        let from = 0.3 + 0.7 * i as f64 / subjects.len() as f64;
        let middle = from + 0.35 / subjects.len() as f64;
        let plain = by_work(lab, subject, seconds, settings, without, direct::drift, from..middle)?;
        let with = by_work(lab, subject, seconds, settings_with, |_| {}, direct::drift, middle..middle + 0.1)?;
        let least = |curve: &[(f64, f64)]| curve.iter().map(|p| p.1).fold(f64::MAX, f64::min);
        let label = subject.label;
        verdict = verdict.open(format!("{label}, without: least drift at any work"), "mm", least(&plain)).at_most(
            format!("{label}, with: least drift at any work"),
            "mm",
            least(&plain),
            least(&with),
        );
        chart = add_pair(chart, subject, Mark::Dotted, plain, with);
    }
    lab.chart(chart.level(direct::FALLEN, "fell"));
    Ok(verdict.note(
        "From cold the correction is made again and again, with a sweep after each, until it finds nothing: that is \
        its work. A standing tower is calm, and pays for one look at its residual. At rest a step is one substep, \
        so work grows less than the number of substeps.",
    ))
}
