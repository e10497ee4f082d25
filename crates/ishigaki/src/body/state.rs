//! The live state of bodies and shapes in a world.

use super::{Body, BodyKind, MassSource};
use crate::constraint::joint_rows::BodyFrame;
use crate::error::{Error, Result};
use crate::handle::BodyHandle;
use crate::mass::MassProperties;
use crate::math::{Mat3, Pose, Quat, Vec3, rotated_diagonal, vector_from_rotation, without_dust};
use crate::motion::Spin;
use crate::motion::forces::limited;
use crate::shape::{Geometry, Shape};
use serde::{Deserialize, Serialize};
use smallvec::SmallVec;

/// The state of a body in a world.
///
/// The center of mass is what moves; the pose of the origin follows from it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct BodyState {
    pub(crate) kind: BodyKind,
    pub(crate) name: Box<str>,
    /// Center of mass, world, m.
    pub(crate) center: Vec3,
    /// world_from_local.
    pub(crate) rotation: Quat,
    pub(crate) velocity: Vec3,
    pub(crate) angular_velocity: Vec3,
    /// About the center, world, kg·m²/s: the state of the rotation; ω follows from it.
    pub(crate) angular_momentum: Vec3,
    pub(crate) mass: MassProperties,
    pub(crate) inverse_mass: f32,
    /// About the principal axes, 1/(kg·m²).
    pub(crate) inverse_principal_inertia: Vec3,
    /// Sum of user forces for the next step, N, and torques about the center, N·m.
    pub(crate) force: Vec3,
    pub(crate) torque: Vec3,
    pub(crate) gravity_scale: f32,
    pub(crate) linear_damping: f32,
    pub(crate) angular_damping: f32,
    pub(crate) locked_translation: [bool; 3],
    pub(crate) locked_rotation: [bool; 3],
    pub(crate) continuous: bool,
    pub(crate) can_sleep: bool,
    /// Where a kinematic body shall be at the end of the next step.
    pub(crate) kinematic_target: Option<Box<Pose>>,
    /// Slots of its shapes in the world.
    pub(crate) shapes: SmallVec<[u32; 2]>,
    /// Origin at the start of the last step, for interpolation.
    pub(crate) previous_pose: Pose,
    /// The velocity came from a kinematic target, so it ends with the step.
    pub(crate) target_driven: bool,
    /// Takes no part because its numbers are not finite.
    pub(crate) broken: bool,
    /// Its user changed it since the last step: what rests on it looks again.
    pub(crate) edited: bool,
    /// Contacts that carry more are reported, N.
    pub(crate) force_threshold: Option<f32>,
    pub(crate) asleep: bool,
    /// How long it has been slow enough to sleep, s.
    pub(crate) rest_time: f32,
    /// How many steps in a row it has been slow enough for aggressive sleep.
    pub(crate) rest_steps: u32,
    /// Step until which level correction leaves the island alone whose first body this is.
    pub(crate) no_correction_until: u64,
    /// Hops from the ground; [`NO_HEIGHT`] where there is no way down.
    pub(crate) height: u32,
    /// Island of the last step, for people and pictures.
    pub(crate) island: u32,
}

/// The height of a body that is not carried by the ground.
pub const NO_HEIGHT: u32 = u32::MAX;

impl BodyState {
    /// What moves it.
    pub fn kind(&self) -> BodyKind {
        self.kind
    }

    /// The name it was given.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Place of its origin.
    pub fn pose(&self) -> Pose {
        Pose::from_parts(self.center - self.rotation * self.mass.center, self.rotation)
    }

    /// Place of its origin, m.
    pub fn position(&self) -> Vec3 {
        self.pose().translation
    }

    /// world_from_local.
    pub fn rotation(&self) -> Quat {
        self.rotation
    }

    /// Center of mass, world, m.
    pub fn center(&self) -> Vec3 {
        self.center
    }

    /// Of the center of mass, m/s.
    pub fn velocity(&self) -> Vec3 {
        self.velocity
    }

    /// World, rad/s.
    pub fn angular_velocity(&self) -> Vec3 {
        self.angular_velocity
    }

    /// About the center of mass, world, kg·m²/s.
    pub fn angular_momentum(&self) -> Vec3 {
        self.angular_momentum
    }

    /// Mass (kg), center and inertia, in the body's frame.
    pub fn mass_properties(&self) -> &MassProperties {
        &self.mass
    }

    /// kg; infinite if it is not dynamic.
    pub fn mass(&self) -> f32 {
        if self.kind == BodyKind::Dynamic { self.mass.mass } else { f32::INFINITY }
    }

    /// Velocity of a world point that moves with the body, m/s. TALK B2.
    pub fn velocity_at(&self, point: Vec3) -> Vec3 {
        self.velocity + self.angular_velocity.cross(point - self.center)
    }

    /// Whether its island sleeps.
    pub fn is_asleep(&self) -> bool {
        self.asleep
    }

    /// Hops from the ground over contacts; `None` where there is no way down. TALK D5.
    pub fn height(&self) -> Option<u32> {
        (self.height != NO_HEIGHT).then_some(self.height)
    }

    /// Number of its island in the last step.
    pub fn island(&self) -> u32 {
        self.island
    }

    /// Kinetic energy, J.
    pub fn kinetic_energy(&self) -> f32 {
        if self.kind != BodyKind::Dynamic {
            return 0.0;
        }
        0.5 * self.mass.mass * self.velocity.length_squared() + 0.5 * self.angular_momentum.dot(self.angular_velocity)
    }

    /// Pose between the last two steps: `alpha` 0 is the start of the last step, 1 its end.
    pub fn interpolated_pose(&self, alpha: f32) -> Pose {
        let now = self.pose();
        Pose::from_parts(
            self.previous_pose.translation.lerp(now.translation, alpha),
            self.previous_pose.rotation.slerp(now.rotation, alpha),
        )
    }

    /// The state of a definition that has been validated; `shapes` laid out flat.
    pub(crate) fn new(body: &Body, shapes: &[Shape]) -> Result<Self> {
        let mass = match body.mass {
            MassSource::Shapes => MassProperties::of_shapes(shapes),
            MassSource::Mass(mass) => {
                let of_shapes = MassProperties::of_shapes(shapes);
                if of_shapes.mass > 0.0 {
                    of_shapes.with_mass(mass)
                } else {
                    let unit: Vec<Shape> =
                        shapes.iter().filter(|s| !s.sensor).map(|s| s.clone().density(1.0)).collect();
                    MassProperties::of_shapes(&unit).with_mass(mass)
                }
            }
            MassSource::Explicit(properties) => properties,
        };
        let dynamic = body.kind == BodyKind::Dynamic;
        if dynamic {
            mass.validate().map_err(|e| {
                let message = "a dynamic body needs mass and inertia: give it a solid shape with density > 0, or explicit mass properties";
                Error::invalid("mass", format!("{message} ({e})"))
            })?;
        }
        let rotation = body.pose.rotation.normalize();
        let invert = |i: f32| if dynamic && i > 0.0 { 1.0 / i } else { 0.0 };
        let inverse_inertia = Vec3::from_array(mass.principal_inertia.to_array().map(invert));
        let inverse_mass = if dynamic { 1.0 / mass.mass } else { 0.0 };
        if !(inverse_mass.is_finite() && inverse_inertia.is_finite()) {
            return Err(Error::invalid("mass", format!("too small to be inverted: {} kg", mass.mass)));
        }
        let mut state = Self {
            kind: body.kind,
            name: body.name.clone().into_boxed_str(),
            center: body.pose.translation + rotation * mass.center,
            rotation,
            velocity: if body.kind == BodyKind::Fixed { Vec3::ZERO } else { body.velocity },
            angular_velocity: if body.kind == BodyKind::Fixed { Vec3::ZERO } else { body.angular_velocity },
            angular_momentum: Vec3::ZERO,
            mass,
            inverse_mass,
            inverse_principal_inertia: inverse_inertia,
            force: Vec3::ZERO,
            torque: Vec3::ZERO,
            gravity_scale: body.gravity_scale,
            linear_damping: body.linear_damping,
            angular_damping: body.angular_damping,
            locked_translation: body.locked_translation,
            locked_rotation: body.locked_rotation,
            continuous: body.continuous,
            can_sleep: body.can_sleep,
            kinematic_target: None,
            shapes: SmallVec::new(),
            previous_pose: Pose::from_parts(body.pose.translation, rotation),
            target_driven: false,
            broken: false,
            edited: false,
            force_threshold: None,
            asleep: false,
            rest_time: 0.0,
            rest_steps: 0,
            no_correction_until: 0,
            height: NO_HEIGHT,
            island: 0,
        };
        state.velocity *= unlocked(state.locked_translation);
        state.angular_velocity *= unlocked(state.locked_rotation);
        state.angular_momentum = state.inertia_world() * state.angular_velocity;
        Ok(state)
    }

    /// Awake, and not at rest for either kind of sleep; numbers are looked at again.
    pub(crate) fn wake(&mut self) {
        self.asleep = false;
        self.rest_time = 0.0;
        self.rest_steps = 0;
    }

    /// It gained or lost a contact: its pairs thaw; if it slept, it wakes. Whether it slept.
    pub(crate) fn feel_change(&mut self) -> bool {
        self.rest_steps = 0;
        let slept = self.asleep;
        if slept {
            self.wake();
        }
        slept
    }

    pub(crate) fn put_to_sleep(&mut self) {
        self.asleep = true;
        self.previous_pose = self.pose();
        self.velocity = Vec3::ZERO;
        self.angular_velocity = Vec3::ZERO;
        self.angular_momentum = Vec3::ZERO;
    }

    /// R, L and ω with the inertia that ties them.
    pub(crate) fn spin(&self) -> Spin {
        Spin {
            rotation: self.rotation,
            principal_frame: self.mass.principal_frame,
            principal_inertia: self.mass.principal_inertia,
            inverse_principal_inertia: self.inverse_principal_inertia,
            angular_momentum: self.angular_momentum,
            angular_velocity: self.angular_velocity,
        }
    }

    pub(crate) fn frame(&self) -> BodyFrame {
        BodyFrame {
            gyration: self.inverse_inertia_world() * self.angular_momentum.cross(self.angular_velocity),
            ..self.frame_without_gyration()
        }
    }

    /// The same where only poses and velocities are asked for.
    pub(crate) fn frame_without_gyration(&self) -> BodyFrame {
        BodyFrame {
            center: self.center,
            rotation: self.rotation,
            velocity: self.velocity,
            angular_velocity: self.angular_velocity,
            gyration: crate::math::Vec3::ZERO,
        }
    }

    /// Gives a kinematic body the velocity that takes it to its target; without a new one it stops.
    pub(crate) fn aim_at_target(&mut self, dt: f32) {
        (self.velocity, self.angular_velocity) = self.velocities_in_step(dt);
        self.target_driven = false;
    }

    /// Puts a kinematic body exactly where it was sent.
    pub(crate) fn reach_target(&mut self) {
        if let Some(target) = self.kinematic_target.take() {
            self.rotation = target.rotation;
            self.center = target.translation + target.rotation * self.mass.center;
            self.target_driven = true;
        }
    }

    /// Velocity (m/s) and angular velocity (rad/s) with which the coming step begins: those that take a kinematic
    /// body to its target, none where the last target has been reached.
    pub(crate) fn velocities_in_step(&self, dt: f32) -> (Vec3, Vec3) {
        if let Some(target) = &self.kinematic_target {
            let center = target.translation + target.rotation * self.mass.center;
            let turn = vector_from_rotation(target.rotation * self.rotation.conjugate());
            ((center - self.center) / dt, turn / dt)
        } else if self.target_driven {
            (Vec3::ZERO, Vec3::ZERO)
        } else {
            (self.velocity, self.angular_velocity)
        }
    }

    /// Rates and turns that are nothing become it: `math.rs`, `without_dust`. Its angular momentum ends with the last of ω.
    pub(crate) fn forget_dust(&mut self) {
        self.velocity = without_dust(self.velocity);
        let spin = without_dust(self.angular_velocity);
        if spin != self.angular_velocity {
            self.angular_velocity = spin;
            if spin == Vec3::ZERO {
                self.angular_momentum = Vec3::ZERO;
            }
        }
        let [x, y, z, w] = self.rotation.to_array();
        let turn = without_dust(Vec3::new(x, y, z));
        self.rotation = Quat::from_xyzw(turn.x, turn.y, turn.z, w);
    }

    /// Whether the solver moves it in this step.
    pub(crate) fn is_active(&self) -> bool {
        self.kind == BodyKind::Dynamic && !self.asleep && !self.broken
    }

    /// Whether its surface may move without being pushed.
    pub(crate) fn is_moving_kinematic(&self) -> bool {
        self.kind == BodyKind::Kinematic
            && !self.broken
            && (self.kinematic_target.is_some()
                || !self.target_driven && (self.velocity != Vec3::ZERO || self.angular_velocity != Vec3::ZERO))
    }

    /// Whether its pairs must be looked at again: it moves, or its user changed it.
    pub(crate) fn is_stirring(&self) -> bool {
        self.is_active() || self.is_moving_kinematic() || self.edited
    }

    pub(crate) fn has_locked_rotation(&self) -> bool {
        self.locked_rotation.contains(&true)
    }

    pub(crate) fn is_dynamic(&self) -> bool {
        self.kind == BodyKind::Dynamic
    }

    pub(crate) fn is_finite(&self) -> bool {
        // Finite numbers times nothing are nothing, whatever is added up; others never are.
        let vectors = [self.center, self.velocity, self.angular_velocity, self.angular_momentum];
        let nothing: Vec3 = vectors.map(|vector| vector * 0.0).into_iter().sum();
        nothing == Vec3::ZERO && self.rotation * 0.0 == Quat::from_xyzw(0.0, 0.0, 0.0, 0.0)
    }

    /// A user may ask for any speed; the solver sees no faster one than the options allow, m/s and rad/s.
    pub(crate) fn limit_speeds(&mut self, max_speed: f32, max_angular_speed: f32) {
        self.velocity = limited(self.velocity, max_speed);
        let limit = limited(self.angular_velocity, max_angular_speed);
        if limit != self.angular_velocity && self.is_finite() {
            self.angular_velocity = limit;
            self.angular_momentum = self.inertia_world() * limit;
        }
    }

    /// Forces beyond those that reverse the greatest speed within the step could only leave f32; m/s², rad/s².
    pub(crate) fn limit_forces(&mut self, max_acceleration: f32, max_angular_acceleration: f32) {
        if !self.is_active() {
            return;
        }
        if self.force != Vec3::ZERO {
            let inverse_mass = self.inverse_mass;
            self.force = limited_by(self.force, |f| f * inverse_mass, 2.0 * max_acceleration);
        }
        if self.torque != Vec3::ZERO {
            let inverse_inertia = self.inverse_inertia_world();
            self.torque = limited_by(self.torque, |t| inverse_inertia * t, 2.0 * max_angular_acceleration);
        }
    }

    /// Rotation of the principal axes of inertia: world_from_principal.
    pub(crate) fn world_from_principal(&self) -> Quat {
        self.rotation * self.mass.principal_frame
    }

    /// I⁻¹ in world, with locked axes taken out, 1/(kg·m²). TALK A4.
    pub(crate) fn inverse_inertia_world(&self) -> Mat3 {
        let mut inverse = rotated_diagonal(self.world_from_principal(), self.inverse_principal_inertia);
        let keep = unlocked(self.locked_rotation);
        inverse = Mat3::from_cols(
            inverse.x_axis * keep * keep.x,
            inverse.y_axis * keep * keep.y,
            inverse.z_axis * keep * keep.z,
        );
        inverse
    }

    /// I in world, kg·m².
    pub(crate) fn inertia_world(&self) -> Mat3 {
        rotated_diagonal(self.world_from_principal(), self.mass.principal_inertia)
    }

    /// Inverse mass by world axis: zero along locked axes, 1/kg.
    pub(crate) fn inverse_mass_by_axis(&self) -> Vec3 {
        unlocked(self.locked_translation) * self.inverse_mass
    }
}

/// The vector, shortened so that its `effect` (linear) is no longer than `most`.
fn limited_by(vector: Vec3, effect: impl Fn(Vec3) -> Vec3, most: f32) -> Vec3 {
    // In units of the largest component: squares of large ones would overflow.
    let largest = vector.abs().max_element();
    let unit = vector / largest;
    let per_unit = effect(unit).length();
    if per_unit * largest > most { unit * (most / per_unit) } else { vector }
}

/// 1 for free axes, 0 for locked ones.
pub(crate) fn unlocked(locked: [bool; 3]) -> Vec3 {
    Vec3::from_array(locked.map(|l| if l { 0.0 } else { 1.0 }))
}

/// A shape of a body in a world.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct ShapeState {
    pub body: u32,
    /// Which shape of its body.
    pub ordinal: u32,
    pub shape: Shape,
    /// From the center of mass to its origin, in the body's frame, m.
    pub offset: Vec3,
    /// Radius of the largest ball about its centroid inside it, m: what sweeping compares motion with.
    pub inner_radius: f32,
    /// It was placed by its user, or may touch others now: its pairs are found anew.
    pub moved: bool,
    /// Fat bounds in the broad phase.
    pub bounds_min: Vec3,
    pub bounds_max: Vec3,
}

impl ShapeState {
    pub fn new(body: u32, ordinal: u32, mut shape: Shape, state: &BodyState) -> Self {
        shape.pose.rotation = shape.pose.rotation.normalize();
        Self {
            body,
            ordinal,
            inner_radius: shape.geometry.inner_radius(),
            offset: shape.pose.translation - state.mass.center,
            shape,
            moved: true,
            bounds_min: Vec3::ZERO,
            bounds_max: Vec3::ZERO,
        }
    }

    /// Bounds without any margin, world.
    pub fn tight_bounds(&self, body: &BodyState) -> (Vec3, Vec3) {
        self.shape.geometry.bounds(&self.world_from_shape(body))
    }

    /// The same of a ball about the center of mass, which no rotation moves.
    pub fn ball_bounds(&self, body: &BodyState) -> Option<(Vec3, Vec3)> {
        let Geometry::Ball { radius } = self.shape.geometry else { return None };
        (self.offset == Vec3::ZERO).then(|| (body.center - radius, body.center + radius))
    }

    pub fn world_from_shape(&self, body: &BodyState) -> Pose {
        // Of most bodies it is their own.
        if self.offset == Vec3::ZERO && self.shape.pose.rotation == Quat::IDENTITY {
            return Pose::from_parts(body.center, body.rotation);
        }
        Pose::from_parts(body.center, body.rotation) * Pose::from_parts(self.offset, self.shape.pose.rotation)
    }
}

/// Names a shape of a body in a world: the body and which of its shapes (compounds laid out flat).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct ShapeId {
    /// The body.
    pub body: BodyHandle,
    /// Which of its shapes.
    pub ordinal: u32,
}
