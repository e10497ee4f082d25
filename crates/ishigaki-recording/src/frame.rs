//! A frame: poses and states of bodies, contacts, measures; and its bytes.

use crate::chunk::{f32_at, u32_at, u64_at};
use ishigaki::{BodyHandle, Pose, Quat, Vec3, World};
use std::collections::BTreeMap;

/// Length of a frame without bodies and contacts.
const START: usize = 64;
/// Length of the record of a body, over all columns.
const BODY: usize = 40;
const CONTACT: usize = 44;

const ASLEEP: u32 = 1;
const FROZEN: u32 = 2;
const ABSENT: u32 = 4;
/// A height that does not fit in 24 bits, or none.
const NO_HEIGHT: u32 = 0xFF_FFFF;
/// Not dynamic.
const NO_ISLAND: u32 = u32::MAX;

/// A body in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyRecord {
    /// Of the body's origin, world, m.
    pub position: Vec3,
    /// world_from_body; a unit quaternion.
    pub rotation: Quat,
    /// Its island sleeps.
    pub asleep: bool,
    /// Aggressive sleep keeps one of its contacts.
    pub frozen: bool,
    /// It was removed from the world: do not draw it.
    pub absent: bool,
    /// Hops from the ground over contacts; `None` where there is no way down.
    pub height: Option<u32>,
    /// Number of the lowest body in its island; `None` if it is not dynamic.
    pub island: Option<u32>,
}

impl BodyRecord {
    /// World from body.
    pub fn pose(&self) -> Pose {
        Pose::from_parts(self.position, self.rotation)
    }

    /// Whether its numbers can be drawn.
    pub fn is_finite(&self) -> bool {
        self.position.is_finite() && self.rotation.is_finite()
    }

    /// As written: equal words, equal records.
    fn words(&self) -> [u32; 10] {
        let flags = [(self.asleep, ASLEEP), (self.frozen, FROZEN), (self.absent, ABSENT)];
        let flags = flags.into_iter().filter(|&(is, _)| is).map(|(_, bit)| bit).sum::<u32>();
        let height = self.height.map_or(NO_HEIGHT, |h| h.min(NO_HEIGHT - 1));
        let (p, q) = (self.position, self.rotation);
        let [px, py, pz, qx, qy, qz, qw] = [p.x, p.y, p.z, q.x, q.y, q.z, q.w].map(f32::to_bits);
        [flags | height << 8, self.island.unwrap_or(NO_ISLAND), px, py, pz, qx, qy, qz, qw, 0]
    }

    pub(crate) fn same_bits(&self, other: &Self) -> bool {
        self.words() == other.words()
    }
}

/// A contact point in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Number of the first body.
    pub body_a: u32,
    /// Number of the second body.
    pub body_b: u32,
    /// Aggressive sleep keeps it.
    pub frozen: bool,
    /// On B's surface, world, m.
    pub point: Vec3,
    /// Unit, B's surface normal: from B to A.
    pub normal: Vec3,
    /// Along the normal, m; negative = overlap.
    pub separation: f32,
    /// Normal impulse on A summed over the step, N·s.
    pub impulse: f32,
}

/// What the engine reported about the step before a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measures {
    /// Steps the world has taken.
    pub step: u64,
    /// Of the world, s.
    pub time: f64,
    /// J.
    pub kinetic_energy: f32,
    /// J.
    pub potential_energy: f32,
    /// About the origin, kg·m²/s.
    pub angular_momentum: Vec3,
    /// Greatest, m.
    pub penetration: f32,
    /// Greatest, m.
    pub joint_error: f32,
    /// Of the solver after the last sweep.
    pub residual: f32,
}

impl Measures {
    /// Of a world as it stands.
    pub fn of(world: &World) -> Self {
        let report = world.report();
        Self {
            step: world.step_count(),
            time: world.time(),
            kinetic_energy: report.kinetic_energy,
            potential_energy: report.potential_energy,
            angular_momentum: report.angular_momentum,
            penetration: report.max_penetration,
            joint_error: report.max_joint_error,
            residual: report.residual,
        }
    }
}

/// A frame, complete.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// What the engine reported.
    pub measures: Measures,
    /// One for each body of the scene, in its order.
    pub bodies: Vec<BodyRecord>,
    /// Empty if the recording has none.
    pub contacts: Vec<Contact>,
}

/// The bodies of a world as records; `last` is what they were, for those that are gone.
pub fn bodies_of(world: &World, handles: &[BodyHandle], last: &[BodyRecord]) -> Vec<BodyRecord> {
    // The engine's numbers of islands change from step to step; that of the lowest body in them stays.
    let mut lowest = BTreeMap::new();
    let stepped = world.step_count() > 0;
    let record = |(i, &handle): (usize, &BodyHandle)| {
        let Some(body) = world.body(handle) else {
            let gone = |record: &BodyRecord| BodyRecord { absent: true, ..*record };
            return last.get(i).map_or(ABSENT_AT_ORIGIN, gone);
        };
        let number = i as u32;
        let island = match body.kind() {
            ishigaki::BodyKind::Dynamic if stepped => Some(*lowest.entry(body.island()).or_insert(number)),
            ishigaki::BodyKind::Dynamic => Some(number),
            _ => None,
        };
        let pose = body.pose();
        BodyRecord {
            position: pose.translation,
            rotation: pose.rotation,
            asleep: body.is_asleep(),
            frozen: false,
            absent: false,
            height: body.height(),
            island,
        }
    };
    handles.iter().enumerate().map(record).collect()
}

const ABSENT_AT_ORIGIN: BodyRecord = BodyRecord {
    position: Vec3::ZERO,
    rotation: Quat::IDENTITY,
    asleep: false,
    frozen: false,
    absent: true,
    height: None,
    island: None,
};

/// The bytes of a frame with these `(number, record)`s.
pub fn encode(
    number: u32,
    key: bool,
    measures: &Measures,
    bodies: &[(u32, BodyRecord)],
    contacts: &[Contact],
    out: &mut Vec<u8>,
) {
    out.clear();
    let mut word = |word: u32| out.extend_from_slice(&word.to_le_bytes());
    word(number);
    word(u32::from(key));
    for wide in [measures.step, measures.time.to_bits()] {
        word(wide as u32);
        word((wide >> 32) as u32);
    }
    let momentum = measures.angular_momentum;
    for number in [measures.kinetic_energy, measures.potential_energy, momentum.x, momentum.y, momentum.z] {
        word(number.to_bits());
    }
    for number in [measures.penetration, measures.joint_error, measures.residual] {
        word(number.to_bits());
    }
    word(bodies.len() as u32);
    word(contacts.len() as u32);
    bodies.iter().for_each(|&(body, _)| word(body));
    // Columns: state, island, position, rotation.
    for column in [0..1, 1..2, 2..5, 5..9] {
        for (_, record) in bodies {
            record.words()[column.clone()].iter().for_each(|&w| word(w));
        }
    }
    for c in contacts {
        word(c.body_a);
        word(c.body_b);
        word(u32::from(c.frozen));
        let (p, n) = (c.point, c.normal);
        [p.x, p.y, p.z, n.x, n.y, n.z, c.separation, c.impulse].iter().for_each(|x| word(x.to_bits()));
    }
}

/// The content of a frame chunk that has been checked.
#[derive(Clone, Copy, Debug)]
pub struct FrameBytes<'a> {
    bytes: &'a [u8],
    pub key: bool,
    bodies: usize,
    contacts: usize,
}

impl<'a> FrameBytes<'a> {
    /// Refuses what contradicts itself, the scene, or its place in the recording.
    pub fn check(bytes: &'a [u8], number: usize, scene_bodies: usize) -> Result<Self, String> {
        if bytes.len() < START {
            return Err("it is too short for a frame".into());
        }
        if u32_at(bytes, 0) as usize != number {
            return Err(format!("it is frame {}, and frame {number} is due", u32_at(bytes, 0)));
        }
        let key = match u32_at(bytes, 4) {
            0 => false,
            1 => true,
            other => return Err(format!("it is of the unknown kind {other}")),
        };
        let (bodies, contacts) = (u32_at(bytes, 56) as usize, u32_at(bytes, 60) as usize);
        let length = bodies.checked_mul(BODY).zip(contacts.checked_mul(CONTACT)).and_then(|(b, c)| b.checked_add(c));
        if length.and_then(|l| l.checked_add(START)) != Some(bytes.len()) {
            return Err(format!("its length does not fit {bodies} bodies and {contacts} contacts"));
        }
        if number == 0 && !key {
            return Err("the first frame is no key frame".into());
        }
        if key && bodies != scene_bodies {
            return Err(format!("a key frame of {bodies} bodies in a scene of {scene_bodies}"));
        }
        let frame = Self { bytes, key, bodies, contacts };
        let mut next = 0;
        for i in 0..bodies {
            let body = frame.column(0, 1, i) as usize;
            if body < next || body >= scene_bodies {
                return Err(format!("body {body} is out of order or not in the scene"));
            }
            next = body + 1;
            let island = frame.column(8, 1, i);
            if island != NO_ISLAND && island as usize >= scene_bodies {
                return Err(format!("body {body} is in the unknown island {island}"));
            }
        }
        let known = |body: u32| (body as usize) < scene_bodies;
        if frame.contacts().any(|c| !known(c.body_a) || !known(c.body_b)) {
            return Err("a contact of a body that is not in the scene".into());
        }
        Ok(frame)
    }

    /// Word `i` of a column of `width` words that begins at `START + offset × bodies`.
    fn column(&self, offset: usize, width: usize, i: usize) -> u32 {
        u32_at(self.bytes, START + offset * self.bodies + 4 * width * i)
    }

    fn vector<const N: usize>(&self, offset: usize, i: usize) -> [f32; N] {
        let start = START + offset * self.bodies + 4 * N * i;
        std::array::from_fn(|k| f32_at(self.bytes, start + 4 * k))
    }

    pub fn measures(&self) -> Measures {
        let number = |at| f32_at(self.bytes, at);
        Measures {
            step: u64_at(self.bytes, 8),
            time: f64::from_bits(u64_at(self.bytes, 16)),
            kinetic_energy: number(24),
            potential_energy: number(28),
            angular_momentum: Vec3::new(number(32), number(36), number(40)),
            penetration: number(44),
            joint_error: number(48),
            residual: number(52),
        }
    }

    /// The records of this frame: `(number, record)`.
    pub fn bodies(&self) -> impl Iterator<Item = (usize, BodyRecord)> + '_ {
        (0..self.bodies).map(|i| {
            let state = self.column(4, 1, i);
            let island = self.column(8, 1, i);
            let record = BodyRecord {
                position: Vec3::from_array(self.vector(12, i)),
                rotation: Quat::from_array(self.vector(24, i)),
                asleep: state & ASLEEP != 0,
                frozen: state & FROZEN != 0,
                absent: state & ABSENT != 0,
                height: (state >> 8 != NO_HEIGHT).then_some(state >> 8),
                island: (island != NO_ISLAND).then_some(island),
            };
            (self.column(0, 1, i) as usize, record)
        })
    }

    pub fn contacts(&self) -> impl Iterator<Item = Contact> + '_ {
        let start = START + BODY * self.bodies;
        (0..self.contacts).map(move |i| {
            let at = start + CONTACT * i;
            let number = |k: usize| f32_at(self.bytes, at + 12 + 4 * k);
            Contact {
                body_a: u32_at(self.bytes, at),
                body_b: u32_at(self.bytes, at + 4),
                frozen: u32_at(self.bytes, at + 8) & 1 != 0,
                point: Vec3::new(number(0), number(1), number(2)),
                normal: Vec3::new(number(3), number(4), number(5)),
                separation: number(6),
                impulse: number(7),
            }
        })
    }
}
