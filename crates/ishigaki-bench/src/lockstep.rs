//! Engines side by side, turn by turn.
//!
//! All engines live in one process and take turns of a few steps, the first of each round another one than in the
//! round before. What slows the machine down for a while slows all of them, so that ratios hold where times do not.
//! States are read and judged between turns, outside the time that counts.

use crate::engine::{Counts, DT, Engine, Kind, Setup, State};
use crate::meter::{Meter, Quality};
use crate::scene::Scene;
use crate::stats::quantile;
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
    /// When the meter looks.
    pub looks: Looks,
}

/// When the meter looks at an engine's states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Looks {
    /// After every turn.
    Always,
    /// Once, at the end: in large worlds the meter takes longer than the engines.
    AtEnd,
}

/// An engine that takes turns.
#[derive(Clone, Copy)]
pub struct Player {
    /// Which.
    pub kind: Kind,
    /// Threads it uses.
    pub threads: u32,
}

/// Every engine with every number of threads, once: an engine without threads has one.
pub fn players(kinds: &[Kind], threads: &[u32]) -> Vec<Player> {
    let with = |kind: &Kind| {
        let kind = *kind;
        let used = if kind.threaded { threads } else { &[1] };
        used.iter().map(move |&threads| Player { kind, threads }).collect::<Vec<_>>()
    };
    kinds.iter().flat_map(with).collect()
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
    /// What its last step had to do with, if the engine says.
    pub counts: Option<Counts>,
    /// Median over the turns that count, of the milliseconds of a step in each stage; if the engine says.
    pub phases: Vec<(&'static str, f64)>,
    /// Why it took fewer steps than it should.
    pub note: Option<String>,
}

struct Runner {
    run: Run,
    engine: Box<dyn Engine>,
    meter: Meter,
    looks: Looks,
    seconds: f64,
    /// Milliseconds of a step in each stage, by turn that counts.
    stages: Vec<Vec<f64>>,
}

/// Lets engines run a scene in lockstep; `progress` hears the number of steps done.
///
/// # Errors
/// A scene that an engine cannot build: the message names both.
pub fn run(
    scene: &Scene,
    players: &[Player],
    setup: &Setup,
    course: &Course,
    progress: &mut dyn FnMut(u32),
) -> Result<Vec<Run>> {
    let mut runners = Vec::with_capacity(players.len());
    for player in players {
        let runner = Runner::new(player, scene, setup, course);
        runners.push(runner.with_context(|| format!("engine {}", player.kind.name))?);
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
    Ok(runners.into_iter().map(|runner| runner.finish(&mut states)).collect())
}

impl Runner {
    fn new(player: &Player, scene: &Scene, setup: &Setup, course: &Course) -> Result<Self> {
        let threads = player.threads;
        let engine = (player.kind.build)(scene, &Setup { threads, ..setup.clone() })?;
        let meter = Meter::new(scene)?;
        let run = Run {
            engine: player.kind.name,
            threads,
            turns: Vec::new(),
            steps: 0,
            quality: meter.quality(),
            counts: None,
            phases: Vec::new(),
            note: None,
        };
        Ok(Self { run, engine, meter, looks: course.looks, seconds: 0.0, stages: Vec::new() })
    }

    fn turn(&mut self, start: u32, steps: u32, course: &Course, states: &mut Vec<State>) {
        let before = self.engine.phases();
        let clock = Instant::now();
        self.engine.step(steps);
        let seconds = clock.elapsed().as_secs_f64();
        let after = self.engine.phases();
        self.seconds += seconds;
        self.run.steps = start + steps;
        if start >= course.warm_up {
            let per_step = 1e3 / f64::from(steps);
            self.run.turns.push(Turn { start, ms: per_step * seconds });
            self.stages.push(before.iter().zip(&after).map(|(b, a)| per_step * (a.1 - b.1)).collect());
        }
        if self.looks == Looks::Always {
            self.look(states);
        }
        if self.seconds > course.limit && self.run.steps < course.steps {
            self.run.note = Some(format!("stopped after {} steps: {:.0} s limit", self.run.steps, course.limit));
        }
    }

    fn look(&mut self, states: &mut Vec<State>) {
        self.engine.states(states);
        self.meter.observe(states, f64::from(self.run.steps) * f64::from(DT));
    }

    fn finish(mut self, states: &mut Vec<State>) -> Run {
        if self.looks == Looks::AtEnd {
            self.look(states);
        }
        self.run.quality = self.meter.quality();
        self.run.counts = self.engine.counts();
        let median = |stage: usize| quantile(&self.stages.iter().map(|turn| turn[stage]).collect::<Vec<_>>(), 0.5);
        let names = self.engine.phases().into_iter().enumerate();
        self.run.phases = names.filter_map(|(stage, (name, _))| Some((name, median(stage)?))).collect();
        self.run
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::KINDS;

    #[test]
    fn every_engine_plays_once_with_each_number_of_threads() {
        let threaded = Kind { threaded: true, ..KINDS[0] };
        let serial = Kind { threaded: false, ..KINDS[0] };
        let threads: Vec<u32> = players(&[threaded, serial], &[1, 2]).iter().map(|p| p.threads).collect();
        assert_eq!(threads, [1, 2, 1]);
    }
}
