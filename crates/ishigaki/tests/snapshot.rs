//! A restored world continues bit for bit; bytes that are no world are refused.
use ishigaki::*;

const DT: f32 = 1.0 / 60.0;

/// A body of five capsules on ball joints with cones.
fn doll(world: &mut World, at: Vec3) {
    let capsule =
        |a: Vec3, b: Vec3, r: f32| Body::dynamic(Shape::capsule_between(a - b, b - a, r)).at(at + 0.5 * (a + b));
    let torso = world.add_body(capsule(Vec3::ZERO, Vec3::Y * 0.5, 0.15)).unwrap();
    for (x, y, down) in [(0.25, 0.5, 0.0), (-0.25, 0.5, 0.0), (0.1, -0.2, 1.0), (-0.1, -0.2, 1.0)] {
        let root = Vec3::new(x, y, 0.0);
        let along = Vec3::new(x.signum() * (1.0 - down), -down, 0.1).normalize();
        let limb = world.add_body(capsule(root, root + along * 0.3, 0.07)).unwrap();
        world.add_joint(Joint::ball_about(torso, limb, at + root, along).cone(0.9).limit(-0.5..=0.5)).unwrap();
    }
}

/// Dolls, boxes and hulls over a bumpy ground of triangles.
fn scene(rest: bool) -> World {
    let mut options = WorldOptions::default();
    options.rest.sleep.enabled = rest;
    options.rest.aggressive_sleep.enabled = rest;
    options.solver.permutation = Permutation::PerSweep;
    let mut world = World::new(options).unwrap();
    let n = 12_u32;
    let height = |i: u32, j: u32| 0.1 * ((i * 7 + j * 3) % 5) as f32;
    let at = |i: u32, j: u32| Vec3::new(i as f32 - 6.0, height(i, j), j as f32 - 6.0);
    let vertices = (0..=n).flat_map(|j| (0..=n).map(move |i| at(i, j))).collect();
    let quads = (0..n).flat_map(|j| (0..n).map(move |i| j * (n + 1) + i));
    let triangles = quads.flat_map(|v| [[v, v + n + 1, v + 1], [v + 1, v + n + 1, v + n + 2]]).collect();
    world.add_body(Body::fixed(Shape::triangle_mesh(vertices, triangles).unwrap())).unwrap();
    for i in 0..3 {
        doll(&mut world, Vec3::new(0.3 * i as f32, 1.5 + 1.2 * i as f32, 0.2 * i as f32));
    }
    let gem: Vec<Vec3> = [0.2, -0.2].iter().flat_map(|&s| [Vec3::X * s, Vec3::Y * s, Vec3::Z * 2.0 * s]).collect();
    for i in 0..6 {
        let place = Vec3::new(0.5 * i as f32 - 1.5, 1.0 + 0.3 * i as f32, -0.4);
        world.add_body(Body::dynamic(Shape::cuboid(0.15, 0.2, 0.25)).at(place)).unwrap();
        world.add_body(Body::dynamic(Shape::convex_hull(&gem).unwrap()).at(place + Vec3::Y)).unwrap();
    }
    let last = world.bodies().last().unwrap().0;
    world.set_force_threshold(last, Some(f32::INFINITY));
    world
}

fn run(world: &mut World, steps: usize) -> Vec<u64> {
    (0..steps)
        .map(|_| {
            world.step(DT);
            world.state_hash()
        })
        .collect()
}

#[test]
fn a_restored_world_continues_bit_for_bit() {
    for rest in [true, false] {
        let mut world = scene(rest);
        run(&mut world, 150);
        world.validate().unwrap();
        let bytes = world.snapshot();
        let mut restored = World::restore(&bytes).unwrap();
        assert_eq!(restored.snapshot(), bytes, "the same state is the same bytes");
        let mut cloned = world.clone();
        let mut from_json: World = serde_json::from_str(&serde_json::to_string(&world).unwrap()).unwrap();
        let mut from_postcard: World = postcard::from_bytes(&postcard::to_stdvec(&world).unwrap()).unwrap();
        let expected = run(&mut world, 150);
        for (name, other) in [
            ("restored", &mut restored),
            ("cloned", &mut cloned),
            ("JSON", &mut from_json),
            ("bytes", &mut from_postcard),
        ] {
            let hashes = run(other, 150);
            let first = hashes.iter().zip(&expected).position(|(a, b)| a != b);
            assert_eq!(first, None, "{name} with rest {rest}: steps differ");
            assert_eq!(other.report(), world.report(), "{name}");
            assert_eq!(other.events(), world.events(), "{name}");
            assert_eq!((other.step_count(), other.time()), (300, world.time()), "{name}");
        }
        // And their whole states, not only poses.
        assert_eq!(restored.snapshot(), world.snapshot());
        // What is found by the restored broad phase is found when bodies come new, too.
        for w in [&mut world, &mut restored] {
            w.add_body(Body::dynamic(Shape::ball(0.3)).at(Vec3::new(0.0, 3.0, 0.0))).unwrap();
        }
        assert_eq!(run(&mut world, 60), run(&mut restored, 60));
    }
}

#[test]
fn a_sleeping_world_is_restored_asleep() {
    let mut world = World::default();
    world.add_body(Body::fixed(Shape::half_space(Vec3::Y))).unwrap();
    let cube = world.add_body(Body::dynamic(Shape::cuboid(0.5, 0.5, 0.5)).at(Vec3::Y * 0.5)).unwrap();
    run(&mut world, 90);
    let mut restored = World::restore(&world.snapshot()).unwrap();
    assert!(restored.body(cube).unwrap().is_asleep());
    assert_eq!(restored.step(DT).rows, 0);
    assert_eq!(restored.contacts().count(), 1);
}

#[test]
fn definitions_with_infinite_ends_survive_json() {
    let (a, b) = (BodyHandle::from((0, 0)), BodyHandle::from((1, 0)));
    let joint = Joint::hinge(a, b, Vec3::ZERO, Vec3::Y)
        .limit(f32::NEG_INFINITY..=1.5)
        .motor(1.0, f32::INFINITY)
        .breaking(f32::INFINITY, 7.0);
    let text = serde_json::to_string(&joint).unwrap();
    assert_eq!(serde_json::from_str::<Joint>(&text).unwrap(), joint);
    assert!(text.contains(r#""lower":"-inf","upper":1.5"#), "{text}");
    assert!(serde_json::from_str::<Range>(r#"{"lower":"low","upper":1}"#).is_err());
    let bytes = postcard::to_stdvec(&joint).unwrap();
    assert_eq!(postcard::from_bytes::<Joint>(&bytes).unwrap(), joint);
}

#[test]
fn a_world_with_a_broken_body_survives_json() {
    let mut world = World::default();
    let ball = world.add_body(Body::dynamic(Shape::ball(0.01))).unwrap();
    world.body_mut(ball).unwrap().apply_impulse(Vec3::X * 3e38).unwrap();
    world.step(DT);
    assert_eq!(world.report().non_finite, [ball]);
    let mut restored: World = serde_json::from_str(&serde_json::to_string(&world).unwrap()).unwrap();
    assert_eq!(restored.step(DT).non_finite, [ball]);
}

fn message(bytes: &[u8]) -> String {
    World::restore(bytes).expect_err("is no snapshot").to_string()
}

#[test]
fn bytes_that_are_no_snapshot_are_refused_with_the_reason() {
    let world = scene(true);
    let bytes = world.snapshot();
    let foreign = "snapshot: not a snapshot of Ishigaki: it does not begin with the mark of one";
    assert_eq!(message(b""), foreign);
    assert_eq!(message(&[0x50; 4000]), foreign);
    assert_eq!(message(&bytes[..12]), foreign);
    let damaged = "snapshot: damaged or cut off: its checksum does not fit";
    for length in [16, 17, 100, bytes.len() / 2, bytes.len() - 1] {
        assert_eq!(message(&bytes[..length]), damaged);
    }
    let mut flipped = bytes.clone();
    flipped[200] ^= 4;
    assert_eq!(message(&flipped), damaged);
    let mut newer = bytes.clone();
    newer[8] += 1;
    let version = u32::from(newer[8]);
    let expected = format!(
        "snapshot: of version {version}; this engine reads version {}: make it again with this engine",
        version - 1
    );
    assert_eq!(message(&newer), expected);
    assert!(serde_json::from_str::<World>("\"12zz\"").unwrap_err().to_string().contains("hexadecimal"));
    assert!(serde_json::from_str::<World>("\"123\"").is_err());
    assert!(serde_json::from_str::<World>("{}").is_err());
}

#[test]
fn garbage_with_a_good_checksum_is_refused_or_steps_without_panic() {
    let mut world = scene(true);
    run(&mut world, 40);
    let bytes = world.snapshot();
    let mut state = 7_u64;
    let mut random = move |n: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % n
    };
    let (mut refused, mut accepted) = (0, 0);
    for i in 0..1000 {
        let mut bad = bytes.clone();
        for _ in 0..=random(3) {
            let at = 16 + random(bad.len() - 16);
            bad[at] = if i % 2 == 0 { bad[at] ^ (1 << random(8)) } else { random(256) as u8 };
        }
        if i % 10 == 0 {
            bad.truncate(16 + random(bad.len() - 16));
        }
        let checksum = crc32fast::hash(&bad[16..]);
        bad[12..16].copy_from_slice(&checksum.to_le_bytes());
        match World::restore(&bad) {
            Ok(mut restored) => {
                accepted += 1;
                for _ in 0..3 {
                    restored.step(DT);
                }
                for (handle, _) in restored.bodies().map(|(h, b)| (h, b.pose())).collect::<Vec<_>>().into_iter().take(3)
                {
                    restored.remove_body(handle);
                }
                restored.step(DT);
            }
            Err(error) => {
                refused += 1;
                assert!(matches!(error, Error::Snapshot(_)), "{error}");
            }
        }
    }
    assert!(refused > 100 && accepted > 100, "{refused} refused, {accepted} accepted: the test sees only one side");
}

/// What the engine keeps of joints from step to step knows of an edit: a joint that loses its cone or begins to break is in
/// other lanes, or ends, as in a world that was restored after the edit.
#[test]
fn edited_joints_are_what_they_would_be_in_a_restored_world() {
    let mut world = World::default();
    world.add_body(Body::fixed(Shape::half_space(Vec3::Y))).unwrap();
    (0..6_u8).for_each(|k| doll(&mut world, Vec3::new(0.3 * f32::from(k), 1.0 + f32::from(k), 0.0)));
    (0..20).for_each(|_| drop(world.step(DT)));
    let joints: Vec<JointHandle> = world.joints().map(|(handle, _)| handle).collect();
    let free = JointKind::Ball { cone: None, twist: None, friction: 0.0, damping: 0.0 };
    for &joint in joints.iter().step_by(3) {
        world.edit_joint(joint, |j| j.kind = free.clone()).unwrap();
    }
    world.edit_joint(joints[1], |j| j.break_force = Some(1.0)).unwrap();
    let mut restored = World::restore(&world.snapshot()).unwrap();
    for _ in 0..60 {
        world.step(DT);
        restored.step(DT);
        assert_eq!(world.state_hash(), restored.state_hash());
    }
    assert!(world.joint(joints[1]).is_none(), "it broke");
}
