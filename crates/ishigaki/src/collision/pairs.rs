//! Stage `find_pairs`: bounds of what moved, and the pairs whose bounds overlap.
//!
//! Bounds are fattened by a margin and by the motion of the coming step, so a resting body costs nothing here.
//! The list of pairs is sorted by shape slots: its order does not depend on the tree.

use crate::body::{BodyKind, BodyState, ShapeState};
use crate::collision::contact_list;
use crate::collision::continuous::start_center;
use crate::collision::pair::{Pair, clear_burst};
use crate::collision::proxy::{FatBounds, Places, Plane, Proxy};
use crate::math::Vec3;
use crate::shape::Groups;
use crate::step::Scratch;
use crate::world::World;

/// Bounds reach as far as a shape gets in so many steps at its speed: fewer shapes are put into the tree anew, but more
/// pairs are looked at.
const STEPS_AHEAD: f32 = 3.0;
/// Of shapes that touch nothing: they have no pairs.
const STEPS_AHEAD_ALONE: f32 = 8.0;

impl World {
    /// Updates bounds and the list of pairs; pairs whose bounds came apart are dropped.
    pub(crate) fn find_pairs(&mut self, dt: f32) {
        let margin = self.options.contact.speculative_margin * self.options.length_scale;
        let fat = self.options.contact.bounds_margin * self.options.length_scale;
        let (proxies, parts) = (&mut self.scratch.proxies, &mut self.scratch.moves);
        proxies.begin(self.shapes.slot_count());
        parts.resize_with(self.workers.parts(self.shapes.slot_count()), Moves::default);
        let groups = self.scratch.groups.get_or_insert_with(|| {
            self.shapes.iter().fold(Groups::NONE, |groups, (_, shape)| groups.and(shape.shape.groups))
        });
        let (bodies, stirs) = (&self.bodies, &self.scratch.stirs);
        let sizes = Margins { dt, margin, fat, groups: *groups };
        let whole = (self.shapes.all(), proxies.places());
        self.workers.in_parts(whole, parts, |(shapes, mut places), moves| {
            moves.moved.clear();
            moves.planes.clear();
            for (slot, shape) in shapes.objects() {
                if *places.holds(slot) && !(shape.moved || stirs[shape.body as usize]) {
                    continue;
                }
                moves.enter(slot, shape, bodies.at(shape.body), &mut places, &sizes);
            }
        });
        let moved = &mut self.scratch.moved_shapes;
        moved.clear();
        for part in parts {
            moved.extend_from_slice(&part.moved);
            proxies.planes.append(&mut part.planes);
        }
        if !moved.is_empty() {
            self.broad_phase.update_all(moved, |slot| {
                let [now, _] = proxies.bounds[slot as usize];
                (now.min, now.max)
            });
            // Nets and ropes that touch nothing ask for no neighbors.
            moved.retain(|&slot| !proxies.shapes[slot as usize].traits.alone);
            self.drop_parted_pairs();
            self.add_new_pairs();
        }
    }

    /// After the motion: bounds that a shape left unforeseen grow to hold it, so that queries find it where it is.
    pub(crate) fn hold_bounds(&mut self) {
        let Scratch { moves: parts, proxies, roles, .. } = &mut self.scratch;
        let (bodies, proxies) = (&self.bodies, &*proxies);
        let may_move = |slot: u32| roles[proxies.motions[slot as usize].body as usize].may_move();
        parts.resize_with(self.workers.parts(self.shapes.slot_count()), Moves::default);
        self.workers.in_parts(self.shapes.all(), parts, |shapes, moves| {
            moves.moved.clear();
            for (slot, shape) in shapes.objects_where(may_move) {
                let body = bodies.at(shape.body);
                let rests = body.kind == BodyKind::Fixed || body.asleep || body.broken;
                let ball = shape.ball_bounds(body);
                if rests || ball.is_none() && stays_inside(shape, body, &proxies.shapes[slot as usize]) {
                    continue;
                }
                let (min, max) = ball.unwrap_or_else(|| shape.tight_bounds(body));
                if !(min.cmpge(shape.bounds_min).all() && max.cmple(shape.bounds_max).all()) {
                    (shape.bounds_min, shape.bounds_max) = (min.min(shape.bounds_min), max.max(shape.bounds_max));
                    shape.moved = true;
                    moves.moved.push(slot);
                }
            }
        });
        for &slot in parts.iter().flat_map(|part| &part.moved) {
            let shape = self.shapes.at(slot);
            self.broad_phase.update(slot, shape.bounds_min, shape.bounds_max);
        }
    }

    fn drop_parted_pairs(&mut self) {
        let Scratch { moves: parts, proxies, .. } = &mut self.scratch;
        let (pairs, contacts, bounds) = (&self.pairs.all[..], &self.contacts[..], &proxies.bounds[..]);
        parts.resize_with(self.workers.parts(pairs.len()), Moves::default);
        self.workers.in_parts(0..pairs.len(), parts, |indices, moves| {
            moves.parted.clear();
            moves.has_ended = false;
            let mut rest = contacts;
            for (pair, index) in pairs[indices.clone()].iter().zip(indices) {
                if pair.is_gone() || bounds[pair.shape_a as usize][0].touch(&bounds[pair.shape_b as usize][0]) {
                    continue;
                }
                moves.parted.push(index as u32);
                rest = &rest[rest.partition_point(|contact| contact.key() < pair.key())..];
                moves.has_ended |=
                    rest.first().is_some_and(|contact| contact.key() == pair.key() && !contact.is_empty());
            }
        });
        let has_ended = parts.iter().any(|part| part.has_ended);
        self.pairs.remove(parts.iter().flat_map(|part| &part.parted).map(|&index| index as usize));
        if has_ended {
            self.drop_contacts_without_pair();
            self.end_gone_pairs();
        }
    }

    /// Drops pairs that joints, exclusions or groups no longer allow.
    pub(crate) fn drop_forbidden_pairs(&mut self) {
        let mut pairs = std::mem::take(&mut self.pairs);
        pairs.retain(&mut |p| self.may_touch(p.shape_a, p.shape_b));
        self.pairs = pairs;
        self.drop_contacts_without_pair();
        let first = self.events.len();
        self.end_gone_pairs();
        // Between steps: reported with the next one.
        let ended = self.events.split_off(first);
        self.pending_events.extend(ended);
    }

    fn drop_contacts_without_pair(&mut self) {
        let gone = &mut self.scratch.gone_pairs;
        gone.clear();
        let mut pairs = self.pairs.iter().map(Pair::key);
        let mut pair = pairs.next();
        contact_list::retain(&mut self.contacts, &mut self.scratch.links, |c| {
            while pair.is_some_and(|key| key < c.key()) {
                pair = pairs.next();
            }
            let keep = pair == Some(c.key());
            if !keep && c.touching {
                gone.push((c.shape_a, c.shape_b, c.sensor));
            }
            keep
        });
    }

    fn end_gone_pairs(&mut self) {
        for i in 0..self.scratch.gone_pairs.len() {
            let (a, b, sensor) = self.scratch.gone_pairs[i];
            for slot in [a, b] {
                let body = self.shapes.at(slot).body;
                if !sensor {
                    let body_state = self.bodies.at_mut(body);
                    body_state.feel_change();
                    // Between steps it may be new; all of them are told anew when one begins.
                    if let Some(stirs) = self.scratch.stirs.get_mut(body as usize) {
                        *stirs |= body_state.is_stirring();
                    }
                }
            }
            let event = self.touch_event(a, b, sensor, false);
            self.events.push(event);
        }
    }

    fn add_new_pairs(&mut self) {
        let mut found = std::mem::take(&mut self.scratch.new_pairs);
        let mut lists = std::mem::take(&mut self.scratch.pair_lists);
        let bounds = &self.scratch.proxies.bounds;
        let is_new = |a: u32, b: u32| {
            // If the bounds touched before, the pair is known, or forbidden; edits that change that also say `moved`.
            let [before_a, before_b] = [a, b].map(|slot| &bounds[slot as usize][1]);
            !before_a.touch(before_b) && self.may_touch(a, b)
        };
        self.broad_phase.pairs_in_parts(&self.scratch.moved_shapes, is_new, &self.workers, &mut lists, &mut found);
        lists.iter_mut().for_each(clear_burst);
        self.scratch.pair_lists = lists;
        // What moved because its user said so may know its pairs already.
        let asks_anew = |slot: u32| bounds[slot as usize][1].is_nowhere();
        found.retain(|pair| !(asks_anew(pair.0) || asks_anew(pair.1)) || !self.pairs.contains(*pair));
        self.pairs.insert(&found);
        clear_burst(&mut found);
        self.scratch.new_pairs = found;
    }

    /// Whether a pair of shapes can ever make a contact or trip a sensor.
    pub(crate) fn may_touch(&self, a: u32, b: u32) -> bool {
        let (shape_a, shape_b) = (self.shapes.at(a), self.shapes.at(b));
        if shape_a.body == shape_b.body || !shape_a.shape.groups.allow(shape_b.shape.groups) {
            return false;
        }
        let sensors = (shape_a.shape.sensor, shape_b.shape.sensor);
        let (kind_a, kind_b) = (self.bodies.at(shape_a.body).kind, self.bodies.at(shape_b.body).kind);
        let someone_moves = match sensors {
            (true, true) => false,
            (false, false) => kind_a == BodyKind::Dynamic || kind_b == BodyKind::Dynamic,
            _ => kind_a != BodyKind::Fixed || kind_b != BodyKind::Fixed,
        };
        let pair = (shape_a.body.min(shape_b.body), shape_a.body.max(shape_b.body));
        someone_moves && self.excluded.binary_search(&pair).is_err() && self.jointed.binary_search(&pair).is_err()
    }
}

/// What a part of the shapes leaves.
#[derive(Clone, Debug, Default)]
pub(crate) struct Moves {
    moved: Vec<u32>,
    planes: Vec<Plane>,
    /// Indices of pairs whose bounds came apart.
    parted: Vec<u32>,
    /// Some of them had contacts.
    has_ended: bool,
}

/// By how much bounds are larger than shapes, and what they may touch.
struct Margins {
    dt: f32,
    /// Speculative, m.
    margin: f32,
    /// m.
    fat: f32,
    /// Of all shapes.
    groups: Groups,
}

impl Moves {
    /// Enters a shape whose entry holds no longer; its bounds are made anew if it left them.
    fn enter(&mut self, slot: u32, shape: &mut ShapeState, body: &BodyState, places: &mut Places<'_>, by: &Margins) {
        let rests = (body.kind == BodyKind::Fixed || body.asleep) && !(body.edited || body.broken || shape.moved);
        *places.holds(slot) = false;
        let is_alone = !by.groups.allow(shape.shape.groups);
        if is_alone && !rests && self.enter_ball(slot, shape, body, places, by) {
            return;
        }
        places.set_bounds(slot, [FatBounds::of(shape); 2]);
        if body.broken {
            places.leave_out(slot);
            return;
        }
        let (tight, plane) = places.enter(slot, shape, body, by.dt, is_alone);
        // Planes are gathered in each step.
        *places.holds(slot) = rests && plane.is_none();
        self.planes.extend(plane);
        if body.is_active() || body.is_moving_kinematic() || shape.moved {
            let swept = swept_bounds(tight, shape, body, by.dt, by.margin);
            if !holds(shape, swept) {
                let steps = if is_alone { STEPS_AHEAD_ALONE } else { STEPS_AHEAD };
                self.widen(slot, shape, body, swept, steps, places, by);
            }
        }
    }

    /// A ball that touches nothing: nobody asks for more than its bounds in the tree. Whether the shape is one.
    fn enter_ball(
        &mut self,
        slot: u32,
        shape: &mut ShapeState,
        body: &BodyState,
        places: &mut Places<'_>,
        by: &Margins,
    ) -> bool {
        let Some((min, max)) = shape.ball_bounds(body).filter(|_| !body.broken) else { return false };
        places.leave_alone(slot, shape.body);
        let motion = motion_in_step(body, by.dt);
        let swept = (min.min(min + motion), max.max(max + motion));
        if !holds(shape, swept) {
            self.widen(slot, shape, body, swept, STEPS_AHEAD_ALONE, places, by);
        }
        true
    }

    /// Bounds made anew for a shape that left them, or will in the step.
    #[expect(clippy::too_many_arguments, reason = "what `enter` has in its hands")]
    fn widen(
        &mut self,
        slot: u32,
        shape: &mut ShapeState,
        body: &BodyState,
        (min, max): (Vec3, Vec3),
        steps: f32,
        places: &mut Places<'_>,
        by: &Margins,
    ) {
        let (low, high) = ahead(body, max - min, by.dt, steps);
        let before = if shape.moved { FatBounds::NOWHERE } else { FatBounds::of(shape) };
        (shape.bounds_min, shape.bounds_max) = (min + low - by.fat, max + high + by.fat);
        places.set_bounds(slot, [FatBounds::of(shape), before]);
        shape.moved = false;
        self.moved.push(slot);
    }
}

/// Whether the bounds of a shape hold these, and nobody moved it.
#[inline(always)]
fn holds(shape: &ShapeState, (min, max): (Vec3, Vec3)) -> bool {
    !shape.moved && min.cmpge(shape.bounds_min).all() && max.cmple(shape.bounds_max).all()
}

/// Bounds over the coming step: where the shape is and where its velocity takes it.
fn swept_bounds((min, max): (Vec3, Vec3), shape: &ShapeState, body: &BodyState, dt: f32, margin: f32) -> (Vec3, Vec3) {
    if body.kind == BodyKind::Fixed {
        return (min, max);
    }
    let half = 0.5 * (max - min);
    // A turning body reaches out by ω r Δt, never by more than its own size.
    let reach = half.length() + shape.offset.length();
    let (_, angular_velocity) = body.velocities_in_step(dt);
    let swing = (angular_velocity.length() * reach * dt).min(reach);
    let (motion, pad) = (motion_in_step(body, dt), Vec3::splat(margin + swing));
    (min.min(min + motion) - pad, max.max(max + motion) + pad)
}

/// Whether the shape moved less since the start of the step than there was room around it: cheaper than bounds.
fn stays_inside(shape: &ShapeState, body: &BodyState, at_start: &Proxy) -> bool {
    let room = (at_start.min - shape.bounds_min).min(shape.bounds_max - at_start.max).min_element();
    let shift = body.center - start_center(body);
    // A point at r that turns by θ goes 2r sin θ/2, and |q − q₀| = 2 sin θ/4.
    let reach = 0.5 * (at_start.max - at_start.min).length() + shape.offset.length();
    let turn = (body.rotation - body.previous_pose.rotation).length();
    shift.length() + 2.0 * reach * turn <= room
}

/// How much farther the bounds of a shape of this size reach, so that they hold for so many steps.
fn ahead(body: &BodyState, size: Vec3, dt: f32, steps: f32) -> (Vec3, Vec3) {
    // Not farther than it is large: what is faster finds others in each step.
    let reach = ((steps - 1.0) * motion_in_step(body, dt)).clamp(-size, size);
    (reach.min(Vec3::ZERO), reach.max(Vec3::ZERO))
}

/// How far the center will move in the coming step, m.
pub(crate) fn motion_in_step(body: &BodyState, dt: f32) -> Vec3 {
    if body.kind == BodyKind::Fixed || body.asleep { Vec3::ZERO } else { body.velocities_in_step(dt).0 * dt }
}
