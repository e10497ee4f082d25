//! A contact manifold as rows. TALK B5, B6.
//!
//! Normal rows: w = n·(v_A + ω_A×r_A − v_B − ω_B×r_B) + bias ≥ 0, λ ∈ [0, ∞). Both arms of a row reach to the
//! middle of the gap, so that the two impulses have one line of action and angular momentum is conserved.
//! Rows of a manifold: friction first, normals last, since what a sweep does last holds best:
//! 2 tangents for each point, 1 torsion and 2 rolling rows where the material asks for them, then the normals.

use crate::collision::manifold::{ContactPoint, Manifold};
use crate::constraint::friction::{Bound, Coupling};
use crate::constraint::row::Jacobian;
use crate::math::{Vec3, tangents};
use crate::options::FrictionModel;

/// Mixed material of a pair, as its rows need it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Surface {
    /// Coulomb's μ.
    pub friction: f32,
    /// m.
    pub torsional_friction: f32,
    /// m.
    pub rolling_friction: f32,
    /// Velocity of B's surface relative to A's surface by conveyors, world, m/s.
    pub surface_velocity: Vec3,
}

/// Rows of a manifold in their order: how many of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// 2 for each point, or none.
    pub tangents: u32,
    /// 0 or 1.
    pub torsion: u32,
    /// 0 or 2.
    pub rolling: u32,
    /// 1 for each point.
    pub normals: u32,
}

impl Layout {
    /// The rows of a manifold with `points` points.
    pub fn new(points: usize, surface: &Surface, model: FrictionModel) -> Self {
        let on = model != FrictionModel::Off;
        Self {
            tangents: if on && surface.friction > 0.0 { 2 * points as u32 } else { 0 },
            torsion: u32::from(on && surface.torsional_friction > 0.0),
            rolling: if on && surface.rolling_friction > 0.0 { 2 } else { 0 },
            normals: points as u32,
        }
    }

    /// All rows.
    pub fn total(&self) -> u32 {
        self.tangents + self.torsion + self.rolling + self.normals
    }

    /// Offset of the first normal row.
    pub fn first_normal(&self) -> u32 {
        self.tangents + self.torsion + self.rolling
    }
}

/// A row of a manifold before masses and biases come in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactRow {
    /// J.
    pub jacobian: Jacobian,
    /// Wanted J u, negated; normals get theirs from the separation in every substep.
    pub bias: f32,
    /// Who bounds it.
    pub coupling: Coupling,
    /// The last substep's impulse.
    pub lambda: f32,
}

/// Calls `emit` for each row of a manifold in the order of [`Layout`]; `base` is the index of its first row.
pub fn rows(m: &Manifold, surface: &Surface, model: FrictionModel, base: u32, mut emit: impl FnMut(ContactRow)) {
    let layout = Layout::new(m.points.len(), surface, model);
    let first_normal = base + layout.first_normal();
    let (t1, t2) = tangents(m.normal);
    let pair = |bound: Bound| match model {
        FrictionModel::Disk => [Coupling::Disk(bound), Coupling::Partner],
        _ => [Coupling::Interval(bound); 2],
    };
    if layout.tangents > 0 {
        for (i, p) in m.points.iter().enumerate() {
            let (arm_a, arm_b) = middle_arms(p.arm_a, p.arm_b, m.normal, p.separation);
            let bound = Bound { first: first_normal + i as u32, count: 1, coefficient: surface.friction };
            for ((axis, coupling), lambda) in [t1, t2].into_iter().zip(pair(bound)).zip(p.lambda_friction) {
                emit(ContactRow {
                    jacobian: Jacobian::point(axis, arm_a, arm_b),
                    // The surfaces, not the bodies, come to rest relative to each other.
                    bias: -axis.dot(surface.surface_velocity),
                    coupling,
                    lambda,
                });
            }
        }
    }
    let all = |coefficient| Bound { first: first_normal, count: layout.normals, coefficient };
    if layout.torsion > 0 {
        emit(ContactRow {
            jacobian: Jacobian::rotation(m.normal),
            bias: 0.0,
            coupling: Coupling::Interval(all(surface.torsional_friction)),
            lambda: m.lambda_torsion,
        });
    }
    if layout.rolling > 0 {
        let pair = pair(all(surface.rolling_friction));
        for ((axis, coupling), lambda) in [t1, t2].into_iter().zip(pair).zip(m.lambda_rolling) {
            emit(ContactRow { jacobian: Jacobian::rotation(axis), bias: 0.0, coupling, lambda });
        }
    }
    for p in &m.points {
        let (arm_a, arm_b) = middle_arms(p.arm_a, p.arm_b, m.normal, p.separation);
        emit(ContactRow {
            jacobian: Jacobian::point(m.normal, arm_a, arm_b),
            bias: 0.0,
            coupling: Coupling::None,
            lambda: p.lambda_normal,
        });
    }
}

/// Arms to the middle of the gap along the normal; to the two surfaces where a sweep found the contact from afar,
/// since that gap is closed by the time the contact pushes.
fn middle_arms(arm_a: Vec3, arm_b: Vec3, normal: Vec3, separation: f32) -> (Vec3, Vec3) {
    let from_afar = separation > 0.1 * arm_a.length().min(arm_b.length());
    let half = if from_afar { Vec3::ZERO } else { 0.5 * separation * normal };
    (arm_a - half, arm_b + half)
}

/// Spreads the normal impulses of four points as evenly as the same wrench allows. TALK C6.
///
/// Four points carry a load and two tilts: one combination ν of impulses is nothing at all (Σν = 0, Σν r = 0), and
/// whatever an impact leaves of it a warm start keeps for ever, so that a box might rest on two opposite corners.
/// λ − ν (ν·λ)/(ν·ν) is the solution of least norm, to which Gauss–Seidel tends; no λ becomes negative.
/// Points up to `closed` apart (m) may bear.
pub fn share_evenly(m: &mut Manifold, closed: f32) {
    let bears = |p: &ContactPoint| p.separation <= closed || p.lambda_normal > 0.0;
    let [a, b, c, d] = m.points.as_slice() else { return };
    if !m.points.iter().all(bears) {
        return;
    }
    let area = |p: &ContactPoint, q: &ContactPoint, r: &ContactPoint| {
        m.normal.dot((q.arm_b - p.arm_b).cross(r.arm_b - p.arm_b))
    };
    // The affine dependence of four points in a plane: each has the area of the triangle of the others.
    let nothing = [area(b, c, d), -area(a, c, d), area(a, b, d), -area(a, b, c)];
    let square: f32 = nothing.iter().map(|n| n * n).sum();
    if square <= 0.0 {
        return;
    }
    let mut t = m.points.iter().zip(nothing).map(|(p, n)| p.lambda_normal * n).sum::<f32>() / square;
    for (p, n) in m.points.iter().zip(nothing) {
        if t * n > p.lambda_normal {
            t = p.lambda_normal / n;
        }
    }
    for (p, n) in m.points.iter_mut().zip(nothing) {
        p.lambda_normal = (p.lambda_normal - t * n).max(0.0);
    }
}

/// Puts the solved impulses back into the manifold, for the next warm start.
pub fn store(m: &mut Manifold, surface: &Surface, model: FrictionModel, lambdas: &[f32]) {
    let layout = Layout::new(m.points.len(), surface, model);
    let (mut at, normals) = (0, layout.first_normal() as usize);
    for p in &mut m.points {
        p.lambda_friction = if layout.tangents > 0 { [lambdas[at], lambdas[at + 1]] } else { [0.0; 2] };
        at += if layout.tangents > 0 { 2 } else { 0 };
    }
    m.lambda_torsion = if layout.torsion > 0 { lambdas[at] } else { 0.0 };
    at += layout.torsion as usize;
    m.lambda_rolling = if layout.rolling > 0 { [lambdas[at], lambdas[at + 1]] } else { [0.0; 2] };
    for (p, &lambda) in m.points.iter_mut().zip(&lambdas[normals..]) {
        p.lambda_normal = lambda;
    }
}
