//! Writes a recording while a world steps: front to back, in constant memory but for 8 bytes a frame.

use crate::chunk::{self, HEAD, Tag};
use crate::frame::{self, BodyRecord, Contact, Measures};
use crate::scene::{Camera, Scene};
use ishigaki::{BodyHandle, World};
use std::collections::BTreeMap;
use std::io::{self, Write};

/// Frames from one key frame to the next.
pub const KEY_INTERVAL: usize = 64;

/// What a recording says of its run, besides the world.
#[derive(Clone, Debug, PartialEq)]
pub struct About {
    /// Name of the scene or path of its file.
    pub name: String,
    /// Length of a step, s.
    pub dt: f32,
    /// Steps from one frame to the next, at least 1.
    pub every: u64,
    /// Whether contacts are recorded.
    pub contacts: bool,
    /// Where a viewer should look from.
    pub camera: Option<Camera>,
}

impl Default for About {
    fn default() -> Self {
        Self { name: String::new(), dt: 1.0 / 60.0, every: 1, contacts: false, camera: None }
    }
}

/// Records a world: [`new`](Self::new) before the first step, [`step`](Self::step) after each, then
/// [`finish`](Self::finish).
#[derive(Debug)]
pub struct Recorder<W: Write> {
    out: W,
    every: u64,
    with_contacts: bool,
    /// The bodies of the scene, in its order, and their numbers.
    handles: Vec<BodyHandle>,
    numbers: BTreeMap<BodyHandle, u32>,
    /// As in the last frame.
    last: Vec<BodyRecord>,
    /// Bytes written.
    written: u64,
    /// Where each frame begins.
    offsets: Vec<u64>,
    /// Steps since the last frame.
    waiting: u64,
    content: Vec<u8>,
}

impl<W: Write> Recorder<W> {
    /// Writes the scene and frame 0: the world as it stands.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn new(mut out: W, world: &World, about: &About) -> io::Result<Self> {
        let handles: Vec<BodyHandle> = world.bodies().map(|(handle, _)| handle).collect();
        let numbers: BTreeMap<_, _> = handles.iter().zip(0..).map(|(&handle, number)| (handle, number)).collect();
        let mut content = serde_json::to_vec(&Scene::of(world, about, &numbers))?;
        content.resize(content.len().next_multiple_of(4), b' ');
        chunk::write_head(&mut out)?;
        let written = HEAD as u64 + chunk::write(&mut out, Tag::Scene, &content)?;
        let mut recorder = Self {
            out,
            every: about.every.max(1),
            with_contacts: about.contacts,
            handles,
            numbers,
            last: Vec::new(),
            written,
            offsets: Vec::new(),
            waiting: 0,
            content,
        };
        recorder.write_frame(world)?;
        Ok(recorder)
    }

    /// To be called after every step: writes a frame when it is time for one.
    ///
    /// # Errors
    /// Those of `out`; the recording cannot go on.
    pub fn step(&mut self, world: &World) -> io::Result<()> {
        self.waiting += 1;
        if self.waiting < self.every {
            return Ok(());
        }
        self.write_frame(world)
    }

    /// Writes the last step if it is not there yet, and the index; gives `out` back.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn finish(mut self, world: &World) -> io::Result<W> {
        if self.waiting > 0 {
            self.write_frame(world)?;
        }
        self.content.clear();
        self.content.extend_from_slice(&(self.offsets.len() as u32).to_le_bytes());
        self.content.extend_from_slice(&0u32.to_le_bytes());
        for offset in &self.offsets {
            self.content.extend_from_slice(&offset.to_le_bytes());
        }
        let index = self.written;
        chunk::write(&mut self.out, Tag::Index, &self.content)?;
        chunk::write(&mut self.out, Tag::End, &index.to_le_bytes())?;
        self.out.flush()?;
        Ok(self.out)
    }

    fn write_frame(&mut self, world: &World) -> io::Result<()> {
        let number =
            u32::try_from(self.offsets.len()).map_err(|_| io::Error::other("more frames than 32 bits count"))?;
        let mut bodies = frame::bodies_of(world, &self.handles, &self.last);
        let mut contacts = Vec::new();
        for pair in world.contacts() {
            // A body that was added later is not in the recording.
            let numbers = (self.numbers.get(&pair.a.body), self.numbers.get(&pair.b.body));
            let (Some(&a), Some(&b)) = numbers else { continue };
            if pair.frozen {
                bodies[a as usize].frozen = true;
                bodies[b as usize].frozen = true;
            }
            if self.with_contacts {
                push_contacts(world, &pair, a, b, &mut contacts);
            }
        }
        let key = self.offsets.len().is_multiple_of(KEY_INTERVAL);
        let changed = |&(i, record): &(u32, BodyRecord)| {
            key || self.last.get(i as usize).is_none_or(|last| !record.same_bits(last))
        };
        let records: Vec<(u32, BodyRecord)> = (0..).zip(bodies.iter().copied()).filter(changed).collect();
        frame::encode(number, key, &Measures::of(world), &records, &contacts, &mut self.content);
        self.offsets.push(self.written);
        self.written += chunk::write(&mut self.out, Tag::Frame, &self.content)?;
        self.last = bodies;
        self.waiting = 0;
        Ok(())
    }
}

fn push_contacts(world: &World, pair: &ishigaki::ContactView, body_a: u32, body_b: u32, contacts: &mut Vec<Contact>) {
    let Some(b) = world.body(pair.b.body) else { return };
    for manifold in pair.manifolds {
        contacts.extend(manifold.points.iter().map(|point| Contact {
            body_a,
            body_b,
            frozen: pair.frozen,
            point: b.center() + point.arm_b,
            normal: manifold.normal,
            separation: point.separation,
            impulse: point.impulse,
        }));
    }
}
