//! Joints: the definition a user writes.

use crate::error::{Error, Result, direction, finite_vector, not_negative};
use crate::handle::BodyHandle;
use crate::math::{Pose, Quat, Vec3};
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;

/// A range of a coordinate: rad for angles, m for lengths.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Range {
    /// Lower end; −∞ for none.
    #[serde(with = "crate::number")]
    pub lower: f32,
    /// Upper end; ∞ for none.
    #[serde(with = "crate::number")]
    pub upper: f32,
}

impl From<RangeInclusive<f32>> for Range {
    fn from(range: RangeInclusive<f32>) -> Self {
        Self { lower: *range.start(), upper: *range.end() }
    }
}

/// Drives the rate of a coordinate to a speed with bounded effort.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Motor {
    /// rad/s or m/s.
    pub speed: f32,
    /// Greatest effort: N·m or N; may be infinite.
    #[serde(with = "crate::number")]
    pub max_effort: f32,
}

/// A spring on a coordinate, integrated implicitly: stable at any stiffness.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spring {
    /// Rest value: rad or m.
    pub target: f32,
    /// N·m/rad or N/m.
    pub stiffness: f32,
    /// N·m·s/rad or N·s/m.
    pub damping: f32,
}

/// What acts on one coordinate of a joint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Drive {
    /// Range of motion. TALK B9.
    pub limit: Option<Range>,
    /// Motor.
    pub motor: Option<Motor>,
    /// Spring.
    pub spring: Option<Spring>,
    /// Inertia of a rotor geared to the coordinate, kg·m² (kg for sliders).
    pub armature: f32,
    /// Dry friction: effort up to this against motion, N·m or N.
    pub friction: f32,
}

/// One coordinate of a generic joint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Freedom {
    /// Held at zero.
    #[default]
    Locked,
    /// May move; the drive may have a limit, a motor, a spring.
    Free(Drive),
}

/// A turning axis of a generic joint, in the joint's frame at zero.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TurnAxis {
    /// Unit.
    pub axis: Vec3,
    /// What acts on its angle.
    pub drive: Drive,
}

/// What a joint allows, in the joint's frame (x is the axis of hinges and sliders).
///
/// | Kind | Locked | Free | Rows besides drives |
/// |---|---|---|---|
/// | ball | point | swing, twist (each may have a range) | 3 |
/// | hinge | point, axis | angle | 5 |
/// | slider | rotation, two displacements | displacement | 5 |
/// | fixed | all | – | 6 |
/// | distance | – | distance (a range, a spring) | 0 to 2 |
/// | generic | what is not listed | up to three displacements and three turns | 6 − free |
///
/// ```
/// use ishigaki::{BodyHandle, Drive, Freedom, Joint, Pose, Range, TurnAxis, Vec3};
/// # let (a, b) = (BodyHandle::from((0, 0)), BodyHandle::from((1, 0)));
/// // A shoulder: the arm stays within 0.9 rad of the axis and twists by 0.7 rad each way.
/// let shoulder = Joint::ball_about(a, b, Vec3::ZERO, Vec3::X).cone(0.9).limit(-0.7..=0.7).dry_friction(0.2);
/// // A car's strut: 20 cm of travel, a spring at its middle.
/// let strut = Joint::slider(a, b, Vec3::ZERO, Vec3::Y).limit(-0.1..=0.1).spring(0.0, 30e3, 2e3);
/// // A hip as robots have it: three turns one after the other, each with its own range.
/// let drive = Drive { limit: Some(Range::from(-0.5..=1.2)), armature: 0.01, ..Drive::default() };
/// let axes = [Vec3::X, Vec3::Z, Vec3::Y].map(|axis| TurnAxis { axis, drive });
/// let hip = Joint::generic(a, b, Pose::IDENTITY, [Freedom::Locked; 3], axes.to_vec());
/// for joint in [shoulder, strut, hip] {
///     joint.validate()?;
/// }
/// # Ok::<(), ishigaki::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum JointKind {
    /// A point in common. TALK B7.
    ///
    /// Rotation = twist about x, then swing: the cone bounds the swing in all directions alike, the range the twist.
    /// A cone of π is none. Past 168° of swing twist has no meaning and its range is enforced less and less.
    Ball {
        /// Greatest angle between the two frames' x axes, rad: the neck does not nod further. TALK B9.
        cone: Option<f32>,
        /// Range of the rotation about x, rad.
        twist: Option<Range>,
        /// Dry friction against all rotation, N·m.
        friction: f32,
        /// Damping of all rotation, N·m·s/rad.
        damping: f32,
    },
    /// A point and an axis (x) in common. TALK B8.
    ///
    /// The angle counts on beyond ±π. A new hinge starts on the turn nearest to the middle of its range.
    Hinge {
        /// What acts on the angle.
        drive: Drive,
    },
    /// B slides along A's x axis and does not turn.
    Slider {
        /// What acts on the displacement.
        drive: Drive,
    },
    /// No relative motion.
    Fixed,
    /// The distance of the two anchors is in a range; a rope has lower = 0, a rod lower = upper.
    ///
    /// With a spring the ends of the range stay hard; a range without ends leaves the spring alone.
    Distance {
        /// m.
        range: Range,
        /// Pulls toward a length inside the range; the target is that length, m.
        spring: Option<Spring>,
    },
    /// Any of six coordinates: displacements along A's x, y, z, then up to three turns one after the other,
    /// the first axis fixed to A, the last to B.
    ///
    /// An effort on one angle does work on that angle alone. Three turns meet gimbal lock where their axes fall into
    /// one plane: all stays finite there, but ranges of the outer two mean little; keep the middle one's range clear
    /// of it.
    Generic {
        /// Along x, y, z of frame A.
        linear: [Freedom; 3],
        /// In sequence; directions that no axis turns about are locked.
        angular: Vec<TurnAxis>,
    },
}

/// Where the joint's frame sits on each body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum JointFrames {
    /// One frame in the world at the time of adding; both bodies take it over as they stand.
    World(Pose),
    /// In each body's own frame.
    Local {
        /// On A.
        a: Pose,
        /// On B.
        b: Pose,
    },
}

/// The definition of a joint between two bodies.
///
/// A coordinate (angle, displacement) is that of B relative to A, right-handed about A's axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Joint {
    /// For people; need not be unique.
    pub name: String,
    /// First body.
    pub body_a: BodyHandle,
    /// Second body.
    pub body_b: BodyHandle,
    /// What it allows.
    pub kind: JointKind,
    /// Where it sits.
    pub frames: JointFrames,
    /// Whether the two bodies may touch each other.
    pub collide: bool,
    /// It breaks when it carries more than this, N.
    #[serde(with = "crate::number::optional")]
    pub break_force: Option<f32>,
    /// It breaks when it carries more than this, N·m.
    #[serde(with = "crate::number::optional")]
    pub break_torque: Option<f32>,
}

impl Joint {
    /// A joint of a kind at a world frame.
    pub fn new(body_a: BodyHandle, body_b: BodyHandle, kind: JointKind, frame: Pose) -> Self {
        Self {
            name: String::new(),
            body_a,
            body_b,
            kind,
            frames: JointFrames::World(frame),
            collide: false,
            break_force: None,
            break_torque: None,
        }
    }

    /// A point in common, world, m.
    pub fn ball(body_a: BodyHandle, body_b: BodyHandle, anchor: Vec3) -> Self {
        let kind = JointKind::Ball { cone: None, twist: None, friction: 0.0, damping: 0.0 };
        Self::new(body_a, body_b, kind, Pose::from_translation(anchor))
    }

    /// A ball joint whose cone and twist limits are about `axis` (world).
    pub fn ball_about(body_a: BodyHandle, body_b: BodyHandle, anchor: Vec3, axis: Vec3) -> Self {
        let mut joint = Self::ball(body_a, body_b, anchor);
        joint.frames = JointFrames::World(frame_about(anchor, axis));
        joint
    }

    /// A point and an axis in common, world.
    pub fn hinge(body_a: BodyHandle, body_b: BodyHandle, anchor: Vec3, axis: Vec3) -> Self {
        Self::new(body_a, body_b, JointKind::Hinge { drive: Drive::default() }, frame_about(anchor, axis))
    }

    /// B slides along an axis (world) of A.
    pub fn slider(body_a: BodyHandle, body_b: BodyHandle, anchor: Vec3, axis: Vec3) -> Self {
        Self::new(body_a, body_b, JointKind::Slider { drive: Drive::default() }, frame_about(anchor, axis))
    }

    /// No relative motion.
    pub fn fixed(body_a: BodyHandle, body_b: BodyHandle, anchor: Vec3) -> Self {
        Self::new(body_a, body_b, JointKind::Fixed, Pose::from_translation(anchor))
    }

    /// Holds two points, given in the bodies' own frames, at a distance in a range, m.
    pub fn distance(
        body_a: BodyHandle,
        body_b: BodyHandle,
        anchor_a: Vec3,
        anchor_b: Vec3,
        range: impl Into<Range>,
    ) -> Self {
        let kind = JointKind::Distance { range: range.into(), spring: None };
        let mut joint = Self::new(body_a, body_b, kind, Pose::IDENTITY);
        joint.frames = JointFrames::Local { a: Pose::from_translation(anchor_a), b: Pose::from_translation(anchor_b) };
        joint.collide = true;
        joint
    }

    /// A distance of at most `length`, m.
    pub fn rope(body_a: BodyHandle, body_b: BodyHandle, anchor_a: Vec3, anchor_b: Vec3, length: f32) -> Self {
        Self::distance(body_a, body_b, anchor_a, anchor_b, 0.0..=length)
    }

    /// Six coordinates, see [`JointKind::Generic`].
    pub fn generic(
        body_a: BodyHandle,
        body_b: BodyHandle,
        frame: Pose,
        linear: [Freedom; 3],
        angular: Vec<TurnAxis>,
    ) -> Self {
        Self::new(body_a, body_b, JointKind::Generic { linear, angular }, frame)
    }

    /// For people; need not be unique.
    #[must_use]
    pub fn named(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// Range of the angle (hinge, rad), displacement (slider, m) or twist (ball, rad).
    #[must_use]
    pub fn limit(mut self, range: impl Into<Range>) -> Self {
        let range = range.into();
        match &mut self.kind {
            JointKind::Hinge { drive } | JointKind::Slider { drive } => drive.limit = Some(range),
            JointKind::Ball { twist, .. } => *twist = Some(range),
            JointKind::Distance { range: r, .. } => *r = range,
            JointKind::Fixed | JointKind::Generic { .. } => {}
        }
        self
    }

    /// Greatest angle between the x axes of the two frames of a ball joint, rad.
    #[must_use]
    pub fn cone(mut self, angle: f32) -> Self {
        if let JointKind::Ball { cone, .. } = &mut self.kind {
            *cone = Some(angle);
        }
        self
    }

    /// Drives a hinge (rad/s, N·m) or slider (m/s, N).
    #[must_use]
    pub fn motor(mut self, speed: f32, max_effort: f32) -> Self {
        if let JointKind::Hinge { drive } | JointKind::Slider { drive } = &mut self.kind {
            drive.motor = Some(Motor { speed, max_effort });
        }
        self
    }

    /// A spring on a hinge, slider or distance.
    #[must_use]
    pub fn spring(mut self, target: f32, stiffness: f32, damping: f32) -> Self {
        let value = Some(Spring { target, stiffness, damping });
        match &mut self.kind {
            JointKind::Hinge { drive } | JointKind::Slider { drive } => drive.spring = value,
            JointKind::Distance { spring, .. } => *spring = value,
            _ => {}
        }
        self
    }

    /// Dry friction on a hinge, slider or ball, N·m or N.
    #[must_use]
    pub fn dry_friction(mut self, effort: f32) -> Self {
        match &mut self.kind {
            JointKind::Hinge { drive } | JointKind::Slider { drive } => drive.friction = effort,
            JointKind::Ball { friction, .. } => *friction = effort,
            _ => {}
        }
        self
    }

    /// Lets the two bodies touch each other.
    #[must_use]
    pub fn colliding(mut self) -> Self {
        self.collide = true;
        self
    }

    /// Breaks above a force, N, or a torque, N·m.
    #[must_use]
    pub fn breaking(mut self, force: f32, torque: f32) -> Self {
        self.break_force = Some(force);
        self.break_torque = Some(torque);
        self
    }

    /// Refuses definitions that make no sense; names the field.
    ///
    /// # Errors
    /// The first field that is not finite, a range whose ends are exchanged, a body joined to itself.
    pub fn validate(&self) -> Result<()> {
        if self.body_a == self.body_b {
            return Err(Error::invalid("body_b", "must differ from body_a: a body cannot be joined to itself"));
        }
        match self.frames {
            JointFrames::World(pose) => frame("frame", pose)?,
            JointFrames::Local { a, b } => {
                frame("frame_a", a)?;
                frame("frame_b", b)?;
            }
        }
        threshold("break_force", self.break_force)?;
        threshold("break_torque", self.break_torque)?;
        self.kind.validate()
    }
}

/// The world frame at `anchor` whose x axis is `axis`.
pub(crate) fn frame_about(anchor: Vec3, axis: Vec3) -> Pose {
    // A bad axis gives a bad rotation, which `validate` names.
    let rotation = match axis.try_normalize() {
        Some(unit) => Quat::from_rotation_arc(Vec3::X, unit),
        None => Quat::from_xyzw(0.0, 0.0, 0.0, 0.0),
    };
    Pose::from_parts(anchor, rotation)
}

fn frame(place: &str, pose: Pose) -> Result<()> {
    finite_vector(&format!("{place}.position"), pose.translation)?;
    let length = pose.rotation.length();
    if length.is_finite() && (length - 1.0).abs() < 1e-3 {
        Ok(())
    } else {
        Err(Error::invalid(
            format!("{place}.rotation"),
            format!("must be a unit quaternion, has length {length} (is the axis zero or not finite?)"),
        ))
    }
}

fn threshold(place: &str, value: Option<f32>) -> Result<()> {
    // Infinity is a threshold that is never reached.
    match value {
        Some(v) if v.is_nan() || v <= 0.0 => Err(Error::invalid(place, format!("must be > 0, is {v}"))),
        _ => Ok(()),
    }
}

impl Range {
    fn validate(&self, place: &str) -> Result<()> {
        if self.lower.is_nan() || self.upper.is_nan() {
            return Err(Error::invalid(place, "must not be NaN"));
        }
        if self.lower > self.upper {
            let message = format!("ends are exchanged: lower {} > upper {}", self.lower, self.upper);
            return Err(Error::invalid(place, message));
        }
        Ok(())
    }
}

impl Spring {
    fn validate(&self, place: &str) -> Result<()> {
        crate::error::finite(&format!("{place}.target"), self.target)?;
        not_negative(&format!("{place}.stiffness"), self.stiffness)?;
        not_negative(&format!("{place}.damping"), self.damping)?;
        Ok(())
    }
}

impl Drive {
    fn validate(&self, place: &str) -> Result<()> {
        if let Some(limit) = &self.limit {
            limit.validate(&format!("{place}.limit"))?;
        }
        if let Some(motor) = &self.motor {
            crate::error::finite(&format!("{place}.motor.speed"), motor.speed)?;
            if motor.max_effort.is_nan() || motor.max_effort < 0.0 {
                return Err(Error::invalid(
                    format!("{place}.motor.max_effort"),
                    format!("must be ≥ 0, is {}", motor.max_effort),
                ));
            }
        }
        if let Some(spring) = &self.spring {
            spring.validate(&format!("{place}.spring"))?;
        }
        not_negative(&format!("{place}.armature"), self.armature)?;
        not_negative(&format!("{place}.friction"), self.friction)?;
        Ok(())
    }
}

impl JointKind {
    fn validate(&self) -> Result<()> {
        match self {
            Self::Ball { cone, twist, friction, damping } => {
                if let Some(cone) = cone
                    && !(0.0..=std::f32::consts::PI).contains(cone)
                {
                    return Err(Error::invalid("cone", format!("must be in [0, π] rad, is {cone}")));
                }
                if let Some(twist) = twist {
                    twist.validate("twist")?;
                }
                not_negative("friction", *friction)?;
                not_negative("damping", *damping)?;
                Ok(())
            }
            Self::Hinge { drive } | Self::Slider { drive } => drive.validate("drive"),
            Self::Fixed => Ok(()),
            Self::Distance { range, spring } => {
                range.validate("range")?;
                if range.lower < 0.0 {
                    return Err(Error::invalid("range", format!("a distance is ≥ 0, lower is {}", range.lower)));
                }
                if let Some(spring) = spring {
                    spring.validate("spring")?;
                }
                Ok(())
            }
            Self::Generic { linear, angular } => {
                for (i, freedom) in linear.iter().enumerate() {
                    if let Freedom::Free(drive) = freedom {
                        drive.validate(&format!("linear[{i}]"))?;
                    }
                }
                if angular.len() > 3 {
                    return Err(Error::invalid("angular", format!("at most 3 axes, has {}", angular.len())));
                }
                for (i, turn) in angular.iter().enumerate() {
                    direction(&format!("angular[{i}].axis"), turn.axis)?;
                    turn.drive.validate(&format!("angular[{i}]"))?;
                }
                independent(angular)
            }
        }
    }
}

/// Two turns about one line, or three in one plane, are not coordinates.
fn independent(angular: &[TurnAxis]) -> Result<()> {
    let axes: Vec<Vec3> = angular.iter().map(|t| t.axis.normalize_or_zero()).collect();
    let degenerate = match axes[..] {
        [a, b] => a.cross(b).length() < 1e-2,
        [a, b, c] => a.cross(b).dot(c).abs() < 1e-2,
        _ => false,
    };
    if degenerate {
        return Err(Error::invalid("angular", "the axes must be independent: two are parallel or three in one plane"));
    }
    Ok(())
}
