//! Modes: in what proportions the impulses of a manifold, or of a level, change together.

use crate::math::Vec3;
use crate::solver::block_ldl::MAX_SIZE;
use crate::solver::level_correction::{LevelCorrection, Member, State, normals_of};
use crate::solver::plan::{ManifoldRows, Plan};
use crate::world::World;

impl World {
    pub(super) fn set_modes(&self, plan: &Plan, work: &mut LevelCorrection, island: &[Member], fine: bool) {
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

    /// Load, two shears, two tilts, twist; a single point has the first three.
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
            coefficients[normal + i] = [share, 0.0, 0.0, share * x, share * y, 0.0];
            if tangents && work.states[first + 2 * i] == State::Free {
                let (own1, own2) = (&plan.rows[m.first as usize + 2 * i], &plan.rows[m.first as usize + 2 * i + 1]);
                let grip = mu * share;
                coefficients[first + 2 * i] = [carried * own1.lambda, grip, 0.0, 0.0, 0.0, -grip * y];
                coefficients[first + 2 * i + 1] = [carried * own2.lambda, 0.0, grip, 0.0, 0.0, grip * x];
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

/// Runs of members with the same group.
fn island_groups(island: &[Member]) -> impl Iterator<Item = std::ops::Range<usize>> + '_ {
    let mut start = 0;
    island.chunk_by(|a, b| a.group == b.group).map(move |run| {
        let range = start..start + run.len();
        start = range.end;
        range
    })
}
