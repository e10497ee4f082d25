//! Penetration recovery and the speculative gap. TALK D1.
//!
//! Overlap d is pushed out with the velocity k d/h, at most v_max; a gap s > 0 may close, but no faster than
//! s/h. Both are the bias of a normal row, w = J u + bias ≥ 0. Without recovery overlap stays for ever;
//! with k near 1 and no relax sweep it throws bodies apart, since the push stays in their velocity.
//! Option: `solver.penetration_recovery`; shown by `tests/techniques.rs`.

use crate::options::PenetrationRecovery;
use crate::solver::slop;

/// Gaps up to this are closed contacts, × length scale.
pub(crate) const DEADBAND: f32 = 1e-4;

/// Recovery in the units of one world.
#[derive(Clone, Copy, Debug)]
pub struct Recovery {
    /// k, 0 when switched off.
    pub rate: f32,
    /// v_max, m/s.
    pub max_speed: f32,
    /// Overlap left alone, m.
    pub slop: f32,
    /// A gap that counts as touching where an impulse bears already, m: rounding of f32 must not switch support off.
    /// It is never more than that impulse would close in a substep, so that nothing jumps when a contact begins to bear.
    pub deadband: f32,
}

impl Recovery {
    /// From options; speeds scale with the root of the length.
    pub fn new(options: &PenetrationRecovery, slop: f32, length_scale: f32) -> Self {
        Self {
            rate: if options.enabled { options.rate } else { 0.0 },
            max_speed: options.max_speed * length_scale.sqrt(),
            slop,
            deadband: DEADBAND * length_scale,
        }
    }

    // ANCHOR: bias
    /// Bias with and without recovery of a normal row at `separation` (m, negative = overlap), substep `h` (s), whose
    /// impulse changes its velocity by `borne` (λ J M⁻¹Jᵀ, m/s).
    #[inline]
    pub fn bias(&self, separation: f32, h: f32, borne: f32) -> (f32, f32) {
        if separation > 0.0 {
            let deadband = (h * borne).min(self.deadband);
            let gap = (separation - deadband).max(0.0) / h;
            (gap, gap)
        } else {
            let push = self.rate * slop::excess(-separation, self.slop) / h;
            (-push.min(self.max_speed), 0.0)
        }
    }
    // ANCHOR_END: bias
}
