//! First impulses of contacts that have none: the weight above, handed down. Beyond the talk; it uses its heights (D5).
//!
//! A stack that was just built has no impulses to start from, and a sweep carries a load over few contacts: it would
//! fall freely while its impulses are found, a hundred levels for a second. Each body hands its weight, and what it
//! bears itself, to its contacts with lower bodies in equal parts, from the top down: exact for towers, near for walls
//! and pyramids. Impulses that are there already stay. Only a guess: sweeps and corrections go on from it, and bodies
//! that move are left alone. Option: `solver.wide.seed`; proved by `tests/wide.rs`.

use crate::body::{BodyState, NO_HEIGHT};
use crate::math::Vec3;
use crate::solver::wide::batch::{Batch, Place, Source};

/// Bodies slower than this may be at rest, m/s × √length scale.
const SLOW: f32 = 0.1;

/// What handing down asks of a body.
#[derive(Clone, Copy)]
struct Bearer {
    height: u32,
    is_slow: bool,
    /// What it bears and weighs, N·s.
    load: f32,
    /// How many manifolds it stands on.
    supports: u32,
}

impl Batch {
    /// Fills in the impulses of contacts between slow bodies that have none, for a substep of `h` seconds.
    pub(super) fn seed(&mut self, source: &Source<'_>, h: f32) {
        if !self.has_cold_stands(source) {
            return;
        }
        let mut bearers = self.bearers(source, h);
        let up = -source.options.gravity.normalize_or_zero();
        for (name, upper) in self.top_down(&mut bearers, source) {
            let place = self.places[name as usize];
            let (above, below) = (place.bodies[upper] as usize, place.bodies[1 - upper] as usize);
            let mut borne = self.borne(&place);
            if borne == 0.0 && place.bodies.iter().all(|&body| bearers[body as usize].is_slow) {
                let manifold = &source.contacts[place.contact as usize].manifolds[place.manifold as usize];
                let normal: Vec3 = if upper == 0 { manifold.normal } else { -manifold.normal };
                let bearer = &bearers[above];
                borne = bearer.load / bearer.supports as f32 * normal.dot(up).max(0.0);
                for point in &mut self.blocks[place.block()].points[..manifold.points.len()] {
                    point.lambda[place.lane()] = borne / manifold.points.len() as f32;
                }
            }
            // The ground bears all.
            if below != 0 {
                bearers[below].load += borne;
            }
        }
    }

    /// Whether a body that may be at rest stands on another without impulses.
    fn has_cold_stands(&self, source: &Source<'_>) -> bool {
        self.places.iter().any(|place| {
            let contact = &source.contacts[place.contact as usize];
            let is_cold = || contact.manifolds[place.manifold as usize].points.iter().all(|p| p.lambda_normal == 0.0);
            let [a, b] = [contact.body_a, contact.body_b].map(|slot| source.bodies.at(slot));
            a.height != b.height && is_cold() && is_slow(a, source) && is_slow(b, source)
        })
    }

    /// All bodies by their records, with their own weight. What does not move is slow, and of any height.
    fn bearers(&self, source: &Source<'_>, h: f32) -> Vec<Bearer> {
        let still = Bearer { height: NO_HEIGHT, is_slow: true, load: 0.0, supports: 0 };
        let mut bearers = vec![still; self.movers.records()];
        let weight = source.options.gravity.length() * h;
        for (record, slot) in self.movers.bodies() {
            let body = source.bodies.at(slot);
            bearers[record as usize] = Bearer {
                height: body.height,
                is_slow: is_slow(body, source),
                load: weight * body.gravity_scale / body.inverse_mass,
                supports: 0,
            };
        }
        bearers
    }

    /// Manifolds between bodies of different heights, with the side of the upper one: the highest first, those of one height
    /// in the order of contacts. Counts what bodies stand on.
    fn top_down(&self, bearers: &mut [Bearer], source: &Source<'_>) -> Vec<(u32, usize)> {
        let mut stands = Vec::with_capacity(self.places.len());
        let mut next: Vec<usize> = Vec::new();
        for (place, name) in self.places.iter().zip(0..) {
            let Some((upper, height)) = upper_of(place, bearers, source) else { continue };
            bearers[place.bodies[upper] as usize].supports += 1;
            if next.len() <= height {
                next.resize(height + 1, 0);
            }
            next[height] += 1;
            stands.push((height, (name, upper)));
        }
        let mut first = 0;
        for of_height in next.iter_mut().rev() {
            (*of_height, first) = (first, first + *of_height);
        }
        let mut order = vec![(0, 0); stands.len()];
        for (height, stand) in stands {
            order[next[height]] = stand;
            next[height] += 1;
        }
        order
    }

    /// The sum of its normal impulses, N·s.
    fn borne(&self, place: &Place) -> f32 {
        let (block, lane) = (&self.blocks[place.block()], place.lane());
        block.points[..place.size.points()].iter().map(|p| p.lambda[lane]).sum()
    }
}

/// Which of its bodies stands on the other, 0 or 1, and how high, if one that moves does.
fn upper_of(place: &Place, bearers: &[Bearer], source: &Source<'_>) -> Option<(usize, usize)> {
    let contact = || &source.contacts[place.contact as usize];
    let height = |side: usize| match place.bodies[side] {
        // Ground, or a sleeper that is not touched yet.
        0 => source.bodies.at([contact().body_a, contact().body_b][side]).height,
        body => bearers[body as usize].height,
    };
    let [a, b] = [height(0), height(1)];
    let upper = usize::from(b > a);
    let stands = a != b && a != NO_HEIGHT && b != NO_HEIGHT && place.bodies[upper] != 0;
    stands.then_some((upper, a.max(b) as usize))
}

/// Whether it may be at rest.
fn is_slow(body: &BodyState, source: &Source<'_>) -> bool {
    let limit = SLOW * source.options.length_scale.sqrt();
    body.velocity.length_squared() < limit * limit
}
