//! A scene as every engine can build it: bodies of convex shapes, a ground, a terrain, ball joints.
//!
//! SI units, Y up. Rotations are unit quaternions [x, y, z, w]. Mass and inertia follow from shapes and densities in
//! every engine, so nothing else needs to agree. This file is shared with the library that holds Rapier.

use serde::{Deserialize, Serialize};

/// What an engine builds.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// m/s².
    pub gravity: [f32; 3],
    /// Points of the convex hulls that shapes refer to, m.
    pub hulls: Vec<Vec<[f32; 3]>>,
    /// In the order in which states are read back.
    pub bodies: Vec<Body>,
    /// Ball joints.
    pub joints: Vec<BallJoint>,
    /// Pairs of bodies that never touch each other, besides those of joints.
    pub excluded: Vec<[usize; 2]>,
}

/// A body, dynamic or fixed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Body {
    /// Moved by forces; otherwise fixed.
    pub dynamic: bool,
    /// Place of its origin, m.
    pub position: [f32; 3],
    /// Orientation.
    pub rotation: [f32; 4],
    /// Of the center of mass, m/s.
    pub velocity: [f32; 3],
    /// World, rad/s.
    pub angular_velocity: [f32; 3],
    /// At least one.
    pub shapes: Vec<Shape>,
    /// Bits of the groups it is in.
    pub member_of: u32,
    /// Bits of the groups it touches.
    pub collides_with: u32,
}

/// A shape of a body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shape {
    /// Form in the shape's frame.
    pub form: Form,
    /// Place in the body's frame, m.
    pub position: [f32; 3],
    /// Orientation in the body's frame.
    pub rotation: [f32; 4],
    /// kg/m³.
    pub density: f32,
    /// Coulomb's μ.
    pub friction: f32,
    /// Newton's e.
    pub restitution: f32,
}

/// The form of a shape; lengths in m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Form {
    /// Half of each edge.
    Cuboid([f32; 3]),
    /// Radius.
    Ball(f32),
    /// Points within `radius` of a segment along Y.
    Capsule {
        /// Half of the segment.
        half_length: f32,
        /// Of the round ends.
        radius: f32,
    },
    /// The convex hull of `Scene::hulls[i]`.
    Hull(usize),
    /// All points with y ≤ 0; fixed bodies only. Engines without half-spaces take a box, see [`Scene::ground_box`].
    HalfSpace,
    /// `count` × `count` heights, row by row (rows along Z), over a square of `size` about the origin; fixed bodies only.
    HeightField {
        /// Points along each edge.
        count: usize,
        /// `heights[row * count + column]`.
        heights: Vec<f32>,
        /// Of the square's edge.
        size: f32,
    },
}

/// A point in common; the two bodies do not touch each other.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BallJoint {
    /// Indices of the bodies.
    pub bodies: [usize; 2],
    /// The point in the frame of each, m.
    pub anchors: [[f32; 3]; 2],
}

impl Scene {
    /// Half extents of a box that stands for the half-space, its top at y = 0: it reaches 50 m beyond all bodies.
    #[allow(dead_code, reason = "a build without engines that need it has no use for it")]
    pub fn ground_box(&self) -> [f32; 3] {
        let reach = self.bodies.iter().flat_map(|b| [b.position[0].abs(), b.position[2].abs()]).fold(0.0, f32::max);
        [reach + 50.0, 5.0, reach + 50.0]
    }
}

impl Body {
    /// A body at a place, at rest, of one shape.
    pub fn new(dynamic: bool, position: [f32; 3], shape: Shape) -> Self {
        Self {
            dynamic,
            position,
            rotation: [0.0, 0.0, 0.0, 1.0],
            velocity: [0.0; 3],
            angular_velocity: [0.0; 3],
            shapes: vec![shape],
            member_of: 1,
            collides_with: u32::MAX,
        }
    }
}

impl Shape {
    /// A form about the body's origin: 1000 kg/m³, friction 0.6, restitution 0.
    pub fn new(form: Form) -> Self {
        Self {
            form,
            position: [0.0; 3],
            rotation: [0.0, 0.0, 0.0, 1.0],
            density: 1000.0,
            friction: 0.6,
            restitution: 0.0,
        }
    }
}
