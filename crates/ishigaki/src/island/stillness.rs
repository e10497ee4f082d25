//! Steps in which nothing can happen are not taken: all bodies sleep, no ground moves, and nobody changed anything.
//!
//! A step without active bodies gives each body the state that it has, and after two of them nothing remembers an edit:
//! the next one would do the same again. Time goes on, and the report of the last step is that of the next.
//! Whatever changes a world from outside calls [`World::disturb`]; `tests/stillness.rs` compares each of these ways with
//! a world that takes every step.

use crate::report::StepReport;
use crate::world::World;

/// Steps since anything moved or was changed, up to [`ENOUGH`].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Stillness(u8);

/// The first step without motion still takes notice of edits.
const ENOUGH: u8 = 2;

impl World {
    /// Something was changed from outside: the next steps are taken.
    pub(crate) fn disturb(&mut self) {
        self.scratch.stillness = Stillness::default();
    }

    /// Whether a step would leave all as it is.
    pub(crate) fn is_still(&self) -> bool {
        self.scratch.stillness.0 == ENOUGH
    }

    /// A step of a world that is still.
    pub(crate) fn stay(&mut self, dt: f32) -> StepReport {
        (self.report.still, self.report.stage_seconds) = (true, [0.0; 10]);
        self.last_substep = dt / self.options.solver.substeps as f32;
        self.pass_time(dt);
        self.report.clone()
    }

    /// At the end of a step that was taken.
    pub(crate) fn notice_stillness(&mut self) {
        let scratch = &mut self.scratch;
        let moves = self.report.islands > 0 || scratch.roles.iter().any(|role| role.moving_ground);
        let Stillness(steps) = scratch.stillness;
        let is_quiet = !moves && self.events.is_empty() && scratch.moved_shapes.is_empty();
        scratch.stillness = if is_quiet { Stillness((steps + 1).min(ENOUGH)) } else { Stillness::default() };
    }
}
