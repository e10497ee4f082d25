//! The rows A to D of the talk, and where each is put to the test.
//!
//! Rows are those of our retelling of the talk: A unconstrained motion, B constraints, C the linear
//! complementarity problem, D stabilization and speed.

/// Where a row is put to the test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Proof {
    /// Experiments of this crate, by name.
    Experiments(&'static [&'static str]),
    /// A definition that needs no experiment of its own: a test of the engine, `file::function`.
    Test(&'static str),
}

/// A technique or a term of the talk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Row {
    /// A letter for the chapter and a number.
    pub id: &'static str,
    /// Its name.
    pub technique: &'static str,
    /// Where it is put to the test.
    pub proof: Proof,
}

const fn row(id: &'static str, technique: &'static str, experiments: &'static [&'static str]) -> Row {
    Row { id, technique, proof: Proof::Experiments(experiments) }
}

const fn term(id: &'static str, technique: &'static str, test: &'static str) -> Row {
    Row { id, technique, proof: Proof::Test(test) }
}

/// All rows, in order.
pub const ROWS: &[Row] = &[
    row("A1", "Translation", &["free-fall"]),
    row("A2", "Orientation", &["orthonormalization"]),
    term("A3", "Torque", "motion_laws.rs::torque_adds_up_in_the_momentum"),
    row("A4", "Inertia tensor", &["mass-integrals"]),
    term("A5", "Newton–Euler equations", "motion_laws.rs::symmetric_top_precesses_steadily"),
    row("A6", "The talk's four-step rotation", &["euler-vs-angular-momentum", "orthonormalization"]),
    row("A7", "Symmetric splitting", &["dzhanibekov"]),
    term("B1", "Analytic, velocity-level constraints", "laws_contact.rs::ground_carries_the_weight_of_the_stack"),
    term("B2", "Velocity of a point", "kinematic.rs::a_turntable_carries_a_box_around"),
    term("B3", "Generalized velocity and mass matrix", "mass_laws.rs::turning_a_body_turns_its_inertia"),
    row("B4", "Jacobian", &["jacobian-check"]),
    row("B5", "Velocity on a constraint axis", &["jacobian-check"]),
    term("B6", "Inequality and equality", "joint_rows/laws.rs::rope_and_cone_hold"),
    row("B7", "Ball joint", &["ball-joint"]),
    row("B8", "Hinge", &["hinge"]),
    row("B9", "Range of motion", &["range-of-motion"]),
    row("B10", "Constraint force", &["momentum"]),
    term("B11", "Condition after one step", "techniques/recovery.rs::more_sweeps_leave_less_residual"),
    row("B12", "Many bodies: the sparse J", &["talk-matrix"]),
    term("C1", "Contact LCP", "joint_rows/laws.rs::limits_push_inward"),
    row("C2", "Friction", &["friction-box-vs-disk"]),
    row("C3", "General box LCP", &["lemke-vs-pgs"]),
    row("C4", "Direct solution: Lemke", &["lemke-vs-pgs"]),
    row("C5", "Jacobi, Gauss–Seidel", &["jacobi-vs-gauss-seidel"]),
    row("C6", "Indeterminate systems", &["indeterminate"]),
    row("C7", "Projected Gauss–Seidel", &["pgs-two-body", "lemke-vs-pgs"]),
    row("D1", "Penetration recovery", &["penetration-recovery", "technique-matrix"]),
    row("D2", "Slop", &["slop", "technique-matrix"]),
    row("D3", "Permutation", &["permutation", "technique-matrix"]),
    row("D4", "Warm start", &["warm-start", "contact-ids", "technique-matrix"]),
    row("D5", "Height", &["heights", "plank-on-two-towers"]),
    row("D6", "Shock propagation", &["shock-propagation", "weight-feeling", "technique-matrix"]),
    row("D7", "Blended shock propagation", &["blended-shock", "weight-feeling", "technique-matrix"]),
    row("D8", "Weight amplification", &["weight-amplification", "weight-feeling", "technique-matrix"]),
    row("D9", "Sleep", &["sleep"]),
    row("D10", "Aggressive sleep", &["aggressive-sleep", "technique-matrix"]),
    row("D11", "Ragdolls", &["ragdoll-dies"]),
];

/// The row of this id.
pub fn find(id: &str) -> Option<&'static Row> {
    ROWS.iter().find(|row| row.id == id)
}
