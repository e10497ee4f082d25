//! Beyond the talk: all joints of a chain solved at once, where sweeps need as many as links times the mass ratio.

use crate::direct::{
    ROUNDING, Subject, add_cold, add_pair, by_work, cold_chart, cold_curves, decade, least, sweeps_for_a_decade,
    turning, work_chart,
};
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

const HANGING: Subject = Subject { label: "hanging", ..LONG.subject };
const SWINGING: Subject = Subject {
    label: "swinging",
    scene: "chain",
    parameters: &[("links", 100.0), ("end_mass_ratio", 1000.0), ("swing", 1.0)],
};

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
        decade(low / self.links) * turning(self.links + 1.0)
    }
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let verdict = Verdict::on("nothing: beyond it. Its sweeps pass a load on from joint to joint");
    let verdict = cold(lab, verdict)?;
    running(lab, verdict)
}

fn cold(lab: &mut Lab<'_>, mut verdict: Verdict) -> Result<Verdict> {
    let mut chart =
        cold_chart("The first step of a hanging chain from a cold start: at once, and joint by joint", ROUNDING);
    let chains: &[Chain] = lab.choose(&[SHORT, MIDDLE, LONG], &[SHORT]);
    for (i, chain) in chains.iter().enumerate() {
        let label = chain.subject.label;
        lab.progress(0.1 * i as f64, &format!("{label}: cold"));
        let expected = chain.predicted();
        // The slowest needs a quarter of a million for a tenth: it is only looked at.
        let sweeps = (5.0 * expected).min(30_000.0);
        let curves = cold_curves(&chain.subject, sweeps as usize, 4, without)?;
        let (last, first) = (curves.0[curves.0.len() - 1], curves.1[0]);
        verdict = verdict.at_most(format!("{label}, at once: residual after one visit"), "", 1e-3, first.1);
        if sweeps > expected {
            let what = format!("{label}, joint by joint: sweeps for a tenth of the residual");
            verdict = verdict.near(what, "", expected, 0.03 * expected, sweeps_for_a_decade(&curves.0));
        } else {
            let what = format!("{label}, joint by joint: residual after {sweeps} sweeps");
            verdict = verdict.open(what, "", last.1);
        }
        chart = add_cold(chart, &chain.subject, curves);
    }
    lab.chart(chart);
    Ok(verdict)
}

fn running(lab: &mut Lab<'_>, mut verdict: Verdict) -> Result<Verdict> {
    let seconds = lab.choose(5.0, 0.1);
    let settings_with = lab.choose(&[(1, 1), (2, 1), (4, 1), (8, 1)][..], &[(4, 1)]);
    let settings = lab.choose(&[(2, 1), (4, 1), (8, 1), (8, 4), (16, 4), (32, 4)][..], &[(4, 1)]);
    let subjects: &[(Subject, f64)] = lab.choose(&[(HANGING, 10.0), (SWINGING, 50.0)], &[(SHORT.subject, 10.0)]);
    let title = format!("Greatest gap of a joint in {seconds} s, more and more substeps and sweeps");
    let mut chart = work_chart(title, "gap, mm (least shown: 0.01)");
    for (i, (subject, limit)) in subjects.iter().enumerate() {
        let at = |k: f64| 0.3 + 0.7 * (i as f64 + k) / subjects.len() as f64;
        let plain = by_work(lab, subject, seconds, settings, without, |c| c.gap, at(0.0)..at(0.8))?;
        let with = by_work(lab, subject, seconds, settings_with, |_| {}, |c| c.gap, at(0.8)..at(1.0))?;
        let label = subject.label;
        verdict = verdict.at_most(format!("{label}, at once: least gap at any work"), "mm", *limit, least(&with)).open(
            format!("{label}, joint by joint: least gap at any work"),
            "mm",
            least(&plain),
        );
        chart = add_pair(chart, subject, plain, with);
    }
    lab.chart(chart);
    Ok(verdict.note(
        "In the cold step joints are hard in both; in the runs below, joint by joint they are recovered softly, as they \
        are by default wherever trees are off. Where there are joints, the default options take twice the substeps and \
        sweeps that are given. A gap below 0.01 mm counts as that.",
    ))
}
