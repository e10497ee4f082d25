//! Which islands the wide path takes, and their batches. What it cannot do yet stays with the reference.
//!
//! Islands that share a contact, even one too far apart to close in this step, are solved together. An island goes to
//! the reference as a whole if any of its bodies has locked axes, any of its joints is no ball joint, or any of its contacts
//! bounces, rolls, slides like a conveyor or touches moving ground; and if its joints are all there is, close no loop and
//! bear loads: the reference solves trees of joints at once. What flies freely bears none but those of its own turning.

use crate::body::NO_HEIGHT;
use crate::collision::link::Link;
use crate::options::{DriftScheme, FrictionModel, Permutation, RotationScheme, WorldOptions};
use crate::solver::wide::Wide;
use crate::solver::wide::batch::{IslandState, Place, Source};
use crate::solver::wide::contact_block::Size;
use crate::solver::wide::domain::Machine;
use crate::solver::wide::joints::Stamp;
use crate::solver::wide::lanes::LANES;
use crate::union_find::{root, unite};
use crate::world::World;
use fearless_simd::Level;

/// Manifolds of a batch, about: what fits the second cache, at most, and what fills lanes, at least.
const MOST: usize = 700;
const LEAST: usize = 200;
/// So many batches keep threads at work evenly.
const BATCHES: usize = 8;
/// A tree of joints that flies freely has at most so many for the lanes, and none of its bodies is so much heavier than
/// another: sweeps carry what is between them in time.
const SMALL_TREE: u32 = 32;
const EVEN_MASSES: f32 = 100.0;
const NONE: u32 = u32::MAX;

/// Whether the options ask for nothing that the reference alone can do.
fn options_fit(options: &WorldOptions) -> bool {
    let solver = &options.solver;
    solver.wide.enabled
        && solver.manifold_block.enabled
        && solver.permutation == Permutation::Alternating
        && solver.friction != FrictionModel::Box
        && !solver.shock_propagation.enabled
        && options.motion.drift == DriftScheme::Symplectic
        && options.motion.rotation != RotationScheme::ExplicitEuler
        && !options.report.residual_by_sweep
}

impl World {
    /// Decides which islands are solved wide and builds their batches.
    pub(crate) fn build_batches(&mut self, wide: &mut Wide, dt: f32) {
        (wide.used, wide.rows, wide.takes_all) = (0, 0, false);
        wide.order.clear();
        wide.joint_order.clear();
        wide.level = if self.options.solver.wide.narrow { Level::baseline() } else { Level::new() };
        wide.batch_of.clear();
        wide.batch_of.resize(self.bodies.slot_count(), NONE);
        if !options_fit(&self.options) {
            return;
        }
        self.group_islands(wide);
        self.assign_batches(wide);
        self.fill_batches(wide, dt);
        if self.options.solver.wide.by_reference {
            self.hand_over(wide, dt);
        }
    }

    /// First impulses, the order of blocks and that of joints for the reference, which then solves all.
    fn hand_over(&mut self, wide: &mut Wide, dt: f32) {
        let scale = self.warm_start_scale(dt);
        let mut first = 0;
        for batch in &wide.batches[..wide.used] {
            for place in &batch.places {
                wide.order.push((place.contact, place.manifold, first + place.lane));
                let manifold = &mut self.contacts[place.contact as usize].manifolds[place.manifold as usize];
                let block = &batch.blocks[place.block()];
                for (point, lanes) in manifold.points.iter_mut().zip(&block.points) {
                    if scale > 0.0 && point.lambda_normal == 0.0 {
                        point.lambda_normal = lanes.lambda[place.lane()] / scale;
                    }
                }
            }
            first += LANES as u32 * batch.blocks.len() as u32;
        }
        wide.order.sort_unstable();
        let links = &self.scratch.joint_links.list;
        let mut visits: Vec<(u32, u32, u32)> = (0..links.len() as u32).map(|index| (0, index, 0)).collect();
        for place in wide.batches[..wide.used].iter().flat_map(|batch| &batch.joints.places) {
            if let Ok(index) = links.binary_search_by_key(&place.joint, |link| link.joint) {
                visits[index].0 = LANES as u32 * place.block + place.lane;
            }
        }
        visits.sort_unstable();
        wide.joint_order.extend(visits.iter().map(|&(_, index, _)| index));
        wide.batch_of.fill(NONE);
        self.scratch.links.iter_mut().for_each(|link| link.batch = Link::NONE);
        wide.batches[..wide.used].iter_mut().for_each(|batch| batch.joints.give_up());
        (wide.used, wide.rows, wide.takes_all) = (0, 0, false);
    }

    /// Unites islands over contacts and marks those that the wide path cannot solve.
    fn group_islands(&self, wide: &mut Wide) {
        let islands = self.report.islands;
        wide.parents.clear();
        wide.parents.extend(0..islands as u32);
        wide.unfit.clear();
        wide.unfit.resize(islands, false);
        wide.sizes.clear();
        wide.sizes.resize(islands, 0);
        wide.inverse_masses.clear();
        wide.inverse_masses.resize(islands, [f32::INFINITY, 0.0]);
        let roles = &self.scratch.roles[..];
        for role in roles.iter().filter(|role| role.active) {
            let [least, greatest] = &mut wide.inverse_masses[role.island as usize];
            (*least, *greatest) = (least.min(role.inverse_mass), greatest.max(role.inverse_mass));
            wide.unfit[role.island as usize] |= !role.free;
        }
        for link in self.scratch.links.iter().filter(|link| link.meets()) {
            let [a, b] = link.bodies.map(|slot| &roles[slot as usize]);
            let island = match (a.active, b.active) {
                (true, true) => unite(&mut wide.parents, a.island, b.island),
                (true, false) => a.island,
                (false, true) => b.island,
                (false, false) => continue,
            };
            wide.sizes[island as usize] += link.manifolds;
            wide.unfit[island as usize] |= link.asks_much || a.moving_ground || b.moving_ground;
        }
        self.group_joints(wide);
        for island in 0..islands as u32 {
            let root = root(&mut wide.parents, island);
            if root != island {
                for flags in [&mut wide.unfit, &mut wide.loops, &mut wide.hangs] {
                    flags[root as usize] |= flags[island as usize];
                }
                for counts in [&mut wide.sizes, &mut wide.joint_counts] {
                    counts[root as usize] += counts[island as usize];
                }
            }
        }
        if self.options.solver.joint_tree.enabled {
            for island in 0..islands {
                let [least, greatest] = wide.inverse_masses[island];
                let is_easy = wide.joint_counts[island] <= SMALL_TREE && greatest <= EVEN_MASSES * least;
                wide.unfit[island] |= wide.is_tree(island) && (wide.hangs[island] || !is_easy);
            }
        }
    }

    /// Marks islands with joints, those that the lanes have no rows for, and those whose joints close loops.
    fn group_joints(&self, wide: &mut Wide) {
        let islands = wide.parents.len();
        for flags in [&mut wide.loops, &mut wide.hangs] {
            flags.clear();
            flags.resize(islands, false);
        }
        wide.joint_counts.clear();
        wide.joint_counts.resize(islands, 0);
        let roles = &self.scratch.roles[..];
        for link in &self.scratch.joint_links.list {
            let ends = link.bodies.map(|slot| &roles[slot as usize]);
            let island = ends.iter().find(|role| role.active).map(|role| role.island as usize);
            let Some(island) = island.filter(|_| ends.iter().all(|role| !role.broken)) else { continue };
            wide.joint_counts[island] += 1;
            wide.hangs[island] |= ends.iter().any(|role| !role.active);
            wide.unfit[island] |= !link.fits || ends.iter().any(|role| role.moving_ground);
            wide.loops[island] |= link.closes;
        }
    }

    /// Groups in the order of their first islands, a batch as soon as there is enough.
    fn assign_batches(&mut self, wide: &mut Wide) {
        wide.batch_of_island.clear();
        wide.batch_of_island.resize(wide.parents.len(), NONE);
        let is_root = |&island: &usize| wide.parents[island] == island as u32;
        let all: usize = (0..wide.parents.len()).filter(is_root).map(|island| wide.sizes[island] as usize + 1).sum();
        let enough = (all / BATCHES).clamp(LEAST, MOST);
        // Islands with joints take sweeps of their own, and fewer where they touch nothing.
        let enough = [enough, MOST, MOST];
        let mut open = [(NONE, usize::MAX); 3];
        for island in 0..wide.parents.len() {
            let root = root(&mut wide.parents, island as u32) as usize;
            if wide.unfit[root] {
                continue;
            }
            if root == island {
                let has_joints = wide.joint_counts[root] > 0;
                let is_clear = has_joints && wide.sizes[root] == 0;
                let kind = usize::from(has_joints) + usize::from(is_clear);
                let (batch, size) = &mut open[kind];
                if *size >= enough[kind] {
                    (*batch, *size) = (wide.start_batch(is_clear), 0);
                }
                *size += wide.sizes[root] as usize + 1;
                wide.batch_of_island[root] = *batch;
                wide.batches[*batch as usize].divisible += wide.sizes[root];
                wide.batches[*batch as usize].joint_count += wide.joint_counts[root];
            } else {
                wide.batch_of_island[island] = wide.batch_of_island[root];
            }
        }
        wide.index_of.clear();
        wide.index_of.resize(self.bodies.slot_count(), 0);
        wide.local_island.clear();
        wide.local_island.resize(wide.parents.len(), NONE);
        wide.island_of.clear();
        wide.island_of.resize(self.bodies.slot_count(), NONE);
        wide.takes_all = true;
        for (slot, role) in (0..).zip(&self.scratch.roles).filter(|(_, role)| role.active) {
            let number = wide.batch_of_island[role.island as usize];
            if number == NONE {
                wide.takes_all = false;
                continue;
            }
            let batch = &mut wide.batches[number as usize];
            wide.batch_of[slot as usize] = number;
            batch.movers.add(slot);
            let local = &mut wide.local_island[role.island as usize];
            if *local == NONE {
                *local = batch.islands.len() as u32;
                batch.islands.push(IslandState { number: role.island, first_body: NONE, ..IslandState::default() });
            }
            wide.island_of[slot as usize] = *local;
            let (island, height) = (&mut batch.islands[*local as usize], self.scratch.heights[slot as usize]);
            if height != NO_HEIGHT {
                island.levels = island.levels.max(height);
            }
        }
        let threads = if self.options.solver.wide.by_reference { 1 } else { self.workers.count() };
        let batches = &mut wide.batches[..wide.used];
        let sum: usize = batches.iter().map(|batch| batch.size()).sum();
        for batch in batches {
            // Batches side by side keep threads at work without meetings: what is cut is more than a thread's share.
            let share = (2 * threads * batch.size() + sum) / (2 * sum).max(1);
            batch.divide(&self.bodies, &self.scratch.joint_links, share);
            batch.movers.bodies().for_each(|(index, slot)| wide.index_of[slot as usize] = index);
        }
    }

    fn fill_batches(&mut self, wide: &mut Wide, dt: f32) {
        self.place_manifolds(wide);
        self.place_joints(wide);
        let source = Source {
            contacts: &self.contacts,
            joints: &self.joints,
            bodies: &self.bodies,
            options: &self.options,
            dt,
            warm_scale: self.warm_start_scale(dt),
        };
        let machine = Machine { level: wide.level, workers: &self.workers };
        machine.each_batch(&mut wide.batches[..wide.used], |batch| batch.build(machine, &source));
        wide.rows = wide.batches[..wide.used].iter().map(|b| (b.rows + b.joints.rows) as usize).sum();
    }

    /// Joints into their batches, but for those that are there.
    fn place_joints(&self, wide: &mut Wide) {
        let links = &self.scratch.joint_links;
        let roles = &self.scratch.roles[..];
        let is_whole = links.list.is_empty() || !roles.iter().any(|role| role.broken);
        let now = is_whole.then_some(Stamp { edition: links.edition, step: self.step_count });
        let mut all_kept = true;
        for batch in &mut wide.batches[..wide.used] {
            all_kept &= batch.joints.keep(&batch.movers.slots, batch.joint_count, now);
        }
        if all_kept {
            return;
        }
        for link in &links.list {
            let Some(&mover) = link.bodies.iter().find(|&&s| wide.batch_of[s as usize] != NONE) else { continue };
            let batch = &mut wide.batches[wide.batch_of[mover as usize] as usize];
            if !batch.joints.is_kept() && link.bodies.iter().all(|&s| !roles[s as usize].broken) {
                let bodies = link.bodies.map(|s| wide.index_of[s as usize]);
                let cell = batch.cell_of(bodies);
                batch.joints.add(link, bodies, cell);
            }
        }
    }

    /// Manifolds into their batches.
    fn place_manifolds(&mut self, wide: &mut Wide) {
        for (index, link) in self.scratch.links.iter_mut().enumerate().filter(|(_, link)| link.meets()) {
            let Some(&slot) = link.bodies.iter().find(|&&s| wide.batch_of[s as usize] != NONE) else { continue };
            let number = wide.batch_of[slot as usize];
            let batch = &mut wide.batches[number as usize];
            if batch.places.is_empty() {
                // Lists that grow leave holes in memory, each half as large as they are.
                batch.places.reserve_exact(batch.divisible as usize);
            }
            (link.batch, link.place) = (number, batch.places.len() as u32);
            let island = wide.island_of[slot as usize];
            let state = &mut batch.islands[island as usize];
            state.first_body = state.first_body.min(slot);
            state.manifolds += link.manifolds;
            let bodies = link.bodies.map(|s| wide.index_of[s as usize]);
            // Contacts are far apart, and of most the link has all that is asked.
            batch.places.push(Place::new(index as u32, 0, bodies, island, Size::of(usize::from(link.points))));
            for m in 1..link.manifolds {
                let size = Size::of(self.contacts[index].manifolds[m as usize].points.len());
                batch.places.push(Place::new(index as u32, m, bodies, island, size));
            }
        }
    }
}
