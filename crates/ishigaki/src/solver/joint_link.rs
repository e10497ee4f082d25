//! What stages ask of a joint beside its rows, close together in memory: joints themselves are thirty times as large.
//!
//! Made when the first step after a change of joints asks for them, in the order of slots.
//!
//! With them come two orders of what is joined. *Levels* go outward from what does not move, or from the first body of what
//! hangs on nothing: in their order a load passes through a whole net in a sweep. *Ranks* number bodies branch by branch:
//! cut anywhere, few joints between levels are cut.

use crate::body::BodyState;
use crate::constraint::joint::Joint;
use crate::handle::Arena;
use crate::solver::height;
use crate::solver::wide::joints;
use crate::union_find::{root, unite};
use crate::world::JointState;

/// A joint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointLink {
    /// Its slot.
    pub joint: u32,
    /// Slots of its bodies.
    pub bodies: [u32; 2],
    /// The wide path has rows for it.
    pub fits: bool,
    /// What it has beside them, as [`Parts::kind`](crate::solver::wide::joint_block::Parts::kind) says it.
    pub kind: u8,
    /// It closes a loop: those before it connect the same two already, over what does not move or not, and none joins them.
    pub closes: bool,
    /// Its bodies are not in one island already by those before it, or one of them does not move.
    pub unites: bool,
    /// It may break.
    pub breaks: bool,
    /// Hops of both bodies from what does not move, or from the first body of all that are joined.
    pub level: u32,
}

impl JointLink {
    /// Before it is known what else is joined.
    fn new(joint: u32, definition: &Joint) -> Self {
        Self {
            joint,
            bodies: [definition.body_a.index, definition.body_b.index],
            fits: joints::fits(definition),
            kind: joints::kind(definition),
            closes: false,
            unites: false,
            breaks: definition.break_force.is_some() || definition.break_torque.is_some(),
            level: 0,
        }
    }
}

/// Links of all joints.
#[derive(Clone, Debug, Default)]
pub(crate) struct JointLinks {
    /// In the order of slots. Empty until a step asks for them.
    pub list: Vec<JointLink>,
    /// The rank of each body that was there then.
    pub ranks: Vec<u32>,
    /// Another number after each change of what lanes have rows for: what was made from links holds as long as it is the
    /// same.
    pub edition: u64,
}

impl JointLinks {
    /// A joint was added or removed: the next step that asks for links makes them anew.
    pub fn forget(&mut self) {
        self.list.clear();
        self.edition += 1;
    }

    /// A joint allows something else now, between the same bodies.
    pub fn change(&mut self, joint: u32, definition: &Joint) {
        if let Ok(index) = self.list.binary_search_by_key(&joint, |link| link.joint) {
            let JointLink { closes, unites, level, fits, .. } = self.list[index];
            let changed = JointLink { closes, unites, level, ..JointLink::new(joint, definition) };
            // Motors are edited step after step: what the lanes have no rows for changes nothing there.
            self.edition += u64::from(fits || changed.fits);
            self.list[index] = changed;
        }
    }

    /// Makes them, unless they are there.
    pub fn collect(&mut self, joints: &Arena<JointState>, bodies: &Arena<BodyState>) {
        if self.list.len() != joints.len() {
            self.edition += 1;
            collect(joints, bodies, &mut self.list, &mut self.ranks);
        }
    }
}

fn collect(joints: &Arena<JointState>, bodies: &Arena<BodyState>, links: &mut Vec<JointLink>, ranks: &mut Vec<u32>) {
    links.clear();
    links.extend(joints.iter().map(|(slot, joint)| JointLink::new(slot, &joint.definition)));
    find_loops(links, bodies);
    let hops = hops(links, bodies);
    for link in &mut *links {
        link.level = link.bodies.map(|slot| hops[slot as usize]).iter().sum();
    }
    rank(links, &hops, ranks);
}

/// Which links close loops, and which unite islands.
fn find_loops(links: &mut [JointLink], bodies: &Arena<BodyState>) {
    // Whatever does not move is one: the number after the last slot.
    let ground = bodies.slot_count() as u32;
    let pair = |link: &JointLink| {
        let [a, b] = link.bodies.map(|slot| if bodies.at(slot).is_dynamic() { slot } else { ground });
        (a.min(b), a.max(b))
    };
    let mut pairs: Vec<(u32, u32, u32)> = Vec::with_capacity(links.len());
    for (link, index) in links.iter().zip(0..) {
        let (a, b) = pair(link);
        pairs.push((a, b, index));
    }
    // Triples are sorted elsewhere too, and each kind of sorting is 4 kB of the page.
    pairs.sort_unstable();
    pairs.dedup_by_key(|&mut (a, b, _)| (a, b));
    for (_, _, index) in pairs {
        links[index as usize].closes = true;
    }
    let mut connected: Vec<u32> = (0..=ground).collect();
    let mut of_island = connected.clone();
    for link in links {
        let (a, b) = pair(link);
        link.closes &= !joins(&mut connected, a, b);
        link.unites = b == ground || joins(&mut of_island, a, b);
    }
}

/// Unites two; whether they were apart.
fn joins(parents: &mut [u32], a: u32, b: u32) -> bool {
    let are_apart = root(parents, a) != root(parents, b);
    unite(parents, a, b);
    are_apart
}

/// Of each body: hops over joints from what does not move, or from the first body of all that are joined.
fn hops(links: &[JointLink], bodies: &Arena<BodyState>) -> Vec<u32> {
    let slots = bodies.slot_count();
    let moves: Vec<bool> = (0..slots as u32).map(|s| bodies.in_use(s).is_some_and(BodyState::is_dynamic)).collect();
    let mut parents: Vec<u32> = (0..slots as u32).collect();
    let mut hangs = vec![false; slots];
    let ends = links.iter().map(|link| link.bodies);
    for [a, b] in ends.clone().filter(|ends| ends.iter().all(|&s| moves[s as usize])) {
        unite(&mut parents, a, b);
    }
    for [a, b] in ends.clone() {
        for (body, other) in [(a, b), (b, a)] {
            hangs[root(&mut parents, body) as usize] |= !moves[other as usize];
        }
    }
    let is_first = |slot: u32| parents[slot as usize] == slot && !hangs[slot as usize];
    let is_ground = |slot: u32| !moves[slot as usize] || is_first(slot);
    let mut hops = vec![0; slots];
    height::heights(ends, is_ground, &mut height::Scratch::default(), &mut hops);
    hops
}

/// Numbers bodies so that each comes before all that hang on it, and these come together: a tree of shortest paths, branch
/// by branch. What has no joints has the rank of the body before it.
fn rank(links: &[JointLink], hops: &[u32], ranks: &mut Vec<u32>) {
    const NONE: u32 = u32::MAX;
    let mut nearer = vec![NONE; hops.len()];
    let mut joined: Vec<(u32, u32, u32)> = Vec::with_capacity(2 * links.len());
    for [a, b] in links.iter().map(|link| link.bodies) {
        for (body, other) in [(a, b), (b, a)] {
            // The third is nothing: see `find_loops`.
            joined.push((hops[body as usize], body, 0));
            let nearer = &mut nearer[body as usize];
            if *nearer == NONE && hops[other as usize] < hops[body as usize] {
                *nearer = other;
            }
        }
    }
    joined.sort_unstable();
    joined.dedup();
    let joined = || joined.iter().map(|&(_, body, _)| body);
    let mut branch = vec![1; hops.len()];
    for body in joined().rev().filter(|&body| nearer[body as usize] != NONE) {
        branch[nearer[body as usize] as usize] += branch[body as usize];
    }
    let mut next = vec![0; hops.len()];
    let mut next_root = 0;
    ranks.clear();
    ranks.resize(hops.len(), NONE);
    for body in joined() {
        let free = match nearer[body as usize] {
            NONE => &mut next_root,
            nearer => &mut next[nearer as usize],
        };
        let rank = *free;
        *free += branch[body as usize];
        (ranks[body as usize], next[body as usize]) = (rank, rank + 1);
    }
    let mut last = 0;
    for rank in ranks {
        last = if *rank == NONE { last } else { *rank };
        *rank = last;
    }
}

#[cfg(test)]
mod tests {
    use crate::{Body, Joint, Shape, Vec3, World};

    /// A net of 4 × 4 balls of which the first column is fixed: levels are columns and the joints between them, ranks go
    /// row by row; a ball that stands alone has that of the ball before it.
    #[test]
    fn levels_go_outward_and_ranks_along_branches() {
        let mut world = World::default();
        let mut balls = Vec::new();
        for k in 0..16_u8 {
            let (row, column) = (f32::from(k / 4), f32::from(k % 4));
            let shape = Shape::ball(0.1);
            let body = if k % 4 == 0 { Body::fixed(shape) } else { Body::dynamic(shape) };
            balls.push(world.add_body(body.at(Vec3::new(column, 0.0, row))).unwrap());
        }
        world.add_body(Body::dynamic(Shape::ball(0.1)).at(Vec3::Y)).unwrap();
        for k in 0..16 {
            let at = world.body(balls[k]).unwrap().position();
            if k % 4 > 0 {
                world.add_joint(Joint::ball(balls[k - 1], balls[k], at - 0.5 * Vec3::X)).unwrap();
            }
            if k % 4 > 0 && k > 3 {
                world.add_joint(Joint::ball(balls[k - 4], balls[k], at - 0.5 * Vec3::Z)).unwrap();
            }
        }
        let mut links = super::JointLinks::default();
        links.collect(&world.joints, &world.bodies);
        assert_eq!(links.list.len(), 12 + 9);
        for link in links.list {
            let [a, b] = link.bodies.map(|slot| slot % 4);
            assert_eq!(link.level, a + b);
        }
        let rows: Vec<u32> = (0..17).map(|k: u32| k.min(15)).collect();
        assert_eq!(links.ranks, rows);
    }
}
