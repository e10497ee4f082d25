//! Snapshots: all state as bytes, with a version and a checksum; and the hash of a state.

use crate::body::{BodyState, ShapeState};
use crate::collision::broad_phase::BroadPhase;
use crate::collision::manifold::Contact;
use crate::collision::pair::PairList;
use crate::error::{Error, Result};
use crate::event::Event;
use crate::handle::Arena;
use crate::options::WorldOptions;
use crate::report::StepReport;
use crate::solver::permutation::Random;
use crate::step::Scratch;
use crate::threads::Workers;
use crate::world::{JointState, World};
use serde::de::Visitor;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

/// Snapshots begin with this.
const MAGIC: &[u8; 8] = b"ISHIGAKI";
/// Raised whenever the layout of the state changes.
const VERSION: u32 = 6;
/// Magic, version, checksum.
const HEADER: usize = 16;

/// What of a world is written, in this order; the rest follows from it.
#[derive(Serialize, Deserialize)]
#[serde(remote = "World")]
struct Written {
    options: WorldOptions,
    bodies: Arena<BodyState>,
    shapes: Arena<ShapeState>,
    joints: Arena<JointState>,
    pairs: PairList,
    #[serde(serialize_with = "write_contacts")]
    contacts: Vec<Contact>,
    excluded: Vec<(u32, u32)>,
    jointed: Vec<(u32, u32)>,
    events: Vec<Event>,
    pending_events: Vec<Event>,
    report: StepReport,
    random: Random,
    last_substep: f32,
    step_count: u64,
    time: f64,
    #[serde(skip)]
    broad_phase: BroadPhase,
    #[serde(skip)]
    scratch: Scratch,
    #[serde(skip)]
    workers: Workers,
}

#[derive(Serialize)]
struct Writing<'a>(#[serde(serialize_with = "write")] &'a World);

#[derive(Deserialize)]
struct Reading(#[serde(with = "Written")] World);

fn write<S: Serializer>(world: &&World, serializer: S) -> std::result::Result<S::Ok, S::Error> {
    Written::serialize(world, serializer)
}

/// Those with points: no others make a difference.
fn write_contacts<S: Serializer>(contacts: &[Contact], serializer: S) -> std::result::Result<S::Ok, S::Error> {
    let contacts: Vec<&Contact> = contacts.iter().filter(|contact| !contact.is_empty()).collect();
    contacts.serialize(serializer)
}

impl World {
    /// All state as bytes, with a version and a checksum.
    ///
    /// ```
    /// use ishigaki::{Body, Shape, World};
    /// let mut world = World::default();
    /// world.add_body(Body::dynamic(Shape::ball(0.5)))?;
    /// world.step(0.01);
    /// let mut restored = World::restore(&world.snapshot())?;
    /// world.step(0.01);
    /// restored.step(0.01);
    /// assert_eq!(world.state_hash(), restored.state_hash());
    /// # Ok::<(), ishigaki::Error>(())
    /// ```
    pub fn snapshot(&self) -> Vec<u8> {
        let body = postcard::to_stdvec(&Writing(self)).expect("a world is plain data");
        let mut bytes = Vec::with_capacity(HEADER + body.len());
        bytes.extend_from_slice(MAGIC);
        bytes.extend_from_slice(&VERSION.to_le_bytes());
        bytes.extend_from_slice(&crc32fast::hash(&body).to_le_bytes());
        bytes.extend_from_slice(&body);
        bytes
    }

    /// The world of a snapshot; it continues bit for bit.
    ///
    /// # Errors
    /// Bytes that are no snapshot, are damaged, are of another version, or hold a state that contradicts itself.
    pub fn restore(bytes: &[u8]) -> Result<Self> {
        let refuse = |message: String| Err(Error::Snapshot(message));
        if bytes.len() < HEADER || &bytes[..8] != MAGIC {
            return refuse("not a snapshot of Ishigaki: it does not begin with the mark of one".into());
        }
        let number = |at: usize| u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
        let (version, checksum, body) = (number(8), number(12), &bytes[HEADER..]);
        if version != VERSION {
            return refuse(format!(
                "of version {version}; this engine reads version {VERSION}: make it again with this engine"
            ));
        }
        if crc32fast::hash(body) != checksum {
            return refuse("damaged or cut off: its checksum does not fit".into());
        }
        let Reading(mut world) = postcard::from_bytes(body).map_err(|e| Error::Snapshot(format!("unreadable: {e}")))?;
        world.validate().map_err(|e| Error::Snapshot(format!("contradicts itself: {e}")))?;
        world.broad_phase.rebuild(world.shapes.iter().map(|(slot, s)| (slot, s.bounds_min, s.bounds_max)));
        Ok(world)
    }

    /// A hash of all poses and velocities in slot order: equal states have equal hashes (FNV-1a, 64 bits).
    pub fn state_hash(&self) -> u64 {
        let mut hash = 0xCBF2_9CE4_8422_2325_u64;
        let mut add = |bits: u32| {
            for byte in bits.to_le_bytes() {
                hash = (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01B3);
            }
        };
        for (index, body) in self.bodies.iter() {
            add(index);
            let vectors = [body.center, body.velocity, body.angular_velocity];
            for x in vectors.iter().flat_map(|v| v.to_array()).chain(body.rotation.to_array()) {
                // −0 and 0 are the same state.
                add((x + 0.0).to_bits());
            }
        }
        hash
    }
}

/// As its snapshot: bytes, or hexadecimal digits in formats for people, which know neither NaN nor infinity.
impl Serialize for World {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        let bytes = self.snapshot();
        if serializer.is_human_readable() {
            serializer.serialize_str(&to_hex(&bytes))
        } else {
            serializer.serialize_bytes(&bytes)
        }
    }
}

impl<'de> Deserialize<'de> for World {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        if deserializer.is_human_readable() {
            deserializer.deserialize_str(SnapshotVisitor)
        } else {
            deserializer.deserialize_byte_buf(SnapshotVisitor)
        }
    }
}

struct SnapshotVisitor;

impl Visitor<'_> for SnapshotVisitor {
    type Value = World;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a snapshot of a world")
    }

    fn visit_str<E: serde::de::Error>(self, text: &str) -> std::result::Result<World, E> {
        let bytes = from_hex(text).ok_or_else(|| E::custom("a snapshot as text is hexadecimal digits"))?;
        self.visit_bytes(&bytes)
    }

    fn visit_bytes<E: serde::de::Error>(self, bytes: &[u8]) -> std::result::Result<World, E> {
        World::restore(bytes).map_err(E::custom)
    }
}

fn to_hex(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 16] = b"0123456789abcdef";
    bytes.iter().flat_map(|b| [b >> 4, b & 15]).map(|digit| char::from(DIGITS[usize::from(digit)])).collect()
}

fn from_hex(text: &str) -> Option<Vec<u8>> {
    let digit = |c: u8| char::from(c).to_digit(16).map(|d| d as u8);
    let (pairs, rest) = text.as_bytes().as_chunks::<2>();
    rest.is_empty().then(|| pairs.iter().map(|&[high, low]| Some(digit(high)? << 4 | digit(low)?)).collect())?
}
