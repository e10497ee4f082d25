//! The world: owns all state.

use crate::body::{Body, BodyState, ShapeId, ShapeState};
use crate::collision::manifold::{Contact, Manifold};
use crate::constraint::joint::Joint;
use crate::error::Result;
use crate::event::Event;
use crate::handle::{Arena, BodyHandle, JointHandle};
use crate::math::{Pose, Vec3};
use crate::options::WorldOptions;
use crate::report::StepReport;
use crate::shape::Shape;
use serde::{Deserialize, Serialize};

/// All bodies, shapes, joints and contacts, and what is remembered between steps.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct World {
    pub(crate) options: WorldOptions,
    pub(crate) bodies: Arena<BodyState>,
    pub(crate) shapes: Arena<ShapeState>,
    pub(crate) joints: Arena<JointState>,
    /// Sorted by (shape_a, shape_b).
    pub(crate) contacts: Vec<Contact>,
    pub(crate) events: Vec<Event>,
    pub(crate) report: StepReport,
    /// Steps taken.
    pub(crate) step_count: u64,
    /// Sum of all Δt, s.
    pub(crate) time: f64,
}

/// The state of a joint in a world.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct JointState {
    pub(crate) definition: Joint,
}

impl JointState {
    /// As it was defined.
    pub fn definition(&self) -> &Joint {
        &self.definition
    }

    /// Mean force on body A over the last step, world, N.
    pub fn force(&self) -> Vec3 {
        todo!()
    }

    /// Mean torque on body A at the anchor over the last step, world, N·m.
    pub fn torque(&self) -> Vec3 {
        todo!()
    }

    /// Coordinates: angle (hinge, rad), displacement (slider, m), distance (m), or the generic joint's free
    /// coordinates, linear first; empty for ball and fixed joints.
    pub fn coordinates(&self) -> &[f32] {
        todo!()
    }

    /// Distance between the two anchors where they should coincide, m.
    pub fn anchor_error(&self) -> f32 {
        todo!()
    }
}

/// A pair of shapes with contact points.
#[derive(Clone, Copy, Debug)]
pub struct ContactView<'a> {
    /// First shape.
    pub a: ShapeId,
    /// Second shape.
    pub b: ShapeId,
    /// Mixed Coulomb's μ.
    pub friction: f32,
    /// Mixed Newton's e.
    pub restitution: f32,
    /// Whether aggressive sleep keeps its rows.
    pub frozen: bool,
    /// Normals and points.
    pub manifolds: &'a [Manifold],
}

/// A body that is being edited: the body is awake afterwards.
pub struct BodyMut<'a> {
    pub(crate) body: &'a mut BodyState,
}

impl World {
    /// An empty world.
    ///
    /// # Errors
    /// An option that is not finite or out of its range.
    pub fn new(options: WorldOptions) -> Result<Self> {
        let _ = options;
        todo!()
    }

    /// The options.
    pub fn options(&self) -> &WorldOptions {
        &self.options
    }

    /// Changes the options; wakes everything.
    ///
    /// # Errors
    /// An option that is not finite or out of its range; the old options stay.
    pub fn set_options(&mut self, options: WorldOptions) -> Result<()> {
        let _ = options;
        todo!()
    }

    /// Adds a body.
    ///
    /// # Errors
    /// A definition that makes no sense; nothing is added.
    pub fn add_body(&mut self, body: Body) -> Result<BodyHandle> {
        let _ = body;
        todo!()
    }

    /// Adds many bodies, or none if one of them is bad.
    ///
    /// # Errors
    /// The first definition that makes no sense, its place prefixed with `bodies[i]`.
    pub fn add_bodies(&mut self, bodies: Vec<Body>) -> Result<Vec<BodyHandle>> {
        let _ = bodies;
        todo!()
    }

    /// Removes a body with its shapes, contacts and joints; `false` if the handle is stale.
    pub fn remove_body(&mut self, handle: BodyHandle) -> bool {
        let _ = handle;
        todo!()
    }

    /// A body, unless the handle is stale.
    pub fn body(&self, handle: BodyHandle) -> Option<&BodyState> {
        self.bodies.get(handle.into())
    }

    /// A body to be edited, unless the handle is stale. Its island wakes.
    pub fn body_mut(&mut self, handle: BodyHandle) -> Option<BodyMut<'_>> {
        let _ = handle;
        todo!()
    }

    /// All bodies in slot order.
    pub fn bodies(&self) -> impl Iterator<Item = (BodyHandle, &BodyState)> {
        self.bodies
            .iter()
            .map(|(index, body)| (BodyHandle { index, generation: self.bodies.generation_at(index) }, body))
    }

    /// The shapes of a body (compounds laid out flat), each with its pose in the world.
    pub fn shapes_of(&self, handle: BodyHandle) -> impl Iterator<Item = (ShapeId, &Shape, Pose)> {
        let body = self.bodies.get(handle.into());
        body.into_iter().flat_map(move |body| {
            body.shapes.iter().map(move |&slot| {
                let state = self.shapes.at(slot);
                let id = ShapeId { body: handle, ordinal: state.ordinal };
                (id, &state.shape, state.world_from_shape(body))
            })
        })
    }

    /// Adds a joint.
    ///
    /// # Errors
    /// A definition that makes no sense, a stale handle; nothing is added.
    pub fn add_joint(&mut self, joint: Joint) -> Result<JointHandle> {
        let _ = joint;
        todo!()
    }

    /// Changes what a joint allows (limits, motors, springs); the kind of joint stays. Wakes both bodies.
    ///
    /// # Errors
    /// A definition that makes no sense, a stale handle; nothing changes.
    pub fn edit_joint(&mut self, handle: JointHandle, edit: impl FnOnce(&mut Joint)) -> Result<()> {
        let _ = (handle, edit);
        todo!()
    }

    /// Removes a joint; `false` if the handle is stale.
    pub fn remove_joint(&mut self, handle: JointHandle) -> bool {
        let _ = handle;
        todo!()
    }

    /// A joint, unless the handle is stale.
    pub fn joint(&self, handle: JointHandle) -> Option<&JointState> {
        self.joints.get(handle.into())
    }

    /// All joints in slot order.
    pub fn joints(&self) -> impl Iterator<Item = (JointHandle, &JointState)> {
        self.joints
            .iter()
            .map(|(index, joint)| (JointHandle { index, generation: self.joints.generation_at(index) }, joint))
    }

    /// Pairs with contact points, in a fixed order.
    pub fn contacts(&self) -> impl Iterator<Item = ContactView<'_>> {
        self.contacts.iter().filter(|c| c.touching && !c.sensor).map(|c| self.view(c))
    }

    fn view<'a>(&self, c: &'a Contact) -> ContactView<'a> {
        ContactView {
            a: self.shape_id(c.shape_a),
            b: self.shape_id(c.shape_b),
            friction: c.friction,
            restitution: c.restitution,
            frozen: c.is_frozen(),
            manifolds: &c.manifolds,
        }
    }

    pub(crate) fn shape_id(&self, slot: u32) -> ShapeId {
        let shape = self.shapes.at(slot);
        let body = BodyHandle { index: shape.body, generation: self.bodies.generation_at(shape.body) };
        ShapeId { body, ordinal: shape.ordinal }
    }

    /// Advances by `dt` seconds. Never fails: the report says what happened.
    pub fn step(&mut self, dt: f32) -> StepReport {
        let _ = dt;
        todo!()
    }

    /// What happened in the last step.
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// The report of the last step.
    pub fn report(&self) -> &StepReport {
        &self.report
    }

    /// Steps taken.
    pub fn step_count(&self) -> u64 {
        self.step_count
    }

    /// Sum of all Δt, s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// A hash of all poses and velocities: equal states have equal hashes.
    pub fn state_hash(&self) -> u64 {
        todo!()
    }

    /// All state as bytes, with a version and a checksum.
    pub fn snapshot(&self) -> Vec<u8> {
        todo!()
    }

    /// The world of a snapshot; it continues bit for bit.
    ///
    /// # Errors
    /// Bytes that are no snapshot, are damaged, or are of another version.
    pub fn restore(bytes: &[u8]) -> Result<Self> {
        let _ = bytes;
        todo!()
    }

    /// Reports contacts of a body that carry more than `force` (N) as [`Event::ContactForce`]; `None` for none.
    /// `false` if the handle is stale.
    pub fn set_force_threshold(&mut self, handle: BodyHandle, force: Option<f32>) -> bool {
        let _ = (handle, force);
        todo!()
    }
}

impl BodyMut<'_> {
    /// Moves the origin there at once; the velocity stays.
    ///
    /// # Errors
    /// A pose that is not finite or whose rotation is not a unit quaternion; nothing changes.
    pub fn set_pose(&mut self, pose: Pose) -> Result<()> {
        let _ = pose;
        todo!()
    }

    /// Of the center of mass, m/s.
    ///
    /// # Errors
    /// Not finite; nothing changes.
    pub fn set_velocity(&mut self, velocity: Vec3) -> Result<()> {
        let _ = velocity;
        todo!()
    }

    /// World, rad/s.
    ///
    /// # Errors
    /// Not finite; nothing changes.
    pub fn set_angular_velocity(&mut self, angular_velocity: Vec3) -> Result<()> {
        let _ = angular_velocity;
        todo!()
    }

    /// Where a kinematic body shall be at the end of the next step.
    ///
    /// # Errors
    /// A pose that is not finite, or a body that is not kinematic; nothing changes.
    pub fn set_kinematic_target(&mut self, pose: Pose) -> Result<()> {
        let _ = pose;
        todo!()
    }

    /// A force at the center of mass during the next step, N. TALK A3.
    ///
    /// # Errors
    /// Not finite; nothing changes. The same for all forces, torques and impulses.
    pub fn apply_force(&mut self, force: Vec3) -> Result<()> {
        let _ = force;
        todo!()
    }

    /// A force at a world point during the next step, N.
    ///
    /// # Errors
    /// Not finite; nothing changes.
    pub fn apply_force_at(&mut self, force: Vec3, point: Vec3) -> Result<()> {
        let _ = (force, point);
        todo!()
    }

    /// A torque during the next step, N·m.
    ///
    /// # Errors
    /// Not finite; nothing changes.
    pub fn apply_torque(&mut self, torque: Vec3) -> Result<()> {
        let _ = torque;
        todo!()
    }

    /// An impulse at the center of mass, now, N·s.
    ///
    /// # Errors
    /// Not finite; nothing changes.
    pub fn apply_impulse(&mut self, impulse: Vec3) -> Result<()> {
        let _ = impulse;
        todo!()
    }

    /// An impulse at a world point, now, N·s.
    ///
    /// # Errors
    /// Not finite; nothing changes.
    pub fn apply_impulse_at(&mut self, impulse: Vec3, point: Vec3) -> Result<()> {
        let _ = (impulse, point);
        todo!()
    }

    /// An angular impulse, now, N·m·s.
    ///
    /// # Errors
    /// Not finite; nothing changes.
    pub fn apply_angular_impulse(&mut self, impulse: Vec3) -> Result<()> {
        let _ = impulse;
        todo!()
    }

    /// The state as it is.
    pub fn state(&self) -> &BodyState {
        self.body
    }
}
