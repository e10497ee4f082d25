//! What the laws share: step sizes, worlds that do not sleep, the test of an order of convergence.
#![allow(dead_code, reason = "each file of laws uses its own part")]

use ishigaki::{BodyHandle, BodyState, Vec3, World, WorldOptions};

/// Every law holds at these, s.
pub const STEPS: [f32; 3] = [1.0 / 60.0, 1.0 / 240.0, 1.0 / 960.0];
/// Default gravity, m/s².
pub const G: f64 = 9.81;

/// Default options without sleep: a law is about what moves. Four substeps, whatever the default: at 1/960 s they are
/// 1/3840 s long, and in still shorter ones f32 rounds off more than the scheme is wrong by.
pub fn options() -> WorldOptions {
    let mut options = WorldOptions::default();
    options.solver.substeps = 4;
    options.rest.sleep.enabled = false;
    options
}

/// An empty world with [`options`].
pub fn world() -> World {
    World::new(options()).unwrap()
}

/// The same without gravity.
pub fn weightless() -> World {
    World::new(WorldOptions { gravity: Vec3::ZERO, ..options() }).unwrap()
}

/// Steps for about `seconds`; gives the time that passed, s.
pub fn run(world: &mut World, seconds: f64, dt: f32) -> f64 {
    let steps = (seconds / f64::from(dt)).round() as usize;
    for _ in 0..steps {
        world.step(dt);
    }
    steps as f64 * f64::from(dt)
}

/// A body that is there.
pub fn body(world: &World, handle: BodyHandle) -> &BodyState {
    world.body(handle).unwrap()
}

/// |measured/exact − 1|.
pub fn relative(measured: f64, exact: f64) -> f64 {
    (measured / exact - 1.0).abs()
}

/// A law that holds in the limit of small steps.
///
/// `errors` are those at [`STEPS`], `rounding` what f32 leaves of it. The order between neighbors must be at least
/// 0.8 of `order` unless the smaller error is rounding, and the last error below `limit`.
pub fn converges(law: &str, errors: [f64; 3], order: f64, rounding: f64, limit: f64) {
    let orders = [0, 1].map(|i| (errors[i] / errors[i + 1]).ln() / f64::from(STEPS[i] / STEPS[i + 1]).ln());
    eprintln!(
        "{law}: error {:.2e}, {:.2e}, {:.2e} at 1/60, 1/240, 1/960 s; order {:.2}, {:.2}",
        errors[0], errors[1], errors[2], orders[0], orders[1]
    );
    for i in [0, 1] {
        assert!(
            orders[i] >= 0.8 * order || errors[i + 1] <= rounding,
            "{law}: order {:.2} instead of {order}, errors {errors:?}",
            orders[i]
        );
    }
    assert!(errors[2] < limit, "{law}: error {:.3e} at 1/960 s, allowed {limit:e}", errors[2]);
}
