//! Beyond the talk: loads of wide stacks handed down from each body to its supports in one pass.

use crate::chart::Mark;
use crate::direct::{
    self, Subject, add_pair, by_work, cold_chart, cold_curves, decade, sweeps_for_a_decade, work_chart,
};
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

/// A box passes its load to two below, so a column's cos²θ becomes cos²(√2 θ); and from the tip down the stack widens
/// as a circle does from its center, so the quarter wave π/2n becomes that of a drum: θ = 2.405/n.
fn predicted(base: f64) -> f64 {
    decade(std::f64::consts::SQRT_2 * J0_ZERO / base)
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let verdict = Verdict::on("nothing: beyond it. Height says who stands on whom; loads can follow it");
    let verdict = cold(lab, verdict)?;
    running(lab, verdict)
}

fn cold(lab: &mut Lab<'_>, mut verdict: Verdict) -> Result<Verdict> {
    let pyramids: &[(Subject, f64)] = lab.choose(&[(PYRAMID_20, 20.0), (PYRAMID_40, 40.0)], &[(PYRAMID_12, 12.0)]);
    let mut chart = cold_chart("The first step from a cold start: one pass down and sweeps, and sweeps alone");
    for (i, (subject, base)) in pyramids.iter().enumerate() {
        lab.progress(0.15 * i as f64, &format!("{}: cold", subject.label));
        let expected = predicted(*base);
        let (plain, with) = cold_curves(subject, (6.0 * expected) as usize, 20, without)?;
        let label = subject.label;
        let seen = sweeps_for_a_decade(&plain);
        verdict = verdict
            .near(format!("{label}, without: sweeps for a tenth of the residual"), "", expected, 0.2 * expected, seen)
            .at_most(format!("{label}, with: residual after one pass and one sweep"), "", 1e-2, with[0].1)
            .at_most(format!("{label}, with: work of both, in sweeps"), "", 3.0, with[0].0);
        chart = add_pair(chart, subject, Mark::Line, plain, with);
    }
    lab.chart(chart.level(1e-2, "a hundredth"));
    Ok(verdict)
}

fn running(lab: &mut Lab<'_>, mut verdict: Verdict) -> Result<Verdict> {
    let seconds = lab.choose(5.0, 0.1);
    let settings_with = lab.choose(&[(1, 1), (2, 1), (4, 1), (8, 1), (8, 4)][..], &[(4, 1)]);
    let settings = lab.choose(&[(4, 1), (8, 1), (8, 4), (8, 16)][..], &[(4, 1)]);
    let subject = lab.choose(PYRAMID_40, PYRAMID_12);
    let title = format!("{}: drift in {seconds} s with more and more substeps and sweeps", subject.label);
    let cold_start: direct::Switch = |s| s.wide.seed = false;
    let cold_without: direct::Switch = |s| {
        s.wide.seed = false;
        without(s);
    };
    let plain = by_work(lab, &subject, seconds, settings, cold_without, direct::drift, 0.3..0.7)?;
    let with = by_work(lab, &subject, seconds, settings_with, cold_start, direct::drift, 0.7..1.0)?;
    let least = |curve: &[(f64, f64)]| curve.iter().map(|p| p.1).fold(f64::MAX, f64::min);
    verdict = verdict.open("without: least drift at any work", "mm", least(&plain)).at_most(
        "with: least drift at any work",
        "mm",
        least(&plain),
        least(&with),
    );
    let chart = add_pair(work_chart(title, "drift, mm"), &subject, Mark::Dotted, plain, with);
    lab.chart(chart.level(direct::FALLEN, "fell"));
    Ok(verdict.note(
        "Seeds, which give new contacts the weight above them, are off: both start from nothing. Without means sweeps \
        alone: level correction, which would take the place of hand-down, is off as well.",
    ))
}
