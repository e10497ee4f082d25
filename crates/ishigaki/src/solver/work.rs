//! Work of the solver, in multiply-adds.
//!
//! Times differ between machines and days; the multiply-adds of row visits, assembly, factorization, substitution and
//! line search do not. `report.work` counts them as the code makes them, `report.work_budget` says what twelve visits to
//! every row alone would cost: what four substeps of three sweeps spend in engines that know nothing but sweeps.

/// J u of a row: three for the linear part, which both bodies share, and three for the rotation of each.
pub const VELOCITY: u64 = 9;
/// u += M⁻¹Jᵀ Δλ.
pub const APPLY: u64 = 12;
/// A visit to a row alone: J u, Δλ and its bounds, u.
pub const VISIT: u64 = VELOCITY + APPLY + 3;
/// M⁻¹Jᵀ of a row.
pub const RESPONSE: u64 = 24;
/// J · (M⁻¹J'ᵀ) of two rows of the same two bodies.
pub const INNER: u64 = 9;
/// What manifolds cost in the wide path.
#[derive(Clone, Copy, Debug, Default)]
pub struct Manifolds {
    /// A visit: relative velocity and pushes are shared by the normals.
    pub visit: u64,
    /// Rows from arms: J', K.
    pub rows: u64,
    /// u' += J'ᵀλ.
    pub warm_start: u64,
    /// Separations after the motion, and biases of them after it and before the next.
    pub measures: u64,
    /// How far from rest they are.
    pub looks: u64,
}

impl Manifolds {
    /// A manifold of `count` points more; `passes` over its normals in a visit.
    pub fn add(&mut self, count: u64, passes: u64) {
        let passes = if count == 1 { 1 } else { passes };
        let normals = count * 12 + passes * count * (count + 1);
        let disk = 2 * 6 + 14 + 2 * 6 + 2;
        // Relative velocities along the three directions, and one impulse of all points on both bodies.
        let linear = 9 + 9 + 6;
        self.visit += linear + normals + count * disk;
        // Arms, their products with the directions, I^−½ of these; from two points on by way of I^−½ of the directions.
        let jacobians = if count == 1 { 18 + 27 } else { 27 + count * 27 };
        self.rows += 2 * jacobians + inner(count);
        self.warm_start += count * (9 + 6 + 3 * 6);
        self.measures += 3 + count * (6 + 5);
        self.looks += 9 + count * (3 * 6 + 8);
    }
}

/// J M⁻¹Jᵀ of the rows of a manifold. Directions are unit vectors and square to each other: rotations are all that is
/// multiplied.
const fn inner(count: u64) -> u64 {
    (3 + 1) * 6 * count + count * (count - 1) / 2 * 6
}

/// Rows of a manifold of `count` points anew for other inertias.
pub const fn reweighing(count: u64) -> u64 {
    count * 3 * (18 + 18) + inner(count)
}

/// A visit to the point of a ball joint in the wide path: the linear part of its rows is a unit vector each.
pub const POINT: u64 = 2 * 9 + 9 + POINT_PUSH;
/// u' += M'⁻¹J'ᵀλ of it.
pub const POINT_PUSH: u64 = 2 * (3 + 9);
/// A visit to the same of round bodies, whose rows are a vector product with the arm.
pub const ROUND_POINT: u64 = 2 * 6 + 9 + ROUND_POINT_PUSH;
/// u' += M'⁻¹J'ᵀλ of it.
pub const ROUND_POINT_PUSH: u64 = 2 * (3 + 6);
/// Part of its error that a recovery takes back, or its step times ω.
pub const POINT_PART: u64 = 3;
/// u' += M'⁻¹J'ᵀλ of a row there that turns its bodies only.
pub const TURN_PUSH: u64 = 6 + 1;
/// A visit to such a row.
pub const TURN_VISIT: u64 = TURN_LOOK + TURN_PUSH;
/// Whether it has something to do, as ends of ranges mostly have not.
pub const TURN_LOOK: u64 = 6 + 2;
/// What a point leaves free of such a row.
pub const FREE_PART: u64 = 3 * 6 + 9 + 3;
/// Rows of a point at a pose: arms, J', K and its factors, arcs.
pub const POINT_ROWS: u64 = 2 * 15 + 2 * 18 + 6 * 6 + 10 + 2 * 18 + 3;
/// The same of round bodies, whose rows are arms and whose ω stays.
pub const ROUND_POINT_ROWS: u64 = 2 * 15 + 2 * 3 + 2 * 6 + 10 + 2 * 12 + 3;
/// Rows of twist and cone: frames, angles, J'.
pub const RANGE_ROWS: u64 = 2 * 16 + 2 * 15 + 16 + 20 + 2 * 24;

/// Visits to every row in the budget.
pub const BUDGET_VISITS: u64 = 12;

/// What `rows` rows may cost in a step.
pub fn budget(rows: usize) -> u64 {
    BUDGET_VISITS * VISIT * rows as u64
}

/// A friction disk: two rows together.
pub const DISK: u64 = 2 * (VELOCITY + APPLY) + 14;

/// Equality rows of a joint; of those along the world axes only rotations are multiplied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// All of them.
    pub rows: u64,
    /// Those along the world axes.
    pub axes: u64,
}

impl Size {
    /// J u + bias, Δλ and u, but for the solution between.
    pub const fn visit(self) -> u64 {
        self.rows * (VELOCITY + 2) - 3 * self.axes + self.push()
    }

    /// u += M⁻¹Jᵀ Δλ.
    pub const fn push(self) -> u64 {
        self.rows * APPLY - 4 * self.axes
    }

    /// M⁻¹Jᵀ.
    pub const fn responses(self) -> u64 {
        self.rows * RESPONSE - 6 * self.axes
    }

    /// J M⁻¹Jᵀ.
    pub const fn inner(self) -> u64 {
        self.rows * (self.rows + 1) / 2 * INNER - self.axes * (self.axes + 1) / 2 * 3
    }

    /// The part of it that runs through a body which another joint has, too.
    pub const fn inner_at(self, other: Self) -> u64 {
        6 * self.rows * other.rows - 3 * self.axes * other.axes
    }

    /// The factors of them alone.
    pub const fn factor(self) -> u64 {
        self.inner() + self.rows * self.rows * self.rows / 6
    }

    /// A visit to them alone.
    pub const fn visit_alone(self) -> u64 {
        self.visit() + self.rows * self.rows
    }
}

/// A visit to the normals of a manifold of `count` points.
pub const fn normals(count: u64, passes: u64) -> u64 {
    count * (VELOCITY + APPLY) + passes * count * (count + 1)
}
