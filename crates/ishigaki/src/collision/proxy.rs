//! Shapes as the search for contacts sees them in this step: pose, bounds, motion, close together in memory.
//!
//! Bodies and shapes are large, and pairs ask for them in an order that no cache foresees. Made anew in each step by
//! `find_pairs`, for all shapes; nothing moves between that and the narrow phase.

use crate::body::{BodyState, ShapeState};
use crate::collision::pairs::motion_in_step;
use crate::math::{Pose, Vec3};
use crate::shape::Geometry;

/// A shape in this step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Proxy {
    /// Bounds without any margin, world, m.
    pub min: Vec3,
    pub max: Vec3,
    /// How far its body moves in this step, m.
    pub motion: Vec3,
    /// Radius of a ball inside it, m.
    pub inner_radius: f32,
    pub body: u32,
    pub traits: Traits,
}

/// What else tells pairs apart that cannot touch.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Traits {
    pub sensor: bool,
    /// May be swept: no gap is too large.
    pub continuous: bool,
    pub half_space: bool,
}

/// Bounds in the broad phase, m.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FatBounds {
    pub min: Vec3,
    pub max: Vec3,
}

impl FatBounds {
    /// Touches nothing.
    pub const NOWHERE: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    pub fn of(shape: &ShapeState) -> Self {
        Self { min: shape.bounds_min, max: shape.bounds_max }
    }

    pub fn touch(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }
}

/// All shapes by slot.
#[derive(Clone, Debug, Default)]
pub(crate) struct Proxies {
    pub shapes: Vec<Proxy>,
    /// world_from_shape.
    pub poses: Vec<Pose>,
    /// Bounds in the broad phase, now and before this step; these are [`FatBounds::NOWHERE`] if pairs are found anew.
    pub bounds: Vec<[FatBounds; 2]>,
    /// Surfaces of half-spaces, whose bounds tell nothing; few.
    pub planes: Vec<Plane>,
}

/// The surface of a half-space, world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plane {
    slot: u32,
    normal: Vec3,
    offset: f32,
}

impl Proxies {
    /// Makes room for slots below `count`.
    pub fn reset(&mut self, count: usize) {
        self.shapes.clear();
        self.shapes.resize(count, Proxy::NOWHERE);
        self.poses.clear();
        self.poses.resize(count, Pose::IDENTITY);
        self.bounds.clear();
        self.bounds.resize(count, [FatBounds::NOWHERE; 2]);
        self.planes.clear();
    }

    /// Enters a shape of a body that is finite; gives its bounds without any margin.
    pub fn enter(&mut self, slot: u32, shape: &ShapeState, body: &BodyState, dt: f32) -> (Vec3, Vec3) {
        let pose = shape.world_from_shape(body);
        if let Geometry::HalfSpace { normal } = shape.shape.geometry {
            let normal = pose.rotation * normal;
            self.planes.push(Plane { slot, normal, offset: normal.dot(pose.translation) });
        }
        let proxy = Proxy::new(shape, body, &pose, dt);
        self.shapes[slot as usize] = proxy;
        self.poses[slot as usize] = pose;
        (proxy.min, proxy.max)
    }

    /// Speculative margin of a pair, m: contacts are made up to it, or as far as a step takes the pair, but not farther
    /// than the bodies are thick: beyond that a plane is a bad picture of a surface, and fast bodies should be
    /// `continuous`.
    pub fn margin(a: &Proxy, b: &Proxy, least: f32) -> f32 {
        if a.traits.sensor || b.traits.sensor {
            return 0.0;
        }
        let thick = a.inner_radius.max(b.inner_radius);
        least.max((a.motion - b.motion).length().min(thick))
    }

    /// Whether the bounds of a pair are farther apart than it may touch.
    pub fn are_apart(&self, (slot_a, slot_b): (u32, u32), least_margin: f32) -> bool {
        let (a, b) = (&self.shapes[slot_a as usize], &self.shapes[slot_b as usize]);
        if a.traits.half_space {
            return self.is_above(slot_a, b, Self::margin(a, b, least_margin));
        }
        if b.traits.half_space {
            return self.is_above(slot_b, a, Self::margin(a, b, least_margin));
        }
        let gap = (a.min - b.max).max(b.min - a.max).max_element();
        // Not a number is no gap: the narrow phase decides.
        gap > least_margin && gap > Self::margin(a, b, least_margin) && !(a.traits.continuous || b.traits.continuous)
    }

    /// Whether the bounds of `other` are out of reach of a half-space.
    fn is_above(&self, half_space: u32, other: &Proxy, margin: f32) -> bool {
        let Some(plane) = self.planes.iter().find(|plane| plane.slot == half_space) else { return false };
        let (center, half) = (0.5 * (other.min + other.max), 0.5 * (other.max - other.min));
        let lowest = plane.normal.dot(center) - plane.normal.abs().dot(half) - plane.offset;
        lowest > margin && !other.traits.continuous
    }
}

impl Proxy {
    /// Of an unused slot, or of a body that is not finite.
    const NOWHERE: Self = Self {
        min: Vec3::INFINITY,
        max: Vec3::NEG_INFINITY,
        motion: Vec3::ZERO,
        inner_radius: 0.0,
        body: 0,
        traits: Traits { sensor: false, continuous: false, half_space: false },
    };

    fn new(shape: &ShapeState, body: &BodyState, pose: &Pose, dt: f32) -> Self {
        let (min, max) = shape.shape.geometry.bounds(pose);
        Self {
            min,
            max,
            motion: motion_in_step(body, dt),
            inner_radius: shape.inner_radius,
            body: shape.body,
            traits: Traits {
                sensor: shape.shape.sensor,
                continuous: body.continuous,
                half_space: matches!(shape.shape.geometry, Geometry::HalfSpace { .. }),
            },
        }
    }
}
