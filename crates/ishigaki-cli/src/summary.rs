//! What a run found out, for people and for programs.

use crate::samples::Samples;
use ishigaki::{BodyHandle, Stage, StepReport, World};
use serde::{Serialize, Serializer};
use std::collections::BTreeSet;
use std::fmt::Write;

/// Collected while a run goes on.
pub struct Record {
    /// Of the steps that were taken.
    step: Samples,
    steps_not_taken: u64,
    stages: [Samples; Stage::ALL.len()],
    worst_penetration: f32,
    worst_joint_error: f32,
    /// Multiply-adds, and what twelve visits to every row would have been.
    work: u64,
    work_budget: u64,
    non_finite: BTreeSet<BodyHandle>,
    last: StepReport,
}

impl Record {
    pub fn new() -> Self {
        Self {
            step: Samples::new(),
            steps_not_taken: 0,
            stages: std::array::from_fn(|_| Samples::new()),
            worst_penetration: 0.0,
            worst_joint_error: 0.0,
            work: 0,
            work_budget: 0,
            non_finite: BTreeSet::new(),
            last: StepReport::default(),
        }
    }

    /// Takes in one step that took `seconds`.
    pub fn add(&mut self, seconds: f64, report: StepReport) {
        if report.still {
            self.steps_not_taken += 1;
        } else {
            self.step.push(1e3 * seconds);
            for (samples, &stage) in self.stages.iter_mut().zip(&report.stage_seconds) {
                samples.push(1e3 * stage);
            }
        }
        self.worst_penetration = self.worst_penetration.max(report.max_penetration);
        self.worst_joint_error = self.worst_joint_error.max(report.max_joint_error);
        self.work += report.work;
        self.work_budget += report.work_budget;
        self.non_finite.extend(&report.non_finite);
        self.last = report;
    }

    pub fn summarize(self, scene: String, steps: u64, dt: f32, warnings: Vec<String>, world: &World) -> Summary {
        let name = |&handle: &BodyHandle| match world.body(handle).map(|body| body.name()) {
            Some(name) if !name.is_empty() => name.to_string(),
            _ => format!("body {}", handle.index()),
        };
        let last = self.last;
        Summary {
            scene,
            steps,
            steps_not_taken: self.steps_not_taken,
            dt,
            bodies: last.bodies,
            ms_per_step: Milliseconds {
                median: nanoseconds_kept(self.step.median()),
                p95: nanoseconds_kept(self.step.quantile(0.95)),
                max: nanoseconds_kept(self.step.max()),
            },
            stages_ms: std::array::from_fn(|i| (Stage::ALL[i].name(), nanoseconds_kept(self.stages[i].median()))),
            work_per_step: self.work / steps.max(1),
            work_over_budget: (self.work_budget > 0).then(|| self.work as f64 / self.work_budget as f64),
            contacts: last.contacts,
            rows: last.rows,
            max_penetration: last.max_penetration,
            max_joint_error: last.max_joint_error,
            max_speed: last.max_speed,
            kinetic_energy: last.kinetic_energy,
            potential_energy: last.potential_energy,
            momentum: last.momentum.to_array(),
            angular_momentum: last.angular_momentum.to_array(),
            asleep: last.asleep,
            frozen: last.frozen,
            state_hash: format!("{:016x}", world.state_hash()),
            worst_penetration: self.worst_penetration,
            worst_joint_error: self.worst_joint_error,
            non_finite: self.non_finite.iter().map(name).collect(),
            warnings,
        }
    }
}

/// The result of a run. Lengths in m, speeds in m/s, energies in J; what is not said to be of the whole run is of
/// the last step.
#[derive(Serialize)]
pub struct Summary {
    scene: String,
    steps: u64,
    /// Of these, those in which nothing could happen, since all slept.
    steps_not_taken: u64,
    /// s.
    dt: f32,
    bodies: usize,
    /// Over the steps that were taken.
    ms_per_step: Milliseconds,
    /// Medians over the steps that were taken.
    #[serde(serialize_with = "as_object")]
    stages_ms: [(&'static str, f64); Stage::ALL.len()],
    /// Multiply-adds of the solver, the mean of all steps.
    work_per_step: u64,
    /// Over those of twelve visits to every row; nothing where there were no rows.
    work_over_budget: Option<f64>,
    contacts: usize,
    rows: usize,
    max_penetration: f32,
    max_joint_error: f32,
    max_speed: f32,
    kinetic_energy: f32,
    potential_energy: f32,
    /// kg·m/s.
    momentum: [f32; 3],
    /// About the origin, kg·m²/s.
    angular_momentum: [f32; 3],
    asleep: usize,
    frozen: usize,
    /// Hexadecimal: equal states have equal hashes.
    state_hash: String,
    /// Over the whole run.
    worst_penetration: f32,
    /// Over the whole run.
    worst_joint_error: f32,
    /// Names of bodies that left the numbers, at any step of the run.
    pub non_finite: Vec<String>,
    warnings: Vec<String>,
}

#[derive(Serialize)]
struct Milliseconds {
    median: f64,
    p95: f64,
    max: f64,
}

impl Summary {
    /// One JSON object on one line; a number that is not finite is `null`.
    pub fn json(&self) -> String {
        // Strings, numbers and string-keyed maps cannot fail.
        serde_json::to_string(self).unwrap_or_default()
    }

    /// Aligned lines with units.
    pub fn text(&self) -> String {
        let mut lines: Vec<(&str, String)> = Vec::new();
        let ms = &self.ms_per_step;
        lines
            .push(("time per step", format!("{:.3} ms median, {:.3} ms p95, {:.3} ms max", ms.median, ms.p95, ms.max)));
        for (stage, ms) in self.stages_ms {
            lines.push(("", format!("{ms:>10.3} ms {stage}")));
        }
        if self.steps_not_taken > 0 {
            lines.push(("steps not taken", format!("{} of {}: all slept", self.steps_not_taken, self.steps)));
        }
        lines.push(("bodies", format!("{}, {} asleep", self.bodies, self.asleep)));
        lines.push(("contacts", format!("{}, {} frozen", self.contacts, self.frozen)));
        lines.push(("rows", self.rows.to_string()));
        if let Some(part) = self.work_over_budget {
            let work = format!("{} multiply-adds a step, {part:.2} of 12 visits to each row", self.work_per_step);
            lines.push(("solver work", work));
        }
        lines.push(("penetration", worst(self.max_penetration, self.worst_penetration)));
        lines.push(("joint error", worst(self.max_joint_error, self.worst_joint_error)));
        lines.push(("greatest speed", format!("{:.4} m/s", self.max_speed)));
        let (kinetic, potential) = (significant(self.kinetic_energy), significant(self.potential_energy));
        lines.push(("energy", format!("{kinetic} J kinetic, {potential} J potential")));
        lines.push(("momentum", format!("{} kg·m/s", vector(self.momentum))));
        lines.push(("angular momentum", format!("{} kg·m²/s", vector(self.angular_momentum))));
        lines.push(("state hash", self.state_hash.clone()));
        if !self.non_finite.is_empty() {
            lines.push(("NOT FINITE", self.non_finite.join(", ")));
        }

        let seconds = self.steps as f64 * f64::from(self.dt);
        let mut text = format!("{}: {} steps, {seconds:.3} s simulated\n", self.scene, self.steps);
        for (what, value) in lines {
            let _ = writeln!(text, "  {what:<17} {value}");
        }
        text
    }
}

fn worst(now: f32, ever: f32) -> String {
    format!("{:.3} mm, {:.3} mm at worst", 1e3 * now, 1e3 * ever)
}

fn vector([x, y, z]: [f32; 3]) -> String {
    format!("({x:.4}, {y:.4}, {z:.4})")
}

/// The digits that an f32 holds, six or seven, and none that it does not.
fn significant(value: f32) -> String {
    let size = value.abs();
    if !(1e-4..1e7).contains(&size) && size > 0.0 {
        return format!("{value:.3e}");
    }
    let whole_digits = (size.max(1.0).log10() as usize) + 1;
    format!("{value:.*}", 7_usize.saturating_sub(whole_digits).min(6))
}

/// Milliseconds without the digits below a nanosecond: they are rounding of the clock's seconds.
fn nanoseconds_kept(ms: f64) -> f64 {
    (1e6 * ms).round() / 1e6
}

/// Pairs as an object, in their order.
fn as_object<S: Serializer>(pairs: &[(&'static str, f64)], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(pairs.iter().copied())
}

#[cfg(test)]
mod tests {
    use super::*;
    use ishigaki::{Body, Shape};

    #[test]
    fn numbers_show_the_digits_they_have() {
        for (value, text) in [
            (0.0, "0.000000"),
            (1_225_967.9, "1225968"),
            (2568.252, "2568.252"),
            (-0.25, "-0.250000"),
            (3.2e-7, "3.200e-7"),
            (-4e9, "-4.000e9"),
            (f32::NAN, "NaN"),
            (f32::INFINITY, "inf"),
        ] {
            assert_eq!(significant(value), text);
        }
    }

    #[test]
    fn bodies_that_left_the_numbers_are_named_and_their_energies_are_null() {
        let mut world = World::default();
        let lost = world.add_body(Body::dynamic(Shape::ball(1.0)).named("lost")).unwrap();
        let nameless = world.add_body(Body::dynamic(Shape::ball(1.0))).unwrap();
        let mut record = Record::new();
        let report = StepReport { non_finite: vec![nameless, lost], kinetic_energy: f32::NAN, ..StepReport::default() };
        record.add(0.001, report);
        record
            .add(0.003, StepReport { kinetic_energy: f32::INFINITY, max_penetration: f32::NAN, ..Default::default() });
        let summary = record.summarize("test".into(), 2, 0.5, vec!["a warning".into()], &world);
        assert_eq!(summary.non_finite, ["lost", "body 1"], "at any step, in the order of bodies");
        assert!(summary.text().contains("lost, body 1"), "{}", summary.text());
        let json: serde_json::Value = serde_json::from_str(&summary.json()).unwrap();
        assert!(json["kinetic_energy"].is_null() && json["max_penetration"].is_null(), "{json}");
        assert_eq!(json["worst_penetration"], 0.0);
        assert_eq!(json["warnings"][0], "a warning");
        assert_eq!(json["ms_per_step"]["max"], 3.0);
    }

    #[test]
    fn steps_that_were_not_taken_have_no_time() {
        let mut record = Record::new();
        record.add(0.002, StepReport::default());
        (0..8).for_each(|_| record.add(1e-6, StepReport { still: true, ..StepReport::default() }));
        let summary = record.summarize("test".into(), 9, 0.5, vec![], &World::default());
        assert!(summary.text().contains("8 of 9: all slept"), "{}", summary.text());
        let json: serde_json::Value = serde_json::from_str(&summary.json()).unwrap();
        assert_eq!((&json["ms_per_step"]["median"], &json["steps_not_taken"]), (&2.0.into(), &8.into()));
    }
}
