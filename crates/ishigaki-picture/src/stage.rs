//! A frame put in place: solids under a tree of bounds, and planes.

use crate::palette::{self, Coloring};
use crate::solid::{self, Solid};
use ishigaki::math::tangents;
use ishigaki::{BodyKind, Mat3, Pose, Quat, Vec3};
use ishigaki_recording::{Contact, Frame, Geometry, Scene};
use parry3d::bounding_volume::Aabb;
use parry3d::partitioning::{Bvh, BvhBuildStrategy, TraversalAction};
use parry3d::query::Ray;

/// How wide edges are worn, as a share of half the thickness.
const WORN: f32 = 0.09;
/// How dark the gap along an edge is.
const GAP: f32 = 0.62;

/// What hides more than this share of the bodies is a curtain.
const CURTAIN: f32 = 0.1;

/// Everything that rays can meet.
pub struct Stage {
    solids: Vec<Solid>,
    placed: Vec<Placed>,
    planes: Vec<Plane>,
    /// Of the placed solids, in their order.
    bounds: Vec<Aabb>,
    tree: Bvh,
    /// What shines through everything: the arrows of contacts.
    overlay: Option<Box<Stage>>,
}

struct Placed {
    /// Number of its body; `None` for what is drawn besides bodies.
    body: Option<usize>,
    /// Number of its solid.
    solid: usize,
    position: Vec3,
    world_from_local: Mat3,
    color: Vec3,
    /// Width of its worn edges, m.
    worn: f32,
}

struct Plane {
    normal: Vec3,
    offset: f32,
    /// Directions of its grid.
    axes: (Vec3, Vec3),
    color: Vec3,
}

/// What a ray met.
pub struct Met {
    pub distance: f32,
    /// Unit, toward where the ray came from.
    pub normal: Vec3,
    pub color: Vec3,
    /// Coordinates on a plane, m.
    pub grid: Option<(f32, f32)>,
}

impl Stage {
    pub fn new(scene: &Scene, frame: &Frame, coloring: Coloring, arrows: Option<f32>) -> Self {
        let colors = palette::colors(scene, frame, coloring);
        let mut solids: Vec<Solid> = Vec::new();
        // Where the solid of a geometry is; half-spaces have none.
        let mut places: Vec<Option<usize>> = Vec::new();
        let mut boxes = Vec::new();
        for geometry in &scene.geometries {
            places.push(Solid::new(geometry).map(|solid| {
                solids.push(solid);
                boxes.extend(solid::local_box(geometry));
                solids.len() - 1
            }));
        }
        let mut stage = Self { solids, ..Self::empty() };
        for (i, (body, record)) in scene.bodies.iter().zip(&frame.bodies).enumerate() {
            if record.absent || !record.is_finite() {
                continue;
            }
            for shape in body.shapes.iter().filter(|shape| !shape.sensor) {
                let pose = record.pose() * shape.pose();
                match (&scene.geometries[shape.geometry], places[shape.geometry]) {
                    (Geometry::HalfSpace { normal }, _) => stage.add_plane(&pose, *normal, scene.up, colors[i]),
                    (_, Some(solid)) => stage.add(solid, &pose, boxes[solid], colors[i], Some(i)),
                    _ => {}
                }
            }
        }
        if let Some(longest) = arrows {
            let mut overlay = Self::empty();
            overlay.add_arrows(scene, &frame.contacts, longest);
            overlay.plant();
            stage.overlay = Some(Box::new(overlay));
        }
        stage.plant();
        stage
    }

    fn empty() -> Self {
        let (solids, placed, planes, bounds) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { solids, placed, planes, bounds, tree: Bvh::new(), overlay: None }
    }

    /// What shines through everything.
    pub fn overlay(&self) -> Option<&Self> {
        self.overlay.as_deref()
    }

    fn plant(&mut self) {
        self.tree = Bvh::from_leaves(BvhBuildStrategy::Binned, &self.bounds);
    }

    /// Takes away fixed solids that stand between the eye and many of the bodies that move: the near walls of a box.
    pub fn without_curtains(mut self, scene: &Scene, frame: &Frame, eye: Vec3) -> Self {
        let is_moving = |i: usize| scene.bodies[i].kind == BodyKind::Dynamic;
        let moving = || frame.bodies.iter().enumerate().filter(|(i, r)| is_moving(*i) && r.is_finite() && !r.absent);
        let most = (CURTAIN * moving().count() as f32).max(0.5);
        let is_curtain = |placed: &Placed| {
            let hides = |position: Vec3| {
                let way = position - eye;
                let direction = way.try_normalize()?;
                self.local_cast(placed, eye, direction, way.length())
            };
            placed.body.is_some_and(|body| !is_moving(body))
                && moving().filter(|(_, record)| hides(record.position).is_some()).count() as f32 > most
        };
        let keep: Vec<bool> = self.placed.iter().map(|placed| !is_curtain(placed)).collect();
        let mut kept = keep.iter();
        self.placed.retain(|_| kept.next().is_none_or(|&k| k));
        let mut kept = keep.iter();
        self.bounds.retain(|_| kept.next().is_none_or(|&k| k));
        self.plant();
        self
    }

    fn add(&mut self, solid: usize, pose: &Pose, (center, half): (Vec3, Vec3), color: Vec3, body: Option<usize>) {
        let world_from_local = Mat3::from_quat(pose.rotation);
        let middle = pose.translation + world_from_local * center;
        let [x, y, z] = world_from_local.to_cols_array_2d().map(|c| Vec3::from_array(c).abs());
        let half = x * half.x + y * half.y + z * half.z;
        let bounds = Aabb::new(middle - half, middle + half);
        if !(bounds.mins.is_finite() && bounds.maxs.is_finite()) {
            return;
        }
        let worn = WORN * self.solids[solid].thickness();
        self.placed.push(Placed { body, solid, position: pose.translation, world_from_local, color, worn });
        self.bounds.push(bounds);
    }

    fn add_plane(&mut self, pose: &Pose, normal: Vec3, up: Vec3, color: Vec3) {
        let Some(normal) = (pose.rotation * normal).try_normalize() else { return };
        // On level ground the grid runs along the world's axes.
        let along = if normal.dot(up).abs() > 0.999 && up.x.abs() < 0.5 { Vec3::X } else { tangents(normal).0 };
        let first = (along - normal * along.dot(normal)).try_normalize().unwrap_or(tangents(normal).0);
        let offset = normal.dot(pose.translation);
        self.planes.push(Plane { normal, offset, axes: (first, normal.cross(first)), color });
    }

    /// An arrow for each contact that carries: the push on the lighter body (on the upper one of equals), as long as its
    /// impulse says; the longest is `longest`.
    fn add_arrows(&mut self, scene: &Scene, contacts: &[Contact], longest: f32) {
        let most = contacts.iter().map(|c| c.impulse).filter(|λ| λ.is_finite()).fold(0.0, f32::max);
        let radius = 0.022 * longest;
        let color = palette::linear(palette::CONTACT);
        let mass = |body: u32| scene.bodies[body as usize].mass.unwrap_or(f32::INFINITY);
        for contact in contacts {
            let share = contact.impulse / most;
            if !(share > 1e-3 && contact.point.is_finite() && contact.normal.is_finite()) {
                continue;
            }
            let half = 0.5 * longest * share;
            // λ pushes A along the normal.
            let (a, b) = (mass(contact.body_a), mass(contact.body_b));
            let alike = (a - b).abs() <= 0.01 * a.min(b);
            let toward_a = if alike { contact.normal.dot(scene.up) >= 0.0 } else { a < b };
            let push = if toward_a { contact.normal } else { -contact.normal };
            let rotation = Quat::from_rotation_arc(Vec3::Y, push.try_normalize().unwrap_or(Vec3::Y));
            for (geometry, along) in [
                (Geometry::Capsule { half_length: half, radius: 0.5 * radius }, half),
                (Geometry::Cone { half_height: 2.5 * radius, radius: 1.6 * radius }, 2.0 * half),
                (Geometry::Ball { radius: 1.5 * radius }, 0.0),
            ] {
                let pose = Pose::from_parts(contact.point + push * along, rotation);
                let Some((solid, local)) = Solid::new(&geometry).zip(solid::local_box(&geometry)) else { continue };
                self.solids.push(solid);
                self.add(self.solids.len() - 1, &pose, local, color, None);
            }
        }
    }

    /// The first thing along a ray with a unit direction.
    pub fn cast(&self, origin: Vec3, direction: Vec3, reach: f32) -> Option<Met> {
        let mut best: Option<Met> = None;
        let mut limit = reach;
        for plane in &self.planes {
            let (height, speed) = (plane.normal.dot(origin) - plane.offset, plane.normal.dot(direction));
            let distance = -height / speed;
            if speed < 0.0 && distance > 0.0 && distance < limit {
                let p = origin + distance * direction;
                limit = distance;
                let grid = Some((p.dot(plane.axes.0), p.dot(plane.axes.1)));
                best = Some(Met { distance, normal: plane.normal, color: plane.color, grid });
            }
        }
        let ray = Ray::new(origin, direction);
        let found = self
            .tree
            .cast_ray(&ray, limit, |leaf, limit| self.cast_leaf(leaf, origin, direction, limit).map(|(t, _)| t));
        if let Some((leaf, _)) = found
            && let Some((distance, normal)) = self.cast_leaf(leaf, origin, direction, limit)
        {
            let placed = &self.placed[leaf as usize];
            let local = placed.world_from_local.transpose() * (origin + distance * direction - placed.position);
            let (normal, shade) = placed.worn_edge(&self.solids[placed.solid], local, normal);
            let (normal, color) = (placed.world_from_local * normal, placed.color * shade);
            best = Some(Met { distance, normal, color, grid: None });
        }
        best
    }

    /// Whether a solid is in the way.
    pub fn is_blocked(&self, origin: Vec3, direction: Vec3, reach: f32) -> bool {
        let ray = Ray::new(origin, direction);
        let mut blocked = false;
        self.tree.traverse(|node| {
            if node.cast_ray(&ray, reach) >= reach {
                return TraversalAction::Prune;
            }
            if let Some(leaf) = node.leaf_data()
                && self.cast_leaf(leaf, origin, direction, reach).is_some()
            {
                blocked = true;
                return TraversalAction::EarlyExit;
            }
            TraversalAction::Continue
        });
        blocked
    }

    fn cast_leaf(&self, leaf: u32, origin: Vec3, direction: Vec3, reach: f32) -> Option<(f32, Vec3)> {
        self.local_cast(self.placed.get(leaf as usize)?, origin, direction, reach)
    }

    fn local_cast(&self, placed: &Placed, origin: Vec3, direction: Vec3, reach: f32) -> Option<(f32, Vec3)> {
        let turn = placed.world_from_local.transpose();
        self.solids[placed.solid].cast(turn * (origin - placed.position), turn * direction, reach)
    }
}

impl Placed {
    /// Near an edge the surface bends toward the other side and darkens: stones that lie flush can be told apart.
    fn worn_edge(&self, solid: &Solid, point: Vec3, normal: Vec3) -> (Vec3, f32) {
        match solid.edge(point, normal) {
            Some((distance, other)) if distance < self.worn => {
                let near = 1.0 - (distance / self.worn).clamp(0.0, 1.0);
                let bent = (normal + other * (0.9 * near * near)).normalize_or(normal);
                (bent, 1.0 - (1.0 - GAP) * near * near)
            }
            _ => (normal, 1.0),
        }
    }
}
