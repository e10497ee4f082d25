//! Laws of stones without mortar: the harmonic overhang and the semicircular arch stand just inside the limit of
//! statics and fall just outside.
//!
//! Four substeps of 50 sweeps: so near to the limit the load must be right to a part in fifty, and a few sweeps
//! leave a chain of ten contacts too far from it while it settles. All else is as it is by default.

use ishigaki_scenes::{Scene, named};

/// A scene without sleep, with sweeps enough for the limit.
fn scene(name: &str, parameters: &[(&str, f64)]) -> Scene {
    let parameters: Vec<_> = parameters.iter().map(|&(name, value)| (name.to_string(), value)).collect();
    let mut file = named(name, &parameters).unwrap();
    file.options.rest.sleep.enabled = false;
    file.options.solver.substeps = 4;
    file.options.solver.sweeps = 50;
    file.options.solver.relax_sweeps = 5;
    file.build().unwrap()
}

/// Greatest way of a body from its start within 20 s, m; ends when one has gone `fallen` m.
fn greatest_move(scene: &mut Scene, fallen: f32) -> (f32, f64) {
    let center = |scene: &Scene, i: usize| scene.world.body(scene.bodies[i].1).unwrap().center();
    let starts: Vec<_> = (0..scene.bodies.len()).map(|i| center(scene, i)).collect();
    let mut worst = 0.0_f32;
    for _ in 0..20 * 60 {
        scene.world.step(1.0 / 60.0);
        worst = (0..starts.len()).map(|i| (center(scene, i) - starts[i]).length()).fold(worst, f32::max);
        if worst > fallen {
            break;
        }
    }
    (worst, scene.world.time())
}

/// n planks reach Σ 1/(2k) of their length beyond the edge and no farther: 0.98 of it stands, 1.02 falls.
#[test]
fn harmonic_overhang() {
    for n in [1.0, 2.0, 5.0, 10.0] {
        let (inside, _) = greatest_move(&mut scene("overhang", &[("n", n), ("fraction", 0.98)]), 0.3);
        let (outside, time) = greatest_move(&mut scene("overhang", &[("n", n), ("fraction", 1.02)]), 0.3);
        eprintln!("overhang of {n}: .98 moves {inside:.1e} m in 20 s, 1.02 falls in {time:.1} s");
        assert!(inside < 0.01, "{n} planks at 0.98 of the limit moved {inside} m");
        assert!(outside > 0.3, "{n} planks at 1.02 of the limit moved only {outside} m in 20 s");
    }
}

/// A semicircular arch of n wedges stands above a thickness t/R and falls below it. The limits are those of n stones
/// whose thrust must pass through the joints between them; more stones come up to Milankovitch's 0.1075.
fn arch(limits: &[(f64, f64)]) {
    for &(stones, limit) in limits {
        let thickness = |part: f64| [("stones", stones), ("thickness", part * limit)];
        let (inside, _) = greatest_move(&mut scene("arch", &thickness(1.05)), 0.3);
        let (outside, time) = greatest_move(&mut scene("arch", &thickness(0.95)), 0.3);
        eprintln!("arch of {stones}: 1.05 t moves {inside:.1e} m in 20 s, .95 t falls in {time:.1} s");
        assert!(inside < 0.01, "{stones} stones at 1.05 of the limit moved {inside} m");
        assert!(outside > 0.3, "{stones} stones at 0.95 of the limit moved only {outside} m in 20 s");
    }
}

#[test]
fn arch_of_few_stones() {
    arch(&[(7.0, 0.0963), (9.0, 0.1021), (11.0, 0.1049)]);
}

#[test]
fn arch_of_many_stones() {
    arch(&[(15.0, 0.1063), (21.0, 0.1068)]);
}
