//! Ragdolls die: dropped, they come to rest on the ground with their joints together and inside their ranges.
//! Sleep is off, so that rest is the solver's. Run with `--nocapture` to see the measured figures.

use ishigaki::World;
use ishigaki_scenes::measure::REST_SPEED;
use ishigaki_scenes::{Scene, named};

/// A named scene with sleep switched off.
fn scene(name: &str, parameters: &[(&str, f64)]) -> Scene {
    let parameters: Vec<_> = parameters.iter().map(|(key, value)| (key.to_string(), *value)).collect();
    let mut file = named(name, &parameters).unwrap();
    file.options.rest.sleep.enabled = false;
    file.build().unwrap()
}

/// What was seen while bodies fell and came to rest; times from the start, s.
#[derive(Debug, Default)]
struct Fall {
    /// When the first body touched anything.
    landing: Option<f64>,
    /// From when on nothing was faster than 0.05 m/s.
    rest: Option<f64>,
    /// Greatest distance between anchors once settled, m.
    gap: f32,
    /// Greatest angle beyond a range or off an axis once settled, rad.
    angle: f32,
    /// The same over the whole fall, impact included.
    worst_gap: f32,
    worst_angle: f32,
    /// After the last step, m/s.
    speed: f32,
}

/// Steps for `seconds`; gaps and angles count from `settling` seconds after the first landing on.
fn watch(world: &mut World, dt: f32, seconds: f64, settling: f64) -> Fall {
    let mut fall = Fall::default();
    while world.time() < seconds {
        let report = world.step(dt);
        assert!(report.non_finite.is_empty());
        fall.speed = report.max_speed;
        let now = world.time();
        if fall.landing.is_none() && world.contacts().next().is_some() {
            fall.landing = Some(now);
        }
        let angle = world.joints().map(|(_, j)| j.angle_error()).fold(0.0, f32::max);
        (fall.worst_gap, fall.worst_angle) = (fall.worst_gap.max(report.max_joint_error), fall.worst_angle.max(angle));
        if fall.landing.is_some_and(|landing| now > landing + settling) {
            (fall.gap, fall.angle) = (fall.gap.max(report.max_joint_error), fall.angle.max(angle));
        }
        fall.rest =
            (report.max_speed <= REST_SPEED).then(|| fall.rest.unwrap_or(now)).filter(|_| fall.landing.is_some());
    }
    fall
}

fn print(name: &str, fall: &Fall) {
    eprintln!(
        "{name}: landed {:.2} s, at rest from {:.2?} s on (speed {:.4} m/s); settled: gap {:.2} mm, beyond ranges {:.2}°; \
         worst: {:.1} mm, {:.1}°",
        fall.landing.unwrap_or(f64::NAN),
        fall.rest,
        fall.speed,
        1e3 * fall.gap,
        fall.angle.to_degrees(),
        1e3 * fall.worst_gap,
        fall.worst_angle.to_degrees()
    );
}

#[test]
fn a_ragdoll_dies() {
    let mut scene = scene("ragdoll", &[]);
    let fall = watch(&mut scene.world, scene.dt, 8.0, 1.0);
    print("ragdoll", &fall);
    let (landing, rest) = (fall.landing.unwrap(), fall.rest.expect("it never came to rest"));
    assert!(rest - landing < 5.0, "{rest}");
    assert!(fall.gap < 5e-3, "joints came apart by {} m", fall.gap);
    assert!(fall.angle.to_degrees() < 2.0, "ranges were left by {}°", fall.angle.to_degrees());
}

#[test]
fn a_heap_of_ragdolls_dies() {
    let mut scene = scene("ragdolls", &[("n", 20.0)]);
    let fall = watch(&mut scene.world, scene.dt, 12.0, 4.0);
    print("ragdolls n=20", &fall);
    let rest = fall.rest.expect("they never came to rest");
    assert!(rest - fall.landing.unwrap() < 11.0, "{rest}");
    assert!(fall.gap < 0.01, "joints came apart by {} m", fall.gap);
    assert!(fall.angle.to_degrees() < 2.0, "ranges were left by {}°", fall.angle.to_degrees());
}

/// Greatest gap of a jointed scene over `seconds`, m, and the speed at the end, m/s.
fn hang(name: &str, parameters: &[(&str, f64)], seconds: f64) -> (f32, f32) {
    let mut scene = scene(name, parameters);
    let mut gap = 0.0_f32;
    while scene.world.time() < seconds {
        gap = gap.max(scene.world.step(scene.dt).max_joint_error);
    }
    let speed = scene.world.report().max_speed;
    eprintln!("{name} {parameters:?}: greatest gap {:.2} mm in {seconds} s, then {speed:.4} m/s", 1e3 * gap);
    (gap, speed)
}

#[test]
fn chains_and_nets_hold() {
    let (gap, speed) = hang("chain", &[("end_mass_ratio", 1.0)], 5.0);
    assert!(gap < 0.01 && speed < 0.05, "{gap} m, {speed} m/s");
    let (gap, speed) = hang("chain", &[], 5.0);
    assert!(gap < 0.02 && speed < 0.05, "{gap} m, {speed} m/s");
    let (gap, _) = hang("joint_grid", &[("n", 10.0)], 3.0);
    assert!(gap < 0.03, "{gap} m");
}
