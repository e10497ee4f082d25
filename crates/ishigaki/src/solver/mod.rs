//! The solver: a table of rows, and one file for each technique that edits a column or the order of visiting.

pub mod block;
pub mod block_ldl;
pub mod hand_down;
pub mod height;
pub(crate) mod joint_link;
pub mod joint_recovery;
pub mod joint_tree;
pub mod level_correction;
pub mod manifold_block;
pub mod over_relaxation;
pub mod penetration_recovery;
pub mod permutation;
pub mod plan;
pub mod reference;
pub mod residual;
pub mod restitution;
pub mod shock_propagation;
pub mod slop;
mod substeps;
pub mod table;
pub mod warm_start;
pub mod weight_amplification;
pub mod wide;
pub mod work;
