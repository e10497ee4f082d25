//! Level correction: loads of whole stacks at once. Beyond the talk.
//!
//! A sweep carries information over one contact; a tower of n boxes needs n² sweeps and falls before it had them.
//! Here each manifold moves in six *modes* (load, two tilts, two shears, twist: every wrench it can bear), and all
//! modes of an island are solved at once as if contacts were welds: T s = −r with T = Σ yᵀM⁻¹y, y = JᵀP, r = Pᵀw,
//! sparse, by LDLᵀ (`block_ldl.rs`). What came out is projected onto what contacts can do, d = Π(λ + Ps) − λ, and
//! taken as far as it lowers the energy of the residual, α = clamp(−wᵀd / dᵀAd, 0, 1): it can only help. Points that
//! would pull are let go, tangents that would slip are held at their cone, and the rest is solved again.
//! Where an island is too wide for that, all manifolds of one level that share bodies move in three modes (load and
//! two tilts, in proportion to their λ). Sweeps before and after do the rest.
//! Fixed point and equation are those of the rows: λ of the box LCP. Off while masses are amplified (the energy
//! above needs symmetric masses). Option: `solver.level_correction`; proved by `tests/level_correction.rs`.

use crate::body::NO_HEIGHT;
use crate::constraint::friction::Coupling;
use crate::math::Vec3;
use crate::solver::block_ldl::{BlockLdl, MAX_SIZE, Pattern};
use crate::solver::hand_down;
use crate::solver::manifold_block;
use crate::solver::plan::{ManifoldRows, Plan};
use crate::solver::reference::{self, Unit};
use crate::solver::table::SolverBody;
use crate::solver::work as cost;
use crate::world::World;
use std::collections::BTreeMap;

/// Cells begin here, in cells: not where things of one or one half of the length scale stand.
const OFFSET: f32 = 0.25;
/// Modes of a level.
const LEVEL_MODES: usize = 3;
/// Modes of a manifold.
type Modes = [f32; MAX_SIZE];

/// A manifold that takes part.
#[derive(Clone, Copy, Debug)]
struct Member {
    /// Index in the plan.
    manifold: u32,
    island: u32,
    /// Slot of a dynamic body of it.
    body: u32,
    /// Of its upper body.
    level: u32,
    /// Node of the system; local to the island.
    group: u32,
    /// Horizontal position of its upper body, m.
    at: [f32; 2],
    /// Σλ_n, or a floor for what just touched, N·s.
    load: f32,
    /// It bears, or is about to.
    active: bool,
    /// Index of its first row in the arrays by row.
    first: u32,
}

/// What a row may do in a try.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// Moves with the modes.
    Free,
    /// Keeps the change it has: released, or at its cone.
    Held,
}

/// What a mode pushes one body with.
#[derive(Clone, Copy, Debug)]
struct Entry {
    body: u32,
    group: u32,
    /// In which it was made: sums do not depend on how they are sorted.
    order: u32,
    /// Force impulse and torque impulse by mode.
    linear: [Vec3; MAX_SIZE],
    angular: [Vec3; MAX_SIZE],
}

/// What was chosen for an island, and for what.
#[derive(Clone, Debug, Default)]
struct Choice {
    /// Bodies, level and cell of each member; the work a factorization may cost.
    key: Vec<[i64; 4]>,
    most_work: u64,
    fine: bool,
    doublings: u32,
    pattern: Pattern,
}

/// Choices that are remembered at most; beyond, all are forgotten and made again.
const MOST_CHOICES: usize = 4096;

/// Arrays that are used again.
#[derive(Clone, Debug, Default)]
pub struct LevelCorrection {
    /// By the first body of the island. The same island with the same contacts gets the same choice, remembered or not.
    choices: BTreeMap<u32, Choice>,
    key: Vec<[i64; 4]>,
    members: Vec<Member>,
    pattern: Pattern,
    ldl: BlockLdl,
    entries: Vec<Entry>,
    solution: Vec<Modes>,
    /// By row of the island: P.
    coefficients: Vec<Modes>,
    w: Vec<f32>,
    change: Vec<f32>,
    best: Vec<f32>,
    states: Vec<State>,
    /// By body of the plan: impulse of a change of λ.
    push: Vec<(Vec3, Vec3)>,
    touched: Vec<u32>,
    /// Multiply-adds of the step so far.
    pub work: u64,
    /// First bodies of islands that corrections did not help, until the caller takes them.
    pub(crate) pauses: Vec<u32>,
    current: Option<(u32, Choice)>,
    links: Vec<(u32, u32)>,
    users: Vec<(u32, u32)>,
}

/// A factorization may cost as much as this many sweeps; what costs more gets coarser modes.
const SWEEPS: u64 = 4;
const MOST_DOUBLINGS: u32 = 16;
/// Added to the unit diagonal: f32.
const EPSILON: f32 = 1e-4;
/// Rounds of correction and sweep in a substep.
const ROUNDS: usize = 6;
/// A correction that takes less than this part of Σλ g h was the last, and below `CALM` none is made.
const ENOUGH: f32 = 1e-7;
pub(crate) const CALM: f32 = 1e-9;
/// A correction must take this part of what sweeps for the same work would take; else it rests for `PAUSE` steps.
const WORTH: f32 = 0.2;
pub(crate) const HOPELESS: f32 = 0.03;
pub(crate) const PAUSE: u64 = 8;
/// Above this part of Σλ g h bodies hit each other; below it they rest or sag.
pub(crate) const TUMBLING: f32 = 1e-2;
/// More manifolds than `MANY`, and more than `WIDTH` on a level, are dear to correct.
const MANY: usize = 200;
const WIDTH: usize = 4;
/// Tries: solutions with another set of points.
const TRIES: usize = 3;

impl World {
    /// Corrects the impulses of all islands that stand on the ground in levels.
    pub(crate) fn correct_levels(&self, plan: &mut Plan, h: f32) {
        let mut work = std::mem::take(&mut plan.level_correction);
        self.gather_members(plan, &mut work, h);
        let mut members = std::mem::take(&mut work.members);
        plan.calm.clear();
        plan.calm.resize(plan.manifolds.len(), false);
        for island in members.chunk_by_mut(|a, b| a.island == b.island) {
            island.sort_unstable_by_key(|m| (!m.active, m.level, m.manifold));
            let active = island.iter().filter(|m| m.active).count();
            let first = island.iter().map(|m| m.body).min().unwrap_or(0);
            let pauses = self.bodies.at(first).no_correction_until > self.step_count;
            let stands = !pauses && active > 1 && island[0].level == 1 && island[active - 1].level > 1;
            if stands {
                let is_dear = is_dear(island.len(), island[active - 1].level as usize);
                let worth_it = if is_dear && self.options.solver.hand_down.enabled {
                    self.hand_down_island(plan, &mut work, island, active, h)
                } else {
                    let worth_it = self.correct_island(plan, &mut work, island, active, h);
                    work.remember();
                    worth_it
                };
                if !worth_it {
                    work.pauses.push(first);
                }
            }
        }
        work.members = members;
        plan.level_correction = work;
    }

    /// Hand-down in place of a correction; whether it was worth its work.
    fn hand_down_island(
        &self,
        plan: &mut Plan,
        work: &mut LevelCorrection,
        all: &mut [Member],
        active: usize,
        h: f32,
    ) -> bool {
        let scale = all.iter().map(|m| m.load).sum::<f32>() * self.options.gravity.length() * h;
        let island = &mut all[..active];
        let rows = number_rows(plan, island);
        work.start(plan, island, rows);
        let unrest = work.unrest(plan, island);
        if unrest <= CALM * scale {
            for member in all.iter() {
                plan.calm[member.manifold as usize] = true;
            }
            return true;
        }
        let gain = self.hand_down_rows(plan, all.iter().map(|m| m.manifold));
        !hand_down::is_hopeless(gain, unrest, scale)
    }

    /// Correction and a sweep over the island's contacts in turn, while the correction still finds something; whether
    /// it was worth its work.
    fn correct_island(
        &self,
        plan: &mut Plan,
        work: &mut LevelCorrection,
        all: &mut [Member],
        active: usize,
        h: f32,
    ) -> bool {
        let passes = manifold_block::passes(&self.options.solver.manifold_block).unwrap_or(1);
        let scale = all.iter().map(|m| m.load).sum::<f32>() * self.options.gravity.length() * h;
        let sweep_work: u64 = all.iter().map(|m| plan.manifold_work(m.manifold, u64::from(passes))).sum();
        let borne: f32 = all
            .iter()
            .map(|m| plan.rows[normals_of(&plan.manifolds[m.manifold as usize])].iter().map(|r| r.lambda).sum::<f32>())
            .sum();
        let is_new = borne < 0.5 * all.iter().map(|m| m.load).sum::<f32>();
        let cell = self.options.length_scale;
        let mut fine = None;
        let rounds = if is_new { 5 * ROUNDS } else { ROUNDS };
        for round in 0..rounds {
            let island = &mut all[..active];
            let rows = number_rows(plan, island);
            work.start(plan, island, rows);
            let unrest = work.unrest(plan, island);
            if unrest <= CALM * scale {
                for member in all.iter() {
                    plan.calm[member.manifold as usize] = true;
                }
                break;
            }
            let before = work.work;
            let fine = *fine.get_or_insert_with(|| work.find_groups(plan, island, cell, SWEEPS * sweep_work));
            let gain = self.correct_once(plan, work, island, fine);
            let sweeps = (work.work - before) as f32 / sweep_work as f32;
            let worth_it = gain > WORTH * sweeps * unrest;
            for k in 0..all.len() {
                let at = if round % 2 == 0 { k } else { all.len() - 1 - k };
                let manifold = all[at].manifold;
                reference::visit(Unit::Manifold(manifold), plan, passes);
            }
            work.work += sweep_work;
            if !worth_it && !is_new {
                let hopeless = gain < HOPELESS * sweeps * unrest && unrest > TUMBLING * scale;
                return round > 0 || !hopeless;
            }
            if gain <= ENOUGH * scale {
                break;
            }
        }
        true
    }

    fn gather_members(&self, plan: &Plan, work: &mut LevelCorrection, h: f32) {
        work.members.clear();
        let scale = self.options.length_scale;
        let gravity = self.options.gravity;
        let (t1, t2) = crate::math::tangents(gravity.normalize_or(Vec3::NEG_Y));
        for (index, m) in plan.manifolds.iter().enumerate() {
            if m.layout.normals == 0 {
                continue;
            }
            let normals = normals_of(m);
            let row = &plan.rows[normals.start];
            let (a, b) = (&plan.bodies[row.body_a as usize], &plan.bodies[row.body_b as usize]);
            let (height_a, height_b) = (a.height, b.height);
            if height_a == NO_HEIGHT || height_b == NO_HEIGHT {
                continue;
            }
            let sum: f32 = plan.rows[normals.clone()].iter().map(|r| r.lambda).sum();
            let inverse = a.inverse_mass.max_element() + b.inverse_mass.max_element();
            if inverse <= 0.0 {
                continue;
            }
            let floor = 0.1 * gravity.length() * h / inverse;
            // What hangs on joints too is not held by its contacts alone.
            let mut active = !(a.jointed || b.jointed);
            if sum <= 0.0 {
                let near = plan.rows[normals].iter().any(|r| r.bias * h < 1e-3 * scale);
                active &= near && height_a != height_b;
            }
            let contact = &self.contacts[m.contact as usize];
            let (one, two) = (self.bodies.at(contact.body_a), self.bodies.at(contact.body_b));
            let (body, island) =
                if one.is_active() { (contact.body_a, one.island) } else { (contact.body_b, two.island) };
            let upper = if height_a > height_b { one.center } else { two.center };
            work.members.push(Member {
                manifold: index as u32,
                island,
                body,
                level: height_a.max(height_b),
                group: 0,
                at: [upper.dot(t1), upper.dot(t2)],
                load: if active { sum.max(floor) } else { 0.0 },
                active,
                first: 0,
            });
        }
        work.members.sort_unstable_by_key(|m| (m.island, m.manifold));
    }

    // ANCHOR: correct_once
    /// One correction; the energy of the residual that it took away, J.
    fn correct_once(&self, plan: &mut Plan, work: &mut LevelCorrection, island: &[Member], fine: bool) -> f32 {
        let (mut best_gain, mut best_alpha) = (0.0_f32, 0.0);
        let mut epsilon = EPSILON;
        for _ in 0..TRIES {
            self.set_modes(plan, work, island, fine);
            work.assemble(plan, island, fine);
            work.ldl.factor(&work.pattern, epsilon);
            work.work += work.pattern.factor_work() + work.pattern.solve_work();
            work.right_side(plan, island);
            work.ldl.solve(&work.pattern, &mut work.solution);
            let violated = work.project(plan, island);
            let (slope, curvature) = work.search(plan, island);
            let alpha = if curvature > 0.0 { (-slope / curvature).clamp(0.0, 1.0) } else { 0.0 };
            let gain = -alpha * slope - 0.5 * alpha * alpha * curvature;
            if gain > best_gain && gain.is_finite() {
                (best_gain, best_alpha) = (gain, alpha);
                work.best.clone_from(&work.change);
            }
            if alpha > 0.95 || !violated {
                break;
            }
            epsilon *= 10.0;
        }
        if best_gain > 0.0 {
            work.apply(plan, island, best_alpha);
        }
        best_gain
    }
    // ANCHOR_END: correct_once

    fn set_modes(&self, plan: &Plan, work: &mut LevelCorrection, island: &[Member], fine: bool) {
        for c in &mut work.coefficients {
            *c = [0.0; MAX_SIZE];
        }
        if fine {
            for member in island {
                self.wrench_modes(plan, work, member);
            }
        } else {
            for group in island_groups(island) {
                self.level_modes(plan, work, island, group);
            }
        }
    }

    /// Load, two tilts, two shears, twist.
    fn wrench_modes(&self, plan: &Plan, work: &mut LevelCorrection, member: &Member) {
        let m = &plan.manifolds[member.manifold as usize];
        let points = &self.contacts[m.contact as usize].manifolds[m.manifold as usize].points;
        let first = member.first as usize;
        let normal = first + m.layout.first_normal() as usize;
        let free = |i: usize| work.states[normal + i] == State::Free;
        let count = (0..points.len()).filter(|&i| free(i)).count();
        if count == 0 {
            return;
        }
        let share = member.load / count as f32;
        let centroid: Vec3 =
            (0..points.len()).filter(|&i| free(i)).map(|i| points[i].arm_b).sum::<Vec3>() / count as f32;
        let row = &plan.rows[normals_of(m).start];
        let (t1, t2) = crate::math::tangents(row.jacobian.linear);
        let size = (0..points.len()).map(|i| (points[i].arm_b - centroid).length()).fold(0.0, f32::max).max(1e-9);
        let sum: f32 = plan.rows[normals_of(m)].iter().map(|r| r.lambda).sum();
        let carried = if sum > 0.0 { member.load / sum } else { 0.0 };
        let mu = m.surface.friction;
        let tangents = m.layout.tangents > 0;
        let mut coefficients = std::mem::take(&mut work.coefficients);
        for i in (0..points.len()).filter(|&i| free(i)) {
            let (x, y) = {
                let offset = (points[i].arm_b - centroid) / size;
                (offset.dot(t1), offset.dot(t2))
            };
            coefficients[normal + i] = [share, share * x, share * y, 0.0, 0.0, 0.0];
            if tangents && work.states[first + 2 * i] == State::Free {
                let (own1, own2) = (&plan.rows[m.first as usize + 2 * i], &plan.rows[m.first as usize + 2 * i + 1]);
                let grip = mu * share;
                coefficients[first + 2 * i] = [carried * own1.lambda, 0.0, 0.0, grip, 0.0, -grip * y];
                coefficients[first + 2 * i + 1] = [carried * own2.lambda, 0.0, 0.0, 0.0, grip, grip * x];
            }
        }
        work.coefficients = coefficients;
    }

    /// Load and two tilts of a level, in proportion to the impulses as they are.
    fn level_modes(&self, plan: &Plan, work: &mut LevelCorrection, island: &[Member], group: std::ops::Range<usize>) {
        let down = self.options.gravity.normalize_or_zero();
        let (t1, t2) = crate::math::tangents(-down);
        let position = |m: &ManifoldRows, i: usize| {
            let contact = &self.contacts[m.contact as usize];
            self.bodies.at(contact.body_b).center + contact.manifolds[m.manifold as usize].points[i].arm_b
        };
        let (mut load, mut moment, mut size) = (0.0_f32, Vec3::ZERO, 1e-9_f32);
        let origin = position(&plan.manifolds[island[group.start].manifold as usize], 0);
        let each = |f: &mut dyn FnMut(&Member, &ManifoldRows, usize, f32, Vec3)| {
            for member in &island[group.clone()] {
                let m = &plan.manifolds[member.manifold as usize];
                let normals = &plan.rows[normals_of(m)];
                let sum: f32 = normals.iter().map(|r| r.lambda).sum();
                for (i, row) in normals.iter().enumerate() {
                    let own =
                        if sum > 0.0 { row.lambda * member.load / sum } else { member.load / normals.len() as f32 };
                    f(member, m, i, own, position(m, i) - origin);
                }
            }
        };
        each(&mut |_, _, _, own, at| {
            load += own;
            moment += own * at;
        });
        let centroid = moment / load.max(1e-30);
        each(&mut |_, _, _, _, at| size = size.max((at - centroid).length()));
        let (states, coefficients) = (&work.states, &mut work.coefficients);
        each(&mut |member, m, i, own, at| {
            let first = member.first as usize;
            let normal = first + m.layout.first_normal() as usize + i;
            if states[normal] != State::Free {
                return;
            }
            let offset = (at - centroid) / size;
            let shape = [1.0, offset.dot(t1), offset.dot(t2), 0.0, 0.0, 0.0];
            coefficients[normal] = shape.map(|s| s * own);
            if m.layout.tangents > 0 {
                for t in [2 * i, 2 * i + 1] {
                    let lambda = plan.rows[m.first as usize + t].lambda;
                    coefficients[first + t] = shape.map(|s| s * lambda);
                }
            }
        });
    }
}

/// Whether an island is too wide to be corrected: its loads are handed down.
pub(crate) fn is_dear(manifolds: usize, levels: usize) -> bool {
    manifolds > MANY && manifolds > WIDTH * levels
}

fn normals_of(m: &ManifoldRows) -> std::ops::Range<usize> {
    let first = (m.first + m.layout.first_normal()) as usize;
    first..first + m.layout.normals as usize
}

/// Runs of members with the same group.
fn island_groups(island: &[Member]) -> impl Iterator<Item = std::ops::Range<usize>> + '_ {
    let mut start = 0;
    island.chunk_by(|a, b| a.group == b.group).map(move |run| {
        let range = start..start + run.len();
        start = range.end;
        range
    })
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

/// Gives each member its place in the arrays by row; how many rows there are.
fn number_rows(plan: &Plan, island: &mut [Member]) -> usize {
    let mut rows = 0;
    for member in island.iter_mut() {
        member.first = rows;
        rows += plan.manifolds[member.manifold as usize].layout.total();
    }
    rows as usize
}

impl LevelCorrection {
    /// The groups of an island, from memory if it is as it was when they were chosen.
    fn find_groups(&mut self, plan: &Plan, island: &mut [Member], cell: f32, most_work: u64) -> bool {
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
    fn remember(&mut self) {
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

    /// What a visit to each row alone would take of the energy of the residual, J.
    fn unrest(&self, plan: &Plan, island: &[Member]) -> f32 {
        let mut sum = 0.0_f64;
        for member in island {
            let m = &plan.manifolds[member.manifold as usize];
            for k in 0..m.layout.total() as usize {
                let (row, w) = (&plan.rows[m.first as usize + k], self.w[member.first as usize + k]);
                let change = if row.coupling == Coupling::None {
                    (row.lambda - w * row.effective_mass).max(0.0) - row.lambda
                } else {
                    -w * row.effective_mass
                };
                sum += 0.5 * f64::from(change * w).abs();
            }
        }
        sum as f32
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

    fn start(&mut self, plan: &Plan, island: &[Member], rows: usize) {
        self.coefficients.clear();
        self.coefficients.resize(rows, [0.0; MAX_SIZE]);
        self.change.clear();
        self.change.resize(rows, 0.0);
        self.states.clear();
        self.states.resize(rows, State::Free);
        self.w.clear();
        self.w.resize(rows, 0.0);
        self.push.resize(plan.bodies.len(), (Vec3::ZERO, Vec3::ZERO));
        for member in island {
            let m = &plan.manifolds[member.manifold as usize];
            let (first, base, total) = (member.first as usize, m.first as usize, m.layout.total() as usize);
            for k in 0..total {
                let row = &plan.rows[base + k];
                self.w[first + k] = row.velocity(&plan.bodies) + row.bias;
            }
            self.work += (cost::VELOCITY + 2) * total as u64;
            let mu = m.surface.friction;
            let normal = m.layout.first_normal() as usize;
            for i in 0..m.layout.normals as usize {
                // Parted, and nothing pulls it back: the residual of such a point is zero.
                if plan.rows[base + normal + i].lambda == 0.0 && self.w[first + normal + i] > 0.0 {
                    self.states[first + normal + i] = State::Held;
                }
            }
            for i in 0..if m.layout.tangents > 0 { m.layout.normals as usize } else { 0 } {
                let (x, y) = (plan.rows[base + 2 * i].lambda, plan.rows[base + 2 * i + 1].lambda);
                let reach = mu * plan.rows[base + normal + i].lambda;
                if reach > 0.0 && x * x + y * y > 0.96 * reach * reach {
                    self.states[first + 2 * i] = State::Held;
                    self.states[first + 2 * i + 1] = State::Held;
                }
            }
        }
    }

    /// T from what the modes push each body with.
    fn assemble(&mut self, plan: &Plan, island: &[Member], fine: bool) {
        self.entries.clear();
        for member in island {
            let m = &plan.manifolds[member.manifold as usize];
            let row = &plan.rows[m.first as usize];
            for (body, sign) in [(row.body_a, 1.0), (row.body_b, -1.0)] {
                if plan.bodies[body as usize].inverse_mass == Vec3::ZERO {
                    continue;
                }
                let mut entry = Entry {
                    body,
                    group: member.group,
                    order: self.entries.len() as u32,
                    linear: [Vec3::ZERO; 6],
                    angular: [Vec3::ZERO; 6],
                };
                for k in 0..m.layout.total() as usize {
                    let j = &plan.rows[m.first as usize + k].jacobian;
                    let angular = if sign > 0.0 { j.angular_a } else { j.angular_b };
                    for (mode, &c) in self.coefficients[member.first as usize + k].iter().enumerate() {
                        if c != 0.0 {
                            self.work += 6;
                            entry.linear[mode] += c * sign * j.linear;
                            entry.angular[mode] += c * angular;
                        }
                    }
                }
                self.entries.push(entry);
            }
        }
        self.entries.sort_unstable_by_key(|e| (e.body, e.group, e.order));
        self.entries.dedup_by(|next, kept| {
            let same = (next.body, next.group) == (kept.body, kept.group);
            if same {
                for mode in 0..MAX_SIZE {
                    kept.linear[mode] += next.linear[mode];
                    kept.angular[mode] += next.angular[mode];
                }
            }
            same
        });
        self.ldl.clear(&self.pattern);
        for same in self.entries.chunk_by(|a, b| a.body == b.body) {
            let body = &plan.bodies[same[0].body as usize];
            let modes = if fine { MAX_SIZE } else { LEVEL_MODES } as u64;
            for (i, one) in same.iter().enumerate() {
                self.work += 12 * modes + 6 * modes * modes * (i as u64 + 1);
                let moved: [(Vec3, Vec3); MAX_SIZE] =
                    std::array::from_fn(|k| (body.inverse_mass * one.linear[k], body.inverse_inertia * one.angular[k]));
                for other in &same[..=i] {
                    let block =
                        moved.map(|(v, w)| std::array::from_fn(|k| v.dot(other.linear[k]) + w.dot(other.angular[k])));
                    self.ldl.add(&self.pattern, one.group, other.group, &block);
                }
            }
        }
    }

    /// −Pᵀ(w + A d) with the changes that are held.
    fn right_side(&mut self, plan: &Plan, island: &[Member]) {
        for (change, state) in self.change.iter_mut().zip(&self.states) {
            if *state == State::Free {
                *change = 0.0;
            }
        }
        let held = self.change.iter().any(|&d| d != 0.0);
        if held {
            self.push_bodies(plan, island);
        }
        self.solution.clear();
        self.solution.resize(self.pattern.nodes(), [0.0; MAX_SIZE]);
        for member in island {
            let m = &plan.manifolds[member.manifold as usize];
            for k in 0..m.layout.total() as usize {
                let at = member.first as usize + k;
                let row = &plan.rows[m.first as usize + k];
                let moved = if held { self.moved(plan, row) } else { 0.0 };
                self.work += 3 + if held { cost::VELOCITY } else { 0 };
                let w = self.w[at] + moved;
                for (sum, c) in self.solution[member.group as usize].iter_mut().zip(&self.coefficients[at]) {
                    *sum -= c * w;
                }
            }
        }
    }

    /// d = Π(λ + Ps) − λ; holds what leaves its bounds and says whether anything did.
    fn project(&mut self, plan: &Plan, island: &[Member]) -> bool {
        let mut violated = false;
        for member in island {
            let m = &plan.manifolds[member.manifold as usize];
            let (first, base) = (member.first as usize, m.first as usize);
            let normal = m.layout.first_normal() as usize;
            let s = &self.solution[member.group as usize];
            for i in 0..m.layout.normals as usize {
                let at = first + normal + i;
                let own = plan.rows[base + normal + i].lambda;
                let wanted = |at: usize, own: f32, state: State, change: f32| {
                    if state == State::Held { own + change } else { own + dot(&self.coefficients[at], s) }
                };
                let mut lambda = wanted(at, own, self.states[at], self.change[at]);
                if lambda < 0.0 {
                    lambda = 0.0;
                    self.states[at] = State::Held;
                    violated = true;
                }
                let tangents = (m.layout.tangents > 0).then(|| {
                    [0, 1].map(|k| {
                        let (t, row) = (first + 2 * i + k, &plan.rows[base + 2 * i + k]);
                        (t, row.lambda, wanted(t, row.lambda, self.states[t], self.change[t]), row.coupling)
                    })
                });
                self.change[at] = lambda - own;
                if let Some([one, two]) = tangents {
                    let reach = m.surface.friction * lambda;
                    let (x, y, slips) = clamp(one.2, two.2, one.3, reach);
                    if slips && self.states[one.0] == State::Free {
                        self.states[one.0] = State::Held;
                        self.states[two.0] = State::Held;
                        violated = true;
                    }
                    self.change[one.0] = x - one.1;
                    self.change[two.0] = y - two.1;
                }
            }
        }
        violated
    }

    /// wᵀd and dᵀAd.
    fn search(&mut self, plan: &Plan, island: &[Member]) -> (f32, f32) {
        self.push_bodies(plan, island);
        let slope = self.w.iter().zip(&self.change).map(|(w, d)| f64::from(w * d)).sum::<f64>() as f32;
        let curvature: f64 = self
            .touched
            .iter()
            .map(|&b| {
                let (body, (force, torque)) = (&plan.bodies[b as usize], self.push[b as usize]);
                f64::from(force.dot(body.inverse_mass * force) + torque.dot(body.inverse_inertia * torque))
            })
            .sum();
        (slope, curvature as f32)
    }

    fn apply(&mut self, plan: &mut Plan, island: &[Member], alpha: f32) {
        std::mem::swap(&mut self.change, &mut self.best);
        self.push_bodies(plan, island);
        for member in island {
            let m = &plan.manifolds[member.manifold as usize];
            for k in 0..m.layout.total() as usize {
                plan.rows[m.first as usize + k].lambda += alpha * self.change[member.first as usize + k];
            }
        }
        for &b in &self.touched {
            let (force, torque) = self.push[b as usize];
            let body: &mut SolverBody = &mut plan.bodies[b as usize];
            body.velocity += alpha * (body.inverse_mass * force);
            body.angular_velocity += alpha * (body.inverse_inertia * torque);
        }
    }

    /// Jᵀd by body.
    fn push_bodies(&mut self, plan: &Plan, island: &[Member]) {
        self.touched.clear();
        for member in island {
            for body in bodies_of(plan, member) {
                self.push[body as usize] = (Vec3::ZERO, Vec3::ZERO);
                self.touched.push(body);
            }
        }
        self.touched.sort_unstable();
        self.touched.dedup();
        for member in island {
            let m = &plan.manifolds[member.manifold as usize];
            for k in 0..m.layout.total() as usize {
                let d = self.change[member.first as usize + k];
                if d == 0.0 {
                    continue;
                }
                self.work += cost::APPLY;
                let row = &plan.rows[m.first as usize + k];
                let a = &mut self.push[row.body_a as usize];
                a.0 += d * row.jacobian.linear;
                a.1 += d * row.jacobian.angular_a;
                let b = &mut self.push[row.body_b as usize];
                b.0 -= d * row.jacobian.linear;
                b.1 += d * row.jacobian.angular_b;
            }
        }
    }

    /// J M⁻¹Jᵀd of a row.
    fn moved(&self, plan: &Plan, row: &crate::solver::table::Row) -> f32 {
        let part = |b: u32, angular: Vec3, sign: f32| {
            let (body, (force, torque)) = (&plan.bodies[b as usize], self.push[b as usize]);
            sign * row.jacobian.linear.dot(body.inverse_mass * force) + angular.dot(body.inverse_inertia * torque)
        };
        let a = if plan.bodies[row.body_a as usize].inverse_mass == Vec3::ZERO {
            0.0
        } else {
            part(row.body_a, row.jacobian.angular_a, 1.0)
        };
        let b = if plan.bodies[row.body_b as usize].inverse_mass == Vec3::ZERO {
            0.0
        } else {
            part(row.body_b, row.jacobian.angular_b, -1.0)
        };
        a + b
    }
}

fn dot(a: &Modes, b: &Modes) -> f32 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// The nearest bearable tangent impulse, and whether it is another one.
fn clamp(x: f32, y: f32, coupling: Coupling, reach: f32) -> (f32, f32, bool) {
    if let Coupling::Interval(_) = coupling {
        let (cx, cy) = (x.max(-reach).min(reach), y.max(-reach).min(reach));
        return (cx, cy, cx != x || cy != y);
    }
    let length = (x * x + y * y).sqrt();
    if length > reach { (x * reach / length, y * reach / length, true) } else { (x, y, false) }
}

/// Dynamic bodies of a manifold, by index in the plan.
fn bodies_of<'a>(plan: &'a Plan, member: &Member) -> impl Iterator<Item = u32> + 'a {
    let row = &plan.rows[plan.manifolds[member.manifold as usize].first as usize];
    [row.body_a, row.body_b].into_iter().filter(|&b| plan.bodies[b as usize].inverse_mass != Vec3::ZERO)
}
