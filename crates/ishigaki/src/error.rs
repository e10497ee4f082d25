//! What can be wrong with a definition. `step` never fails; only definitions and snapshots do.

/// A definition or a snapshot that the engine refuses, with the place and the remedy.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A number that is NaN, infinite, negative where it must not be, out of range …
    #[error("{place}: {message}")]
    Invalid {
        /// Which field, as the user would write it: `body.density`, `shape[2].radius`.
        place: String,
        /// What is wrong and what would be right.
        message: String,
    },
    /// A handle of an object that is not (or no longer) there.
    #[error("{place}: no such object: the handle is stale or of another world")]
    Stale {
        /// Which argument.
        place: String,
    },
    /// A snapshot that is not one, is damaged, or is of another version.
    #[error("snapshot: {0}")]
    Snapshot(String),
}

impl Error {
    pub(crate) fn invalid(place: impl Into<String>, message: impl Into<String>) -> Self {
        Self::Invalid { place: place.into(), message: message.into() }
    }

    /// The same error, its place prefixed: `radius` inside `shape[2]` becomes `shape[2].radius`.
    #[must_use]
    pub fn within(self, outer: &str) -> Self {
        let join = |inner: String| {
            if inner.is_empty() {
                outer.to_string()
            } else if inner.starts_with('[') {
                format!("{outer}{inner}")
            } else {
                format!("{outer}.{inner}")
            }
        };
        match self {
            Self::Invalid { place, message } => Self::Invalid { place: join(place), message },
            Self::Stale { place } => Self::Stale { place: join(place) },
            other => other,
        }
    }
}

/// The result of a definition.
pub type Result<T> = std::result::Result<T, Error>;

/// Refuses NaN and infinity.
pub(crate) fn finite(place: &str, value: f32) -> Result<f32> {
    if value.is_finite() { Ok(value) } else { Err(Error::invalid(place, format!("must be finite, is {value}"))) }
}

/// Refuses all but finite numbers > 0.
pub(crate) fn positive(place: &str, value: f32) -> Result<f32> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(Error::invalid(place, format!("must be finite and > 0, is {value}")))
    }
}

/// Refuses all but finite numbers ≥ 0.
pub(crate) fn not_negative(place: &str, value: f32) -> Result<f32> {
    if value.is_finite() && value >= 0.0 {
        Ok(value)
    } else {
        Err(Error::invalid(place, format!("must be finite and ≥ 0, is {value}")))
    }
}

/// Refuses vectors with a component that is not finite.
pub(crate) fn finite_vector(place: &str, value: crate::math::Vec3) -> Result<crate::math::Vec3> {
    if value.is_finite() {
        Ok(value)
    } else {
        Err(Error::invalid(place, format!("must be finite, is ({}, {}, {})", value.x, value.y, value.z)))
    }
}

/// Refuses vectors that have no direction; gives the unit vector.
pub(crate) fn direction(place: &str, value: crate::math::Vec3) -> Result<crate::math::Vec3> {
    finite_vector(place, value)?;
    value.try_normalize().ok_or_else(|| Error::invalid(place, "must not be zero: it is a direction"))
}
