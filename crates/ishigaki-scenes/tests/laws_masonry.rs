//! Laws of stones without mortar: the harmonic overhang and the semicircular arch stand just inside the limit of
//! statics and fall just outside.
//!
//! Substeps of 50 sweeps, no longer than 1/240 s: so near to the limit the load must be right to a part in fifty, and a
//! few sweeps leave a chain of ten contacts too far from it while it settles. All else is as it is by default.

use ishigaki_scenes::{Scene, named};

/// Length of a step, s, and its substeps.
const STEPS: [(f32, u32); 3] = [(1.0 / 60.0, 4), (1.0 / 240.0, 1), (1.0 / 960.0, 1)];

/// A scene without sleep, with sweeps enough for the limit.
fn scene(name: &str, parameters: &[(&str, f64)], (dt, substeps): (f32, u32)) -> Scene {
    let parameters: Vec<_> = parameters.iter().map(|&(name, value)| (name.to_string(), value)).collect();
    let mut file = named(name, &parameters).unwrap();
    file.dt = dt;
    file.options.rest.sleep.enabled = false;
    file.options.solver.substeps = substeps;
    file.options.solver.sweeps = 50;
    file.options.solver.relax_sweeps = 5;
    file.build().unwrap()
}

/// Greatest way of a body from its start within 20 s, m; ends when one has gone `fallen` m.
fn greatest_move(scene: &mut Scene, fallen: f32) -> (f32, f64) {
    let center = |scene: &Scene, i: usize| scene.world.body(scene.bodies[i].1).unwrap().center();
    let starts: Vec<_> = (0..scene.bodies.len()).map(|i| center(scene, i)).collect();
    let mut worst = 0.0_f32;
    while scene.world.time() < 20.0 {
        scene.world.step(scene.dt);
        worst = (0..starts.len()).map(|i| (center(scene, i) - starts[i]).length()).fold(worst, f32::max);
        if worst > fallen {
            break;
        }
    }
    (worst, scene.world.time())
}

/// What is built inside its limit stands for 20 s, what is built outside falls.
fn stands_and_falls(name: &str, inside: &[(&str, f64)], outside: &[(&str, f64)], step: (f32, u32)) {
    let (inside_moves, _) = greatest_move(&mut scene(name, inside, step), 0.3);
    let (outside_moves, time) = greatest_move(&mut scene(name, outside, step), 0.3);
    let dt = 1.0 / step.0;
    eprintln!("{name} at 1/{dt:.0} s: {inside:?} moves {inside_moves:.1e} m, {outside:?} falls in {time:.1} s");
    assert!(inside_moves < 0.01, "{name} {inside:?} at 1/{dt:.0} s moved {inside_moves} m");
    assert!(outside_moves > 0.3, "{name} {outside:?} at 1/{dt:.0} s moved only {outside_moves} m in 20 s");
}

/// n planks reach Σ 1/(2k) of their length beyond the edge and no farther: 0.98 of it stands, 1.02 falls.
fn overhang(n: f64, step: (f32, u32)) {
    stands_and_falls("overhang", &[("n", n), ("fraction", 0.98)], &[("n", n), ("fraction", 1.02)], step);
}

#[test]
fn harmonic_overhang() {
    for n in [1.0, 2.0, 5.0, 10.0] {
        overhang(n, STEPS[0]);
    }
    for step in &STEPS[1..] {
        overhang(5.0, *step);
    }
}

/// A semicircular arch of n wedges stands above a thickness t/R and falls below it. The limits are those of n stones
/// whose thrust must pass through the joints between them; more stones come up to Milankovitch's 0.1075.
fn arch(stones: f64, limit: f64, step: (f32, u32)) {
    let thickness = |part: f64| [("stones", stones), ("thickness", part * limit)];
    stands_and_falls("arch", &thickness(1.05), &thickness(0.95), step);
}

#[test]
fn arch_of_few_stones() {
    for (stones, limit) in [(7.0, 0.0963), (9.0, 0.1021), (11.0, 0.1049)] {
        arch(stones, limit, STEPS[0]);
    }
    for step in &STEPS[1..] {
        arch(7.0, 0.0963, *step);
    }
}

#[test]
fn arch_of_many_stones() {
    for (stones, limit) in [(15.0, 0.1063), (21.0, 0.1068)] {
        arch(stones, limit, STEPS[0]);
    }
}
