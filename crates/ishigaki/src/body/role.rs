//! What the stages after `build_islands` ask of a body, close together in memory: bodies themselves are twenty times as large.

use crate::body::{BodyKind, BodyState};

/// A body in this step, or an empty slot.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Role {
    /// Its island, if it is active.
    pub island: u32,
    /// 1/kg.
    pub inverse_mass: f32,
    /// The solver moves it.
    pub active: bool,
    /// Nothing pushes it.
    pub ground: bool,
    /// Its user moves it.
    pub kinematic: bool,
    /// Its surface may move without being pushed.
    pub moving_ground: bool,
    /// It takes no part: its numbers are not finite.
    pub broken: bool,
    /// Its user changed it since the last step.
    pub edited: bool,
    /// It has a mass and may move and turn along all axes.
    pub free: bool,
    /// It may be stopped at walls.
    pub continuous: bool,
    /// At the end of the step: it was not slow for long enough to sleep.
    pub restless: bool,
}

impl Role {
    /// An empty slot.
    pub const NOTHING: Self = Self {
        island: 0,
        inverse_mass: 0.0,
        active: false,
        ground: false,
        kinematic: false,
        moving_ground: false,
        broken: false,
        edited: false,
        free: false,
        continuous: false,
        restless: false,
    };

    /// The solver moves it, or its user.
    pub fn may_move(&self) -> bool {
        self.active || self.kinematic
    }

    /// It sleeps, and nobody touched it: steps leave all of it as it is.
    pub fn sleeps(&self) -> bool {
        !(self.active || self.ground || self.broken || self.edited)
    }

    /// Before it has an island.
    pub fn of(body: &BodyState) -> Self {
        Self {
            island: 0,
            inverse_mass: body.inverse_mass,
            active: body.is_active(),
            ground: !body.is_dynamic(),
            kinematic: body.kind == BodyKind::Kinematic,
            moving_ground: body.is_moving_kinematic(),
            broken: body.broken,
            edited: body.edited,
            free: !body.locked_translation.contains(&true) && !body.has_locked_rotation() && body.inverse_mass > 0.0,
            continuous: body.continuous,
            restless: false,
        }
    }
}
