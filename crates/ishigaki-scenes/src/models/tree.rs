//! What both formats describe: a tree of links, before it becomes bodies and joints.

use super::inertia::Inertia;
use crate::error::SceneError;
use glamx::{DPose3, DQuat, DVec3};
use ishigaki::{Geometry, Pose, Quat, Vec3};

/// A model as its file tells it; SI units, the file's frame.
#[derive(Debug)]
pub(crate) struct Tree {
    pub name: String,
    /// The world first, parents before their children.
    pub links: Vec<Link>,
    /// m/s².
    pub gravity: DVec3,
    /// s.
    pub timestep: f64,
    pub rules: Rules,
    /// Links whose shapes never touch each other.
    pub excluded: Vec<[usize; 2]>,
    /// Shapes, by their ids, that touch each other whatever the filters say.
    pub pairs: Vec<[usize; 2]>,
    /// Joints that close loops.
    pub loops: Vec<Loop>,
}

/// Where the two formats differ.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rules {
    /// Links that cannot move become one body; otherwise each is a fixed body of its own.
    pub merge_fixed: bool,
    /// Neighbors in the tree do not touch.
    pub exclude_parent: bool,
    /// … not even if the parent cannot move.
    pub exclude_fixed_parent: bool,
    /// Mend inertias that no body has, with a warning, instead of refusing them.
    pub mend_inertia: bool,
    /// Friction of the floor that is added on request.
    pub ground_friction: f64,
}

/// A link.
#[derive(Debug)]
pub(crate) struct Link {
    pub name: String,
    /// `ant.xml:12: <body name="leg">`, for messages.
    pub place: String,
    /// Itself for the world.
    pub parent: usize,
    /// parent_from_link when all coordinates are zero.
    pub pose: DPose3,
    pub motion: Motion,
    /// In the link's frame.
    pub inertia: Inertia,
    pub gravity_scale: f64,
    pub pieces: Vec<Piece>,
}

/// How a link moves relative to its parent.
#[derive(Clone, Debug)]
pub(crate) enum Motion {
    /// Not at all.
    Welded,
    /// In any way, with a damping of all six velocities, N·s/m and N·m·s.
    Free { damping: f64 },
    /// As its user says.
    Kinematic,
    /// Along and about axes, one after the other: the first fixed to the parent, the last to the link.
    Joints(Vec<Coordinate>),
}

/// A joint of one kind at one place.
#[derive(Clone, Debug)]
pub(crate) struct Coordinate {
    pub name: String,
    pub kind: CoordinateKind,
    /// In the link's frame, m.
    pub anchor: DVec3,
    /// In the link's frame, unit.
    pub axis: DVec3,
    /// rad or m, relative to the pose in the file; of a ball: the second is its greatest angle.
    pub limit: Option<[f64; 2]>,
    /// Rest value of the spring, relative to the pose in the file.
    pub rest: f64,
    /// What the file's own coordinate is in that pose.
    pub reference: f64,
    pub stiffness: f64,
    pub damping: f64,
    pub armature: f64,
    pub friction: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CoordinateKind {
    Hinge,
    Slide,
    Ball,
}

/// A shape on a link.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    /// Unique in the tree.
    pub id: usize,
    pub geometry: Geometry,
    /// link_from_shape.
    pub pose: DPose3,
    pub surface: Surface,
}

/// How a shape meets others: MuJoCo's terms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Surface {
    pub contype: u32,
    pub conaffinity: u32,
    /// 1: no friction, 3: sliding, 4: and spin, 6: and rolling.
    pub condim: u8,
    pub priority: i64,
    /// Sliding, spin (m), rolling (m).
    pub friction: [f64; 3],
}

/// A joint between two links beside the tree.
#[derive(Debug)]
pub(crate) struct Loop {
    pub name: String,
    /// A common point, else no relative motion at all.
    pub ball: bool,
    pub links: [usize; 2],
    /// link_from_joint of each.
    pub frames: [DPose3; 2],
}

impl Link {
    pub fn new(name: String, place: String, parent: usize, pose: DPose3) -> Self {
        Self {
            name,
            place,
            parent,
            pose,
            motion: Motion::Welded,
            inertia: Inertia::ZERO,
            gravity_scale: 1.0,
            pieces: Vec::new(),
        }
    }

    pub fn error(&self, message: impl std::fmt::Display) -> SceneError {
        SceneError::invalid(self.place.clone(), message.to_string())
    }
}

/// The turn that lays a shape made along z (as both formats have it) with the engine's along y.
pub(crate) fn y_to_z() -> DQuat {
    DQuat::from_xyzw(std::f64::consts::FRAC_1_SQRT_2, 0.0, 0.0, std::f64::consts::FRAC_1_SQRT_2)
}

/// A pose at which a rotation follows a translation.
pub(crate) fn pose(translation: DVec3, rotation: DQuat) -> DPose3 {
    DPose3::from_parts(translation, rotation)
}

pub(crate) fn vec32(v: DVec3) -> Vec3 {
    Vec3::new(v.x as f32, v.y as f32, v.z as f32)
}

pub(crate) fn quat32(q: DQuat) -> Quat {
    // The same rotation has two signs: take the one whose w is not negative.
    let q = if q.w < 0.0 { -q } else { q };
    Quat::from_xyzw(q.x as f32, q.y as f32, q.z as f32, q.w as f32).normalize()
}

pub(crate) fn pose32(p: DPose3) -> Pose {
    Pose::from_parts(vec32(p.translation), quat32(p.rotation))
}
