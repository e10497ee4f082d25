//! Slop. TALK D2.
//!
//! v_error = k max(0, d − d_slop)/Δt: overlap up to d_slop is left alone, so that support never switches off.
//! Without it a resting block is pushed out, loses its contact, falls back and shakes: one block at k = 1
//! toggles its contacts 60 times a second. Option: `solver.slop`; shown by `tests/techniques.rs`.

use crate::options::Slop;

// ANCHOR: excess
/// Overlap that counts as an error, m, for an overlap `depth` ≥ 0, m.
#[inline]
pub fn excess(depth: f32, slop_depth: f32) -> f32 {
    (depth - slop_depth).max(0.0)
}
// ANCHOR_END: excess

/// The depth left alone in a world of this length scale, m; 0 when switched off.
pub fn depth(options: &Slop, length_scale: f32) -> f32 {
    if options.enabled { options.depth * length_scale } else { 0.0 }
}
