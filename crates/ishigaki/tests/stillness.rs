//! Steps of a world in which all sleeps are not taken: no bit may show that.
use ishigaki::*;

const DT: f32 = 1.0 / 60.0;

/// A floor, a lift that stands, a sleeping stack and a sleeping pendulum.
struct Still {
    world: World,
    lift: BodyHandle,
    boxes: Vec<BodyHandle>,
    joint: JointHandle,
}

fn still() -> Still {
    let mut world = World::default();
    let floor = world.add_body(Body::fixed(Shape::cuboid(20.0, 0.5, 20.0)).at(-0.5 * Vec3::Y)).unwrap();
    let lift = world.add_body(Body::kinematic(Shape::cuboid(0.5, 0.1, 0.5)).at(Vec3::new(3.0, 0.1, 0.0))).unwrap();
    let cube = |at| Body::dynamic(Shape::cuboid(0.25, 0.25, 0.25)).at(at);
    let stack = (0..3).map(|i| Vec3::new(0.0, 0.25 + 0.5 * i as f32, 0.0));
    let places = stack.chain([Vec3::new(3.0, 0.45, 0.0)]);
    let mut boxes: Vec<_> = places.map(|at| world.add_body(cube(at)).unwrap()).collect();
    let bob = world.add_body(cube(Vec3::new(-3.0, 2.0, 0.0))).unwrap();
    let joint = world.add_joint(Joint::ball(floor, bob, Vec3::new(-3.0, 3.0, 0.0))).unwrap();
    boxes.push(bob);
    for _ in 0..240 {
        world.step(DT);
    }
    assert_eq!(world.report().asleep, boxes.len());
    Still { world, lift, boxes, joint }
}

/// How often a step looks at the clock: once it is taken.
fn looks_at_clock(world: &mut World, dt: f32) -> usize {
    let mut looks = 0;
    let mut clock = || {
        looks += 1;
        0.0
    };
    world.step_with(dt, &mut StepContext { clock: Some(&mut clock), ..StepContext::default() });
    looks
}

/// A world without a memory of being still.
fn twin(world: &World) -> World {
    World::restore(&world.snapshot()).unwrap()
}

type Edit = fn(&mut World, &Still);

/// Every way to change a world from outside.
const EDITS: [(&str, Edit); 17] = [
    ("nothing", |_, _| {}),
    ("options", |w, _| w.set_options(WorldOptions { gravity: Vec3::X, ..w.options().clone() }).unwrap()),
    ("body", |w, _| {
        w.add_body(Body::dynamic(Shape::ball(0.2)).at(Vec3::new(0.0, 2.0, 0.0))).unwrap();
    }),
    ("bodies", |w, _| {
        drop(w.add_bodies(vec![Body::dynamic(Shape::ball(0.2)).at(Vec3::new(0.0, 2.0, 0.0))]).unwrap());
    }),
    ("support gone", |w, s| assert!(w.remove_body(s.boxes[0]))),
    ("pose", |w, s| w.body_mut(s.boxes[1]).unwrap().set_pose(Pose::from_translation(3.0 * Vec3::Y)).unwrap()),
    ("velocity", |w, s| w.body_mut(s.boxes[1]).unwrap().set_velocity(Vec3::X).unwrap()),
    ("force", |w, s| w.body_mut(s.boxes[4]).unwrap().apply_force(1e4 * Vec3::X).unwrap()),
    ("ground", |w, s| w.body_mut(s.lift).unwrap().set_pose(Pose::from_translation(Vec3::new(5.0, 0.1, 0.0))).unwrap()),
    ("target", |w, s| {
        let up = Pose::from_translation(Vec3::new(3.0, 0.15, 0.0));
        w.body_mut(s.lift).unwrap().set_kinematic_target(up).unwrap();
    }),
    ("sleep again", |w, s| w.body_mut(s.boxes[2]).unwrap().sleep()),
    ("excluded", |w, s| w.exclude_pair(s.boxes[0], s.boxes[1]).unwrap()),
    ("included", |w, s| w.include_pair(s.boxes[0], s.boxes[1]).unwrap()),
    ("joint", |w, s| {
        w.add_joint(Joint::fixed(s.boxes[2], s.boxes[3], Vec3::X)).unwrap();
    }),
    ("motor", |w, s| w.edit_joint(s.joint, |joint| joint.break_force = Some(1.0)).unwrap()),
    ("joint gone", |w, s| assert!(w.remove_joint(s.joint))),
    ("threshold", |w, s| assert!(w.set_force_threshold(s.boxes[0], Some(1.0)))),
];

#[test]
fn a_still_world_does_not_look_at_the_clock() {
    let Still { mut world, .. } = still();
    let (steps, time) = (world.step_count(), world.time());
    assert_eq!(looks_at_clock(&mut world, DT), 0);
    assert!(world.report().still);
    assert_eq!(world.step_count(), steps + 1);
    assert!((world.time() - time - f64::from(DT)).abs() < 1e-12);
    assert!(looks_at_clock(&mut twin(&world), DT) > 0);
    // A Δt that is none is refused, and leaves no report that a later step might repeat.
    assert!(world.step(f32::NAN).rejected.is_some());
    assert!(world.step(DT).rejected.is_none());
}

#[test]
fn every_edit_is_noticed() {
    for (name, edit) in EDITS {
        let mut still = still();
        let mut world = std::mem::take(&mut still.world);
        let mut other = twin(&world);
        edit(&mut world, &still);
        edit(&mut other, &still);
        for step in 0..60 {
            // Each step of the other one is its first.
            let events = other.events().to_vec();
            let dt = if step < 30 { DT } else { 0.5 * DT };
            let (report, taken) = (world.step(dt), other.step(dt));
            assert!(!taken.still);
            assert_eq!(StepReport { still: false, ..report }, taken, "{name}, step {step}");
            assert_eq!(world.events(), other.events(), "{name}, step {step}: {events:?} before");
            assert!(world.snapshot() == other.snapshot(), "{name}, step {step}");
            other = twin(&other);
        }
    }
}

#[test]
fn what_moves_is_not_still() {
    let Still { mut world, lift, .. } = still();
    world.body_mut(lift).unwrap().set_velocity(0.01 * Vec3::Y).unwrap();
    for _ in 0..60 {
        assert!(looks_at_clock(&mut world, DT) > 0);
    }
    assert!(world.body(lift).unwrap().position().y > 0.105);
}
