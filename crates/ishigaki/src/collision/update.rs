//! Stage `update_contacts`: narrow phase for all pairs that may have changed; λ carried by feature id. TALK D4.

use crate::body::{BodyState, ShapeState};
use crate::collision::continuous;
use crate::collision::manifold::{Contact, ContactPoint, LocalManifold, Manifold};
use crate::collision::narrow_phase::{LocalManifolds, find_manifolds};
use crate::collision::pairs::motion_in_step;
use crate::constraint::contact::share_evenly;
use crate::event::Event;
use crate::hooks::{ContactHooks, PairView};
use crate::island::aggressive_sleep;
use crate::math::{Pose, Vec3};
use crate::options::WorldOptions;
use crate::world::World;
use smallvec::SmallVec;

/// Points up to this apart may bear a part of the load: what rounding leaves of a gap, × length scale.
const CLOSED: f32 = 1e-5;

impl World {
    /// Refreshes every pair that has a moving body and is not frozen; reports touching that began or ended.
    pub(crate) fn update_contacts(&mut self, dt: f32, hooks: Option<&mut (dyn ContactHooks + '_)>) {
        let mut hooks = hooks;
        let mut contacts = std::mem::take(&mut self.contacts);
        let mut scratch = std::mem::take(&mut self.scratch.narrow);
        for contact in &mut contacts {
            self.update_contact(contact, dt, &mut scratch, &mut hooks);
        }
        self.scratch.narrow = scratch;
        self.contacts = contacts;
    }

    fn update_contact(
        &mut self,
        contact: &mut Contact,
        dt: f32,
        scratch: &mut NarrowScratch,
        hooks: &mut Option<&mut (dyn ContactHooks + '_)>,
    ) {
        let (a, b) = (self.bodies.at(contact.body_a), self.bodies.at(contact.body_b));
        let (shape_a, shape_b) = (self.shapes.at(contact.shape_a), self.shapes.at(contact.shape_b));
        if a.broken || b.broken {
            contact.manifolds.clear();
        } else if a.is_stirring() || b.is_stirring() {
            mix_materials(contact, a, b, shape_a, shape_b);
            let options = &self.options;
            if aggressive_sleep::stays_frozen(contact, a, b, options) {
                self.report.frozen += 1;
            } else {
                contact.frozen = None;
                self.report.narrow_phase_calls += 1;
                find_points(contact, a, b, shape_a, shape_b, dt, options, scratch);
                self.report.ids_matched += scratch.matched;
                self.report.ids_expected += scratch.expected;
                aggressive_sleep::freeze_if_at_rest(contact, a, b, options);
            }
            let closed = CLOSED * self.options.length_scale;
            contact.manifolds.iter_mut().for_each(|m| share_evenly(m, closed));
        } else {
            return; // both asleep or fixed: nothing changed
        }
        self.ask_hooks(contact, hooks);
        self.notice_touching(contact);
    }

    fn ask_hooks(&self, contact: &mut Contact, hooks: &mut Option<&mut (dyn ContactHooks + '_)>) {
        let Some(hooks) = hooks else { return };
        if contact.manifolds.is_empty() {
            return;
        }
        let (a, b) = (self.shape_id(contact.shape_a), self.shape_id(contact.shape_b));
        let (body_a, body_b) = (self.bodies.at(contact.body_a), self.bodies.at(contact.body_b));
        let pair = PairView { a, b, body_a, body_b };
        if !hooks.allow(&pair) {
            contact.manifolds.clear();
            contact.frozen = None;
        } else {
            hooks.modify(&pair, contact);
        }
    }

    /// Touching begins at contact and ends when the gap is half the speculative margin: no chatter between.
    fn notice_touching(&mut self, contact: &mut Contact) {
        let options = &self.options;
        let gap = 0.5 * options.contact.speculative_margin * options.length_scale;
        let limit = if contact.sensor {
            0.0
        } else if contact.touching {
            gap
        } else {
            1e-3 * gap
        };
        let touching = contact.manifolds.iter().flat_map(|m| &m.points).any(|p| p.separation <= limit);
        if touching != contact.touching {
            self.set_touching(contact, touching);
        }
    }

    /// What bounced within the step touched, though a gap was there before and after it.
    pub(crate) fn notice_impacts(&mut self) {
        let mut contacts = std::mem::take(&mut self.contacts);
        for contact in contacts.iter_mut().filter(|c| !c.touching && !c.sensor) {
            if contact.manifolds.iter().flat_map(|m| &m.points).any(|p| p.impulse > 0.0) {
                self.set_touching(contact, true);
            }
        }
        self.contacts = contacts;
    }

    fn set_touching(&mut self, contact: &mut Contact, touching: bool) {
        contact.touching = touching;
        if !contact.sensor {
            for index in [contact.body_a, contact.body_b] {
                self.bodies.at_mut(index).feel_change();
            }
        }
        let event = self.touch_event(contact.shape_a, contact.shape_b, contact.sensor, touching);
        self.events.push(event);
    }

    pub(crate) fn touch_event(&self, a: u32, b: u32, sensor: bool, began: bool) -> Event {
        let a_is_sensor = self.shapes.at(a).shape.sensor;
        let (a, b) = (self.shape_id(a), self.shape_id(b));
        let (sensor_id, other) = if a_is_sensor { (a, b) } else { (b, a) };
        match (sensor, began) {
            (false, true) => Event::ContactBegan { a, b },
            (false, false) => Event::ContactEnded { a, b },
            (true, true) => Event::SensorEntered { sensor: sensor_id, other },
            (true, false) => Event::SensorLeft { sensor: sensor_id, other },
        }
    }
}

/// Arrays used again for each pair.
#[derive(Clone, Debug, Default)]
pub(crate) struct NarrowScratch {
    found: LocalManifolds,
    old: SmallVec<[Manifold; 1]>,
    matched: usize,
    expected: usize,
}

/// The moment of impact is looked at this far into the touch, as a part of the thinner body's inner radius.
const INTO: f32 = 0.05;

#[expect(clippy::too_many_arguments, reason = "plain values of one pair; a struct would name them twice")]
fn find_points(
    contact: &mut Contact,
    a: &BodyState,
    b: &BodyState,
    shape_a: &ShapeState,
    shape_b: &ShapeState,
    dt: f32,
    options: &WorldOptions,
    scratch: &mut NarrowScratch,
) {
    let (pose_a, pose_b) = (shape_a.world_from_shape(a), shape_b.world_from_shape(b));
    let motion = motion_in_step(a, dt) - motion_in_step(b, dt);
    let margin = if contact.sensor { 0.0 } else { speculative_margin(motion, shape_a, shape_b, options) };
    let (geometry_a, geometry_b) = (&shape_a.shape.geometry, &shape_b.shape.geometry);
    let b_in_a = pose_a.inverse() * pose_b;
    find_manifolds(
        geometry_a,
        geometry_b,
        &b_in_a,
        margin,
        options.length_scale,
        &mut contact.hint,
        &mut scratch.found,
    );

    let mut lead = Vec3::ZERO;
    let mut pose_at_hit = pose_a;
    if !contact.sensor
        && scratch.found.iter().all(|m| m.points.is_empty())
        && continuous::is_swept(a, b, shape_a, shape_b, motion, options)
        && let Some(part) = continuous::time_of_impact(geometry_a, &pose_a, geometry_b, &pose_b, motion)
    {
        // The manifold of the moment of impact; its gap is what the motion until then takes away. A little past it:
        // at the touch itself rounding decides whether there is a contact.
        lead = motion * part + motion.normalize_or_zero() * (INTO * continuous::thinness(shape_a, shape_b));
        pose_at_hit.translation += lead;
        let b_at_hit = pose_at_hit.inverse() * pose_b;
        let margin = options.contact.speculative_margin * options.length_scale;
        find_manifolds(
            geometry_a,
            geometry_b,
            &b_at_hit,
            margin,
            options.length_scale,
            &mut contact.hint,
            &mut scratch.found,
        );
    }

    std::mem::swap(&mut contact.manifolds, &mut scratch.old);
    contact.manifolds.clear();
    (scratch.matched, scratch.expected) = (0, 0);
    for found in scratch.found.iter().filter(|m| !m.points.is_empty()) {
        let mut manifold = to_world(found, &pose_at_hit, lead, a.center, b.center);
        if let Some(old) = scratch.old.iter().find(|m| m.part == manifold.part) {
            scratch.expected += manifold.points.len();
            scratch.matched += carry_impulses(&mut manifold, old);
        }
        contact.manifolds.push(manifold);
    }
    scratch.old.clear();
}

/// Contacts are made up to the margin, or as far as a step takes the pair, but not farther than the bodies
/// are thick: beyond that a plane is a bad picture of a surface, and fast bodies should be `continuous`.
fn speculative_margin(motion: Vec3, a: &ShapeState, b: &ShapeState, options: &WorldOptions) -> f32 {
    let thick = a.inner_radius.max(b.inner_radius);
    let margin = options.contact.speculative_margin * options.length_scale;
    margin.max(motion.length().min(thick))
}

/// From the frame of shape A to arms in the world; `lead` is how far A was moved for the search.
fn to_world(found: &LocalManifold, pose_a: &Pose, lead: Vec3, center_a: Vec3, center_b: Vec3) -> Manifold {
    let normal = pose_a.rotation * found.normal;
    let points = found.points.iter().map(|p| ContactPoint {
        arm_a: pose_a.transform_point(p.on_a) - lead - center_a,
        arm_b: pose_a.transform_point(p.on_b) - center_b,
        separation: p.separation - lead.dot(normal),
        id: p.id,
        lambda_normal: 0.0,
        lambda_friction: Vec3::ZERO,
        impulse: 0.0,
    });
    Manifold { normal, points: points.collect(), part: found.part, lambda_torsion: 0.0, lambda_rolling: Vec3::ZERO }
}

/// Hands the impulses of the last step to the points with the same name; gives the number of points found again.
fn carry_impulses(manifold: &mut Manifold, old: &Manifold) -> usize {
    manifold.lambda_torsion = old.lambda_torsion;
    manifold.lambda_rolling = old.lambda_rolling;
    let mut matched = 0;
    for point in &mut manifold.points {
        if let Some(last) = old.points.iter().find(|p| p.id == point.id) {
            point.lambda_normal = last.lambda_normal;
            point.lambda_friction = last.lambda_friction;
            matched += 1;
        }
    }
    matched
}

fn mix_materials(contact: &mut Contact, a: &BodyState, b: &BodyState, shape_a: &ShapeState, shape_b: &ShapeState) {
    let (m, n) = (&shape_a.shape.material, &shape_b.shape.material);
    contact.friction = m.friction_combine.mix(n.friction_combine, m.friction, n.friction);
    contact.restitution = m.restitution_combine.mix(n.restitution_combine, m.restitution, n.restitution);
    contact.torsional_friction = m.torsional_friction.max(n.torsional_friction);
    contact.rolling_friction = m.rolling_friction.max(n.rolling_friction);
    contact.surface_velocity = b.rotation * n.surface_velocity - a.rotation * m.surface_velocity;
}
