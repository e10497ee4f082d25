//! Stage `build_islands`: bodies connected by contacts and joints, by union-find; sleepers that are touched wake.
//!
//! Ground (fixed and kinematic bodies) connects nothing. An island is awake if any of its bodies is; islands are
//! numbered by their first body, so the numbers do not depend on the order of contacts.

use crate::body::{BodyState, NO_HEIGHT};
use crate::handle::Arena;
use crate::solver::height;
use crate::union_find::{root, unite};
use crate::world::World;

impl World {
    /// Unites bodies, wakes islands, numbers them, measures heights.
    pub(crate) fn build_islands(&mut self) {
        let slots = self.bodies.slot_count();
        let mut parents = std::mem::take(&mut self.scratch.parents);
        parents.clear();
        parents.extend(0..slots as u32);
        if self.unite(&mut parents) {
            self.wake_islands(&mut parents);
        }
        self.number_islands(&mut parents);
        self.scratch.parents = parents;
        self.measure_heights();
    }

    /// Whether any that are awake are now with some that sleep.
    fn unite(&mut self, parents: &mut [u32]) -> bool {
        let mut is_mixed = false;
        for link in self.scratch.links.iter().filter(|link| link.unites) {
            is_mixed |= unite_ends(&mut self.bodies, parents, link.bodies);
        }
        for (_, joint) in self.joints.iter() {
            let ends = [joint.definition.body_a.index, joint.definition.body_b.index];
            is_mixed |= unite_ends(&mut self.bodies, parents, ends);
        }
        is_mixed
    }

    fn wake_islands(&mut self, parents: &mut [u32]) {
        let awake = &mut self.scratch.awake_roots;
        awake.clear();
        awake.resize(parents.len(), false);
        for (index, body) in self.bodies.iter() {
            if body.is_active() {
                awake[root(parents, index) as usize] = true;
            }
        }
        for (index, body) in self.bodies.iter_mut() {
            if body.is_dynamic() && body.asleep && awake[root(parents, index) as usize] {
                body.wake();
            }
        }
    }

    fn number_islands(&mut self, parents: &mut [u32]) {
        let numbers = &mut self.scratch.island_numbers;
        numbers.clear();
        numbers.resize(parents.len(), u32::MAX);
        let mut islands = 0;
        for (index, body) in self.bodies.iter_mut() {
            if body.is_active() {
                let number = &mut numbers[root(parents, index) as usize];
                if *number == u32::MAX {
                    *number = islands;
                    islands += 1;
                }
                body.island = *number;
            }
        }
        self.report.islands = islands as usize;
    }

    fn measure_heights(&mut self) {
        let mut supports = std::mem::take(&mut self.scratch.supports);
        supports.clear();
        supports
            .extend(self.scratch.links.iter().filter(|link| link.bears).map(|link| (link.bodies[0], link.bodies[1])));
        if self.options.solver.height.through_joints {
            supports.extend(self.joints.iter().map(|(_, j)| (j.definition.body_a.index, j.definition.body_b.index)));
        }
        let heights = &mut self.scratch.heights;
        heights.clear();
        heights.resize(self.bodies.slot_count(), NO_HEIGHT);
        let ground = &mut self.scratch.is_ground;
        ground.clear();
        ground.resize(self.bodies.slot_count(), false);
        for (index, body) in self.bodies.iter() {
            ground[index as usize] = !body.is_dynamic();
        }
        height::heights(&supports, |i| ground[i as usize], &mut self.scratch.height, heights);
        for (index, body) in self.bodies.iter_mut() {
            body.height = heights[index as usize];
        }
        self.scratch.supports = supports;
    }
}

/// Puts both into one island, or lets ground wake what is on it; whether some are awake now that may be with sleepers.
fn unite_ends(bodies: &mut Arena<BodyState>, parents: &mut [u32], [index_a, index_b]: [u32; 2]) -> bool {
    let (a, b) = (bodies.at(index_a), bodies.at(index_b));
    if a.is_dynamic() && b.is_dynamic() {
        unite(parents, index_a, index_b);
        a.asleep != b.asleep
    } else {
        let_ground_wake(bodies, index_a, index_b)
    }
}

/// Ground that moves, or that its user changed, wakes what is connected with it; whether anything slept.
fn let_ground_wake(bodies: &mut Arena<BodyState>, a: u32, b: u32) -> bool {
    let mut slept = false;
    for (ground, other) in [(a, b), (b, a)] {
        let ground = bodies.at(ground);
        if !ground.is_dynamic() && ground.is_stirring() {
            let edited = ground.edited;
            let other = bodies.at_mut(other);
            slept |= other.asleep;
            if edited {
                other.wake();
            } else {
                // Awake, but it may rest on what carries it along.
                other.asleep = false;
            }
        }
    }
    slept
}
