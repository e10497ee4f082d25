//! How far the impulses are from a solution. TALK C3.
//!
//! ‖λ − clip(λ − w·m_eff, lower, upper)‖∞, N·s: the change one more visit would make to each row alone.
//! Zero exactly at a solution of the box LCP. Scaling w with the row's effective mass gives all rows one unit.

use crate::constraint::friction::Coupling;
use crate::solver::block::Block;
use crate::solver::reference::reach;
use crate::solver::table::{Row, SolverBody, inner};

/// The residual for the velocities and biases as they are, N·s.
pub fn residual(rows: &[Row], blocks: &[Block], bodies: &[SolverBody]) -> f32 {
    let mut greatest = 0.0_f32;
    let wanted = |row: &Row| {
        let w = row.velocity(bodies) + row.softness * row.lambda + row.bias;
        row.lambda - w * row.effective_mass
    };
    for (i, row) in rows.iter().enumerate() {
        let change = match row.coupling {
            Coupling::None | Coupling::Limit(_) => (row.lambda - wanted(row).max(row.lower).min(row.upper)).abs(),
            Coupling::Interval(bound) => {
                let reach = reach(&bound, rows);
                (row.lambda - wanted(row).max(-reach).min(reach)).abs()
            }
            Coupling::Disk(bound) => {
                let (reach, other) = (reach(&bound, rows), &rows[i + 1]);
                let (x, y) = (wanted(row), wanted(other));
                let length = (x * x + y * y).sqrt();
                let shrink = if length > reach { reach / length } else { 1.0 };
                let (dx, dy) = (row.lambda - shrink * x, other.lambda - shrink * y);
                (dx * dx + dy * dy).sqrt()
            }
            Coupling::Block(index) => block_residual(&blocks[index as usize], rows, bodies),
            // Counted with the first row of its disk or block.
            Coupling::Partner => 0.0,
        };
        greatest = greatest.max(change);
    }
    greatest
}

/// Rows of a block have no bounds: the greatest |w| / (J M⁻¹Jᵀ).
fn block_residual(block: &Block, rows: &[Row], bodies: &[SolverBody]) -> f32 {
    let rows = &rows[block.first as usize..][..block.count as usize];
    let mut greatest = 0.0_f32;
    for row in rows {
        let w = row.velocity(bodies) + row.bias;
        let k = inner(&row.jacobian, &row.response);
        greatest = greatest.max(if k > 0.0 { (w / k).abs() } else { 0.0 });
    }
    greatest
}
