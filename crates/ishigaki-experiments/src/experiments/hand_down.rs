//! Beyond the talk: loads of wide stacks handed down from each body to its supports in one pass.

use crate::course::follow;
use crate::direct::{
    self, Subject, Switch, add_cold, add_pair, by_work, cold_chart, cold_curves, decade, least, sweeps_for_a_decade,
    work_chart,
};
use crate::setup::scene;
use crate::{Experiment, Lab, Result, Verdict};
use ishigaki::SolverOptions;

pub const EXPERIMENT: Experiment =
    Experiment { name: "hand-down", rows: &[], title: "Hand-down: pyramids with it and without", run };

const fn pyramid(label: &'static str, parameters: &'static [(&'static str, f64)]) -> Subject {
    Subject { label, scene: "pyramid", parameters }
}

/// Large enough for hand-down: more than 200 manifolds.
const PYRAMID_12: Subject = pyramid("pyramid of 12", &[("base", 12.0)]);
const PYRAMID_20: Subject = pyramid("pyramid of 20", &[("base", 20.0)]);
const PYRAMID_40: Subject = pyramid("pyramid of 40", &[("base", 40.0)]);

/// Both, or level correction would take its place.
fn without(solver: &mut SolverOptions) {
    (solver.hand_down.enabled, solver.level_correction.enabled) = (false, false);
}

/// First zero of the Bessel function J₀.
const J0_ZERO: f64 = 2.404_826;

/// What boxes that only move up and down would need. Each passes its load to two below, so a column's cos²θ becomes
/// cos²(√2 θ); and from the tip down the stack widens as a disk does from its center, so the quarter wave π/2n becomes
/// that of a drum, θ = 2.405/n.
fn vertical(base: f64) -> f64 {
    decade(std::f64::consts::SQRT_2 * J0_ZERO / base)
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let verdict = Verdict::on("nothing: beyond it. Height says who stands on whom; loads can follow it");
    let verdict = cold(lab, verdict)?;
    running(lab, verdict)
}

fn cold(lab: &mut Lab<'_>, mut verdict: Verdict) -> Result<Verdict> {
    let pyramids: &[(Subject, f64)] = lab.choose(&[(PYRAMID_20, 20.0), (PYRAMID_40, 40.0)], &[(PYRAMID_12, 12.0)]);
    let mut chart = cold_chart("The first step from a cold start: one pass down and sweeps, and sweeps alone", 1e-4);
    let mut decades = Vec::new();
    for (i, (subject, base)) in pyramids.iter().enumerate() {
        lab.progress(0.15 * i as f64, &format!("{}: cold", subject.label));
        let bound = vertical(*base);
        let curves = cold_curves(subject, (8.0 * bound) as usize, 20, without)?;
        let (label, first) = (subject.label, curves.1[0]);
        let seen = sweeps_for_a_decade(&curves.0);
        let as_good = curves.0.iter().find(|p| p.1 <= first.1).map_or(f64::NAN, |p| p.0);
        verdict = verdict
            .at_least(format!("{label}, without: sweeps for a tenth of the residual"), "", bound, seen)
            .at_most(format!("{label}, with: work of one pass and one sweep, in sweeps"), "", 2.0, first.0)
            .open(format!("{label}, with: residual after both"), "", first.1)
            // A load goes down one level in a sweep.
            .at_least(format!("{label}, without: sweeps for the same residual"), "", *base, as_good);
        decades.push(seen);
        chart = add_cold(chart, subject, curves);
    }
    lab.chart(chart);
    if let [small, large] = decades[..] {
        verdict = verdict.near("without: sweeps, 40 boxes over 20", "×", 4.0, 0.5, large / small);
    }
    Ok(verdict)
}

fn running(lab: &mut Lab<'_>, mut verdict: Verdict) -> Result<Verdict> {
    let seconds = lab.choose(5.0, 0.1);
    let settings_with = lab.choose(&[(1, 1), (2, 1), (4, 1), (8, 1), (8, 4)][..], &[(4, 1)]);
    let settings = lab.choose(&[(4, 1), (8, 1), (8, 4), (8, 16)][..], &[(4, 1)]);
    let subject = lab.choose(PYRAMID_40, PYRAMID_12);
    let title = format!("{}: drift in {seconds} s, more and more substeps and sweeps", subject.label);
    let unseeded_without: Switch = |s| {
        direct::unseeded(s);
        without(s);
    };
    let plain = by_work(lab, &subject, seconds, settings, unseeded_without, direct::drift, 0.3..0.7)?;
    let with = by_work(lab, &subject, seconds, settings_with, direct::unseeded, direct::drift, 0.7..0.95)?;
    verdict = verdict.open("without: least drift at any work", "mm", least(&plain)).at_most(
        "with: least drift at any work",
        "mm",
        least(&plain),
        least(&with),
    );
    lab.chart(add_pair(work_chart(title, "drift, mm"), &subject, plain, with));
    dearest_steps(lab, verdict)
}

/// What hand-down is for: level correction holds such a pyramid too, but its first steps are dear.
fn dearest_steps(lab: &mut Lab<'_>, mut verdict: Verdict) -> Result<Verdict> {
    let seconds = lab.choose(1.0, 0.1);
    let subject = lab.choose(PYRAMID_40, PYRAMID_12);
    let switches: [(&str, Switch); 2] =
        [("with hand-down", |_| {}), ("with level correction in its place", |s| s.hand_down.enabled = false)];
    for (name, switch) in switches {
        let mut scene = scene(subject.scene, subject.parameters, |o| {
            direct::unseeded(&mut o.solver);
            switch(&mut o.solver);
        })?;
        let course = follow(lab, &mut scene, seconds, 0.95..1.0, name);
        verdict = verdict.open(format!("{}, {name}: work of the dearest step", subject.label), "", course.work_most);
    }
    Ok(verdict.note(
        "Boxes tilt and slide too, which takes more sweeps than the bound for those that only move up and down. We had \
        expected one pass to leave a hundredth of the residual. It leaves a tenth: points that would pull are let go, \
        friction ends at its cone, and what is lost there is left to the sweeps. Seeds, which give new contacts the \
        weight above them, are off, so that all runs start from nothing; without means sweeps alone, since level \
        correction would take the place of hand-down.",
    ))
}
