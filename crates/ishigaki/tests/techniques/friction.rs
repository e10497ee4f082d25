//! C2: friction off, as a box, as a disk; and what the presets of options are.

use crate::support::*;
use ishigaki::*;

const MU: f32 = 0.5;

/// Velocity after a second of pushing a flat block of 1 kN weight along `angle` (degrees from x) with 1.2 μN.
fn pushed(model: FrictionModel, angle: f32) -> Vec3 {
    let mut world = world(plain(|s| {
        s.friction = model;
        s.warm_start.enabled = true;
        s.sweeps = 30;
    }));
    world.add_body(Body::fixed(Shape::half_space(Vec3::Y).friction(MU))).unwrap();
    let slab = Shape::cuboid(0.5, 0.05, 0.5).friction(MU);
    let block = world.add_body(Body::dynamic(slab).mass(100.0).at(0.05 * Vec3::Y)).unwrap();
    let angle = f64::from(angle).to_radians();
    let along = Vec3::new(angle.cos() as f32, 0.0, angle.sin() as f32);
    for _ in 0..60 {
        world.body_mut(block).unwrap().apply_force(1.2 * MU * 100.0 * G * along).unwrap();
        world.step(DT);
    }
    body(&world, block).velocity()
}

#[test]
fn without_friction_a_push_is_not_resisted() {
    let velocity = pushed(FrictionModel::Off, 0.0);
    assert!((velocity.x - 1.2 * MU * G).abs() < 1e-3, "{velocity}");
}

#[test]
fn pushed_along_the_diagonal_the_disk_slides_and_the_box_sticks() {
    let (disk, square) = (pushed(FrictionModel::Disk, 45.0), pushed(FrictionModel::Box, 45.0));
    eprintln!("C2 friction: 1.2 μN at 45° for 1 s: disk {:.4} m/s, box {:.1e} m/s", disk.length(), square.length());
    assert!((disk.length() - 0.2 * MU * G).abs() < 0.03 * 0.2 * MU * G, "{disk}");
    assert!((disk.x - disk.z).abs() < 0.01 * disk.length(), "{disk}");
    assert!(square.length() < 1e-3, "{square}");
}

#[test]
fn pushed_aslant_the_disk_slides_straight_and_the_box_along_its_axis() {
    let (disk, square) = (pushed(FrictionModel::Disk, 22.5), pushed(FrictionModel::Box, 22.5));
    let angle = |v: Vec3| f64::from(v.z).atan2(f64::from(v.x)).to_degrees();
    eprintln!("C2 friction: 1.2 μN at 22.5°: disk slides at {:.2}°, box at {:.2}°", angle(disk), angle(square));
    assert!((angle(disk) - 22.5).abs() < 0.5, "{disk}");
    assert!(angle(square).abs() < 0.5 && square.x > 0.1, "{square}");
}

#[test]
fn presets_are_what_their_names_say() {
    let plain = SolverOptions::plain();
    assert_eq!((plain.substeps, plain.sweeps, plain.relax_sweeps), (1, 10, 0));
    assert_eq!(plain.permutation, Permutation::None);
    let switches = |s: &SolverOptions| {
        [
            s.penetration_recovery.enabled,
            s.slop.enabled,
            s.warm_start.enabled,
            s.shock_propagation.enabled,
            s.weight_amplification.enabled,
            s.manifold_block.enabled,
        ]
    };
    assert_eq!(switches(&plain), [false; 6]);

    let talk = SolverOptions::talk();
    assert_eq!((talk.substeps, talk.sweeps, talk.relax_sweeps), (4, 10, 0));
    assert_eq!(talk.permutation, Permutation::PerSweep);
    assert_eq!(switches(&talk), [true, true, true, false, true, false]);
    assert_eq!(talk.weight_amplification.factor, 1.4);
    assert!(talk.weight_amplification.mass && talk.weight_amplification.inertia);

    for solver in [plain, talk, SolverOptions::default()] {
        assert_eq!(solver.friction, FrictionModel::Disk);
        assert!(solver.restitution.enabled && solver.joint_recovery.enabled);
        let per_substep = solver.sweeps + solver.relax_sweeps;
        let mut world = world(solver.clone());
        add_stack(&mut world, 2);
        assert_eq!(world.step(DT).sweeps as u32, solver.substeps * per_substep);
    }
}
