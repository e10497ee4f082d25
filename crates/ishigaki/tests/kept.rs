//! What the engine keeps from step to step, joints in their blocks and room in its lists, changes no bit: a world that was
//! restored a moment ago has none of it.

use ishigaki::{Body, BodyHandle, Event, Joint, JointHandle, JointKind, Pose, Shape, Vec3, World};

const DT: f32 = 1.0 / 60.0;

fn restored(world: &World) -> World {
    World::restore(&world.snapshot()).unwrap()
}

/// Steps a world beside one that is restored before each of them.
fn compare(world: &mut World, steps: usize, dt: f32, what: &str) {
    for step in 0..steps {
        let mut other = restored(world);
        let (report, of_other) = (world.step(dt), other.step(dt));
        assert_eq!(world.state_hash(), other.state_hash(), "{what}, step {step}");
        assert_eq!((report.pairs, report.contacts), (of_other.pairs, of_other.contacts), "{what}, step {step}");
        assert_eq!(report.max_joint_error, of_other.max_joint_error, "{what}, step {step}");
        assert_eq!(report.work, of_other.work, "{what}, step {step}");
        assert_eq!(world.snapshot(), other.snapshot(), "{what}, step {step}");
    }
}

/// A level net of `side` × `side` balls beside a free chain, with drags on a few joints if asked for.
fn net(side: usize, drags: bool) -> (World, Vec<BodyHandle>, Vec<JointHandle>) {
    let mut world = World::default();
    let at = |i: usize| Vec3::new((i % side) as f32, 0.0, (i / side) as f32);
    let (mut balls, mut joints) = (Vec::new(), Vec::new());
    for i in 0..side * side {
        let ball = Shape::ball(0.4).groups(2, 1);
        let body = if i % side == 0 { Body::fixed(ball) } else { Body::dynamic(ball) };
        balls.push(world.add_body(body.at(at(i))).unwrap());
        let before = [i.checked_sub(1).filter(|_| i % side > 0), i.checked_sub(side).filter(|_| i % side > 0)];
        for other in before.into_iter().flatten() {
            joints.push(world.add_joint(Joint::ball(balls[other], balls[i], 0.5 * (at(other) + at(i)))).unwrap());
        }
    }
    if drags {
        let kind = JointKind::Ball { cone: Some(0.3), twist: None, friction: 0.1, damping: 0.2 };
        for &joint in joints.iter().step_by(5) {
            world.edit_joint(joint, |j| j.kind = kind.clone()).unwrap();
        }
    }
    (world, balls, joints)
}

#[test]
fn joints_that_stay_in_their_blocks_have_the_impulses_of_restored_ones() {
    for drags in [false, true] {
        let (mut world, balls, joints) = net(10, drags);
        compare(&mut world, 6, DT, "hanging");
        compare(&mut world, 3, 0.5 * DT, "half a step");
        world.body_mut(balls[0]).unwrap().set_pose(Pose::from_translation(Vec3::new(0.1, 0.2, 0.0))).unwrap();
        compare(&mut world, 3, DT, "what it hangs on was moved");
        world.body_mut(balls[55]).unwrap().apply_impulse(Vec3::new(10.0, 200.0, 0.0)).unwrap();
        compare(&mut world, 3, DT, "pushed");
        world.edit_joint(joints[7], |j| j.break_force = Some(1.0)).unwrap();
        compare(&mut world, 3, DT, "a joint breaks");
        assert!(world.joint(joints[7]).is_none());
        assert!(world.remove_joint(joints[20]));
        compare(&mut world, 3, DT, "a joint was removed");
        // As many joints as before, but others.
        assert!(world.remove_joint(joints[30]));
        let middle = 0.5 * (world.body(balls[46]).unwrap().position() + world.body(balls[57]).unwrap().position());
        world.add_joint(Joint::ball(balls[46], balls[57], middle)).unwrap();
        compare(&mut world, 3, DT, "a joint in the place of another");
        // The reference solves some steps, then the lanes do again.
        let mut options = world.options().clone();
        for step in 0..4 {
            (options.solver.wide.by_reference, options.solver.wide.enabled) = (step == 0, step != 2);
            world.set_options(options.clone()).unwrap();
            compare(
                &mut world,
                3,
                DT,
                ["by the reference in the order of the lanes", "", "by the reference", ""][step],
            );
        }
        let kind = JointKind::Ball { cone: Some(0.2), twist: None, friction: 0.0, damping: 0.0 };
        world.edit_joint(joints[51], |j| j.kind = kind).unwrap();
        compare(&mut world, 3, DT, "a joint has a cone now");
        world.add_body(Body::dynamic(Shape::ball(0.2)).at(Vec3::new(4.0, 1.0, 4.0))).unwrap();
        assert!(world.remove_body(balls[44]));
        compare(&mut world, 3, DT, "a ball was removed, another one falls");
        let fixed = balls[10];
        world.body_mut(fixed).unwrap().apply_force(Vec3::splat(f32::MAX)).unwrap();
        world.body_mut(fixed).unwrap().apply_force(Vec3::splat(f32::MAX)).unwrap();
        compare(&mut world, 3, DT, "forces beyond all numbers on what is fixed");
    }
}

/// Bodies that fall and come to rest lose and gain contacts in each step.
#[test]
fn room_in_the_lists_of_pairs_and_contacts_changes_no_bit() {
    let mut world = World::default();
    world.add_body(Body::fixed(Shape::half_space(Vec3::Y))).unwrap();
    let mut bodies = Vec::new();
    for k in 0..160_u16 {
        let (layer, x, z) = (f32::from(k / 16), f32::from(k % 4), f32::from(k / 4 % 4));
        let shape = match k % 3 {
            0 => Shape::cuboid(0.2, 0.15, 0.25),
            1 => Shape::ball(0.22),
            _ => Shape::capsule(0.15, 0.14),
        };
        let at = Vec3::new(0.55 * x + 0.03 * layer, 0.4 + 0.5 * layer, 0.5 * z - 0.02 * layer);
        bodies.push(world.add_body(Body::dynamic(shape).at(at)).unwrap());
    }
    let mut greatest = 0;
    for part in 0..30 {
        compare(&mut world, 4, DT, "heap");
        greatest = greatest.max(world.report().contacts);
        if part == 15 {
            assert!(bodies[..40].iter().step_by(4).all(|&body| world.remove_body(body)));
        }
    }
    assert!(greatest > 200, "{greatest} contacts");
}

/// A ball whose group touches nothing asks for no neighbors, until something comes that it may touch.
#[test]
fn what_was_alone_finds_what_comes_later() {
    for rests in [false, true] {
        let mut world = World::default();
        let ball = world.add_body(Body::dynamic(Shape::ball(0.5).groups(4, 8)).at(Vec3::Y)).unwrap();
        let mut options = world.options().clone();
        options.gravity = if rests { Vec3::ZERO } else { options.gravity };
        world.set_options(options.clone()).unwrap();
        (0..90).for_each(|_| drop(world.step(DT)));
        assert_eq!(world.body(ball).unwrap().is_asleep(), rests);
        let below = world.body(ball).unwrap().position() - 0.9 * Vec3::Y;
        world.add_body(Body::fixed(Shape::cuboid(2.0, 0.1, 2.0).groups(8, 4)).at(below - 0.2 * Vec3::Y)).unwrap();
        options.gravity = -9.81 * Vec3::Y;
        world.set_options(options).unwrap();
        world.body_mut(ball).unwrap().set_velocity(Vec3::ZERO).unwrap();
        let began = (0..60).any(|_| {
            world.step(DT);
            world.events().iter().any(|event| matches!(event, Event::ContactBegan { .. }))
        });
        assert!(began && world.body(ball).unwrap().position().y > below.y, "rests {rests}");
    }
}

/// The same on two threads, for a net that is cut (decision 034).
#[cfg(feature = "threads")]
#[test]
fn threads_keep_the_same() {
    let (mut alone, _, _) = net(48, false);
    let (mut world, balls, _) = net(48, false);
    world.set_threads(2).unwrap();
    for step in 0..12 {
        if step == 6 {
            for world in [&mut alone, &mut world] {
                world.body_mut(balls[100]).unwrap().apply_impulse(Vec3::new(0.0, 900.0, 0.0)).unwrap();
            }
        }
        let mut other = restored(&alone);
        alone.step(DT);
        world.step(DT);
        other.step(DT);
        assert_eq!(alone.state_hash(), world.state_hash(), "step {step}");
        assert_eq!(alone.state_hash(), other.state_hash(), "step {step}, restored");
    }
}
