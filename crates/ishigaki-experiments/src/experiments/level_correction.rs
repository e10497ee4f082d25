//! Beyond the talk: the impulses of whole towers and arches found at once, where sweeps need n² of them.

use crate::course::Course;
use crate::direct::{
    self, Subject, Switch, add_cold, add_pair, by_work, cold_chart, cold_curves, decade, least, sweeps_for_a_decade,
    turning, work_chart,
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
const TOWER_160: Subject = tower("tower of 160", &[("n", 160.0)]);
const HEAVY: Subject =
    Subject { label: "10 boxes, top 1000 ×", scene: "heavy_on_light", parameters: &[("n", 10.0), ("ratio", 1000.0)] };
const ARCH: Subject = Subject { label: "arch", scene: "arch", parameters: &[] };

fn without(solver: &mut SolverOptions) {
    solver.level_correction.enabled = false;
}

/// The slowest error of a column of n fades by cos²(π/2n) in a sweep: a standing wave of a quarter of its length.
fn predicted(n: f64) -> f64 {
    decade(0.5 * PI / n) * turning(n)
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let verdict = Verdict::on("nothing: beyond it. Its sweeps need some n² to carry a load down a tower of n");
    let verdict = cold(lab, verdict)?;
    running(lab, verdict)
}

fn cold(lab: &mut Lab<'_>, mut verdict: Verdict) -> Result<Verdict> {
    let towers: &[(Subject, f64)] = lab.choose(&[(TOWER_20, 20.0), (TOWER_40, 40.0)], &[(TOWER_5, 5.0)]);
    let mut chart =
        cold_chart("The first step from a cold start: correction and sweeps, and sweeps alone", direct::ROUNDING);
    let mut costs = Vec::new();
    for (i, (subject, n)) in towers.iter().enumerate() {
        lab.progress(0.05 * i as f64, &format!("{}: cold", subject.label));
        let expected = predicted(*n);
        let curves = cold_curves(subject, (4.0 * expected) as usize, 4, without)?;
        let (label, first) = (subject.label, curves.1[0]);
        let seen = sweeps_for_a_decade(&curves.0);
        verdict = verdict
            .near(format!("{label}, without: sweeps for a tenth of the residual"), "", expected, 0.03 * expected, seen)
            .at_most(format!("{label}, with: residual after correction and one sweep"), "", 1e-3, first.1);
        costs.push(first.0);
        chart = add_cold(chart, subject, curves);
    }
    lab.progress(0.1, "arch: cold");
    let curves = cold_curves(&ARCH, lab.choose(4000, 50), 4, without)?;
    let (last, first) = (curves.0[curves.0.len() - 1], curves.1[0]);
    verdict = verdict
        .open(format!("arch, without: residual after {} sweeps", last.0.round()), "", last.1)
        .open("arch, with: residual after correction and one sweep", "", first.1)
        .open("arch, with: work of both, in sweeps", "", first.0);
    lab.chart(add_cold(chart, &ARCH, curves));
    if let [short, tall] = costs[..] {
        verdict = verdict.open("tower of 40, with: work of both, in sweeps", "", tall).at_most(
            "its growth from 20 boxes to 40 (of sweeps alone it is 4)",
            "×",
            2.0,
            tall / short,
        );
    }
    Ok(verdict)
}

/// What is looked at, and how.
type Look = (Subject, fn(&Course) -> f64);

fn running(lab: &mut Lab<'_>, mut verdict: Verdict) -> Result<Verdict> {
    let seconds = lab.choose(20.0, 0.6);
    let settings_with = lab.choose(&[(1, 1), (2, 1), (3, 1), (4, 1), (8, 1), (8, 4)][..], &[(4, 1)]);
    let settings = lab.choose(&[(4, 1), (8, 1), (8, 4), (8, 16), (16, 16), (16, 32)][..], &[(4, 1)]);
    let looks: &[Look] = lab.choose(
        &[(TOWER_160, direct::overlap), (HEAVY, direct::overlap), (ARCH, direct::drift)],
        &[(TOWER_5, direct::overlap)],
    );
    let unseeded_without: Switch = |s| {
        direct::unseeded(s);
        without(s);
    };
    let title = format!("Overlap of stacks and drift of the arch in {seconds} s, more and more substeps and sweeps");
    let mut chart = work_chart(title, "overlap or drift, mm");
    for (i, (subject, figure)) in looks.iter().enumerate() {
        let at = |k: f64| 0.15 + 0.85 * (i as f64 + k) / looks.len() as f64;
        let plain = by_work(lab, subject, seconds, settings, unseeded_without, *figure, at(0.0)..at(0.7))?;
        let with = by_work(lab, subject, seconds, settings_with, direct::unseeded, *figure, at(0.7)..at(1.0))?;
        let label = subject.label;
        // Twice as much is the same.
        verdict = verdict.open(format!("{label}, without: least at any work"), "mm", least(&plain)).at_most(
            format!("{label}, with: least at any work"),
            "mm",
            2.0 * least(&plain),
            least(&with),
        );
        chart = add_pair(chart, subject, plain, with);
    }
    lab.chart(chart);
    Ok(verdict.note(
        "From cold the correction is made again and again, with a sweep after each, until it finds nothing: that is \
        its work. Sweeps go up and down: at each turn a row is visited twice running, which makes n rows as slow as \
        n/(n − 1) times as many sweeps; the prediction without this was low by just that. Seeds, which give new \
        contacts the weight above them, are off in all runs. At rest a step is one substep, so work grows less than \
        the number of substeps.",
    ))
}
