//! Which manifolds move as one, by what a factorization may cost; choices are remembered.

use crate::solver::block_ldl::{MAX_SIZE, Pattern};
use crate::solver::level_correction::{Choice, LEVEL_MODES, LevelCorrection, Member, bodies_of};
use crate::solver::plan::Plan;

/// Cells begin here, in cells: not where things of one or one half of the length scale stand.
const OFFSET: f32 = 0.25;
/// Choices that are remembered at most; beyond, all are forgotten and made again.
const MOST_CHOICES: usize = 4096;
const MOST_DOUBLINGS: u32 = 16;

impl LevelCorrection {
    /// The groups of an island, from memory if it is as it was when they were chosen.
    pub(super) fn find_groups(&mut self, plan: &Plan, island: &mut [Member], cell: f32, most_work: u64) -> bool {
        let mut key = std::mem::take(&mut self.key);
        key.clear();
        key.extend(island.iter().map(|m| {
            let row = &plan.rows[plan.manifolds[m.manifold as usize].first as usize];
            let [x, y] = m.at.map(|c| cell_of(c, cell));
            [i64::from(row.body_a), i64::from(row.body_b), x, (y << 32) | i64::from(m.level)]
        }));
        let first = island.iter().map(|m| m.body).min().unwrap_or(0);
        let known = self.choices.remove(&first).filter(|c| c.most_work == most_work && c.key == key);
        let choice = if let Some(mut choice) = known {
            std::mem::swap(&mut self.pattern, &mut choice.pattern);
            if choice.fine {
                for (k, member) in island.iter_mut().enumerate() {
                    member.group = k as u32;
                }
            } else {
                group_cells(island, cell, choice.doublings);
            }
            self.key = key;
            choice
        } else {
            let (fine, doublings) = self.choose_groups(plan, island, cell, most_work);
            Choice { key, most_work, fine, doublings, pattern: Pattern::default() }
        };
        let fine = choice.fine;
        if self.choices.len() >= MOST_CHOICES {
            self.choices.clear();
        }
        self.current = Some((first, choice));
        fine
    }

    /// Puts the choice of the island back into memory.
    pub(super) fn remember(&mut self) {
        if let Some((first, mut choice)) = self.current.take() {
            std::mem::swap(&mut self.pattern, &mut choice.pattern);
            self.choices.insert(first, choice);
        }
    }

    /// Each manifold a node if that is affordable, else all of a level within a cell, in cells as small as possible;
    /// whether each is its own.
    fn choose_groups(&mut self, plan: &Plan, island: &mut [Member], cell: f32, most_work: u64) -> (bool, u32) {
        for (k, member) in island.iter_mut().enumerate() {
            member.group = k as u32;
        }
        let size = |m: &Member| if plan.manifolds[m.manifold as usize].layout.normals == 1 { 3 } else { MAX_SIZE };
        let mean = island.iter().map(size).sum::<usize>() as f32 / island.len() as f32;
        self.link_by_bodies(plan, island);
        if self.pattern.analyze(island.len(), self.links.iter().copied(), (most_work as f32 / mean.powi(3)) as u64) {
            self.pattern.set_sizes(island.iter().map(size));
            return (true, 0);
        }
        let most = most_work / LEVEL_MODES.pow(3) as u64;
        for doublings in 0..=MOST_DOUBLINGS {
            let groups = group_cells(island, cell, doublings);
            self.link_by_bodies(plan, island);
            let most = if doublings == MOST_DOUBLINGS { u64::MAX } else { most };
            if self.pattern.analyze(groups, self.links.iter().copied(), most) {
                self.pattern.set_sizes((0..groups).map(|_| LEVEL_MODES));
                return (false, doublings);
            }
        }
        (false, MOST_DOUBLINGS)
    }

    fn link_by_bodies(&mut self, plan: &Plan, island: &[Member]) {
        self.links.clear();
        let mut users = std::mem::take(&mut self.users);
        users.clear();
        for member in island {
            for body in bodies_of(plan, member) {
                users.push((body, member.group));
            }
        }
        users.sort_unstable();
        users.dedup();
        for same in users.chunk_by(|a, b| a.0 == b.0) {
            for (i, a) in same.iter().enumerate() {
                self.links.extend(same[..i].iter().map(|b| (a.1, b.1)));
            }
        }
        self.users = users;
    }
}

/// Index of the smallest cell along one axis; larger ones are made of these.
fn cell_of(at: f32, cell: f32) -> i64 {
    (at / cell + OFFSET).floor() as i64
}

/// Unites manifolds of a level whose upper bodies are in the same cell; members are sorted by group after it.
fn group_cells(island: &mut [Member], cell: f32, doublings: u32) -> usize {
    let key = |m: &Member| {
        let [x, y] = m.at.map(|c| cell_of(c, cell) >> doublings);
        (m.level, x, y)
    };
    island.sort_unstable_by_key(|m| (key(m), m.manifold));
    let (mut groups, mut last) = (0, None);
    for member in island.iter_mut() {
        if last != Some(key(member)) {
            (groups, last) = (groups + 1, Some(key(member)));
        }
        member.group = groups - 1;
    }
    groups as usize
}
