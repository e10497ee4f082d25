//! Engines side by side, turn by turn.
//!
//! All engines live in one process and take turns of a few steps, the first of each round another one than in the
//! round before. What slows the machine down for a while slows all of them, so that ratios hold where times do not.
//! States are read and judged between turns, outside the time that counts.

use crate::engine::{DT, Engine, Kind, Setup, State};
use crate::meter::{Meter, Quality};
use crate::scene::Scene;
use anyhow::{Context, Result};
use std::time::Instant;

/// How a scene is run.
#[derive(Clone, Debug)]
pub struct Course {
    /// Steps of 1/60 s.
    pub steps: u32,
    /// Steps in a turn.
    pub turn: u32,
    /// Steps before the first that counts.
    pub warm_up: u32,
    /// An engine that has stepped for longer than this takes no further turn, s.
    pub limit: f64,
}

/// A turn that counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// Steps before it.
    pub start: u32,
    /// Milliseconds for each step.
    pub ms: f64,
}

/// What became of an engine.
#[derive(Clone, Debug)]
pub struct Run {
    /// The engine.
    pub engine: &'static str,
    /// Threads it used.
    pub threads: u32,
    /// In order.
    pub turns: Vec<Turn>,
    /// Steps it took.
    pub steps: u32,
    /// What the meter saw.
    pub quality: Quality,
    /// Milliseconds of a step in each stage, if the engine says.
    pub phases: Vec<(&'static str, f64)>,
    /// Why it took fewer steps than it should.
    pub note: Option<String>,
}

struct Runner {
    run: Run,
    engine: Box<dyn Engine>,
    meter: Meter,
    seconds: f64,
}

/// Lets engines run a scene in lockstep; `progress` hears the number of steps done.
///
/// # Errors
/// A scene that an engine cannot build: the message names both.
pub fn run(
    scene: &Scene,
    kinds: &[Kind],
    setup: &Setup,
    course: &Course,
    progress: &mut dyn FnMut(u32),
) -> Result<Vec<Run>> {
    let mut runners = Vec::with_capacity(kinds.len());
    for kind in kinds {
        runners.push(Runner::new(kind, scene, setup).with_context(|| format!("engine {}", kind.name))?);
    }
    let mut states = Vec::new();
    let mut done = 0;
    let mut round = 0;
    while done < course.steps && runners.iter().any(|r| r.run.note.is_none()) {
        let steps = course.turn.min(course.steps - done);
        for k in 0..runners.len() {
            let place = (k + round) % runners.len();
            let runner = &mut runners[place];
            if runner.run.note.is_none() {
                runner.turn(done, steps, course, &mut states);
            }
        }
        done += steps;
        round += 1;
        progress(done);
    }
    Ok(runners.into_iter().map(Runner::finish).collect())
}

impl Runner {
    fn new(kind: &Kind, scene: &Scene, setup: &Setup) -> Result<Self> {
        let threads = if kind.threaded { setup.threads } else { 1 };
        let engine = (kind.build)(scene, &Setup { threads, ..setup.clone() })?;
        let meter = Meter::new(scene)?;
        let run = Run {
            engine: kind.name,
            threads,
            turns: Vec::new(),
            steps: 0,
            quality: meter.quality(),
            phases: Vec::new(),
            note: None,
        };
        Ok(Self { run, engine, meter, seconds: 0.0 })
    }

    fn turn(&mut self, start: u32, steps: u32, course: &Course, states: &mut Vec<State>) {
        let clock = Instant::now();
        self.engine.step(steps);
        let seconds = clock.elapsed().as_secs_f64();
        self.seconds += seconds;
        self.run.steps = start + steps;
        if start >= course.warm_up {
            self.run.turns.push(Turn { start, ms: 1e3 * seconds / f64::from(steps) });
        }
        self.engine.states(states);
        self.meter.observe(states, f64::from(self.run.steps) * f64::from(DT));
        if self.seconds > course.limit && self.run.steps < course.steps {
            self.run.note = Some(format!("stopped after {} steps: {:.0} s limit", self.run.steps, course.limit));
        }
    }

    fn finish(mut self) -> Run {
        let steps = f64::from(self.run.steps.max(1));
        self.run.quality = self.meter.quality();
        self.run.phases = self.engine.phases().into_iter().map(|(name, s)| (name, 1e3 * s / steps)).collect();
        self.run
    }
}
