//! The table of rows and the bodies they act on: what every technique edits and every sweep reads.

use crate::constraint::contact::ContactRow;
use crate::constraint::friction::Coupling;
use crate::constraint::row::{Jacobian, RowSpec};
use crate::math::{Mat3, Vec3};

/// Rows of joints turn with their bodies; inertia, and what is factored of it, only after more than this, rad.
pub const FAR_TURN: f32 = 0.1;

/// A body as the solver sees it. Index 0 is the ground: no velocity, no inverse mass.
#[derive(Clone, Copy, Debug)]
pub struct SolverBody {
    /// Of the center of mass, m/s.
    pub velocity: Vec3,
    /// rad/s, world.
    pub angular_velocity: Vec3,
    /// 1/m by world axis, 1/kg; zero along locked axes and for bodies that forces do not move.
    pub inverse_mass: Vec3,
    /// I⁻¹ in world, 1/(kg·m²).
    pub inverse_inertia: Mat3,
    /// I in world for the same pose, kg·m²: what turns a change of ω back into one of L.
    pub inertia: Mat3,
    /// What forces added to the velocity in this substep, m/s; impacts look behind it.
    pub forced_velocity: Vec3,
    /// What torques added to the angular velocity in this substep, rad/s.
    pub forced_spin: Vec3,
    /// Its inertia is another one than in the last substep.
    pub turned: bool,
    /// It has joints.
    pub jointed: bool,
    /// Its joints recover by poses: their rows and its inertia after the motion are those of the next substep too.
    pub keeps_rows: bool,
    /// It has contacts.
    pub touched: bool,
    /// Its joints are solved one by one, since it or what it is joined to touches something.
    pub in_idle_tree: bool,
    /// Its joints close loops.
    pub in_net: bool,
    /// It has more than one joint.
    pub shares_joints: bool,
    /// How far it had turned when its inertia was taken, rad.
    pub turn_of_inertia: Vec3,
    /// How far the center moved in this step, m.
    pub translation: Vec3,
    /// How far the body turned in this step, Σ h ω, rad.
    pub turn: Vec3,
    /// h Σ|λ||r| of its joints, kg·m².
    pub stiffness: f32,
    /// Hops from the ground.
    pub height: u32,
    /// A row pushes it in this substep; kept up for the trapezoidal drift only.
    pub pushed: bool,
}

impl SolverBody {
    /// The ground.
    pub const GROUND: Self = Self {
        velocity: Vec3::ZERO,
        angular_velocity: Vec3::ZERO,
        inverse_mass: Vec3::ZERO,
        inverse_inertia: Mat3::ZERO,
        inertia: Mat3::ZERO,
        forced_velocity: Vec3::ZERO,
        forced_spin: Vec3::ZERO,
        turned: false,
        jointed: false,
        keeps_rows: false,
        touched: false,
        in_idle_tree: false,
        in_net: false,
        shares_joints: false,
        turn_of_inertia: Vec3::ZERO,
        translation: Vec3::ZERO,
        turn: Vec3::ZERO,
        stiffness: 0.0,
        height: 0,
        pushed: false,
    };
}

impl SolverBody {
    /// Forces can move it.
    pub fn moves(&self) -> bool {
        self.inverse_mass != Vec3::ZERO
    }

    /// It turned so far that its inertia is to be taken anew.
    pub fn has_turned_far(&self) -> bool {
        (self.turn - self.turn_of_inertia).length_squared() > FAR_TURN * FAR_TURN
    }
}

/// M⁻¹Jᵀ of one row: what a unit impulse adds to the velocities.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Response {
    /// Of A, m/s per N·s.
    pub linear_a: Vec3,
    /// Of A, rad/s per N·s.
    pub angular_a: Vec3,
    /// Of B.
    pub linear_b: Vec3,
    /// Of B.
    pub angular_b: Vec3,
}

/// Multiples of the inverse masses that a row sees: the column that shock propagation and WA edit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassScale {
    /// Of the inverse mass of A.
    pub mass_a: f32,
    /// Of the inverse inertia of A.
    pub inertia_a: f32,
    /// Of the inverse mass of B.
    pub mass_b: f32,
    /// Of the inverse inertia of B.
    pub inertia_b: f32,
}

impl MassScale {
    /// The masses as they are.
    pub const ONE: Self = Self { mass_a: 1.0, inertia_a: 1.0, mass_b: 1.0, inertia_b: 1.0 };
}

/// A scalar constraint between two bodies: w = J u + γλ + bias, λ in [lower, upper]. TALK C3.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Index of the first body in the plan.
    pub body_a: u32,
    /// Index of the second.
    pub body_b: u32,
    /// J.
    pub jacobian: Jacobian,
    /// What techniques make of the inverse masses.
    pub scale: MassScale,
    /// M⁻¹Jᵀ, scaled.
    pub response: Response,
    /// 1/(J M⁻¹Jᵀ + γ).
    pub effective_mass: f32,
    /// γ.
    pub softness: f32,
    /// With recovery of position errors; the sweep reads this one.
    pub bias: f32,
    /// Without; copied to `bias` for relax sweeps.
    pub relax_bias: f32,
    /// What the way along arcs adds to the error in this substep, m/s.
    pub arc: f32,
    /// Least λ.
    pub lower: f32,
    /// Greatest λ.
    pub upper: f32,
    /// Whose impulses bound it.
    pub coupling: Coupling,
    /// For the first row of a disk: J₁ M⁻¹J₂ᵀ, the coupling with its partner.
    pub cross_mass: f32,
    /// For the end of a range: 1/(J M⁻¹Jᵀ) with what the equality rows of its joint leave of M⁻¹; 0 until it is asked for.
    pub limit_mass: f32,
    /// Of a joint that recovers by moving its bodies, not by their velocities.
    pub by_pose: bool,
    /// λ, N·s or N·m·s.
    pub lambda: f32,
    /// λ summed over the substeps.
    pub total_lambda: f32,
}

impl Row {
    /// An equality without a spring of its own.
    pub fn is_hard_equality(&self) -> bool {
        self.softness == 0.0 && self.lower == f32::NEG_INFINITY && self.upper == f32::INFINITY
    }

    /// An end of a range.
    pub fn is_limit(&self) -> bool {
        self.softness == 0.0 && self.lower == 0.0 && self.upper == f32::INFINITY
    }

    /// J u, m/s or rad/s.
    #[inline]
    pub fn velocity(&self, bodies: &[SolverBody]) -> f32 {
        let (a, b) = (&bodies[self.body_a as usize], &bodies[self.body_b as usize]);
        self.jacobian.linear.dot(a.velocity - b.velocity)
            + self.jacobian.angular_a.dot(a.angular_velocity)
            + self.jacobian.angular_b.dot(b.angular_velocity)
    }

    /// J hM⁻¹F: the part of J u that the forces of this substep made, m/s or rad/s.
    pub fn forced_velocity(&self, bodies: &[SolverBody]) -> f32 {
        let (a, b) = (&bodies[self.body_a as usize], &bodies[self.body_b as usize]);
        self.jacobian.linear.dot(a.forced_velocity - b.forced_velocity)
            + self.jacobian.angular_a.dot(a.forced_spin)
            + self.jacobian.angular_b.dot(b.forced_spin)
    }

    /// u += M⁻¹Jᵀ Δλ.
    #[inline]
    pub fn apply(&self, bodies: &mut [SolverBody], delta_lambda: f32) {
        let a = &mut bodies[self.body_a as usize];
        a.velocity += self.response.linear_a * delta_lambda;
        a.angular_velocity += self.response.angular_a * delta_lambda;
        let b = &mut bodies[self.body_b as usize];
        b.velocity += self.response.linear_b * delta_lambda;
        b.angular_velocity += self.response.angular_b * delta_lambda;
    }

    /// J·δ: what the motion of this step did along the row, m or rad.
    #[inline]
    pub fn displacement(&self, bodies: &[SolverBody]) -> f32 {
        let (a, b) = (&bodies[self.body_a as usize], &bodies[self.body_b as usize]);
        self.jacobian.linear.dot(a.translation - b.translation)
            + self.jacobian.angular_a.dot(a.turn)
            + self.jacobian.angular_b.dot(b.turn)
    }

    /// Fills in what depends on the masses: M⁻¹Jᵀ and 1/(J M⁻¹Jᵀ + γ).
    pub fn refresh_mass(&mut self, bodies: &[SolverBody]) {
        let (a, b) = (&bodies[self.body_a as usize], &bodies[self.body_b as usize]);
        self.response = response(&self.jacobian, a, b, self.scale);
        let k = inner(&self.jacobian, &self.response) + self.softness;
        self.effective_mass = if k > 0.0 { 1.0 / k } else { 0.0 };
        self.limit_mass = 0.0;
    }
}

/// M⁻¹Jᵀ with scaled masses.
#[inline]
pub fn response(j: &Jacobian, a: &SolverBody, b: &SolverBody, scale: MassScale) -> Response {
    Response {
        linear_a: a.inverse_mass * j.linear * scale.mass_a,
        angular_a: a.inverse_inertia * j.angular_a * scale.inertia_a,
        linear_b: -(b.inverse_mass * j.linear) * scale.mass_b,
        angular_b: b.inverse_inertia * j.angular_b * scale.inertia_b,
    }
}

/// The part of J M⁻¹J'ᵀ of two rows that runs through one body: the A or B of each.
#[inline]
pub fn inner_at(row: &Row, row_is_a: bool, other: &Row, other_is_a: bool) -> f32 {
    let (linear, angular) = if row_is_a {
        (row.jacobian.linear, row.jacobian.angular_a)
    } else {
        (-row.jacobian.linear, row.jacobian.angular_b)
    };
    let r = &other.response;
    let (v, w) = if other_is_a { (r.linear_a, r.angular_a) } else { (r.linear_b, r.angular_b) };
    linear.dot(v) + angular.dot(w)
}

/// J · (M⁻¹J'ᵀ) of two rows between the same two bodies.
#[inline]
pub fn inner(j: &Jacobian, r: &Response) -> f32 {
    j.linear.dot(r.linear_a - r.linear_b) + j.angular_a.dot(r.angular_a) + j.angular_b.dot(r.angular_b)
}

impl Row {
    /// A row of a contact; masses come in with [`Row::refresh_mass`].
    pub fn of_contact(spec: &ContactRow, body_a: u32, body_b: u32) -> Self {
        Self {
            body_a,
            body_b,
            jacobian: spec.jacobian,
            scale: MassScale::ONE,
            response: Response::default(),
            effective_mass: 0.0,
            softness: 0.0,
            bias: spec.bias,
            relax_bias: spec.bias,
            arc: 0.0,
            lower: 0.0,
            upper: f32::INFINITY,
            coupling: spec.coupling,
            cross_mass: 0.0,
            limit_mass: 0.0,
            by_pose: false,
            lambda: spec.lambda,
            total_lambda: 0.0,
        }
    }

    /// A row of a joint; masses come in with [`Row::refresh_mass`].
    pub fn of_joint(spec: &RowSpec, body_a: u32, body_b: u32, lambda: f32) -> Self {
        Self {
            body_a,
            body_b,
            jacobian: spec.jacobian,
            scale: MassScale::ONE,
            response: Response::default(),
            effective_mass: 0.0,
            softness: spec.softness,
            bias: spec.bias,
            relax_bias: spec.relax_bias,
            arc: spec.arc,
            lower: spec.lower,
            upper: spec.upper,
            coupling: Coupling::None,
            cross_mass: 0.0,
            limit_mass: 0.0,
            by_pose: false,
            lambda,
            total_lambda: 0.0,
        }
    }
}

/// Fills in J₁ M⁻¹J₂ᵀ of every disk.
pub fn couple_disks(rows: &mut [Row]) {
    for i in 0..rows.len() {
        if let Coupling::Disk(_) = rows[i].coupling {
            rows[i].cross_mass = inner(&rows[i].jacobian, &rows[i + 1].response);
        }
    }
}

/// Notes which bodies some row pushes in this substep. Impulses of impacts do not count: they are over.
pub fn mark_pushed(rows: &[Row], bodies: &mut [SolverBody]) {
    bodies.iter_mut().for_each(|body| body.pushed = false);
    for row in rows.iter().filter(|row| row.lambda != 0.0) {
        bodies[row.body_a as usize].pushed = true;
        bodies[row.body_b as usize].pushed = true;
    }
}
