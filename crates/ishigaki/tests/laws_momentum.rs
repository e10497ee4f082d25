//! Constraints between bodies are internal: they change neither linear nor angular momentum, whatever their kind.
//! TALK B10. Without gravity, both about the world's origin.

mod laws;

use ishigaki::{
    Body, BodyHandle, Drive, Freedom, Joint, Pose, Quat, Range, Shape, TurnAxis, Vec3, World, WorldOptions,
};
use laws::{STEPS, options, weightless};

/// Total momentum and angular momentum from the bodies' states, in f64.
fn totals(world: &World) -> [f64; 6] {
    let mut sum = [0.0; 6];
    for (_, body) in world.bodies() {
        let d = |v: Vec3| v.to_array().map(f64::from);
        let (x, v, l, m) = (d(body.center()), d(body.velocity()), d(body.angular_momentum()), f64::from(body.mass()));
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            sum[i] += m * v[i];
            sum[3 + i] += l[i] + m * (x[j] * v[k] - x[k] * v[j]);
        }
    }
    sum
}

/// Σ |p| and Σ |L| + |x × p| of all bodies: what rounding errors are parts of.
fn sizes(world: &World) -> (f64, f64) {
    world.bodies().fold((0.0, 0.0), |(p, l), (_, body)| {
        let momentum = body.mass() * body.velocity().length();
        let angular = body.angular_momentum().length() + body.center().length() * momentum;
        (p + f64::from(momentum), l + f64::from(angular))
    })
}

/// Runs for 5 s; gives the greatest drift of P and L as parts of their sizes.
fn drift(name: &str, world: &mut World, dt: f32) -> (f64, f64) {
    let start = totals(world);
    let (mut p_size, mut l_size) = sizes(world);
    let (mut p_drift, mut l_drift) = (0.0_f64, 0.0_f64);
    for _ in 0..(5.0 / dt).round() as usize {
        let report = world.step(dt);
        assert!(report.non_finite.is_empty());
        let (p, l) = sizes(world);
        (p_size, l_size) = (p_size.max(p), l_size.max(l));
        let now = totals(world);
        let apart = |range: std::ops::Range<usize>| range.map(|i| (now[i] - start[i]).powi(2)).sum::<f64>().sqrt();
        (p_drift, l_drift) = (p_drift.max(apart(0..3)), l_drift.max(apart(3..6)));
    }
    eprintln!("{name}: P drifts by {:.1e}, L by {:.1e} in 5 s", p_drift / p_size, l_drift / l_size);
    (p_drift / p_size, l_drift / l_size)
}

/// A stick 1 m long from `x` on along +x, with a velocity of its own.
fn stick(world: &mut World, k: usize) -> BodyHandle {
    let phase = k as f64;
    let wave = |a: f64| (a + 1.7 * phase).sin() as f32;
    let shape = Shape::cuboid(0.5, 0.1, 0.15);
    let body = Body::dynamic(shape)
        .at(Vec3::new(k as f32, 0.0, 0.0))
        .velocity(Vec3::new(wave(0.3), wave(1.1), wave(2.3)))
        .angular_velocity(2.0 * Vec3::new(wave(0.7), wave(1.9), wave(3.1)));
    world.add_body(body).unwrap()
}

/// Two sticks that a joint holds together at x = ½.
fn pair(joint: impl Fn(BodyHandle, BodyHandle, Vec3) -> Joint) -> World {
    let mut world = weightless();
    let (a, b) = (stick(&mut world, 0), stick(&mut world, 1));
    world.add_joint(joint(a, b, 0.5 * Vec3::X)).unwrap();
    world
}

/// Only the joint acts between the two.
fn apart(joint: Joint) -> Joint {
    Joint { collide: false, ..joint }
}

fn every_kind() -> Vec<(&'static str, World)> {
    let drive = Drive { limit: Some(Range::from(-0.4..=0.5)), friction: 3.0, armature: 0.5, ..Drive::default() };
    let ends = (0.5 * Vec3::X, -0.5 * Vec3::X);
    vec![
        ("ball", pair(Joint::ball)),
        (
            "ball with limits",
            pair(|a, b, at| Joint::ball_about(a, b, at, Vec3::X).cone(0.6).limit(-0.3..=0.3).dry_friction(0.5)),
        ),
        ("hinge", pair(|a, b, at| Joint::hinge(a, b, at, Vec3::Y))),
        (
            "hinge, limit and spring",
            pair(|a, b, at| Joint::hinge(a, b, at, Vec3::Y).limit(-0.3..=0.6).spring(0.2, 200.0, 5.0)),
        ),
        ("hinge, motor", pair(|a, b, at| Joint::hinge(a, b, at, Vec3::Z).motor(3.0, 50.0))),
        ("slider", pair(|a, b, at| Joint::slider(a, b, at, Vec3::X).limit(-0.2..=0.8))),
        ("slider, spring", pair(|a, b, at| Joint::slider(a, b, at, Vec3::new(0.6, 0.8, 0.0)).spring(0.1, 300.0, 20.0))),
        ("fixed", pair(Joint::fixed)),
        ("rod", pair(|a, b, _| apart(Joint::distance(a, b, ends.1, ends.0, 2.0..=2.0)))),
        ("rope", pair(|a, b, _| apart(Joint::rope(a, b, ends.0, ends.1, 0.5)))),
        (
            "distance, spring",
            pair(|a, b, _| apart(Joint::distance(a, b, ends.0, ends.1, 0.0..=9.0).spring(0.3, 500.0, 10.0))),
        ),
        (
            "generic, three turns",
            pair(move |a, b, at| {
                let axes = [Vec3::X, Vec3::Z, Vec3::Y].map(|axis| TurnAxis { axis, drive });
                Joint::generic(a, b, Pose::from_translation(at), [Freedom::Locked; 3], axes.to_vec())
            }),
        ),
        (
            "generic, two ways and a turn",
            pair(move |a, b, at| {
                let turn = vec![TurnAxis { axis: Vec3::Y, drive: Drive::default() }];
                let linear = [Freedom::Free(drive), Freedom::Locked, Freedom::Free(drive)];
                Joint::generic(a, b, Pose::from_translation(at), linear, turn)
            }),
        ),
    ]
}

#[test]
fn joints_conserve_momentum() {
    for (name, mut world) in every_kind() {
        let (p, l) = drift(name, &mut world, 1.0 / 60.0);
        assert!(p < 1e-5, "{name}: momentum drifts by {p}");
        assert!(l < 1e-4, "{name}: angular momentum drifts by {l}");
    }
}

/// A body of ten sticks with joints of every kind, thrown and spinning.
fn tree() -> World {
    let mut world = weightless();
    let sticks: Vec<BodyHandle> = (0..8).map(|k| stick(&mut world, k)).collect();
    let at = |k: usize| Vec3::new(k as f32 + 0.5, 0.0, 0.0);
    let joints = [
        Joint::ball_about(sticks[0], sticks[1], at(0), Vec3::X).cone(0.8),
        Joint::hinge(sticks[1], sticks[2], at(1), Vec3::Y).limit(-1.0..=0.2),
        Joint::fixed(sticks[2], sticks[3], at(2)),
        Joint::slider(sticks[3], sticks[4], at(3), Vec3::Y).limit(-0.3..=0.3),
        Joint::ball(sticks[4], sticks[5], at(4)),
        Joint::hinge(sticks[5], sticks[6], at(5), Vec3::Z).motor(2.0, 20.0),
        Joint::rope(sticks[6], sticks[7], 0.5 * Vec3::X, -0.5 * Vec3::X, 0.4),
    ];
    for joint in joints {
        world.add_joint(joint).unwrap();
    }
    world
}

#[test]
fn a_floating_ragdoll_conserves_momentum() {
    let (p, l) = drift("tree of every joint", &mut tree(), 1.0 / 60.0);
    assert!(p < 1e-5 && l < 3e-4, "P drifts by {p}, L by {l}");
}

/// Boxes, balls, capsules and hulls that fly into each other, with friction and restitution.
fn crowd(restitution: f32, options: WorldOptions) -> World {
    let mut world = World::new(options).unwrap();
    let corners = [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]];
    let pyramid = corners.map(|corner| 0.4 * Vec3::from_array(corner));
    for k in 0..27_usize {
        let cell = Vec3::new((k % 3) as f32 - 1.0, (k / 3 % 3) as f32 - 1.0, (k / 9) as f32 - 1.0);
        let shape = match k % 4 {
            0 => Shape::cuboid(0.3, 0.2, 0.4),
            1 => Shape::ball(0.3),
            2 => Shape::capsule(0.2, 0.2),
            _ => Shape::convex_hull(&pyramid).unwrap(),
        };
        // Toward the middle, and each its own way round.
        let body = Body::dynamic(shape.friction(0.5).restitution(restitution))
            .at(1.2 * cell)
            .rotated(Quat::from_rotation_y(k as f32))
            .velocity(-1.5 * cell + 0.1 * Vec3::new(1.0, 2.0, -1.0))
            .angular_velocity(Vec3::new(cell.y, -cell.z, cell.x));
        world.add_body(body).unwrap();
    }
    world
}

/// With one substep and no relax sweep every impulse acts where its arms were measured: both momenta to rounding.
///
/// Without restitution: the bounce of a flat contact is solved point by point, and turns bodies by rounding more.
#[test]
fn collisions_conserve_momentum() {
    let mut options = WorldOptions { gravity: Vec3::ZERO, ..options() };
    options.solver.substeps = 1;
    options.solver.relax_sweeps = 0;
    // Aggressive sleep keeps arms of pairs that move on together, as substeps do.
    options.rest.aggressive_sleep.enabled = false;
    let (p, l) = drift("27 bodies that collide, one substep", &mut crowd(0.0, options), 1.0 / 60.0);
    assert!(p < 1e-5 && l < 3e-5, "P drifts by {p}, L by {l}");
}

/// A known defect: contacts keep their arms for the whole step while the bodies move on. In the later substeps the two
/// impulses of a contact are then off each other's line by the sliding since the step began, and angular momentum is
/// kept only to first order in the step. Momentum is kept.
#[test]
fn arms_of_contacts_are_a_step_old() {
    let drifts = STEPS.map(|dt| {
        let options = WorldOptions { gravity: Vec3::ZERO, ..options() };
        let name = format!("27 bodies that collide at 1/{:.0} s", 1.0 / dt);
        let (p, l) = drift(&name, &mut crowd(0.0, options), dt);
        assert!(p < 1e-5, "P drifts by {p}");
        assert!(l < 5e-3, "L drifts by {l}");
        l
    });
    assert!(drifts[0] > 1e-5, "angular momentum is kept to {}: this test is no longer needed", drifts[0]);
    assert!(drifts[2] < 0.5 * drifts[0], "the drift does not vanish with the step: {drifts:?}");
}
