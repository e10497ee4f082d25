//! D6 shock propagation, D7 its blend, D8 weight amplification: what they gain, and what a scale reads with them.

use crate::support::*;
use ishigaki::*;

fn shock(blend: f32, sweeps: u32) -> SolverOptions {
    plain(|s| {
        s.shock_propagation = ShockPropagation { enabled: true, blend };
        s.sweeps = sweeps;
    })
}

fn amplified(factor: f32) -> WeightAmplification {
    WeightAmplification { enabled: true, factor, ..WeightAmplification::default() }
}

/// What a scale under `n` boxes reads, in weights of one box: the mean of half a second after one and a half.
fn reading(solver: SolverOptions, n: usize) -> f32 {
    let mut world = world(solver);
    let (ground, boxes) = add_stack(&mut world, n);
    run(&mut world, 90);
    mean_load(&mut world, ground, boxes[0], 30)
}

#[test]
fn without_them_a_scale_reads_the_weight_and_each_contact_what_lies_above() {
    let mut world = world(plain(|s| (s.warm_start.enabled, s.sweeps) = (true, 50)));
    let (ground, boxes) = add_stack(&mut world, 5);
    run(&mut world, 120);
    let below = [&[ground][..], &boxes[..4]].concat();
    let loads: Vec<f32> =
        below.iter().zip(&boxes).map(|(&lower, &upper)| load_on(&world, lower, upper) / (MASS * G)).collect();
    eprintln!("no amplification: contacts of a stack of 5 carry {loads:?} weights");
    for (k, load) in loads.iter().enumerate() {
        let weights = (5 - k) as f32;
        assert!((load - weights).abs() < 1e-3 * weights, "{loads:?}");
    }
}

#[test]
fn shock_propagation_loses_the_weight_of_all_boxes_but_one() {
    // The weight-feeling problem: wrong, and predicted.
    for n in [2, 5, 10] {
        let reading = reading(shock(1.0, 40), n);
        eprintln!("D6 shock: a scale under {n} boxes reads {reading:.4} weights");
        assert!((reading - 1.0).abs() < 0.01, "n = {n}: {reading}");
    }
}

#[test]
fn shock_propagation_solves_a_column_in_one_sweep() {
    let mut world = world(shock(1.0, 1));
    add_column(&mut world, 20);
    let report = world.step(DT);
    assert!(report.max_speed < 1e-5 && report.residual < 1e-3, "{} {}", report.max_speed, report.residual);
}

#[test]
fn blended_shock_reads_part_of_the_weight() {
    for (n, c) in [(5, 0.25), (5, 0.5), (5, 0.75), (10, 0.5)] {
        let reading = reading(shock(c, 400), n) / n as f32;
        let predicted = (1.0 - c) + c / n as f32;
        eprintln!(
            "D7 blended shock: c = {c}, {n} boxes: the scale reads {reading:.4} of the weight, predicted {predicted:.4}"
        );
        assert!((reading - predicted).abs() < 0.01, "n = {n}, c = {c}: {reading} against {predicted}");
    }
}

#[test]
fn blended_shock_takes_two_solves() {
    let mut world = world(shock(0.5, 7));
    add_stack(&mut world, 2);
    assert_eq!(world.step(DT).sweeps, 14);
}

#[test]
fn amplified_contacts_carry_a_geometric_sum() {
    for (n, c) in [(5, 1.4), (10, 1.4), (10, 2.0)] {
        let solver = plain(|s| {
            s.weight_amplification = amplified(c);
            s.warm_start.enabled = true;
            s.sweeps = 60;
        });
        let reading = reading(solver, n);
        let predicted: f32 = (0..n).map(|j| c.powi(-(j as i32))).sum();
        eprintln!("D8 WA {c}: a scale under {n} boxes reads {reading:.4} weights, predicted {predicted:.4}");
        assert!((reading - predicted).abs() < 0.02 * predicted, "n = {n}: {reading} against {predicted}");
    }
}

/// Sweeps after which no ball of a column of `n` falls faster than 1 % of g Δt, from a cold start.
fn sweeps_to_stop(n: usize, amplification: Option<f32>) -> u32 {
    let stops = |sweeps: u32| {
        let mut world = world(plain(|s| {
            s.sweeps = sweeps;
            if let Some(factor) = amplification {
                s.weight_amplification = amplified(factor);
            }
        }));
        add_column(&mut world, n);
        world.step(DT).max_speed <= 0.01 * G * DT
    };
    let (mut too_few, mut enough) = (0, 2000);
    while enough - too_few > 1 {
        let middle = (too_few + enough) / 2;
        if stops(middle) { enough = middle } else { too_few = middle }
    }
    enough
}

#[test]
fn amplification_makes_columns_converge_sooner() {
    // The figures of the talk's one-dimensional model.
    for (n, plain_sweeps, amplified_sweeps) in [(10, 192, 65), (20, 776, 129)] {
        let (plain, wa) = (sweeps_to_stop(n, None), sweeps_to_stop(n, Some(1.4)));
        eprintln!("D8 WA: column of {n}, sweeps to 1 %: {plain} without, {wa} with 1.4");
        assert!(plain.abs_diff(plain_sweeps) <= 2, "n = {n}: {plain}");
        assert!(wa.abs_diff(amplified_sweeps) <= 2, "n = {n}: {wa}");
    }
}

#[test]
fn amplification_of_mass_and_inertia_is_switched_apart() {
    let hash = |change: &dyn Fn(&mut WeightAmplification), locked: bool| {
        let mut world = world(plain(|s| {
            s.weight_amplification.enabled = true;
            change(&mut s.weight_amplification);
        }));
        if locked {
            add_column(&mut world, 5);
        } else {
            add_stack(&mut world, 5);
        }
        run(&mut world, 5);
        world.state_hash()
    };
    let off = |w: &mut WeightAmplification| w.enabled = false;
    let both = |_: &mut WeightAmplification| {};
    let mass = |w: &mut WeightAmplification| w.inertia = false;
    let inertia = |w: &mut WeightAmplification| w.mass = false;
    let neither = |w: &mut WeightAmplification| (w.mass, w.inertia) = (false, false);
    let one = |w: &mut WeightAmplification| w.factor = 1.0;
    // Balls that cannot turn feel the mass alone.
    assert_eq!(hash(&inertia, true), hash(&off, true));
    assert_eq!(hash(&mass, true), hash(&both, true));
    // Boxes feel both.
    assert_eq!(hash(&neither, false), hash(&off, false));
    assert_eq!(hash(&one, false), hash(&off, false));
    let all = [hash(&off, false), hash(&both, false), hash(&mass, false), hash(&inertia, false)];
    for (i, a) in all.iter().enumerate() {
        assert!(all[i + 1..].iter().all(|b| b != a), "{all:?}");
    }
}

/// Three boxes and balls that meet in free space, off center and with friction.
fn collide_freely(solver: SolverOptions) -> (StepReport, StepReport) {
    let mut world = world(solver);
    change_options(&mut world, |o| o.gravity = Vec3::ZERO);
    world.add_body(cube(Vec3::ZERO).angular_velocity(Vec3::new(0.3, 0.2, -0.5))).unwrap();
    world.add_body(cube(Vec3::new(1.6, 0.3, 0.1)).mass(300.0).velocity(Vec3::new(-2.0, 0.1, 0.0))).unwrap();
    world.add_body(Body::dynamic(Shape::ball(0.4)).at(Vec3::new(0.2, 2.0, 0.0)).velocity(-3.0 * Vec3::Y)).unwrap();
    let before = world.step(DT);
    run(&mut world, 60);
    (before, world.report().clone())
}

#[test]
fn free_collisions_conserve_momentum_whatever_is_amplified() {
    let wa = plain(|s| s.weight_amplification = amplified(1.4));
    for (name, solver) in [("plain", plain(|_| {})), ("WA", wa), ("shock", shock(1.0, 10)), ("blend", shock(0.5, 10))] {
        let (before, after) = collide_freely(solver);
        let linear = (after.momentum - before.momentum).length() / before.momentum.length();
        let angular = (after.angular_momentum - before.angular_momentum).length() / before.angular_momentum.length();
        let lost = before.kinetic_energy - after.kinetic_energy;
        eprintln!("{name}: momentum changed by {linear:.1e}, angular by {angular:.1e}; {lost:.0} J lost");
        assert!(linear < 1e-5 && angular < 1e-4, "{name}: {linear} {angular}");
        assert!(lost > 0.05 * before.kinetic_energy, "{name}: they did not meet");
    }
}

#[test]
fn bodies_of_one_height_are_not_amplified() {
    let mut world = world(plain(|s| s.weight_amplification = amplified(2.0)));
    let ice = Shape::half_space(Vec3::Y).friction(0.0);
    world.add_body(Body::fixed(ice)).unwrap();
    let still = world.add_body(cube(0.5 * Vec3::Y)).unwrap();
    let fast = world.add_body(cube(Vec3::new(-1.2, 0.5, 0.0)).velocity(2.0 * Vec3::X)).unwrap();
    run(&mut world, 60);
    assert_eq!([still, fast].map(|b| body(&world, b).height()), [Some(1), Some(1)]);
    let after = body(&world, still).velocity().x + body(&world, fast).velocity().x;
    assert!((after - 2.0).abs() < 1e-4, "{after}");
    assert!(body(&world, still).velocity().x > 0.9, "they did not meet");
}
