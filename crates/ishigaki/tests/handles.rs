//! Handles have generations; anything may be added or removed in any order.
use ishigaki::*;

const DT: f32 = 1.0 / 60.0;

fn ball(x: f32) -> Body {
    Body::dynamic(Shape::ball(0.2)).at(Vec3::new(x, 1.0, 0.0))
}

#[test]
fn a_stale_handle_finds_nothing() {
    let mut world = World::default();
    let (a, b) = (world.add_body(ball(0.0)).unwrap(), world.add_body(ball(1.0)).unwrap());
    let joint = world.add_joint(Joint::ball(a, b, Vec3::ZERO)).unwrap();
    assert!(world.remove_body(a));
    // The slot is used again by another body and another joint.
    let c = world.add_body(ball(2.0)).unwrap();
    assert_eq!((c.index(), c.generation()), (a.index(), a.generation() + 1));
    let next = world.add_joint(Joint::ball(b, c, Vec3::ZERO)).unwrap();
    assert_eq!(next.index(), joint.index());

    assert!(world.body(a).is_none());
    assert!(world.body_mut(a).is_none());
    assert!(!world.remove_body(a));
    assert_eq!(world.shapes_of(a).count(), 0);
    assert!(!world.set_force_threshold(a, Some(1.0)));
    assert!(world.joint(joint).is_none());
    assert!(!world.remove_joint(joint));
    let stale = |result: Result<()>, place: &str| {
        let message = format!("{place}: no such object: the handle is stale or of another world");
        assert_eq!(result.unwrap_err().to_string(), message);
    };
    stale(world.edit_joint(joint, |_| ()), "joint");
    stale(world.exclude_pair(a, b), "body_a");
    stale(world.include_pair(b, a), "body_b");
    stale(world.add_joint(Joint::ball(b, a, Vec3::ZERO)).map(|_| ()), "body_b");
    assert_eq!((world.bodies().count(), world.joints().count()), (2, 1));
    // A handle of a world with more bodies.
    assert!(world.body(BodyHandle::from((1000, 0))).is_none());
}

#[test]
fn a_batch_is_added_as_a_whole_or_not_at_all() {
    let mut world = World::default();
    let error = world.add_bodies(vec![ball(0.0), ball(1.0), ball(f32::NAN), ball(3.0)]).unwrap_err();
    assert_eq!(error.to_string(), "bodies[2].position: must be finite, is (NaN, 1, 0)");
    assert_eq!(world.bodies().count(), 0);
    assert_eq!(world.step(DT).bodies, 0);
    let handles = world.add_bodies((0..4).map(|i| ball(i as f32)).collect()).unwrap();
    let listed: Vec<_> = world.bodies().map(|(handle, _)| handle).collect();
    assert_eq!(handles, listed);
    // One by one or all at once: the same world.
    let mut single = World::default();
    for i in 0..4 {
        single.add_body(ball(i as f32)).unwrap();
    }
    for _ in 0..10 {
        world.step(DT);
        single.step(DT);
    }
    assert_eq!(world.state_hash(), single.state_hash());
}

/// splitmix64.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) % n as u64) as usize
    }

    fn place(&mut self) -> Vec3 {
        Vec3::new(self.below(100) as f32 * 0.03, 0.2 + self.below(100) as f32 * 0.03, self.below(100) as f32 * 0.03)
    }
}

fn any_body(random: &mut Random) -> Body {
    let shape = match random.below(5) {
        0 => Shape::ball(0.2),
        1 => Shape::cuboid(0.2, 0.1, 0.15),
        2 => Shape::capsule(0.2, 0.1),
        3 => Shape::compound(vec![Shape::ball(0.1), Shape::cuboid(0.1, 0.1, 0.1).at(Vec3::X * 0.2)]),
        _ => Shape::ball(0.3).sensor(),
    };
    let sensor = shape.sensor;
    let kind = match random.below(8) {
        0 => BodyKind::Kinematic,
        1 => BodyKind::Fixed,
        _ if sensor => BodyKind::Fixed,
        _ => BodyKind::Dynamic,
    };
    Body::new(kind, shape).at(random.place())
}

fn any_joint(random: &mut Random, a: BodyHandle, b: BodyHandle) -> Joint {
    let at = random.place();
    match random.below(6) {
        0 => Joint::ball(a, b, at).cone(0.5).limit(-0.3..=0.3),
        1 => Joint::hinge(a, b, at, Vec3::X).motor(2.0, 10.0),
        2 => Joint::slider(a, b, at, Vec3::Y).limit(-0.5..=0.5).spring(0.0, 100.0, 1.0),
        3 => Joint::fixed(a, b, at).breaking(500.0, 500.0),
        4 => Joint::rope(a, b, Vec3::ZERO, Vec3::ZERO, 1.0),
        _ => {
            let drive = Drive { limit: Some(Range::from(-0.5..=0.5)), ..Drive::default() };
            let freedoms = [Freedom::Locked, Freedom::Free(drive), Freedom::Locked];
            Joint::generic(a, b, Pose::from_translation(at), freedoms, vec![TurnAxis { axis: Vec3::X, drive }])
        }
    }
}

/// One random operation; stale handles are kept among the good ones and used again.
fn operate(world: &mut World, random: &mut Random, bodies: &mut Vec<BodyHandle>, joints: &mut Vec<JointHandle>) {
    let pick = |random: &mut Random, list: &[BodyHandle]| list[random.below(list.len())];
    match random.below(20) {
        0..5 => {
            if world.bodies().count() < 40 {
                bodies.push(world.add_body(any_body(random)).unwrap());
            }
        }
        5..8 => {
            let handle = pick(random, bodies);
            let there = world.body(handle).is_some();
            assert_eq!(world.remove_body(handle), there);
            assert!(world.body(handle).is_none());
        }
        8..11 => {
            let (a, b) = (pick(random, bodies), pick(random, bodies));
            let ok = a != b && world.body(a).is_some() && world.body(b).is_some();
            let joint = world.add_joint(any_joint(random, a, b));
            assert_eq!(joint.is_ok(), ok);
            joints.extend(joint);
        }
        11..13 if !joints.is_empty() => {
            let handle = joints[random.below(joints.len())];
            let there = world.joint(handle).is_some();
            assert_eq!(world.remove_joint(handle), there);
        }
        13 if !joints.is_empty() => {
            let handle = joints[random.below(joints.len())];
            let edit = |joint: &mut Joint| match &mut joint.kind {
                JointKind::Generic { linear, .. } => linear.swap(0, 1),
                JointKind::Hinge { drive } => drive.limit = Some(Range::from(-1.0..=1.0)),
                JointKind::Ball { cone, .. } => *cone = None,
                _ => joint.collide = !joint.collide,
            };
            assert_eq!(world.edit_joint(handle, edit).is_ok(), world.joint(handle).is_some());
        }
        14 => {
            let (a, b) = (pick(random, bodies), pick(random, bodies));
            let ok = a != b && world.body(a).is_some() && world.body(b).is_some();
            assert_eq!(world.exclude_pair(a, b).is_ok(), ok);
        }
        15 => {
            let (a, b) = (pick(random, bodies), pick(random, bodies));
            let ok = a != b && world.body(a).is_some() && world.body(b).is_some();
            assert_eq!(world.include_pair(a, b).is_ok(), ok);
        }
        16 => {
            let handle = pick(random, bodies);
            let place = random.place();
            if let Some(mut body) = world.body_mut(handle) {
                body.set_pose(Pose::from_translation(place)).unwrap();
                body.set_velocity(place).unwrap();
            }
        }
        17 => {
            let handle = pick(random, bodies);
            if let Some(mut body) = world.body_mut(handle) {
                let _ = body.set_kinematic_target(Pose::from_translation(Vec3::ONE));
                body.apply_impulse_at(Vec3::Y, Vec3::ZERO).unwrap();
                body.sleep();
            }
        }
        _ => {
            let report = world.step(DT);
            assert_eq!(report.bodies, world.bodies().count());
            assert!(report.non_finite.is_empty());
        }
    }
}

fn churn(seed: u64, operations: usize) -> World {
    let mut random = Random(seed);
    let mut world = World::default();
    let floor = world.add_body(Body::fixed(Shape::half_space(Vec3::Y))).unwrap();
    let (mut bodies, mut joints) = (vec![floor], Vec::new());
    for i in 0..operations {
        operate(&mut world, &mut random, &mut bodies, &mut joints);
        if i % 100 == 0 {
            world.validate().unwrap_or_else(|e| panic!("after operation {i}: {e}"));
            assert!(world.bodies().map(|(h, _)| h.index()).is_sorted());
            assert!(world.joints().map(|(h, _)| h.index()).is_sorted());
        }
        // Forget the oldest, or all handles would be stale at last.
        if bodies.len() > 80 {
            bodies.drain(1..20);
        }
    }
    world
}

#[test]
fn anything_may_be_added_and_removed_in_any_order() {
    let world = churn(5, 10_000);
    assert!(world.step_count() > 500);
    // The order of slots depends on the history alone.
    assert_eq!(churn(6, 1000).state_hash(), churn(6, 1000).state_hash());
}
