//! Shapes as the meter sees them: parry's, in f64, with masses and overlaps.

use crate::scene::{Body, Form, Scene, Shape};
use anyhow::{Context, Result};
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::mass_properties::MassProperties;
use parry3d_f64::math::{Pose, Rotation, Vector};
use parry3d_f64::query;
use parry3d_f64::shape::SharedShape;

/// A shape that overlaps can be measured of.
#[derive(Clone)]
pub struct Solid {
    /// In its body's frame.
    pub local: Pose,
    kind: Kind,
}

#[derive(Clone)]
enum Kind {
    Convex(SharedShape),
    HalfSpace,
    Field { count: usize, heights: Vec<f64>, size: f64 },
}

impl Solid {
    /// The shape of a body of a scene.
    pub fn new(shape: &Shape, hulls: &[Vec<[f32; 3]>]) -> Result<Self> {
        let kind = match &shape.form {
            Form::HalfSpace => Kind::HalfSpace,
            Form::HeightField { count, heights, size } => {
                let heights = heights.iter().map(|&h| f64::from(h)).collect();
                Kind::Field { count: *count, heights, size: f64::from(*size) }
            }
            form => Kind::Convex(convex(form, hulls)?),
        };
        Ok(Self { local: pose(shape.position.map(f64::from), shape.rotation.map(f64::from)), kind })
    }

    /// World bounds of a convex shape; `None` for ground and terrain, which reach everywhere.
    pub fn bounds(&self, world_from_body: &Pose) -> Option<Aabb> {
        match &self.kind {
            Kind::Convex(shape) => Some(shape.compute_aabb(&(*world_from_body * self.local))),
            _ => None,
        }
    }

    /// How deep two shapes overlap, m; 0 if they do not.
    pub fn overlap(&self, pose_a: &Pose, other: &Self, pose_b: &Pose) -> f64 {
        let (world_from_a, world_from_b) = (*pose_a * self.local, *pose_b * other.local);
        match (&self.kind, &other.kind) {
            (Kind::Convex(a), Kind::Convex(b)) => {
                // Unsupported pairs do not exist among convex shapes.
                let contact = query::contact(&world_from_a, &**a, &world_from_b, &**b, 0.0).ok().flatten();
                contact.map_or(0.0, |c| (-c.dist).max(0.0))
            }
            (Kind::Convex(a), ground) => below(&(world_from_b.inverse() * world_from_a), a, ground),
            (ground, Kind::Convex(b)) => below(&(world_from_a.inverse() * world_from_b), b, ground),
            _ => 0.0,
        }
    }
}

/// How deep a convex shape is in ground or terrain, whose frame is given.
fn below(ground_from_shape: &Pose, shape: &SharedShape, ground: &Kind) -> f64 {
    match ground {
        Kind::Convex(_) => 0.0,
        Kind::HalfSpace => {
            let support = shape.as_support_map().map(|s| s.support_point(ground_from_shape, -Vector::Y));
            support.map_or(0.0, |p| (-p.y).max(0.0))
        }
        Kind::Field { count, heights, size } => {
            // Its lowest points against the terrain's triangles; a peak between the corners of a face is not seen.
            let points = corners(shape);
            let depths = points.iter().map(|&(p, radius)| {
                let p = ground_from_shape.transform_point(p);
                surface(*count, heights, *size, p).map_or(0.0, |(height, up)| (height - p.y) * up + radius)
            });
            depths.fold(0.0, f64::max)
        }
    }
}

/// Points, each with a radius, whose convex hull is the shape.
fn corners(shape: &SharedShape) -> Vec<(Vector, f64)> {
    if let Some(ball) = shape.as_ball() {
        vec![(Vector::ZERO, ball.radius)]
    } else if let Some(capsule) = shape.as_capsule() {
        vec![(capsule.segment.a, capsule.radius), (capsule.segment.b, capsule.radius)]
    } else if let Some(cuboid) = shape.as_cuboid() {
        let sign = |bit: u8, k: u8| if bit >> k & 1 == 0 { -1.0 } else { 1.0 };
        let all = (0..8_u8).map(|i| Vector::from([0, 1, 2].map(|k| sign(i, k))));
        all.map(|signs| (cuboid.half_extents * signs, 0.0)).collect()
    } else if let Some(hull) = shape.as_convex_polyhedron() {
        hull.points().iter().map(|&p| (p, 0.0)).collect()
    } else {
        Vec::new()
    }
}

/// Height of a terrain under a point and the upward part of its normal there; `None` beside the terrain.
///
/// Cells are cut by the diagonal from low x, high z to high x, low z or the other one, as each engine likes: the mean
/// of the two is right for both within the cell's own curvature.
fn surface(count: usize, heights: &[f64], size: f64, p: Vector) -> Option<(f64, f64)> {
    let cell = size / (count - 1) as f64;
    let (x, z) = ((p.x + 0.5 * size) / cell, (p.z + 0.5 * size) / cell);
    let inside = |v: f64| (0.0..(count - 1) as f64).contains(&v);
    if !inside(x) || !inside(z) {
        return None;
    }
    let (column, row) = (x.floor() as usize, z.floor() as usize);
    let (x, z) = (x.fract(), z.fract());
    let at = |r: usize, c: usize| heights[(row + r) * count + column + c];
    let (h00, h01, h10, h11) = (at(0, 0), at(0, 1), at(1, 0), at(1, 1));
    let height = (h00 * (1.0 - x) + h01 * x) * (1.0 - z) + (h10 * (1.0 - x) + h11 * x) * z;
    let slope_x = ((h01 - h00) * (1.0 - z) + (h11 - h10) * z) / cell;
    let slope_z = ((h10 - h00) * (1.0 - x) + (h11 - h01) * x) / cell;
    Some((height, 1.0 / (1.0 + slope_x * slope_x + slope_z * slope_z).sqrt()))
}

fn convex(form: &Form, hulls: &[Vec<[f32; 3]>]) -> Result<SharedShape> {
    Ok(match form {
        Form::Cuboid(half) => {
            let [x, y, z] = half.map(f64::from);
            SharedShape::cuboid(x, y, z)
        }
        Form::Ball(radius) => SharedShape::ball(f64::from(*radius)),
        Form::Capsule { half_length, radius } => SharedShape::capsule_y(f64::from(*half_length), f64::from(*radius)),
        Form::Hull(i) => {
            let points: Vec<Vector> = hulls[*i].iter().map(|p| p.map(f64::from).into()).collect();
            SharedShape::convex_hull(&points).context("the points of a hull span no volume")?
        }
        Form::HalfSpace | Form::HeightField { .. } => anyhow::bail!("ground and terrain are not convex"),
    })
}

/// A rigid transform.
pub fn pose(position: [f64; 3], rotation: [f64; 4]) -> Pose {
    Pose::from_parts(position.into(), Rotation::from_array(rotation))
}

/// Mass of a shape, kg; 0 for ground and terrain.
pub fn mass(shape: &Shape, hulls: &[Vec<[f32; 3]>]) -> f64 {
    convex(&shape.form, hulls).map_or(0.0, |s| s.mass_properties(f64::from(shape.density)).mass())
}

/// Mass, center and inertia of a body in its own frame.
pub fn mass_properties(body: &Body, scene: &Scene) -> MassProperties {
    let parts = body.shapes.iter().filter_map(|s| {
        let local = pose(s.position.map(f64::from), s.rotation.map(f64::from));
        Some(convex(&s.form, &scene.hulls).ok()?.mass_properties(f64::from(s.density)).transform_by(&local))
    });
    parts.fold(MassProperties::default(), |sum, part| sum + part)
}

/// The smallest edge of a body: the least side of a box or of a hull's bounds, a diameter; m.
pub fn smallest_edge(body: &Body, scene: &Scene) -> f64 {
    let edges = body.shapes.iter().map(|s| match &s.form {
        Form::Cuboid(half) => 2.0 * f64::from(half.iter().copied().fold(f32::INFINITY, f32::min)),
        Form::Ball(radius) | Form::Capsule { radius, .. } => 2.0 * f64::from(*radius),
        Form::Hull(_) => convex(&s.form, &scene.hulls).map_or(f64::INFINITY, |hull| {
            let extents = hull.compute_local_aabb().extents();
            extents.x.min(extents.y).min(extents.z)
        }),
        Form::HalfSpace | Form::HeightField { .. } => f64::INFINITY,
    });
    edges.fold(f64::INFINITY, f64::min)
}
