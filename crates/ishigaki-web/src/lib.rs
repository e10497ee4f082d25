//! The engine in a web page: one [`Testbed`] is one scene that runs, is pushed about and looked at.
//!
//! [`bindings`] is what JavaScript sees: numbers as typed arrays, the rest as JSON. Behind it is plain Rust that tests
//! run natively. A page that shows two configurations side by side has two testbeds. The same input gives the same
//! bits here as in a native build; `web/tests/same-bits.test.mjs` compares them.

pub mod bindings;
mod controls;
mod overlay;
mod testbed;

pub use controls::{Control, ControlKind, controls};
pub use overlay::{Overlay, contact_arrows, lines};
pub use testbed::{BODY_STRIDE, POSE_STRIDE, Source, Testbed};
