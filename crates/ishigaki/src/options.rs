//! Every option of the engine: one struct per technique, with units.
//!
//! A technique has `enabled` and its numbers, so that switching it off and on keeps them. Lengths are
//! multiples of [`WorldOptions::length_scale`] where the doc says "× length scale"; speeds and times
//! scale with its square root, so a scene behaves the same at 0.01, 1 and 100 m.

mod solver;

use crate::error::{Error, Result, finite_vector, not_negative, positive};
use crate::math::Vec3;
use serde::{Deserialize, Serialize};
pub use solver::*;

/// Everything a world can be told besides its bodies and joints.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct WorldOptions {
    /// Gravitational acceleration, m/s².
    #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
    pub gravity: Vec3,
    /// The typical size of a body, m. Slop, margins, rest speeds and deadbands are multiples of it.
    pub length_scale: f32,
    /// Seed of every random choice (permutation).
    pub seed: u64,
    /// How bodies move between contacts.
    pub motion: MotionOptions,
    /// How contacts are found.
    pub contact: ContactOptions,
    /// How constraints are solved.
    pub solver: SolverOptions,
    /// How bodies come to rest.
    pub rest: RestOptions,
    /// What the report measures beyond the counts.
    pub report: ReportOptions,
}

impl Default for WorldOptions {
    fn default() -> Self {
        Self {
            gravity: Vec3::new(0.0, -9.81, 0.0),
            length_scale: 1.0,
            seed: 1,
            motion: MotionOptions::default(),
            contact: ContactOptions::default(),
            solver: SolverOptions::default(),
            rest: RestOptions::default(),
            report: ReportOptions::default(),
        }
    }
}

/// Scheme of the rotation. TALK A5–A7.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum RotationScheme {
    /// Angular momentum kept exactly, rotation by a symmetric splitting about the principal axes (default).
    #[default]
    Splitting,
    /// The talk's four steps: R, I, L, ω.
    AngularMomentum,
    /// Explicit integration of Euler's equation in ω: the talk's warning. It gains energy and blows up.
    ExplicitEuler,
}

/// How far a body moves in a substep. TALK A1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum DriftScheme {
    /// By the new velocity: x' = x + h v' (default).
    #[default]
    Symplectic,
    /// What no contact or joint pushes, by the mean of both velocities: x' = x + h (v + v')/2. Free fall is exact, and a
    /// bounce at e = 1 keeps the energy to rounding.
    Trapezoidal,
}

/// How bodies move between contacts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct MotionOptions {
    /// Scheme of the rotation.
    pub rotation: RotationScheme,
    /// Which velocity moves a body that nothing touches.
    pub drift: DriftScheme,
    /// No body moves faster than this, m/s × √length scale: a guard against numbers that run away.
    pub max_speed: f32,
    /// No body turns faster than this, rad/s ÷ √length scale.
    pub max_angular_speed: f32,
}

impl Default for MotionOptions {
    fn default() -> Self {
        Self {
            rotation: RotationScheme::Splitting,
            drift: DriftScheme::Symplectic,
            max_speed: 1000.0,
            max_angular_speed: 500.0,
        }
    }
}

/// How contacts are found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct ContactOptions {
    /// Contacts are made up to this separation, × length scale.
    pub speculative_margin: f32,
    /// Bounds are fattened by this, × length scale, so that slow bodies need no new broad phase.
    pub bounds_margin: f32,
    /// Bodies marked `continuous` are swept when they move more than this part of their own inner radius in a step.
    pub sweep_threshold: f32,
}

impl Default for ContactOptions {
    fn default() -> Self {
        Self { speculative_margin: 0.02, bounds_margin: 0.05, sweep_threshold: 0.5 }
    }
}

/// How bodies come to rest.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct RestOptions {
    /// Whole islands stop being simulated. TALK D9.
    pub sleep: Sleep,
    /// Resting pairs keep their rows; bodies are still simulated. TALK D10.
    pub aggressive_sleep: AggressiveSleep,
}

/// Whole islands stop being simulated. TALK D9.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Sleep {
    /// On or off.
    pub enabled: bool,
    /// At rest below this speed, m/s × √length scale.
    pub linear_speed: f32,
    /// At rest below this angular speed, rad/s ÷ √length scale.
    pub angular_speed: f32,
    /// An island sleeps when all its bodies have been at rest this long, s × √length scale.
    pub time: f32,
}

impl Default for Sleep {
    fn default() -> Self {
        Self { enabled: true, linear_speed: 0.05, angular_speed: 0.05, time: 0.5 }
    }
}

/// Resting pairs keep their rows; bodies are still simulated. TALK D10.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct AggressiveSleep {
    /// On or off.
    pub enabled: bool,
    /// At rest below this speed, m/s × √length scale.
    pub linear_speed: f32,
    /// At rest below this angular speed, rad/s ÷ √length scale.
    pub angular_speed: f32,
    /// At rest after this many slow steps in a row.
    pub steps: u32,
    /// A pair thaws when it moved this part of the slop since freezing.
    pub thaw_distance: f32,
    /// A pair thaws when it turned this much since freezing, rad.
    pub thaw_angle: f32,
}

impl Default for AggressiveSleep {
    fn default() -> Self {
        Self {
            enabled: true,
            linear_speed: 0.1,
            angular_speed: 0.1,
            steps: 10,
            thaw_distance: 0.25,
            thaw_angle: 0.5_f32.to_radians(),
        }
    }
}

/// What the report measures beyond the counts; each costs a pass over bodies or rows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct ReportOptions {
    /// Energies and momenta.
    pub energy: bool,
    /// The residual of the LCP after the last sweep.
    pub residual: bool,
    /// The residual after every sweep too: slow, for plots.
    pub residual_by_sweep: bool,
}

impl Default for ReportOptions {
    fn default() -> Self {
        Self { energy: true, residual: true, residual_by_sweep: false }
    }
}

impl WorldOptions {
    /// Refuses numbers that make no sense; names the option.
    ///
    /// # Errors
    /// The first option that is not finite or out of its range, named by its path.
    pub fn validate(&self) -> Result<()> {
        finite_vector("gravity", self.gravity)?;
        positive("length_scale", self.length_scale)?;
        positive("motion.max_speed", self.motion.max_speed)?;
        positive("motion.max_angular_speed", self.motion.max_angular_speed)?;
        not_negative("contact.speculative_margin", self.contact.speculative_margin)?;
        not_negative("contact.bounds_margin", self.contact.bounds_margin)?;
        not_negative("contact.sweep_threshold", self.contact.sweep_threshold)?;
        self.solver.validate().map_err(|e| e.within("solver"))?;
        let sleep = &self.rest.sleep;
        not_negative("rest.sleep.linear_speed", sleep.linear_speed)?;
        not_negative("rest.sleep.angular_speed", sleep.angular_speed)?;
        not_negative("rest.sleep.time", sleep.time)?;
        let aggressive = &self.rest.aggressive_sleep;
        not_negative("rest.aggressive_sleep.linear_speed", aggressive.linear_speed)?;
        not_negative("rest.aggressive_sleep.angular_speed", aggressive.angular_speed)?;
        not_negative("rest.aggressive_sleep.thaw_distance", aggressive.thaw_distance)?;
        not_negative("rest.aggressive_sleep.thaw_angle", aggressive.thaw_angle)?;
        Ok(())
    }
}

fn fraction(place: &str, value: f32) -> Result<()> {
    if (0.0..=1.0).contains(&value) {
        Ok(())
    } else {
        Err(Error::invalid(place, format!("must be in [0, 1], is {value}")))
    }
}

fn count(place: &str, value: u32, least: u32, most: u32) -> Result<()> {
    if (least..=most).contains(&value) {
        Ok(())
    } else {
        Err(Error::invalid(place, format!("must be in [{least}, {most}], is {value}")))
    }
}
