//! Friction: impulses bounded by other impulses. TALK C2.
//!
//! |λ_t| ≤ μ λ_n with λ_n re-read in every sweep. `Disk` bounds the vector of the two tangential impulses
//! (Coulomb's cone), `Box` each of them alone (the talk's; up to √2 too strong along the diagonal, and it
//! bends sliding, because the axis that slides and the axis that sticks are told apart by fixed tangents).
//! Without friction nothing stacked stays. Option: `solver.friction`; proved by `tests/laws_friction.rs`.

/// The impulses that bound a friction impulse: `coefficient · Σ λ` over a run of rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// First of the normal rows.
    pub first: u32,
    /// How many normal rows follow each other.
    pub count: u32,
    /// μ (a number) for tangents, a length (m) for torsion and rolling.
    pub coefficient: f32,
}

// ANCHOR: coupling
/// How the bounds of a row follow from other rows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Coupling {
    /// They do not: lower and upper stand.
    #[default]
    None,
    /// −b ≤ λ ≤ b.
    Interval(Bound),
    /// √(λ² + λ'²) ≤ b with λ' of the next row; the two are solved together.
    Disk(Bound),
    /// The first of several equality rows that are solved together: index of the block.
    Block(u32),
    /// An end of a range: after it the equality rows of its joint are solved again. Index of their block.
    Limit(u32),
    /// A row that is solved with an earlier one: the second of a disk, or one of a block.
    Partner,
}
// ANCHOR_END: coupling
