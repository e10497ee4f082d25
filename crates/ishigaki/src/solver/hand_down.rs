//! Hand-down: what each body is to be rid of goes to its supports, from the top of a stack to the ground. Beyond the
//! talk; it uses its heights (D5).
//!
//! At rest a body passes on all that acts on it: its own momentum error p = M u and what the bodies above handed to
//! it. Over the points it stands on, the least impulses that make up a wrench are f = Gᵀ(GGᵀ)⁻¹p, G the map from point
//! forces to a wrench (six numbers, so six unknowns for a body, however many points). Points that would pull are let
//! go, friction ends at its cone. One pass over the bodies by height solves a whole stack, however wide: linear where
//! `level_correction.rs` factors a sparse matrix. What it finds is a direction d from the impulses as they are, taken
//! as far as it lowers the energy of the residual, α = clamp(−wᵀd / dᵀAd, 0, 1): it can only help. Loops, and contacts
//! between bodies of one height, are left to sweeps.
//! Source of the least-norm distribution: Moore–Penrose inverse of a full-rank G; of the step length: exact line search
//! on the quadratic whose minimum is the box LCP.
//! Option: `solver.hand_down`; proved by `tests/hand_down.rs`.

use crate::body::NO_HEIGHT;
use crate::collision::manifold::{MAX_POINTS, Manifold};
use crate::math::{Mat3, Vec3, skew, tangents};
use crate::solver::plan::Plan;
use crate::solver::table::{Row, SolverBody};
use crate::world::World;

/// Added to GGᵀ in parts of its diagonal: what supports cannot bear is left, not divided by nothing.
const EPSILON: f32 = 1e-4;
/// Tries with fewer points.
const TRIES: usize = 3;

/// What takes a smaller part of the unrest is not tried again for `PAUSE` steps: sweeps take more for the same work.
const WORTH: f32 = 0.08;
pub(crate) const PAUSE: u64 = 4;
/// Nor is what takes a greater part and comes from such a pause: so heaps do, and what it left them is of loops.
const MOST: f32 = 0.2;

/// Force impulse, N·s, and torque impulse about the center of mass, N·m·s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wrench {
    /// N·s.
    pub linear: Vec3,
    /// N·m·s.
    pub angular: Vec3,
}

impl Wrench {
    fn add(&mut self, impulse: Vec3, arm: Vec3) {
        self.linear += impulse;
        self.angular += arm.cross(impulse);
    }
}

/// A point that may bear.
#[derive(Clone, Copy, Debug, Default)]
pub struct Point {
    /// From the center of the upper body, m.
    pub arm_upper: Vec3,
    /// From the center of the lower, m.
    pub arm_lower: Vec3,
    /// Impulse on the upper body along normal and tangents, N·s.
    pub lambda: Vec3,
    /// It bears, or is about to.
    pub is_active: bool,
    /// d: what hand-down adds to `lambda`, N·s.
    pub change: Vec3,
}

/// A manifold between a body and one that stands lower.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stand {
    /// Index of the body that stands on it.
    pub upper: u32,
    /// Index of the body that bears; 0 for the ground.
    pub lower: u32,
    /// Twice what the caller knows it by, and which side of the manifold the upper body is, 0 or 1.
    name_and_side: u32,
}

impl Stand {
    /// What the caller knows it by.
    pub fn name(&self) -> usize {
        self.name_and_side as usize / 2
    }

    /// Which side of the manifold the upper body is, 0 or 1.
    pub fn side(&self) -> usize {
        self.name_and_side as usize % 2
    }
}

/// What a body stands on, as the solver has it at the moment.
#[derive(Clone, Copy, Debug)]
pub struct Support {
    /// Columns: normal toward the upper body, two tangents.
    pub axes: Mat3,
    /// Coulomb's μ.
    pub friction: f32,
    /// How many points.
    pub count: usize,
    /// The first `count` are of it.
    pub points: [Point; MAX_POINTS],
}

impl Support {
    /// A manifold whose upper body is on this side, with no impulses yet and all points active.
    pub(crate) fn new(manifold: &Manifold, side: usize, friction: f32) -> Self {
        // Impulses are those on A.
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let (t1, t2) = tangents(manifold.normal);
        let mut points = [Point::default(); MAX_POINTS];
        for (to, from) in points.iter_mut().zip(&manifold.points) {
            let arms = [from.arm_a, from.arm_b];
            (to.arm_upper, to.arm_lower, to.is_active) = (arms[side], arms[1 - side], true);
        }
        let axes = Mat3::from_cols(sign * manifold.normal, sign * t1, sign * t2);
        Self { axes, friction, count: manifold.points.len(), points }
    }
}

/// Arrays that are used again.
#[derive(Clone, Debug, Default)]
pub struct HandDown {
    /// All manifolds between bodies of different heights.
    pub stands: Vec<Stand>,
    /// By stand: what hand-down adds to normal and tangents of each point, N·s.
    pub changes: Vec<[Vec3; MAX_POINTS]>,
    /// By body: what it is to be rid of, −p.
    pub needs: Vec<Wrench>,
    /// By body: what all changes together push it with.
    pub pushes: Vec<Wrench>,
    /// Bodies that stand on others: height, rank, body.
    uppers: Vec<(std::cmp::Reverse<u32>, u32, u32)>,
    /// By body: how many others it stands on; then where they end in `order`.
    places: Vec<u32>,
    /// Stands, upper body by upper body.
    order: Vec<u32>,
    standing: Vec<Support>,
}

impl HandDown {
    /// Forgets all; makes room for `bodies` bodies, the ground among them.
    pub fn clear(&mut self, bodies: usize) {
        self.stands.clear();
        for wrenches in [&mut self.needs, &mut self.pushes] {
            wrenches.clear();
            wrenches.resize(bodies, Wrench::default());
        }
        self.uppers.clear();
        self.places.clear();
        self.places.resize(bodies, 0);
    }

    /// Adds a manifold, unless neither body stands on the other. Bodies of one height are sorted by their ranks.
    pub(crate) fn add(&mut self, name: u32, bodies: [u32; 2], heights: [u32; 2], ranks: [u32; 2]) {
        if heights[0] == heights[1] || heights.contains(&NO_HEIGHT) {
            return;
        }
        let side = usize::from(heights[1] > heights[0]);
        let (upper, lower) = (bodies[side], bodies[1 - side]);
        let count = &mut self.places[upper as usize];
        if *count == 0 {
            self.uppers.push((std::cmp::Reverse(heights[side]), ranks[side], upper));
        }
        *count += 1;
        self.stands.push(Stand { upper, lower, name_and_side: 2 * name + side as u32 });
    }

    /// Fills in `changes` and `pushes`; multiply-adds of that. `support` looks a stand up.
    pub fn solve(&mut self, support: &dyn Fn(&Stand) -> Support) -> u64 {
        self.sort();
        self.changes.resize(self.stands.len(), [Vec3::ZERO; MAX_POINTS]);
        let (mut work, mut first) = (0, 0);
        for &(_, _, upper) in &self.uppers {
            let upper = upper as usize;
            let end = self.places[upper] as usize;
            let names = &self.order[first..end];
            first = end;
            self.standing.clear();
            self.standing.extend(names.iter().map(|&name| support(&self.stands[name as usize])));
            work += distribute(&mut self.standing, self.needs[upper]);
            for (&name, support) in names.iter().zip(&self.standing) {
                let stand = self.stands[name as usize];
                let lower = stand.lower as usize;
                for point in &support.points[..support.count] {
                    let impulse = support.axes * point.change;
                    self.pushes[upper].add(impulse, point.arm_upper);
                    self.pushes[lower].add(-impulse, point.arm_lower);
                    // The reaction is one more thing that the lower body is to be rid of.
                    self.needs[lower].add(impulse, point.arm_lower);
                }
                self.changes[name as usize] = support.points.map(|point| point.change);
            }
        }
        work
    }

    /// By height of the upper body from the top down, by body, by name: bodies are sorted, stands counted.
    fn sort(&mut self) {
        self.uppers.sort_unstable();
        let mut first = 0;
        for &(_, _, upper) in &self.uppers {
            let place = &mut self.places[upper as usize];
            (*place, first) = (first, first + *place);
        }
        self.order.resize(self.stands.len(), 0);
        for (stand, name) in self.stands.iter().zip(0..) {
            let place = &mut self.places[stand.upper as usize];
            self.order[*place as usize] = name;
            *place += 1;
        }
    }
}

/// Where a direction leads: the energy ½uᵀMu + biasᵀλ along it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Search {
    /// wᵀd, J.
    pub slope: f64,
    /// dᵀAd, J.
    pub curvature: f64,
}

impl Search {
    /// α and the energy it takes away, J.
    pub fn step(&self) -> (f32, f32) {
        if self.curvature <= 0.0 {
            return (0.0, 0.0);
        }
        let alpha = (-self.slope / self.curvature).clamp(0.0, 1.0);
        (alpha as f32, (-alpha * self.slope - 0.5 * alpha * alpha * self.curvature) as f32)
    }
}

impl World {
    /// Whether to hand down in the next substep too: what was gained of the unrest there was, both J. Pauses of an island
    /// are those of its first body.
    pub(crate) fn is_worth_handing_down(&self, first_body: u32, gain: f32, unrest: f32) -> bool {
        let is_back = self.step_count > 0 && self.bodies.at(first_body).no_correction_until == self.step_count;
        gain > WORTH * unrest && !(is_back && gain > MOST * unrest)
    }

    /// Hands down the momentum of bodies that these manifolds of the reference connect; the energy of the residual
    /// that it took away, J, and the multiply-adds.
    pub(crate) fn hand_down_rows(&self, plan: &mut Plan, manifolds: impl Iterator<Item = u32>) -> (f32, u64) {
        let mut work = std::mem::take(&mut plan.hand_down);
        work.clear(plan.bodies.len());
        for name in manifolds {
            let m = &plan.manifolds[name as usize];
            let row = &plan.rows[m.first as usize];
            let bodies = [row.body_a, row.body_b];
            let heights = bodies.map(|b| plan.bodies[b as usize].height);
            work.add(name, bodies, heights, bodies);
        }
        for (need, body) in work.needs.iter_mut().zip(&plan.bodies) {
            *need = Wrench { linear: -momentum(body), angular: -(body.inertia * body.angular_velocity) };
        }
        let multiply_adds = work.solve(&|stand| self.support_of_rows(plan, stand));
        let mut search = Search::default();
        for (push, body) in work.pushes.iter().zip(&plan.bodies) {
            let (v, w) = moved(push, body);
            search.slope += f64::from(push.linear.dot(body.velocity) + push.angular.dot(body.angular_velocity));
            search.curvature += f64::from(push.linear.dot(v) + push.angular.dot(w));
        }
        for (stand, changes) in work.stands.iter().zip(&work.changes) {
            for (change, row) in changes.iter().zip(normals_of(plan, stand)) {
                search.slope += f64::from(row.bias * change.x);
            }
        }
        let (alpha, gain) = search.step();
        if gain > 0.0 {
            take(plan, &work, alpha);
        }
        plan.hand_down = work;
        (gain, multiply_adds)
    }

    fn support_of_rows(&self, plan: &Plan, stand: &Stand) -> Support {
        let m = &plan.manifolds[stand.name()];
        let manifold = &self.contacts[m.contact as usize].manifolds[m.manifold as usize];
        let rows = &plan.rows[m.first as usize..(m.first + m.layout.total()) as usize];
        let mut support = Support::new(manifold, stand.side(), m.surface.friction);
        for (i, (point, row)) in support.points.iter_mut().zip(normals_of(plan, stand)).enumerate() {
            point.lambda.x = row.lambda;
            point.is_active = row.lambda > 0.0 || row.velocity(&plan.bodies) + row.bias <= 0.0;
            if m.layout.tangents > 0 {
                (point.lambda.y, point.lambda.z) = (rows[2 * i].lambda, rows[2 * i + 1].lambda);
            }
        }
        support
    }
}

/// Rows of the points of a stand.
fn normals_of<'a>(plan: &'a Plan, stand: &Stand) -> &'a [Row] {
    let m = &plan.manifolds[stand.name()];
    let first = (m.first + m.layout.first_normal()) as usize;
    &plan.rows[first..first + m.layout.normals as usize]
}

/// m v, N·s; none along locked axes, and none of what forces do not move.
fn momentum(body: &SolverBody) -> Vec3 {
    let along = |inverse_mass: f32, velocity: f32| if inverse_mass > 0.0 { velocity / inverse_mass } else { 0.0 };
    let (m, v) = (body.inverse_mass, body.velocity);
    Vec3::new(along(m.x, v.x), along(m.y, v.y), along(m.z, v.z))
}

fn moved(push: &Wrench, body: &SolverBody) -> (Vec3, Vec3) {
    (body.inverse_mass * push.linear, body.inverse_inertia * push.angular)
}

/// λ += αd, u += αM⁻¹Jᵀd.
fn take(plan: &mut Plan, work: &HandDown, alpha: f32) {
    for (stand, changes) in work.stands.iter().zip(&work.changes) {
        let m = &plan.manifolds[stand.name()];
        let rows = &mut plan.rows[m.first as usize..(m.first + m.layout.total()) as usize];
        for (i, change) in changes[..m.layout.normals as usize].iter().enumerate() {
            rows[m.layout.first_normal() as usize + i].lambda += alpha * change.x;
            if m.layout.tangents > 0 {
                rows[2 * i].lambda += alpha * change.y;
                rows[2 * i + 1].lambda += alpha * change.z;
            }
        }
    }
    for (push, body) in work.pushes.iter().zip(&mut plan.bodies) {
        let (v, w) = moved(push, body);
        body.velocity += alpha * v;
        body.angular_velocity += alpha * w;
    }
}

/// Changes of the points under one body that make up `need`, as far as they can.
fn distribute(standing: &mut [Support], need: Wrench) -> u64 {
    let mut work = 0;
    for support in standing.iter_mut() {
        for point in &mut support.points {
            point.change = Vec3::ZERO;
        }
    }
    for _ in 0..TRIES {
        let size = arms(standing).map(|a| a.length()).fold(0.0, f32::max).max(1e-9);
        let mut rest = need;
        let mut gram = Gram::default();
        for support in standing.iter() {
            for point in &support.points[..support.count] {
                if point.is_active {
                    gram.add(point.arm_upper / size);
                } else {
                    rest.add(support.axes * -point.change, point.arm_upper);
                }
            }
        }
        let Some((force, torque)) = gram.solve(rest.linear, rest.angular / size) else { break };
        work += u64::from(gram.points) * 40 + 90;
        if !release_pulled(standing, |arm| force + torque.cross(arm / size)) {
            break;
        }
    }
    for support in standing.iter_mut() {
        for point in &mut support.points[..support.count] {
            hold_at_cone(point, support.friction);
        }
    }
    work
}

fn arms(standing: &[Support]) -> impl Iterator<Item = Vec3> + '_ {
    let points = standing.iter().flat_map(|s| &s.points[..s.count]);
    points.filter(|p| p.is_active).map(|p| p.arm_upper)
}

/// Sets the changes of active points; those that would pull are let go. Whether there were any.
fn release_pulled(standing: &mut [Support], impulse_at: impl Fn(Vec3) -> Vec3) -> bool {
    let mut any = false;
    for support in standing {
        let to_axes = support.axes.transpose();
        for point in support.points[..support.count].iter_mut().filter(|p| p.is_active) {
            point.change = to_axes * impulse_at(point.arm_upper);
            if point.lambda.x + point.change.x < 0.0 {
                point.change = -point.lambda;
                point.is_active = false;
                any = true;
            }
        }
    }
    any
}

/// |λ_t| ≤ μ λ_n after the change.
fn hold_at_cone(point: &mut Point, friction: f32) {
    let lambda = point.lambda + point.change;
    let reach = friction * lambda.x.max(0.0);
    let length = (lambda.y * lambda.y + lambda.z * lambda.z).sqrt();
    if length > reach {
        let shrink = reach / length;
        point.change.y = shrink * lambda.y - point.lambda.y;
        point.change.z = shrink * lambda.z - point.lambda.z;
    }
}

/// GGᵀ of points on unit arms: [n·1, −Σ[a]ₓ; Σ[a]ₓ, −Σ[a]ₓ²].
#[derive(Clone, Copy, Debug, Default)]
struct Gram {
    points: u32,
    arm: Vec3,
    inertia: Mat3,
}

impl Gram {
    fn add(&mut self, arm: Vec3) {
        self.points += 1;
        self.arm += arm;
        let cross = skew(arm);
        self.inertia += cross.transpose() * cross;
    }

    /// y with (GGᵀ + ε) y = (linear, angular), by the Schur complement of the linear part; `None` without points.
    fn solve(&self, linear: Vec3, angular: Vec3) -> Option<(Vec3, Vec3)> {
        if self.points == 0 {
            return None;
        }
        let n = self.points as f32;
        let mean = self.arm / n;
        let cross = skew(mean);
        let about_mean = self.inertia - n * (cross.transpose() * cross);
        let softness = EPSILON * n;
        let inverse = (about_mean + Mat3::from_diagonal(Vec3::splat(softness))).inverse();
        let torque = inverse * (angular - mean.cross(linear));
        if !torque.is_finite() {
            return None;
        }
        Some((linear / n - torque.cross(mean), torque))
    }
}
