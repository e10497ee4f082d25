//! Over-relaxation of joints that are solved one by one.
//!
//! Gauss–Seidel gives each joint the impulse that it alone asks for; its neighbours take part of that back, and what a net as
//! a whole asks for is found in ever smaller steps of the same sign. A step ω times as long finds it in fewer. For equality
//! rows, whose J M⁻¹Jᵀ is positive semidefinite, sweeps converge for each 0 < ω < 2 (Ostrowski–Reich); for chains of n
//! joints those needed fall from O(n²) to O(n) at the best ω, which is near 2 for long ones.
//!
//! Few sweeps are far from converged, and overshoot is a gap if bodies move by it: so only the sweeps after the motion
//! step farther. What they leave in the velocities the next substep starts from, and one sweep before the motion then does
//! what two did. Contacts push one way only and ends of ranges as well; joints in turn with them gain nothing, and are solved
//! as they were.
//! Option: `solver.over_relaxation`; shown by `ishigaki experiment over-relaxation`, proved by `tests/net.rs`.
//! Source: Young 1954, Iterative methods for solving partial difference equations of elliptic type.

use crate::options::OverRelaxation;

/// ω of the sweeps after the motion; `touches`: some of the joints' bodies are in contact.
pub fn factor(options: &OverRelaxation, touches: bool) -> f32 {
    if options.enabled && !touches { options.factor } else { 1.0 }
}
