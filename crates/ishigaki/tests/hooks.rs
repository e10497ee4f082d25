//! A say in contacts: one-way platforms, conveyors, filters.
use ishigaki::*;

const DT: f32 = 1.0 / 60.0;

fn step(world: &mut World, hooks: &mut dyn ContactHooks) -> StepReport {
    world.step_with(DT, &mut StepContext { clock: None, hooks: Some(hooks) })
}

/// Holds from above only.
struct OneWay(BodyHandle);

impl ContactHooks for OneWay {
    fn modify(&mut self, pair: &PairView<'_>, contact: &mut collision::manifold::Contact) {
        let (above, up) = if pair.a.body == self.0 {
            (pair.body_b, -1.0)
        } else if pair.b.body == self.0 {
            (pair.body_a, 1.0)
        } else {
            return;
        };
        let from_above = contact.manifolds().iter().all(|m| up * m.normal.y > 0.9);
        if !from_above || above.velocity().y > 0.1 {
            contact.drop_points();
        }
    }
}

#[test]
fn a_one_way_platform_lets_through_from_below_and_holds_from_above() {
    let mut world = World::default();
    let platform = world.add_body(Body::fixed(Shape::cuboid(2.0, 0.05, 2.0)).at(Vec3::Y * 2.0)).unwrap();
    let ball = world.add_body(Body::dynamic(Shape::ball(0.2)).at(Vec3::Y).velocity(Vec3::Y * 7.0)).unwrap();
    let mut highest = 0.0_f32;
    for _ in 0..240 {
        step(&mut world, &mut OneWay(platform));
        highest = highest.max(world.body(ball).unwrap().position().y);
    }
    // v²/2g above the start: it lost nothing on its way through.
    assert!((highest - 1.0 - 49.0 / (2.0 * 9.81)).abs() < 0.08, "{highest}");
    let rest = world.body(ball).unwrap().position().y;
    assert!((rest - 2.25).abs() < 0.01, "{rest}");
}

/// Moves what lies on a floor that is shape A.
struct Belt;

impl ContactHooks for Belt {
    fn modify(&mut self, _: &PairView<'_>, contact: &mut collision::manifold::Contact) {
        assert!((contact.friction() - 0.6).abs() < 1e-6, "the mixed friction, anew in each step");
        contact.set_friction(1.0);
        // B's surface relative to A's: the floor runs along +x.
        contact.set_surface_velocity(-Vec3::X);
        contact.set_friction(f32::NAN);
        contact.set_restitution(2.0);
        contact.set_surface_velocity(Vec3::INFINITY);
    }
}

#[test]
fn a_hook_can_make_a_conveyor() {
    let mut world = World::default();
    world.add_body(Body::fixed(Shape::half_space(Vec3::Y))).unwrap();
    let cube = world.add_body(Body::dynamic(Shape::cuboid(0.2, 0.2, 0.2)).at(Vec3::Y * 0.2)).unwrap();
    for _ in 0..90 {
        step(&mut world, &mut Belt);
    }
    assert_eq!(world.contacts().next().unwrap().friction, 1.0);
    let velocity = world.body(cube).unwrap().velocity();
    assert!((velocity - Vec3::X).length() < 0.02, "{velocity}");
    // Without the hook the floor stands still again.
    for _ in 0..60 {
        world.step(DT);
    }
    assert!(world.body(cube).unwrap().velocity().length() < 1e-3);
}

/// Refuses contacts of what is called a ghost, and remembers what it was asked.
#[derive(Default)]
struct Ghosts(Vec<(ShapeId, ShapeId)>);

impl ContactHooks for Ghosts {
    fn allow(&mut self, pair: &PairView<'_>) -> bool {
        self.0.push((pair.a, pair.b));
        pair.body_a.name() != "ghost" && pair.body_b.name() != "ghost"
    }

    fn modify(&mut self, pair: &PairView<'_>, _: &mut collision::manifold::Contact) {
        assert!(pair.body_b.name() != "ghost");
    }
}

#[test]
fn a_filter_is_asked_in_the_order_of_pairs_and_is_obeyed() {
    let mut world = World::default();
    world.add_body(Body::fixed(Shape::half_space(Vec3::Y))).unwrap();
    let cube = |name: &str, x: f32| Body::dynamic(Shape::cuboid(0.2, 0.2, 0.2)).named(name).at(Vec3::new(x, 0.3, 0.0));
    let solid = world.add_body(cube("solid", 0.0)).unwrap();
    let ghost = world.add_body(cube("ghost", 2.0)).unwrap();
    let mut hooks = Ghosts::default();
    for _ in 0..60 {
        hooks.0.clear();
        step(&mut world, &mut hooks);
        assert!(hooks.0.is_sorted());
        let touches_ghost = |e: &Event| matches!(e, Event::ContactBegan { b, .. } if b.body == ghost);
        assert!(!world.events().iter().any(touches_ghost));
    }
    assert!(world.body(solid).unwrap().position().y > 0.19);
    assert!(world.body(ghost).unwrap().position().y < -3.0);
}

#[test]
fn the_clock_times_every_stage() {
    let mut world = World::default();
    let mut now = 0.0;
    let mut clock = || {
        now += 1.0;
        now
    };
    let report = world.step_with(DT, &mut StepContext { clock: Some(&mut clock), hooks: None });
    assert_eq!(report.stage_seconds, [1.0; 10]);
    assert_eq!(world.step(DT).stage_seconds, [0.0; 10]);
}
