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

mod groups;
mod modes;
mod system;

use crate::body::NO_HEIGHT;
use crate::math::Vec3;
use crate::solver::block_ldl::{BlockLdl, MAX_SIZE, Pattern};
use crate::solver::hand_down;
use crate::solver::manifold_block;
use crate::solver::plan::{ManifoldRows, Plan};
use crate::solver::reference::{self, Unit};
use crate::world::World;
use std::collections::BTreeMap;

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
    /// First bodies of islands that corrections did not help, and for how many steps these rest, until the caller takes
    /// them.
    pub(crate) pauses: Vec<(u32, u64)>,
    current: Option<(u32, Choice)>,
    links: Vec<(u32, u32)>,
    users: Vec<(u32, u32)>,
}

/// A factorization may cost as much as this many sweeps; what costs more gets coarser modes.
const SWEEPS: u64 = 4;
/// Added to the unit diagonal: f32.
const EPSILON: f32 = 1e-4;
/// Rounds of correction and sweep in a substep.
const ROUNDS: usize = 6;
/// A correction that takes less than this part of Σλ g h was the last, and below `CALM` none is made.
const ENOUGH: f32 = 1e-7;
pub(crate) const CALM: f32 = 1e-9;
/// Below this part nothing is handed down, and two sweeps keep at rest what rests.
pub(crate) const QUIET: f32 = 3e-8;
/// A correction must take this part of what sweeps for the same work would take; else it rests for `PAUSE` steps.
const WORTH: f32 = 0.2;
const HOPELESS: f32 = 0.03;
const PAUSE: u64 = 8;
/// Above this part of Σλ g h bodies hit each other; below it they rest or sag.
const TUMBLING: f32 = 1e-2;
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
                let scale = island.iter().map(|m| m.load).sum::<f32>() * self.options.gravity.length() * h;
                let is_dear = is_dear(island.len(), island[active - 1].level as usize);
                let hands_down = is_dear && self.options.solver.hand_down.enabled;
                let pause = if hands_down { hand_down::PAUSE } else { PAUSE };
                let worth_it = if hands_down {
                    self.hand_down_island(plan, &mut work, island, active, scale)
                } else {
                    let worth_it = self.correct_island(plan, &mut work, island, active, scale);
                    work.remember();
                    worth_it
                };
                if !worth_it {
                    work.pauses.push((first, pause));
                }
            }
        }
        work.members = members;
        plan.level_correction = work;
    }

    /// Hand-down in place of a correction; whether it was worth its work. `scale`: Σλ g h of the island, J.
    fn hand_down_island(
        &self,
        plan: &mut Plan,
        work: &mut LevelCorrection,
        all: &mut [Member],
        active: usize,
        scale: f32,
    ) -> bool {
        let island = &mut all[..active];
        let rows = number_rows(plan, island);
        work.start(plan, island, rows);
        let unrest = work.unrest(plan, island);
        if unrest <= CALM * scale {
            mark_calm(plan, all);
            return true;
        }
        if unrest <= QUIET * scale {
            return true;
        }
        let (gain, multiply_adds) = self.hand_down_rows(plan, all.iter().map(|m| m.manifold));
        work.work += multiply_adds;
        let first = all.iter().map(|m| m.body).min().unwrap_or(0);
        self.is_worth_handing_down(first, gain, unrest)
    }

    /// Correction and a sweep over the island's contacts in turn, while the correction still finds something; whether
    /// it was worth its work.
    fn correct_island(
        &self,
        plan: &mut Plan,
        work: &mut LevelCorrection,
        all: &mut [Member],
        active: usize,
        scale: f32,
    ) -> bool {
        let passes = manifold_block::passes(&self.options.solver.manifold_block).unwrap_or(1);
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
                mark_calm(plan, all);
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
}

/// One sweep with recovery is enough for these.
fn mark_calm(plan: &mut Plan, members: &[Member]) {
    for member in members {
        plan.calm[member.manifold as usize] = true;
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

/// Gives each member its place in the arrays by row; how many rows there are.
fn number_rows(plan: &Plan, island: &mut [Member]) -> usize {
    let mut rows = 0;
    for member in island.iter_mut() {
        member.first = rows;
        rows += plan.manifolds[member.manifold as usize].layout.total();
    }
    rows as usize
}

/// Dynamic bodies of a manifold, by index in the plan.
fn bodies_of<'a>(plan: &'a Plan, member: &Member) -> impl Iterator<Item = u32> + 'a {
    let row = &plan.rows[plan.manifolds[member.manifold as usize].first as usize];
    [row.body_a, row.body_b].into_iter().filter(|&b| plan.bodies[b as usize].inverse_mass != Vec3::ZERO)
}
