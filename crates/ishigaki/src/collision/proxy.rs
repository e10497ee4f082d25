//! Shapes as the search for contacts sees them in this step: pose, bounds, motion, close together in memory.
//!
//! Bodies and shapes are large, and pairs ask for them in an order that no cache foresees. Made anew in each step by
//! `find_pairs`, but for shapes that rest as they did; nothing moves between that and the narrow phase.

use crate::body::{BodyState, ShapeState};
use crate::collision::pairs::motion_in_step;
use crate::math::{Pose, Vec3};
use crate::shape::Geometry;
use crate::threads::Cut;

/// A shape in this step: what nearly all pairs are told apart by, in half a cache line.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub(crate) struct Proxy {
    /// Bounds without any margin, world, m.
    pub min: Vec3,
    pub max: Vec3,
    /// Length of its motion, m.
    reach: f32,
    pub traits: Traits,
}

/// What else is asked of pairs that are near.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ProxyMotion {
    /// How far its body moves in this step, m.
    motion: Vec3,
    /// Radius of a ball inside it, m.
    inner_radius: f32,
    pub body: u32,
}

/// What else tells pairs apart that cannot touch.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Traits {
    pub sensor: bool,
    /// May be swept: no gap is too large.
    pub continuous: bool,
    pub half_space: bool,
    /// No shape of the world is in a group that it may touch, or may touch one that it is in.
    pub alone: bool,
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

    pub fn is_nowhere(&self) -> bool {
        self.min.x == f32::INFINITY
    }

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
    pub motions: Vec<ProxyMotion>,
    /// world_from_shape.
    pub poses: Vec<Pose>,
    /// Bounds in the broad phase, now and before this step; these are [`FatBounds::NOWHERE`] if pairs are found anew.
    pub bounds: Vec<[FatBounds; 2]>,
    /// Surfaces of half-spaces, whose bounds tell nothing; few.
    pub planes: Vec<Plane>,
    /// Entered as it rested: it holds until the shape is moved, its body wakes or is changed.
    holds: Vec<bool>,
}

/// Places of neighboring slots: each is written by one thread.
pub(crate) struct Places<'a> {
    first: u32,
    shapes: &'a mut [Proxy],
    motions: &'a mut [ProxyMotion],
    poses: &'a mut [Pose],
    bounds: &'a mut [[FatBounds; 2]],
    holds: &'a mut [bool],
}

impl Cut for Places<'_> {
    fn cut(self, part: usize, of: usize) -> (Self, Self) {
        let middle = self.shapes.len() * part / of;
        let (shapes, other_shapes) = self.shapes.split_at_mut(middle);
        let (motions, other_motions) = self.motions.split_at_mut(middle);
        let (poses, other_poses) = self.poses.split_at_mut(middle);
        let (bounds, other_bounds) = self.bounds.split_at_mut(middle);
        let (holds, other_holds) = self.holds.split_at_mut(middle);
        let others = Self {
            first: self.first + middle as u32,
            shapes: other_shapes,
            motions: other_motions,
            poses: other_poses,
            bounds: other_bounds,
            holds: other_holds,
        };
        (Self { first: self.first, shapes, motions, poses, bounds, holds }, others)
    }
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
    pub fn begin(&mut self, count: usize) {
        self.shapes.resize(count, Proxy::NOWHERE);
        self.motions.resize(count, ProxyMotion::default());
        self.poses.resize(count, Pose::IDENTITY);
        self.bounds.resize(count, [FatBounds::NOWHERE; 2]);
        self.holds.resize(count, false);
        self.planes.clear();
    }

    /// The places of all slots.
    pub fn places(&mut self) -> Places<'_> {
        let Self { shapes, motions, poses, bounds, holds, .. } = self;
        Places { first: 0, shapes, motions, poses, bounds, holds }
    }

    /// Speculative margin of a pair, m: contacts are made up to it, or as far as a step takes the pair, but not farther
    /// than the bodies are thick: beyond that a plane is a bad picture of a surface, and fast bodies should be
    /// `continuous`.
    pub fn margin(&self, (slot_a, slot_b): (u32, u32), least: f32) -> f32 {
        let (slot_a, slot_b) = (slot_a as usize, slot_b as usize);
        if self.shapes[slot_a].traits.sensor || self.shapes[slot_b].traits.sensor {
            return 0.0;
        }
        let (a, b) = (&self.motions[slot_a], &self.motions[slot_b]);
        let thick = a.inner_radius.max(b.inner_radius);
        least.max((a.motion - b.motion).length().min(thick))
    }

    /// Whether the bounds of a pair are farther apart than it may touch.
    pub fn are_apart(&self, pair: (u32, u32), least_margin: f32) -> bool {
        let (a, b) = (&self.shapes[pair.0 as usize], &self.shapes[pair.1 as usize]);
        if a.traits.continuous || b.traits.continuous {
            return false;
        }
        if a.traits.half_space || b.traits.half_space {
            let (half_space, other) = if a.traits.half_space { (pair.0, b) } else { (pair.1, a) };
            return self.is_above(half_space, other, self.margin(pair, least_margin));
        }
        // Not a number is no gap: the narrow phase decides.
        let gap = (a.min - b.max).max(b.min - a.max).max_element();
        // The margin is no greater than this, and most pairs are farther apart.
        let greatest_margin = least_margin.max(1.000_01 * (a.reach + b.reach));
        gap > greatest_margin || gap > least_margin && gap > self.margin(pair, least_margin)
    }

    /// Whether the bounds of `other` are out of reach of a half-space.
    fn is_above(&self, half_space: u32, other: &Proxy, margin: f32) -> bool {
        let Some(plane) = self.planes.iter().find(|plane| plane.slot == half_space) else { return false };
        let (center, half) = (0.5 * (other.min + other.max), 0.5 * (other.max - other.min));
        let lowest = plane.normal.dot(center) - plane.normal.abs().dot(half) - plane.offset;
        lowest > margin
    }
}

impl Places<'_> {
    /// Enters a shape of a body that is finite, and whether it is alone ([`Traits::alone`]); gives its bounds without any
    /// margin, and its surface if it is a half-space.
    pub fn enter(
        &mut self,
        slot: u32,
        shape: &ShapeState,
        body: &BodyState,
        dt: f32,
        alone: bool,
    ) -> ((Vec3, Vec3), Option<Plane>) {
        let pose = shape.world_from_shape(body);
        let plane = match shape.shape.geometry {
            Geometry::HalfSpace { normal } => {
                let normal = pose.rotation * normal;
                Some(Plane { slot, normal, offset: normal.dot(pose.translation) })
            }
            _ => None,
        };
        let (min, max) = shape.shape.geometry.bounds(&pose);
        let motion = motion_in_step(body, dt);
        let traits =
            Traits { sensor: shape.shape.sensor, continuous: body.continuous, half_space: plane.is_some(), alone };
        let at = (slot - self.first) as usize;
        self.shapes[at] = Proxy { min, max, reach: motion.length(), traits };
        self.motions[at] = ProxyMotion { motion, inner_radius: shape.inner_radius, body: shape.body };
        self.poses[at] = pose;
        ((min, max), plane)
    }

    /// Whether the entry of a shape that rests is as it was.
    pub fn holds(&mut self, slot: u32) -> &mut bool {
        &mut self.holds[(slot - self.first) as usize]
    }

    /// A shape of a body that is not finite touches nothing.
    pub fn leave_out(&mut self, slot: u32) {
        self.shapes[(slot - self.first) as usize] = Proxy::NOWHERE;
    }

    /// A shape that touches nothing has no pairs that would ask for it.
    pub fn leave_alone(&mut self, slot: u32, body: u32) {
        self.leave_out(slot);
        self.motions[(slot - self.first) as usize].body = body;
    }

    /// Bounds of a shape in the broad phase, now and before this step.
    pub fn set_bounds(&mut self, slot: u32, bounds: [FatBounds; 2]) {
        self.bounds[(slot - self.first) as usize] = bounds;
    }
}

impl Proxy {
    /// Of an unused slot, or of a body that is not finite.
    const NOWHERE: Self = Self {
        min: Vec3::INFINITY,
        max: Vec3::NEG_INFINITY,
        reach: 0.0,
        traits: Traits { sensor: false, continuous: false, half_space: false, alone: true },
    };
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Body;
    use crate::collision::narrow_phase::{LocalManifolds, find_manifolds};
    use crate::collision::pair_memory::PairMemory;
    use crate::math::Quat;
    use crate::shape::Shape;
    use crate::solver::permutation::Random;

    /// Two shapes, turned and placed at random within reach of each other, thrown about.
    fn placed(random: &mut Random, shapes: [&Shape; 2]) -> Proxies {
        let mut proxies = Proxies::default();
        proxies.begin(2);
        let mut number = |size: f32| size * ((random.bits() >> 40) as f32 / (1 << 23) as f32 - 1.0);
        for (slot, shape) in (0..).zip(shapes) {
            let mut vector = |size: f32| Vec3::new(number(size), number(size), number(size));
            let (at, turn, velocity) = (vector(0.8), vector(3.0), vector(4.0));
            let rotation = crate::math::rotation_from_vector(turn);
            let body = Body::kinematic(shape.clone()).at(at).rotated(rotation).velocity(velocity);
            let flat = body.flat_shapes();
            let state = BodyState::new(&body, &flat).unwrap();
            let shape = ShapeState::new(slot, 0, flat[0].clone(), &state);
            let (_, plane) = proxies.places().enter(slot, &shape, &state, 1.0 / 60.0, false);
            proxies.planes.extend(plane);
        }
        proxies
    }

    #[test]
    fn pairs_that_are_apart_have_no_points() {
        const MARGIN: f32 = 0.02;
        let shapes = [
            Shape::ball(0.3),
            Shape::cuboid(0.3, 0.2, 0.1),
            Shape::capsule(0.3, 0.1),
            Shape::cylinder(0.2, 0.3),
            Shape::cone(0.3, 0.2),
            Shape::half_space(Quat::from_xyzw(0.5, 0.5, 0.5, 0.5) * Vec3::Y),
        ];
        let mut random = Random(5);
        let (mut apart, mut empty) = (0, 0);
        for (i, a) in shapes.iter().enumerate() {
            for b in &shapes[..i] {
                for _ in 0..300 {
                    let proxies = placed(&mut random, [a, b]);
                    let b_in_a = proxies.poses[0].inverse() * proxies.poses[1];
                    let (margin, mut found) = (proxies.margin((0, 1), MARGIN), LocalManifolds::new());
                    find_manifolds(
                        &a.geometry,
                        &b.geometry,
                        &b_in_a,
                        margin,
                        1.0,
                        &mut PairMemory::default(),
                        &mut found,
                    );
                    let is_apart = proxies.are_apart((0, 1), MARGIN);
                    assert!(!is_apart || found.is_empty(), "{a:?} and {b:?}");
                    (apart, empty) = (apart + u32::from(is_apart), empty + u32::from(found.is_empty()));
                }
            }
        }
        assert!(apart * 2 > empty, "it tells {apart} of {empty} pairs apart: too few to be worth it");
    }
}
