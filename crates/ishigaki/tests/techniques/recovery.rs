//! D1 penetration recovery, D2 slop, substeps and relax sweeps.

use crate::support::*;
use ishigaki::collision::manifold::Contact;
use ishigaki::*;

/// A ball of radius 0.5 m that overlaps the ground by `depth`: one contact point, solved exactly by one sweep.
fn overlapping_ball(solver: SolverOptions, depth: f32) -> (World, BodyHandle) {
    let mut world = world(solver);
    add_ground(&mut world);
    let ball = world.add_body(Body::dynamic(Shape::ball(0.5)).at(Vec3::Y * (0.5 - depth))).unwrap();
    (world, ball)
}

fn depth(world: &World, ball: BodyHandle) -> f32 {
    0.5 - body(world, ball).center().y
}

fn recovery(rate: f32) -> PenetrationRecovery {
    PenetrationRecovery { enabled: true, rate, ..PenetrationRecovery::default() }
}

#[test]
fn overlap_decays_as_powers_of_one_minus_k() {
    for k in [0.1, 0.3, 0.8, 1.0] {
        let solver = plain(|s| {
            s.penetration_recovery = recovery(k);
            s.relax_sweeps = 1;
        });
        let (mut world, ball) = overlapping_ball(solver, 0.02);
        let mut worst = 0.0_f32;
        for n in 1..=30 {
            world.step(DT);
            worst = worst.max((depth(&world, ball) - 0.02 * (1.0 - k).powi(n)).abs());
        }
        eprintln!("D1 recovery: k = {k}: worst deviation from d₀(1−k)ⁿ {:.1e} m", worst);
        assert!(worst < 2e-6, "k = {k}: {worst}");
    }
}

#[test]
fn without_recovery_overlap_stays() {
    let (mut world, ball) = overlapping_ball(plain(|_| {}), 0.02);
    run(&mut world, 60);
    assert!((depth(&world, ball) - 0.02).abs() < 2e-6, "{}", depth(&world, ball));
}

#[test]
fn recovery_is_never_faster_than_its_limit() {
    let solver = plain(|s| {
        s.penetration_recovery = PenetrationRecovery { enabled: true, rate: 1.0, max_speed: 1.5 };
        s.relax_sweeps = 1;
    });
    let (mut world, ball) = overlapping_ball(solver, 0.12);
    for n in 1..=4 {
        world.step(DT);
        assert!((depth(&world, ball) - (0.12 - 1.5 * DT * n as f32)).abs() < 2e-6);
    }
    world.step(DT); // the rest of 20 mm at once
    assert!(depth(&world, ball).abs() < 2e-6, "{}", depth(&world, ball));
}

#[test]
fn without_a_relax_sweep_the_push_stays_in_the_velocity() {
    let pushed = |relax_sweeps| {
        let solver = plain(|s| {
            s.penetration_recovery = recovery(0.5);
            s.relax_sweeps = relax_sweeps;
        });
        let (mut world, ball) = overlapping_ball(solver, 0.02);
        world.step(DT);
        body(&world, ball).velocity().y
    };
    assert!((pushed(0) - 0.5 * 0.02 / DT).abs() < 1e-5, "{}", pushed(0));
    assert!(pushed(1).abs() < 1e-6, "{}", pushed(1));
}

#[test]
fn slop_is_left_alone() {
    let solver = plain(|s| {
        s.penetration_recovery = recovery(0.5);
        s.slop.enabled = true;
        s.relax_sweeps = 1;
    });
    let (mut world, ball) = overlapping_ball(solver, 0.02);
    for n in 1..=30 {
        world.step(DT);
        assert!((depth(&world, ball) - (0.005 + 0.015 * 0.5_f32.powi(n))).abs() < 2e-6);
    }
}

/// Contacts as the talk has them: they are there only while things overlap.
struct OverlapOnly;

impl ContactHooks for OverlapOnly {
    fn modify(&mut self, _pair: &PairView<'_>, contact: &mut Contact) {
        let overlaps = contact.manifolds().iter().flat_map(|m| &m.points).any(|p| p.separation < 0.0);
        if !overlaps {
            contact.drop_points();
        }
    }
}

/// How often the support of one block switched on or off in a second, and how far it shook, m: k = 1, one substep.
fn shaking(slop: bool, overlap_only: bool) -> (usize, f32) {
    let mut world = world(plain(|s| {
        s.penetration_recovery = recovery(1.0);
        s.slop.enabled = slop;
    }));
    let ground = add_ground(&mut world);
    let block = world.add_body(cube(Vec3::Y * 0.501)).unwrap();
    let (mut toggles, mut low, mut high, mut supported) = (0, f32::MAX, f32::MIN, None);
    for step in 0..120 {
        let mut hooks = OverlapOnly;
        let hooks: Option<&mut dyn ContactHooks> = if overlap_only { Some(&mut hooks) } else { None };
        world.step_with(DT, &mut StepContext { clock: None, hooks });
        if step < 60 {
            continue; // it comes to rest first
        }
        let now = load_on(&world, ground, block) > 0.0;
        toggles += usize::from(supported.is_some_and(|before| before != now));
        supported = Some(now);
        let y = body(&world, block).center().y;
        (low, high) = (low.min(y), high.max(y));
    }
    (toggles, high - low)
}

#[test]
fn without_slop_support_switches_on_and_off() {
    let (toggles, shake) = shaking(false, true);
    let (quiet_toggles, quiet_shake) = shaking(true, true);
    eprintln!(
        "D2 slop: off {toggles} toggles/s, {:.2} mm; on {quiet_toggles}, {:.4} mm",
        shake * 1e3,
        quiet_shake * 1e3
    );
    assert!(toggles >= 30 && shake > 1e-3, "{toggles} toggles, {shake} m");
    assert!(quiet_toggles == 0 && quiet_shake < 2e-5, "{quiet_toggles} toggles, {quiet_shake} m");
}

#[test]
fn speculative_contacts_keep_support_even_without_slop() {
    // Beyond the talk: a contact that is there before things overlap does not switch off in exact balance.
    let (toggles, shake) = shaking(false, false);
    eprintln!("D2 slop off, speculative contacts: {toggles} toggles/s, {:.4} mm", shake * 1e3);
    assert!(toggles == 0 && shake < 2e-5, "{toggles} toggles, {shake} m");
}

#[test]
fn substeps_shorten_the_step_of_free_fall() {
    for substeps in [1, 2, 4] {
        let mut world = world(plain(|s| s.substeps = substeps));
        let ball = world.add_body(Body::dynamic(Shape::ball(0.5))).unwrap();
        run(&mut world, 30);
        let (h, n) = (DT / substeps as f32, 30 * substeps);
        let fall = G * h * h * (n * (n + 1) / 2) as f32;
        assert!((body(&world, ball).center().y + fall).abs() < 1e-4 * fall);
    }
}

#[test]
fn sweeps_are_counted_per_substep() {
    let mut world = world(plain(|s| (s.substeps, s.sweeps, s.relax_sweeps) = (3, 5, 2)));
    add_stack(&mut world, 2);
    assert_eq!(world.step(DT).sweeps, 3 * (5 + 2));
}

#[test]
fn more_sweeps_leave_less_residual() {
    let residual = |sweeps| {
        let mut world = world(plain(|s| s.sweeps = sweeps));
        add_column(&mut world, 5);
        world.step(DT).residual
    };
    let by_sweeps = [4, 8, 16, 32, 64].map(residual);
    eprintln!("column of 5, residual after 4, 8, 16, 32, 64 sweeps, N·s: {by_sweeps:?}");
    assert!(by_sweeps.windows(2).all(|w| w[1] < w[0]), "{by_sweeps:?}");
}
