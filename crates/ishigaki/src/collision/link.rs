//! What later stages ask of a contact, close together in memory: contacts themselves are ten times as large.
//!
//! In the order of contacts: islands, heights and batches look at these alone. Made anew in each step while a contact is
//! at hand, but for those that sleep: these stay until a body stirs.

use crate::body::BodyState;
use crate::collision::manifold::{Contact, SurfaceExtras};
use crate::options::WorldOptions;

/// A contact in this step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Link {
    /// Slots of its bodies.
    pub bodies: [u32; 2],
    /// How many manifolds it has.
    pub manifolds: u32,
    /// Points of the first.
    pub points: u8,
    nearness: Nearness,
    /// Neither body stirs, and no impulse of a step before is left: nothing changes it but waking.
    pub sleeps: bool,
    /// Both bodies are awake and pushed by others: there is no more to ask where they unite.
    pub joins: bool,
    /// Rolling or torsional friction, a bounce or a moving surface: rows that only the reference has.
    pub asks_much: bool,
    /// Its batch in the wide path, or [`Link::NONE`].
    pub batch: u32,
    /// The place of its first manifold there; of one that sleeps the bits of its depth.
    pub place: u32,
}

/// How near its surfaces are: each implies those before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Nearness {
    /// A sensor's.
    NoMatter,
    /// It has rows.
    Meets,
    /// Its bodies may touch in this step: they are of one island.
    Unites,
    /// Its surfaces touch: one body may stand on the other.
    Bears,
}

/// What links are judged by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Judge {
    dt: f32,
    /// What gravity may add to the motion of the step, m.
    fall: f32,
    slop: f32,
    bounces: bool,
}

impl Judge {
    pub fn new(options: &WorldOptions, dt: f32) -> Self {
        Self {
            dt,
            fall: options.gravity.length() * dt * dt,
            slop: options.solver.slop.depth * options.length_scale,
            bounces: options.solver.restitution.enabled,
        }
    }

    /// Whether the reference alone has rows for these.
    fn asks_much(&self, extras: &SurfaceExtras) -> bool {
        *extras
            != SurfaceExtras { restitution: if self.bounces { 0.0 } else { extras.restitution }, ..Default::default() }
    }

    /// Whether the two may touch within the step, in which they also fall.
    fn closes(&self, contact: &Contact, a: &BodyState, b: &BodyState) -> bool {
        let (linear_a, angular_a) = a.velocities_in_step(self.dt);
        let (linear_b, angular_b) = b.velocities_in_step(self.dt);
        contact.manifolds.iter().any(|m| {
            m.points.iter().any(|p| {
                let velocity_a = linear_a + angular_a.cross(p.arm_a);
                let velocity_b = linear_b + angular_b.cross(p.arm_b);
                p.separation + self.dt * m.normal.dot(velocity_a - velocity_b) <= self.fall
            })
        })
    }
}

impl Link {
    /// No batch.
    pub const NONE: u32 = u32::MAX;
    /// Of a contact that nothing is known of.
    pub const UNKNOWN: Self = Self {
        bodies: [0; 2],
        manifolds: 0,
        points: 0,
        nearness: Nearness::NoMatter,
        sleeps: false,
        joins: false,
        asks_much: false,
        batch: Self::NONE,
        place: 0,
    };

    pub fn new(contact: &Contact, a: &BodyState, b: &BodyState, judge: &Judge) -> Self {
        let points = || contact.manifolds.iter().flat_map(|m| &m.points);
        let sleeps = !(a.is_stirring() || b.is_stirring()) && points().all(|p| p.impulse == 0.0);
        let nearness = if contact.sensor || contact.manifolds.is_empty() {
            Nearness::NoMatter
        } else if contact.touching && points().any(|p| p.separation <= judge.slop) {
            Nearness::Bears
        } else if contact.touching || judge.closes(contact, a, b) {
            Nearness::Unites
        } else {
            Nearness::Meets
        };
        let depth = if sleeps { points().map(|p| -p.separation).fold(0.0, f32::max) } else { 0.0 };
        Self {
            bodies: [contact.body_a, contact.body_b],
            manifolds: contact.manifolds.len() as u32,
            points: contact.manifolds.first().map_or(0, |manifold| manifold.points.len() as u8),
            nearness,
            sleeps,
            joins: a.is_active() && b.is_active(),
            asks_much: contact.extras.as_ref().is_some_and(|extras| judge.asks_much(extras)),
            batch: Self::NONE,
            place: depth.to_bits(),
        }
    }

    /// It has rows: it is no sensor.
    pub fn meets(&self) -> bool {
        self.nearness >= Nearness::Meets
    }

    /// Its bodies may touch in this step: they are of one island.
    pub fn unites(&self) -> bool {
        self.nearness >= Nearness::Unites
    }

    /// Its surfaces touch: one body may stand on the other.
    pub fn bears(&self) -> bool {
        self.nearness == Nearness::Bears
    }

    /// Greatest overlap, m, if it sleeps.
    pub fn depth(&self) -> f32 {
        if self.sleeps { f32::from_bits(self.place) } else { 0.0 }
    }
}
