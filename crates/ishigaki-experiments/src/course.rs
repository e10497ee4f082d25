//! A scene followed to its end: how long it stood, how far it moved, and what the solver worked for it.

use crate::Lab;
use crate::setup::DT;
use crate::verdict::short;
use ishigaki_scenes::{Meter, Scene};
use std::ops::Range;

/// What a run was like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Course {
    /// Until a body had moved by a quarter of its edge, s; the whole time if none did.
    pub stood: f64,
    /// Whether none ever did.
    pub stands: bool,
    /// Greatest overlap after the first half second, mm.
    pub pen: f64,
    /// Greatest horizontal way, mm.
    pub drift: f64,
    /// Greatest opening of a joint, mm.
    pub gap: f64,
    /// Multiply-adds over those of twelve visits to every row alone: of all steps together.
    pub work: f64,
    /// The same, 95th percentile of the steps.
    pub work_95: f64,
    /// The same, of the dearest step.
    pub work_most: f64,
    /// Median time of a step on this machine, ms.
    pub step_ms: f64,
}

/// Steps a scene for so many seconds; `part` is the part of the experiment that this is.
pub fn follow(lab: &mut Lab<'_>, scene: &mut Scene, seconds: f64, part: Range<f64>, label: &str) -> Course {
    let mut meter = Meter::new(&scene.world);
    let (mut stood, mut work, mut budget) = (seconds, 0, 0);
    let (mut works, mut times) = (Vec::new(), Vec::new());
    while scene.world.time() < seconds {
        let ((spent, allowed), time) = lab.time(|| {
            let report = scene.world.step(DT);
            (report.work, report.work_budget)
        });
        meter.observe(&scene.world);
        if !meter.measure().stands && stood == seconds {
            stood = scene.world.time();
        }
        (work, budget) = (work + spent, budget + allowed);
        if allowed > 0 {
            works.push(spent as f64 / allowed as f64);
        }
        times.push(1e3 * time);
        let done = (scene.world.time() / seconds).min(1.0);
        lab.progress(part.start + done * (part.end - part.start), label);
    }
    let m = meter.measure();
    Course {
        stood,
        stands: m.stands,
        pen: 1e3 * f64::from(m.pen),
        drift: 1e3 * f64::from(m.drift),
        gap: 1e3 * f64::from(m.joint_gap),
        work: work as f64 / (budget as f64).max(1.0),
        work_95: percentile(&mut works, 95),
        work_most: works.iter().copied().fold(0.0, f64::max),
        step_ms: percentile(&mut times, 50),
    }
}

/// 0 of nothing.
fn percentile(values: &mut [f64], percent: usize) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() * percent / 100).copied().unwrap_or(0.0)
}

/// What is too small to see is so said.
pub fn rounded(value: f64) -> String {
    if value > 0.0 && value < 1e-3 { "< 0.001".to_string() } else { short(value) }
}
