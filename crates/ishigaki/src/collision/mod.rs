//! From poses to contact points: broad phase, manifolds, semantic ids.

mod box_box;
mod box_clip;
pub mod broad_phase;
mod clip;
mod continuous;
mod curved;
pub mod feature_id;
mod half_space;
mod hull_hull;
pub(crate) mod link;
pub mod manifold;
mod mesh;
pub mod narrow_phase;
mod other_pairs;
pub(crate) mod pair;
pub mod pair_memory;
pub(crate) mod pairs;
mod polyhedron;
pub(crate) mod proxy;
mod reduce;
mod round;
mod sat;
mod segment;
pub(crate) mod side_by_side;
mod surface;
pub(crate) mod update;
