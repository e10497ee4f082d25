//! Mass, center and inertia of shapes and bodies. TALK A4.
//!
//! Each shape is a volume integral in its own frame: V = ∫dV, c = ∫x dV / V, I = ∫(x·x 1 − xxᵀ) dV about c,
//! closed for round shapes, a sum over tetrahedra for hulls. Densities scale it, the shape's pose turns it
//! (I = R I' Rᵀ), the parallel axis law (I += m (d·d 1 − ddᵀ)) carries it to the common center, and Jacobi
//! rotations find the principal axes. All in f64, rounded once at the end. Where shapes overlap, mass counts
//! twice. The test that proves it: `mass_laws`.

use crate::error::{Error, Result, finite_vector, positive};
use crate::math::{Mat3, Quat, Vec3, rotated_diagonal};
use crate::shape::{ConvexHull, Geometry, Shape};
use glam::{DMat3, DQuat, DVec3};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Mass, center of mass and inertia about it, in the body's frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MassProperties {
    /// kg.
    pub mass: f32,
    /// Center of mass, m.
    pub center: Vec3,
    /// About the principal axes through the center, kg·m².
    pub principal_inertia: Vec3,
    /// local_from_principal: the principal axes in the body's frame.
    pub principal_frame: Quat,
}

impl MassProperties {
    /// No mass at all: of a body without shapes, or with sensors only.
    pub const ZERO: Self =
        Self { mass: 0.0, center: Vec3::ZERO, principal_inertia: Vec3::ZERO, principal_frame: Quat::IDENTITY };

    /// Of several shapes with their densities. Sensors, shapes of density 0 and shapes without volume
    /// (half-space, triangle mesh, height field) contribute nothing; [`MassProperties::ZERO`] if nothing is left.
    ///
    /// ```
    /// use ishigaki::{MassProperties, Shape, Vec3};
    /// // Twice the unit cube, side by side along x.
    /// let cube = Shape::cuboid(0.5, 0.5, 0.5).density(600.0);
    /// let pair = MassProperties::of_shapes(&[cube.clone(), cube.at(Vec3::X)]);
    /// assert_eq!((pair.mass, pair.center), (1200.0, Vec3::new(0.5, 0.0, 0.0)));
    /// assert_eq!(pair.principal_inertia, 100.0 * Vec3::new(1.0 + 1.0, 4.0 + 1.0, 4.0 + 1.0));
    /// ```
    pub fn of_shapes(shapes: &[Shape]) -> Self {
        let mut parts = Vec::with_capacity(shapes.len());
        for shape in shapes {
            collect(shape, DMat3::IDENTITY, DVec3::ZERO, &mut parts);
        }
        let mass: f64 = parts.iter().map(|p| p.volume).sum();
        if mass <= 0.0 {
            return Self::ZERO;
        }
        let center = parts.iter().map(|p| p.center * p.volume).sum::<DVec3>() / mass;
        let mut inertia = DMat3::ZERO;
        for part in &parts {
            inertia += part.inertia + parallel_axis(part.volume, part.center - center);
        }
        Self::from_f64(mass, center, inertia)
    }

    /// From the inertia matrix about the center, in the body's frame, kg·m².
    ///
    /// # Errors
    /// A matrix that is not symmetric, or what [`validate`](Self::validate) refuses.
    pub fn from_matrix(mass: f32, center: Vec3, inertia: Mat3) -> Result<Self> {
        let greatest = inertia.to_cols_array().iter().fold(0.0_f32, |m, x| m.max(x.abs()));
        let skew = inertia - inertia.transpose();
        if !skew.to_cols_array().iter().all(|x| x.abs() <= 1e-3 * greatest) {
            return Err(Error::invalid("inertia", "must be a symmetric matrix"));
        }
        let symmetric = 0.5 * (inertia.as_dmat3() + inertia.transpose().as_dmat3());
        let properties = Self::from_f64(f64::from(mass), center.as_dvec3(), symmetric);
        properties.validate()?;
        Ok(properties)
    }

    /// The inertia about the center in the body's frame, kg·m².
    pub fn matrix(&self) -> Mat3 {
        rotated_diagonal(self.principal_frame, self.principal_inertia)
    }

    fn from_f64(mass: f64, center: DVec3, inertia: DMat3) -> Self {
        let (moments, frame) = principal_axes(inertia);
        Self {
            mass: mass as f32,
            center: center.as_vec3(),
            principal_inertia: moments.as_vec3(),
            principal_frame: frame.as_quat(),
        }
    }

    /// The same body with another mass: the inertia scales along.
    #[must_use]
    pub fn with_mass(self, mass: f32) -> Self {
        let scale = if self.mass > 0.0 { mass / self.mass } else { 0.0 };
        Self { mass, principal_inertia: self.principal_inertia * scale, ..self }
    }

    /// Refuses numbers that make no sense; names the field.
    ///
    /// # Errors
    /// A mass or inertia ≤ 0 or not finite, an inertia that breaks the triangle inequality, a frame that is not a rotation.
    pub fn validate(&self) -> Result<()> {
        positive("mass", self.mass)?;
        finite_vector("center", self.center)?;
        let i = self.principal_inertia;
        positive("principal_inertia[0]", i.x)?;
        positive("principal_inertia[1]", i.y)?;
        positive("principal_inertia[2]", i.z)?;
        let greatest = i.max_element();
        // Models are rounded to few digits: allow one percent.
        if 2.0 * greatest > 1.01 * (i.x + i.y + i.z) {
            let message = format!(
                "no body has the moments ({}, {}, {}): one is greater than the sum of the others",
                i.x, i.y, i.z
            );
            return Err(Error::invalid("principal_inertia", message));
        }
        let length = self.principal_frame.length();
        if !(length.is_finite() && (length - 1.0).abs() < 1e-3) {
            return Err(Error::invalid("principal_frame", format!("must be a unit quaternion, has length {length}")));
        }
        Ok(())
    }
}

/// Volume, centroid and inertia about the centroid. With density 1 the volume is the mass.
struct Solid {
    volume: f64,
    center: DVec3,
    inertia: DMat3,
}

/// Appends the masses of a shape (of its children if it is a compound), in the frame given by R and t.
fn collect(shape: &Shape, rotation: DMat3, translation: DVec3, out: &mut Vec<Solid>) {
    if shape.sensor {
        return;
    }
    // Poses come as f32: a quaternion off unit length by 1e-7 would scale the shape by as much.
    let r = rotation * DMat3::from_quat(shape.pose.rotation.as_dquat().normalize());
    let t = translation + rotation * shape.pose.translation.as_dvec3();
    if let Geometry::Compound(children) = &shape.geometry {
        for child in children {
            collect(child, r, t, out);
        }
    } else if let Some(solid) = solid(&shape.geometry)
        && shape.density > 0.0
    {
        let density = f64::from(shape.density);
        out.push(Solid {
            volume: density * solid.volume,
            center: t + r * solid.center,
            inertia: density * (r * solid.inertia * r.transpose()),
        });
    }
}

/// The volume integrals of a shape in its own frame; `None` if it has no volume.
fn solid(geometry: &Geometry) -> Option<Solid> {
    let about_origin =
        |volume, moments| Some(Solid { volume, center: DVec3::ZERO, inertia: DMat3::from_diagonal(moments) });
    match geometry {
        Geometry::Ball { radius } => {
            let r = f64::from(*radius);
            let volume = 4.0 / 3.0 * PI * r.powi(3);
            about_origin(volume, DVec3::splat(0.4 * volume * r * r))
        }
        Geometry::Cuboid { half_extents } => {
            let h = half_extents.as_dvec3();
            let volume = 8.0 * h.x * h.y * h.z;
            let square = h * h;
            about_origin(volume, volume / 3.0 * (DVec3::splat(square.element_sum()) - square))
        }
        Geometry::Capsule { half_length, radius } => {
            let (h, r) = (f64::from(*half_length), f64::from(*radius));
            let cylinder = cylinder_moments(h, r);
            let caps = 4.0 / 3.0 * PI * r.powi(3);
            // A half ball's centroid is 3r/8 from its flat side, about which it has 83/320 m r².
            let across = caps * (83.0 / 320.0 * r * r + (h + 0.375 * r).powi(2));
            let moments = cylinder.1 + DVec3::new(across, 0.4 * caps * r * r, across);
            about_origin(cylinder.0 + caps, moments)
        }
        Geometry::Cylinder { half_height, radius } => {
            let (volume, moments) = cylinder_moments(f64::from(*half_height), f64::from(*radius));
            about_origin(volume, moments)
        }
        Geometry::Cone { half_height, radius } => {
            let (height, r) = (2.0 * f64::from(*half_height), f64::from(*radius));
            let volume = PI * r * r * height / 3.0;
            let across = volume * (0.15 * r * r + 3.0 / 80.0 * height * height);
            Some(Solid {
                volume,
                // A quarter of the height above the base.
                center: DVec3::new(0.0, -0.25 * height, 0.0),
                inertia: DMat3::from_diagonal(DVec3::new(across, 0.3 * volume * r * r, across)),
            })
        }
        Geometry::ConvexHull(hull) => Some(hull_solid(hull)),
        Geometry::HalfSpace { .. } | Geometry::TriangleMesh(_) | Geometry::HeightField(_) | Geometry::Compound(_) => {
            None
        }
    }
}

/// Volume and moments of a cylinder about Y.
fn cylinder_moments(half_height: f64, r: f64) -> (f64, DVec3) {
    let height = 2.0 * half_height;
    let volume = PI * r * r * height;
    let across = volume * (3.0 * r * r + height * height) / 12.0;
    (volume, DVec3::new(across, 0.5 * volume * r * r, across))
}

/// Sums the tetrahedra between a corner and all surface triangles.
///
/// A tetrahedron (0, a, b, c) with d = a·(b×c) has ∫dV = d/6, ∫x dV = d/24 s and
/// ∫xxᵀdV = d/120 (aaᵀ + bbᵀ + ccᵀ + ssᵀ), s = a + b + c.
fn hull_solid(hull: &ConvexHull) -> Solid {
    let (points, triangles) = hull.polyhedron.to_trimesh();
    // From a corner of the hull, not from the frame's origin: a hull far from it loses no digits.
    let origin = points[0].as_dvec3();
    let (mut volume, mut first, mut second) = (0.0, DVec3::ZERO, DMat3::ZERO);
    for triangle in triangles {
        let [a, b, c] = triangle.map(|i| points[i as usize].as_dvec3() - origin);
        let d = a.dot(b.cross(c));
        let s = a + b + c;
        volume += d / 6.0;
        first += d / 24.0 * s;
        second += d / 120.0 * (outer(a) + outer(b) + outer(c) + outer(s));
    }
    let center = first / volume;
    let covariance = second - volume * outer(center);
    let trace = covariance.x_axis.x + covariance.y_axis.y + covariance.z_axis.z;
    Solid { volume, center: origin + center, inertia: DMat3::from_diagonal(DVec3::splat(trace)) - covariance }
}

/// vvᵀ.
fn outer(v: DVec3) -> DMat3 {
    DMat3::from_cols(v * v.x, v * v.y, v * v.z)
}

// ANCHOR: parallel_axis
/// m (d·d 1 − ddᵀ): what a mass adds to the inertia about a point at −d from its center.
fn parallel_axis(mass: f64, d: DVec3) -> DMat3 {
    mass * (DMat3::from_diagonal(DVec3::splat(d.length_squared())) - outer(d))
}
// ANCHOR_END: parallel_axis

/// Moments and axes (I = Q diag(moments) Qᵀ) of a symmetric matrix by cyclic Jacobi rotations.
///
/// Each rotation is the smaller of the two that clear an element (≤ 45°), so the axes stay near those of the
/// matrix: no sorting, no sign choice, a matrix that is diagonal but for f32 rounding keeps the identity.
fn principal_axes(mut a: DMat3) -> (DVec3, DQuat) {
    let scale = a.to_cols_array().iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let off = |a: &DMat3| a.x_axis.y.abs().max(a.x_axis.z.abs()).max(a.y_axis.z.abs());
    let mut q = DMat3::IDENTITY;
    // Below the rounding of an f32 pose an off-diagonal element means nothing.
    if off(&a) > 1e-6 * scale {
        // Converges quadratically: six sweeps reach f64 rounding; NaN just runs through.
        for _ in 0..12 {
            for (i, j) in [(0, 1), (0, 2), (1, 2)] {
                let rotation = jacobi_rotation(&a, i, j);
                a = rotation.transpose() * a * rotation;
                q *= rotation;
            }
            if off(&a) <= 1e-15 * scale {
                break;
            }
        }
    }
    let moments = DVec3::new(a.x_axis.x, a.y_axis.y, a.z_axis.z);
    let frame = DQuat::from_mat3(&q).normalize();
    (moments, if frame.w < 0.0 { -frame } else { frame })
}

/// The rotation in the plane of axes i and j that makes a_ij zero: t = tan θ solves t² + 2τt − 1 = 0,
/// τ = (a_jj − a_ii) / 2a_ij.
fn jacobi_rotation(a: &DMat3, i: usize, j: usize) -> DMat3 {
    let off = a.col(j)[i];
    let mut rotation = DMat3::IDENTITY;
    if off != 0.0 {
        let tau: f64 = (a.col(j)[j] - a.col(i)[i]) / (2.0 * off);
        let t: f64 = if tau >= 0.0 { 1.0 } else { -1.0 } / (tau.abs() + (1.0 + tau * tau).sqrt());
        let cosine = 1.0 / (1.0 + t * t).sqrt();
        let sine = t * cosine;
        rotation.col_mut(i)[i] = cosine;
        rotation.col_mut(j)[j] = cosine;
        rotation.col_mut(j)[i] = sine;
        rotation.col_mut(i)[j] = -sine;
    }
    rotation
}
