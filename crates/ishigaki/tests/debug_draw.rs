//! What the debug lines show.

use ishigaki::debug_draw::{Color, DebugColors, DebugDraw, DebugDrawOptions};
use ishigaki::{Body, Joint, Shape, Vec3, World, WorldOptions};

#[derive(Default)]
struct Picture {
    lines: Vec<(Vec3, Vec3, Color)>,
    points: Vec<(Vec3, Color)>,
    labels: Vec<(Vec3, String)>,
}

impl DebugDraw for Picture {
    fn line(&mut self, a: Vec3, b: Vec3, color: Color) {
        self.lines.push((a, b, color));
    }

    fn point(&mut self, position: Vec3, _size: f32, color: Color) {
        self.points.push((position, color));
    }

    fn label(&mut self, position: Vec3, text: &str, _color: Color) {
        self.labels.push((position, text.to_string()));
    }
}

fn picture(world: &World, options: &DebugDrawOptions) -> Picture {
    let mut picture = Picture::default();
    world.debug_draw(&mut picture, options);
    picture
}

fn empty() -> World {
    World::new(WorldOptions::default()).unwrap()
}

#[test]
fn wireframes_lie_on_their_shapes() {
    let octahedron: Vec<Vec3> = [Vec3::X, Vec3::Y, Vec3::Z].iter().flat_map(|&v| [v, -v]).collect();
    let cube: Vec<Vec3> = (0..8).map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32)).collect();
    let mesh = Shape::triangle_mesh(vec![Vec3::ZERO, Vec3::X, Vec3::Z], vec![[0, 2, 1]]).unwrap();
    let cases = [
        (Shape::ball(0.5), None),
        (Shape::cuboid(0.5, 1.0, 2.0), Some(12)),
        (Shape::capsule(1.0, 0.5), None),
        (Shape::cylinder(1.0, 0.5), None),
        (Shape::cone(1.0, 0.5), None),
        (Shape::convex_hull(&octahedron).unwrap(), Some(12)),
        (Shape::convex_hull(&cube).unwrap(), Some(12)),
        (Shape::half_space(Vec3::Y), None),
        (mesh, Some(3)),
        (Shape::height_field(3, 4, (0..12).map(|i| 0.1 * i as f32).collect(), 3.0, 2.0).unwrap(), Some(17)),
        (Shape::compound(vec![Shape::cuboid(0.1, 0.1, 0.1), Shape::cuboid(0.1, 0.1, 0.1).at(Vec3::X)]), Some(24)),
    ];
    for (shape, count) in cases {
        let at = Vec3::new(1.0, 2.0, 3.0);
        let mut world = empty();
        let body = world.add_body(Body::fixed(shape.clone()).at(at)).unwrap();
        let lines = picture(&world, &DebugDrawOptions::default()).lines;
        assert!(!lines.is_empty() && count.is_none_or(|count| lines.len() == count), "{shape:?}: {}", lines.len());
        // The end of each line is on the surface: neither outside nor deep inside. (A half-space shows its normal.)
        for (a, b, _) in lines {
            for end in [a, b] {
                let distance = world
                    .shapes_of(body)
                    .map(|(_, shape, pose)| {
                        let parry = shape.geometry.to_parry().unwrap();
                        (parry.project_point(&pose, end, false).point - end).length()
                    })
                    .fold(f32::INFINITY, f32::min);
                let is_normal = matches!(shape.geometry, ishigaki::Geometry::HalfSpace { .. }) && b == at + Vec3::Y;
                assert!(distance < 1e-4 || is_normal, "{shape:?}: {end} is {distance} m off");
            }
        }
    }
}

#[test]
fn colors_tell_the_state() {
    let mut world = empty();
    world.add_body(Body::fixed(Shape::half_space(Vec3::Y))).unwrap();
    world.add_body(Body::kinematic(Shape::ball(0.5)).at(Vec3::X * 5.0 + Vec3::Y * 3.0)).unwrap();
    let brick = world.add_body(Body::dynamic(Shape::cuboid(0.5, 0.5, 0.5)).at(Vec3::Y * 0.5)).unwrap();
    world.add_body(Body::fixed(Shape::ball(0.5).sensor()).at(Vec3::X * -5.0)).unwrap();
    let colors = DebugColors::default();
    let has = |world: &World, color: Color| {
        picture(world, &DebugDrawOptions::default()).lines.iter().any(|(_, _, c)| *c == color)
    };
    world.step(1.0 / 60.0);
    for color in [colors.fixed, colors.kinematic, colors.dynamic, colors.sensor, colors.contact] {
        assert!(has(&world, color), "{color:?}");
    }
    for _ in 0..120 {
        world.step(1.0 / 60.0);
    }
    assert!(world.body(brick).unwrap().is_asleep());
    assert!(has(&world, colors.asleep) && !has(&world, colors.dynamic));
}

#[test]
fn normals_are_as_long_as_the_impulse() {
    let mut world = empty();
    world.add_body(Body::fixed(Shape::half_space(Vec3::Y))).unwrap();
    let brick = Body::dynamic(Shape::cuboid(0.5, 0.5, 0.5)).at(Vec3::Y * 0.5).sleepless();
    world.add_body(brick).unwrap();
    for _ in 0..60 {
        world.step(1.0 / 60.0);
    }
    let options = DebugDrawOptions { shapes: false, impulse_scale: 2.0, ..DebugDrawOptions::default() };
    let picture = picture(&world, &options);
    assert_eq!((picture.lines.len(), picture.points.len()), (4, 4));
    // At rest the impulses carry the weight: Σλ/m = gΔt.
    let sum: Vec3 = picture.lines.iter().map(|(a, b, _)| *b - *a).sum();
    assert!((sum - Vec3::Y * 2.0 * 9.81 / 60.0).abs().max_element() < 1e-3, "{sum}");
    assert!(picture.points.iter().all(|(p, _)| p.y.abs() < 0.02 && (p.x.abs() - 0.5).abs() < 1e-3));
}

#[test]
fn joints_show_their_anchors_and_names() {
    let mut world = empty();
    let wall = world.add_body(Body::fixed(Shape::cuboid(0.1, 1.0, 0.1))).unwrap();
    let door = world.add_body(Body::dynamic(Shape::cuboid(0.5, 1.0, 0.05)).at(Vec3::X * 0.6).named("door")).unwrap();
    let anchor = Vec3::X * 0.1;
    world.add_joint(Joint::hinge(wall, door, anchor, Vec3::Y).named("hinge")).unwrap();
    let options = DebugDrawOptions { shapes: false, ..DebugDrawOptions::all() };
    let picture = picture(&world, &options);
    let near = |p: Vec3| (p - anchor).length() < 1e-6;
    let center = world.body(door).unwrap().center();
    assert!(picture.lines.iter().any(|(a, b, _)| (*a - center).length() < 1e-6 && near(*b)));
    // The joint's x axis is the hinge's.
    let size = options.size;
    assert!(picture.lines.iter().any(|(a, b, _)| near(*a) && (*b - *a - Vec3::Y * size).length() < 1e-5));
    let names: Vec<&str> = picture.labels.iter().map(|(_, name)| name.as_str()).collect();
    assert_eq!(names, ["door", "hinge"]);
}

#[test]
fn options_choose() {
    let mut world = empty();
    let ball = Body::dynamic(Shape::ball(0.5)).at(Vec3::Y * 9.0).velocity(Vec3::X).angular_velocity(Vec3::Z);
    world.add_body(ball).unwrap();
    let none = DebugDrawOptions { shapes: false, contacts: false, joints: false, ..DebugDrawOptions::default() };
    assert!(picture(&world, &none).lines.is_empty());
    let velocity = picture(&world, &DebugDrawOptions { velocities: true, velocity_scale: 0.5, ..none.clone() });
    assert_eq!(velocity.lines, [(Vec3::Y * 9.0, Vec3::new(0.5, 9.0, 0.0), DebugColors::default().velocity)]);
    assert_eq!(picture(&world, &DebugDrawOptions { bounds: true, ..none.clone() }).lines.len(), 12);
    assert_eq!(picture(&world, &DebugDrawOptions { axes: true, ..none.clone() }).lines.len(), 3);
    assert_eq!(picture(&world, &DebugDrawOptions { centers_of_mass: true, ..none }).points.len(), 1);
}
