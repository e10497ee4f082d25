//! Aggressive sleep, AS. TALK D10.
//!
//! Between resting bodies the Jacobians of the last step are kept: no narrow phase, no new normals, arms or
//! ids, so the structure of the LCP stops changing and its impulses settle. The bodies are still simulated:
//! λ, friction bounds and separations are live (separations advance by J·δ, or bodies would creep), so there
//! is no wrong rest: take a support away and the pile falls at the next step.
//! A pair freezes when both bodies have been slow for some steps, or one is fixed; it thaws when a body is woken,
//! pushed, edited or gains a contact, or when the relative motion since freezing grows past a part of the slop.
//! Option: `rest.aggressive_sleep`; shown by `tests/aggressive_sleep.rs`.

use crate::body::{BodyKind, BodyState};
use crate::collision::pair_memory::PairMemory;
use crate::math::Pose;
use crate::options::{AggressiveSleep, WorldOptions};

// ANCHOR: stays_frozen
/// Whether the pair, with its second shape at `b_in_a` in the frame of the first, keeps its rows in this step.
pub(crate) fn stays_frozen(
    memory: &PairMemory,
    b_in_a: impl FnOnce() -> Pose,
    (a, b): (&BodyState, &BodyState),
    options: &WorldOptions,
) -> bool {
    if !memory.frozen || !may_freeze(a, b, options) {
        return false;
    }
    let settings = &options.rest.aggressive_sleep;
    let (shift, sine) = memory.motion_since_frozen(&b_in_a());
    let slop = options.solver.slop.depth * options.length_scale;
    // Half an angle that matters here is its sine.
    shift <= settings.thaw_distance * slop && sine <= 0.5 * settings.thaw_angle
}
// ANCHOR_END: stays_frozen

/// Whether a pair, no sensor, whose rows have just been refreshed may keep them: both bodies are at rest.
pub(crate) fn may_freeze(a: &BodyState, b: &BodyState, options: &WorldOptions) -> bool {
    let settings = &options.rest.aggressive_sleep;
    settings.enabled && at_rest(a, settings) && at_rest(b, settings)
}

/// Counts slow steps. Speeds scale with the root of the length, angular speeds with its inverse.
pub(crate) fn count_rest_steps(body: &mut BodyState, settings: &AggressiveSleep, length_scale: f32) {
    let root = length_scale.sqrt();
    let slow = body.velocity.length() < settings.linear_speed * root
        && body.angular_velocity.length() < settings.angular_speed / root;
    body.rest_steps = if slow { body.rest_steps.saturating_add(1) } else { 0 };
}

fn at_rest(body: &BodyState, settings: &AggressiveSleep) -> bool {
    match body.kind {
        BodyKind::Fixed | BodyKind::Kinematic => !body.is_stirring(),
        BodyKind::Dynamic => body.asleep || body.rest_steps >= settings.steps,
    }
}
