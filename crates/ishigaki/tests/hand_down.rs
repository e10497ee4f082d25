//! Hand-down (`solver/hand_down.rs`): a wide stack finds its loads in one pass, in the wide path as in the reference.

mod on_floor;

use ishigaki::{Body, BodyKind, Shape, Vec3, World, WorldOptions};
use on_floor::{DT, world};

/// Boxes of 1 m, each on two others; how many there are.
fn pyramid(world: &mut World, base: u16) -> f32 {
    let mut bodies = 0.0;
    for row in 0..base {
        for i in 0..base - row {
            let x = f32::from(i) + 0.5 * f32::from(row) - 0.5 * f32::from(base);
            let at = Vec3::new(x, 0.5 + f32::from(row), 0.0);
            world.add_body(Body::dynamic(Shape::cuboid(0.5, 0.5, 0.5)).at(at).density(1000.0)).unwrap();
            bodies += 1.0;
        }
    }
    bodies
}

fn ground_impulse(world: &World) -> f32 {
    let ground = world.bodies().find(|(_, b)| b.kind() == BodyKind::Fixed).unwrap().0;
    let touching = world.contacts().filter(|c| c.a.body == ground || c.b.body == ground);
    touching.flat_map(|c| c.manifolds).flat_map(|m| &m.points).map(|p| p.impulse).sum()
}

fn first_step(base: u16, edit: fn(&mut WorldOptions)) -> (f32, f32) {
    let mut world = world(|o| {
        o.solver.wide.seed = false;
        edit(o);
    });
    let weight = pyramid(&mut world, base) * 1000.0 * 9.81 * DT;
    let report = world.step(DT);
    (report.max_speed, ground_impulse(&world) / weight)
}

#[test]
fn a_cold_pyramid_bears_its_weight_in_the_first_step() {
    let (speed, carried) = first_step(40, |_| {});
    assert!((carried - 1.0).abs() < 0.02, "{carried} of the weight arrives");
    assert!(speed < 0.01, "{speed} m/s");
    let (speed_without, carried_without) = first_step(40, |o| {
        (o.solver.hand_down.enabled, o.solver.level_correction.enabled) = (false, false);
    });
    assert!(speed_without > 10.0 * speed, "{speed_without} m/s without, {speed} with");
    assert!(carried_without < 0.9, "{carried_without}");
}

#[test]
fn the_wide_path_hands_down_as_the_reference_does() {
    // At rest the wide path takes one substep, the reference all.
    let mut world = world(|o| (o.solver.wide.seed, o.rest.aggressive_sleep.enabled) = (false, false));
    pyramid(&mut world, 32);
    // Something to correct in each step.
    let hit = Body::dynamic(Shape::ball(0.3)).at(Vec3::new(-3.0, 40.0, 0.0)).density(1000.0);
    world.add_body(hit.velocity(Vec3::new(0.0, -20.0, 0.0))).unwrap();
    world.step(DT);
    let mut worst = 0.0_f32;
    for _ in 0..30 {
        let mut reference = world.clone();
        let mut options = reference.options().clone();
        options.solver.wide.by_reference = true;
        reference.set_options(options).unwrap();
        reference.step(DT);
        let report = world.step(DT);
        assert_eq!(report.wide_rows, report.rows);
        for ((_, a), (_, b)) in world.bodies().zip(reference.bodies()) {
            let scale = a.velocity().length().max(1.0);
            worst = worst.max((a.velocity() - b.velocity()).length() / scale);
        }
    }
    eprintln!("worst {worst:.1e}");
    assert!(worst < 1e-4, "{worst}");
}

#[test]
fn a_wide_pyramid_stands() {
    let mut world = world(|_| {});
    pyramid(&mut world, 60);
    let mut worst = 0.0_f32;
    for _ in 0..600 {
        worst = worst.max(world.step(DT).max_penetration);
    }
    let report = world.report();
    assert!(report.max_speed < 0.01 && worst < 5e-4, "{} m/s, {worst} m", report.max_speed);
}

/// What flies apart is not held: momentum changes by gravity alone, whatever heights the bodies had on the ground.
#[test]
fn what_flies_keeps_its_momentum() {
    let mut world = world(|o| o.solver.level_correction.enabled = true);
    let bodies = pyramid(&mut world, 30);
    for _ in 0..10 {
        world.step(DT);
    }
    let handles: Vec<_> = world.bodies().filter(|(_, b)| b.kind() == BodyKind::Dynamic).map(|(h, _)| h).collect();
    for handle in &handles {
        world.body_mut(*handle).unwrap().set_velocity(Vec3::new(0.0, 5.0, 0.0)).unwrap();
    }
    world.step(DT);
    let mean = handles.iter().map(|h| world.body(*h).unwrap().velocity()).sum::<Vec3>() / bodies;
    assert!((mean - Vec3::new(0.0, 5.0 - 9.81 * DT, 0.0)).length() < 1e-3, "{mean}");
}

/// Amplified masses carry less than the weight: seeds of the true weight would throw the pyramid into the air.
#[test]
fn a_cold_pyramid_with_weight_amplification_is_not_thrown() {
    let mut world = world(|o| o.solver.weight_amplification.enabled = true);
    pyramid(&mut world, 40);
    let fastest = (0..5).map(|_| world.step(DT).max_speed).fold(0.0, f32::max);
    assert!(fastest < 1.0, "{fastest} m/s");
}
