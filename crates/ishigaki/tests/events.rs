//! Events: what begins ends, once; nothing chatters.
use ishigaki::*;
use std::collections::BTreeSet;

const DT: f32 = 1.0 / 60.0;

fn floor(world: &mut World) -> BodyHandle {
    world.add_body(Body::fixed(Shape::cuboid(20.0, 0.5, 20.0)).at(Vec3::new(0.0, -0.5, 0.0))).unwrap()
}

/// Which pairs touch by what the events say; panics if one begins twice or ends without having begun.
#[derive(Default)]
struct Ledger {
    open: BTreeSet<(ShapeId, ShapeId)>,
    began: usize,
    ended: usize,
}

impl Ledger {
    fn read(&mut self, world: &World) {
        for event in world.events() {
            match *event {
                Event::ContactBegan { a, b } | Event::SensorEntered { sensor: a, other: b } => {
                    assert!(self.open.insert((a, b)), "began twice: {a:?} {b:?}");
                    self.began += 1;
                }
                Event::ContactEnded { a, b } | Event::SensorLeft { sensor: a, other: b } => {
                    assert!(self.open.remove(&(a, b)), "ended without having begun: {a:?} {b:?}");
                    self.ended += 1;
                }
                _ => {}
            }
        }
    }
}

#[test]
fn a_bouncing_ball_begins_and_ends_each_contact_once() {
    let mut world = World::default();
    floor(&mut world);
    world.add_body(Body::dynamic(Shape::ball(0.2)).at(Vec3::Y * 2.0).restitution(0.8).friction(0.3)).unwrap();
    let mut ledger = Ledger::default();
    for _ in 0..600 {
        world.step(DT);
        ledger.read(&world);
        let touching: BTreeSet<_> = world.contacts().map(|c| (c.a, c.b)).collect();
        assert_eq!(touching, ledger.open, "contacts() and events disagree");
    }
    assert!(ledger.began >= 3 && ledger.ended >= 2, "{}", ledger.began);
    assert_eq!(ledger.open.len(), 1, "at rest on the floor at last");
}

#[test]
fn a_resting_stack_does_not_chatter() {
    for aggressive in [true, false] {
        let mut options = WorldOptions::default();
        options.rest.sleep.enabled = false;
        options.rest.aggressive_sleep.enabled = aggressive;
        let mut world = World::new(options).unwrap();
        floor(&mut world);
        for i in 0..5 {
            let at = Vec3::new(0.02 * i as f32, 0.25 + 0.5 * i as f32, 0.0);
            world.add_body(Body::dynamic(Shape::cuboid(0.25, 0.25, 0.25)).at(at)).unwrap();
        }
        let mut ledger = Ledger::default();
        for _ in 0..600 {
            world.step(DT);
            ledger.read(&world);
        }
        assert_eq!((ledger.began, ledger.ended), (5, 0));
    }
}

#[test]
fn sensors_see_bodies_come_and_go() {
    let mut world = World::default();
    let sensor = Shape::cuboid(0.5, 0.5, 0.5).sensor();
    let gate = world.add_body(Body::fixed(sensor)).unwrap();
    let ball = world.add_body(Body::dynamic(Shape::ball(0.1)).at(Vec3::Y * 2.0)).unwrap();
    let lift = world.add_body(Body::kinematic(Shape::ball(0.1)).at(Vec3::X * -2.0).velocity(Vec3::X * 2.0)).unwrap();
    let mut ledger = Ledger::default();
    let mut seen = BTreeSet::new();
    for _ in 0..150 {
        world.step(DT);
        ledger.read(&world);
        seen.extend(ledger.open.iter().copied());
        // A sensor pushes nothing.
        assert_eq!(world.contacts().count(), 0);
    }
    let id = |body| ShapeId { body, ordinal: 0 };
    assert_eq!(seen, BTreeSet::from([(id(gate), id(ball)), (id(gate), id(lift))]));
    assert_eq!((ledger.began, ledger.ended), (2, 2));
    assert!((world.body(ball).unwrap().velocity().y + 9.81 * 2.5).abs() < 1e-2, "slowed by a sensor");
}

#[test]
fn removal_ends_what_touched() {
    let mut world = World::default();
    let ground = floor(&mut world);
    let gate = world.add_body(Body::fixed(Shape::cuboid(1.0, 1.0, 1.0).sensor())).unwrap();
    let cube = world.add_body(Body::dynamic(Shape::cuboid(0.2, 0.2, 0.2)).at(Vec3::Y * 0.2)).unwrap();
    let mut ledger = Ledger::default();
    for _ in 0..30 {
        world.step(DT);
        ledger.read(&world);
    }
    let id = |body| ShapeId { body, ordinal: 0 };
    assert_eq!(ledger.open, BTreeSet::from([(id(ground), id(cube)), (id(gate), id(cube))]));
    world.remove_body(cube);
    world.step(DT);
    let ended = Event::ContactEnded { a: id(ground), b: id(cube) };
    let left = Event::SensorLeft { sensor: id(gate), other: id(cube) };
    assert_eq!(world.events(), [ended, left]);
    world.step(DT);
    assert!(world.events().is_empty());
}

#[test]
fn an_exclusion_ends_the_contact_and_inclusion_begins_it_again() {
    let mut world = World::default();
    let ground = floor(&mut world);
    let cube = world.add_body(Body::dynamic(Shape::cuboid(0.2, 0.2, 0.2)).at(Vec3::Y * 0.2)).unwrap();
    let mut ledger = Ledger::default();
    let go = |world: &mut World, ledger: &mut Ledger| {
        world.step(DT);
        ledger.read(world);
    };
    go(&mut world, &mut ledger);
    assert_eq!(ledger.open.len(), 1);
    world.exclude_pair(cube, ground).unwrap();
    go(&mut world, &mut ledger);
    assert_eq!(ledger.open.len(), 0);
    world.include_pair(ground, cube).unwrap();
    go(&mut world, &mut ledger);
    assert_eq!(ledger.open.len(), 1);
    // A joint forbids them to touch unless it says otherwise.
    let joint = world.add_joint(Joint::ball(ground, cube, Vec3::ZERO)).unwrap();
    go(&mut world, &mut ledger);
    assert_eq!(ledger.open.len(), 0);
    world.edit_joint(joint, |j| j.collide = true).unwrap();
    go(&mut world, &mut ledger);
    assert_eq!(ledger.open.len(), 1);
}

#[test]
fn forces_above_a_threshold_are_reported() {
    let mut world = World::default();
    floor(&mut world);
    let cube = world.add_body(Body::dynamic(Shape::cuboid(0.5, 0.5, 0.5)).at(Vec3::Y * 0.5).sleepless()).unwrap();
    for _ in 0..60 {
        world.step(DT);
    }
    let weight = 1000.0 * 9.81;
    let force = |world: &World| {
        world.events().iter().find_map(|e| if let Event::ContactForce { force, .. } = e { Some(*force) } else { None })
    };
    assert!(world.set_force_threshold(cube, Some(1.05 * weight)));
    world.step(DT);
    assert_eq!(force(&world), None);
    assert!(world.set_force_threshold(cube, Some(0.95 * weight)));
    world.step(DT);
    let carried = force(&world).expect("its weight is above the threshold");
    assert!((carried / weight - 1.0).abs() < 0.01, "{carried} N of {weight} N");
    world.body_mut(cube).unwrap().apply_force(Vec3::Y * -weight).unwrap();
    world.step(DT);
    let pressed = force(&world).unwrap();
    assert!((pressed / (2.0 * weight) - 1.0).abs() < 0.02, "{pressed}");
    assert!(world.set_force_threshold(cube, None));
    world.step(DT);
    assert_eq!(force(&world), None);
    assert!(!world.set_force_threshold(cube, Some(f32::NAN)));
}

#[test]
fn joints_break_above_their_force_or_torque() {
    let weight = 1000.0 * 4.0 / 3.0 * std::f32::consts::PI * 0.008 * 9.81;
    // A ball hangs on a joint: it carries the weight.
    let hangs = |limit: f32| {
        let mut world = World::default();
        let hook = world.add_body(Body::fixed(Shape::ball(0.05)).at(Vec3::Y)).unwrap();
        let bob = world.add_body(Body::dynamic(Shape::ball(0.2))).unwrap();
        let joint = world.add_joint(Joint::ball(hook, bob, Vec3::Y).breaking(limit, f32::INFINITY)).unwrap();
        for _ in 0..60 {
            world.step(DT);
            for event in world.events() {
                let Event::JointBroke { joint: broken, force, .. } = *event else { continue };
                assert_eq!(broken, joint);
                assert!(force > limit);
                assert!(world.joint(joint).is_none(), "the handle is stale afterwards");
                assert!(!world.remove_joint(joint));
                assert!(world.edit_joint(joint, |_| ()).is_err());
                world.step(DT);
                assert!(world.events().is_empty(), "reported once");
                assert!(world.body(bob).unwrap().velocity().y < -0.1, "it falls");
                return false;
            }
        }
        let carried = world.joint(joint).unwrap().force().length();
        assert!((carried / weight - 1.0).abs() < 0.01, "{carried}");
        true
    };
    assert!(hangs(1.1 * weight));
    assert!(!hangs(0.9 * weight));

    // The same ball welded to a post at the side: the anchor carries weight × 1 m.
    let holds = |limit: f32| {
        let mut world = World::default();
        let post = world.add_body(Body::fixed(Shape::ball(0.05))).unwrap();
        let bob = world.add_body(Body::dynamic(Shape::ball(0.2)).at(Vec3::X)).unwrap();
        let joint = world.add_joint(Joint::fixed(post, bob, Vec3::ZERO).breaking(f32::INFINITY, limit)).unwrap();
        for _ in 0..60 {
            world.step(DT);
        }
        world.joint(joint).is_some()
    };
    assert!(holds(1.1 * weight));
    assert!(!holds(0.9 * weight));
}
