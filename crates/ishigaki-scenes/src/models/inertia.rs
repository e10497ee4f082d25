//! Mass, center and inertia in f64: what bodies are merged and scaled with before they become f32.
//!
//! Parallel axes (Steiner): about its center a body of parts has `I = Σ R Iᵢ Rᵀ + mᵢ (|d|² 1 − d dᵀ)` with d from the
//! common center to the part's. Principal axes by Jacobi rotations, exact to rounding for any symmetric matrix.

use glamx::{DMat3, DPose3, DQuat, DVec3};
use std::f64::consts::PI;

/// Mass, center of mass, inertia about it; axes of the frame it is expressed in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Inertia {
    /// kg.
    pub mass: f64,
    /// m.
    pub center: DVec3,
    /// About the center, kg·m².
    pub matrix: DMat3,
}

impl Inertia {
    pub const ZERO: Self = Self { mass: 0.0, center: DVec3::ZERO, matrix: DMat3::ZERO };

    /// About its own center, in its principal axes.
    pub fn diagonal(mass: f64, moments: DVec3) -> Self {
        Self { mass, center: DVec3::ZERO, matrix: DMat3::from_diagonal(moments) }
    }

    /// The same body seen from another frame: `to_from_here`.
    pub fn transformed(&self, to_from_here: DPose3) -> Self {
        let r = DMat3::from_quat(to_from_here.rotation);
        Self { mass: self.mass, center: to_from_here * self.center, matrix: r * self.matrix * r.transpose() }
    }

    /// Two bodies as one, both in the same frame.
    pub fn merged(&self, other: &Self) -> Self {
        let mass = self.mass + other.mass;
        if mass <= 0.0 {
            return Self { mass: 0.0, center: DVec3::ZERO, matrix: self.matrix + other.matrix };
        }
        let center = (self.center * self.mass + other.center * other.mass) / mass;
        let matrix = self.about(center) + other.about(center);
        Self { mass, center, matrix }
    }

    /// About another point.
    pub fn about(&self, point: DVec3) -> DMat3 {
        self.matrix + point_mass(self.mass, self.center - point)
    }

    /// The same form with all masses times a factor.
    pub fn scaled(&self, factor: f64) -> Self {
        Self { mass: self.mass * factor, center: self.center, matrix: self.matrix * factor }
    }

    /// Moments and `here_from_principal`.
    pub fn principal(&self) -> (DVec3, DQuat) {
        principal_axes(self.matrix)
    }

    /// The same body with other moments about the same principal axes.
    pub fn with_moments(&self, moments: DVec3, axes: DQuat) -> Self {
        let r = DMat3::from_quat(axes);
        Self { matrix: r * DMat3::from_diagonal(moments) * r.transpose(), ..*self }
    }
}

/// `m (|d|² 1 − d dᵀ)`.
fn point_mass(mass: f64, d: DVec3) -> DMat3 {
    let outer = DMat3::from_cols(d * d.x, d * d.y, d * d.z);
    (DMat3::from_diagonal(DVec3::splat(d.length_squared())) - outer) * mass
}

/// Eigenvalues and the rotation of the eigenvectors of a symmetric matrix: cyclic Jacobi rotations.
pub(crate) fn principal_axes(matrix: DMat3) -> (DVec3, DQuat) {
    let mut a = [matrix.x_axis.to_array(), matrix.y_axis.to_array(), matrix.z_axis.to_array()];
    let mut v = DMat3::IDENTITY;
    for _ in 0..32 {
        let off = a[0][1].abs() + a[0][2].abs() + a[1][2].abs();
        let scale = a[0][0].abs() + a[1][1].abs() + a[2][2].abs();
        if off <= 1e-15 * scale {
            break;
        }
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if a[p][q] == 0.0 {
                continue;
            }
            // tan of the angle that makes a[p][q] zero, the smaller of the two.
            let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let s = t * c;
            let mut columns = DMat3::IDENTITY.to_cols_array_2d();
            (columns[p][p], columns[p][q], columns[q][p], columns[q][q]) = (c, -s, s, c);
            let g = DMat3::from_cols_array_2d(&columns);
            let m = DMat3::from_cols_array_2d(&a);
            let mut rotated = (g.transpose() * m * g).to_cols_array_2d();
            (rotated[p][q], rotated[q][p]) = (0.0, 0.0);
            a = rotated;
            v *= g;
        }
    }
    let rotation = DQuat::from_mat3(&v).normalize();
    (DVec3::new(a[0][0], a[1][1], a[2][2]), rotation)
}

/// Of the solid forms the formats know, about their center, with density 1 kg/m³.
pub(crate) mod unit_density {
    use super::{DVec3, Inertia, PI};

    pub fn ball(r: f64) -> Inertia {
        let mass = 4.0 / 3.0 * PI * r.powi(3);
        Inertia::diagonal(mass, DVec3::splat(0.4 * mass * r * r))
    }

    /// By half edges.
    pub fn cuboid(half: DVec3) -> Inertia {
        let mass = 8.0 * half.x * half.y * half.z;
        let s = half * half;
        Inertia::diagonal(mass, DVec3::new(s.y + s.z, s.x + s.z, s.x + s.y) * (mass / 3.0))
    }

    /// By half axes.
    pub fn ellipsoid(half: DVec3) -> Inertia {
        let mass = 4.0 / 3.0 * PI * half.x * half.y * half.z;
        let s = half * half;
        Inertia::diagonal(mass, DVec3::new(s.y + s.z, s.x + s.z, s.x + s.y) * (mass / 5.0))
    }

    /// Along z.
    pub fn cylinder(half_height: f64, r: f64) -> Inertia {
        let mass = 2.0 * PI * r * r * half_height;
        let across = mass * (r * r / 4.0 + half_height * half_height / 3.0);
        Inertia::diagonal(mass, DVec3::new(across, across, 0.5 * mass * r * r))
    }

    /// Along z: a cylinder between two half balls.
    pub fn capsule(half_length: f64, r: f64) -> Inertia {
        let (middle, caps) = (cylinder(half_length, r), ball(r));
        // A half ball's center is 3r/8 from its flat side: its moments about the capsule's center, both halves together.
        let d = half_length + 0.375 * r;
        let about_own_center = 83.0 / 320.0 * caps.mass * r * r;
        let across = middle.matrix.x_axis.x + about_own_center + caps.mass * d * d;
        let along = middle.matrix.z_axis.z + caps.matrix.z_axis.z;
        Inertia::diagonal(middle.mass + caps.mass, DVec3::new(across, across, along))
    }
}

/// Of the solid inside a closed surface of triangles (counter-clockwise from outside), density 1 kg/m³.
///
/// Sum over tetrahedra from the origin, signed: `∫ x xᵀ dV = V/20 (Σ vᵢ vᵢᵀ + s sᵀ)` with s the sum of the three
/// vertices (the fourth is the origin).
pub(crate) fn of_surface(vertices: &[DVec3], triangles: &[[u32; 3]]) -> Inertia {
    let mut volume = 0.0;
    let mut first = DVec3::ZERO;
    let mut second = DMat3::ZERO;
    let outer = |v: DVec3| DMat3::from_cols(v * v.x, v * v.y, v * v.z);
    for triangle in triangles {
        let [a, b, c] = triangle.map(|i| vertices[i as usize]);
        let v = a.dot(b.cross(c)) / 6.0;
        let sum = a + b + c;
        volume += v;
        first += sum * (v / 4.0);
        second += (outer(a) + outer(b) + outer(c) + outer(sum)) * (v / 20.0);
    }
    if volume.abs() < 1e-300 {
        return Inertia::ZERO;
    }
    let center = first / volume;
    let covariance = second - outer(center) * volume;
    let trace = covariance.x_axis.x + covariance.y_axis.y + covariance.z_axis.z;
    Inertia { mass: volume, center, matrix: DMat3::from_diagonal(DVec3::splat(trace)) - covariance }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: DMat3, b: DMat3, tolerance: f64) -> bool {
        (a - b).to_cols_array().iter().all(|x| x.abs() < tolerance)
    }

    #[test]
    fn principal_axes_restore_the_matrix() {
        for seed in 0..50_u32 {
            let x = |k: u32| f64::from((seed * 7919 + k * 104_729) % 1000) / 500.0 - 1.0;
            let q = DQuat::from_xyzw(x(1), x(2), x(3), x(4) + 1e-3).normalize();
            let r = DMat3::from_quat(q);
            let m = r * DMat3::from_diagonal(DVec3::new(1.0, 1.0 + x(5).abs() * 1e-9, 3.0)) * r.transpose();
            let m = (m + m.transpose()) * 0.5;
            let (moments, axes) = principal_axes(m);
            let back = Inertia { mass: 1.0, center: DVec3::ZERO, matrix: m }.with_moments(moments, axes).matrix;
            assert!(close(back, m, 1e-12), "{m} {back}");
        }
    }

    #[test]
    fn capsule_is_the_limit_of_many_slices() {
        // Against a sum over thin disks: z from −(h+r) to h+r.
        let (h, r) = (0.3, 0.2);
        let n = 20_000;
        let dz = 2.0 * (h + r) / n as f64;
        let (mut mass, mut across, mut along) = (0.0, 0.0, 0.0);
        for i in 0..n {
            let z = -(h + r) + (i as f64 + 0.5) * dz;
            let beyond = (z.abs() - h).max(0.0);
            let s2 = r * r - beyond * beyond;
            let m = PI * s2 * dz;
            mass += m;
            along += 0.5 * m * s2;
            across += m * (0.25 * s2 + z * z);
        }
        let capsule = unit_density::capsule(h, r);
        assert!((capsule.mass - mass).abs() < 1e-7);
        assert!(close(capsule.matrix, DMat3::from_diagonal(DVec3::new(across, across, along)), 1e-7));
    }

    #[test]
    fn surface_of_a_shifted_box_has_the_inertia_of_the_box() {
        let half = DVec3::new(0.1, 0.2, 0.3);
        let shift = DVec3::new(1.0, -2.0, 0.5);
        let vertices: Vec<DVec3> = (0..8)
            .map(|i| {
                let sign = |bit: u32| if i & bit == 0 { -1.0 } else { 1.0 };
                shift + half * DVec3::new(sign(1), sign(2), sign(4))
            })
            .collect();
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
        let (solid, exact) = (of_surface(&vertices, &triangles), unit_density::cuboid(half));
        assert!((solid.mass - exact.mass).abs() < 1e-12);
        assert!((solid.center - shift).length() < 1e-12);
        assert!(close(solid.matrix, exact.matrix, 1e-12));
    }

    #[test]
    fn halves_merge_to_the_whole() {
        let half = unit_density::cuboid(DVec3::new(0.5, 0.25, 0.125));
        let at = |x: f64| half.transformed(DPose3::from_translation(DVec3::new(x, 0.0, 0.0)));
        let whole = unit_density::cuboid(DVec3::new(1.0, 0.25, 0.125));
        let merged = at(0.5).merged(&at(-0.5));
        assert!((merged.mass - whole.mass).abs() < 1e-12 && merged.center.length() < 1e-12);
        assert!(close(merged.matrix, whole.matrix, 1e-12));
    }
}
