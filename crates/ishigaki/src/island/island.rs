//! Stage `build_islands`: bodies connected by contacts and joints, by union-find; sleepers that are touched wake.
//!
//! Ground (fixed and kinematic bodies) connects nothing. An island is awake if any of its bodies is; islands are
//! numbered by their first body, so the numbers do not depend on the order of contacts.

use crate::body::{BodyState, NO_HEIGHT, Role};
use crate::handle::Arena;
use crate::solver::height;
use crate::step::Scratch;
use crate::union_find::{root, unite};
use crate::world::World;

impl World {
    /// Unites bodies, wakes islands, numbers them, measures heights.
    pub(crate) fn build_islands(&mut self) {
        let slots = self.bodies.slot_count();
        let mut parents = std::mem::take(&mut self.scratch.parents);
        parents.clear();
        parents.extend(0..slots as u32);
        if self.unite(&mut parents) || self.scratch.has_woken {
            self.unite_sleepers(&mut parents);
            self.wake_islands(&mut parents);
            self.scratch.roles.clear();
        }
        self.number_islands(&mut parents);
        self.scratch.parents = parents;
        self.measure_heights();
        self.tell_bodies();
    }

    /// Whether any that are awake are now with some that sleep. Which sleepers are together is asked only then.
    fn unite(&mut self, parents: &mut [u32]) -> bool {
        let mut is_mixed = false;
        for link in self.scratch.links.iter().filter(|link| link.unites() && !link.sleeps) {
            if link.joins {
                unite(parents, link.bodies[0], link.bodies[1]);
            } else {
                is_mixed |= unite_ends(&mut self.bodies, parents, link.bodies);
            }
        }
        self.scratch.joint_links.collect(&self.joints, &self.bodies);
        for link in self.scratch.joint_links.list.iter().filter(|link| link.unites) {
            is_mixed |= unite_ends(&mut self.bodies, parents, link.bodies);
        }
        is_mixed
    }

    fn unite_sleepers(&mut self, parents: &mut [u32]) {
        for link in self.scratch.links.iter_mut().filter(|link| link.sleeps) {
            link.sleeps = false;
            if link.unites() {
                unite_ends(&mut self.bodies, parents, link.bodies);
            }
        }
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

    /// Roles of all bodies, with the islands of those that are awake. Those that sleep on keep theirs.
    fn number_islands(&mut self, parents: &mut [u32]) {
        let (numbers, roles) = (&mut self.scratch.island_numbers, &mut self.scratch.roles);
        numbers.clear();
        numbers.resize(parents.len(), u32::MAX);
        if roles.len() == parents.len() {
            roles.iter_mut().zip(&self.scratch.stirs).for_each(|(role, &stirs)| role.edited |= stirs);
        } else {
            roles.clear();
            roles.resize(parents.len(), Role { edited: true, ..Role::NOTHING });
        }
        let mut no_outputs = self.workers.no_outputs(parents.len());
        self.workers.in_parts((self.bodies.all(), &mut roles[..]), &mut no_outputs, |(bodies, roles), ()| {
            bodies.objects_with(roles, |role| !role.sleeps()).for_each(|(body, role)| *role = Role::of(body));
        });
        let mut islands = 0;
        for (role, index) in roles.iter_mut().zip(0..).filter(|(role, _)| role.active) {
            let number = &mut numbers[root(parents, index) as usize];
            if *number == u32::MAX {
                *number = islands;
                islands += 1;
            }
            role.island = *number;
        }
        self.report.islands = islands as usize;
    }

    /// Of all bodies but those that sleep: they keep theirs.
    fn measure_heights(&mut self) {
        let Scratch { links, joint_links, roles, height, heights, .. } = &mut self.scratch;
        let joints = if self.options.solver.height.through_joints { &joint_links.list[..] } else { &[] };
        let supports = links.iter().filter(|link| link.bears() && !link.sleeps).map(|link| link.bodies);
        let supports = supports.chain(joints.iter().map(|link| link.bodies));
        heights.clear();
        heights.resize(roles.len(), NO_HEIGHT);
        height::heights(supports, |i| roles[i as usize].ground, height, heights);
    }

    /// Tells bodies their height and their island.
    fn tell_bodies(&mut self) {
        let (roles, heights) = (&self.scratch.roles, &self.scratch.heights);
        let mut no_outputs = self.workers.no_outputs(roles.len());
        self.workers.in_parts(self.bodies.all(), &mut no_outputs, |bodies, ()| {
            for (index, body) in bodies.objects_where(|slot| !roles[slot as usize].sleeps()) {
                let role = &roles[index as usize];
                if !body.asleep {
                    body.height = heights[index as usize];
                }
                if role.active {
                    body.island = role.island;
                }
            }
        });
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
