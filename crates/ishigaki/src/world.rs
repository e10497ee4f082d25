//! The world: owns all state.

use crate::body::{Body, BodyState, ShapeId, ShapeState};
use crate::collision::broad_phase::BroadPhase;
use crate::collision::contact_list;
use crate::collision::manifold::{Contact, Manifold};
use crate::collision::pair::PairList;
use crate::constraint::joint::Joint;
use crate::constraint::joint_rows::ResolvedJoint;
use crate::error::{Error, Result};
use crate::event::Event;
use crate::handle::{Arena, BodyHandle, JointHandle};
use crate::math::{Pose, Vec3};
use crate::options::WorldOptions;
use crate::report::StepReport;
use crate::shape::Shape;
use crate::solver::permutation::Random;
use crate::step::Scratch;
use crate::threads::Workers;
use serde::{Deserialize, Serialize};
use smallvec::{SmallVec, smallvec};

/// All bodies, shapes, joints and contacts, and what is remembered between steps.
///
/// `Clone` and serialisable (as its [`snapshot`](Self::snapshot)): a restored world continues bit for bit.
#[derive(Clone, Debug)]
pub struct World {
    pub(crate) options: WorldOptions,
    pub(crate) bodies: Arena<BodyState>,
    pub(crate) shapes: Arena<ShapeState>,
    pub(crate) joints: Arena<JointState>,
    /// Pairs whose bounds overlap, sorted by (shape_a, shape_b).
    pub(crate) pairs: PairList,
    /// Those of them with contact points, in the same order, and for some steps those that had them.
    pub(crate) contacts: Vec<Contact>,
    /// Pairs of bodies that never touch because the user said so; sorted, each (low slot, high slot).
    pub(crate) excluded: Vec<(u32, u32)>,
    /// Pairs of bodies that never touch because a joint says so; sorted.
    pub(crate) jointed: Vec<(u32, u32)>,
    pub(crate) events: Vec<Event>,
    /// Events of edits between steps, reported with the next step.
    pub(crate) pending_events: Vec<Event>,
    pub(crate) report: StepReport,
    pub(crate) random: Random,
    /// Length of the last substep, s: impulses are scaled when it changes.
    pub(crate) last_substep: f32,
    /// Steps taken.
    pub(crate) step_count: u64,
    /// Sum of all Δt, s.
    pub(crate) time: f64,
    /// Rebuilt from the shapes' bounds after restoring.
    pub(crate) broad_phase: BroadPhase,
    /// Arrays that are used again in each step; nothing in them outlives a step.
    pub(crate) scratch: Scratch,
    /// What it may run on; no part of its state.
    pub(crate) workers: Workers,
}

/// The state of a joint in a world.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct JointState {
    /// Elsewhere: most steps do not look at it, but pass over all joints.
    pub(crate) definition: Box<Joint>,
    pub(crate) resolved: ResolvedJoint,
    /// Impulses of the last substep, one for each row: the warm start.
    pub(crate) lambdas: SmallVec<[f32; 6]>,
    /// Mean over the last step, world, N and N·m on A.
    pub(crate) force: Vec3,
    pub(crate) torque: Vec3,
    pub(crate) anchor_error: f32,
    pub(crate) angle_error: f32,
}

impl JointState {
    /// As it was defined.
    pub fn definition(&self) -> &Joint {
        &self.definition
    }

    /// Mean force on body A over the last step, world, N.
    pub fn force(&self) -> Vec3 {
        self.force
    }

    /// Mean torque on body A about the anchor over the last step, world, N·m.
    pub fn torque(&self) -> Vec3 {
        self.torque
    }

    /// The joint's frame on A and on B, each in the axes of its body and from its center of mass, m.
    pub fn frames_from_centers(&self) -> [Pose; 2] {
        let joint = &self.resolved;
        [Pose::from_parts(joint.anchor_a, joint.frame_a), Pose::from_parts(joint.anchor_b, joint.frame_b)]
    }

    /// Coordinates: angle (hinge, rad), displacement (slider, m), distance (m), or the generic joint's free
    /// coordinates, linear first; empty for fixed joints.
    pub fn coordinates(&self) -> &[f32] {
        self.resolved.coordinates()
    }

    /// Distance between the two anchors where they should coincide, at the end of the last step, m.
    pub fn anchor_error(&self) -> f32 {
        self.anchor_error
    }

    /// How far an angle is beyond its range, or an axis from the one it should be on, at the end of the last step, rad.
    pub fn angle_error(&self) -> f32 {
        self.angle_error
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

/// A body that is being edited: it is awake afterwards, and its contacts are found anew.
#[derive(Debug)]
pub struct BodyMut<'a> {
    pub(crate) body: &'a mut BodyState,
    pub(crate) shapes: &'a mut Arena<ShapeState>,
    pub(crate) broad_phase: &'a mut BroadPhase,
}

impl Default for World {
    /// An empty world with default options.
    fn default() -> Self {
        let options = WorldOptions::default();
        Self {
            random: Random(options.seed),
            options,
            bodies: Arena::default(),
            shapes: Arena::default(),
            joints: Arena::default(),
            pairs: PairList::default(),
            contacts: Vec::new(),
            excluded: Vec::new(),
            jointed: Vec::new(),
            events: Vec::new(),
            pending_events: Vec::new(),
            report: StepReport::default(),
            last_substep: 0.0,
            step_count: 0,
            time: 0.0,
            broad_phase: BroadPhase::default(),
            scratch: Scratch::default(),
            workers: Workers::default(),
        }
    }
}

impl World {
    /// An empty world.
    ///
    /// # Errors
    /// An option that is not finite or out of its range.
    pub fn new(options: WorldOptions) -> Result<Self> {
        options.validate()?;
        Ok(Self { random: Random(options.seed), options, ..Self::default() })
    }

    /// The options.
    pub fn options(&self) -> &WorldOptions {
        &self.options
    }

    /// Changes the options; wakes everything. A new seed starts the random order anew.
    ///
    /// # Errors
    /// An option that is not finite or out of its range; the old options stay.
    pub fn set_options(&mut self, options: WorldOptions) -> Result<()> {
        options.validate()?;
        if options.seed != self.options.seed {
            self.random = Random(options.seed);
        }
        self.options = options;
        self.disturb();
        for (_, body) in self.bodies.iter_mut() {
            body.wake();
        }
        Ok(())
    }

    /// Adds a body.
    ///
    /// # Errors
    /// A definition that makes no sense; nothing is added.
    pub fn add_body(&mut self, body: Body) -> Result<BodyHandle> {
        body.validate()?;
        let shapes = body.flat_shapes();
        let state = BodyState::new(&body, &shapes)?;
        Ok(self.insert_body(state, shapes))
    }

    /// Adds many bodies, or none if one of them is bad.
    ///
    /// # Errors
    /// The first definition that makes no sense, its place prefixed with `bodies[i]`.
    pub fn add_bodies(&mut self, bodies: Vec<Body>) -> Result<Vec<BodyHandle>> {
        let mut states = Vec::with_capacity(bodies.len());
        for (i, body) in bodies.iter().enumerate() {
            let named = |e: Error| e.within(&format!("bodies[{i}]"));
            body.validate().map_err(named)?;
            let shapes = body.flat_shapes();
            states.push((BodyState::new(body, &shapes).map_err(named)?, shapes));
        }
        Ok(states.into_iter().map(|(state, shapes)| self.insert_body(state, shapes)).collect())
    }

    fn insert_body(&mut self, state: BodyState, shapes: Vec<Shape>) -> BodyHandle {
        self.disturb();
        let handle = BodyHandle::from(self.bodies.insert(state));
        let index = handle.index;
        for (ordinal, shape) in shapes.into_iter().enumerate() {
            let body = self.bodies.at(index);
            self.scratch.groups = self.scratch.groups.map(|groups| groups.and(shape.groups));
            let shape_state = ShapeState::new(index, ordinal as u32, shape, body);
            let (min, max) = shape_state.tight_bounds(body);
            let (slot, _) = self.shapes.insert(ShapeState { bounds_min: min, bounds_max: max, ..shape_state });
            self.broad_phase.insert(slot, min, max);
            self.bodies.at_mut(index).shapes.push(slot);
        }
        handle
    }

    /// Removes a body with its shapes, contacts and joints; wakes what it touched. `false` if the handle is stale.
    pub fn remove_body(&mut self, handle: BodyHandle) -> bool {
        if self.bodies.get(handle.into()).is_none() {
            return false;
        }
        self.disturb();
        self.scratch.roles.clear();
        let index = handle.index;
        let mut ended = Vec::new();
        for contact in self.contacts.iter().filter(|c| c.touching && (c.body_a == index || c.body_b == index)) {
            ended.push((contact.shape_a, contact.shape_b, contact.sensor));
        }
        self.drop_pairs_of(index);
        for (a, b, sensor) in ended {
            let event = self.touch_event(a, b, sensor, false);
            self.pending_events.push(event);
        }
        self.excluded.retain(|&(a, b)| a != index && b != index);
        let jointed: Vec<_> = self
            .joints()
            .filter(|(_, j)| j.definition.body_a == handle || j.definition.body_b == handle)
            .map(|(h, _)| h)
            .collect();
        for joint in jointed {
            self.remove_joint(joint);
        }
        let body = self.bodies.remove(handle.into()).expect("checked above");
        for slot in body.shapes {
            let generation = self.shapes.generation_at(slot);
            self.shapes.remove((slot, generation));
            self.broad_phase.remove(slot);
        }
        true
    }

    /// Forgets the pairs of a body; wakes those it might have carried.
    fn drop_pairs_of(&mut self, index: u32) {
        let (shapes, bodies) = (&self.shapes, &mut self.bodies);
        self.pairs.retain(&mut |pair| {
            let (a, b) = (shapes.at(pair.shape_a), shapes.at(pair.shape_b));
            if a.body != index && b.body != index {
                return true;
            }
            if !(a.shape.sensor || b.shape.sensor) {
                bodies.at_mut(if a.body == index { b.body } else { a.body }).wake();
            }
            false
        });
        let (contacts, links) = (&mut self.contacts, &mut self.scratch.links);
        contact_list::retain(contacts, links, |c| c.body_a != index && c.body_b != index);
    }

    /// A body, unless the handle is stale.
    pub fn body(&self, handle: BodyHandle) -> Option<&BodyState> {
        self.bodies.get(handle.into())
    }

    /// A body to be edited, unless the handle is stale. Its island wakes.
    pub fn body_mut(&mut self, handle: BodyHandle) -> Option<BodyMut<'_>> {
        self.disturb();
        let body = self.bodies.get_mut(handle.into())?;
        body.wake();
        body.edited = true;
        Some(BodyMut { body, shapes: &mut self.shapes, broad_phase: &mut self.broad_phase })
    }

    /// All bodies in slot order.
    pub fn bodies(&self) -> impl Iterator<Item = (BodyHandle, &BodyState)> {
        self.bodies
            .iter()
            .map(|(index, body)| (BodyHandle { index, generation: self.bodies.generation_at(index) }, body))
    }

    pub(crate) fn body_handle(&self, index: u32) -> BodyHandle {
        BodyHandle { index, generation: self.bodies.generation_at(index) }
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

    /// Two bodies never touch from now on.
    ///
    /// # Errors
    /// A stale handle, twice the same body.
    pub fn exclude_pair(&mut self, a: BodyHandle, b: BodyHandle) -> Result<()> {
        let pair = self.checked_pair(a, b)?;
        if let Err(place) = self.excluded.binary_search(&pair) {
            self.excluded.insert(place, pair);
            self.drop_forbidden_pairs();
        }
        Ok(())
    }

    /// Two bodies may touch again.
    ///
    /// # Errors
    /// A stale handle, twice the same body.
    pub fn include_pair(&mut self, a: BodyHandle, b: BodyHandle) -> Result<()> {
        let pair = self.checked_pair(a, b)?;
        if let Ok(place) = self.excluded.binary_search(&pair) {
            self.excluded.remove(place);
            self.find_anew(pair);
        }
        Ok(())
    }

    /// Bounds that overlap already are not reported again unless they move: let both seem to.
    fn find_anew(&mut self, pair: (u32, u32)) {
        for index in [pair.0, pair.1] {
            for &slot in &self.bodies.at(index).shapes {
                self.shapes.at_mut(slot).moved = true;
            }
        }
    }

    fn checked_pair(&mut self, a: BodyHandle, b: BodyHandle) -> Result<(u32, u32)> {
        if a == b {
            return Err(Error::invalid("body_b", "must differ from body_a: it is no pair"));
        }
        self.disturb();
        for (place, handle) in [("body_a", a), ("body_b", b)] {
            self.bodies.get_mut(handle.into()).ok_or_else(|| Error::Stale { place: place.into() })?.wake();
        }
        Ok((a.index.min(b.index), a.index.max(b.index)))
    }

    /// Adds a joint; wakes both bodies.
    ///
    /// # Errors
    /// A definition that makes no sense, a stale handle; nothing is added.
    pub fn add_joint(&mut self, joint: Joint) -> Result<JointHandle> {
        joint.validate()?;
        self.checked_pair(joint.body_a, joint.body_b)?;
        let joint_pair = pair_of(&joint);
        let (a, b) = (self.bodies.at(joint.body_a.index), self.bodies.at(joint.body_b.index));
        let resolved = ResolvedJoint::new(&joint, &a.frame(), a.mass.center, &b.frame(), b.mass.center);
        let rows = resolved.row_count(&joint.kind);
        let state = JointState {
            resolved,
            lambdas: smallvec![0.0; rows],
            force: Vec3::ZERO,
            torque: Vec3::ZERO,
            anchor_error: 0.0,
            angle_error: 0.0,
            definition: Box::new(joint),
        };
        let collides = state.definition.collide;
        let handle = JointHandle::from(self.joints.insert(state));
        self.scratch.joint_links.forget();
        if !collides {
            self.keep_apart(joint_pair);
        }
        Ok(handle)
    }

    /// Changes what a joint allows (limits, motors, springs …); its bodies and frames stay. Wakes both bodies.
    ///
    /// # Errors
    /// A definition that makes no sense, another kind of joint, a stale handle; nothing changes.
    pub fn edit_joint(&mut self, handle: JointHandle, edit: impl FnOnce(&mut Joint)) -> Result<()> {
        let stale = || Error::Stale { place: "joint".into() };
        let old = &self.joints.get(handle.into()).ok_or_else(stale)?.definition;
        let mut joint = Joint::clone(old);
        edit(&mut joint);
        joint.validate()?;
        if std::mem::discriminant(&joint.kind) != std::mem::discriminant(&old.kind) {
            return Err(Error::invalid("kind", "cannot change: remove the joint and add another"));
        }
        (joint.body_a, joint.body_b, joint.frames) = (old.body_a, old.body_b, old.frames);
        let (may_touch_now, pairs_change) = (joint.collide && !old.collide, joint.collide != old.collide);
        let pair = self.checked_pair(joint.body_a, joint.body_b)?;
        if may_touch_now {
            self.find_anew(pair);
        }
        let state = self.joints.get_mut(handle.into()).ok_or_else(stale)?;
        let rows = state.resolved.row_count(&joint.kind);
        if rows != state.lambdas.len() {
            // Rows mean something else now: a warm start would push the wrong way.
            state.lambdas = smallvec![0.0; rows];
        }
        self.scratch.joint_links.change(handle.index, &joint);
        *state.definition = joint;
        // Motors are edited step after step: what does not depend on them stays.
        if pairs_change {
            self.collect_jointed_pairs();
        }
        Ok(())
    }

    /// Removes a joint; wakes both bodies. `false` if the handle is stale.
    pub fn remove_joint(&mut self, handle: JointHandle) -> bool {
        let Some(joint) = self.joints.remove(handle.into()) else { return false };
        self.disturb();
        self.scratch.joint_links.forget();
        for body in [joint.definition.body_a, joint.definition.body_b] {
            if let Some(body) = self.bodies.get_mut(body.into()) {
                body.wake();
                // The two may touch now: find their pairs anew.
                for &slot in &body.shapes {
                    self.shapes.at_mut(slot).moved = true;
                }
            }
        }
        self.collect_jointed_pairs();
        true
    }

    /// A pair of bodies more that do not touch.
    fn keep_apart(&mut self, pair: (u32, u32)) {
        if let Err(at) = self.jointed.binary_search(&pair) {
            self.jointed.insert(at, pair);
            self.drop_forbidden_pairs();
        }
    }

    fn collect_jointed_pairs(&mut self) {
        self.jointed.clear();
        let apart = self.joints.iter().filter(|(_, joint)| !joint.definition.collide);
        self.jointed.extend(apart.map(|(_, joint)| pair_of(&joint.definition)));
        self.jointed.sort_unstable();
        self.jointed.dedup();
        self.drop_forbidden_pairs();
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
        self.contacts.iter().filter(|c| c.touching && !c.sensor).map(|c| ContactView {
            a: self.shape_id(c.shape_a),
            b: self.shape_id(c.shape_b),
            friction: c.friction,
            restitution: c.extras().restitution,
            frozen: c.is_frozen(),
            manifolds: &c.manifolds,
        })
    }

    pub(crate) fn shape_id(&self, slot: u32) -> ShapeId {
        let shape = self.shapes.at(slot);
        ShapeId { body: self.body_handle(shape.body), ordinal: shape.ordinal }
    }

    /// What happened in the last step, and through edits since the step before.
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

    /// Reports contacts of a body that carry more than `force` (N) as [`Event::ContactForce`]; `None` for none.
    /// `false` if the handle is stale or the force is not a number.
    pub fn set_force_threshold(&mut self, handle: BodyHandle, force: Option<f32>) -> bool {
        self.disturb();
        match self.bodies.get_mut(handle.into()) {
            Some(body) if !force.is_some_and(f32::is_nan) => {
                body.force_threshold = force;
                true
            }
            _ => false,
        }
    }
}

/// The slots of a joint's bodies, the smaller first.
fn pair_of(joint: &Joint) -> (u32, u32) {
    let (a, b) = (joint.body_a.index, joint.body_b.index);
    (a.min(b), a.max(b))
}
