//! Stage `update_contacts`: narrow phase for all pairs that may have changed; λ carried by feature id. TALK D4.

use crate::body::{BodyState, ShapeState};
use crate::collision::contact_list::ContactList;
use crate::collision::continuous;
use crate::collision::link::{Judge, Link};
use crate::collision::manifold::{Contact, ContactPoint, LocalManifold, Manifold, SurfaceExtras};
use crate::collision::narrow_phase::{LocalManifolds, find_manifolds};
use crate::collision::pair::{Pair, clear_burst};
use crate::collision::pairs::motion_in_step;
use crate::collision::proxy::Proxies;
use crate::constraint::contact::share_evenly;
use crate::event::Event;
use crate::hooks::{ContactHooks, PairView};
use crate::island::aggressive_sleep;
use crate::math::{Mat3, Pose, Vec3, tangents, without_dust};
use crate::solver::penetration_recovery::DEADBAND;
use crate::threads::Cut;
use crate::world::World;
use smallvec::SmallVec;

impl World {
    /// Refreshes every pair that has a moving body and is not frozen; reports touching that began or ended.
    pub(crate) fn update_contacts(&mut self, dt: f32, hooks: Option<&mut (dyn ContactHooks + '_)>) {
        let mut pairs = std::mem::take(&mut self.pairs);
        let mut contacts = std::mem::take(&mut self.contacts);
        let mut parts = std::mem::take(&mut self.scratch.narrow);
        let proxies = std::mem::take(&mut self.scratch.proxies);
        // Hooks are called in the order of pairs.
        let count = if hooks.is_some() { 1 } else { self.workers.parts(pairs.all.len()) };
        parts.resize_with(count, Part::default);
        let (mut links, judge) = (std::mem::take(&mut self.scratch.links), Judge::new(&self.options, dt));
        if self.scratch.judge.replace(judge) != Some(judge) || links.len() != contacts.len() {
            links.clear();
        }
        links.resize(contacts.len(), Link::UNKNOWN);
        let search = Search {
            world: self,
            margin: self.options.contact.speculative_margin * self.options.length_scale,
            proxies: &proxies,
            dt,
            judge,
        };
        let whole = PairsAndContacts { pairs: &mut pairs.all, contacts: &mut contacts, links: &mut links };
        match (hooks, &mut parts[..]) {
            (Some(hooks), [part]) => search.refresh(whole, part, &mut Some(hooks)),
            _ => self.workers.in_parts(whole, &mut parts, |share, part| search.refresh(share, part, &mut None)),
        }
        self.gather(&mut parts, ContactList { contacts, links });
        self.scratch.proxies = proxies;
        self.scratch.narrow = parts;
        self.pairs = pairs;
    }

    /// What the parts found, in the order of pairs.
    fn gather(&mut self, parts: &mut [Part], mut list: ContactList) {
        let empty = parts.iter().map(|part| part.empty).sum();
        let mut new = ContactList::default();
        self.scratch.has_woken = false;
        for part in parts {
            new.append(&mut part.new);
            self.report.frozen += part.frozen;
            self.report.narrow_phase_calls += part.calls;
            self.report.ids_matched += part.ids_matched;
            self.report.ids_expected += part.ids_expected;
            self.tell_touches(&mut part.touches);
        }
        list.insert(new, empty);
        (self.contacts, self.scratch.links) = (list.contacts, list.links);
    }

    /// Touching that began or ended: bodies feel it, and it is an event.
    pub(crate) fn tell_touches(&mut self, touches: &mut Vec<Touch>) {
        self.events.reserve_exact(touches.len());
        for touch in touches.drain(..) {
            if !touch.sensor {
                for body in touch.bodies {
                    self.scratch.has_woken |= self.bodies.at_mut(body).feel_change();
                }
            }
            let event = self.touch_event(touch.shapes.0, touch.shapes.1, touch.sensor, touch.began);
            self.events.push(event);
        }
        clear_burst(touches);
    }

    /// What bounced within the step touched.
    pub(crate) fn tell_impacts(&mut self) {
        let mut sums = std::mem::take(&mut self.scratch.contact_sums);
        sums.iter_mut().for_each(|sums| self.tell_touches(&mut sums.impacts));
        self.scratch.contact_sums = sums;
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

/// What a caller may say about contacts, if anything.
type Hooks<'a, 'b> = Option<&'a mut (dyn ContactHooks + 'b)>;

/// Touching that began or ended in a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Touch {
    shapes: (u32, u32),
    bodies: [u32; 2],
    sensor: bool,
    began: bool,
}

impl Touch {
    /// Notes it in the contact.
    pub fn change(contact: &mut Contact, began: bool) -> Self {
        contact.touching = began;
        let (shapes, bodies) = (contact.key(), [contact.body_a, contact.body_b]);
        Self { shapes, bodies, sensor: contact.sensor, began }
    }
}

/// What a part of the pairs leaves, and arrays used again for each pair.
#[derive(Clone, Debug, Default)]
pub(crate) struct Part {
    found: LocalManifolds,
    old: SmallVec<[Manifold; 1]>,
    new: ContactList,
    touches: Vec<Touch>,
    /// How many contacts have no points.
    empty: usize,
    frozen: usize,
    calls: usize,
    ids_matched: usize,
    ids_expected: usize,
}

impl Part {
    fn clear(&mut self) {
        self.new.clear();
        self.touches.clear();
        self.empty = 0;
        (self.frozen, self.calls, self.ids_matched, self.ids_expected) = (0, 0, 0, 0);
    }
}

/// Neighbors in the list of pairs, and their contacts.
struct PairsAndContacts<'a> {
    pairs: &'a mut [Pair],
    contacts: &'a mut [Contact],
    /// Of the contacts.
    links: &'a mut [Link],
}

impl Cut for PairsAndContacts<'_> {
    fn cut(self, part: usize, of: usize) -> (Self, Self) {
        let (pairs, other_pairs) = self.pairs.split_at_mut(self.pairs.len() * part / of);
        let middle = other_pairs.first().map_or(self.contacts.len(), |first| {
            let first = first.key();
            self.contacts.partition_point(|contact| contact.key() < first)
        });
        let (contacts, other_contacts) = self.contacts.split_at_mut(middle);
        let (links, other_links) = self.links.split_at_mut(middle);
        let others = Self { pairs: other_pairs, contacts: other_contacts, links: other_links };
        (Self { pairs, contacts, links }, others)
    }
}

/// The search for contact points in this step.
struct Search<'a> {
    world: &'a World,
    proxies: &'a Proxies,
    /// Speculative margin of slow pairs, m.
    margin: f32,
    dt: f32,
    judge: Judge,
}

/// Where shape A was when points were found.
struct Lead {
    pose_a: Pose,
    /// How far it was moved for that, m.
    moved: Vec3,
}

/// The moment of impact is looked at this far into the touch, as a part of the thinner body's inner radius.
const INTO: f32 = 0.05;

impl Search<'_> {
    /// All pairs of a part.
    fn refresh(&self, share: PairsAndContacts<'_>, part: &mut Part, hooks: &mut Hooks<'_, '_>) {
        part.clear();
        let mut known = share.contacts.iter_mut().zip(share.links).peekable();
        for pair in share.pairs.iter_mut().filter(|pair| !pair.is_gone()) {
            while let Some((contact, link)) = known.next_if(|(contact, _)| contact.key() < pair.key()) {
                self.renew_link(link, contact, part);
            }
            match known.next_if(|(contact, _)| contact.key() == pair.key()) {
                Some((contact, link)) => {
                    if !self.sleeps_on(link) {
                        self.update_contact(pair, contact, part, hooks);
                    }
                    self.renew_link(link, contact, part);
                }
                None => self.look_for_contact(pair, part, hooks),
            }
        }
        known.for_each(|(contact, link)| self.renew_link(link, contact, part));
    }

    /// Whether a contact slept in the last step and nothing stirs it now: all of it is as it was.
    fn sleeps_on(&self, link: &Link) -> bool {
        link.sleeps && !self.stir(&link.bodies)
    }

    /// Whether one of them stirs.
    fn stir(&self, bodies: &[u32; 2]) -> bool {
        bodies.iter().any(|&body| self.world.scratch.stirs[body as usize])
    }

    fn renew_link(&self, link: &mut Link, contact: &Contact, part: &mut Part) {
        if !self.sleeps_on(link) {
            let (a, b) = (self.world.bodies.at(contact.body_a), self.world.bodies.at(contact.body_b));
            *link = Link::new(contact, a, b, &self.judge);
        }
        part.empty += usize::from(link.manifolds == 0);
    }

    /// A pair that has, or had, contact points.
    fn update_contact(&self, pair: &mut Pair, contact: &mut Contact, part: &mut Part, hooks: &mut Hooks<'_, '_>) {
        let (world, options) = (self.world, &self.world.options);
        let (a, b) = (world.bodies.at(contact.body_a), world.bodies.at(contact.body_b));
        if a.broken || b.broken {
            contact.manifolds.clear();
        } else if a.is_stirring() || b.is_stirring() {
            let (shape_a, shape_b) = (world.shapes.at(contact.shape_a), world.shapes.at(contact.shape_b));
            if self.stays_frozen(pair, (a, b)) {
                part.frozen += 1;
            } else {
                contact.frozen = false;
                if self.proxies.are_apart(pair.key(), self.margin) {
                    contact.manifolds.clear();
                } else {
                    part.calls += 1;
                    let lead = self.find(pair, (a, b), (shape_a, shape_b), part);
                    let (matched, expected) = part.fill(contact, &lead, a.center, b.center);
                    part.ids_matched += matched;
                    part.ids_expected += expected;
                    contact.frozen = !contact.sensor && aggressive_sleep::may_freeze(a, b, options);
                    if contact.frozen {
                        self.freeze(pair);
                    }
                }
            }
            if !contact.manifolds.is_empty() {
                mix_materials(contact, a, b, shape_a, shape_b);
                let closed = DEADBAND * options.length_scale;
                contact.manifolds.iter_mut().for_each(|m| share_evenly(m, closed));
            }
        } else {
            return; // both asleep or fixed: nothing changed
        }
        self.ask_hooks(contact, hooks);
        self.notice_touching(contact, part);
        pair.memory.frozen = contact.frozen;
    }

    /// A pair without contact points.
    fn look_for_contact(&self, pair: &mut Pair, part: &mut Part, hooks: &mut Hooks<'_, '_>) {
        let bodies = [pair.shape_a, pair.shape_b].map(|slot| self.proxies.motions[slot as usize].body);
        if !self.stir(&bodies) {
            return;
        }
        if self.proxies.are_apart(pair.key(), self.margin) {
            pair.memory.frozen = false;
            return;
        }
        let (world, options) = (self.world, &self.world.options);
        let [a, b] = bodies.map(|body| world.bodies.at(body));
        if a.broken || b.broken {
            return;
        }
        if self.stays_frozen(pair, (a, b)) {
            part.frozen += 1;
            return;
        }
        part.calls += 1;
        let (shape_a, shape_b) = (world.shapes.at(pair.shape_a), world.shapes.at(pair.shape_b));
        let lead = self.find(pair, (a, b), (shape_a, shape_b), part);
        let sensor = shape_a.shape.sensor || shape_b.shape.sensor;
        pair.memory.frozen = false;
        if !sensor && aggressive_sleep::may_freeze(a, b, options) {
            self.freeze(pair);
        }
        if part.found.iter().all(|m| m.points.is_empty()) {
            return;
        }
        let mut contact = Contact::new(pair.key(), (shape_a.body, shape_b.body), sensor);
        part.fill(&mut contact, &lead, a.center, b.center);
        contact.frozen = pair.memory.frozen;
        mix_materials(&mut contact, a, b, shape_a, shape_b);
        self.ask_hooks(&mut contact, hooks);
        pair.memory.frozen = contact.frozen;
        self.notice_touching(&mut contact, part);
        if !contact.manifolds.is_empty() {
            let link = Link::new(&contact, a, b, &self.judge);
            part.new.push(contact, link);
        }
    }

    fn stays_frozen(&self, pair: &Pair, bodies: (&BodyState, &BodyState)) -> bool {
        aggressive_sleep::stays_frozen(&pair.memory, || self.b_in_a(pair), bodies, &self.world.options)
    }

    fn freeze(&self, pair: &mut Pair) {
        let b_in_a = self.b_in_a(pair);
        pair.memory.freeze(&b_in_a);
    }

    /// Where the second shape is in the frame of the first.
    fn b_in_a(&self, pair: &Pair) -> Pose {
        let poses = &self.proxies.poses;
        poses[pair.shape_a as usize].inverse() * poses[pair.shape_b as usize]
    }

    fn ask_hooks(&self, contact: &mut Contact, hooks: &mut Hooks<'_, '_>) {
        let Some(hooks) = hooks else { return };
        if contact.manifolds.is_empty() {
            return;
        }
        let world = self.world;
        let (a, b) = (world.shape_id(contact.shape_a), world.shape_id(contact.shape_b));
        let (body_a, body_b) = (world.bodies.at(contact.body_a), world.bodies.at(contact.body_b));
        let pair = PairView { a, b, body_a, body_b };
        if !hooks.allow(&pair) {
            contact.manifolds.clear();
            contact.frozen = false;
        } else {
            hooks.modify(&pair, contact);
        }
    }

    /// Touching begins at contact and ends when the gap is half the speculative margin: no chatter between.
    fn notice_touching(&self, contact: &mut Contact, part: &mut Part) {
        let gap = 0.5 * self.margin;
        let limit = if contact.sensor {
            0.0
        } else if contact.touching {
            gap
        } else {
            1e-3 * gap
        };
        let touching = contact.manifolds.iter().flat_map(|m| &m.points).any(|p| p.separation <= limit);
        if touching != contact.touching {
            part.touches.push(Touch::change(contact, touching));
        }
    }

    /// Finds the points of a pair, in the part's list.
    fn find(
        &self,
        pair: &mut Pair,
        (a, b): (&BodyState, &BodyState),
        (shape_a, shape_b): (&ShapeState, &ShapeState),
        part: &mut Part,
    ) -> Lead {
        let options = &self.world.options;
        let [slot_a, slot_b] = [pair.shape_a as usize, pair.shape_b as usize];
        let (pose_a, pose_b) = (self.proxies.poses[slot_a], self.proxies.poses[slot_b]);
        let (traits_a, traits_b) = (self.proxies.shapes[slot_a].traits, self.proxies.shapes[slot_b].traits);
        let margin = self.proxies.margin(pair.key(), self.margin);
        let (geometry_a, geometry_b) = (&shape_a.shape.geometry, &shape_b.shape.geometry);
        let found = &mut part.found;
        let b_in_a = pose_a.inverse() * pose_b;
        find_manifolds(geometry_a, geometry_b, &b_in_a, margin, options.length_scale, &mut pair.memory, found);

        let mut lead = Lead { pose_a, moved: Vec3::ZERO };
        let may_sweep = traits_a.continuous || traits_b.continuous;
        if !may_sweep || traits_a.sensor || traits_b.sensor || found.iter().any(|m| !m.points.is_empty()) {
            return lead;
        }
        let motion = motion_in_step(a, self.dt) - motion_in_step(b, self.dt);
        if continuous::is_swept(a, b, shape_a, shape_b, motion, options)
            && let Some(part) = continuous::time_of_impact(geometry_a, &pose_a, geometry_b, &pose_b, motion)
        {
            // The manifold of the moment of impact; its gap is what the motion until then takes away. A little past it:
            // at the touch itself rounding decides whether there is a contact.
            lead.moved = motion * part + motion.normalize_or_zero() * (INTO * continuous::thinness(shape_a, shape_b));
            lead.pose_a.translation += lead.moved;
            let b_at_hit = lead.pose_a.inverse() * pose_b;
            let (margin, scale) = (self.margin, options.length_scale);
            find_manifolds(geometry_a, geometry_b, &b_at_hit, margin, scale, &mut pair.memory, found);
        }
        lead
    }
}

impl Part {
    /// Gives a contact the points found, with the impulses of those it had; how many were found again, of how many.
    fn fill(&mut self, contact: &mut Contact, lead: &Lead, center_a: Vec3, center_b: Vec3) -> (usize, usize) {
        let Self { found, old, .. } = self;
        let place = |found: &LocalManifold, old: Option<&Manifold>| to_world(found, lead, (center_a, center_b), old);
        // Most contacts have one manifold and keep it: it is replaced where it is.
        if let ([found], [manifold]) = (&found[..], &mut contact.manifolds[..])
            && found.part == manifold.part
            && !found.points.is_empty()
        {
            let (new, matched) = place(found, Some(manifold));
            *manifold = new;
            return (matched, found.points.len());
        }
        std::mem::swap(&mut contact.manifolds, old);
        contact.manifolds.clear();
        let (mut matched, mut expected) = (0, 0);
        for found in found.iter().filter(|m| !m.points.is_empty()) {
            let old = old.iter().find(|m| m.part == found.part);
            let (manifold, again) = place(found, old);
            matched += again;
            expected += if old.is_some() { manifold.points.len() } else { 0 };
            contact.manifolds.push(manifold);
        }
        old.clear();
        (matched, expected)
    }
}

/// From the frame of shape A to arms in the world, with the impulses of the last step for points with the same name;
/// how many points had one.
fn to_world(
    found: &LocalManifold,
    lead: &Lead,
    (center_a, center_b): (Vec3, Vec3),
    old: Option<&Manifold>,
) -> (Manifold, usize) {
    let pose_a = &lead.pose_a;
    let turn = Mat3::from_quat(pose_a.rotation);
    let normal = without_dust(pose_a.rotation * found.normal);
    let (from_a, from_b) = (pose_a.translation - lead.moved - center_a, pose_a.translation - center_b);
    let turned = old.filter(|old| old.normal != normal).map(|old| [tangents(old.normal), tangents(normal)]);
    let carried = |impulse| turned.map_or(impulse, |[from, to]| from_tangents(impulse, from, to));
    let mut matched = 0;
    let points = found.points.iter().map(|p| {
        let last = old.and_then(|old| old.points.iter().find(|last| last.id == p.id));
        matched += usize::from(last.is_some());
        ContactPoint {
            arm_a: turn * p.on_a + from_a,
            arm_b: turn * p.on_b + from_b,
            separation: p.separation - lead.moved.dot(normal),
            id: p.id,
            lambda_normal: last.map_or(0.0, |last| last.lambda_normal),
            lambda_friction: last.map_or([0.0; 2], |last| carried(last.lambda_friction)),
            impulse: 0.0,
        }
    });
    let manifold = Manifold {
        normal,
        points: points.collect(),
        part: found.part,
        lambda_torsion: old.map_or(0.0, |old| old.lambda_torsion),
        lambda_rolling: old.map_or([0.0; 2], |old| carried(old.lambda_rolling)),
    };
    (manifold, matched)
}

/// A vector along two tangents, along two others.
fn from_tangents([x, y]: [f32; 2], (t1, t2): (Vec3, Vec3), (s1, s2): (Vec3, Vec3)) -> [f32; 2] {
    let vector = x * t1 + y * t2;
    [vector.dot(s1), vector.dot(s2)]
}

fn mix_materials(contact: &mut Contact, a: &BodyState, b: &BodyState, shape_a: &ShapeState, shape_b: &ShapeState) {
    let (m, n) = (&shape_a.shape.material, &shape_b.shape.material);
    contact.friction = m.friction_combine.mix(n.friction_combine, m.friction, n.friction);
    let is_moving = m.surface_velocity != Vec3::ZERO || n.surface_velocity != Vec3::ZERO;
    contact.set_extras(SurfaceExtras {
        restitution: m.restitution_combine.mix(n.restitution_combine, m.restitution, n.restitution),
        torsional_friction: m.torsional_friction.max(n.torsional_friction),
        rolling_friction: m.rolling_friction.max(n.rolling_friction),
        surface_velocity: if is_moving {
            b.rotation * n.surface_velocity - a.rotation * m.surface_velocity
        } else {
            Vec3::ZERO
        },
    });
}
