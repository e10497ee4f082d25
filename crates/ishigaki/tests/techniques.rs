//! Every solver technique of the talk on the engine, each switched alone on top of `SolverOptions::plain()`, held
//! to its prediction; then all of them together. Run with `--nocapture` to see the measured figures.

#[path = "techniques/combinations.rs"]
mod combinations;
#[path = "techniques/friction.rs"]
mod friction;
#[path = "techniques/heights.rs"]
mod heights;
#[path = "techniques/order.rs"]
mod order;
#[path = "techniques/recovery.rs"]
mod recovery;
#[path = "techniques/support.rs"]
mod support;
#[path = "techniques/weights.rs"]
mod weights;
