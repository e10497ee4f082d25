//! The system of an island's modes: assembly, right side, projection, line search, and what a solution does to bodies.

use crate::constraint::friction::Coupling;
use crate::math::Vec3;
use crate::solver::block_ldl::MAX_SIZE;
use crate::solver::level_correction::{Entry, LEVEL_MODES, LevelCorrection, Member, Modes, State, bodies_of};
use crate::solver::plan::Plan;
use crate::solver::table::{Row, SolverBody};
use crate::solver::work as cost;

impl LevelCorrection {
    /// What a visit to each row alone would take of the energy of the residual, J.
    pub(super) fn unrest(&self, plan: &Plan, island: &[Member]) -> f32 {
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

    pub(super) fn start(&mut self, plan: &Plan, island: &[Member], rows: usize) {
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
    pub(super) fn assemble(&mut self, plan: &Plan, island: &[Member], fine: bool) {
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
    pub(super) fn right_side(&mut self, plan: &Plan, island: &[Member]) {
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
    pub(super) fn project(&mut self, plan: &Plan, island: &[Member]) -> bool {
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
    pub(super) fn search(&mut self, plan: &Plan, island: &[Member]) -> (f32, f32) {
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

    pub(super) fn apply(&mut self, plan: &mut Plan, island: &[Member], alpha: f32) {
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
    fn moved(&self, plan: &Plan, row: &Row) -> f32 {
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
