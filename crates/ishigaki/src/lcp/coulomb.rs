//! Gauss–Seidel over frictional contacts. TALK C2; the sliding case after Bonnefon & Daviet 2011.
//!
//! Contact by contact, u = W r + q′ with the others' r held in q′. *Blocks*: the one-contact problem exactly. q′_n ≥ 0: it
//! opens, r = 0. Else r = −W⁻¹q′ if that is in the cone: it sticks. Else it slides: u_n = 0 and r_t = −u_t/α with α > 0;
//! with S = W_tt − W_tn W_nt/W_nn and q̃ = q′_t − W_tn q′_n/W_nn it is r_t(α) = −(S + α)⁻¹ q̃; |r_t| − μ r_n is positive at
//! α = 0, negative for large α, and its root is found by bisection. *Rows*: the normal by PGS, then the two tangents by a
//! step clipped to the disk. With strong coupling of normal and tangents a contact may have several exact solutions, and
//! blocks then jump between them for ever; `relaxation` < 1 ends it. Reads sweeps, tolerance (of the natural map), relaxation
//! (at most 1), order, seed. Tests: `tests/lcp/friction_contact.rs`.

use crate::lcp::box_lcp::clip_to_disk;
use crate::lcp::friction_contact::FrictionContact;
use crate::lcp::settings::{Settings, Status, arrange};
use crate::solver::permutation::Random;
use glam::{DMat2, DMat3, DVec2, DVec3};

/// What was found of a frictional contact problem.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactSolution {
    /// r: normal first, then two tangents.
    pub reaction: Vec<[f64; 3]>,
    /// u = W r + q.
    pub velocity: Vec<[f64; 3]>,
    /// The error of the natural map after every sweep.
    pub errors: Vec<f64>,
    /// That of `reaction`.
    pub error: f64,
    /// Sweeps done.
    pub sweeps: usize,
    /// Solved or limit.
    pub status: Status,
}

impl FrictionContact {
    /// Gauss–Seidel with the exact solution of each contact (NSGS).
    pub fn solve_blocks(&self, settings: &Settings) -> ContactSolution {
        self.sweep(settings, |contact, u, r| {
            let w = self.diagonal[contact];
            solve_contact(w, u - w * r, self.mu[contact])
        })
    }

    /// Projected Gauss–Seidel: normal, then tangents together.
    pub fn solve_rows(&self, settings: &Settings) -> ContactSolution {
        self.sweep(settings, |contact, u, r| {
            let w = self.diagonal[contact];
            let normal = (r.x - u.x / w.x_axis.x).max(0.0);
            let u = u + w.x_axis * (normal - r.x);
            let greatest = greatest_eigenvalue(tangential(w));
            let step = if greatest > 0.0 { 1.0 / greatest } else { 0.0 };
            let [y, z] = clip_to_disk([r.y - step * u.y, r.z - step * u.z], self.mu[contact] * normal);
            DVec3::new(normal, y, z)
        })
    }

    /// Repeats `visit(contact, u, r)`, which gives the new r of the contact.
    fn sweep(&self, settings: &Settings, visit: impl Fn(usize, DVec3, DVec3) -> DVec3) -> ContactSolution {
        let mut reaction = vec![DVec3::ZERO; self.len()];
        let mut order: Vec<usize> = (0..self.len()).collect();
        let mut random = Random(settings.seed);
        let mut errors = Vec::new();
        let mut error = self.error(&reaction, &self.velocity(&reaction));
        while error > settings.tolerance && errors.len() < settings.sweeps {
            let before = reaction.clone();
            arrange(settings.order, errors.len(), &mut random, &mut order);
            for &contact in &order {
                let (u, r) = (self.velocity_of(contact, &reaction), reaction[contact]);
                // Between two points of a cone: in the cone.
                reaction[contact] = r + settings.relaxation.min(1.0) * (visit(contact, u, r) - r);
            }
            let next = self.error(&reaction, &self.velocity(&reaction));
            if !next.is_finite() {
                reaction = before;
                break;
            }
            error = next;
            errors.push(error);
        }
        let velocity = self.velocity(&reaction);
        let status = if error <= settings.tolerance { Status::Solved } else { Status::Limit };
        let arrays = |v: Vec<DVec3>| v.into_iter().map(|x| x.to_array()).collect();
        ContactSolution {
            reaction: arrays(reaction),
            velocity: arrays(velocity),
            sweeps: errors.len(),
            errors,
            error,
            status,
        }
    }
}

/// r of one contact with u = W r + q.
fn solve_contact(w: DMat3, q: DVec3, mu: f64) -> DVec3 {
    if q.x >= 0.0 {
        return DVec3::ZERO;
    }
    let k = w.x_axis.x;
    if mu == 0.0 {
        return DVec3::new(-q.x / k, 0.0, 0.0);
    }
    let stick = -(w.inverse() * q);
    if stick.is_finite() && stick.y * stick.y + stick.z * stick.z <= mu * mu * stick.x * stick.x && stick.x >= 0.0 {
        return stick;
    }
    // W_tn and W_nt: columns and rows of the block.
    let (down, across) = (DVec2::new(w.x_axis.y, w.x_axis.z), DVec2::new(w.y_axis.x, w.z_axis.x));
    let s = tangential(w) - DMat2::from_cols(down * across.x, down * across.y) * (1.0 / k);
    let pushed = DVec2::new(q.y, q.z) - down * (q.x / k);
    let reaction = |alpha: f64| {
        let tangent = -((s + DMat2::from_diagonal(DVec2::splat(alpha))).inverse() * pushed);
        DVec3::new(-(q.x + across.dot(tangent)) / k, tangent.x, tangent.y)
    };
    let excess = |r: DVec3| (r.y * r.y + r.z * r.z).sqrt() - mu * r.x;
    let scale = greatest_eigenvalue(tangential(w)).max(f64::MIN_POSITIVE);
    let (mut low, mut high) = (1e-14 * scale, scale);
    for _ in 0..200 {
        if excess(reaction(high)) <= 0.0 {
            break;
        }
        (low, high) = (high, 4.0 * high);
    }
    for _ in 0..100 {
        // In the middle of their exponents: α spans many of them.
        let middle = if high > 4.0 * low { (low * high).sqrt() } else { 0.5 * (low + high) };
        if middle <= low || middle >= high {
            break;
        }
        if excess(reaction(middle)) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    // The side that is inside the cone.
    reaction(high)
}

fn tangential(w: DMat3) -> DMat2 {
    DMat2::from_cols(DVec2::new(w.y_axis.y, w.y_axis.z), DVec2::new(w.z_axis.y, w.z_axis.z))
}

fn greatest_eigenvalue(m: DMat2) -> f64 {
    let (half, cross) = (0.5 * (m.x_axis.x - m.y_axis.y), 0.5 * (m.x_axis.y + m.y_axis.x));
    0.5 * (m.x_axis.x + m.y_axis.y) + (half * half + cross * cross).sqrt()
}
