//! D3 permutation, D4 warm start, and manifold blocks.

use crate::support::*;
use ishigaki::*;

/// The residual after each of `sweeps` sweeps of the first step of a stack, over that before the first sweep: the
/// quarter of a weight that each corner of the lowest box lacks.
fn stack_residuals(n: usize, permutation: Permutation, sweeps: u32) -> Vec<f32> {
    let mut world = world(plain(|s| (s.permutation, s.sweeps) = (permutation, sweeps)));
    change_options(&mut world, |o| o.report.residual_by_sweep = true);
    add_stack(&mut world, n);
    let report = world.step(DT);
    assert_eq!(report.residual_by_sweep.len(), sweeps as usize);
    report.residual_by_sweep.iter().map(|r| r / (0.25 * MASS * G * DT)).collect()
}

/// From which sweep on the residual stays below `part`.
fn sweeps_to(part: f32, residuals: &[f32]) -> usize {
    residuals.iter().rposition(|r| *r > part).map_or(1, |last| last + 2)
}

#[test]
fn a_stack_solved_in_changing_order_needs_fewer_sweeps() {
    let kinds = [Permutation::None, Permutation::PerStep, Permutation::PerSweep, Permutation::Alternating];
    let residuals = kinds.map(|kind| stack_residuals(10, kind, 3000));
    for part in [0.1, 0.01, 0.001] {
        let needed = residuals.each_ref().map(|r| sweeps_to(part, r));
        eprintln!("D3 permutation: stack of 10, sweeps to {part} by {kinds:?}: {needed:?}");
    }
    // The weight itself arrives equally fast in any order (columns below); what a fixed order feeds is the tail of
    // tilts, since each face is always solved corner after corner in the same way.
    let [fixed, changing @ ..] = residuals.each_ref().map(|r| sweeps_to(1e-3, r));
    assert!(changing.iter().all(|&sweeps| 3 * sweeps < fixed), "{fixed} against {changing:?}");
}

#[test]
fn on_one_point_chains_order_hardly_matters() {
    let needed = [Permutation::None, Permutation::PerSweep, Permutation::Alternating].map(|permutation| {
        let mut world = world(plain(|s| (s.permutation, s.sweeps) = (permutation, 1000)));
        change_options(&mut world, |o| o.report.residual_by_sweep = true);
        add_column(&mut world, 10);
        let report = world.step(DT);
        let relative: Vec<f32> = report.residual_by_sweep.iter().map(|r| r / (MASS * G * DT)).collect();
        sweeps_to(0.01, &relative)
    });
    eprintln!("D3 permutation: column of 10 balls, sweeps to 1 %: {needed:?}");
    let (least, most) = (needed.iter().min().unwrap(), needed.iter().max().unwrap());
    assert!(most < &(2 * least), "{needed:?}");
}

#[test]
fn permutation_is_seeded() {
    let hash = |seed, permutation| {
        let mut world = world(plain(|s| s.permutation = permutation));
        let mut options = world.options().clone();
        options.seed = seed;
        world.set_options(options).unwrap();
        add_stack(&mut world, 5);
        run(&mut world, 5);
        world.state_hash()
    };
    for permutation in [Permutation::PerStep, Permutation::PerSweep] {
        assert_eq!(hash(1, permutation), hash(1, permutation));
        assert_ne!(hash(1, permutation), hash(2, permutation));
    }
    assert_eq!(hash(1, Permutation::Alternating), hash(2, Permutation::Alternating));
}

/// Relative residual of each frame with ten sweeps, of a stack of 10.
fn residual_by_frame(warm: bool, add: impl Fn(&mut World), frames: usize) -> Vec<f32> {
    let mut world = world(plain(|s| s.warm_start.enabled = warm));
    add(&mut world);
    (0..frames).map(|_| world.step(DT).residual / (MASS * G * DT)).collect()
}

#[test]
fn a_warm_start_goes_on_where_the_last_frame_ended() {
    let column = |warm| residual_by_frame(warm, |w| _ = add_column(w, 10), 30);
    let stack = |warm| residual_by_frame(warm, |w| _ = add_stack(w, 10), 30);
    for (name, cold, warm) in [("column", column(false), column(true)), ("stack", stack(false), stack(true))] {
        eprintln!(
            "D4 warm start: {name} of 10, residual after 1, 10, 30 frames: cold {:.3} {:.3} {:.3}, warm {:.3} {:.1e} {:.1e}",
            cold[0], cold[9], cold[29], warm[0], warm[9], warm[29]
        );
        assert_eq!(cold[0], warm[0], "the first frame has nothing to start from");
        // Ten sweeps do not yet settle four points a box: a stack keeps more than a column.
        let kept = if name == "column" { 0.05 } else { 0.5 };
        assert!(warm[29] < kept * cold[29], "{name}: {} against {}", warm[29], cold[29]);
    }
}

#[test]
fn a_warm_start_takes_over_the_part_it_is_told() {
    let hash = |factor, enabled| {
        let mut world = world(plain(|s| s.warm_start = WarmStart { enabled, factor }));
        add_stack(&mut world, 4);
        run(&mut world, 10);
        world.state_hash()
    };
    assert_eq!(hash(0.0, true), hash(1.0, false));
    assert_ne!(hash(0.5, true), hash(1.0, true));
}

#[test]
fn impulses_scale_with_the_step() {
    // A settled stack goes on without a jerk when the step changes.
    let mut world = world(plain(|s| (s.warm_start.enabled, s.sweeps) = (true, 50)));
    add_stack(&mut world, 5);
    run(&mut world, 60);
    let before = world.report().residual;
    let after = world.step(0.5 * DT).residual;
    eprintln!("D4 warm start: residual {before:.2e} N·s, with half the step {after:.2e} N·s");
    assert!(after < 1e-3 * MASS * G * DT, "{before} {after}");
}

/// How far the top of a tower leans after 10 s, m, with ten sweeps, warm start, slop, recovery and WA.
fn lean(count: usize, manifold_block: bool) -> f32 {
    let mut world = world(plain(|s| {
        s.warm_start.enabled = true;
        s.penetration_recovery.enabled = true;
        s.slop.enabled = true;
        s.permutation = Permutation::PerSweep;
        s.weight_amplification.enabled = true;
        s.manifold_block.enabled = manifold_block;
    }));
    let (_, boxes) = add_stack(&mut world, count);
    run(&mut world, 600);
    let top = body(&world, boxes[count - 1]).center();
    (top - (count as f32 - 0.5) * Vec3::Y).length()
}

#[test]
fn manifold_blocks_keep_a_tower_upright() {
    // How far a tower leans without them is chance: five towers.
    let heights = 18..23;
    let leans = |on| heights.clone().map(|count| lean(count, on)).collect::<Vec<_>>();
    let (off, on) = (leans(false), leans(true));
    eprintln!("manifold blocks: tops of towers of {heights:?} after 10 s: {off:.3?} m off, {on:.3?} m on");
    assert!(on.iter().all(|&m| m < 0.05) && on.iter().sum::<f32>() < 0.2 * off.iter().sum::<f32>(), "{on:?} {off:?}");
}

#[test]
fn manifold_blocks_change_the_order_and_not_the_solution() {
    let loads = |enabled| {
        let mut world = world(plain(|s| {
            (s.sweeps, s.warm_start.enabled, s.manifold_block.enabled) = (200, true, enabled);
        }));
        let (ground, boxes) = add_stack(&mut world, 5);
        mean_load(&mut world, ground, boxes[0], 30)
    };
    assert!((loads(true) - loads(false)).abs() < 1e-3 * 5.0, "{} {}", loads(true), loads(false));
}
