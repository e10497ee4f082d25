//! Snapshots: all state as bytes, with a version and a checksum; and the hash of a state.

use crate::error::{Error, Result};
use crate::world::World;

/// Snapshots begin with this.
const MAGIC: &[u8; 8] = b"ISHIGAKI";
/// Raised whenever the layout of the state changes.
const VERSION: u32 = 1;
/// Magic, version, checksum.
const HEADER: usize = 16;

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
        let body = postcard::to_stdvec(self).expect("a world is plain data");
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
    /// Bytes that are no snapshot, are damaged, or are of another version.
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
        let mut world: Self = postcard::from_bytes(body).map_err(|e| Error::Snapshot(format!("unreadable: {e}")))?;
        world.options.validate()?;
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
