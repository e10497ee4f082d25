//! Options of the solver's techniques.

use super::{count, fraction};
use crate::error::{Error, Result, not_negative};
use serde::{Deserialize, Serialize};

/// How constraints are solved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct SolverOptions {
    /// Steps of length Δt/substeps between two contact detections.
    pub substeps: u32,
    /// Sweeps over all rows in each substep, penetration recovery included.
    pub sweeps: u32,
    /// Sweeps in each substep after the bodies moved, without recovery: they take its speed out again.
    pub relax_sweeps: u32,
    /// More sweeps or substeps where jointed bodies touch or hang in loops, fewer substeps where they do neither.
    pub jointed: Jointed,
    /// Joints that are solved one by one step farther than each alone asks for.
    pub over_relaxation: OverRelaxation,
    /// How overlap is pushed out. TALK D1.
    pub penetration_recovery: PenetrationRecovery,
    /// How joint errors are pulled back. TALK B9.
    pub joint_recovery: JointRecovery,
    /// Overlap that is left alone. TALK D2.
    pub slop: Slop,
    /// Order of the rows. TALK D3.
    pub permutation: Permutation,
    /// Start from the last step's impulses. TALK D4.
    pub warm_start: WarmStart,
    /// The points of a manifold are solved together.
    pub manifold_block: ManifoldBlock,
    /// Hard rows of connected joints are solved at once.
    pub joint_tree: JointTree,
    /// Loads of whole stacks at once.
    pub level_correction: LevelCorrection,
    /// Loads of stacks too wide for that go from each body to its supports, from the top down.
    pub hand_down: HandDown,
    /// Distance of a body from the ground in hops. TALK D5.
    pub height: Height,
    /// Forces travel upward only. TALK D6, D7.
    pub shock_propagation: ShockPropagation,
    /// The lower body of a contact counts as heavier. TALK D8.
    pub weight_amplification: WeightAmplification,
    /// Islands of contacts are solved eight manifolds at a time.
    pub wide: Wide,
    /// Friction law. TALK C2.
    pub friction: FrictionModel,
    /// Bouncing.
    pub restitution: Restitution,
}

impl Default for SolverOptions {
    fn default() -> Self {
        Self {
            substeps: 4,
            sweeps: 1,
            relax_sweeps: 1,
            jointed: Jointed::default(),
            over_relaxation: OverRelaxation::default(),
            penetration_recovery: PenetrationRecovery::default(),
            joint_recovery: JointRecovery::default(),
            slop: Slop::default(),
            permutation: Permutation::Alternating,
            warm_start: WarmStart::default(),
            manifold_block: ManifoldBlock::default(),
            joint_tree: JointTree::default(),
            level_correction: LevelCorrection::default(),
            hand_down: HandDown::default(),
            height: Height::default(),
            shock_propagation: ShockPropagation::default(),
            weight_amplification: WeightAmplification::default(),
            wide: Wide::default(),
            friction: FrictionModel::Disk,
            restitution: Restitution::default(),
        }
    }
}

impl SolverOptions {
    /// Every technique off: ten sweeps of projected Gauss–Seidel and nothing else. Friction stays (disk).
    pub fn plain() -> Self {
        let mut options =
            Self { substeps: 1, sweeps: 10, relax_sweeps: 0, permutation: Permutation::None, ..Self::default() };
        options.jointed = Jointed::ALIKE;
        options.over_relaxation.enabled = false;
        options.penetration_recovery.enabled = false;
        options.slop.enabled = false;
        options.warm_start.enabled = false;
        options.manifold_block.enabled = false;
        options.level_correction.enabled = false;
        options.hand_down.enabled = false;
        options.joint_tree.enabled = false;
        options.weight_amplification.enabled = false;
        options.shock_propagation.enabled = false;
        options
    }

    /// All that the talk recommends: recovery with slop, random order in every sweep, warm start and WA 1.4. Ten sweeps in
    /// each of four substeps: in three dimensions, with four points to a face, ten in one do not hold a tower of 40.
    pub fn talk() -> Self {
        Self {
            substeps: 4,
            sweeps: 10,
            relax_sweeps: 0,
            jointed: Jointed::ALIKE,
            over_relaxation: OverRelaxation { enabled: false, ..OverRelaxation::default() },
            permutation: Permutation::PerSweep,
            manifold_block: ManifoldBlock { enabled: false, ..ManifoldBlock::default() },
            level_correction: LevelCorrection { enabled: false },
            hand_down: HandDown { enabled: false },
            joint_tree: JointTree { enabled: false },
            weight_amplification: WeightAmplification { enabled: true, ..WeightAmplification::default() },
            ..Self::default()
        }
    }
}

/// What the solver does more, or less, while joints are at work. Joints that are solved one by one, in turn with contacts,
/// open at impacts and at ends of ranges at the few sweeps that stacks stand at; what hangs and touches nothing is solved
/// almost exactly by its tree.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Jointed {
    /// This many times `substeps`, where bodies of other than ball joints touch something or hang in loops: rows of hinges
    /// are worse conditioned, and those of a closed linkage say the same twice.
    pub substeps: u32,
    /// This many times `sweeps`, where bodies of ball joints touch something.
    pub sweeps: u32,
    /// There, after the last sweep before the motion, the points of joints alone are visited so many times more, back and
    /// forth: what is left undone of them is a gap when bodies move.
    pub passes: u32,
    /// Chains and trees that are solved at once and touch nothing: `substeps` divided by this, one at least.
    pub free_divisor: u32,
}

impl Jointed {
    /// As without joints.
    pub const ALIKE: Self = Self { substeps: 1, sweeps: 1, passes: 0, free_divisor: 1 };
}

impl Default for Jointed {
    fn default() -> Self {
        Self { substeps: 2, sweeps: 2, passes: 1, free_divisor: 2 }
    }
}

/// Successive over-relaxation: in the sweeps after the motion, joints that are solved one by one and touch nothing step
/// `factor` times as far as each alone asks for. Young 1954.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct OverRelaxation {
    /// On or off.
    pub enabled: bool,
    /// ω in [1, 2); 1 is Gauss–Seidel.
    pub factor: f32,
}

impl Default for OverRelaxation {
    fn default() -> Self {
        Self { enabled: true, factor: 1.6 }
    }
}

/// Push overlap out at `rate` of it per substep. TALK D1: v_error = k d/Δt.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct PenetrationRecovery {
    /// On or off.
    pub enabled: bool,
    /// k: the part of the overlap taken back in one substep, in [0, 1].
    pub rate: f32,
    /// Recovery is never faster than this, m/s × √length scale.
    pub max_speed: f32,
}

impl Default for PenetrationRecovery {
    fn default() -> Self {
        Self { enabled: true, rate: 0.3, max_speed: 3.0 }
    }
}

/// Take joint errors back by `rate` of them per substep. TALK B9: k θ_err/Δt; where joints are solved one by one, in turn
/// with contacts or in nets, by poses alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct JointRecovery {
    /// On or off.
    pub enabled: bool,
    /// k: the part of the error taken back in one substep, in [0, 1].
    pub rate: f32,
    /// k of joints that are solved one by one and touch nothing: the part taken back at the end of each step, in [0, 1].
    pub net_rate: f32,
}

impl Default for JointRecovery {
    fn default() -> Self {
        Self { enabled: true, rate: 0.3, net_rate: 0.6 }
    }
}

/// Overlap that is left alone, so that support never switches off. TALK D2.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Slop {
    /// On or off.
    pub enabled: bool,
    /// Overlap left alone, × length scale.
    pub depth: f32,
}

impl Default for Slop {
    fn default() -> Self {
        Self { enabled: true, depth: 0.005 }
    }
}

/// Order in which rows are visited. TALK D3.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Permutation {
    /// As the rows were built.
    None,
    /// A new random order each step.
    PerStep,
    /// A new random order each sweep.
    PerSweep,
    /// Forwards, then backwards.
    #[default]
    Alternating,
}

/// Start from the last step's impulses. TALK D4.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct WarmStart {
    /// On or off.
    pub enabled: bool,
    /// Part of the last impulse that is taken over, in [0, 1].
    pub factor: f32,
}

impl Default for WarmStart {
    fn default() -> Self {
        Self { enabled: true, factor: 1.0 }
    }
}

/// The rows of a manifold are visited as one unit: normals several times, then friction. Off: row by row, as in the talk.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct ManifoldBlock {
    /// On or off.
    pub enabled: bool,
    /// Passes over the normals in each visit.
    pub passes: u32,
}

impl Default for ManifoldBlock {
    fn default() -> Self {
        Self { enabled: true, passes: 4 }
    }
}

/// The equality rows of chains and trees of joints are solved at once, by a sparse direct solver; those of small trees
/// that fly are left to sweeps, which find the little that is between them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct JointTree {
    /// On or off.
    pub enabled: bool,
}

impl Default for JointTree {
    fn default() -> Self {
        Self { enabled: true }
    }
}

/// Impulses of a whole island are corrected at once, by a direct solution of its levels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct LevelCorrection {
    /// On or off.
    pub enabled: bool,
}

impl Default for LevelCorrection {
    fn default() -> Self {
        Self { enabled: true }
    }
}

/// What each body of a wide stack is to be rid of goes to its supports, from the top to the ground. With level
/// correction; in place of it where an island has many manifolds on a level.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct HandDown {
    /// On or off.
    pub enabled: bool,
}

impl Default for HandDown {
    fn default() -> Self {
        Self { enabled: true }
    }
}

/// Hops from a fixed or kinematic body. TALK D5.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Height {
    /// Count hops over joints too, not over contacts alone.
    pub through_joints: bool,
}

/// The lower body of a contact counts as infinitely heavy, lower contacts first. TALK D6, D7.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct ShockPropagation {
    /// On or off.
    pub enabled: bool,
    /// c in λ = (1−c)λ₀ + cλ₁, with λ₀ the plain and λ₁ the shock solution; 1 = shock alone, one solve.
    pub blend: f32,
}

impl Default for ShockPropagation {
    fn default() -> Self {
        Self { enabled: false, blend: 1.0 }
    }
}

/// The lower body of a contact counts as c times as heavy. TALK D8.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct WeightAmplification {
    /// On or off.
    pub enabled: bool,
    /// c ≥ 1.
    pub factor: f32,
    /// Amplify the mass.
    pub mass: bool,
    /// Amplify the inertia.
    pub inertia: bool,
}

impl Default for WeightAmplification {
    fn default() -> Self {
        Self { enabled: false, factor: 1.4, mass: true, inertia: true }
    }
}

/// Islands of contacts are solved eight manifolds at a time, in batches that stay in the cache. What it cannot do
/// (joints, bouncing, rolling friction, conveyors, moving ground, locked axes; shock propagation, other permutations
/// than the alternating one, rows visited one by one) is solved by the readable reference, island by island.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Wide {
    /// On or off.
    pub enabled: bool,
    /// Contacts between slow bodies that have no impulses yet start with the weight above them.
    pub seed: bool,
    /// Four lanes, which every machine has, instead of the most there are: the bits are the same.
    pub narrow: bool,
    /// What the wide path would take is solved by the reference in the order of its blocks: what the wide path is held to.
    pub by_reference: bool,
}

impl Default for Wide {
    fn default() -> Self {
        Self { enabled: true, seed: true, narrow: false, by_reference: false }
    }
}

/// Friction law. TALK C2.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum FrictionModel {
    /// No friction at all.
    Off,
    /// Two tangents fixed in the world, each with |λ_t| ≤ μλ_n: the talk's. Up to √2 too strong, and it bends sliding.
    Box,
    /// |λ_t| ≤ μλ_n for the vector: Coulomb's cone (default).
    #[default]
    Disk,
}

/// Bouncing, as an impact phase before the contact solve (Guendelman et al. 2003).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Restitution {
    /// On or off.
    pub enabled: bool,
    /// Slower impacts do not bounce, m/s × √length scale.
    pub threshold: f32,
    /// Greatest number of passes over the impacts of a substep.
    pub passes: u32,
}

impl Default for Restitution {
    fn default() -> Self {
        Self { enabled: true, threshold: 0.5, passes: 16 }
    }
}

impl SolverOptions {
    pub(super) fn validate(&self) -> Result<()> {
        count("substeps", self.substeps, 1, 1000)?;
        count("sweeps", self.sweeps, 0, 100_000)?;
        count("jointed.substeps", self.jointed.substeps, 1, 100)?;
        count("jointed.sweeps", self.jointed.sweeps, 1, 100)?;
        count("jointed.passes", self.jointed.passes, 0, 1000)?;
        count("jointed.free_divisor", self.jointed.free_divisor, 1, 1000)?;
        count("relax_sweeps", self.relax_sweeps, 0, 100_000)?;
        count("restitution.passes", self.restitution.passes, 0, 10_000)?;
        fraction("penetration_recovery.rate", self.penetration_recovery.rate)?;
        not_negative("penetration_recovery.max_speed", self.penetration_recovery.max_speed)?;
        fraction("joint_recovery.rate", self.joint_recovery.rate)?;
        fraction("joint_recovery.net_rate", self.joint_recovery.net_rate)?;
        let factor = self.over_relaxation.factor;
        if !(1.0..2.0).contains(&factor) {
            return Err(Error::invalid(
                "over_relaxation.factor",
                format!("must be ≥ 1 and < 2 (from 2 on sweeps diverge), is {factor}"),
            ));
        }
        not_negative("slop.depth", self.slop.depth)?;
        fraction("warm_start.factor", self.warm_start.factor)?;
        count("manifold_block.passes", self.manifold_block.passes, 1, 1000)?;
        fraction("shock_propagation.blend", self.shock_propagation.blend)?;
        not_negative("restitution.threshold", self.restitution.threshold)?;
        let factor = self.weight_amplification.factor;
        if !(factor.is_finite() && factor >= 1.0) {
            return Err(Error::invalid(
                "weight_amplification.factor",
                format!("must be finite and ≥ 1 (the lower body counts as heavier), is {factor}"),
            ));
        }
        Ok(())
    }
}
