//! The list: one file for each experiment, in the talk's order.
//!
//! To add one: a file with `pub const EXPERIMENT`, its name here, and the rows it is about in `talk.rs`.

use crate::Experiment;

macro_rules! experiments {
    ($($module:ident),* $(,)?) => {
        $(mod $module;)*

        /// All experiments, in the talk's order.
        pub fn list() -> &'static [&'static Experiment] {
            &[$(&$module::EXPERIMENT),*]
        }
    };
}

experiments! {
    // A: unconstrained motion.
    free_fall,
    mass_integrals,
    euler_vs_angular_momentum,
    orthonormalization,
    dzhanibekov,
    // B: constraints.
    jacobian_check,
    ball_joint,
    hinge,
    range_of_motion,
    momentum,
    talk_matrix,
    // C: the linear complementarity problem.
    friction_box_vs_disk,
    lemke_vs_pgs,
    jacobi_vs_gauss_seidel,
    indeterminate,
    pgs_two_body,
    // D: stabilization and speed.
    penetration_recovery,
    slop,
    permutation,
    warm_start,
    contact_ids,
    heights,
    plank_on_two_towers,
    shock_propagation,
    blended_shock,
    weight_amplification,
    weight_feeling,
    sleep,
    aggressive_sleep,
    ragdoll_dies,
    technique_matrix,
}
