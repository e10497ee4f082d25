//! Domains: parts of a large batch for several threads. Bodies that lie together are of one domain; manifolds and joints
//! between bodies of two domains are the *seam*.
//!
//! Domains share no body that moves: threads visit the manifolds of one color in all of them side by side, each core with
//! its own in its cache, and the seam's of that color after them. Manifolds of one color may be visited in any order, so
//! that domains change no bit, however many there are: as many as the machine has threads.
//!
//! Joints are visited in an order of their own (`joints.rs`), which cuts do change. A batch with many is cut into *cells* by
//! what it is, not by threads, where bodies hang on others (`joint_link.rs`): joints within cells come first, then those of
//! the seam. One thread takes all cells as one domain, several take each cell as one.

use crate::body::BodyState;
use crate::handle::Arena;
use crate::math::Vec3;
use crate::solver::joint_link::JointLinks;
use crate::solver::wide::batch::{Batch, Place};
use crate::solver::wide::contact_block::{ContactBlock, ScaleLanes, Size, TangentLanes};
use crate::solver::wide::joint_part::{JointPart, split};
use crate::solver::wide::lanes::{LANES, Lane, Record};
use crate::solver::wide::mover::MoverBlock;
use crate::threads::{Cut, Workers};
use fearless_simd::Level;
use std::ops::Range;

/// Manifolds of a domain, at least: fewer are not worth the seam.
const MANIFOLDS: usize = 300;
/// Domains of a batch, at most.
const MOST: usize = 16;
/// Joints of a cell, at least, and cells of a batch, at most: a load passes one seam in a sweep.
const JOINTS: usize = 2000;
const CELLS: usize = 2;
/// Blocks of a color that are not worth a second thread.
const FEW: usize = 5;
/// Places that are summed up in one go.
const CHUNK: usize = 512;

/// Kinds of blocks: by size, of round bodies or not.
pub(super) const KINDS: usize = 2 * Size::ALL.len();

/// What a batch is solved on.
#[derive(Clone, Copy)]
pub(crate) struct Machine<'a> {
    /// Its lanes.
    pub level: Level,
    /// Its threads.
    pub workers: &'a Workers,
}

impl Machine<'_> {
    /// Calls `work` for each batch: those of several domains on all threads, one after the other, the rest side by side.
    pub fn each_batch(self, batches: &mut [Batch], work: impl Fn(&mut Batch) + Sync + Send) {
        batches.iter_mut().filter(|batch| batch.divided() > 1).for_each(&work);
        self.workers.for_each(batches, |batch| {
            if batch.divided() == 1 {
                work(batch);
            }
        });
    }
}

/// A part of the arrays of a batch.
#[derive(Clone, Debug, Default)]
pub struct Domain {
    /// Records of its bodies; the first is the ground's.
    pub records: Range<usize>,
    /// Where its manifolds are named in the list of those of all domains.
    pub manifolds: Range<usize>,
    /// Blocks of these, color by color.
    pub blocks: Range<usize>,
    /// Those of each color.
    pub colors: Vec<Range<usize>>,
    /// Tangent rows of these.
    pub tangents: Range<usize>,
    /// Where its joints are named in the list of those of all cells.
    pub joints: Range<usize>,
    /// Blocks of these, wave by wave.
    pub joint_blocks: Range<usize>,
    /// What these ask of rotations.
    pub turns: Range<usize>,
    /// By color and kind: first how many manifolds, then the lane of the next.
    pub(super) counts_of: Vec<[u32; KINDS]>,
}

impl Domain {
    /// Nothing is in it, but room stays.
    fn forget(&mut self) {
        let Self { manifolds, blocks, tangents, joints, joint_blocks, turns, .. } = self;
        for range in [manifolds, blocks, tangents, joints, joint_blocks, turns] {
            *range = 0..0;
        }
    }
}

/// Σλ_n, N·s, and unrest, J, of some manifolds.
#[derive(Clone, Debug, Default)]
pub struct Sums {
    chunk: usize,
    of_islands: Vec<[f32; 2]>,
}

/// What one thread has in its hands: some domains with all that is of them, or the seam with the bodies of all domains.
pub(super) struct Part<'a> {
    pub domains: &'a [Domain],
    pub slots: &'a [u32],
    pub movers: &'a mut [MoverBlock],
    pub velocities: &'a mut [Record],
    pub carried: &'a mut [Record],
    pub displacements: &'a mut [Record],
    pub roots: &'a mut [Record],
    /// Nothing but where there are joints.
    pub old_roots: &'a mut [Record],
    /// All of the batch.
    pub places: &'a [Place],
    /// Which of them are at hand.
    pub manifolds: &'a [u32],
    pub blocks: &'a mut [ContactBlock],
    pub tangents: &'a mut [TangentLanes],
    pub unrest: &'a mut [Lane],
    /// Of the blocks, or one for all.
    pub scales: &'a [ScaleLanes],
    pub joints: JointPart<'a>,
}

impl<'a> Part<'a> {
    /// The only domain, or the seam.
    pub fn domain(&self) -> &Domain {
        &self.domains[0]
    }

    /// Which of its blocks have a color.
    fn blocks_of(&self, color: usize) -> Range<usize> {
        let (of_color, first) = (&self.domain().colors[color], self.domain().blocks.start);
        of_color.start - first..of_color.end - first
    }

    /// Those of some blocks, or one for all.
    pub fn scales_of(&self, blocks: &Range<usize>) -> &'a [ScaleLanes] {
        if self.scales.len() == 1 { self.scales } else { &self.scales[blocks.clone()] }
    }

    /// Index of a body of the batch in the records of this part.
    pub fn local(&self, body: u32) -> u32 {
        if body == 0 { 0 } else { body - self.domain().records.start as u32 }
    }
}

impl Cut for Part<'_> {
    fn cut(self, part: usize, _of: usize) -> (Self, Self) {
        let (domains, other_domains) = self.domains.split_at(part);
        let (first, next) = (&domains[0], &other_domains[0]);
        let record = next.records.start - first.records.start;
        let manifold = next.manifolds.start - first.manifolds.start;
        let block = next.blocks.start - first.blocks.start;
        let (slots, other_slots) = self.slots.split_at(record);
        let (movers, other_movers) = self.movers.split_at_mut(record / LANES);
        let (velocities, other_velocities) = self.velocities.split_at_mut(record);
        let (carried, other_carried) = self.carried.split_at_mut(record);
        let (displacements, other_displacements) = self.displacements.split_at_mut(record);
        let (roots, other_roots) = self.roots.split_at_mut(record);
        let (old_roots, other_old_roots) = split(self.old_roots, record);
        let (manifolds, other_manifolds) = self.manifolds.split_at(manifold);
        let (blocks, other_blocks) = self.blocks.split_at_mut(block);
        let (tangents, other_tangents) = self.tangents.split_at_mut(next.tangents.start - first.tangents.start);
        let (unrest, other_unrest) = self.unrest.split_at_mut(block);
        let (joints, other_joints) = self.joints.cut(first, next);
        let one_for_all = self.scales.len() == 1;
        let (scales, other_scales) = if one_for_all { (self.scales, self.scales) } else { self.scales.split_at(block) };
        let other = Part {
            domains: other_domains,
            slots: other_slots,
            movers: other_movers,
            velocities: other_velocities,
            carried: other_carried,
            displacements: other_displacements,
            roots: other_roots,
            old_roots: other_old_roots,
            places: self.places,
            manifolds: other_manifolds,
            blocks: other_blocks,
            tangents: other_tangents,
            unrest: other_unrest,
            scales: other_scales,
            joints: other_joints,
        };
        let part = Part {
            domains,
            slots,
            movers,
            velocities,
            carried,
            displacements,
            roots,
            old_roots,
            places: self.places,
            manifolds,
            blocks,
            tangents,
            unrest,
            scales,
            joints,
        };
        (part, other)
    }
}

impl Batch {
    /// How large it is, about, beside others.
    pub(crate) fn size(&self) -> usize {
        (self.divisible + self.joint_count) as usize
    }

    /// Sorts bodies into domains, if they are worth it, for a share of so many threads.
    pub(crate) fn divide(&mut self, bodies: &Arena<BodyState>, links: &JointLinks, share: usize) {
        let cells = (self.joint_count as usize / JOINTS).clamp(1, CELLS);
        let domains = if cfg!(feature = "threads") { self.divisible as usize / MANIFOLDS } else { 1 };
        let parts = if cells > 1 { cells } else { domains.min(share).clamp(1, MOST) };
        self.domain_of_body.resize(self.movers.slots.len() - 1, 0);
        let mut first_records = [0; MOST];
        let first_records = &mut first_records[..parts];
        if cells > 1 {
            // The same bodies with the same joints are cut as they were.
            if self.cut_along != Some(links.edition) || !self.movers.are_as_before() {
                self.cut_branches(&links.ranks, cells);
            }
        } else if cfg!(feature = "threads") && parts > 1 {
            self.cut_space(bodies, parts);
        }
        self.cut_along = (cells > 1).then_some(links.edition);
        if parts > 1 {
            self.movers.arrange(&self.domain_of_body, first_records);
        }
        self.movers.make_blocks();
        let end = self.movers.records();
        self.part_of_block.clear();
        for (next, part) in first_records.iter().skip(1).chain([&end]).zip(0..) {
            self.part_of_block.resize(next / LANES, part);
        }
        self.cells = cells as u8;
        let domains = if share > 1 { parts } else { 1 };
        self.domains.resize_with(domains + 1, Domain::default);
        for domain in &mut self.domains {
            domain.forget();
        }
        self.domains[domains].records = 0..end;
        let mut end = end;
        for (domain, &first) in self.domains[..domains].iter_mut().zip(&*first_records).rev() {
            domain.records = first..end;
            end = first;
        }
    }

    /// Parts of as many bodies each, where branches of joints end.
    fn cut_branches(&mut self, ranks: &[u32], parts: usize) {
        let last = ranks.last().copied().unwrap_or_default();
        let rank_of = |&slot: &u32| ranks.get(slot as usize).copied().unwrap_or(last);
        let Self { movers, ranks_of_bodies, domain_of_body, .. } = self;
        ranks_of_bodies.clear();
        ranks_of_bodies.extend(movers.slots[1..].iter().map(rank_of));
        domain_of_body.fill(0);
        for part in 1..parts {
            let place = ranks_of_bodies.len() * part / parts;
            let first = *ranks_of_bodies.select_nth_unstable(place).1;
            for (domain, slot) in domain_of_body.iter_mut().zip(&movers.slots[1..]) {
                *domain += u8::from(rank_of(slot) >= first);
            }
        }
    }

    /// Parts of as many bodies each, that lie together.
    fn cut_space(&mut self, bodies: &Arena<BodyState>, parts: usize) {
        let Self { movers, centers, domain_of_body, .. } = self;
        centers.clear();
        centers.extend(movers.slots[1..].iter().zip(0..).map(|(&slot, index)| (bodies.at(slot).center, index)));
        let mut numbers = 0..;
        bisect(centers, parts, &mut |centers| {
            let number = numbers.next().unwrap_or_default();
            centers.iter().for_each(|&(_, index)| domain_of_body[index as usize] = number);
        });
    }

    /// How many domains there are, the seam aside.
    fn divided(&self) -> usize {
        if cfg!(feature = "threads") { self.domains.len() - 1 } else { 1 }
    }

    /// The part of both bodies, if it is the same.
    fn part_of(&self, bodies: [u32; 2]) -> Option<u8> {
        let of_body = |body: u32| self.part_of_block[body as usize / LANES];
        match bodies {
            [0, body] | [body, 0] => Some(of_body(body)),
            [a, b] => Some(of_body(a)).filter(|&part| part == of_body(b)),
        }
    }

    /// The cell of both bodies, or the seam.
    pub(super) fn cell_of(&self, bodies: [u32; 2]) -> u8 {
        if self.cells == 1 { 0 } else { self.part_of(bodies).unwrap_or(self.cells) }
    }

    /// The domain of both bodies, or the seam.
    pub(super) fn domain_of(&self, bodies: [u32; 2]) -> u8 {
        let domains = self.divided() as u8;
        if domains == 1 { 0 } else { self.part_of(bodies).unwrap_or(domains) }
    }

    /// What `domains` have of the arrays. Many lists: written out wherever it is asked for, it would be a tenth of the engine.
    #[inline(never)]
    fn part(&mut self, domains: Range<usize>) -> Part<'_> {
        let domains = &self.domains[domains];
        let (first, last) = (&domains[0], &domains[domains.len() - 1]);
        let records = first.records.start..last.records.end;
        let blocks = first.blocks.start..last.blocks.end;
        Part {
            slots: &self.movers.slots[records.clone()],
            movers: &mut self.movers.blocks[records.start / LANES..records.end / LANES],
            velocities: &mut self.velocities[records.clone()],
            carried: &mut self.carried[records.clone()],
            displacements: &mut self.displacements[records.clone()],
            old_roots: if self.old_roots.is_empty() { &mut [] } else { &mut self.old_roots[records.clone()] },
            roots: &mut self.roots[records.clone()],
            places: &self.places,
            manifolds: &self.manifolds[first.manifolds.start..last.manifolds.end],
            blocks: &mut self.blocks[blocks.clone()],
            tangents: &mut self.tangents[first.tangents.start..last.tangents.end],
            unrest: &mut self.unrest[blocks.clone()],
            scales: if self.scales.len() == 1 { &self.scales } else { &self.scales[blocks] },
            joints: JointPart::new(&mut self.joints, domains, records),
            domains,
        }
    }

    /// Calls `work` for each domain, side by side on the threads of the machine.
    pub(super) fn each<T: Send>(
        &mut self,
        machine: Machine<'_>,
        work: impl Fn(&mut Part<'_>) -> T + Sync,
    ) -> [Option<T>; MOST] {
        let domains = self.divided();
        let mut outputs = [const { None }; MOST];
        machine.workers.in_parts(self.part(0..domains), &mut outputs[..domains], |mut part, output| {
            *output = Some(work(&mut part));
        });
        outputs
    }

    /// The same for each domain, then the seam, where visits of blocks do not depend on each other.
    pub(super) fn each_and_seam(&mut self, machine: Machine<'_>, work: impl Fn(&mut Part<'_>) + Sync) {
        self.each(machine, &work);
        if let Some(mut seam) = self.seam() {
            work(&mut seam);
        }
    }

    /// Calls `work` with the blocks of each color after the other, where visits push bodies; with all of them where there
    /// is one domain, since they lie in the order of colors.
    pub(super) fn each_color(
        &mut self,
        machine: Machine<'_>,
        reversed: bool,
        work: impl Fn(&mut Part<'_>, Range<usize>) + Sync,
    ) {
        let domains = self.divided();
        if domains == 1 {
            let all = self.domains[0].blocks.clone();
            return work(&mut self.part(0..1), all);
        }
        let colors = self.domains[0].colors.len();
        for color in 0..colors {
            let color = if reversed { colors - 1 - color } else { color };
            let of_color = |part: &mut Part<'_>| work(part, part.blocks_of(color));
            let blocks: usize = self.domains[..domains].iter().map(|domain| domain.colors[color].len()).sum();
            if blocks > FEW {
                self.each(machine, of_color);
            } else {
                (0..domains).for_each(|domain| of_color(&mut self.part(domain..domain + 1)));
            }
            if let Some(mut seam) = self.seam() {
                of_color(&mut seam);
            }
        }
    }

    /// The seam, if there is one: never without threads, so that what is done to it takes no room in a program.
    pub(super) fn seam(&mut self) -> Option<Part<'_>> {
        if !cfg!(feature = "threads") {
            return None;
        }
        let number = self.divided();
        let seam = &self.domains[number];
        let is_empty = seam.manifolds.is_empty() && seam.joints.is_empty();
        (!is_empty).then(|| self.part(number..number + 1))
    }

    /// Calls `work` with the joints of each domain, then with those of the seam; or the other way around.
    pub(super) fn each_joint(&mut self, machine: Machine<'_>, reversed: bool, work: impl Fn(&mut Part<'_>) + Sync) {
        if !reversed {
            return self.each_and_seam(machine, work);
        }
        if let Some(mut seam) = self.seam() {
            work(&mut seam);
        }
        self.each(machine, work);
    }

    /// Loads and unrest of the islands.
    pub(super) fn sum_up(&mut self, machine: Machine<'_>) {
        let islands = self.islands.len();
        let (blocks, unrest) = (&self.blocks, &self.unrest);
        self.sums.resize_with(self.places.len().div_ceil(CHUNK), Sums::default);
        self.sums.iter_mut().zip(0..).for_each(|(sums, chunk)| sums.chunk = chunk);
        let places = &self.places;
        machine.workers.for_each(&mut self.sums, |sums| {
            sums.of_islands.clear();
            sums.of_islands.resize(islands, [0.0; 2]);
            for place in places[CHUNK * sums.chunk..].iter().take(CHUNK) {
                let (k, lane) = (place.block(), place.lane());
                let [load, energy] = &mut sums.of_islands[place.island as usize];
                *energy += unrest[k][lane];
                *load += blocks[k].points[..place.size.points()].iter().map(|p| p.lambda[lane]).sum::<f32>();
            }
        });
        for (island, state) in self.islands.iter_mut().enumerate() {
            (state.load, state.unrest) = (0.0, 0.0);
            for sums in &self.sums {
                let [load, unrest] = sums.of_islands[island];
                (state.load, state.unrest) = (state.load + load, state.unrest + unrest);
            }
        }
    }
}

/// Cuts along the longest side of what bodies take up into parts with as many of them each.
fn bisect(bodies: &mut [(Vec3, u32)], parts: usize, found: &mut impl FnMut(&[(Vec3, u32)])) {
    if parts == 1 {
        return found(bodies);
    }
    let (mut least, mut greatest) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for &(center, _) in &*bodies {
        (least, greatest) = (least.min(center), greatest.max(center));
    }
    let axis = (greatest - least).max_position();
    let near = parts / 2;
    let middle = bodies.len() * near / parts;
    bodies.select_nth_unstable_by(middle, |(a, one), (b, two)| a[axis].total_cmp(&b[axis]).then(one.cmp(two)));
    let (of_near, of_far) = bodies.split_at_mut(middle);
    bisect(of_near, near, found);
    bisect(of_far, parts - near, found);
}
