//! Colors: manifolds of one color share no body that moves; eight of them make a block.
//!
//! Manifolds get the lowest color that none of their bodies has yet, in the order of contacts; those of a block are of
//! one domain, of about as many points, and between round bodies or not. Colors depend on islands and contacts alone,
//! never on lanes or threads.

use crate::solver::wide::batch::{Batch, Place};
use crate::solver::wide::contact_block::{ContactBlock, Size, TangentLanes};
use crate::solver::wide::domain::KINDS;
use crate::solver::wide::lanes::LANES;

impl Place {
    /// Number of the kind of block it is in.
    fn kind(&self) -> usize {
        2 * self.size as usize + usize::from(self.is_round)
    }
}

/// Colors that are told apart; what finds none of them free gets a color of its own.
const COLORS: usize = 64;

impl Batch {
    /// Colors of the manifolds, and blocks for each domain, color and size. A line of its own in profiles.
    #[inline(never)]
    pub(super) fn color(&mut self) {
        self.find_round();
        self.used_colors.clear();
        self.used_colors.resize(self.movers.records(), 0);
        let mut colors = 0;
        let mut own_color = COLORS as u32;
        for domain in &mut self.domains {
            domain.counts_of.clear();
        }
        for p in 0..self.places.len() {
            let place = self.places[p];
            let moving = place.bodies.iter().filter(|&&b| b != 0);
            let taken = moving.clone().fold(0, |taken, &body| taken | self.used_colors[body as usize]);
            let mut color = taken.trailing_ones();
            if color < COLORS as u32 {
                moving.for_each(|&body| self.used_colors[body as usize] |= 1 << color);
            } else {
                (color, own_color) = (own_color, own_color + 1);
            }
            let is_round = place.is_round && self.islands[place.island as usize].is_round();
            let domain = self.domain_of(place.bodies);
            let counts_of = &mut self.domains[usize::from(domain)].counts_of;
            colors = colors.max(color as usize + 1);
            if counts_of.len() <= color as usize {
                counts_of.resize(color as usize + 1, [0; KINDS]);
            }
            let place = &mut self.places[p];
            (place.lane, place.is_round, place.domain) = (color, is_round, domain);
            counts_of[color as usize][place.kind()] += 1;
        }
        self.make_blocks(colors);
        self.name_manifolds();
    }

    /// Which manifolds are between round bodies.
    fn find_round(&mut self) {
        self.islands.iter_mut().for_each(|island| island.round_manifolds = 0);
        for place in &mut self.places {
            place.is_round = place.bodies.iter().all(|&body| self.movers.is_round(body));
            self.islands[place.island as usize].round_manifolds += u32::from(place.is_round);
        }
    }

    /// Blocks for what was counted. Full ones are written over as they are, lane by lane: only those with lanes that
    /// nothing fills are emptied.
    fn make_blocks(&mut self, colors: usize) {
        let (mut first, mut manifolds, mut tangents) = (0, 0, 0);
        let counts = self.domains.iter().flat_map(|domain| domain.counts_of.as_flattened());
        self.make_room(counts.map(|count| count.div_ceil(LANES as u32) as usize).sum());
        for domain in &mut self.domains {
            domain.counts_of.resize(colors, [0; KINDS]);
            domain.colors.clear();
            (domain.blocks.start, domain.manifolds.start) = (first, manifolds);
            domain.tangents.start = tangents;
            for of_color in &mut domain.counts_of {
                let start = first;
                for (kind, count) in of_color.iter_mut().enumerate() {
                    let (size, is_round) = (Size::ALL[kind / 2], kind % 2 == 1);
                    manifolds += *count as usize;
                    let blocks = count.div_ceil(LANES as u32) as usize;
                    if self.blocks.len() < first + blocks {
                        self.blocks.resize(first + blocks, ContactBlock::EMPTY);
                    }
                    if !count.is_multiple_of(LANES as u32) {
                        let last = first + blocks - 1;
                        self.blocks[last] = ContactBlock::EMPTY;
                    }
                    for block in &mut self.blocks[first..first + blocks] {
                        (block.size, block.tangents) = (size, ContactBlock::ROUND);
                        if !is_round {
                            block.tangents = (tangents - domain.tangents.start) as u32;
                            tangents += 1;
                        }
                    }
                    *count = (first * LANES) as u32;
                    first += blocks;
                }
                domain.colors.push(start..first);
            }
            (domain.blocks.end, domain.tangents.end) = (first, tangents);
            domain.manifolds.end = domain.manifolds.start;
        }
        self.blocks.truncate(first);
        self.tangents.resize(tangents, TangentLanes::EMPTY);
        self.unrest.resize(first, [0.0; LANES]);
        self.manifolds.clear();
        self.manifolds.resize(manifolds, 0);
    }

    /// Room for so many blocks: at first as much as they take, not twice that; later some more, since heaps grow step after
    /// step. What the old ones hold is not copied: all is written over.
    fn make_room(&mut self, blocks: usize) {
        let room = self.blocks.capacity();
        if blocks > room {
            let more = if room > 0 { blocks / 8 } else { 0 };
            self.blocks = Vec::new();
            self.blocks.reserve_exact(blocks + more);
        }
    }

    /// Where manifolds are among the blocks; the list of those of each domain.
    fn name_manifolds(&mut self) {
        for (place, name) in self.places.iter_mut().zip(0..) {
            let domain = &mut self.domains[usize::from(place.domain)];
            let next = &mut domain.counts_of[place.lane as usize][place.kind()];
            (place.lane, *next) = (*next, *next + 1);
            self.manifolds[domain.manifolds.end] = name;
            domain.manifolds.end += 1;
        }
    }
}
