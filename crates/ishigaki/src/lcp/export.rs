//! One step of a world as a box LCP. TALK B11, B12.
//!
//! A = J M⁻¹Jᵀ with the masses that each row sees, softness added; b = J (u + h M⁻¹F) + bias at the first substep, after
//! impacts: exactly what the sweeps of that substep work on, taken from the engine's own table and widened to f64. With
//! weight amplification or shock propagation M⁻¹ differs from row to row and A is not symmetric; with blended shock
//! propagation it is the first of the two problems, with the masses as they are. Test: `tests/lcp/export.rs`.

use crate::error::{Error, Result};
use crate::handle::BodyHandle;
use crate::lcp::box_lcp::{BoxLcp, Friction};
use crate::lcp::matrix::Matrix;
use crate::math::{Mat3, Vec3};
use crate::solver::plan::{self, Plan};
use crate::solver::table::{Row, SolverBody};
use crate::world::World;
use glam::{DMat3, DVec3};

/// A dense matrix of more rows is a gigabyte.
const MOST_ROWS: usize = 10_000;

/// What a row of an exported problem is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowKind {
    /// Keeps two surfaces apart; λ in N·s.
    Normal,
    /// Friction along a tangent; λ in N·s.
    Tangent,
    /// Friction against spinning about the normal; λ in N·m·s.
    Torsion,
    /// Friction against rolling; λ in N·m·s.
    Rolling,
    /// A row of a joint, a range or a motor; λ in N·s or N·m·s.
    Joint,
}

impl RowKind {
    /// As files call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Normal => "normal",
            Self::Tangent => "tangent",
            Self::Torsion => "torsion",
            Self::Rolling => "rolling",
            Self::Joint => "joint",
        }
    }
}

/// Where a row of an exported problem comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RowLabel {
    /// What it is for.
    pub kind: RowKind,
    /// A and B: w is the velocity of A relative to B.
    pub bodies: [BodyHandle; 2],
    /// Rows of one manifold, or of one joint, have the same number.
    pub group: usize,
}

/// The problem of a step, and what its rows mean.
#[derive(Clone, Debug)]
pub struct ExportedLcp {
    /// The problem; its groups are those of the labels. Rows stand in the engine's order.
    pub problem: BoxLcp,
    /// One for each row.
    pub labels: Vec<RowLabel>,
    /// The engine's warm start.
    pub start: Vec<f64>,
}

impl World {
    /// The box LCP that the first substep of `step(dt)` would solve. The world stays as it is: a copy takes the step's
    /// stages up to its first sweep. Islands that sleep have no rows.
    ///
    /// # Errors
    /// A `dt` that [`step`](World::step) would refuse; more than 10,000 rows; numbers that ran out of f32, with the row
    /// named.
    pub fn export_lcp(&self, dt: f32) -> Result<ExportedLcp> {
        let mut world = self.clone();
        let plan = world.plan_first_substep(dt)?;
        let rows = plan.rows.len();
        if rows > MOST_ROWS {
            let message = format!("the step has {rows}; a dense matrix is made of {MOST_ROWS} at most");
            return Err(Error::invalid("rows", message));
        }
        let (labels, friction) = (labels(&world, &plan), friction(&plan));
        let (lower, upper) = plan.rows.iter().map(|r| (f64::from(r.lower), f64::from(r.upper))).unzip();
        let problem = BoxLcp::new(matrix(&plan), offsets(&plan), lower, upper)?
            .with_friction(friction)?
            .with_groups(labels.iter().map(|label| label.group).collect())?;
        let start = plan.rows.iter().map(|row| f64::from(row.lambda)).collect();
        Ok(ExportedLcp { problem, labels, start })
    }

    /// The stages of a step up to the first sweep.
    pub(crate) fn plan_first_substep(&mut self, dt: f32) -> Result<Plan> {
        if !self.begin(dt) {
            let why = self.report.rejected.take().unwrap_or_default();
            return Err(Error::invalid("dt", why));
        }
        let mut plan = Plan::default();
        // All rows in one table.
        self.options.solver.wide.enabled = false;
        self.find_pairs(dt);
        self.update_contacts(dt, None);
        self.build_islands();
        self.gather_forces(dt);
        self.build_rows(&mut plan, dt);
        plan::plan_sweep(&mut plan, &self.options.solver);
        let h = dt / plan.substeps as f32;
        self.prepare_substep(&mut plan, h, 0);
        Ok(plan)
    }
}

fn labels(world: &World, plan: &Plan) -> Vec<RowLabel> {
    let handle = |slot: u32| BodyHandle { index: slot, generation: world.bodies.generation_at(slot) };
    let mut labels = Vec::with_capacity(plan.rows.len());
    let mut group = 0;
    for joint in &plan.joints {
        let definition = &world.joints.at(joint.joint).definition;
        let label = RowLabel { kind: RowKind::Joint, bodies: [definition.body_a, definition.body_b], group };
        labels.extend((0..joint.count).map(|_| label));
        group += 1;
    }
    for manifold in &plan.manifolds {
        let contact = &world.contacts[manifold.contact as usize];
        let bodies = [handle(contact.body_a), handle(contact.body_b)];
        let layout = &manifold.layout;
        let kinds = [
            (RowKind::Tangent, layout.tangents),
            (RowKind::Torsion, layout.torsion),
            (RowKind::Rolling, layout.rolling),
            (RowKind::Normal, layout.normals),
        ];
        for (kind, count) in kinds {
            labels.extend((0..count).map(|_| RowLabel { kind, bodies, group }));
        }
        group += 1;
    }
    labels
}

fn friction(plan: &Plan) -> Vec<Option<Friction>> {
    use crate::constraint::friction::{Bound, Coupling};
    let of = |bound: &Bound, partner| Friction {
        normals: (bound.first as usize..(bound.first + bound.count) as usize).collect(),
        coefficient: f64::from(bound.coefficient),
        partner,
    };
    let mut friction: Vec<Option<Friction>> = vec![None; plan.rows.len()];
    for (i, row) in plan.rows.iter().enumerate() {
        match &row.coupling {
            Coupling::Interval(bound) => friction[i] = Some(of(bound, None)),
            Coupling::Disk(bound) => {
                friction[i] = Some(of(bound, Some(i + 1)));
                friction[i + 1] = Some(of(bound, Some(i)));
            }
            _ => {}
        }
    }
    friction
}

/// J M⁻¹Jᵀ and softness.
fn matrix(plan: &Plan) -> Matrix {
    let responses: Vec<[WideSide; 2]> = plan.rows.iter().map(|row| response(row, &plan.bodies)).collect();
    let n = plan.rows.len();
    let mut a = Matrix::from_fn(n, n, |i, j| {
        let (row, other) = (&plan.rows[i], &plan.rows[j]);
        let mut sum = 0.0;
        for (body, jacobian) in [row.body_a, row.body_b].into_iter().zip(sides(row)) {
            for (of, response) in [other.body_a, other.body_b].into_iter().zip(&responses[j]) {
                if body == of && body != 0 {
                    sum += jacobian.linear.dot(response.linear) + jacobian.angular.dot(response.angular);
                }
            }
        }
        sum
    });
    for (i, row) in plan.rows.iter().enumerate() {
        a[(i, i)] += f64::from(row.softness);
    }
    a
}

/// J u + bias.
fn offsets(plan: &Plan) -> Vec<f64> {
    let offset = |row: &Row| {
        let mut sum = f64::from(row.bias);
        for (body, jacobian) in [row.body_a, row.body_b].into_iter().zip(sides(row)) {
            let body = &plan.bodies[body as usize];
            sum += jacobian.linear.dot(wide(body.velocity)) + jacobian.angular.dot(wide(body.angular_velocity));
        }
        sum
    };
    plan.rows.iter().map(offset).collect()
}

/// The part of a row, or of its response, that belongs to one body.
struct WideSide {
    linear: DVec3,
    angular: DVec3,
}

/// J of A and of B.
fn sides(row: &Row) -> [WideSide; 2] {
    let j = &row.jacobian;
    [
        WideSide { linear: wide(j.linear), angular: wide(j.angular_a) },
        WideSide { linear: -wide(j.linear), angular: wide(j.angular_b) },
    ]
}

/// M⁻¹Jᵀ with the masses that the row sees.
fn response(row: &Row, bodies: &[SolverBody]) -> [WideSide; 2] {
    let (a, b) = (&bodies[row.body_a as usize], &bodies[row.body_b as usize]);
    let [ja, jb] = sides(row);
    let of = |body: &SolverBody, j: WideSide, mass: f32, inertia: f32| WideSide {
        linear: wide(body.inverse_mass) * j.linear * f64::from(mass),
        angular: symmetric(body.inverse_inertia) * j.angular * f64::from(inertia),
    };
    [of(a, ja, row.scale.mass_a, row.scale.inertia_a), of(b, jb, row.scale.mass_b, row.scale.inertia_b)]
}

fn wide(v: Vec3) -> DVec3 {
    DVec3::new(v.x.into(), v.y.into(), v.z.into())
}

/// f32 rounds I⁻¹ and its transpose apart: their mean.
fn symmetric(m: Mat3) -> DMat3 {
    let m = DMat3::from_cols(wide(m.x_axis), wide(m.y_axis), wide(m.z_axis));
    (m + m.transpose()) * 0.5
}
