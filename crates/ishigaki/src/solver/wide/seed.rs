//! First impulses of contacts that have none: the weight above, handed down. Beyond the talk; it uses its heights (D5).
//!
//! A stack that was just built has no impulses to start from, and a sweep carries a load over few contacts: it would
//! fall freely while its impulses are found, a hundred levels for a second. Each body hands its weight, and what it
//! bears itself, to its contacts with lower bodies in equal parts, from the top down: exact for towers, near for walls
//! and pyramids. Impulses that are there already stay. Only a guess: sweeps and corrections go on from it, and bodies
//! that move are left alone. Option: `solver.wide.seed`; proved by `tests/wide.rs`.

use crate::body::NO_HEIGHT;
use crate::math::Vec3;
use crate::solver::wide::batch::{Batch, Source};
use std::cmp::Reverse;

/// Bodies slower than this may be at rest, m/s × √length scale.
const SLOW: f32 = 0.1;

impl Batch {
    /// Fills in the impulses of contacts between slow bodies that have none, for a substep of `h` seconds.
    pub(super) fn seed(&mut self, source: &Source<'_>, h: f32) {
        if !self.has_cold_contacts(source) {
            return;
        }
        let up = -source.options.gravity.normalize_or_zero();
        let weight = source.options.gravity.length() * h;
        let height = |slot: u32| source.bodies.at(slot).height;
        let mut loads: Vec<f32> = vec![0.0; self.movers.records()];
        let mut supports: Vec<u32> = vec![0; self.movers.records()];
        for (index, slot) in self.movers.bodies() {
            let body = source.bodies.at(slot);
            loads[index as usize] = weight * body.gravity_scale / body.inverse_mass;
        }
        let mut order: Vec<(Reverse<u32>, u32)> = Vec::with_capacity(self.places.len());
        for (index, place) in self.places.iter().enumerate() {
            let contact = &source.contacts[place.contact as usize];
            let heights = [height(contact.body_a), height(contact.body_b)];
            if heights[0] == heights[1] || heights.contains(&NO_HEIGHT) {
                continue;
            }
            let upper = usize::from(heights[1] > heights[0]);
            supports[place.bodies[upper] as usize] += 1;
            order.push((Reverse(heights[upper]), index as u32));
        }
        order.sort_unstable();
        for (_, index) in order {
            let place = self.places[index as usize];
            let contact = &source.contacts[place.contact as usize];
            let upper = usize::from(height(contact.body_b) > height(contact.body_a));
            let (above, below) = (place.bodies[upper] as usize, place.bodies[1 - upper] as usize);
            let manifold = &contact.manifolds[place.manifold as usize];
            let (block, lane) = (&mut self.blocks[place.block()], place.lane());
            let mut borne: f32 = block.points[..place.size.points()].iter().map(|p| p.lambda[lane]).sum();
            let is_slow = |slot: u32| slow(source, slot);
            if borne == 0.0 && is_slow(contact.body_a) && is_slow(contact.body_b) {
                let normal: Vec3 = if upper == 0 { manifold.normal } else { -manifold.normal };
                borne = loads[above] / supports[above] as f32 * normal.dot(up).max(0.0);
                for point in &mut block.points[..manifold.points.len()] {
                    point.lambda[lane] = borne / manifold.points.len() as f32;
                }
            }
            if below != 0 {
                loads[below] += borne;
            }
        }
    }

    fn has_cold_contacts(&self, source: &Source<'_>) -> bool {
        self.places.iter().any(|place| {
            let contact = &source.contacts[place.contact as usize];
            let points = &contact.manifolds[place.manifold as usize].points;
            let height = |slot: u32| source.bodies.at(slot).height;
            points.iter().all(|p| p.lambda_normal == 0.0)
                && height(contact.body_a) != height(contact.body_b)
                && slow(source, contact.body_a)
                && slow(source, contact.body_b)
        })
    }
}

fn slow(source: &Source<'_>, slot: u32) -> bool {
    let limit = SLOW * source.options.length_scale.sqrt();
    source.bodies.at(slot).velocity.length_squared() < limit * limit
}
