//! Which pairs of shapes may touch: a tree of fat bounds, asked only about what moved.
//!
//! Each shape has a box around it, fattened by its owner so that a slow shape leaves it seldom. Only shapes
//! that left their box are put into the tree anew and asked for neighbors: a settled scene costs nothing,
//! a moving one O(moved · log n). Pairs come sorted and once, so no result depends on the tree's form, and a
//! rebuilt tree (after a snapshot is restored) gives the same ones.
//!
//! Boxes too large for a scene (half-spaces) would fill the top of the tree: they are kept in a short list and
//! tested against everything. Boxes that are not finite belong to bodies that ran away: they touch nothing.
//! Without it every step tests n²/2 pairs. Bounds in m, world; slots are those of the world's shapes.
//! Fattening is `ContactOptions::bounds_margin`. Proved by `tests/broad_phase.rs`: against all pairs of boxes.

use crate::math::Vec3;
use crate::shape::HUGE_LENGTH;
use crate::threads::Workers;
use parry3d::bounding_volume::Aabb;
use parry3d::partitioning::{Bvh, BvhBuildStrategy, BvhNode, BvhWorkspace};
use serde::{Deserialize, Serialize};
use std::cell::{Cell, RefCell};

/// Boxes of shapes by slot. Serialized as nothing: [`rebuild`](Self::rebuild) it from the stored bounds.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct BroadPhase {
    #[serde(skip)]
    tree: Bvh,
    /// Sorted by slot.
    #[serde(skip)]
    large: Vec<LargeBox>,
    #[serde(skip)]
    workspace: Workspace,
    /// Many boxes moved when some last did.
    #[serde(skip)]
    many_moved: bool,
}

/// When more than one in so many boxes move, all of the tree is looked at.
const FEW: usize = 8;

/// Arrays that the tree uses again.
#[derive(Clone, Default)]
struct Workspace(BvhWorkspace);

impl std::fmt::Debug for Workspace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Workspace")
    }
}

#[derive(Clone, Copy, Debug)]
struct LargeBox {
    slot: u32,
    bounds: Aabb,
}

impl BroadPhase {
    /// Without boxes.
    pub fn new() -> Self {
        Self::default()
    }

    /// From all boxes (slot, least corner, greatest corner) at once.
    pub fn rebuild(&mut self, boxes: impl IntoIterator<Item = (u32, Vec3, Vec3)>) {
        self.large.clear();
        let large = &mut self.large;
        let small = boxes.into_iter().filter_map(|(slot, min, max)| match size(min, max) {
            Size::Small => Some((slot as usize, Aabb::new(min, max))),
            Size::Large => {
                large.push(LargeBox { slot, bounds: Aabb::new(min, max) });
                None
            }
            Size::NotFinite => None,
        });
        let small: Vec<(usize, Aabb)> = small.collect();
        if small.len() > 2 {
            self.tree = Bvh::from_iter(BvhBuildStrategy::Binned, small);
        } else {
            // parry 0.31's `from_iter` takes one or two leaves for slots 0 and 1, whatever they are.
            self.tree = Bvh::new();
            for (slot, bounds) in small {
                self.tree.insert(bounds, slot as u32);
            }
        }
        self.large.sort_unstable_by_key(|b| b.slot);
    }

    /// Puts a box in; if the slot has one already, this one takes its place.
    pub fn insert(&mut self, slot: u32, min: Vec3, max: Vec3) {
        self.remove(slot);
        let bounds = Aabb::new(min, max);
        match size(min, max) {
            Size::Small => self.tree.insert(bounds, slot),
            Size::Large => {
                let at = self.large.partition_point(|b| b.slot < slot);
                self.large.insert(at, LargeBox { slot, bounds });
            }
            Size::NotFinite => {}
        }
    }

    /// Gives a slot another box.
    pub fn update(&mut self, slot: u32, min: Vec3, max: Vec3) {
        // Taken out and put in again: boxes grown in place would leave their ancestors too large for good.
        self.insert(slot, min, max);
    }

    /// Gives slots other boxes: as [`update`](Self::update) for each, but faster for many.
    pub fn update_all(&mut self, slots: &[u32], bounds: impl Fn(u32) -> (Vec3, Vec3)) {
        let boxes = || slots.iter().map(|&slot| (slot, bounds(slot)));
        let is_small = |min: Vec3, max: Vec3| matches!(size(min, max), Size::Small);
        if slots.len() * FEW < self.tree.leaf_count() as usize {
            boxes().for_each(|(slot, (min, max))| self.update(slot, min, max));
            self.many_moved = false;
            return;
        }
        // What is not in the tree, or leaves it, needs a tree that holds together.
        for (slot, (min, max)) in boxes() {
            if self.tree.leaf_node(slot).is_none() || !is_small(min, max) {
                self.insert(slot, min, max);
            }
        }
        if self.tree.leaf_count() <= 2 {
            boxes().for_each(|(slot, (min, max))| self.update(slot, min, max));
            return;
        }
        for (slot, (min, max)) in boxes().filter(|&(_, (min, max))| is_small(min, max)) {
            self.tree.insert_or_update_partially(Aabb::new(min, max), slot, 0.0);
        }
        // One pass over the tree instead of a way to the root for each; it grows worse as boxes move apart that were
        // neighbors, so a part of it is built anew.
        self.tree.refit(&mut self.workspace.0);
        self.tree.optimize_incremental(&mut self.workspace.0);
        // It is as large as the tree: only a world in which much moves step after step keeps it.
        if !std::mem::replace(&mut self.many_moved, true) {
            self.workspace = Workspace::default();
        }
    }

    /// Takes a box out, if the slot has one.
    pub fn remove(&mut self, slot: u32) {
        self.tree.remove(slot);
        if let Ok(at) = self.large.binary_search_by_key(&slot, |b| b.slot) {
            self.large.remove(at);
        }
    }

    /// The box of a slot; `None` if it has none or one that is not finite.
    pub fn bounds(&self, slot: u32) -> Option<(Vec3, Vec3)> {
        self.bounds_of(slot).map(|b| (b.mins, b.maxs))
    }

    fn bounds_of(&self, slot: u32) -> Option<Aabb> {
        match self.tree.leaf_node(slot) {
            Some(leaf) => Some(leaf.aabb()),
            None => self.large.binary_search_by_key(&slot, |b| b.slot).ok().map(|at| self.large[at].bounds),
        }
    }

    /// All pairs (a, b), a < b, whose boxes touch and one of which moved: each once, sorted.
    ///
    /// `is_wanted(a, b)` filters them; it must be the same function of (a, b) whenever it is asked. `out` is
    /// cleared first.
    pub fn pairs_of(&self, moved: &[u32], is_wanted: impl Fn(u32, u32) -> bool + Sync, out: &mut Vec<(u32, u32)>) {
        self.pairs_in_parts(moved, is_wanted, &Workers::default(), &mut Vec::new(), out);
    }

    /// The same on several threads, with lists that are used again.
    pub(crate) fn pairs_in_parts(
        &self,
        moved: &[u32],
        is_wanted: impl Fn(u32, u32) -> bool + Sync,
        workers: &Workers,
        lists: &mut Vec<Vec<(u32, u32)>>,
        out: &mut Vec<(u32, u32)>,
    ) {
        lists.resize_with(workers.parts(moved.len()), Vec::new);
        workers.in_parts(moved, lists, |moved, list| self.list_pairs(moved, &is_wanted, list));
        out.clear();
        lists.iter_mut().for_each(|list| out.append(list));
        // A pair of which both moved was found twice.
        out.sort_unstable();
        out.dedup();
    }

    fn list_pairs(&self, moved: &[u32], is_wanted: impl Fn(u32, u32) -> bool, list: &mut Vec<(u32, u32)>) {
        list.clear();
        for &slot in moved {
            let Some(bounds) = self.bounds_of(slot) else { continue };
            self.visit(&bounds, |other| {
                let pair = (slot.min(other), slot.max(other));
                if slot != other && is_wanted(pair.0, pair.1) {
                    list.push(pair);
                }
            });
        }
    }

    /// All slots whose box touches a box, sorted; `out` is cleared first.
    pub fn query_aabb(&self, min: Vec3, max: Vec3, out: &mut Vec<u32>) {
        out.clear();
        self.visit(&Aabb::new(min, max), |slot| out.push(slot));
        out.sort_unstable();
    }

    /// Every slot whose box touches `bounds`, in no particular order.
    fn visit(&self, bounds: &Aabb, mut found: impl FnMut(u32)) {
        self.tree.intersect_aabb(bounds).for_each(&mut found);
        for other in &self.large {
            if touch(&other.bounds, bounds) {
                found(other.slot);
            }
        }
    }

    /// Visits every slot that can cost at most `limit`, the cheaper boxes first where it can.
    ///
    /// `least_cost(min, max)` is a lower bound of the cost of all that lies in a box, `None` if nothing in it
    /// counts. `visit(slot)` gives the new limit, never a greater one; boxes that cost exactly the limit are still
    /// visited, so that ties can be broken by slot and not by the form of the tree.
    pub fn search(
        &self,
        limit: f32,
        least_cost: impl Fn(Vec3, Vec3) -> Option<f32>,
        mut visit: impl FnMut(u32) -> f32,
    ) {
        let mut limit_now = limit;
        for other in &self.large {
            if least_cost(other.bounds.mins, other.bounds.maxs).is_some_and(|cost| cost <= limit_now) {
                limit_now = visit(other.slot);
            }
        }
        let limit = Cell::new(limit_now);
        let visit = RefCell::new(visit);
        // The tree's own notion of the best so far drops ties: it is never told of one, the limit here prunes.
        let _ = self.tree.find_best::<f32>(
            f32::MAX,
            |node: &BvhNode, _| match least_cost(node.mins(), node.maxs()) {
                Some(cost) if cost <= limit.get() => cost,
                _ => f32::MAX,
            },
            |slot, _| {
                limit.set((visit.borrow_mut())(slot));
                None
            },
        );
    }
}

enum Size {
    Small,
    Large,
    NotFinite,
}

fn size(min: Vec3, max: Vec3) -> Size {
    if min.is_nan() || max.is_nan() {
        return Size::NotFinite;
    }
    // Written so that infinite boxes are large too.
    if (max - min).max_element() <= HUGE_LENGTH { Size::Small } else { Size::Large }
}

/// As the tree's own test: boxes that share a point touch.
fn touch(a: &Aabb, b: &Aabb) -> bool {
    a.mins.cmple(b.maxs).all() && a.maxs.cmpge(b.mins).all()
}
