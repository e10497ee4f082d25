//! A net of balls on ball joints that hangs on one side and swings: what sweeps leave undone must give it no energy.

mod on_floor;

use ishigaki::{Body, BodyHandle, Joint, Shape, Vec3, World, WorldOptions};
use on_floor::DT;

const SIDE: usize = 12;
const SPACING: f32 = 0.5;

/// Away from the floor of the world it is in.
fn net(edit: impl FnOnce(&mut WorldOptions)) -> World {
    let mut world = on_floor::world(edit);
    let mut balls: Vec<BodyHandle> = Vec::new();
    for i in 0..SIDE * SIDE {
        let (x, z) = (i % SIDE, i / SIDE);
        let at = Vec3::new(SPACING * x as f32, 20.0, SPACING * z as f32);
        let body = if x == 0 { Body::fixed(Shape::ball(0.1)) } else { Body::dynamic(Shape::ball(0.1)) };
        let ball = world.add_body(body.at(at)).unwrap();
        if x > 0 {
            world.add_joint(Joint::ball(balls[i - 1], ball, at - 0.5 * SPACING * Vec3::X)).unwrap();
        }
        if x > 0 && z > 0 {
            world.add_joint(Joint::ball(balls[i - SIDE], ball, at - 0.5 * SPACING * Vec3::Z)).unwrap();
        }
        balls.push(ball);
    }
    world
}

/// Greatest and least energy over the first two swings, as parts of what the fall to the lowest point sets free, and the
/// greatest gap, m.
fn swing(edit: impl FnOnce(&mut WorldOptions)) -> (f32, f32, f32) {
    let mut world = net(edit);
    let energy = |world: &World| world.report().kinetic_energy + world.report().potential_energy;
    world.step(DT);
    let (start, mut fastest, mut gap) = (energy(&world), 0.0_f32, 0.0_f32);
    let (mut most, mut least) = (0.0_f32, 0.0_f32);
    for _ in 0..150 {
        let report = world.step(DT);
        (fastest, gap) = (fastest.max(report.kinetic_energy), gap.max(report.max_joint_error));
        let change = energy(&world) - start;
        (most, least) = (most.max(change), least.min(change));
    }
    (most / fastest, least / fastest, gap)
}

#[test]
fn it_gains_no_energy_however_few_the_sweeps_are() {
    for wide in [true, false] {
        for (sweeps, relax_sweeps) in [(1, 1), (2, 1), (1, 4), (4, 2)] {
            let (most, least, gap) = swing(|o| {
                o.solver.wide.enabled = wide;
                // Within a net the reference solves a tree at once.
                o.solver.joint_tree.enabled = wide;
                (o.solver.sweeps, o.solver.relax_sweeps, o.solver.jointed.sweeps) = (sweeps, relax_sweeps, 1);
            });
            eprintln!("wide {wide}, {sweeps} + {relax_sweeps}: {most:+.4} {least:+.4} of the energy, gap {gap:.5} m");
            assert!(most < 0.005, "{sweeps} + {relax_sweeps}: gained {most}");
            assert!(least > -0.05, "{sweeps} + {relax_sweeps}: lost {least}");
            assert!(gap < 0.02, "{sweeps} + {relax_sweeps}: {gap} m");
        }
    }
}

#[test]
fn halving_the_substep_divides_what_it_loses() {
    let lost = |substeps| {
        let (_, least, _) = swing(|o| (o.solver.substeps, o.solver.sweeps) = (substeps, 4));
        -least
    };
    let (coarse, fine) = (lost(4), lost(8));
    eprintln!("lost at 4 and at 8 substeps: {coarse:.5} {fine:.5}");
    assert!(fine < 0.7 * coarse, "{coarse} and {fine}");
}

/// Greatest gap, m, in two seconds of a level net of `side` × `side` balls whose first column is fixed, its joints added in the
/// order that `order` makes of theirs: from ball to ball by index.
fn gap_of(side: usize, order: impl FnOnce(&mut Vec<(usize, usize)>)) -> f32 {
    gap_in(World::default(), side, order)
}

/// The same in this world.
fn gap_in(mut world: World, side: usize, order: impl FnOnce(&mut Vec<(usize, usize)>)) -> f32 {
    let at = |i: usize| Vec3::new((i % side) as f32, 0.0, (i / side) as f32);
    let balls: Vec<BodyHandle> = (0..side * side)
        .map(|i| {
            let ball = Shape::ball(0.4).groups(2, 1);
            let body = if i % side == 0 { Body::fixed(ball) } else { Body::dynamic(ball) };
            world.add_body(body.at(at(i))).unwrap()
        })
        .collect();
    let mut joints = Vec::new();
    for i in (0..side * side).filter(|i| i % side > 0) {
        joints.push((i - 1, i));
        joints.extend((i >= side).then(|| (i - side, i)));
    }
    order(&mut joints);
    for (a, b) in joints {
        world.add_joint(Joint::ball(balls[a], balls[b], 0.5 * (at(a) + at(b)))).unwrap();
    }
    (0..120).map(|_| world.step(DT).max_joint_error).fold(0.0, f32::max)
}

/// Visits go outward from what is fixed, whatever the order of joints (`solver/joint_link.rs`): along slots a net whose joints
/// are added from its far end would carry a load over one joint in a sweep.
#[test]
fn the_order_of_joints_does_not_decide_how_far_it_opens() {
    let outward = gap_of(20, |_| {});
    let inward = gap_of(20, |joints| joints.reverse());
    let columns = gap_of(20, |joints| joints.sort_by_key(|&(a, b)| (b % 20, a)));
    let odd = gap_of(20, |joints| joints.sort_by_key(|&(a, b)| (7 * a + 3 * b) % 11));
    eprintln!(
        "gap: {:.2} mm outward, {:.2} inward, {:.2} by columns, {:.2} at odds",
        1e3 * outward,
        1e3 * inward,
        1e3 * columns,
        1e3 * odd
    );
    for gap in [inward, columns, odd] {
        assert!((gap / outward - 1.0).abs() < 0.1, "{gap} and {outward}");
    }
}

/// Cuts go along branches (`solver/wide/domain.rs`): a net of 48 × 48 is cut, one of 40 × 40 is not.
#[test]
fn it_opens_no_farther_where_it_is_cut() {
    let (whole, cut) = (gap_of(40, |_| {}), gap_of(48, |_| {}));
    eprintln!("gap: {:.2} mm whole, {:.2} cut", 1e3 * whole, 1e3 * cut);
    assert!(cut < 1.3 * whole * 48.0 / 40.0, "{cut} and {whole}");
}

/// `solver/over_relaxation.rs`: with it one sweep before the motion does what two do without.
#[test]
fn over_relaxed_it_opens_no_farther_in_half_the_sweeps() {
    for side in [20, 30] {
        let gap = |enabled, sweeps| {
            let mut options = WorldOptions::default();
            (options.solver.over_relaxation.enabled, options.solver.sweeps) = (enabled, sweeps);
            1e3 * gap_in(World::new(options).unwrap(), side, |_| {})
        };
        let (plain, twice, over) = (gap(false, 1), gap(false, 2), gap(true, 1));
        eprintln!("{side}: {plain:.2} mm, {twice:.2} with two sweeps, {over:.2} over-relaxed");
        assert!(over < 0.7 * plain && over < 1.05 * twice, "{side}: {over}, {plain} and {twice}");
    }
}
