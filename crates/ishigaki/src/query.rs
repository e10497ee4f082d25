//! Questions to a world between steps: rays, moving shapes, overlaps, closest points.
//!
//! Queries change nothing and see the bodies where the last step or edit left them. A [`QueryFilter`] says which
//! shapes count. Where two shapes are equally near the lesser [`ShapeId`] wins, and lists come in a fixed order:
//! no answer depends on the form of the broad phase's tree. A question that makes no sense (a number that is not
//! finite, a direction of zero length, a negative distance) finds nothing.
//!
//! The broad phase gives a lower bound for each box and the nearest boxes first; parry answers for single shapes.
//! Proved by `tests/queries.rs`: against closed forms and against asking every shape.

use crate::body::{BodyKind, BodyState, ShapeId, ShapeState};
use crate::handle::BodyHandle;
use crate::math::{Pose, Vec3};
use crate::shape::{Geometry, Groups, Shape};
use crate::world::World;
use parry3d::query::{self, Ray, ShapeCastOptions};
use parry3d::shape::{Ball, Capsule, Cone, Cuboid, Cylinder, HalfSpace, Shape as ParryShape};
use std::fmt;

/// Decides whether a query sees a shape.
pub type Predicate<'a> = &'a dyn Fn(ShapeId, &Shape) -> bool;

/// Which shapes a query sees. The default sees all but sensors.
///
/// ```
/// use ishigaki::QueryFilter;
/// let far_from_me = |shape: ishigaki::ShapeId, _: &ishigaki::Shape| shape.ordinal == 0;
/// let filter = QueryFilter::new().only_dynamic().predicate(&far_from_me);
/// assert!(!filter.fixed && filter.dynamic && !filter.sensors);
/// ```
#[derive(Clone, Copy)]
pub struct QueryFilter<'a> {
    /// The query's own groups: it sees a shape if each is in a group that the other's mask names.
    pub groups: Groups,
    /// A body that is not seen: often the one that asks.
    pub excluded: Option<BodyHandle>,
    /// Sees sensors too.
    pub sensors: bool,
    /// Sees fixed bodies.
    pub fixed: bool,
    /// Sees kinematic bodies.
    pub kinematic: bool,
    /// Sees dynamic bodies.
    pub dynamic: bool,
    /// Sees only what this returns `true` for; asked last.
    pub predicate: Option<Predicate<'a>>,
}

impl Default for QueryFilter<'_> {
    fn default() -> Self {
        Self {
            groups: Groups { member_of: u32::MAX, collides_with: u32::MAX },
            excluded: None,
            sensors: false,
            fixed: true,
            kinematic: true,
            dynamic: true,
            predicate: None,
        }
    }
}

impl fmt::Debug for QueryFilter<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("QueryFilter")
            .field("groups", &self.groups)
            .field("excluded", &self.excluded)
            .field("sensors", &self.sensors)
            .field("fixed", &self.fixed)
            .field("kinematic", &self.kinematic)
            .field("dynamic", &self.dynamic)
            .field("predicate", &self.predicate.map(|_| "Fn"))
            .finish()
    }
}

impl<'a> QueryFilter<'a> {
    /// Sees all but sensors.
    pub fn new() -> Self {
        Self::default()
    }

    /// Bits of the groups the query is in, and of those it sees.
    #[must_use]
    pub fn groups(mut self, member_of: u32, collides_with: u32) -> Self {
        self.groups = Groups { member_of, collides_with };
        self
    }

    /// Does not see this body.
    #[must_use]
    pub fn excluding(mut self, body: BodyHandle) -> Self {
        self.excluded = Some(body);
        self
    }

    /// Sees sensors too.
    #[must_use]
    pub fn with_sensors(mut self) -> Self {
        self.sensors = true;
        self
    }

    /// Does not see fixed and kinematic bodies.
    #[must_use]
    pub fn only_dynamic(mut self) -> Self {
        (self.fixed, self.kinematic) = (false, false);
        self
    }

    /// Does not see kinematic and dynamic bodies.
    #[must_use]
    pub fn only_fixed(mut self) -> Self {
        (self.kinematic, self.dynamic) = (false, false);
        self
    }

    /// Sees only what `predicate` returns `true` for.
    #[must_use]
    pub fn predicate(mut self, predicate: Predicate<'a>) -> Self {
        self.predicate = Some(predicate);
        self
    }

    fn sees(&self, id: ShapeId, shape: &Shape, kind: BodyKind) -> bool {
        let kind_seen = match kind {
            BodyKind::Fixed => self.fixed,
            BodyKind::Kinematic => self.kinematic,
            BodyKind::Dynamic => self.dynamic,
        };
        kind_seen
            && (self.sensors || !shape.sensor)
            && self.excluded != Some(id.body)
            && self.groups.allow(shape.groups)
            && self.predicate.is_none_or(|wanted| wanted(id, shape))
    }
}

/// Where a ray meets a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// The shape.
    pub shape: ShapeId,
    /// From the origin, m; 0 if the ray starts inside the shape.
    pub distance: f32,
    /// In the world, m.
    pub point: Vec3,
    /// Unit, against the ray: the surface's normal, or the ray's direction reversed if it starts inside.
    pub normal: Vec3,
}

/// Where a moving shape first meets another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeHit {
    /// The shape that was met.
    pub shape: ShapeId,
    /// How far the moving shape gets, m; 0 if they overlap from the start.
    pub distance: f32,
    /// Where they touch, world, m.
    pub point: Vec3,
    /// Unit, the normal of the shape that was met: it points toward the moving shape.
    pub normal: Vec3,
}

/// The point of a shape nearest to a given one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointHit {
    /// The shape.
    pub shape: ShapeId,
    /// m; 0 if the given point is inside.
    pub distance: f32,
    /// In the world, m; the given point itself if it is inside.
    pub point: Vec3,
    /// Whether the given point is inside. Surfaces (triangle meshes, height fields) have no inside.
    pub inside: bool,
}

impl World {
    /// The nearest shape that a ray meets within `max_distance` (m). `direction` need not be a unit vector.
    ///
    /// ```
    /// use ishigaki::{Body, QueryFilter, Shape, Vec3, World, WorldOptions};
    /// # fn main() -> ishigaki::Result<()> {
    /// let mut world = World::new(WorldOptions::default())?;
    /// let ball = world.add_body(Body::fixed(Shape::ball(0.5)).at(Vec3::new(0.0, 3.0, 0.0)))?;
    /// let hit = world.cast_ray(Vec3::ZERO, Vec3::Y, 10.0, &QueryFilter::new()).expect("it is right above");
    /// assert_eq!((hit.shape.body, hit.distance, hit.normal), (ball, 2.5, Vec3::NEG_Y));
    /// # Ok(())
    /// # }
    /// ```
    pub fn cast_ray(&self, origin: Vec3, direction: Vec3, max_distance: f32, filter: &QueryFilter) -> Option<RayHit> {
        let ray = unit_ray(origin, direction, max_distance)?;
        let mut best: Option<RayHit> = None;
        self.broad_phase.search(
            max_distance,
            |min, max| entry_distance(&ray, min, max),
            |slot| {
                if let Some(hit) = self.ray_hit(slot, &ray, max_distance, filter)
                    && best.is_none_or(|b| nearer((hit.distance, hit.shape), (b.distance, b.shape)))
                {
                    best = Some(hit);
                }
                best.map_or(max_distance, |b| b.distance)
            },
        );
        best
    }

    /// Every shape that a ray meets within `max_distance` (m), each where the ray enters it, the nearest first.
    /// Stops when `found` returns `false`.
    pub fn cast_ray_all(
        &self,
        origin: Vec3,
        direction: Vec3,
        max_distance: f32,
        filter: &QueryFilter,
        mut found: impl FnMut(RayHit) -> bool,
    ) {
        let Some(ray) = unit_ray(origin, direction, max_distance) else { return };
        let mut hits = Vec::new();
        self.broad_phase.search(
            max_distance,
            |min, max| entry_distance(&ray, min, max),
            |slot| {
                hits.extend(self.ray_hit(slot, &ray, max_distance, filter));
                max_distance
            },
        );
        hits.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.shape.cmp(&b.shape)));
        let _ = hits.into_iter().all(&mut found);
    }

    fn ray_hit(&self, slot: u32, ray: &Ray, max_distance: f32, filter: &QueryFilter) -> Option<RayHit> {
        let (id, shape, body) = self.seen(slot, filter)?;
        let pose = shape.world_from_shape(body);
        let hit = with_parry(&shape.shape.geometry, |g| g.cast_ray_and_get_normal(&pose, ray, max_distance, true))??;
        let distance = hit.time_of_impact;
        let normal = if distance > 0.0 { against(hit.normal, ray.dir) } else { -ray.dir };
        let point = ray.origin + ray.dir * distance;
        (distance <= max_distance).then_some(RayHit { shape: id, distance, point, normal })
    }

    /// The first shape that `geometry`, moved from `pose` along `direction` without turning, meets within
    /// `max_distance` (m). `direction` need not be a unit vector.
    ///
    /// Surfaces and half-spaces can be met, not moved.
    pub fn cast_shape(
        &self,
        geometry: &Geometry,
        pose: &Pose,
        direction: Vec3,
        max_distance: f32,
        filter: &QueryFilter,
    ) -> Option<ShapeHit> {
        if !sensible(geometry, pose) {
            return None;
        }
        let moving = geometry.to_parry()?;
        let (min, max) = geometry.bounds(pose);
        // The box moves with the shape: a ray from its center against boxes grown by half of it.
        let (center, half) = (0.5 * (min + max), 0.5 * (max - min));
        let ray = unit_ray(center, direction, max_distance)?;
        let mut best: Option<ShapeHit> = None;
        self.broad_phase.search(
            max_distance,
            |min, max| entry_distance(&ray, min - half, max + half),
            |slot| {
                // With the whole distance, not what the best hit leaves of it: rounding must not depend on the order.
                if let Some(hit) = self.shape_hit(slot, &*moving.0, pose, ray.dir, max_distance, filter)
                    && best.is_none_or(|b| nearer((hit.distance, hit.shape), (b.distance, b.shape)))
                {
                    best = Some(hit);
                }
                best.map_or(max_distance, |b| b.distance)
            },
        );
        best
    }

    fn shape_hit(
        &self,
        slot: u32,
        moving: &dyn ParryShape,
        from: &Pose,
        direction: Vec3,
        max_distance: f32,
        filter: &QueryFilter,
    ) -> Option<ShapeHit> {
        let (id, shape, body) = self.seen(slot, filter)?;
        let pose = shape.world_from_shape(body);
        let options = ShapeCastOptions::with_max_time_of_impact(max_distance);
        let cast = |g: &dyn ParryShape| query::cast_shapes(&pose, Vec3::ZERO, g, from, direction, moving, options);
        // Pairs that parry does not know (two half-spaces) do not meet.
        let hit = with_parry(&shape.shape.geometry, cast)?.ok()??;
        let distance = hit.time_of_impact;
        let normal = against(pose.rotation * hit.normal1, direction);
        let point = pose * hit.witness1;
        (distance <= max_distance).then_some(ShapeHit { shape: id, distance, point, normal })
    }

    /// Every shape that overlaps `geometry` at `pose`, by [`ShapeId`]. Stops when `found` returns `false`.
    pub fn overlap(&self, geometry: &Geometry, pose: &Pose, filter: &QueryFilter, found: impl FnMut(ShapeId) -> bool) {
        if !sensible(geometry, pose) {
            return;
        }
        let Some(still) = geometry.to_parry() else { return };
        let (min, max) = geometry.bounds(pose);
        self.each_in_box(min, max, filter, found, |shape, world_from_shape| {
            let test = |g: &dyn ParryShape| query::intersection_test(world_from_shape, g, pose, &*still.0);
            with_parry(&shape.geometry, test).and_then(Result::ok).is_some_and(|found| found.intersecting)
        });
    }

    /// Every shape that contains a point (world, m), by [`ShapeId`]. Stops when `found` returns `false`.
    /// Surfaces (triangle meshes, height fields) have no inside.
    pub fn overlap_point(&self, point: Vec3, filter: &QueryFilter, found: impl FnMut(ShapeId) -> bool) {
        if !point.is_finite() {
            return;
        }
        self.each_in_box(point, point, filter, found, |shape, world_from_shape| {
            shape.geometry.has_inside()
                && with_parry(&shape.geometry, |g| g.contains_point(world_from_shape, point)).unwrap_or(false)
        });
    }

    /// Calls `found` for each shape near a box that passes `test`, by id.
    fn each_in_box(
        &self,
        min: Vec3,
        max: Vec3,
        filter: &QueryFilter,
        mut found: impl FnMut(ShapeId) -> bool,
        test: impl Fn(&Shape, &Pose) -> bool,
    ) {
        let mut slots = Vec::new();
        self.broad_phase.query_aabb(min, max, &mut slots);
        let mut ids: Vec<ShapeId> = slots
            .into_iter()
            .filter_map(|slot| self.seen(slot, filter))
            .filter(|(_, shape, body)| test(&shape.shape, &shape.world_from_shape(body)))
            .map(|(id, ..)| id)
            .collect();
        ids.sort_unstable();
        let _ = ids.into_iter().all(&mut found);
    }

    /// The shape nearest to a point (world, m), within `max_distance` (m).
    pub fn closest_point(&self, point: Vec3, max_distance: f32, filter: &QueryFilter) -> Option<PointHit> {
        if !point.is_finite() || max_distance.is_nan() {
            return None;
        }
        let mut best: Option<PointHit> = None;
        self.broad_phase.search(
            max_distance,
            |min, max| Some(LESS * (point.clamp(min, max) - point).length()),
            |slot| {
                if let Some(hit) = self.point_hit(slot, point, filter)
                    && hit.distance <= max_distance
                    && best.is_none_or(|b| nearer((hit.distance, hit.shape), (b.distance, b.shape)))
                {
                    best = Some(hit);
                }
                best.map_or(max_distance, |b| b.distance)
            },
        );
        best
    }

    fn point_hit(&self, slot: u32, point: Vec3, filter: &QueryFilter) -> Option<PointHit> {
        let (id, shape, body) = self.seen(slot, filter)?;
        let pose = shape.world_from_shape(body);
        let projection = with_parry(&shape.shape.geometry, |g| g.project_point(&pose, point, true))?;
        let inside = projection.is_inside && shape.shape.geometry.has_inside();
        let nearest = if inside { point } else { projection.point };
        Some(PointHit { shape: id, distance: (nearest - point).length(), point: nearest, inside })
    }

    /// A shape with its id and body, if the filter sees it and its body is where it can be found.
    fn seen(&self, slot: u32, filter: &QueryFilter) -> Option<(ShapeId, &ShapeState, &BodyState)> {
        let shape = self.shapes.at(slot);
        let body = self.bodies.at(shape.body);
        let id = self.shape_id(slot);
        (filter.sees(id, &shape.shape, body.kind) && body.is_finite()).then_some((id, shape, body))
    }
}

impl Geometry {
    fn has_inside(&self) -> bool {
        !matches!(self, Self::TriangleMesh(_) | Self::HeightField(_))
    }
}

/// Takes rounding out of lower bounds: a box is never farther than the shape in it.
const LESS: f32 = 1.0 - 1e-5;

fn nearer(a: (f32, ShapeId), b: (f32, ShapeId)) -> bool {
    a.0 < b.0 || (a.0 == b.0 && a.1 < b.1)
}

/// The normal on the side that the ray comes from; the reversed ray where there is none.
fn against(normal: Vec3, direction: Vec3) -> Vec3 {
    match normal.try_normalize() {
        Some(unit) if unit.dot(direction) > 0.0 => -unit,
        Some(unit) => unit,
        None => -direction,
    }
}

/// The ray with a unit direction; `None` if the question makes no sense.
fn unit_ray(origin: Vec3, direction: Vec3, max_distance: f32) -> Option<Ray> {
    let direction = direction.is_finite().then(|| direction.try_normalize()).flatten()?;
    (origin.is_finite() && max_distance >= 0.0).then(|| Ray::new(origin, direction))
}

fn sensible(geometry: &Geometry, pose: &Pose) -> bool {
    let length = pose.rotation.length();
    pose.translation.is_finite() && (length - 1.0).abs() < 1e-3 && geometry.validate().is_ok()
}

/// How far a ray goes before it enters a box, m; `None` if it misses it.
fn entry_distance(ray: &Ray, min: Vec3, max: Vec3) -> Option<f32> {
    let (mut enter, mut leave) = (0.0_f32, f32::INFINITY);
    for axis in 0..3 {
        let (origin, direction) = (ray.origin[axis], ray.dir[axis]);
        if direction == 0.0 {
            if origin < min[axis] || origin > max[axis] {
                return None;
            }
        } else {
            let (a, b) = ((min[axis] - origin) / direction, (max[axis] - origin) / direction);
            enter = enter.max(a.min(b) * LESS);
            leave = leave.min(a.max(b) / LESS);
        }
    }
    (enter <= leave).then_some(enter)
}

/// Calls `ask` with the geometry's twin in parry, made on the stack; `None` for compounds, which worlds lay out
/// as single shapes.
fn with_parry<R>(geometry: &Geometry, ask: impl FnOnce(&dyn ParryShape) -> R) -> Option<R> {
    Some(match geometry {
        Geometry::Ball { radius } => ask(&Ball::new(*radius)),
        Geometry::Cuboid { half_extents } => ask(&Cuboid::new(*half_extents)),
        Geometry::Capsule { half_length, radius } => ask(&Capsule::new_y(*half_length, *radius)),
        Geometry::Cylinder { half_height, radius } => ask(&Cylinder::new(*half_height, *radius)),
        Geometry::Cone { half_height, radius } => ask(&Cone::new(*half_height, *radius)),
        Geometry::ConvexHull(hull) => ask(&*hull.polyhedron),
        Geometry::HalfSpace { normal } => ask(&HalfSpace::new(*normal)),
        Geometry::TriangleMesh(mesh) => ask(&*mesh.mesh),
        Geometry::HeightField(field) => ask(&*field.field),
        Geometry::Compound(_) => return None,
    })
}
