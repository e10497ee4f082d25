//! Weight amplification, WA. TALK D8.
//!
//! In each contact the lower body counts as c times as heavy: M_lo⁻¹ is divided by c in the update, the
//! effective mass and the warm start. The lower contacts then converge first, and the sweeps that a stack
//! needs fall from 776 to 129 at 20 boxes. The price: the fixed point itself is attenuated. Each contact
//! carries Σ c⁻ʲ of the weights above it, at most c/(c−1) boxes; a heavy box on light ones still sinks.
//! Equal or missing heights are not amplified, so free collisions conserve momentum.
//! Option: `solver.weight_amplification`; shown by `tests/techniques.rs`.

use crate::body::NO_HEIGHT;
use crate::options::WeightAmplification;
use crate::solver::table::MassScale;

// ANCHOR: scale
/// The scale of a contact between bodies of these heights.
pub fn scale(options: &WeightAmplification, height_a: u32, height_b: u32) -> MassScale {
    let inverse = 1.0 / options.factor;
    let (mass, inertia) = (if options.mass { inverse } else { 1.0 }, if options.inertia { inverse } else { 1.0 });
    match lower(height_a, height_b) {
        Some(Lower::A) => MassScale { mass_a: mass, inertia_a: inertia, ..MassScale::ONE },
        Some(Lower::B) => MassScale { mass_b: mass, inertia_b: inertia, ..MassScale::ONE },
        None => MassScale::ONE,
    }
}
// ANCHOR_END: scale

/// Which of two bodies is below the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lower {
    /// The first.
    A,
    /// The second.
    B,
}

/// The body with the smaller height; none if they are equal or one hangs in the air.
pub fn lower(height_a: u32, height_b: u32) -> Option<Lower> {
    match (height_a, height_b) {
        (NO_HEIGHT, _) | (_, NO_HEIGHT) => None,
        (a, b) if a < b => Some(Lower::A),
        (a, b) if b < a => Some(Lower::B),
        _ => None,
    }
}
