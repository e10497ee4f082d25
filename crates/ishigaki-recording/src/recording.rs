//! Reads a recording: one pass that checks everything, then frames in any order.

use crate::chunk::{self, Chunks, HEAD, Tag, u32_at, u64_at};
use crate::error::{Error, Result};
use crate::frame::{BodyRecord, Frame, FrameBytes, Measures};
use crate::scene::Scene;

/// A recording whose every byte has been checked; frames are decoded when they are asked for.
#[derive(Clone, Debug)]
pub struct Recording<'a> {
    scene: Scene,
    frames: Vec<FrameBytes<'a>>,
}

impl<'a> Recording<'a> {
    /// Reads a whole recording.
    ///
    /// # Errors
    /// Anything that is not a whole and sound recording of this version; see [`Error`].
    pub fn read(bytes: &'a [u8]) -> Result<Self> {
        match Self::recover(bytes)? {
            (recording, None) => Ok(recording),
            (_, Some(error)) => Err(error),
        }
    }

    /// Reads all frames before the first defect, and says what the defect is.
    ///
    /// # Errors
    /// There is not even the scene and one frame.
    pub fn recover(bytes: &'a [u8]) -> Result<(Self, Option<Error>)> {
        chunk::check_head(bytes)?;
        let mut chunks = Chunks::new(bytes);
        let scene = match chunks.next(0)? {
            (Tag::Scene, content) => Scene::from_json(content).map_err(|what| damaged(HEAD, what, 0))?,
            _ => return Err(damaged(HEAD, "the scene is missing".into(), 0)),
        };
        let mut recording = Self { scene, frames: Vec::new() };
        match recording.read_frames(&mut chunks) {
            Err(error) if recording.frames.is_empty() => Err(error),
            result => Ok((recording, result.err())),
        }
    }

    fn read_frames(&mut self, chunks: &mut Chunks<'a>) -> Result<()> {
        let mut offsets = Vec::new();
        loop {
            let (at, frames) = (chunks.at, self.frames.len());
            match chunks.next(frames)? {
                (Tag::Frame, content) => {
                    let frame = FrameBytes::check(content, frames, self.scene.bodies.len());
                    self.frames.push(frame.map_err(|what| damaged(at, what, frames))?);
                    offsets.push(at as u64);
                }
                (Tag::Index, content) if frames > 0 => {
                    check_index(content, &offsets).map_err(|what| damaged(at, what, frames))?;
                    let end = chunks.at;
                    let right = match chunks.next(frames)? {
                        (Tag::End, content) => content.len() == 8 && u64_at(content, 0) == at as u64,
                        _ => false,
                    };
                    return match right && chunks.is_empty() {
                        true => Ok(()),
                        false => Err(damaged(end, "it does not end as a recording should".into(), frames)),
                    };
                }
                _ => return Err(damaged(at, "another part is due here".into(), frames)),
            }
        }
    }

    /// What does not change during the run.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// How many frames there are: at least one.
    #[expect(clippy::len_without_is_empty, reason = "a recording has at least one frame")]
    pub fn len(&self) -> usize {
        self.frames.len()
    }

    /// What the engine reported at a frame; `None` if there is no such frame.
    pub fn measures(&self, frame: usize) -> Option<Measures> {
        self.frames.get(frame).map(FrameBytes::measures)
    }

    /// A frame, put together from the key frame before it and the changes since; `None` if there is no such frame.
    pub fn frame(&self, frame: usize) -> Option<Frame> {
        let up_to = self.frames.get(..=frame)?;
        let key = up_to.iter().rposition(|f| f.key)?;
        let mut bodies: Vec<BodyRecord> = up_to[key].bodies().map(|(_, record)| record).collect();
        for change in &up_to[key + 1..] {
            for (body, record) in change.bodies() {
                bodies[body] = record;
            }
        }
        let last = &up_to[frame];
        Some(Frame { measures: last.measures(), bodies, contacts: last.contacts().collect() })
    }
}

fn damaged(at: usize, what: String, frames: usize) -> Error {
    Error::Damaged { at: at as u64, what, frames }
}

fn check_index(content: &[u8], offsets: &[u64]) -> std::result::Result<(), String> {
    let fits = content.len() == 8 + 8 * offsets.len()
        && u32_at(content, 0) as usize == offsets.len()
        && offsets.iter().enumerate().all(|(i, &offset)| u64_at(content, 8 + 8 * i) == offset);
    fits.then_some(()).ok_or_else(|| "the index names other places than those of the frames".into())
}
