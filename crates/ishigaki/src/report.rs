//! What a step did: counts, residual, energies, stage timings.

use crate::handle::BodyHandle;
use crate::math::Vec3;
use serde::{Deserialize, Serialize};

/// The ten stages of a step, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// Validate, forget the last step's events.
    Begin,
    /// Broad phase.
    FindPairs,
    /// Narrow phase; λ carried by feature id; frozen pairs skipped.
    UpdateContacts,
    /// Union-find, heights, wake.
    BuildIslands,
    /// Gravity and user forces.
    GatherForces,
    /// Jacobians, bounds, biases.
    BuildRows,
    /// Order and mass scale of the rows.
    PlanSweep,
    /// All substeps: velocities and positions.
    Solve,
    /// Poses, bounds, kinematic targets.
    FinishMotion,
    /// Sleep and aggressive sleep.
    PutToRest,
}

impl Stage {
    /// All stages in order.
    pub const ALL: [Self; 10] = [
        Self::Begin,
        Self::FindPairs,
        Self::UpdateContacts,
        Self::BuildIslands,
        Self::GatherForces,
        Self::BuildRows,
        Self::PlanSweep,
        Self::Solve,
        Self::FinishMotion,
        Self::PutToRest,
    ];

    /// The name used in code, timings, book and viewer.
    pub fn name(self) -> &'static str {
        match self {
            Self::Begin => "begin",
            Self::FindPairs => "find_pairs",
            Self::UpdateContacts => "update_contacts",
            Self::BuildIslands => "build_islands",
            Self::GatherForces => "gather_forces",
            Self::BuildRows => "build_rows",
            Self::PlanSweep => "plan_sweep",
            Self::Solve => "solve",
            Self::FinishMotion => "finish_motion",
            Self::PutToRest => "put_to_rest",
        }
    }
}

/// What a step did.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StepReport {
    /// Why the step did nothing, if it did nothing: a Δt that is not finite and > 0.
    pub rejected: Option<String>,
    /// Nothing could happen, since all sleeps and nobody changed anything: the step was not taken, only its time passed.
    /// All else is that of the last one. Not written: it is no part of what a step leaves.
    #[serde(skip)]
    pub still: bool,
    /// Seconds spent in each stage, in the order of [`Stage::ALL`]; zeros without a clock hook.
    /// Not written: snapshots of the same run must be the same bytes, whatever the clock said.
    #[serde(skip)]
    pub stage_seconds: [f64; 10],
    /// Bodies in the world.
    pub bodies: usize,
    /// Dynamic bodies asleep.
    pub asleep: usize,
    /// Pairs whose shapes touch or nearly touch, with points.
    pub contacts: usize,
    /// Pairs frozen by aggressive sleep.
    pub frozen: usize,
    /// Pairs of the broad phase.
    pub pairs: usize,
    /// Pairs that went through the narrow phase in this step.
    pub narrow_phase_calls: usize,
    /// Contact points that were found again by their id, and all points of pairs that had points before.
    pub ids_matched: usize,
    /// Contact points of pairs that had points before.
    pub ids_expected: usize,
    /// Rows solved.
    pub rows: usize,
    /// Of these, rows of the wide path; the reference solved the others.
    pub wide_rows: usize,
    /// Awake islands.
    pub islands: usize,
    /// Sweeps over the rows in this step.
    pub sweeps: usize,
    /// Multiply-adds of the solver in this step.
    pub work: u64,
    /// Multiply-adds of twelve visits to every row alone, for comparison.
    pub work_budget: u64,
    /// ‖λ − clip(λ − w·m_eff)‖∞ after the last sweep with bias, N·s.
    pub residual: f32,
    /// The residual after every sweep, if asked for, N·s.
    pub residual_by_sweep: Vec<f32>,
    /// Deepest overlap at the end of the step, m.
    pub max_penetration: f32,
    /// Greatest distance between the anchors of a joint at the end of the step, m.
    pub max_joint_error: f32,
    /// Greatest speed of a dynamic body, m/s.
    pub max_speed: f32,
    /// Of the dynamic bodies, kg·m/s.
    pub momentum: Vec3,
    /// Of the dynamic bodies about the world's origin, kg·m²/s.
    pub angular_momentum: Vec3,
    /// Of the dynamic bodies, J.
    pub kinetic_energy: f32,
    /// Of the dynamic bodies, against the world's origin, J.
    pub potential_energy: f32,
    /// Bodies whose state is not finite. They no longer take part until they are edited or removed.
    pub non_finite: Vec<BodyHandle>,
}
