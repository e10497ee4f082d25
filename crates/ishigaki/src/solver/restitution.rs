//! Restitution: an impact phase before the contact solve (Guendelman, Bridson, Fedkiw 2003).
//!
//! A contact that closes within the substep (s + h w ≤ 0) faster than the threshold is an impact: its manifold
//! is solved alone for w' = −e w₀, friction included, and the next contact sees the new velocities. Passes repeat
//! until nothing closes any more, so an impact runs through a row of balls one by one: one in, one out. Solving
//! all of them at once would let every ball of a cradle move. e is mixed from the materials; slower impacts
//! do not bounce, or resting bodies would chatter. Masses are as they are: no amplification.
//! Option: `solver.restitution`; proved by `tests/laws_contact.rs`: e²ⁿH, ten bounces at e = 1, the cradle.

use crate::collision::manifold::Manifold;
use crate::constraint::contact::{self, Layout, Surface};
use crate::options::{DriftScheme, FrictionModel};
use crate::solver::reference::solve_row_of;
use crate::solver::table::{Row, SolverBody, couple_disks};
use arrayvec::ArrayVec;

/// Rows of a manifold at most: 4 × (2 tangents + 1 normal) + torsion + 2 rolling.
const MOST_ROWS: usize = 15;
/// Sweeps over the rows of one manifold: four points of a box need about ten.
const INNER_SWEEPS: usize = 16;

/// What an impact needs to know of its pair and substep.
#[derive(Clone, Copy, Debug)]
pub struct Impact {
    /// Index of the first body in the plan.
    pub body_a: u32,
    /// Index of the second.
    pub body_b: u32,
    /// Material of the pair.
    pub surface: Surface,
    /// Newton's e of the pair.
    pub restitution: f32,
    /// Slower impacts do not bounce, m/s.
    pub threshold: f32,
    /// Substep, s.
    pub h: f32,
    /// How bodies move on: it decides which velocity is reflected.
    pub drift: DriftScheme,
}

/// Solves the manifold as an impact if it is one; gives the normal impulses to `impulses` and says whether it was.
///
/// `separations` are those of the points now, m.
pub fn resolve(
    impact: &Impact,
    manifold: &Manifold,
    separations: &[f32],
    model: FrictionModel,
    bodies: &mut [SolverBody],
    mut impulses: impl FnMut(usize, f32),
) -> bool {
    let layout = Layout::new(manifold.points.len(), &impact.surface, model);
    let first_normal = layout.first_normal() as usize;
    let mut rows: ArrayVec<Row, MOST_ROWS> = ArrayVec::new();
    contact::rows(manifold, &impact.surface, model, 0, |spec| {
        rows.push(Row::of_contact(&spec, impact.body_a, impact.body_b));
    });

    let mut is_impact = false;
    for (row, &separation) in rows[first_normal..].iter_mut().zip(separations) {
        let w = row.velocity(bodies);
        let closes = separation + impact.h * w <= 0.0;
        if closes && -w > impact.threshold {
            is_impact = true;
            // w' = −e w₀ with the velocity w₀ before the forces of this substep: symplectic Euler falls on
            // ½v² + gy − ½ghv = const, and this v' keeps it. From w itself each bounce would gain gh|w|.
            let forced = row.forced_velocity(bodies);
            row.bias = impact.restitution * (w - forced).min(0.0);
            if impact.drift == DriftScheme::Trapezoidal {
                // The trapezoid falls on ½v² + gy = const: the forces of this substep act on after the bounce.
                row.bias -= forced;
            }
        } else {
            row.bias = separation.max(0.0) / impact.h; // the others must not close
        }
    }
    if !is_impact {
        return false;
    }

    for row in &mut rows {
        row.lambda = 0.0;
        row.refresh_mass(bodies);
    }
    couple_disks(&mut rows);
    for _ in 0..INNER_SWEEPS {
        // Normals first: friction starts from nothing and needs their impulse.
        for unit in (first_normal..rows.len()).chain(0..first_normal) {
            solve_row_of(unit, &mut rows, &[], bodies);
        }
    }
    for (i, row) in rows[first_normal..].iter().enumerate() {
        impulses(i, row.lambda);
    }
    true
}
