//! D5: heights are hops over contacts from the ground.

use crate::support::*;
use ishigaki::*;

fn heights(world: &World, bodies: &[BodyHandle]) -> Vec<Option<u32>> {
    bodies.iter().map(|&b| body(world, b).height()).collect()
}

#[test]
fn rows_of_a_pyramid_are_levels() {
    let mut world = world(plain(|_| {}));
    let ground = add_ground(&mut world);
    for row in 0..4 {
        let cubes = 4 - row;
        let place = |i| Vec3::new(i as f32 - 0.5 * (cubes - 1) as f32, row as f32 + 0.5, 0.0);
        let boxes: Vec<_> = (0..cubes).map(|i| world.add_body(cube(place(i))).unwrap()).collect();
        world.step(DT);
        assert_eq!(heights(&world, &boxes), vec![Some(row as u32 + 1); cubes], "row {row}");
    }
    assert_eq!(body(&world, ground).height(), Some(0));
}

#[test]
fn a_body_in_the_air_has_none() {
    let mut world = world(plain(|_| {}));
    add_ground(&mut world);
    let ball = world.add_body(Body::dynamic(Shape::ball(0.5)).at(Vec3::Y * 1.0)).unwrap();
    world.step(DT);
    assert_eq!(body(&world, ball).height(), None);
    run(&mut world, 60);
    assert_eq!(body(&world, ball).height(), Some(1));
}

#[test]
fn a_kinematic_body_is_ground_too() {
    let mut world = world(plain(|_| {}));
    let lift = world.add_body(Body::kinematic(Shape::cuboid(1.0, 0.5, 1.0)).at(-0.5 * Vec3::Y)).unwrap();
    let load = world.add_body(cube(0.5 * Vec3::Y)).unwrap();
    world.step(DT);
    assert_eq!(heights(&world, &[lift, load]), [Some(0), Some(1)]);
}

#[test]
fn joints_are_hops_only_if_asked() {
    for through_joints in [false, true] {
        let mut world = world(plain(|s| s.height = Height { through_joints }));
        let hook = world.add_body(Body::fixed(Shape::ball(0.1))).unwrap();
        let bobs = [1.0, 2.0].map(|y| world.add_body(Body::dynamic(Shape::ball(0.1)).at(-y * Vec3::Y)).unwrap());
        world.add_joint(Joint::ball(hook, bobs[0], Vec3::ZERO)).unwrap();
        world.add_joint(Joint::ball(bobs[0], bobs[1], -Vec3::Y)).unwrap();
        world.step(DT);
        let expected = if through_joints { [Some(1), Some(2)] } else { [None, None] };
        assert_eq!(heights(&world, &bobs), expected);
    }
}

#[test]
fn a_plank_on_two_towers_puts_a_supporter_above_its_load() {
    // Known pathology: three bricks carry one end of a plank, six the other, and hops go over the plank too.
    let mut world = world(plain(|_| {}));
    add_ground(&mut world);
    let mut tower = |x: f32, bricks: usize| -> Vec<BodyHandle> {
        let brick = 3.0 / bricks as f32;
        let body =
            |k| Body::dynamic(Shape::cuboid(0.5, 0.5 * brick, 0.5)).at(Vec3::new(x, (k as f32 + 0.5) * brick, 0.0));
        (0..bricks).map(|k| world.add_body(body(k)).unwrap()).collect()
    };
    let (short, tall) = (tower(-2.0, 3), tower(2.0, 6));
    let plank = world.add_body(Body::dynamic(Shape::cuboid(3.0, 0.25, 0.5)).at(3.25 * Vec3::Y)).unwrap();
    world.step(DT);
    assert_eq!(heights(&world, &short), [Some(1), Some(2), Some(3)]);
    assert_eq!(heights(&world, &tall), [1, 2, 3, 4, 5, 5].map(Some));
    assert_eq!(body(&world, plank).height(), Some(4), "below the brick that carries it");
}
