//! The same bits on any number of threads.
#![cfg(feature = "threads")]

use ishigaki::{Body, ContactHooks, Joint, PairView, Shape, ShapeId, StepContext, Vec3, World};

const DT: f32 = 1.0 / 60.0;

/// Towers, a wall that is hit, a heap of balls and boxes, and limbs that fall apart from each other: many islands, one of
/// them wide.
fn scene(world: &mut World) {
    world.add_body(Body::fixed(Shape::half_space(Vec3::Y))).unwrap();
    let mut add = |shape: Shape, at: Vec3, velocity: Vec3| {
        world.add_body(Body::dynamic(shape).at(at).velocity(velocity)).unwrap();
    };
    let half = 0.5_f32;
    for t in 0..60_u16 {
        for i in 0..20_u16 {
            let at = Vec3::new(3.0 * f32::from(t % 8), half + f32::from(i), 3.0 * f32::from(t / 8) - 40.0);
            add(Shape::cuboid(half, half, half), at, Vec3::ZERO);
        }
    }
    for row in 0..12_u16 {
        for i in 0..20_u16 {
            let at = Vec3::new(f32::from(i) + half * f32::from(row % 2), half + f32::from(row), 0.0);
            add(Shape::cuboid(half, half, half), at, Vec3::ZERO);
        }
    }
    add(Shape::ball(1.0), Vec3::new(10.0, 6.0, 8.0), Vec3::new(0.0, 0.0, -15.0));
    for i in 0..200_u16 {
        let at = Vec3::new(f32::from(i % 5) * 1.1, 1.0 + f32::from(i / 25), 20.0 + 1.1 * f32::from(i / 5 % 5));
        add(if i % 2 == 0 { Shape::ball(half) } else { Shape::cuboid(0.4, 0.4, 0.4) }, at, Vec3::ZERO);
    }
    for i in 0..400_u16 {
        let at = Vec3::new(-3.0 * f32::from(i % 20), 0.6, 3.0 * f32::from(i / 20));
        let limb = |at: Vec3| Body::dynamic(Shape::capsule(0.3, 0.2)).at(at);
        let (upper, lower) = (world.add_body(limb(at + Vec3::Y)).unwrap(), world.add_body(limb(at)).unwrap());
        world.add_joint(Joint::ball_about(upper, lower, at + 0.5 * Vec3::Y, Vec3::Y).cone(0.5)).unwrap();
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let hash = |threads: usize| {
        let mut world = World::default();
        world.set_threads(threads).unwrap();
        scene(&mut world);
        let mut events = Vec::new();
        for _ in 0..60 {
            world.step(DT);
            events.extend_from_slice(world.events());
        }
        let report = world.report();
        assert_eq!(report.wide_rows, report.rows);
        assert!(events.len() > 1000, "{} events", events.len());
        let counts = [report.pairs, report.contacts, report.narrow_phase_calls, report.ids_matched, report.frozen];
        (world.state_hash(), report.work, counts, report.max_penetration.to_bits(), format!("{events:?}"))
    };
    let alone = hash(1);
    for threads in [2, 3, 8] {
        assert!(hash(threads) == alone, "{threads} threads");
    }
}

/// Towers with heavy tops that are corrected, and a pyramid of boxes and bricks, some of which are turned: one batch, in as
/// many domains as there are threads.
#[test]
fn a_large_island_is_the_same_on_any_number_of_threads() {
    let hash = |threads: usize| {
        let mut world = World::default();
        world.set_threads(threads).unwrap();
        world.add_body(Body::fixed(Shape::half_space(Vec3::Y))).unwrap();
        let cuboid = |half: Vec3, at: Vec3| Body::dynamic(Shape::cuboid(half.x, half.y, half.z)).at(at);
        for tower in 0..8_u16 {
            for i in 0..12_u16 {
                let density = if i == 11 { 50_000.0 } else { 1000.0 };
                let at = Vec3::new(3.0 * f32::from(tower), 0.5 + f32::from(i), -30.0);
                world.add_body(cuboid(Vec3::splat(0.5), at).density(density)).unwrap();
            }
        }
        let mut turned = Vec::new();
        for level in 0..46_u16 {
            for i in 0..46 - level {
                let at =
                    Vec3::new(1.05 * f32::from(i) + 0.525 * f32::from(level), 0.505 + 1.01 * f32::from(level), 0.0);
                let depth = if i % 3 == 0 { 0.7 } else { 0.5 };
                let body = world.add_body(cuboid(Vec3::new(0.5, 0.5, depth), at)).unwrap();
                if i % 7 == 3 {
                    turned.push(body);
                }
            }
        }
        let ball = Body::dynamic(Shape::ball(1.0)).at(Vec3::new(22.0, 6.0, 8.0)).velocity(Vec3::new(0.0, 0.0, -15.0));
        world.add_body(ball).unwrap();
        let mut work = 0;
        for _ in 0..40 {
            for &body in &turned {
                world.body_mut(body).unwrap().apply_torque(Vec3::Y * 100.0).unwrap();
            }
            work += world.step(DT).work;
            assert_eq!(world.report().wide_rows, world.report().rows);
        }
        (world.state_hash(), work)
    };
    let alone = hash(1);
    for threads in [2, 3, 4, 16] {
        assert!(hash(threads) == alone, "{threads} threads");
    }
}

/// A net that is cut into cells, with cones for every seventh joint, onto which boxes fall; and a heap of boxes with a few limbs among them, whose
/// joints are not cut.
#[test]
fn joints_of_a_large_island_are_visited_in_one_order() {
    let hash = |threads: usize, residual: bool| {
        let mut world = World::default();
        world.set_threads(threads).unwrap();
        let mut options = world.options().clone();
        options.report.residual = residual;
        world.set_options(options).unwrap();
        world.add_body(Body::fixed(Shape::half_space(Vec3::Y))).unwrap();
        let mut net = Vec::new();
        for k in 0..48 * 48_u16 {
            let at = Vec3::new(f32::from(k % 48), 20.0, f32::from(k / 48) - 24.0);
            let shape = if k % 5 == 0 { Shape::cuboid(0.2, 0.3, 0.4) } else { Shape::ball(0.3) };
            let body = if k % 48 == 0 { Body::fixed(shape) } else { Body::dynamic(shape) };
            net.push(world.add_body(body.at(at)).unwrap());
            let k = usize::from(k);
            let mut tie = |other: usize, way: Vec3| {
                let joint = Joint::ball_about(net[other], net[k], at - 0.5 * way, way);
                world.add_joint(if k % 7 == 0 { joint.cone(0.4) } else { joint }).unwrap();
            };
            if k % 48 > 0 {
                tie(k - 1, Vec3::X);
                if k >= 48 {
                    tie(k - 48, Vec3::Z);
                }
            }
        }
        for i in 0..40_u16 {
            let at = Vec3::new(5.0 + f32::from(i), 20.8, f32::from(i % 7) - 3.0);
            world.add_body(Body::dynamic(Shape::cuboid(0.4, 0.4, 0.4)).at(at)).unwrap();
        }
        for i in 0..800_u16 {
            let at = Vec3::new(
                f32::from(i % 10) * 1.01 - 20.0,
                0.5 + f32::from(i / 100),
                1.01 * f32::from(i / 10 % 10) + 3.0,
            );
            let box_at = |at: Vec3| Body::dynamic(Shape::cuboid(0.5, 0.5, 0.5)).at(at);
            let body = world.add_body(box_at(at)).unwrap();
            if i % 100 == 55 {
                let limb = world.add_body(box_at(at + 9.0 * Vec3::Y)).unwrap();
                world.add_joint(Joint::ball(body, limb, at + 4.5 * Vec3::Y)).unwrap();
            }
        }
        let (mut work, mut residuals) = (0, Vec::new());
        for _ in 0..40 {
            let report = world.step(DT);
            assert_eq!(report.wide_rows, report.rows);
            work += report.work;
            residuals.push(report.residual.to_bits());
        }
        (world.state_hash(), work, residuals)
    };
    for residual in [false, true] {
        let alone = hash(1, residual);
        for threads in [2, 3, 8] {
            assert!(hash(threads, residual) == alone, "{threads} threads");
        }
    }
}

#[test]
fn hooks_are_called_in_the_order_of_pairs() {
    struct Log(Vec<(ShapeId, ShapeId)>);
    impl ContactHooks for Log {
        fn allow(&mut self, pair: &PairView<'_>) -> bool {
            self.0.push((pair.a, pair.b));
            true
        }
    }
    let calls = |threads: usize| {
        let mut world = World::default();
        world.set_threads(threads).unwrap();
        scene(&mut world);
        let mut log = Log(Vec::new());
        world.step_with(DT, &mut StepContext { hooks: Some(&mut log), ..StepContext::default() });
        (log.0, world.state_hash())
    };
    let (alone, several) = (calls(1), calls(2));
    assert!(alone.0.is_sorted_by_key(|(a, _)| a.body) && alone.0.len() > 1000);
    assert!(several == alone);
}

#[test]
fn no_threads_at_all_are_refused() {
    let error = World::default().set_threads(0).unwrap_err();
    assert!(error.to_string().starts_with("threads:"), "{error}");
}
