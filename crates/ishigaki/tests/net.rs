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
