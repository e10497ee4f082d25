//! Joint trees: long chains under heavy loads, loops, and what must not change.

use ishigaki::{Body, BodyHandle, Joint, Shape, Vec3, World, WorldOptions};

const DT: f32 = 1.0 / 60.0;

fn world(change: impl FnOnce(&mut WorldOptions)) -> World {
    let mut options = WorldOptions::default();
    options.rest.sleep.enabled = false;
    change(&mut options);
    World::new(options).unwrap()
}

/// Links of 1 m from a hook along `along`, each 1 kg, the last one a ball of `end` kg.
fn add_chain(world: &mut World, links: usize, along: Vec3, end: f32, hook: bool) -> Vec<BodyHandle> {
    let hook = hook.then(|| world.add_body(Body::fixed(Shape::ball(0.1)).at(-0.5 * along)).unwrap());
    let mut bodies: Vec<BodyHandle> = Vec::new();
    for k in 0..links {
        let mass = if k + 1 == links { end } else { 1.0 };
        let link = Body::dynamic(Shape::ball(0.2)).mass(mass).at(k as f32 * along);
        let link = world.add_body(link).unwrap();
        if let Some(before) = bodies.last().copied().or(hook) {
            let anchor = (k as f32 - 0.5) * along;
            world.add_joint(Joint::ball(before, link, anchor)).unwrap();
        }
        bodies.push(link);
    }
    bodies
}

/// Greatest opening of a joint in `seconds`, m.
fn gap(world: &mut World, seconds: f32) -> f32 {
    let mut gap = 0.0_f32;
    for _ in 0..(seconds / DT) as usize {
        gap = gap.max(world.step(DT).max_joint_error);
    }
    gap
}

#[test]
fn a_chain_bears_a_thousand_times_its_links() {
    for (along, name) in [(-Vec3::Y, "hanging"), (Vec3::X, "released from level")] {
        let run = |enabled| {
            let mut world = world(|o| o.solver.joint_tree.enabled = enabled);
            add_chain(&mut world, 100, along, 1000.0, true);
            gap(&mut world, 3.0)
        };
        let (on, off) = (run(true), run(false));
        eprintln!("chain of 100, end 1000 ×, {name}: {:.3} mm on, {:.0} mm off", 1e3 * on, 1e3 * off);
        assert!(on < 1e-3, "{name}: {on} m");
        assert!(off > 0.01, "{name}: {off} m without");
    }
}

/// A chain thrown into empty space keeps P and L.
#[test]
fn a_free_chain_keeps_its_momenta() {
    let mut world = world(|o| o.gravity = Vec3::ZERO);
    let links = add_chain(&mut world, 8, Vec3::X, 1.0, false);
    for (k, &link) in links.iter().enumerate() {
        let velocity = Vec3::new(0.3, 0.5 * (k as f32 - 3.5), 0.2);
        world.body_mut(link).unwrap().set_velocity(velocity).unwrap();
    }
    // The joints pull the velocities together first.
    world.step(DT);
    let momenta = |world: &World| {
        let (mut linear, mut angular) = (Vec3::ZERO, Vec3::ZERO);
        for (_, body) in world.bodies() {
            linear += body.mass() * body.velocity();
            angular += body.angular_momentum() + body.center().cross(body.mass() * body.velocity());
        }
        (linear, angular)
    };
    let (p, l) = momenta(&world);
    for _ in 0..600 {
        world.step(DT);
    }
    let (p_end, l_end) = momenta(&world);
    assert!((p_end - p).length() < 1e-5 * p.length(), "{p} became {p_end}");
    assert!((l_end - l).length() < 2e-4 * l.length(), "{l} became {l_end}");
}

/// Four bars on hinges with parallel axes: three of the rows say what others say already.
#[test]
fn a_loop_with_redundant_rows_holds() {
    let mut world = world(|_| ());
    let corners = [Vec3::ZERO, Vec3::new(0.0, -2.0, 0.0), Vec3::new(2.0, -2.0, 0.0), Vec3::new(2.0, 0.0, 0.0)];
    let hook = world.add_body(Body::fixed(Shape::ball(0.05)).at(Vec3::new(1.0, 0.0, 1.0))).unwrap();
    let mut last = hook;
    for ends in corners.windows(2) {
        let bar = Body::dynamic(Shape::ball(0.1)).mass(5.0).at(0.5 * (ends[0] + ends[1]));
        let bar = world.add_body(bar).unwrap();
        world.add_joint(Joint::hinge(last, bar, ends[0], Vec3::Z)).unwrap();
        last = bar;
    }
    world.add_joint(Joint::hinge(last, hook, corners[3], Vec3::Z)).unwrap();
    let middle = world.bodies().nth(2).unwrap().0;
    world.body_mut(middle).unwrap().set_velocity(Vec3::X).unwrap();
    // A loop is opened at one joint, which is solved by itself, and softly.
    let gap = gap(&mut world, 10.0);
    assert!(gap < 6e-3, "{gap} m");
    assert!(world.report().max_speed < 3.0, "{} m/s", world.report().max_speed);
}

/// A short chain moves the same, solved at once or joint by joint.
#[test]
fn the_motion_is_the_same() {
    let end = |enabled| {
        let mut world = world(|o| {
            o.solver.joint_tree.enabled = enabled;
            (o.solver.substeps, o.solver.sweeps) = (16, 40);
        });
        let links = add_chain(&mut world, 3, Vec3::X, 2.0, true);
        for _ in 0..60 {
            world.step(DT);
        }
        world.body(links[2]).unwrap().center()
    };
    let (on, off) = (end(true), end(false));
    assert!((on - off).length() < 0.02, "{on} and {off}");
}

/// What hangs from the ground moves to the bit as if nothing else touched the ground.
#[test]
fn the_ground_passes_nothing_on() {
    let end = |beside_a_ball: bool| {
        let mut world = world(|_| ());
        let links = add_chain(&mut world, 5, Vec3::X, 3.0, true);
        if beside_a_ball {
            world.add_body(Body::fixed(Shape::half_space(Vec3::Y)).at(Vec3::Y * -50.0)).unwrap();
            let at = Vec3::new(9.0, -49.8, 0.0);
            // It bounces: the reference solves it together with the chain.
            world.add_body(Body::dynamic(Shape::ball(0.3)).at(at).restitution(0.5)).unwrap();
        }
        let mut touched = false;
        for _ in 0..120 {
            touched |= world.step(DT).contacts > 0;
        }
        assert_eq!(touched, beside_a_ball);
        links.iter().map(|&link| world.body(link).unwrap().pose()).collect::<Vec<_>>()
    };
    assert_eq!(end(false), end(true));
}
