//! What the engine keeps from step to step, joints in their blocks, room in its lists and what it knows of sleepers, changes
//! no bit: a world that was restored a moment ago has none of it.

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
        let counts = |r: &ishigaki::StepReport| (r.asleep, r.islands, r.narrow_phase_calls, r.max_penetration);
        assert_eq!(counts(&report), counts(&of_other), "{what}, step {step}");
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

/// Towers of three boxes that sleep, and a ball that rolls among them.
#[test]
fn contacts_and_roles_of_sleepers_are_those_of_restored_ones() {
    let mut world = World::default();
    let ground = world.add_body(Body::fixed(Shape::half_space(Vec3::Y))).unwrap();
    let mut boxes = Vec::new();
    for k in 0..36_u16 {
        let at = Vec3::new(3.0 * f32::from(k / 3 % 4), 0.5 + f32::from(k % 3), 3.0 * f32::from(k / 12));
        boxes.push(world.add_body(Body::dynamic(Shape::cuboid(0.5, 0.5, 0.5)).at(at)).unwrap());
    }
    // The last two of a row are a gap of 2 mm apart: less than a body falls in 1/60 s, more than in half of it.
    let row = [0.0, 1.0, 2.002]
        .map(|x| world.add_body(Body::dynamic(Shape::cuboid(0.5, 0.5, 0.5)).at(Vec3::new(x, 0.5, -4.0))).unwrap());
    let platform = Vec3::new(-6.0, 3.0, 0.0);
    let plate = world.add_body(Body::fixed(Shape::cuboid(1.0, 0.1, 1.0)).at(platform)).unwrap();
    for height in [0.6, 1.6] {
        let on_it = platform + height * Vec3::Y;
        world.add_body(Body::dynamic(Shape::cuboid(0.5, 0.5, 0.5)).at(on_it)).unwrap();
    }
    let ball = Body::dynamic(Shape::ball(0.4)).at(Vec3::new(-40.0, 0.4, 1.5)).velocity(2.0 * Vec3::X);
    let ball = world.add_body(ball).unwrap();
    (0..120).for_each(|_| drop(world.step(DT)));
    assert_eq!(world.report().asleep, 36 + 3 + 2);
    compare(&mut world, 3, DT, "all but the ball sleep");
    world.body_mut(row[0]).unwrap().set_velocity(-0.1 * Vec3::X).unwrap();
    compare(&mut world, 1, 0.5 * DT, "what is 2 mm from the second is not of its island in half a step");
    assert!(world.body(row[2]).unwrap().is_asleep());
    compare(&mut world, 60, DT, "a step again");
    world.body_mut(plate).unwrap().set_pose(Pose::from_translation(platform - 9.0 * Vec3::X)).unwrap();
    compare(&mut world, 60, DT, "what two stood on is gone");

    let mut options = world.options().clone();
    options.gravity *= 1.5;
    options.solver.slop.depth *= 0.5;
    world.set_options(options).unwrap();
    compare(&mut world, 3, DT, "other options");
    world.add_body(Body::dynamic(Shape::cuboid(0.2, 0.2, 0.2)).at(Vec3::new(0.1, 4.0, 0.0))).unwrap();
    compare(&mut world, 90, DT, "something falls on a tower");
    world.body_mut(boxes[10]).unwrap().set_velocity(Vec3::X).unwrap();
    compare(&mut world, 40, DT, "one of another tower is pushed");
    assert!(world.remove_body(boxes[12]));
    compare(&mut world, 60, DT, "the lowest of a tower was removed");
    // Another body takes the slot of one that slept.
    assert!(world.remove_body(boxes[35]));
    compare(&mut world, 2, DT, "one that slept was removed");
    let fixed = Body::fixed(Shape::cuboid(0.5, 0.1, 0.5)).at(Vec3::new(9.0, 4.0, 6.0));
    assert!(world.add_body(fixed).is_ok());
    compare(&mut world, 30, DT, "something fixed in the slot of a sleeper");
    let joint = world.add_joint(Joint::ball(boxes[18], boxes[21], Vec3::new(7.5, 0.5, 3.0))).unwrap();
    compare(&mut world, 80, DT, "a joint between towers");
    assert!(world.remove_joint(joint));
    compare(&mut world, 80, DT, "and none any more");
    world.exclude_pair(boxes[24], boxes[25]).unwrap();
    compare(&mut world, 5, DT, "two that touch no longer may");
    world.include_pair(boxes[24], boxes[25]).unwrap();
    compare(&mut world, 30, DT, "and may again");
    world.body_mut(ground).unwrap().set_pose(Pose::from_translation(-0.05 * Vec3::Y)).unwrap();
    compare(&mut world, 30, DT, "the ground was moved");
    assert!(world.remove_body(ball));
    for step in 0..400 {
        world.step(DT);
        if step % 20 == 0 {
            compare(&mut world, 1, DT, "until all sleep");
        }
    }
    assert!(world.report().asleep > 30);
    assert!(world.remove_body(ground));
    compare(&mut world, 20, DT, "no ground");
    assert_eq!(world.report().asleep, 0);
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
