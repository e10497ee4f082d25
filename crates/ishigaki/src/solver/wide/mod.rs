//! The wide path: islands of contacts, eight manifolds at a time. DESIGN, "Fast path".
//!
//! The same equations and visits as `reference.rs` and `substeps.rs`, in another layout and order: bodies and rows of
//! some islands are gathered into a batch that stays in the cache over all substeps, its manifolds are colored, and
//! eight of a color are visited side by side. Bits depend neither on the width of the machine's lanes nor on threads.
//! Option: `solver.wide`; held to the reference by `tests/wide.rs`.

pub mod batch;
mod color;
pub mod contact_block;
mod correction;
pub(crate) mod domain;
mod handing;
pub mod joint_block;
mod joint_part;
pub mod joints;
pub mod lanes;
pub mod mover;
mod moving;
mod seed;
mod solve;
mod split;
pub(crate) mod storing;
mod sweeping;
mod turning;

use crate::solver::plan::Plan;
use batch::Batch;
use fearless_simd::Level;

/// All batches of a step, and arrays that are used again.
#[derive(Clone, Debug)]
pub struct Wide {
    /// What the machine can do.
    pub level: Level,
    /// The first `used` are of this step.
    pub batches: Vec<Batch>,
    /// Batches of this step.
    pub used: usize,
    /// Rows of all batches.
    pub rows: usize,
    /// It takes all that moves.
    pub takes_all: bool,
    /// Of each contact and manifold: its place among the blocks, where the reference solves them in that order.
    pub order: Vec<(u32, u32, u32)>,
    /// Links of joints in the order of visits, for the same.
    pub joint_order: Vec<u32>,
    /// Of each body slot: its batch, or `u32::MAX`.
    pub batch_of: Vec<u32>,
    index_of: Vec<u32>,
    parents: Vec<u32>,
    unfit: Vec<bool>,
    sizes: Vec<u32>,
    /// Of each island: how many joints it has, whether they close loops, whether some hang from what does not move.
    joint_counts: Vec<u32>,
    loops: Vec<bool>,
    hangs: Vec<bool>,
    /// Of each island: least and greatest 1/m, 1/kg.
    inverse_masses: Vec<[f32; 2]>,
    batch_of_island: Vec<u32>,
    /// Of each island: its number in its batch.
    local_island: Vec<u32>,
    /// Of each body slot: its island in its batch.
    island_of: Vec<u32>,
    /// Rows of islands whose loads are corrected, as the reference has them, and arrays for it: one for each thread.
    #[expect(clippy::vec_box, reason = "threads take them out and put them back")]
    aids: Vec<Box<Plan>>,
}

impl Default for Wide {
    fn default() -> Self {
        Self {
            level: Level::new(),
            batches: Vec::new(),
            used: 0,
            rows: 0,
            takes_all: false,
            order: Vec::new(),
            joint_order: Vec::new(),
            batch_of: Vec::new(),
            index_of: Vec::new(),
            parents: Vec::new(),
            unfit: Vec::new(),
            sizes: Vec::new(),
            joint_counts: Vec::new(),
            loops: Vec::new(),
            hangs: Vec::new(),
            inverse_masses: Vec::new(),
            batch_of_island: Vec::new(),
            local_island: Vec::new(),
            island_of: Vec::new(),
            aids: Vec::new(),
        }
    }
}

impl Wide {
    /// Whether joints are all there is of an island, and close no loop.
    fn is_tree(&self, island: usize) -> bool {
        self.joint_counts[island] > 0 && self.sizes[island] == 0 && !self.loops[island]
    }

    /// Its number.
    fn start_batch(&mut self, is_clear: bool) -> u32 {
        if self.used == self.batches.len() {
            self.batches.push(Batch::default());
        }
        self.batches[self.used].clear();
        self.batches[self.used].is_clear = is_clear;
        self.used += 1;
        self.used as u32 - 1
    }

    /// Whether a body is solved here.
    pub fn takes(&self, slot: u32) -> bool {
        self.batch_of.get(slot as usize).is_some_and(|&b| b != u32::MAX)
    }
}
