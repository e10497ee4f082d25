//! What acts on one coordinate of a joint: range, motor, dry friction, spring. TALK B9.
//!
//! q: an angle (rad) or a length (m), of B relative to A; q̇ = J u; effort Q (N·m or N), λ = h Q per substep h.
//! * range: each end is an inequality, C = q − lower or upper − q: inside, Ċ + C/h ≥ 0 (it may arrive, not cross);
//!   outside Ċ + βC/h ≥ 0; λ ∈ [0, ∞). Rows are there inside too: the count does not change and λ stays with its row.
//! * motor: q̇ = speed, |λ| ≤ h·max_effort; dry friction: the same with speed 0.
//! * passive: spring k, damping d, armature m in one soft row, all implicit. With q̇ at the end of the substep,
//!   λ = −[m(q̇ − q̇₀) + h d q̇ + h k(q + h q̇ − target)]; with K = m + h d + h² k this is
//!   q̇ + γλ + bias = 0, γ = 1/K, bias = γ(−m q̇₀ + h k(q − target)). Armature alone couples a rotor exactly: an
//!   impulse J u sees 1/(J M⁻¹Jᵀ) + m. As an explicit force a stiff spring would explode at h²k > m_eff.
//!
//! Test: `joint_rows::limits_push_inward`, `joint_rows::passive_row_is_implicit_euler`.

use crate::constraint::frame::{FramePair, JointStep};
use crate::constraint::joint::{Drive, Motor, Range, Spring};
use crate::constraint::row::{Jacobian, RowSpec};
use std::f32::consts::TAU;

/// Below this K (kg or kg·m²) a passive row does nothing that f32 could show.
const LEAST_PASSIVE_INERTIA: f32 = 1e-20;

/// One coordinate of B relative to A at one moment.
#[derive(Clone, Copy, Debug)]
pub struct Coordinate {
    /// q: rad or m.
    pub value: f32,
    /// q̇ at the velocities of the moment.
    pub rate: f32,
    /// q̇ = J u.
    pub jacobian: Jacobian,
}

impl Coordinate {
    /// A coordinate and its derivative.
    pub fn new(value: f32, jacobian: Jacobian, pair: &FramePair) -> Self {
        Self { value, rate: pair.rate(&jacobian), jacobian }
    }

    /// Holds the coordinate at `target`: 1 row, of A relative to B like all locked rows.
    pub fn lock_row(&self, target: f32, step: &JointStep) -> RowSpec {
        RowSpec::equality(self.jacobian.negated(), step.recovery(target - self.value))
    }

    /// Keeps the coordinate in a range: one row for each finite end, or one equality if they are the same.
    pub fn limit_rows(&self, range: &Range, step: &JointStep, out: &mut Vec<RowSpec>) {
        if range.lower == range.upper {
            let error = self.value - range.lower;
            out.push(RowSpec::equality(self.jacobian, step.recovery(error)));
            return;
        }
        if range.lower.is_finite() {
            out.push(one_sided(self.jacobian, self.value - range.lower, step));
        }
        if range.upper.is_finite() {
            out.push(one_sided(self.jacobian.negated(), range.upper - self.value, step));
        }
    }

    /// q̇ = speed with bounded effort.
    pub fn motor_row(&self, motor: &Motor, step: &JointStep) -> RowSpec {
        let most = step.h * motor.max_effort;
        RowSpec {
            jacobian: self.jacobian,
            softness: 0.0,
            bias: -motor.speed,
            relax_bias: -motor.speed,
            arc: 0.0,
            lower: -most,
            upper: most,
        }
    }

    /// Effort up to `friction` against the motion.
    pub fn friction_row(&self, friction: f32, step: &JointStep) -> RowSpec {
        self.motor_row(&Motor { speed: 0.0, max_effort: friction }, step)
    }

    /// Spring, damping and armature, implicit.
    pub fn passive_row(&self, spring: &Spring, armature: f32, step: &JointStep) -> RowSpec {
        let h = step.h;
        let k = armature + h * spring.damping + h * h * spring.stiffness;
        if k < LEAST_PASSIVE_INERTIA {
            return RowSpec::inert(self.jacobian);
        }
        let softness = 1.0 / k;
        let bias = softness * (h * spring.stiffness * (self.value - spring.target) - armature * self.rate);
        RowSpec {
            jacobian: self.jacobian,
            softness,
            bias,
            relax_bias: bias,
            arc: 0.0,
            lower: f32::NEG_INFINITY,
            upper: f32::INFINITY,
        }
    }

    /// All that a drive asks for; soft rows first, hard ends last, as the row visited last is kept best.
    pub fn drive_rows(&self, drive: &Drive, step: &JointStep, out: &mut Vec<RowSpec>) {
        if has_passive(drive) {
            let spring = drive.spring.unwrap_or(Spring { target: 0.0, stiffness: 0.0, damping: 0.0 });
            out.push(self.passive_row(&spring, drive.armature, step));
        }
        if let Some(motor) = &drive.motor {
            out.push(self.motor_row(motor, step));
        }
        if drive.friction > 0.0 {
            out.push(self.friction_row(drive.friction, step));
        }
        if let Some(range) = &drive.limit {
            self.limit_rows(range, step, out);
        }
    }
}

/// Rows of [`Coordinate::drive_rows`].
pub fn drive_row_count(drive: &Drive) -> usize {
    usize::from(has_passive(drive))
        + usize::from(drive.motor.is_some())
        + usize::from(drive.friction > 0.0)
        + drive.limit.as_ref().map_or(0, limit_row_count)
}

/// Rows of [`Coordinate::limit_rows`].
pub fn limit_row_count(range: &Range) -> usize {
    if range.lower == range.upper {
        1
    } else {
        usize::from(range.lower.is_finite()) + usize::from(range.upper.is_finite())
    }
}

/// How far `value` is out of a range; 0 inside.
pub fn violation(value: f32, range: Option<&Range>) -> f32 {
    range.map_or(0.0, |range| (range.lower - value).max(value - range.upper).max(0.0))
}

/// `angle` plus the whole turns that bring it nearest to `reference`, rad.
pub fn nearest_turn(angle: f32, reference: f32) -> f32 {
    angle + TAU * ((reference - angle) / TAU + 0.5).floor()
}

/// The angle to count turns from at the start: the middle of the range.
pub fn middle(range: Option<&Range>) -> f32 {
    match range {
        Some(range) if range.lower.is_finite() && range.upper.is_finite() => 0.5 * (range.lower + range.upper),
        _ => 0.0,
    }
}

fn has_passive(drive: &Drive) -> bool {
    drive.spring.is_some() || drive.armature > 0.0
}

// ANCHOR: one_sided
/// Ċ + C/h ≥ 0 inside (C ≥ 0), Ċ + βC/h ≥ 0 outside.
fn one_sided(jacobian: Jacobian, c: f32, step: &JointStep) -> RowSpec {
    let (bias, relax_bias) = if c >= 0.0 { (c / step.h, c / step.h) } else { (step.recovery(c), 0.0) };
    RowSpec { jacobian, softness: 0.0, bias, relax_bias, arc: 0.0, lower: 0.0, upper: f32::INFINITY }
}
// ANCHOR_END: one_sided
