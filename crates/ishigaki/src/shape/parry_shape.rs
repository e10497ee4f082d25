//! What the broad phase and the queries need of a geometry: bounds, an inner ball, and its twin in parry.

use crate::math::{Mat3, Pose, Vec3};
use crate::shape::Geometry;
use parry3d::shape::{Ball, Capsule, Compound, Cone, Cuboid, Cylinder, HalfSpace, SharedShape};
use std::sync::Arc;

/// Half of the edge of the bounds of a half-space, m: beyond every scene, and its square is far from overflow.
const UNBOUNDED: f32 = 1.0e8;

impl Geometry {
    /// The least and the greatest corner of the box along the axes around the geometry at `pose`, m.
    ///
    /// A half-space is unbounded: its box reaches ±1e8 m.
    pub fn bounds(&self, pose: &Pose) -> (Vec3, Vec3) {
        let center = pose.translation;
        let around = |half: Vec3| (center - half, center + half);
        let axis = pose.rotation * Vec3::Y;
        match self {
            Self::Ball { radius } => around(Vec3::splat(*radius)),
            Self::Cuboid { half_extents } => around(turned_half(pose, *half_extents)),
            Self::Capsule { half_length, radius } => around(axis.abs() * *half_length + Vec3::splat(*radius)),
            Self::Cylinder { half_height, radius } => around(axis.abs() * *half_height + disk_half(axis, *radius)),
            Self::Cone { half_height, radius } => {
                let apex = center + axis * *half_height;
                let base = center - axis * *half_height;
                let half = disk_half(axis, *radius);
                (apex.min(base - half), apex.max(base + half))
            }
            Self::ConvexHull(hull) => {
                let turn = Mat3::from_quat(pose.rotation);
                let mut least = Vec3::INFINITY;
                let mut greatest = Vec3::NEG_INFINITY;
                for &vertex in hull.vertices() {
                    let vertex = turn * vertex;
                    least = least.min(vertex);
                    greatest = greatest.max(vertex);
                }
                (center + least, center + greatest)
            }
            Self::HalfSpace { .. } => (Vec3::splat(-UNBOUNDED), Vec3::splat(UNBOUNDED)),
            Self::TriangleMesh(mesh) => turned_box(pose, &mesh.mesh.local_aabb()),
            Self::HeightField(field) => turned_box(pose, &field.field.local_aabb()),
            Self::Compound(shapes) => {
                let mut least = Vec3::INFINITY;
                let mut greatest = Vec3::NEG_INFINITY;
                for shape in shapes {
                    let (low, high) = shape.geometry.bounds(&(*pose * shape.pose));
                    least = least.min(low);
                    greatest = greatest.max(high);
                }
                (least, greatest)
            }
        }
    }

    /// Radius of a ball that lies inside the geometry, m; 0 for surfaces.
    ///
    /// A body that moves less than this in a step cannot pass through a thin wall unseen.
    pub fn inner_radius(&self) -> f32 {
        match self {
            Self::Ball { radius } | Self::Capsule { radius, .. } => *radius,
            Self::Cuboid { half_extents } => half_extents.min_element(),
            Self::Cylinder { half_height, radius } => half_height.min(*radius),
            Self::Cone { half_height, radius } => {
                // The circle in the triangle of half base r and height H: r H / (r + √(r² + H²)).
                let height = 2.0 * half_height;
                radius * height / (radius + (radius * radius + height * height).sqrt())
            }
            Self::ConvexHull(hull) => hull.inner_radius(),
            Self::HalfSpace { .. } => UNBOUNDED,
            Self::TriangleMesh(_) | Self::HeightField(_) => 0.0,
            Self::Compound(shapes) => shapes.iter().map(|s| s.geometry.inner_radius()).fold(0.0, f32::max),
        }
    }

    /// Radius of a ball about the origin that contains the geometry, m; far too much for surfaces and compounds.
    pub(crate) fn outer_radius(&self) -> f32 {
        match self {
            Self::Ball { radius } => *radius,
            Self::Capsule { half_length, radius } => half_length + radius,
            Self::Cuboid { half_extents } => half_extents.length(),
            Self::Cylinder { half_height, radius } | Self::Cone { half_height, radius } => {
                (half_height * half_height + radius * radius).sqrt()
            }
            Self::ConvexHull(hull) => hull.topology.outer_radius,
            Self::HalfSpace { .. } | Self::TriangleMesh(_) | Self::HeightField(_) | Self::Compound(_) => UNBOUNDED,
        }
    }

    /// The same geometry in parry, for ray casts, shape casts and distances.
    ///
    /// Hulls, meshes and height fields are shared, not copied. A compound of compounds is laid out flat;
    /// `None` where parry cannot hold it: a compound with a surface or a half-space in it.
    pub fn to_parry(&self) -> Option<SharedShape> {
        Some(match self {
            Self::Ball { radius } => SharedShape::new(Ball::new(*radius)),
            Self::Cuboid { half_extents } => SharedShape::new(Cuboid::new(*half_extents)),
            Self::Capsule { half_length, radius } => SharedShape::new(Capsule::new_y(*half_length, *radius)),
            Self::Cylinder { half_height, radius } => SharedShape::new(Cylinder::new(*half_height, *radius)),
            Self::Cone { half_height, radius } => SharedShape::new(Cone::new(*half_height, *radius)),
            Self::ConvexHull(hull) => SharedShape(hull.polyhedron.clone()),
            Self::HalfSpace { normal } => SharedShape::new(HalfSpace::new(*normal)),
            Self::TriangleMesh(mesh) => SharedShape(mesh.mesh.clone()),
            Self::HeightField(field) => SharedShape(field.field.clone()),
            Self::Compound(_) => {
                let mut parts = Vec::new();
                self.collect_parts(&Pose::IDENTITY, &mut parts)?;
                SharedShape(Arc::new(Compound::new(parts)))
            }
        })
    }

    fn collect_parts(&self, pose: &Pose, parts: &mut Vec<(Pose, SharedShape)>) -> Option<()> {
        match self {
            Self::Compound(shapes) => {
                shapes.iter().try_for_each(|shape| shape.geometry.collect_parts(&(*pose * shape.pose), parts))
            }
            _ if self.is_solid() => {
                parts.push((*pose, self.to_parry()?));
                Some(())
            }
            _ => None,
        }
    }
}

/// Half of the box around a disk: r √(1 − aᵢ²) along axis i for a disk about the unit axis a.
fn disk_half(axis: Vec3, radius: f32) -> Vec3 {
    let square = (Vec3::ONE - axis * axis).max(Vec3::ZERO);
    radius * Vec3::new(square.x.sqrt(), square.y.sqrt(), square.z.sqrt())
}

/// |R| h: half of the box around a turned box.
fn turned_half(pose: &Pose, half: Vec3) -> Vec3 {
    let turn = Mat3::from_quat(pose.rotation);
    turn.x_axis.abs() * half.x + turn.y_axis.abs() * half.y + turn.z_axis.abs() * half.z
}

fn turned_box(pose: &Pose, bounds: &parry3d::bounding_volume::Aabb) -> (Vec3, Vec3) {
    let center = *pose * (0.5 * (bounds.mins + bounds.maxs));
    let half = turned_half(pose, 0.5 * (bounds.maxs - bounds.mins));
    (center - half, center + half)
}
