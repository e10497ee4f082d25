//! From poses to contact points: broad phase, manifolds, semantic ids.

pub mod broad_phase;
pub mod feature_id;
pub mod manifold;
pub mod narrow_phase;
