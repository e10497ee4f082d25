//! What the bench asks of an engine, and the engines it knows.

#[cfg(feature = "box3d")]
mod box3d;
mod ishigaki;
#[cfg(feature = "jolt")]
mod jolt;
#[cfg(feature = "rapier")]
mod rapier;

use crate::scene::Scene;
use ::ishigaki::WorldOptions;

/// Length of a step, s.
pub const DT: f32 = 1.0 / 60.0;

/// A world that steps.
pub trait Engine {
    /// Advances by so many steps of [`DT`].
    fn step(&mut self, steps: u32);

    /// Fills in the state of every body, in the scene's order.
    fn states(&mut self, states: &mut Vec<State>);

    /// Seconds in each stage so far, by name; empty for an engine that does not say.
    fn phases(&self) -> Vec<(&'static str, f64)> {
        Vec::new()
    }

    /// What the last step had to do with; `None` for an engine that does not say.
    fn counts(&self) -> Option<Counts> {
        None
    }
}

/// How much there was in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Islands awake.
    pub islands: usize,
    /// Pairs of shapes with contact points.
    pub contacts: usize,
    /// Dynamic bodies asleep.
    pub asleep: usize,
}

/// Where a body is and how it moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Of the body's origin, m.
    pub position: [f64; 3],
    /// Unit quaternion [x, y, z, w].
    pub rotation: [f64; 4],
    /// Of the center of mass, m/s.
    pub velocity: [f64; 3],
    /// World, rad/s.
    pub angular_velocity: [f64; 3],
}

/// What all engines are told.
#[derive(Clone, Debug)]
pub struct Setup {
    /// Threads a step may use.
    pub threads: u32,
    /// Whether bodies may fall asleep.
    pub sleep: bool,
    /// Ask for stage timings.
    pub phases: bool,
    /// Ishigaki's options; gravity and sleep are set by the adapter.
    pub ishigaki: WorldOptions,
}

/// An engine by its name.
#[derive(Clone, Copy)]
pub struct Kind {
    /// As given on the command line.
    pub name: &'static str,
    /// Whether it uses [`Setup::threads`].
    pub threaded: bool,
    /// Version, settings and compiler flags, for the reader of a table.
    pub about: fn() -> String,
    /// Makes a world.
    pub build: fn(&Scene, &Setup) -> anyhow::Result<Box<dyn Engine>>,
}

/// All engines of this build, Ishigaki first.
pub const KINDS: &[Kind] = &[
    Kind { name: "ishigaki", threaded: true, about: ishigaki::about, build: ishigaki::build },
    #[cfg(feature = "box3d")]
    Kind { name: "box3d", threaded: true, about: box3d::about, build: box3d::build },
    #[cfg(feature = "rapier")]
    Kind { name: "rapier", threaded: cfg!(feature = "rapier-parallel"), about: rapier::about, build: rapier::build },
    #[cfg(feature = "jolt")]
    Kind { name: "jolt", threaded: true, about: jolt::about, build: jolt::build },
];

/// To the meter's precision.
fn wide<const N: usize>(values: [f32; N]) -> [f64; N] {
    values.map(f64::from)
}

/// States from 13 numbers each: position, rotation, velocity, angular velocity.
#[cfg(any(feature = "rapier", feature = "jolt"))]
fn unpack(numbers: &[f64], states: &mut Vec<State>) {
    states.clear();
    states.extend(numbers.chunks_exact(13).map(|n| State {
        position: [n[0], n[1], n[2]],
        rotation: [n[3], n[4], n[5], n[6]],
        velocity: [n[7], n[8], n[9]],
        angular_velocity: [n[10], n[11], n[12]],
    }));
}

#[cfg(test)]
mod tests;
