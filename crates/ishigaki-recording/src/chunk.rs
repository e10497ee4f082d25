//! The head of a recording and its chunks: tag, length, content, checksum.

use crate::error::{Error, Result};
use std::io::{self, Write};

/// The version of the format that this crate writes and reads.
pub const VERSION: u32 = 1;

/// As in PNG: a byte that is no text, a name, and line ends that a transfer as text would change.
const MARK: &[u8; 8] = b"\x89ISHI\r\n\x1A";
/// Length of the head.
pub const HEAD: usize = 16;
/// What a chunk has besides its content: tag and length before it, checksum after it.
pub const FRAMING: usize = 12;
/// Length of the `ENDS` chunk.
const ENDS: usize = FRAMING + 8;

/// What a chunk holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tag {
    Scene,
    Frame,
    Index,
    End,
}

impl Tag {
    fn bytes(self) -> &'static [u8; 4] {
        match self {
            Self::Scene => b"SCEN",
            Self::Frame => b"FRAM",
            Self::Index => b"INDX",
            Self::End => b"ENDS",
        }
    }

    fn of(bytes: &[u8]) -> Option<Self> {
        [Self::Scene, Self::Frame, Self::Index, Self::End].into_iter().find(|tag| tag.bytes() == bytes)
    }
}

pub fn write_head(out: &mut impl Write) -> io::Result<()> {
    let mut head = [0; HEAD];
    head[..8].copy_from_slice(MARK);
    head[8..12].copy_from_slice(&VERSION.to_le_bytes());
    let checksum = crc32fast::hash(&head[..12]);
    head[12..].copy_from_slice(&checksum.to_le_bytes());
    out.write_all(&head)
}

/// Writes a chunk; gives its whole length.
pub fn write(out: &mut impl Write, tag: Tag, content: &[u8]) -> io::Result<u64> {
    let length = u32::try_from(content.len())
        .map_err(|_| io::Error::other("a scene or a frame of more than 4 GiB cannot be recorded"))?;
    let mut start = [0; 8];
    start[..4].copy_from_slice(tag.bytes());
    start[4..].copy_from_slice(&length.to_le_bytes());
    let mut checksum = crc32fast::Hasher::new();
    checksum.update(&start);
    checksum.update(content);
    out.write_all(&start)?;
    out.write_all(content)?;
    out.write_all(&checksum.finalize().to_le_bytes())?;
    Ok((FRAMING + content.len()) as u64)
}

/// Refuses what is no recording of this version.
pub fn check_head(bytes: &[u8]) -> Result<()> {
    let known = bytes.len().min(MARK.len());
    if known == 0 || bytes[..known] != MARK[..known] {
        return Err(Error::NotARecording);
    }
    if bytes.len() < HEAD {
        return Err(Error::Truncated { at: 0, frames: 0 });
    }
    if u32_at(bytes, 12) != crc32fast::hash(&bytes[..12]) {
        return Err(Error::Damaged { at: 0, what: "the checksum of the head does not fit".into(), frames: 0 });
    }
    match u32_at(bytes, 8) {
        VERSION => Ok(()),
        found => Err(Error::Version { found }),
    }
}

/// Walks the chunks after the head.
pub struct Chunks<'a> {
    bytes: &'a [u8],
    /// Where the next chunk begins.
    pub at: usize,
}

impl<'a> Chunks<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: HEAD.min(bytes.len()) }
    }

    pub fn is_empty(&self) -> bool {
        self.at == self.bytes.len()
    }

    /// The next chunk, its checksum tested; `frames` is for the error.
    pub fn next(&mut self, frames: usize) -> Result<(Tag, &'a [u8])> {
        let rest = &self.bytes[self.at..];
        let at = self.at as u64;
        let damaged = |what: &str| Err(Error::Damaged { at, what: what.into(), frames });
        if rest.len() < FRAMING {
            return Err(Error::Truncated { at, frames });
        }
        let Some(tag) = Tag::of(&rest[..4]) else {
            return damaged("its kind is unknown");
        };
        let length = u32_at(rest, 4) as usize;
        if !length.is_multiple_of(4) {
            return damaged("its length is no multiple of 4");
        }
        if length > rest.len() - FRAMING {
            // If the file has its proper end, then it is this length that is wrong.
            return if self.is_whole() {
                damaged("it is longer than the file")
            } else {
                Err(Error::Truncated { at, frames })
            };
        }
        let (content, checksum) = (&rest[8..8 + length], u32_at(rest, 8 + length));
        if crc32fast::hash(&rest[..8 + length]) != checksum {
            return damaged("its checksum does not fit");
        }
        self.at += FRAMING + length;
        Ok((tag, content))
    }

    /// Whether the file ends as a recording should.
    fn is_whole(&self) -> bool {
        let Some(start) = self.bytes.len().checked_sub(ENDS) else { return false };
        let end = &self.bytes[start..];
        &end[..4] == Tag::End.bytes() && u32_at(end, ENDS - 4) == crc32fast::hash(&end[..ENDS - 4])
    }
}

/// Little-endian. All readers have checked that the bytes are there.
pub fn u32_at(bytes: &[u8], at: usize) -> u32 {
    let mut number = [0; 4];
    number.copy_from_slice(&bytes[at..at + 4]);
    u32::from_le_bytes(number)
}

pub fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from(u32_at(bytes, at)) | u64::from(u32_at(bytes, at + 4)) << 32
}

pub fn f32_at(bytes: &[u8], at: usize) -> f32 {
    f32::from_bits(u32_at(bytes, at))
}
