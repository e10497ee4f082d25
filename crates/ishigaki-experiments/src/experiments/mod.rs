//! The list: one file for each experiment, in the talk's order.
//!
//! To add one: a file with `pub const EXPERIMENT`, a line in each list here, and the rows it is about in `talk.rs`
//! (none for what goes beyond the talk).

mod aggressive_sleep;
mod ball_joint;
mod blended_shock;
mod contact_ids;
mod dzhanibekov;
mod euler_vs_angular_momentum;
mod free_fall;
mod friction_box_vs_disk;
mod frontier;
mod hand_down;
mod heights;
mod hinge;
mod indeterminate;
mod it_holds;
mod jacobi_vs_gauss_seidel;
mod jacobian_check;
mod joint_tree;
mod lemke_vs_pgs;
mod level_correction;
mod mass_integrals;
mod momentum;
mod orthonormalization;
mod over_relaxation;
mod penetration_recovery;
mod permutation;
mod pgs_two_body;
mod plank_on_two_towers;
mod ragdoll_dies;
mod range_of_motion;
mod shock_propagation;
mod simbenchmark;
mod sleep;
mod slop;
mod talk_matrix;
mod technique_matrix;
mod warm_start;
mod weight_amplification;
mod weight_feeling;

use crate::Experiment;

/// All experiments, in the talk's order.
pub fn list() -> &'static [&'static Experiment] {
    &[
        // A: unconstrained motion.
        &free_fall::EXPERIMENT,
        &mass_integrals::EXPERIMENT,
        &euler_vs_angular_momentum::EXPERIMENT,
        &orthonormalization::EXPERIMENT,
        &dzhanibekov::EXPERIMENT,
        // B: constraints.
        &jacobian_check::EXPERIMENT,
        &ball_joint::EXPERIMENT,
        &hinge::EXPERIMENT,
        &range_of_motion::EXPERIMENT,
        &momentum::EXPERIMENT,
        &talk_matrix::EXPERIMENT,
        // C: the linear complementarity problem.
        &friction_box_vs_disk::EXPERIMENT,
        &lemke_vs_pgs::EXPERIMENT,
        &jacobi_vs_gauss_seidel::EXPERIMENT,
        &indeterminate::EXPERIMENT,
        &pgs_two_body::EXPERIMENT,
        // D: stabilization and speed.
        &penetration_recovery::EXPERIMENT,
        &slop::EXPERIMENT,
        &permutation::EXPERIMENT,
        &warm_start::EXPERIMENT,
        &contact_ids::EXPERIMENT,
        &heights::EXPERIMENT,
        &plank_on_two_towers::EXPERIMENT,
        &shock_propagation::EXPERIMENT,
        &blended_shock::EXPERIMENT,
        &weight_amplification::EXPERIMENT,
        &weight_feeling::EXPERIMENT,
        &sleep::EXPERIMENT,
        &aggressive_sleep::EXPERIMENT,
        &ragdoll_dies::EXPERIMENT,
        &technique_matrix::EXPERIMENT,
        // Beyond the talk.
        &simbenchmark::EXPERIMENT,
        &level_correction::EXPERIMENT,
        &hand_down::EXPERIMENT,
        &joint_tree::EXPERIMENT,
        &over_relaxation::EXPERIMENT,
        &it_holds::EXPERIMENT,
        &frontier::EXPERIMENT,
    ]
}
