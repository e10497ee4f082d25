//! It holds: what is built well stands, judged by the words of `measure.rs`. Sleep is off, so that standing is the
//! solver's. Run with `--nocapture` to see the measured figures.

use ishigaki::{BodyKind, SolverOptions};
use ishigaki_scenes::{Measure, Meter, Scene, named};

/// A named scene with sleep switched off and the solver of the scene or another.
fn scene(name: &str, parameters: &[(&str, f64)], solver: Option<SolverOptions>) -> Scene {
    let parameters: Vec<_> = parameters.iter().map(|(key, value)| (key.to_string(), *value)).collect();
    let mut file = named(name, &parameters).unwrap();
    file.options.rest.sleep.enabled = false;
    if let Some(solver) = solver {
        file.options.solver = solver;
    }
    file.build().unwrap()
}

fn watch(scene: &mut Scene, seconds: f64) -> Measure {
    let mut meter = Meter::new(&scene.world);
    while scene.world.time() < seconds {
        scene.world.step(scene.dt);
        meter.observe(&scene.world);
        if !meter.measure().stands {
            break;
        }
    }
    let m = meter.measure();
    eprintln!(
        "{} for {:.1} s: stands {}, drift {:.1} mm, pen {:.2} mm, joint gap {:.2} mm, rest {:.2?} s, speed {:.4} m/s",
        scene.name,
        scene.world.time(),
        m.stands,
        1e3 * m.drift,
        1e3 * m.pen,
        1e3 * m.joint_gap,
        m.rest_time,
        m.speed
    );
    m
}

fn stands(name: &str, parameters: &[(&str, f64)], solver: Option<SolverOptions>, seconds: f64) -> Measure {
    let measure = watch(&mut scene(name, parameters, solver), seconds);
    assert!(measure.stands, "{name} {parameters:?} fell: {measure:?}");
    measure
}

#[test]
fn a_tower_of_forty_stands_with_the_talk() {
    stands("tower", &[("n", 40.0)], Some(SolverOptions::talk()), 60.0);
    // With manifold blocks ten sweeps in one substep are enough.
    let mut solver = SolverOptions { substeps: 1, ..SolverOptions::talk() };
    solver.manifold_block.enabled = true;
    let m = stands("tower", &[("n", 40.0)], Some(solver), 60.0);
    assert!(m.drift < 0.05, "{} m", m.drift);
}

#[test]
fn towers_stand_and_rest() {
    for n in [20.0, 40.0] {
        let m = stands("tower", &[("n", n)], None, 60.0);
        assert!(m.drift < 0.01 && m.pen < 0.005 && m.rest_time.is_some(), "{m:?}");
    }
}

#[test]
fn a_wall_stands() {
    stands("wall", &[], None, 60.0);
}

#[test]
fn an_arch_stands() {
    stands("arch", &[], None, 60.0);
    // At 1.1 times the least thickness the line of thrust has millimeters to go astray.
    stands("arch", &[("thickness", 1.1 * 0.1075)], None, 20.0);
}

#[test]
fn a_house_of_cards_stands() {
    stands("card_house", &[], None, 60.0);
}

#[test]
fn a_pyramid_stands() {
    let m = stands("pyramid", &[("base", 30.0)], None, 10.0);
    assert!(m.drift < 0.05, "{m:?}");
}

#[test]
fn planks_hang_out_over_a_table() {
    stands("overhang", &[], None, 20.0);
}

#[test]
fn heavy_bodies_stand_on_light_ones() {
    stands("heavy_on_light", &[("ratio", 10.0)], None, 20.0);
    stands("heavy_on_light", &[], None, 20.0);
    stands("plank_on_two_towers", &[], None, 20.0);
}

#[test]
fn dominoes_all_fall() {
    let mut scene = scene("dominoes", &[], None);
    while scene.world.time() < 20.0 {
        scene.world.step(scene.dt);
    }
    for (name, handle) in &scene.bodies {
        let body = scene.world.body(*handle).unwrap();
        let up = body.rotation() * ishigaki::Vec3::Y;
        assert!(body.kind() == BodyKind::Fixed || up.y < 0.8, "{name} stands: up is {up}");
    }
}

#[test]
fn a_bridge_holds() {
    let mut scene = scene("bridge", &[], None);
    let mut meter = Meter::new(&scene.world);
    while scene.world.time() < 20.0 {
        scene.world.step(scene.dt);
        meter.observe(&scene.world);
    }
    let m = meter.measure();
    eprintln!("bridge: joint gap {:.2} mm, pen {:.2} mm, speed {:.4} m/s", 1e3 * m.joint_gap, 1e3 * m.pen, m.speed);
    assert!(m.joint_gap < 0.03, "{} m", m.joint_gap);
    let lowest = scene.world.bodies().filter(|(_, b)| b.kind() == BodyKind::Dynamic).map(|(_, b)| b.position().y);
    assert!(lowest.fold(f32::MAX, f32::min) > 2.0, "it hangs too low, or a box fell");
}
