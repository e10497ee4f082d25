//! Pictures of recordings: a ray caster that needs no display, no GPU and no fonts.
//!
//! Round shapes are round, not faceted; the sun is a disk, so shadows are soft; corners are darkened by the light that
//! does not get there. The same recording gives the same picture. Rays are found by parry's tree of bounds.
//!
//! `camera.rs` says where to stand, `palette.rs` what has which color, `solid.rs` where a ray meets a shape, `stage.rs`
//! puts a frame in place, `light.rs` says how bright a point is, `render.rs` walks the pixels.

mod camera;
mod light;
mod palette;
mod png_file;
mod render;
mod solid;
mod stage;

pub use camera::Camera;
pub use palette::Coloring;
pub use render::{Picture, Style, render};
