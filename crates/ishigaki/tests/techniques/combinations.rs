//! Every on/off combination of eleven techniques on a small scene of everything: finite, bounded, the same twice.

use crate::support::*;
use ishigaki::solver::permutation::Random;
use ishigaki::*;

const SWITCHES: u32 = 11;
const STEPS: usize = 60;

/// Bit k of `bits` switches technique k; where a technique has kinds, chance picks one.
fn options(bits: u32) -> WorldOptions {
    let mut random = Random(u64::from(bits));
    let on = |k: u32| bits & (1 << k) != 0;
    let mut pick = |kinds: u32| random.below(kinds);
    let mut options = WorldOptions { solver: SolverOptions::plain(), ..WorldOptions::default() };
    let solver = &mut options.solver;
    let steps = [(1, 10, 0), (2, 4, 1), (4, 2, 1)][pick(3) as usize];
    (solver.substeps, solver.sweeps, solver.relax_sweeps) = steps;
    solver.penetration_recovery.enabled = on(0);
    solver.slop.enabled = on(1);
    if on(2) {
        solver.permutation = [Permutation::PerStep, Permutation::PerSweep, Permutation::Alternating][pick(3) as usize];
    }
    solver.warm_start.enabled = on(3);
    solver.shock_propagation.enabled = on(4);
    solver.shock_propagation.blend = [0.5, 1.0][pick(2) as usize];
    solver.weight_amplification.enabled = on(5);
    if on(6) {
        solver.friction = [FrictionModel::Disk, FrictionModel::Box][pick(2) as usize];
    } else {
        solver.friction = FrictionModel::Off;
    }
    solver.restitution.enabled = on(7);
    options.rest.aggressive_sleep.enabled = on(8);
    options.rest.sleep.enabled = on(9);
    options.solver.manifold_block.enabled = on(10);
    options
}

/// A stack, a thrown ball that bounces, a capsule that rolls, a hull, a pendulum that hits the stack.
fn scene(options: WorldOptions) -> World {
    let mut world = World::new(options).unwrap();
    add_stack(&mut world, 3);
    let tetrahedron = [Vec3::ZERO, 0.6 * Vec3::X, 0.6 * Vec3::Y, 0.6 * Vec3::Z];
    let bodies = [
        Body::dynamic(Shape::ball(0.2).restitution(0.8))
            .at(Vec3::new(-2.0, 1.5, 0.1))
            .velocity(Vec3::new(4.0, 1.0, 0.0)),
        Body::dynamic(Shape::capsule(0.3, 0.2)).at(Vec3::new(1.5, 0.5, 0.0)).angular_velocity(3.0 * Vec3::Z),
        Body::dynamic(Shape::convex_hull(&tetrahedron).unwrap()).at(Vec3::new(0.0, 3.4, 0.0)),
    ];
    for body in bodies {
        world.add_body(body).unwrap();
    }
    let hook = world.add_body(Body::empty(BodyKind::Fixed).at(Vec3::new(2.0, 3.5, 0.0))).unwrap();
    let bob = world.add_body(Body::dynamic(Shape::ball(0.3)).at(Vec3::new(3.5, 3.5, 0.0))).unwrap();
    world.add_joint(Joint::ball(hook, bob, Vec3::new(2.0, 3.5, 0.0))).unwrap();
    world
}

fn run_checked(bits: u32) -> (u64, f32) {
    let mut world = scene(options(bits));
    let mut fastest = 0.0_f32;
    for step in 0..STEPS {
        let report = world.step(DT);
        assert!(report.non_finite.is_empty(), "combination {bits:#013b}: not finite at step {step}");
        fastest = fastest.max(report.max_speed);
    }
    (world.state_hash(), fastest)
}

#[test]
fn every_combination_is_finite_bounded_and_reproducible() {
    let mut worst = (0.0_f32, 0);
    for bits in 0..1 << SWITCHES {
        let (hash, fastest) = run_checked(bits);
        assert_eq!(hash, run_checked(bits).0, "combination {bits:#013b} is not reproducible");
        if fastest > worst.0 {
            worst = (fastest, bits);
        }
    }
    eprintln!("combinations: fastest body {:.2} m/s, in {:#013b}", worst.0, worst.1);
    // The ball's energy (18 J/kg) alone takes nothing beyond 7 m/s; the pendulum falls at 6.
    assert!(worst.0 < 12.0, "{} m/s in {:#013b}", worst.0, worst.1);
}
