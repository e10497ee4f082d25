//! Shapes: geometry, place on the body, material, filters.

use crate::error::{Error, Result, direction, finite, finite_vector, not_negative, positive};
use crate::math::{Pose, Vec3};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

mod height_field;
pub(crate) mod hull;
mod parry_shape;
mod triangle_mesh;

pub use height_field::HeightField;
pub use hull::ConvexHull;
pub use triangle_mesh::TriangleMesh;

/// The form of a shape in its own frame; lengths in m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Geometry {
    /// A ball about the origin.
    Ball {
        /// m.
        radius: f32,
    },
    /// A box about the origin, its edges along the axes.
    Cuboid {
        /// Half of each edge, m.
        half_extents: Vec3,
    },
    /// All points within `radius` of a segment along Y.
    Capsule {
        /// Half of the segment, m: the whole length is 2 (half_length + radius).
        half_length: f32,
        /// m.
        radius: f32,
    },
    /// A cylinder about the Y axis, its center at the origin.
    Cylinder {
        /// m.
        half_height: f32,
        /// m.
        radius: f32,
    },
    /// A cone about the Y axis, apex at +half_height, base at −half_height.
    Cone {
        /// m.
        half_height: f32,
        /// Of the base, m.
        radius: f32,
    },
    /// The convex hull of points.
    ConvexHull(Arc<ConvexHull>),
    /// All points with `normal·x ≤ 0`: never dynamic.
    HalfSpace {
        /// Unit, outward.
        normal: Vec3,
    },
    /// A surface of triangles: never dynamic.
    TriangleMesh(Arc<TriangleMesh>),
    /// A terrain: never dynamic.
    HeightField(Arc<HeightField>),
    /// Several shapes that move as one; laid out into single shapes when the body is added.
    Compound(Vec<Shape>),
}

/// How the materials of two touching shapes make one number. Where the two differ, the later in this list wins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Combine {
    /// (a + b) / 2.
    Average,
    /// √(ab).
    #[default]
    GeometricMean,
    /// The smaller.
    Minimum,
    /// a b.
    Multiply,
    /// The greater.
    Maximum,
}

impl Combine {
    /// The number of the pair.
    pub fn mix(self, other: Self, a: f32, b: f32) -> f32 {
        match self.max(other) {
            Self::Average => 0.5 * (a + b),
            Self::GeometricMean => (a * b).sqrt(),
            Self::Minimum => a.min(b),
            Self::Multiply => a * b,
            Self::Maximum => a.max(b),
        }
    }
}

/// What a surface does on contact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Material {
    /// Coulomb's μ, ≥ 0.
    pub friction: f32,
    /// How two μ combine.
    pub friction_combine: Combine,
    /// Newton's e in [0, 1].
    pub restitution: f32,
    /// How two e combine.
    pub restitution_combine: Combine,
    /// Torque against spin about the normal: μ_torsion × normal force, m.
    pub torsional_friction: f32,
    /// Torque against rolling: μ_roll × normal force, m.
    pub rolling_friction: f32,
    /// Velocity of the surface relative to the body (a conveyor), m/s, in the body's frame.
    pub surface_velocity: Vec3,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            friction: 0.6,
            friction_combine: Combine::GeometricMean,
            restitution: 0.0,
            restitution_combine: Combine::Maximum,
            torsional_friction: 0.0,
            rolling_friction: 0.0,
            surface_velocity: Vec3::ZERO,
        }
    }
}

/// Which shapes may touch: each must be in a group that the other's mask names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Groups {
    /// Bits of the groups this shape is in.
    pub member_of: u32,
    /// Bits of the groups this shape touches.
    pub collides_with: u32,
}

impl Default for Groups {
    fn default() -> Self {
        Self { member_of: 1, collides_with: u32::MAX }
    }
}

impl Groups {
    /// In no group, and touching none.
    pub(crate) const NONE: Self = Self { member_of: 0, collides_with: 0 };

    /// Of several shapes together: what none of them may touch.
    pub(crate) fn and(self, other: Self) -> Self {
        Self { member_of: self.member_of | other.member_of, collides_with: self.collides_with | other.collides_with }
    }

    /// Whether two shapes may touch.
    pub fn allow(self, other: Self) -> bool {
        self.member_of & other.collides_with != 0 && other.member_of & self.collides_with != 0
    }
}

/// A shape of a body.
///
/// ```
/// use ishigaki::{Shape, Vec3};
/// let lid = Shape::cuboid(0.5, 0.05, 0.5).at(Vec3::new(0.0, 1.0, 0.0)).friction(0.3).density(700.0);
/// assert_eq!(lid.material.friction, 0.3);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shape {
    /// Form.
    pub geometry: Geometry,
    /// Place in the body's frame.
    pub pose: Pose,
    /// kg/m³.
    pub density: f32,
    /// Friction, restitution …
    pub material: Material,
    /// Which shapes it may touch.
    pub groups: Groups,
    /// Reports overlaps, makes no contact, has no mass.
    pub sensor: bool,
}

impl Shape {
    /// A shape at the body's origin with default material, 1000 kg/m³.
    pub fn new(geometry: Geometry) -> Self {
        Self {
            geometry,
            pose: Pose::IDENTITY,
            density: 1000.0,
            material: Material::default(),
            groups: Groups::default(),
            sensor: false,
        }
    }

    /// A ball, m.
    pub fn ball(radius: f32) -> Self {
        Self::new(Geometry::Ball { radius })
    }

    /// A box by half edges, m.
    pub fn cuboid(half_x: f32, half_y: f32, half_z: f32) -> Self {
        Self::new(Geometry::Cuboid { half_extents: Vec3::new(half_x, half_y, half_z) })
    }

    /// A capsule along Y, m.
    pub fn capsule(half_length: f32, radius: f32) -> Self {
        Self::new(Geometry::Capsule { half_length, radius })
    }

    /// A capsule between two points of the body's frame, m.
    pub fn capsule_between(start: Vec3, end: Vec3, radius: f32) -> Self {
        let along = end - start;
        let rotation = crate::math::Quat::from_rotation_arc(Vec3::Y, along.try_normalize().unwrap_or(Vec3::Y));
        Self::capsule(0.5 * along.length(), radius).posed(Pose::from_parts(0.5 * (start + end), rotation))
    }

    /// A cylinder about Y, m.
    pub fn cylinder(half_height: f32, radius: f32) -> Self {
        Self::new(Geometry::Cylinder { half_height, radius })
    }

    /// A cone about Y, apex up, m.
    pub fn cone(half_height: f32, radius: f32) -> Self {
        Self::new(Geometry::Cone { half_height, radius })
    }

    /// All that lies below the plane through the origin with this outward normal.
    pub fn half_space(normal: Vec3) -> Self {
        Self::new(Geometry::HalfSpace { normal })
    }

    /// The convex hull of points, m.
    ///
    /// # Errors
    /// Fewer than four points, not finite, or all in one plane.
    pub fn convex_hull(points: &[Vec3]) -> Result<Self> {
        Ok(Self::new(Geometry::ConvexHull(Arc::new(ConvexHull::new(points)?))))
    }

    /// A surface of triangles, m; counter-clockwise seen from outside.
    ///
    /// # Errors
    /// No triangle, an index out of range, a vertex that is not finite.
    pub fn triangle_mesh(vertices: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Result<Self> {
        Ok(Self::new(Geometry::TriangleMesh(Arc::new(TriangleMesh::new(vertices, triangles)?))))
    }

    /// A terrain: `heights[row][column]` flattened row by row, rows along Z, columns along X, centered; m.
    ///
    /// # Errors
    /// Fewer than two rows or columns, a length that does not match, a height that is not finite, a size ≤ 0.
    pub fn height_field(rows: usize, columns: usize, heights: Vec<f32>, size_x: f32, size_z: f32) -> Result<Self> {
        Ok(Self::new(Geometry::HeightField(Arc::new(HeightField::new(rows, columns, heights, size_x, size_z)?))))
    }

    /// Several shapes that move as one.
    pub fn compound(shapes: Vec<Shape>) -> Self {
        Self::new(Geometry::Compound(shapes))
    }

    /// Moves the shape on its body, m.
    #[must_use]
    pub fn at(mut self, translation: Vec3) -> Self {
        self.pose.translation = translation;
        self
    }

    /// Places the shape on its body.
    #[must_use]
    pub fn posed(mut self, pose: Pose) -> Self {
        self.pose = pose;
        self
    }

    /// kg/m³.
    #[must_use]
    pub fn density(mut self, density: f32) -> Self {
        self.density = density;
        self
    }

    /// Coulomb's μ.
    #[must_use]
    pub fn friction(mut self, friction: f32) -> Self {
        self.material.friction = friction;
        self
    }

    /// Newton's e.
    #[must_use]
    pub fn restitution(mut self, restitution: f32) -> Self {
        self.material.restitution = restitution;
        self
    }

    /// The whole material.
    #[must_use]
    pub fn material(mut self, material: Material) -> Self {
        self.material = material;
        self
    }

    /// Which shapes it may touch.
    #[must_use]
    pub fn groups(mut self, member_of: u32, collides_with: u32) -> Self {
        self.groups = Groups { member_of, collides_with };
        self
    }

    /// Reports overlaps, makes no contact, has no mass.
    #[must_use]
    pub fn sensor(mut self) -> Self {
        self.sensor = true;
        self
    }

    /// Refuses numbers that make no sense; names the field.
    ///
    /// # Errors
    /// The first field that is not finite or out of its range.
    pub fn validate(&self) -> Result<()> {
        self.geometry.validate()?;
        within_reach(self.pose.translation, || "position".into())?;
        let length = self.pose.rotation.length();
        if !(length.is_finite() && (length - 1.0).abs() < 1e-3) {
            return Err(Error::invalid("rotation", format!("must be a unit quaternion, has length {length}")));
        }
        not_negative("density", self.density)?;
        self.material.validate()
    }
}

impl Material {
    pub(crate) fn validate(&self) -> Result<()> {
        not_negative("friction", self.friction)?;
        not_negative("torsional_friction", self.torsional_friction)?;
        not_negative("rolling_friction", self.rolling_friction)?;
        finite_vector("surface_velocity", self.surface_velocity)?;
        if (0.0..=1.0).contains(&self.restitution) {
            Ok(())
        } else {
            Err(Error::invalid("restitution", format!("must be in [0, 1], is {}", self.restitution)))
        }
    }
}

/// Larger than any scene in f32 can use: beyond it distances lose millimeters and products overflow.
pub(crate) const HUGE_LENGTH: f32 = 1.0e6;

/// Refuses points that are not finite or too far out; `place` is made only then.
pub(crate) fn within_reach(point: Vec3, place: impl FnOnce() -> String) -> Result<()> {
    if point.is_finite() && point.abs().max_element() <= HUGE_LENGTH {
        Ok(())
    } else {
        Err(Error::invalid(place(), format!("must be finite and within {HUGE_LENGTH} m of the origin")))
    }
}

/// Refuses lengths that are not > 0 or too large.
pub(crate) fn extent(place: &str, value: f32) -> Result<()> {
    positive(place, value)?;
    if value > HUGE_LENGTH {
        return Err(Error::invalid(place, format!("must be at most {HUGE_LENGTH} m, is {value}")));
    }
    Ok(())
}

impl Geometry {
    pub(crate) fn validate(&self) -> Result<()> {
        match self {
            Self::Ball { radius } => extent("radius", *radius),
            Self::Cuboid { half_extents } => {
                extent("half_extents[0]", half_extents.x)?;
                extent("half_extents[1]", half_extents.y)?;
                extent("half_extents[2]", half_extents.z)
            }
            Self::Capsule { half_length, radius } => {
                finite("half_length", *half_length)?;
                if *half_length < 0.0 || *half_length > HUGE_LENGTH {
                    return Err(Error::invalid(
                        "half_length",
                        format!("must be in [0, {HUGE_LENGTH}] m, is {half_length}"),
                    ));
                }
                extent("radius", *radius)
            }
            Self::Cylinder { half_height, radius } | Self::Cone { half_height, radius } => {
                extent("half_height", *half_height)?;
                extent("radius", *radius)
            }
            Self::HalfSpace { normal } => {
                let unit = direction("normal", *normal)?;
                if (unit - *normal).length() > 1e-3 {
                    return Err(Error::invalid(
                        "normal",
                        format!("must be a unit vector, has length {}", normal.length()),
                    ));
                }
                Ok(())
            }
            Self::Compound(shapes) => {
                if shapes.is_empty() {
                    return Err(Error::invalid("shapes", "a compound needs at least one shape"));
                }
                for (i, shape) in shapes.iter().enumerate() {
                    shape.validate().map_err(|e| e.within(&format!("shapes[{i}]")))?;
                }
                Ok(())
            }
            Self::ConvexHull(_) | Self::TriangleMesh(_) | Self::HeightField(_) => Ok(()),
        }
    }

    /// Whether it has a volume, and so may be dynamic.
    pub fn is_solid(&self) -> bool {
        match self {
            Self::HalfSpace { .. } | Self::TriangleMesh(_) | Self::HeightField(_) => false,
            Self::Compound(shapes) => shapes.iter().all(|s| s.geometry.is_solid()),
            _ => true,
        }
    }
}
