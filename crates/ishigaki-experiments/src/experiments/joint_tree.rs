//! Beyond the talk: all joints of a chain solved at once, where sweeps need as many as links times the mass ratio.

use crate::chart::{Chart, Mark};
use crate::direct::{Subject, add_pair, by_work, cold_chart, cold_curves, decade, sweeps_for_a_decade, work_chart};
use crate::{Experiment, Lab, Result, Verdict};
use ishigaki::SolverOptions;

pub const EXPERIMENT: Experiment = Experiment {
    name: "joint-tree",
    rows: &[],
    title: "Joint trees: chains with heavy ends, solved at once and joint by joint",
    run,
};

/// Links, mass of the end over that of a link.
struct Chain {
    subject: Subject,
    links: f64,
    ratio: f64,
}

const fn chain(label: &'static str, parameters: &'static [(&'static str, f64)], links: f64, ratio: f64) -> Chain {
    Chain { subject: Subject { label, scene: "chain", parameters }, links, ratio }
}

const SHORT: Chain = chain("10 links, end 10 ×", &[("links", 10.0), ("end_mass_ratio", 10.0)], 10.0, 10.0);
const MIDDLE: Chain = chain("20 links, end 100 ×", &[("links", 20.0), ("end_mass_ratio", 100.0)], 20.0, 100.0);
const LONG: Chain = chain("100 links, end 1000 ×", &[("links", 100.0), ("end_mass_ratio", 1000.0)], 100.0, 1000.0);

fn without(solver: &mut SolverOptions) {
    solver.joint_tree.enabled = false;
}

impl Chain {
    /// The slowest error is that of a heavy rope with a weight at its end: x tan x = n m/M, θ = x/n. Without a weight x is
    /// π/2, as for a tower; under a great one x² is n m/M, and sweeps are some n M/m.
    fn predicted(&self) -> f64 {
        let (mut low, mut high) = (0.0, 0.5 * std::f64::consts::PI);
        for _ in 0..60 {
            let x = 0.5 * (low + high);
            if x * f64::tan(x) < self.links / self.ratio { low = x } else { high = x }
        }
        decade(low / self.links)
    }
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let verdict = Verdict::on("nothing: beyond it. Its sweeps pass a load on from joint to joint");
    let verdict = cold(lab, verdict)?;
    running(lab, verdict)
}

fn cold(lab: &mut Lab<'_>, mut verdict: Verdict) -> Result<Verdict> {
    let mut chart = cold_chart("The first step of a hanging chain from a cold start: at once, and joint by joint");
    let chains: &[Chain] = lab.choose(&[SHORT, MIDDLE, LONG], &[SHORT]);
    for (i, chain) in chains.iter().enumerate() {
        let label = chain.subject.label;
        lab.progress(0.1 * i as f64, &format!("{label}: cold"));
        let expected = chain.predicted();
        // The slowest needs a quarter of a million for a tenth: it is only looked at.
        let sweeps = (5.0 * expected).min(30_000.0);
        let (plain, with) = cold_curves(&chain.subject, sweeps as usize, 20, without)?;
        verdict = verdict.at_most(format!("{label}, at once: residual after one visit"), "", 1e-3, with[0].1);
        if sweeps > expected {
            let what = format!("{label}, joint by joint: sweeps for a tenth of the residual");
            verdict = verdict.near(what, "", expected, 0.1 * expected, sweeps_for_a_decade(&plain));
        } else {
            let what = format!("{label}, joint by joint: residual after {sweeps} sweeps");
            verdict = verdict.open(what, "", plain[plain.len() - 1].1);
        }
        chart = add_pair(chart, &chain.subject, Mark::Line, plain, with);
    }
    lab.chart(chart.level(1e-3, "a thousandth"));
    Ok(verdict)
}

fn running(lab: &mut Lab<'_>, mut verdict: Verdict) -> Result<Verdict> {
    let seconds = lab.choose(10.0, 0.1);
    let settings_with = lab.choose(&[(1, 1), (2, 1), (4, 1), (8, 1)][..], &[(4, 1)]);
    let settings = lab.choose(&[(2, 1), (4, 1), (8, 1), (8, 4), (16, 8), (32, 8)][..], &[(4, 1)]);
    let subject = lab.choose(LONG, SHORT).subject;
    let title = format!("{}: greatest gap of a joint in {seconds} s, hanging", subject.label);
    let plain = by_work(lab, &subject, seconds, settings, without, |c| c.gap, 0.3..0.8)?;
    let with = by_work(lab, &subject, seconds, settings_with, |_| {}, |c| c.gap, 0.8..1.0)?;
    let at = |curve: &[(f64, f64)], pick: fn(f64, f64) -> f64, start: f64| curve.iter().map(|p| p.1).fold(start, pick);
    verdict = verdict.at_most("at once: greatest gap at any work", "mm", 10.0, at(&with, f64::max, 0.0)).open(
        "joint by joint: least gap at any work",
        "mm",
        at(&plain, f64::min, f64::MAX),
    );
    let chart: Chart = add_pair(work_chart(title, "gap, mm"), &subject, Mark::Dotted, plain, with);
    lab.chart(chart.level(10.0, "limit"));
    Ok(verdict.note(
        "In the cold step joints are hard in both; in the runs below, joint by joint they are recovered softly, as they \
        are by default wherever trees are off. Where there are joints the default options take twice the substeps and \
        sweeps that are given.",
    ))
}
