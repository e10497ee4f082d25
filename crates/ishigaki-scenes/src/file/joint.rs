//! Joints in a scene file.

use super::{finite_or_none, is_default, is_false, is_zero};
use ishigaki::math::vector_from_rotation;
use ishigaki::{Drive, Freedom, JointFrames, JointKind, Motor, Pose, Quat, Range, Spring, TurnAxis, Vec3};
use schemars::JsonSchema;
use serde::de::{Deserializer, Error, Visitor};
use serde::{Deserialize, Serialize};

/// A body by its name or by its place in `bodies`, from 0.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum BodyRef {
    /// Its place in `bodies`, from 0.
    Index(usize),
    /// Its name, which must then be unique.
    Name(String),
}

impl From<usize> for BodyRef {
    fn from(index: usize) -> Self {
        Self::Index(index)
    }
}

impl From<&str> for BodyRef {
    fn from(name: &str) -> Self {
        Self::Name(name.to_string())
    }
}

// By hand: serde's own message for untagged enums names no remedy.
impl<'de> Deserialize<'de> for BodyRef {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Ref;
        impl Visitor<'_> for Ref {
            type Value = BodyRef;
            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("a body's name or its index in `bodies`, from 0")
            }
            fn visit_str<E: Error>(self, name: &str) -> Result<BodyRef, E> {
                Ok(name.into())
            }
            fn visit_u64<E: Error>(self, index: u64) -> Result<BodyRef, E> {
                usize::try_from(index).map(BodyRef::Index).map_err(E::custom)
            }
        }
        deserializer.deserialize_any(Ref)
    }
}

/// A joint between two bodies. A coordinate is that of B relative to A, right-handed about A's axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JointFile {
    /// For people; default `joint3` for the fourth.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// First body.
    pub body_a: BodyRef,
    /// Second body.
    pub body_b: BodyRef,
    /// What it allows.
    pub kind: JointKindFile,
    /// Where it sits.
    pub frame: FramesFile,
    /// Whether the two bodies may touch each other; default false.
    #[serde(default, skip_serializing_if = "is_false")]
    pub collide: bool,
    /// It breaks when it carries more than this, N; default: never.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "finite_or_none")]
    pub break_force: Option<f32>,
    /// It breaks when it carries more than this, N·m; default: never.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "finite_or_none")]
    pub break_torque: Option<f32>,
}

/// What a joint allows, in the joint's frame (x is the axis of hinges and sliders).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum JointKindFile {
    /// A point in common.
    Ball {
        /// Greatest angle between the two frames' x axes, in [0, π] rad; default: any.
        #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "finite_or_none")]
        cone: Option<f32>,
        /// Range of the rotation about x, rad; default: any.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        twist: Option<LimitFile>,
        /// Dry friction against all rotation, N·m.
        #[serde(default, skip_serializing_if = "is_zero")]
        friction: f32,
        /// Damping of all rotation, N·m·s/rad.
        #[serde(default, skip_serializing_if = "is_zero")]
        damping: f32,
    },
    /// A point and the axis x in common; the coordinate is the angle, rad.
    Hinge(DriveFile),
    /// B slides along A's x axis and does not turn; the coordinate is the displacement, m.
    Slider(DriveFile),
    /// No relative motion.
    Fixed,
    /// The distance of the two anchors is in a range; a rope has no lower end.
    Distance {
        /// m ≥ 0; default 0.
        #[serde(default, skip_serializing_if = "is_zero")]
        lower: f32,
        /// m; default: any.
        #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "finite_or_none")]
        upper: Option<f32>,
        /// Soft instead of hard; the target is a length, m.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        spring: Option<SpringFile>,
    },
    /// Any of six coordinates: displacements along A's x, y, z, then up to three turns one after the other.
    Generic {
        /// Along x, y, z of frame A; default all locked.
        #[serde(default, skip_serializing_if = "is_default")]
        linear: [FreedomFile; 3],
        /// In sequence, the first axis fixed to A, the last to B; other directions are locked.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        angular: Vec<TurnFile>,
    },
}

/// A range of a coordinate: rad or m. An end that is left out does not limit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LimitFile {
    /// Lower end.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "finite_or_none")]
    pub lower: Option<f32>,
    /// Upper end.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "finite_or_none")]
    pub upper: Option<f32>,
}

/// Drives the rate of a coordinate to a speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MotorFile {
    /// rad/s or m/s.
    pub speed: f32,
    /// Greatest effort, N·m or N; default: any.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "finite_or_none")]
    pub max_effort: Option<f32>,
}

/// A spring on a coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpringFile {
    /// Rest value: rad or m; default 0.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub target: f32,
    /// N·m/rad or N/m.
    pub stiffness: f32,
    /// N·m·s/rad or N·s/m; default 0.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub damping: f32,
}

/// What acts on one coordinate of a joint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct DriveFile {
    /// Range of motion; default: any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit: Option<LimitFile>,
    /// Motor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motor: Option<MotorFile>,
    /// Spring.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spring: Option<SpringFile>,
    /// Inertia of a rotor geared to the coordinate, kg·m² (kg for displacements).
    #[serde(skip_serializing_if = "is_zero")]
    pub armature: f32,
    /// Dry friction: effort up to this against motion, N·m or N.
    #[serde(skip_serializing_if = "is_zero")]
    pub friction: f32,
}

/// One displacement of a generic joint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum FreedomFile {
    /// Held at zero.
    #[default]
    Locked,
    /// May move, as the drive says.
    Free(DriveFile),
}

/// A turning axis of a generic joint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TurnFile {
    /// In the joint's frame at zero.
    #[schemars(with = "[f32; 3]")]
    pub axis: Vec3,
    /// What acts on its angle.
    #[serde(default, skip_serializing_if = "is_default")]
    pub drive: DriveFile,
}

/// Where the joint's frame sits.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum FramesFile {
    /// One frame in the world; both bodies take it over as they stand.
    World(FrameFile),
    /// In each body's own frame.
    Local {
        /// On A.
        #[serde(default, skip_serializing_if = "is_default")]
        a: FrameFile,
        /// On B.
        #[serde(default, skip_serializing_if = "is_default")]
        b: FrameFile,
    },
}

/// A place with an orientation, said by a rotation or by where its x axis points; not by both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FrameFile {
    /// m.
    #[serde(skip_serializing_if = "is_default")]
    #[schemars(with = "[f32; 3]")]
    pub position: Vec3,
    /// A unit quaternion [x, y, z, w].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<[f32; 4]>")]
    pub rotation: Option<Quat>,
    /// The direction of x, the axis of hinges, sliders, cones and twists; y and z follow by the shortest turn.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<[f32; 3]>")]
    pub axis: Option<Vec3>,
}

impl FrameFile {
    /// A place with the axes of its parent.
    pub fn at(position: Vec3) -> Self {
        Self { position, rotation: None, axis: None }
    }

    /// A place whose x axis points along `axis`.
    pub fn about(position: Vec3, axis: Vec3) -> Self {
        Self { position, rotation: None, axis: Some(axis) }
    }

    fn build(&self, place: &str) -> ishigaki::Result<Pose> {
        let error = |field: &str, message: &str| ishigaki::Error::Invalid {
            place: format!("{place}{field}"),
            message: message.to_string(),
        };
        let rotation = match (self.rotation, self.axis) {
            (Some(_), Some(_)) => return Err(error("", "has both `rotation` and `axis`: say one of them")),
            (Some(rotation), None) => rotation,
            (None, None) => Quat::IDENTITY,
            (None, Some(axis)) => {
                let unit = axis
                    .try_normalize()
                    .ok_or_else(|| error(".axis", "must be finite and not zero: it is a direction"))?;
                Quat::from_rotation_arc(Vec3::X, unit)
            }
        };
        Ok(Pose::from_parts(self.position, rotation))
    }
}

impl From<Pose> for FrameFile {
    fn from(pose: Pose) -> Self {
        let turned = vector_from_rotation(pose.rotation) != Vec3::ZERO;
        Self { position: pose.translation, rotation: turned.then_some(pose.rotation), axis: None }
    }
}

impl JointFile {
    /// A joint of a kind at a frame; the two bodies do not touch each other.
    pub fn new(body_a: impl Into<BodyRef>, body_b: impl Into<BodyRef>, kind: JointKindFile, frame: FramesFile) -> Self {
        Self {
            name: String::new(),
            body_a: body_a.into(),
            body_b: body_b.into(),
            kind,
            frame,
            collide: false,
            break_force: None,
            break_torque: None,
        }
    }
}

impl FramesFile {
    pub(super) fn build(&self) -> ishigaki::Result<JointFrames> {
        Ok(match self {
            Self::World(frame) => JointFrames::World(frame.build("frame")?),
            Self::Local { a, b } => JointFrames::Local { a: a.build("frame_a")?, b: b.build("frame_b")? },
        })
    }
}

impl From<JointFrames> for FramesFile {
    fn from(frames: JointFrames) -> Self {
        match frames {
            JointFrames::World(pose) => Self::World(pose.into()),
            JointFrames::Local { a, b } => Self::Local { a: a.into(), b: b.into() },
        }
    }
}

/// A number that a file can say: infinity is left out.
fn finite(value: f32) -> Option<f32> {
    (!value.is_infinite()).then_some(value)
}

impl From<LimitFile> for Range {
    fn from(limit: LimitFile) -> Self {
        Self { lower: limit.lower.unwrap_or(f32::NEG_INFINITY), upper: limit.upper.unwrap_or(f32::INFINITY) }
    }
}

impl From<Range> for LimitFile {
    fn from(range: Range) -> Self {
        Self { lower: finite(range.lower), upper: finite(range.upper) }
    }
}

impl From<MotorFile> for Motor {
    fn from(motor: MotorFile) -> Self {
        Self { speed: motor.speed, max_effort: motor.max_effort.unwrap_or(f32::INFINITY) }
    }
}

impl From<Motor> for MotorFile {
    fn from(motor: Motor) -> Self {
        Self { speed: motor.speed, max_effort: finite(motor.max_effort) }
    }
}

impl From<SpringFile> for Spring {
    fn from(s: SpringFile) -> Self {
        Self { target: s.target, stiffness: s.stiffness, damping: s.damping }
    }
}

impl From<Spring> for SpringFile {
    fn from(s: Spring) -> Self {
        Self { target: s.target, stiffness: s.stiffness, damping: s.damping }
    }
}

impl From<DriveFile> for Drive {
    fn from(d: DriveFile) -> Self {
        Self {
            limit: d.limit.map(Into::into),
            motor: d.motor.map(Into::into),
            spring: d.spring.map(Into::into),
            armature: d.armature,
            friction: d.friction,
        }
    }
}

impl From<Drive> for DriveFile {
    fn from(d: Drive) -> Self {
        Self {
            limit: d.limit.map(Into::into),
            motor: d.motor.map(Into::into),
            spring: d.spring.map(Into::into),
            armature: d.armature,
            friction: d.friction,
        }
    }
}

impl From<&JointKindFile> for JointKind {
    fn from(kind: &JointKindFile) -> Self {
        match kind {
            &JointKindFile::Ball { cone, twist, friction, damping } => {
                Self::Ball { cone, twist: twist.map(Into::into), friction, damping }
            }
            &JointKindFile::Hinge(drive) => Self::Hinge { drive: drive.into() },
            &JointKindFile::Slider(drive) => Self::Slider { drive: drive.into() },
            JointKindFile::Fixed => Self::Fixed,
            &JointKindFile::Distance { lower, upper, spring } => Self::Distance {
                range: Range { lower, upper: upper.unwrap_or(f32::INFINITY) },
                spring: spring.map(Into::into),
            },
            JointKindFile::Generic { linear, angular } => Self::Generic {
                linear: linear.map(|f| match f {
                    FreedomFile::Locked => Freedom::Locked,
                    FreedomFile::Free(drive) => Freedom::Free(drive.into()),
                }),
                angular: angular.iter().map(|t| TurnAxis { axis: t.axis, drive: t.drive.into() }).collect(),
            },
        }
    }
}

impl From<&JointKind> for JointKindFile {
    fn from(kind: &JointKind) -> Self {
        match kind {
            &JointKind::Ball { cone, twist, friction, damping } => {
                Self::Ball { cone, twist: twist.map(Into::into), friction, damping }
            }
            &JointKind::Hinge { drive } => Self::Hinge(drive.into()),
            &JointKind::Slider { drive } => Self::Slider(drive.into()),
            JointKind::Fixed => Self::Fixed,
            &JointKind::Distance { range, spring } => {
                Self::Distance { lower: range.lower, upper: finite(range.upper), spring: spring.map(Into::into) }
            }
            JointKind::Generic { linear, angular } => Self::Generic {
                linear: linear.map(|f| match f {
                    Freedom::Locked => FreedomFile::Locked,
                    Freedom::Free(drive) => FreedomFile::Free(drive.into()),
                }),
                angular: angular.iter().map(|t| TurnFile { axis: t.axis, drive: t.drive.into() }).collect(),
            },
        }
    }
}
