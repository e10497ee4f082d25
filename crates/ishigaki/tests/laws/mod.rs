//! What the laws share: step sizes, worlds that do not sleep, the test of an order of convergence.
#![allow(dead_code, reason = "each file of laws uses its own part")]

use ishigaki::{BodyHandle, BodyState, Jointed, Vec3, World, WorldOptions};

/// Every law holds at these with the substeps of [`options`], s.
pub const STEPS: [f32; 3] = [1.0 / 60.0, 1.0 / 240.0, 1.0 / 960.0];
/// The laws of pendulum and friction hold at these with the default number of substeps too, s.
pub const DEFAULT_STEPS: [f32; 2] = [STEPS[0], STEPS[1]];
/// Default gravity, m/s².
pub const G: f64 = 9.81;

/// Default options without sleep: a law is about what moves. Four substeps, joints or not: an order shows only
/// where the error of the scheme is greater than rounding. With many at 1/960 s, eight of 1/7680 s say, the errors stay
/// far below 1 % (4.5e-4 of a stop distance, 1.3e-4 of the period at 170°), but no longer shrink: they are what
/// f32 rounds off. That the default keeps the laws of pendulum and friction is shown at [`DEFAULT_STEPS`].
pub fn options() -> WorldOptions {
    let mut options = WorldOptions::default();
    (options.solver.substeps, options.solver.sweeps) = (4, 2);
    options.solver.jointed = Jointed::ALIKE;
    options.rest.sleep.enabled = false;
    options
}

/// An empty world with [`options`].
pub fn world() -> World {
    World::new(options()).unwrap()
}

/// An empty world with all options as they are by default, but without sleep.
pub fn default_world() -> World {
    let mut options = WorldOptions::default();
    options.rest.sleep.enabled = false;
    World::new(options).unwrap()
}

/// As [`world`], without gravity.
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
/// `errors` are those at the first of [`STEPS`], `rounding` what f32 leaves of it. The order between neighbors must be
/// at least 0.8 of `order` unless the smaller error is rounding, and the last error below `limit`.
pub fn converges<const N: usize>(law: &str, errors: [f64; N], order: f64, rounding: f64, limit: f64) {
    let orders: Vec<f64> = errors
        .windows(2)
        .zip(STEPS.windows(2))
        .map(|(e, dt)| (e[0] / e[1]).ln() / f64::from(dt[0] / dt[1]).ln())
        .collect();
    let shown = errors.map(|error| format!("{error:.2e}")).join(", ");
    eprintln!("{law}: error {shown} at 1/60, 1/240 … s; order {orders:.2?}");
    for (found, &error) in orders.iter().zip(&errors[1..]) {
        assert!(
            *found >= 0.8 * order || error <= rounding,
            "{law}: order {found:.2} instead of {order}, errors {errors:?}"
        );
    }
    let last = errors[N - 1];
    assert!(last < limit, "{law}: error {last:.3e} at the shortest step, allowed {limit:e}");
}
