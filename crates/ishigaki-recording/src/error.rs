//! What a recording can be refused for.

/// Why bytes are no recording, or only part of one.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// It does not begin with the mark of one.
    #[error(
        "not a recording: it does not begin with the mark of one; `ishigaki run SCENE --record FILE.ishi` makes one"
    )]
    NotARecording,
    /// Of a later version of the format, or of none.
    #[error("a recording of version {found}; this program reads version {}: record it again", crate::VERSION)]
    Version {
        /// The version that the file names.
        found: u32,
    },
    /// It ends too early.
    #[error("cut off in the part that begins at byte {at}; {frames} frames before it are whole")]
    Truncated {
        /// Where the part that is not whole begins.
        at: u64,
        /// How many frames can still be used.
        frames: usize,
    },
    /// A checksum does not fit, or the parts contradict each other.
    #[error("damaged at byte {at}: {what}; {frames} frames before it are whole")]
    Damaged {
        /// Where the part that is wrong begins.
        at: u64,
        /// What is wrong with it.
        what: String,
        /// How many frames can still be used.
        frames: usize,
    },
}

/// With [`Error`].
pub type Result<T> = std::result::Result<T, Error>;
