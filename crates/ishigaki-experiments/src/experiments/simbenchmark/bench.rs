//! What the tasks share: the two configurations, worlds with z up as in the source, the mean of an error over time.

use crate::Result;
use ishigaki::{Body, Combine, DriftScheme, Shape, SolverOptions, Vec3, World, WorldOptions};

/// As the source has it, m/s².
pub const G: f64 = 9.81;
/// Of all tasks but the tower, s.
pub const DT: f64 = 1e-3;

/// How the engine is set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Setting {
    /// One substep with this many sweeps; overlap is left as it is (ERP = 0); every impact bounces; trapezoidal drift.
    OneSubstep { sweeps: u32 },
    /// As the engine is by default.
    Default,
}

impl Setting {
    /// For progress.
    pub fn label(self) -> String {
        match self {
            Self::OneSubstep { sweeps } => format!("one substep of {sweeps} sweeps"),
            Self::Default => "default".to_string(),
        }
    }

    /// Over the table of rows in each step, of all substeps.
    pub fn sweeps(self) -> f64 {
        match self {
            Self::OneSubstep { sweeps } => f64::from(sweeps),
            Self::Default => {
                let solver = SolverOptions::default();
                f64::from(solver.substeps * (solver.sweeps + solver.relax_sweeps))
            }
        }
    }

    /// An empty world where nothing sleeps, z up; `length` is the size of its bodies, m.
    pub fn world(self, length: f32) -> Result<World> {
        let mut options = WorldOptions { gravity: G as f32 * Vec3::NEG_Z, length_scale: length, ..Default::default() };
        options.rest.sleep.enabled = false;
        options.rest.aggressive_sleep.enabled = false;
        options.report.energy = false;
        options.report.residual = false;
        if let Self::OneSubstep { sweeps } = self {
            options.solver = SolverOptions { substeps: 1, sweeps, relax_sweeps: 0, ..SolverOptions::default() };
            options.solver.penetration_recovery.enabled = false;
            options.solver.restitution.threshold = 0.0;
            options.solver.restitution.passes = 1000;
            options.motion.drift = DriftScheme::Trapezoidal;
        }
        Ok(World::new(options)?)
    }
}

/// The plane z = 0; pairs take the lesser friction, so that a body says what it has with the ground.
pub fn add_ground(world: &mut World, friction: f32) -> Result<()> {
    let mut plane = Shape::half_space(Vec3::Z).friction(friction);
    plane.material.friction_combine = Combine::Minimum;
    world.add_body(Body::fixed(plane))?;
    Ok(())
}

/// A quantity over time: its mean, and some of it for a plot.
pub struct Course {
    sum: f64,
    count: usize,
    every: usize,
    /// Time (s) and value.
    pub points: Vec<(f64, f64)>,
}

impl Course {
    /// Of about `steps` values.
    pub fn new(steps: usize) -> Self {
        Self { sum: 0.0, count: 0, every: (steps / 200).max(1), points: Vec::new() }
    }

    pub fn add(&mut self, time: f64, value: f64) {
        if self.count.is_multiple_of(self.every) {
            self.points.push((time, value));
        }
        self.sum += value;
        self.count += 1;
    }

    pub fn mean(&self) -> f64 {
        self.sum / self.count as f64
    }
}
