//! Queries against closed forms and against asking every shape.

use ishigaki::{
    Body, BodyHandle, Geometry, Pose, Quat, QueryFilter, RayHit, Shape, ShapeId, Vec3, World, WorldOptions,
};
use parry3d::query::{self, Ray, ShapeCastOptions};

/// A small generator (xorshift64*), so that the scenes are the same everywhere.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f32 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 40) as f32 / (1_u64 << 24) as f32
    }

    fn vector(&mut self, half: f32) -> Vec3 {
        half * (2.0 * Vec3::new(self.unit(), self.unit(), self.unit()) - 1.0)
    }

    fn pose(&mut self, half: f32) -> Pose {
        let v = self.vector(1.0);
        Pose::from_parts(self.vector(half), Quat::from_xyzw(v.x, v.y, v.z, 0.1 + self.unit()).normalize())
    }

    fn shape(&mut self) -> Shape {
        let mut size = || 0.3 + 0.7 * self.unit();
        let (a, b, c) = (size(), size(), size());
        let shape = match (6.0 * self.unit()) as u32 {
            0 => Shape::ball(a),
            1 => Shape::cuboid(a, b, c),
            2 => Shape::capsule(a, b),
            3 => Shape::cylinder(a, b),
            4 => Shape::cone(a, b),
            _ => {
                let points: Vec<Vec3> = (0..12).map(|_| self.vector(1.0)).collect();
                Shape::convex_hull(&points).unwrap()
            }
        };
        let offset = self.pose(0.5);
        shape.posed(offset)
    }
}

fn empty() -> World {
    World::new(WorldOptions::default()).unwrap()
}

/// A hundred bodies of one or two shapes on a floor.
fn crowd(random: &mut Random) -> World {
    let mut world = empty();
    world.add_body(Body::fixed(Shape::half_space(Vec3::Y)).at(Vec3::NEG_Y * 6.0)).unwrap();
    for i in 0..100 {
        let shape = random.shape();
        let mut body = if i % 3 == 0 { Body::fixed(shape) } else { Body::dynamic(shape) };
        if i % 4 == 0 {
            body = body.with(random.shape());
        }
        world.add_body(body.posed(random.pose(8.0))).unwrap();
    }
    world
}

fn only(shape: Shape) -> (World, BodyHandle) {
    let mut world = empty();
    let body = world.add_body(Body::fixed(shape)).unwrap();
    (world, body)
}

const ALL: QueryFilter<'static> = QueryFilter {
    groups: ishigaki::Groups { member_of: u32::MAX, collides_with: u32::MAX },
    excluded: None,
    sensors: true,
    fixed: true,
    kinematic: true,
    dynamic: true,
    predicate: None,
};

#[test]
fn rays_meet_each_geometry_where_geometry_says() {
    let octahedron: Vec<Vec3> = [Vec3::X, Vec3::Y, Vec3::Z].iter().flat_map(|&v| [v, -v]).map(|v| v * 0.5).collect();
    let vertices = vec![Vec3::new(-5.0, 0.0, -5.0), Vec3::new(5.0, 0.0, -5.0), Vec3::new(0.0, 0.0, 8.0)];
    // The height at which a ray straight down on x = 0.1, z = 0 meets each.
    let cases = [
        (Shape::ball(0.5), (0.25_f32 - 0.01).sqrt(), None),
        (Shape::cuboid(1.0, 0.25, 1.0), 0.25, Some(Vec3::Y)),
        (Shape::capsule(1.0, 0.5), 1.0 + (0.25_f32 - 0.01).sqrt(), None),
        (Shape::cylinder(0.75, 0.5), 0.75, Some(Vec3::Y)),
        (Shape::cone(0.5, 0.5), 0.3, Some(Vec3::new(2.0, 1.0, 0.0).normalize())),
        (Shape::convex_hull(&octahedron).unwrap(), 0.4, None),
        (Shape::half_space(Vec3::Y), 0.0, Some(Vec3::Y)),
        (Shape::triangle_mesh(vertices, vec![[0, 2, 1]]).unwrap(), 0.0, Some(Vec3::Y)),
        (Shape::height_field(3, 3, vec![0.5; 9], 4.0, 4.0).unwrap(), 0.5, Some(Vec3::Y)),
    ];
    for (shape, height, normal) in cases {
        let (world, body) = only(shape.clone());
        // The direction need not be a unit vector; the distance is in m all the same.
        let hit = world.cast_ray(Vec3::new(0.1, 4.0, 0.0), Vec3::NEG_Y * 7.0, 10.0, &QueryFilter::new());
        let hit = hit.unwrap_or_else(|| panic!("{shape:?} was missed"));
        assert_eq!(hit.shape, ShapeId { body, ordinal: 0 });
        assert!((hit.distance - (4.0 - height)).abs() < 1e-5, "{shape:?}: {hit:?}");
        assert!((hit.point - Vec3::new(0.1, height, 0.0)).length() < 1e-5);
        assert!((hit.normal.length() - 1.0).abs() < 1e-5 && hit.normal.y > 0.0);
        if let Some(normal) = normal {
            assert!((hit.normal - normal).length() < 1e-4, "{shape:?}: {}", hit.normal);
        }
        // Just out of reach.
        let short = 4.0 - height - 0.01;
        assert_eq!(world.cast_ray(Vec3::new(0.1, 4.0, 0.0), Vec3::NEG_Y, short, &QueryFilter::new()), None);
    }
}

#[test]
fn rays_that_start_inside_hit_at_once() {
    for shape in [Shape::ball(1.0), Shape::cuboid(1.0, 1.0, 1.0), Shape::half_space(Vec3::Y)] {
        let (world, _) = only(shape.at(Vec3::Y * 0.5));
        let hit = world.cast_ray(Vec3::ZERO, Vec3::X, 10.0, &QueryFilter::new()).unwrap();
        assert_eq!((hit.distance, hit.point, hit.normal), (0.0, Vec3::ZERO, Vec3::NEG_X));
    }
}

#[test]
fn surfaces_are_met_from_both_sides() {
    let vertices = vec![Vec3::new(-5.0, 0.0, -5.0), Vec3::new(5.0, 0.0, -5.0), Vec3::new(0.0, 0.0, 8.0)];
    let (world, _) = only(Shape::triangle_mesh(vertices, vec![[0, 2, 1]]).unwrap());
    let hit = world.cast_ray(Vec3::NEG_Y, Vec3::Y, 10.0, &QueryFilter::new()).unwrap();
    assert_eq!((hit.distance, hit.normal), (1.0, Vec3::NEG_Y));
}

/// Equal but for the rounding of a direction that is made a unit vector once more.
#[track_caller]
fn assert_same(found: Option<(f32, ShapeId)>, expected: Option<(f32, ShapeId)>, tolerance: f32) {
    let same = match (found, expected) {
        (Some(a), Some(b)) => a.1 == b.1 && (a.0 - b.0).abs() <= tolerance * (1.0 + b.0),
        (None, None) => true,
        _ => false,
    };
    assert!(same, "found {found:?}, expected {expected:?}");
}

/// Every shape with its place, through the public interface alone.
fn each(world: &World) -> impl Iterator<Item = (ShapeId, &Shape, Pose)> {
    world.bodies().flat_map(|(handle, _)| world.shapes_of(handle))
}

fn least(hits: impl Iterator<Item = (f32, ShapeId)>) -> Option<(f32, ShapeId)> {
    hits.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
}

#[test]
fn the_nearest_hit_is_the_nearest_of_all_shapes() {
    let mut random = Random(1);
    let world = crowd(&mut random);
    let mut hits = 0;
    for _ in 0..300 {
        let (origin, direction) = (random.vector(12.0), random.vector(1.0).normalize());
        let ray = Ray::new(origin, direction);
        let expected = least(each(&world).filter_map(|(id, shape, pose)| {
            let hit = shape.geometry.to_parry().unwrap().cast_ray(&pose, &ray, 20.0, true)?;
            Some((hit, id))
        }));
        let found = world.cast_ray(origin, direction, 20.0, &ALL);
        assert_same(found.map(|h| (h.distance, h.shape)), expected, 1e-5);
        let mut all: Vec<RayHit> = Vec::new();
        world.cast_ray_all(origin, direction, 20.0, &ALL, |hit| {
            all.push(hit);
            true
        });
        assert_eq!(all.first().copied(), found);
        assert!(all.windows(2).all(|w| w[0].distance <= w[1].distance));
        let count = each(&world)
            .filter(|(_, s, pose)| s.geometry.to_parry().unwrap().cast_ray(pose, &ray, 20.0, true).is_some())
            .count();
        assert_eq!(all.len(), count);
        hits += count;
    }
    assert!(hits > 150, "{hits}");
}

#[test]
fn the_closest_point_is_the_closest_of_all_shapes() {
    let mut random = Random(2);
    let world = crowd(&mut random);
    for _ in 0..300 {
        let point = random.vector(10.0);
        let expected = least(each(&world).filter_map(|(id, shape, pose)| {
            let on_shape = shape.geometry.to_parry().unwrap().project_point(&pose, point, true);
            let distance = if on_shape.is_inside { 0.0 } else { (on_shape.point - point).length() };
            (distance <= 3.0).then_some((distance, id))
        }));
        let found = world.closest_point(point, 3.0, &ALL);
        assert_same(found.map(|h| (h.distance, h.shape)), expected, 1e-5);
        if let Some(hit) = found {
            assert!(((hit.point - point).length() - hit.distance).abs() < 1e-5);
            assert_eq!(hit.inside, hit.distance == 0.0);
        }
        let mut containing = Vec::new();
        world.overlap_point(point, &ALL, |id| {
            containing.push(id);
            true
        });
        let expected: Vec<ShapeId> = each(&world)
            .filter(|(_, shape, pose)| shape.geometry.to_parry().unwrap().contains_point(pose, point))
            .map(|(id, ..)| id)
            .collect();
        assert_eq!(containing, expected);
    }
}

#[test]
fn overlaps_and_casts_of_shapes_are_those_of_all_shapes() {
    let mut random = Random(3);
    let world = crowd(&mut random);
    let mut count = 0;
    for _ in 0..150 {
        let (shape, pose) = (random.shape(), random.pose(9.0));
        let parry = shape.geometry.to_parry().unwrap();
        let mut found = Vec::new();
        world.overlap(&shape.geometry, &pose, &ALL, |id| {
            found.push(id);
            true
        });
        let expected: Vec<ShapeId> = each(&world)
            .filter(|(_, other, at)| {
                query::intersection_test(at, &*other.geometry.to_parry().unwrap().0, &pose, &*parry.0)
                    .unwrap()
                    .intersecting
            })
            .map(|(id, ..)| id)
            .collect();
        assert_eq!(found, expected);
        count += found.len();

        let direction = random.vector(1.0).normalize();
        let options = ShapeCastOptions::with_max_time_of_impact(15.0);
        let expected = least(each(&world).filter_map(|(id, other, at)| {
            let other = other.geometry.to_parry().unwrap();
            let hit = query::cast_shapes(&at, Vec3::ZERO, &*other.0, &pose, direction, &*parry.0, options);
            Some((hit.unwrap()?.time_of_impact, id))
        }));
        let found = world.cast_shape(&shape.geometry, &pose, direction, 15.0, &ALL);
        // parry advances until the gap is small: that gap is the difference.
        assert_same(found.map(|h| (h.distance, h.shape)), expected, 1e-4);
        if let Some(found) = found {
            assert!((found.normal.length() - 1.0).abs() < 1e-5 && found.normal.dot(direction) <= 0.0);
        }
    }
    assert!(count > 60, "{count}");
}

#[test]
fn a_moving_ball_stops_at_its_radius() {
    let mut world = empty();
    let floor = world.add_body(Body::fixed(Shape::half_space(Vec3::Y))).unwrap();
    let wall = world.add_body(Body::fixed(Shape::cuboid(0.5, 5.0, 5.0)).at(Vec3::X * 4.0)).unwrap();
    let ball = Geometry::Ball { radius: 0.25 };
    let filter = QueryFilter::new();
    let from = Pose::from_translation(Vec3::Y * 3.0);
    let down = world.cast_shape(&ball, &from, Vec3::NEG_Y * 3.0, 10.0, &filter).unwrap();
    assert_eq!(down.shape.body, floor);
    assert!((down.distance - 2.75).abs() < 1e-4 && down.point.length() < 1e-3);
    assert!((down.normal - Vec3::Y).length() < 1e-4);
    let across = world.cast_shape(&ball, &from, Vec3::X, 10.0, &filter).unwrap();
    assert_eq!(across.shape.body, wall);
    assert!((across.distance - 3.25).abs() < 1e-4);
    assert!((across.normal - Vec3::NEG_X).length() < 1e-4);
    assert_eq!(world.cast_shape(&ball, &from, Vec3::X, 3.0, &filter), None);
    assert_eq!(world.cast_shape(&ball, &from, Vec3::NEG_X, 100.0, &filter), None);
    // Two balls as one moving compound: the lower one leads.
    let pair = Geometry::Compound(vec![Shape::ball(0.25), Shape::ball(0.25).at(Vec3::NEG_Y)]);
    let down = world.cast_shape(&pair, &from, Vec3::NEG_Y, 10.0, &filter).unwrap();
    assert!((down.distance - 1.75).abs() < 1e-4);
    // Overlapping from the start.
    let inside = world.cast_shape(&ball, &Pose::from_translation(Vec3::X * 4.0), Vec3::NEG_X, 10.0, &filter);
    assert_eq!(inside.unwrap().distance, 0.0);
}

#[test]
fn ties_go_to_the_least_id_whatever_the_tree() {
    let mut random = Random(4);
    let mut world = empty();
    let handles: Vec<BodyHandle> =
        (0..30).map(|_| world.add_body(Body::fixed(Shape::ball(1.0)).at(Vec3::Z * 5.0)).unwrap()).collect();
    let ask = |world: &World| {
        let mut order = Vec::new();
        world.cast_ray_all(Vec3::ZERO, Vec3::Z, 10.0, &QueryFilter::new(), |hit| {
            order.push(hit.shape.body);
            true
        });
        assert_eq!(order, handles);
        assert_eq!(world.cast_ray(Vec3::ZERO, Vec3::Z, 10.0, &QueryFilter::new()).unwrap().shape.body, handles[0]);
        assert_eq!(world.closest_point(Vec3::ZERO, 10.0, &QueryFilter::new()).unwrap().shape.body, handles[0]);
        let ball = Geometry::Ball { radius: 0.5 };
        let cast = world.cast_shape(&ball, &Pose::IDENTITY, Vec3::Z, 10.0, &QueryFilter::new());
        assert_eq!(cast.unwrap().shape.body, handles[0]);
    };
    ask(&world);
    // Other bodies that come and go give the tree other forms.
    for _ in 0..5 {
        let others: Vec<BodyHandle> =
            (0..20).map(|_| world.add_body(Body::fixed(Shape::ball(0.1)).at(random.vector(3.0))).unwrap()).collect();
        others.into_iter().for_each(|other| assert!(world.remove_body(other)));
        ask(&world);
    }
    // A restored world has a tree built at once.
    ask(&World::restore(&world.snapshot()).unwrap());
}

#[test]
fn filters_choose() {
    let mut world = empty();
    let at = |z: f32| Vec3::Z * z;
    let sensor = world.add_body(Body::fixed(Shape::ball(0.5).sensor()).at(at(1.0))).unwrap();
    let fixed = world.add_body(Body::fixed(Shape::ball(0.5)).at(at(3.0))).unwrap();
    let kinematic = world.add_body(Body::kinematic(Shape::ball(0.5)).at(at(5.0))).unwrap();
    let grouped = world.add_body(Body::dynamic(Shape::ball(0.5).groups(2, 4)).at(at(7.0))).unwrap();
    let dynamic = world.add_body(Body::dynamic(Shape::ball(0.5)).at(at(9.0))).unwrap();
    let first = |filter: &QueryFilter| world.cast_ray(Vec3::ZERO, Vec3::Z, 20.0, filter).unwrap().shape.body;
    assert_eq!(first(&QueryFilter::new()), fixed);
    assert_eq!(first(&QueryFilter::new().with_sensors()), sensor);
    assert_eq!(first(&QueryFilter::new().excluding(fixed)), kinematic);
    assert_eq!(first(&QueryFilter::new().only_dynamic()), grouped);
    assert_eq!(first(&QueryFilter { fixed: false, ..QueryFilter::new() }), kinematic);
    assert_eq!(first(&QueryFilter::new().groups(4, 2)), grouped);
    assert_eq!(first(&QueryFilter::new().only_dynamic().groups(1, u32::MAX)), dynamic, "seen only by group 4");
    assert_eq!(first(&QueryFilter::new().only_fixed()), fixed);
    let far = |id: ShapeId, _: &Shape| world.body(id.body).is_some_and(|b| b.position().z > 8.0);
    assert_eq!(first(&QueryFilter::new().predicate(&far)), dynamic);
}

#[test]
fn lists_stop_when_told() {
    let mut random = Random(6);
    let world = crowd(&mut random);
    let big = Geometry::Ball { radius: 6.0 };
    let mut seen = 0;
    world.overlap(&big, &Pose::IDENTITY, &ALL, |_| {
        seen += 1;
        seen < 3
    });
    assert_eq!(seen, 3);
}

#[test]
fn questions_without_sense_find_nothing() {
    let (world, _) = only(Shape::ball(1.0));
    let filter = QueryFilter::new();
    let nan = Vec3::new(f32::NAN, 0.0, 0.0);
    let far = Vec3::Z * 5.0;
    assert!(world.cast_ray(far, Vec3::NEG_Z, f32::INFINITY, &filter).is_some(), "no limit is fine");
    assert_eq!(world.cast_ray(nan, Vec3::NEG_Z, 10.0, &filter), None);
    assert_eq!(world.cast_ray(far, nan, 10.0, &filter), None);
    assert_eq!(world.cast_ray(far, Vec3::ZERO, 10.0, &filter), None);
    assert_eq!(world.cast_ray(far, Vec3::NEG_Z * f32::INFINITY, 10.0, &filter), None);
    assert_eq!(world.cast_ray(far, Vec3::NEG_Z, f32::NAN, &filter), None);
    assert_eq!(world.cast_ray(far, Vec3::NEG_Z, -1.0, &filter), None);
    assert_eq!(world.closest_point(nan, 10.0, &filter), None);
    assert_eq!(world.closest_point(far, f32::NAN, &filter), None);
    assert_eq!(world.closest_point(far, -1.0, &filter), None);
    let ball = Geometry::Ball { radius: f32::NAN };
    assert_eq!(world.cast_shape(&ball, &Pose::IDENTITY, Vec3::X, 1.0, &filter), None);
    let ball = Geometry::Ball { radius: 1.0 };
    assert_eq!(world.cast_shape(&ball, &Pose::from_translation(nan), Vec3::X, 1.0, &filter), None);
    let not_unit = Pose::from_parts(Vec3::ZERO, Quat::from_xyzw(0.0, 0.0, 0.0, 0.0));
    let mut found = false;
    world.overlap(&ball, &not_unit, &filter, |_| {
        found = true;
        true
    });
    world.overlap_point(nan, &filter, |_| {
        found = true;
        true
    });
    assert!(!found);
}

#[test]
fn queries_see_edits_and_steps_at_once() {
    let mut world = World::new(WorldOptions { gravity: Vec3::ZERO, ..WorldOptions::default() }).unwrap();
    let ball = world.add_body(Body::dynamic(Shape::ball(0.5)).velocity(Vec3::X * 60.0)).unwrap();
    let above = |x: f32| Vec3::new(x, 5.0, 0.0);
    let hits = |world: &World, x: f32| world.cast_ray(above(x), Vec3::NEG_Y, 10.0, &QueryFilter::new()).is_some();
    assert!(hits(&world, 0.0));
    for step in 1..=10 {
        world.step(1.0 / 60.0);
        assert!(hits(&world, step as f32) && !hits(&world, step as f32 - 1.0), "step {step}");
    }
    world.body_mut(ball).unwrap().set_pose(Pose::from_translation(Vec3::X * -20.0)).unwrap();
    assert!(hits(&world, -20.0) && !hits(&world, 10.0));
    // Against a wall the step ends where no prediction from its start could tell.
    world.add_body(Body::fixed(Shape::cuboid(0.5, 5.0, 5.0)).restitution(1.0).at(Vec3::X * -17.0)).unwrap();
    for _ in 0..10 {
        world.step(1.0 / 60.0);
        let x = world.body(ball).unwrap().position().x;
        let only_dynamic = QueryFilter::new().only_dynamic();
        assert!(world.cast_ray(Vec3::new(x, 5.0, 0.0), Vec3::NEG_Y, 10.0, &only_dynamic).is_some(), "at {x}");
    }
}
