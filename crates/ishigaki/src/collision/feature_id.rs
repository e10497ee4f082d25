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
///
/// Every contact point has one, so it is small: of a shape with more than 2¹⁴ features of a kind some share a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct FeatureId {
    /// On shape A.
    a: Name,
    /// On shape B.
    b: Name,
}
// ANCHOR_END: feature_id

/// A feature in two bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
struct Name(u16);

impl Name {
    const KIND_SHIFT: u32 = 14;
    const NUMBERS: u32 = (1 << Self::KIND_SHIFT) - 1;

    const fn new(feature: Feature) -> Self {
        Self((feature.0 >> Feature::KIND_SHIFT << Self::KIND_SHIFT | feature.0 & Self::NUMBERS) as u16)
    }

    const fn feature(self) -> Feature {
        let name = self.0 as u32;
        Feature(name >> Self::KIND_SHIFT << Feature::KIND_SHIFT | name & Self::NUMBERS)
    }
}

impl FeatureId {
    /// The pair of features.
    pub const fn new(a: Feature, b: Feature) -> Self {
        Self { a: Name::new(a), b: Name::new(b) }
    }

    /// On shape A; its number modulo 2¹⁴.
    pub const fn a(self) -> Feature {
        self.a.feature()
    }

    /// On shape B; its number modulo 2¹⁴.
    pub const fn b(self) -> Feature {
        self.b.feature()
    }

    /// A number to sort names by, the same for A and B exchanged, and whether the feature of A is the greater.
    pub(crate) const fn order(self) -> (u32, bool) {
        let (a, b) = (self.a.0 as u32, self.b.0 as u32);
        if a > b { (b << 16 | a, true) } else { (a << 16 | b, false) }
    }

    /// The same contact with A and B exchanged.
    #[must_use]
    pub const fn swapped(self) -> Self {
        Self { a: self.b, b: self.a }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_tell_features_apart() {
        let features =
            [Feature::vertex(0), Feature::vertex(16383), Feature::edge(16383), Feature::face(7), Feature::unknown(0)];
        for (i, a) in features.into_iter().enumerate() {
            for b in features {
                let id = FeatureId::new(a, b);
                assert_eq!((id.a(), id.b()), (a, b));
                assert_eq!((id.swapped().a(), id.swapped().b()), (b, a));
                assert_eq!(id.order().0, id.swapped().order().0);
            }
            assert!(features[..i].iter().all(|other| Name::new(*other) != Name::new(a)));
        }
        assert_eq!(FeatureId::new(Feature::edge(1 << 14 | 3), Feature::face(0)).a(), Feature::edge(3));
    }
}
