//! Joint trees: all hard rows of chains, trees and small loops of joints solved at once. Beyond the talk.
//!
//! A sweep passes a load on from joint to joint; a chain of 100 links under a load a thousand times as heavy as a link
//! stretches at any number of sweeps. Here the equality rows of connected joints are one unit of the sweep:
//! K Δλ = −(J u + bias) with K = J M⁻¹Jᵀ over the whole tree, sparse, by LDLᵀ (`block_ldl.rs`); for a tree the cost
//! is linear. Motors and contacts stay rows of their own, visited in turn with it; so do limits, which see what the tree
//! leaves free (`reference.rs`).
//!
//! A taut string of light links swings faster than any affordable substep: a link under the impulse λ of a joint at
//! arm r has the stiffness |λ|·|r|/h against turning. Where h·|λ|·|r| exceeds `FREE` of its inertia, what exceeds is added
//! to the inertia that joints see (*geometric stiffness*: the implicit treatment of that spring, with its mass matrix
//! made diagonal). Lightly loaded joints see the inertia as it is, and conserve angular momentum to rounding.
//! Option: `solver.joint_tree`; proved by `tests/joint_tree.rs`.
//! Sources: Baraff 1996 (linear-time dynamics with Lagrange multipliers); Tournier et al. 2015 (geometric stiffness).

use crate::math::{Mat3, Vec3};
use crate::solver::block::Block;
use crate::solver::block_ldl::{BlockLdl, MAX_SIZE, Pattern};
use crate::solver::height;
use crate::solver::table::{Row, SolverBody, inner, inner_at};
use crate::union_find::{root, unite};

/// Part of the inertia up to which a stiffness is left to the substep: symplectic Euler is stable below 4.
const FREE: f32 = 0.5;
/// Most products of blocks for each joint: a chain has 3; dense loops are left to sweeps.
const DENSE_COST: u64 = 12;

/// Joints that are solved at once.
#[derive(Clone, Debug, Default)]
pub struct JointTree {
    /// Indices of their blocks of rows.
    pub blocks: Vec<u32>,
    pattern: Pattern,
    ldl: BlockLdl,
    x: Vec<[f32; MAX_SIZE]>,
    coupling: Vec<[f32; MAX_SIZE]>,
    /// Other joints close loops with it: it is part of a net.
    pub in_net: bool,
    /// It touches something: its joints are solved one by one, in turn with the contacts.
    pub is_idle: bool,
    /// Moving body, block of the tree, whether it is the block's A; sorted.
    users: Vec<(u32, u32, bool)>,
}

/// All joint trees of a world.
#[derive(Clone, Debug, Default)]
pub struct Forest {
    /// By their first blocks.
    pub trees: Vec<JointTree>,
    /// Of each block: its two bodies if they move, and its rows; what the trees were found for.
    links: Vec<(Option<u32>, Option<u32>, u32)>,
    last_links: Vec<(Option<u32>, Option<u32>, u32)>,
}

impl Forest {
    /// Finds the trees among blocks of joint rows and marks their blocks; those of the last step if nothing changed.
    /// Of nets that would be too dear only the shortest paths to what does not move.
    pub fn find(&mut self, rows: &[Row], blocks: &mut [Block], bodies: &mut [SolverBody]) {
        let moving = |bodies: &[SolverBody], b: u32| (bodies[b as usize].inverse_mass != Vec3::ZERO).then_some(b);
        std::mem::swap(&mut self.links, &mut self.last_links);
        self.links.clear();
        self.links.extend(blocks.iter().map(|block| {
            let row = &rows[block.first as usize];
            (moving(bodies, row.body_a), moving(bodies, row.body_b), block.count)
        }));
        if self.links != self.last_links {
            self.trees.clear();
            self.plant(rows, blocks, bodies);
        }
        for (index, tree) in self.trees.iter_mut().enumerate() {
            tree.is_idle = tree.users.iter().any(|user| bodies[user.0 as usize].touched);
            for user in &tree.users {
                bodies[user.0 as usize].in_idle_tree = tree.is_idle;
                bodies[user.0 as usize].in_net = tree.in_net;
            }
            for &block in &tree.blocks {
                (blocks[block as usize].in_tree, blocks[block as usize].tree) = (!tree.is_idle, index as u32);
            }
        }
    }

    fn plant(&mut self, rows: &[Row], blocks: &[Block], bodies: &[SolverBody]) {
        let mut parents: Vec<u32> = (0..bodies.len() as u32).collect();
        for &(a, b, _) in &self.links {
            if let (Some(a), Some(b)) = (a, b) {
                unite(&mut parents, a, b);
            }
        }
        let mut by_root: Vec<(u32, u32)> = Vec::with_capacity(blocks.len());
        for (index, &(a, b, _)) in self.links.iter().enumerate() {
            if let Some(body) = a.or(b) {
                by_root.push((root(&mut parents, body), index as u32));
            }
        }
        by_root.sort_unstable();
        let moves = |b: u32| bodies[b as usize].inverse_mass != Vec3::ZERO;
        for same in by_root.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() > 1) {
            let mut tree = JointTree { blocks: same.iter().map(|s| s.1).collect(), ..JointTree::default() };
            // A loop that is closed twice over, as planks between two banks are, asks for the same motion in two ways:
            // its K is singular but for rounding.
            let is_affordable = tree.connect(rows, blocks, &moves);
            if tree.has_loops(blocks, rows) || !is_affordable {
                tree.in_net = true;
                tree.keep_shortest_paths(rows, blocks, bodies.len(), &moves);
                tree.connect(rows, blocks, &moves);
            }
            self.trees.push(tree);
        }
    }
}

impl JointTree {
    /// Leaves the joints on shortest paths to what does not move: loads of a net hang on them; the others become units
    /// of the sweep.
    fn keep_shortest_paths(&mut self, rows: &[Row], blocks: &[Block], bodies: usize, moves: &impl Fn(u32) -> bool) {
        let ends = |block: u32| {
            let row = &rows[blocks[block as usize].first as usize];
            (row.body_a, row.body_b)
        };
        let links: Vec<(u32, u32)> = self.blocks.iter().map(|&b| ends(b)).collect();
        let hangs = links.iter().any(|&(a, b)| !moves(a) || !moves(b));
        let first = links.iter().map(|&(a, b)| a.min(b)).min();
        let mut hops = vec![u32::MAX; bodies];
        let is_ground = |body: u32| if hangs { !moves(body) } else { Some(body) == first };
        height::heights(links.iter().map(|&(a, b)| [a, b]), is_ground, &mut height::Scratch::default(), &mut hops);
        // Of each body the first joint that leads nearer; parallel blocks of the same joint with it.
        let mut nearer: Vec<Option<(u32, u32)>> = vec![None; bodies];
        self.blocks.retain(|&block| {
            let (a, b) = ends(block);
            let (far, near) = if hops[a as usize] > hops[b as usize] { (a, b) } else { (b, a) };
            if hops[far as usize] == hops[near as usize] {
                return false;
            }
            let pair = nearer[far as usize].get_or_insert((a, b));
            *pair == (a, b)
        });
    }

    /// More pairs of bodies are joined than a tree of its moving bodies has.
    fn has_loops(&self, blocks: &[Block], rows: &[Row]) -> bool {
        let mut pairs: Vec<(u32, u32)> = self
            .blocks
            .iter()
            .map(|&b| {
                let row = &rows[blocks[b as usize].first as usize];
                (row.body_a.min(row.body_b), row.body_a.max(row.body_b))
            })
            .collect();
        pairs.sort_unstable();
        pairs.dedup();
        pairs.len() > self.users.chunk_by(|a, b| a.0 == b.0).count()
    }

    fn connect(&mut self, rows: &[Row], blocks: &[Block], moves: &impl Fn(u32) -> bool) -> bool {
        self.users.clear();
        for (node, &block) in self.blocks.iter().enumerate() {
            let row = &rows[blocks[block as usize].first as usize];
            for (body, is_a) in [(row.body_a, true), (row.body_b, false)] {
                if moves(body) {
                    self.users.push((body, node as u32, is_a));
                }
            }
        }
        self.users.sort_unstable();
        let mut links = Vec::new();
        for same in self.users.chunk_by(|a, b| a.0 == b.0) {
            for (i, a) in same.iter().enumerate() {
                links.extend(same[..i].iter().map(|b| (a.1, b.1)));
            }
        }
        let most = DENSE_COST * self.blocks.len() as u64;
        self.pattern.set_sizes(self.blocks.iter().map(|&b| blocks[b as usize].count as usize));
        self.pattern.analyze(self.blocks.len(), links.into_iter(), most)
    }

    /// Its moving bodies, by index in the plan; some more than once.
    pub fn bodies(&self) -> impl Iterator<Item = u32> + '_ {
        self.users.iter().map(|u| u.0)
    }

    /// Multiply-adds of a visit.
    pub fn visit_work(&self, blocks: &[Block]) -> u64 {
        let rows = self.blocks.iter().map(|&b| blocks[b as usize].size().visit());
        rows.sum::<u64>() + self.pattern.solve_work()
    }

    /// Multiply-adds of K and its factors.
    pub fn assembly_work(&self, blocks: &[Block]) -> u64 {
        let size = |node: u32| self.block(node, blocks).size();
        let mut sum = self.pattern.factor_work();
        for same in self.users.chunk_by(|a, b| a.0 == b.0) {
            for (i, one) in same.iter().enumerate() {
                sum += same[..i].iter().map(|other| size(one.1).inner_at(size(other.1))).sum::<u64>();
            }
        }
        sum + self.blocks.iter().map(|&b| blocks[b as usize].size().inner()).sum::<u64>()
    }

    /// K for the responses as they are, and its factors.
    pub fn factor(&mut self, rows: &[Row], blocks: &[Block]) {
        self.ldl.clear(&self.pattern);
        for (node, &index) in self.blocks.iter().enumerate() {
            let of_joint = &blocks[index as usize];
            let mut block = [[0.0; MAX_SIZE]; MAX_SIZE];
            for (i, line) in block[..of_joint.count as usize].iter_mut().enumerate() {
                // What is above the diagonal is not read.
                for (j, value) in line[..=i].iter_mut().enumerate() {
                    *value = of_joint.inner(i, j, rows);
                }
            }
            self.ldl.add(&self.pattern, node as u32, node as u32, &block);
        }
        for same in self.users.chunk_by(|a, b| a.0 == b.0) {
            for (k, &(_, one, one_is_a)) in same.iter().enumerate() {
                for &(_, other, other_is_a) in &same[..k] {
                    let (of_one, of_other) = (self.block(one, blocks), self.block(other, blocks));
                    let mut block = [[0.0; MAX_SIZE]; MAX_SIZE];
                    for (i, line) in block[..of_one.count as usize].iter_mut().enumerate() {
                        for (j, value) in line[..of_other.count as usize].iter_mut().enumerate() {
                            *value = of_one.inner_at(i, one_is_a, of_other, j, other_is_a, rows);
                        }
                    }
                    self.ldl.add(&self.pattern, one, other, &block);
                }
            }
        }
        self.ldl.factor(&self.pattern, 0.0);
    }

    /// J M⁻¹Jᵀ of a row on its bodies with what the tree leaves of M⁻¹: K_ll − K_lt K⁻¹ K_tl.
    pub fn free_part(&mut self, row: &Row, rows: &[Row], blocks: &[Block]) -> f32 {
        let (mut x, mut coupling) = (std::mem::take(&mut self.x), std::mem::take(&mut self.coupling));
        coupling.clear();
        coupling.resize(self.blocks.len(), [0.0; MAX_SIZE]);
        for (body, is_a) in [(row.body_a, true), (row.body_b, false)] {
            let first = self.users.partition_point(|user| user.0 < body);
            for &(_, node, node_is_a) in self.users[first..].iter().take_while(|user| user.0 == body) {
                for (c, other) in coupling[node as usize].iter_mut().zip(self.rows(node, rows, blocks)) {
                    *c += inner_at(row, is_a, other, node_is_a);
                }
            }
        }
        x.clone_from(&coupling);
        self.ldl.solve(&self.pattern, &mut x);
        let taken: f32 = coupling.iter().flatten().zip(x.iter().flatten()).map(|(c, x)| c * x).sum();
        (self.x, self.coupling) = (x, coupling);
        inner(&row.jacobian, &row.response) - taken
    }

    fn block<'a>(&self, node: u32, blocks: &'a [Block]) -> &'a Block {
        &blocks[self.blocks[node as usize] as usize]
    }

    fn rows<'a>(&self, node: u32, rows: &'a [Row], blocks: &[Block]) -> &'a [Row] {
        let block = self.block(node, blocks);
        &rows[block.first as usize..][..block.count as usize]
    }

    /// Δλ = −K⁻¹(J u + bias), u += M⁻¹Jᵀ Δλ, for all joints of the tree.
    pub fn solve(&mut self, rows: &mut [Row], blocks: &[Block], bodies: &mut [SolverBody]) {
        let mut x = std::mem::take(&mut self.x);
        x.clear();
        x.extend(self.blocks.iter().map(|&block| blocks[block as usize].velocities(rows, bodies)));
        self.ldl.solve(&self.pattern, &mut x);
        if !x.iter().flatten().all(|x| x.is_finite()) {
            // Numbers beyond f32: there is no solution to take a step to.
            self.x = x;
            return;
        }
        for (x, &block) in x.iter().zip(&self.blocks) {
            blocks[block as usize].add(&x.map(|x| -x), rows, bodies);
        }
        self.x = x;
    }
}

// ANCHOR: stiffen
/// Inverse inertia that joints see: with the geometric stiffness of their impulses in a substep `h`, s.
pub fn stiffen(rows: &[Row], blocks: &[Block], h: f32, bodies: &mut [SolverBody]) {
    for body in bodies.iter_mut() {
        body.stiffness = 0.0;
    }
    for block in blocks {
        let rows = &rows[block.first as usize..][..block.count as usize];
        // Solved one by one they need none, and heaps come to rest sooner without.
        if bodies[rows[0].body_a as usize].keeps_rows || bodies[rows[0].body_b as usize].keeps_rows {
            continue;
        }
        let impulse: Vec3 = rows.iter().map(|r| r.lambda * r.jacobian.linear).sum();
        let axes = rows.iter().filter(|r| r.jacobian.linear != Vec3::ZERO).count();
        // Σ|r × e|² = 2|r|² over three axes, |r|² or less over one.
        let part = 1.0 / axes.saturating_sub(1).max(1) as f32;
        let square = |angular: &dyn Fn(&Row) -> Vec3| -> f32 {
            let linear = rows.iter().filter(|r| r.jacobian.linear != Vec3::ZERO);
            part * linear.map(|r| angular(r).length_squared()).sum::<f32>()
        };
        let (arm_a, arm_b) = (square(&|r| r.jacobian.angular_a).sqrt(), square(&|r| r.jacobian.angular_b).sqrt());
        let size = h * impulse.length();
        bodies[rows[0].body_a as usize].stiffness += size * arm_a;
        bodies[rows[0].body_b as usize].stiffness += size * arm_b;
    }
    for body in bodies.iter_mut().filter(|b| b.stiffness > 0.0) {
        let inverse = body.inverse_inertia;
        let trace = inverse.x_axis.x + inverse.y_axis.y + inverse.z_axis.z;
        if body.stiffness * trace > FREE {
            let excess = body.stiffness - FREE / trace;
            // (I + s)⁻¹ = (1 + s I⁻¹)⁻¹ I⁻¹.
            body.inverse_inertia = (Mat3::IDENTITY + excess * inverse).inverse() * inverse;
        }
    }
}
// ANCHOR_END: stiffen
