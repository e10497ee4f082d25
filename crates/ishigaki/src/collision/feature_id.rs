//! Semantic contact ids. TALK D4.
//!
//! A contact point is named by *what touches what*: a feature of A × a feature of B. The name is the same
//! whichever of the two shapes the narrow phase takes as reference, and it survives sliding and turning as
//! long as the same two features touch: impulses of the last step can be handed to the right point.

use serde::{Deserialize, Serialize};

/// A vertex, an edge or a face of one shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Feature(u32);

impl Feature {
    const KIND_SHIFT: u32 = 30;

    /// A vertex by its number in the shape (a ball's center, a capsule's end).
    pub const fn vertex(index: u32) -> Self {
        Self(index)
    }

    /// An edge by its number in the shape (a capsule's side).
    pub const fn edge(index: u32) -> Self {
        Self(1 << Self::KIND_SHIFT | index)
    }

    /// A face by its number in the shape.
    pub const fn face(index: u32) -> Self {
        Self(2 << Self::KIND_SHIFT | index)
    }

    /// The number of the vertex, if it is one.
    pub const fn as_vertex(self) -> Option<u32> {
        self.index_of_kind(0)
    }

    /// The number of the edge, if it is one.
    pub const fn as_edge(self) -> Option<u32> {
        self.index_of_kind(1)
    }

    /// The number of the face, if it is one.
    pub const fn as_face(self) -> Option<u32> {
        self.index_of_kind(2)
    }

    const fn index_of_kind(self, kind: u32) -> Option<u32> {
        if self.0 >> Self::KIND_SHIFT == kind { Some(self.0 & ((1 << Self::KIND_SHIFT) - 1)) } else { None }
    }

    /// A feature that the narrow phase cannot name, told apart by a number.
    pub const fn unknown(index: u32) -> Self {
        Self(3 << Self::KIND_SHIFT | index)
    }
}

// ANCHOR: feature_id
/// A feature of A × a feature of B.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct FeatureId {
    /// On shape A.
    pub a: Feature,
    /// On shape B.
    pub b: Feature,
}
// ANCHOR_END: feature_id

impl FeatureId {
    /// The pair of features.
    pub const fn new(a: Feature, b: Feature) -> Self {
        Self { a, b }
    }

    /// A number to sort names by, the same for A and B exchanged, and whether the feature of A is the greater.
    pub(crate) const fn order(self) -> (u64, bool) {
        let (a, b) = (self.a.0 as u64, self.b.0 as u64);
        if a > b { (b << 32 | a, true) } else { (a << 32 | b, false) }
    }

    /// The same contact with A and B exchanged.
    #[must_use]
    pub const fn swapped(self) -> Self {
        Self { a: self.b, b: self.a }
    }
}
