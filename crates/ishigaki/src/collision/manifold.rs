//! What the narrow phase finds ([`LocalManifold`]) and what the solver keeps ([`Manifold`], [`Contact`]).

use crate::collision::feature_id::FeatureId;
use crate::math::Vec3;
use arrayvec::ArrayVec;
use serde::{Deserialize, Serialize};
use smallvec::SmallVec;

/// Points in a manifold at most: more add no support.
pub const MAX_POINTS: usize = 4;

/// A touching or nearly touching point, in the frame of shape A.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalPoint {
    /// On the surface of A, m.
    pub on_a: Vec3,
    /// On the surface of B, m.
    pub on_b: Vec3,
    /// (on_a − on_b)·normal, m; negative = overlap.
    pub separation: f32,
    /// What touches what.
    pub id: FeatureId,
}

/// Points of one pair that share a normal, in the frame of shape A.
#[derive(Clone, Debug, PartialEq)]
pub struct LocalManifold {
    /// Unit, B's surface normal: it points from B to A.
    pub normal: Vec3,
    /// At most [`MAX_POINTS`], reduced for support area; never two with the same id.
    pub points: ArrayVec<LocalPoint, MAX_POINTS>,
    /// Which triangle of the one that is a mesh or a height field; 0 for convex shapes.
    pub part: u32,
}

impl LocalManifold {
    /// Without points.
    pub fn empty() -> Self {
        Self { normal: Vec3::Y, points: ArrayVec::new(), part: 0 }
    }
}

/// A contact point as the solver sees it. Arms are in world, from the bodies' centers of mass.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContactPoint {
    /// From the center of A to the point on A, world, m.
    pub arm_a: Vec3,
    /// From the center of B to the point on B, world, m.
    pub arm_b: Vec3,
    /// Along the normal, m; negative = overlap.
    pub separation: f32,
    /// What touches what.
    pub id: FeatureId,
    /// Normal impulse of the last substep, N·s: the warm start.
    pub lambda_normal: f32,
    /// Friction impulses on A of the last substep along the [`tangents`](crate::math::tangents) of the normal, N·s: the
    /// warm start.
    pub lambda_friction: [f32; 2],
    /// Normal impulse summed over the step, N·s.
    pub impulse: f32,
}

/// Points of a pair that share a normal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifold {
    /// Unit, world, B's surface normal: it points from B to A.
    pub normal: Vec3,
    /// At most [`MAX_POINTS`].
    pub points: ArrayVec<ContactPoint, MAX_POINTS>,
    /// Which triangle of the one that is a mesh or a height field; 0 for convex shapes.
    pub part: u32,
    /// Torsional impulse about the normal on A, N·m·s: the warm start.
    pub lambda_torsion: f32,
    /// Rolling impulses on A about the tangents of the normal, N·m·s: the warm start.
    pub lambda_rolling: [f32; 2],
}

/// What the mixed material of most pairs does not ask for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct SurfaceExtras {
    /// Newton's e.
    pub restitution: f32,
    /// m.
    pub torsional_friction: f32,
    /// m.
    pub rolling_friction: f32,
    /// Velocity of B's surface relative to A's by conveyors, world, m/s.
    pub surface_velocity: Vec3,
}

/// A pair of shapes with contact points, and what is remembered of them between steps.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Contact {
    /// Slots of the shapes; `shape_a < shape_b`.
    pub(crate) shape_a: u32,
    pub(crate) shape_b: u32,
    /// Slots of the bodies.
    pub(crate) body_a: u32,
    pub(crate) body_b: u32,
    /// One for convex pairs, several for meshes.
    pub(crate) manifolds: SmallVec<[Manifold; 1]>,
    /// Mixed material of the pair.
    pub(crate) friction: f32,
    /// Of few pairs only.
    pub(crate) extras: Option<Box<SurfaceExtras>>,
    /// Neither makes contact; overlap is reported.
    pub(crate) sensor: bool,
    /// Had points (or overlap, for sensors) in the last step.
    pub(crate) touching: bool,
    /// Set while the pair is frozen by aggressive sleep.
    pub(crate) frozen: bool,
}

impl Contact {
    /// Without points.
    pub(crate) fn new((shape_a, shape_b): (u32, u32), (body_a, body_b): (u32, u32), sensor: bool) -> Self {
        Self {
            shape_a,
            shape_b,
            body_a,
            body_b,
            manifolds: SmallVec::new(),
            friction: 0.0,
            extras: None,
            sensor,
            touching: false,
            frozen: false,
        }
    }

    /// It has no points any more: it may stay in the list for some steps, longer than its pair.
    pub(crate) fn is_empty(&self) -> bool {
        self.manifolds.is_empty()
    }

    /// Without a box for what there is nothing of.
    pub(crate) fn set_extras(&mut self, extras: SurfaceExtras) {
        if extras == SurfaceExtras::default() {
            self.extras = None;
        } else {
            **self.extras.get_or_insert_default() = extras;
        }
    }

    pub(crate) fn extras(&self) -> SurfaceExtras {
        self.extras.as_deref().copied().unwrap_or_default()
    }

    /// Slots of the shapes: what the list of contacts is sorted by.
    pub(crate) fn key(&self) -> (u32, u32) {
        (self.shape_a, self.shape_b)
    }

    /// Manifolds with at least one point.
    pub fn manifolds(&self) -> &[Manifold] {
        &self.manifolds
    }

    /// Whether aggressive sleep keeps its rows from the last step.
    pub fn is_frozen(&self) -> bool {
        self.frozen && !self.is_empty()
    }
}
