//! What makes no sense is refused, with the place and the reason; what is merely huge never panics.
use ishigaki::*;

const DT: f32 = 1.0 / 60.0;
const NAN: f32 = f32::NAN;
const INF: f32 = f32::INFINITY;

fn ball() -> Body {
    Body::dynamic(Shape::ball(0.5))
}

/// The message with which a body is refused.
fn refused(body: Body) -> String {
    let mut world = World::default();
    let error = world.add_body(body).expect_err("makes no sense").to_string();
    assert_eq!(world.bodies().count(), 0);
    error
}

#[test]
fn bad_bodies_are_refused() {
    let hollow = MassProperties { mass: 1.0, principal_inertia: Vec3::new(1.0, 1.0, 3.0), ..MassProperties::ZERO };
    let weightless = MassProperties { mass: 0.0, principal_inertia: Vec3::ONE, ..MassProperties::ZERO };
    let flat = MassProperties { mass: 1.0, principal_inertia: Vec3::new(1.0, 1.0, 0.0), ..MassProperties::ZERO };
    let needs_mass = "mass: a dynamic body needs mass and inertia: give it a solid shape with density > 0, or explicit mass properties (mass: must be finite and > 0, is 0)";
    let cases: Vec<(Body, &str)> = vec![
        (ball().at(Vec3::new(0.0, NAN, 0.0)), "position: must be finite, is (0, NaN, 0)"),
        (ball().at(Vec3::X * INF), "position: must be finite, is (inf, NaN, NaN)"),
        (ball().at(Vec3::Y * 2e6), "position: must be within 1000000 m of the origin"),
        (ball().rotated(Quat::from_xyzw(0.0, 0.0, 0.0, 2.0)), "rotation: must be a unit quaternion, has length 2"),
        (ball().rotated(Quat::from_xyzw(0.0, 0.0, 0.0, 0.0)), "rotation: must be a unit quaternion, has length 0"),
        (ball().rotated(Quat::from_xyzw(NAN, 0.0, 0.0, 1.0)), "rotation: must be a unit quaternion, has length NaN"),
        (ball().velocity(Vec3::new(INF, 0.0, 0.0)), "velocity: must be finite, is (inf, 0, 0)"),
        (ball().angular_velocity(Vec3::new(0.0, 0.0, NAN)), "angular_velocity: must be finite, is (0, 0, NaN)"),
        (ball().gravity_scale(NAN), "gravity_scale: must be finite, is NaN"),
        (ball().damping(-1.0, 0.0), "linear_damping: must be finite and ≥ 0, is -1"),
        (ball().damping(0.0, INF), "angular_damping: must be finite and ≥ 0, is inf"),
        (ball().mass(0.0), "mass: must be finite and > 0, is 0"),
        (ball().mass(-3.0), "mass: must be finite and > 0, is -3"),
        (ball().mass(1e-39), "mass: too small to be inverted: 0.000000000000000000000000000000000000001 kg"),
        (ball().density(0.0), needs_mass),
        (Body::empty(BodyKind::Dynamic), needs_mass),
        (Body::dynamic(Shape::ball(0.5).sensor()), needs_mass),
        (ball().mass_properties(weightless), "mass_properties.mass: must be finite and > 0, is 0"),
        (ball().mass_properties(flat), "mass_properties.principal_inertia[2]: must be finite and > 0, is 0"),
        (
            ball().mass_properties(hollow),
            "mass_properties.principal_inertia: no body has the moments (1, 1, 3): one is greater than the sum of the others",
        ),
        (
            Body::dynamic(Shape::half_space(Vec3::Y)),
            "shapes[0]: a half-space, triangle mesh or height field has no volume and cannot be dynamic: use a fixed or kinematic body, or convex hulls",
        ),
        (
            ball().with(Shape::triangle_mesh(vec![Vec3::ZERO, Vec3::X, Vec3::Z], vec![[0, 2, 1]]).unwrap()),
            "shapes[1]: a half-space, triangle mesh or height field has no volume and cannot be dynamic: use a fixed or kinematic body, or convex hulls",
        ),
    ];
    for (body, message) in cases {
        assert_eq!(refused(body), message);
    }
}

#[test]
fn bad_shapes_are_refused() {
    let two_cubes = |bad: Shape| Shape::compound(vec![Shape::cuboid(1.0, 1.0, 1.0), bad]);
    let belt = Material { surface_velocity: Vec3::new(0.0, INF, 0.0), ..Material::default() };
    let rolling = Material { rolling_friction: -1.0, ..Material::default() };
    let cases: Vec<(Shape, &str)> = vec![
        (Shape::ball(0.0), "radius: must be finite and > 0, is 0"),
        (Shape::ball(-1.0), "radius: must be finite and > 0, is -1"),
        (Shape::ball(1e7), "radius: must be at most 1000000 m, is 10000000"),
        (Shape::cuboid(1.0, NAN, 1.0), "half_extents[1]: must be finite and > 0, is NaN"),
        (Shape::capsule(-0.1, 0.5), "half_length: must be in [0, 1000000] m, is -0.1"),
        (Shape::capsule(NAN, 0.5), "half_length: must be finite, is NaN"),
        (Shape::cylinder(0.0, 0.5), "half_height: must be finite and > 0, is 0"),
        (Shape::cone(0.5, INF), "radius: must be finite and > 0, is inf"),
        (Shape::half_space(Vec3::ZERO), "normal: must not be zero: it is a direction"),
        (Shape::half_space(Vec3::Y * 2.0), "normal: must be a unit vector, has length 2"),
        (Shape::compound(vec![]), "shapes: a compound needs at least one shape"),
        (two_cubes(Shape::ball(NAN)), "shapes[1].radius: must be finite and > 0, is NaN"),
        (Shape::ball(1.0).density(-1.0), "density: must be finite and ≥ 0, is -1"),
        (Shape::ball(1.0).friction(-0.5), "friction: must be finite and ≥ 0, is -0.5"),
        (Shape::ball(1.0).restitution(1.5), "restitution: must be in [0, 1], is 1.5"),
        (Shape::ball(1.0).restitution(NAN), "restitution: must be in [0, 1], is NaN"),
        (Shape::ball(1.0).material(rolling), "rolling_friction: must be finite and ≥ 0, is -1"),
        (Shape::ball(1.0).material(belt), "surface_velocity: must be finite, is (0, inf, 0)"),
        (Shape::ball(1.0).at(Vec3::new(NAN, 0.0, 0.0)), "position: must be finite and within 1000000 m of the origin"),
    ];
    for (shape, message) in cases {
        assert_eq!(refused(Body::fixed(shape)), format!("shapes[0].{message}"));
    }
}

#[test]
fn bad_geometry_is_refused_where_it_is_made() {
    let plane: Vec<Vec3> = (0..9).map(|i| Vec3::new((i % 3) as f32, (i / 3) as f32, 0.0)).collect();
    let flat = "points: must span a volume: they lie in one plane or on one line";
    let hull = |points: &[Vec3]| Shape::convex_hull(points).unwrap_err().to_string();
    assert_eq!(hull(&[]), "points: a hull needs at least 4 points, has 0");
    assert_eq!(
        hull(&[Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z * NAN]),
        "points[3]: must be finite and within 1000000 m of the origin"
    );
    assert_eq!(hull(&plane), flat);
    assert_eq!(hull(&[Vec3::ONE; 6]), flat);
    assert_eq!(hull(&[Vec3::ZERO, Vec3::X, Vec3::X * 2.0, Vec3::X * 3.0]), flat);
    let mesh = |v: Vec<Vec3>, t: Vec<[u32; 3]>| Shape::triangle_mesh(v, t).unwrap_err().to_string();
    assert_eq!(mesh(vec![], vec![]), "triangles: a mesh needs at least one triangle");
    let corners = || vec![Vec3::ZERO, Vec3::X, Vec3::Z];
    assert_eq!(mesh(corners(), vec![[0, 1, 3]]), "triangles[0]: vertex 3 does not exist: there are 3");
    assert_eq!(
        mesh(vec![Vec3::ZERO, Vec3::X, Vec3::Z * INF], vec![[0, 1, 2]]),
        "vertices[2]: must be finite and within 1000000 m of the origin"
    );
    let field = |r, c, h: Vec<f32>, x, z| Shape::height_field(r, c, h, x, z).unwrap_err().to_string();
    assert_eq!(field(1, 2, vec![0.0; 2], 1.0, 1.0), "heights: needs at least 2 rows and 2 columns, has 1 and 2");
    assert_eq!(field(2, 2, vec![0.0; 5], 1.0, 1.0), "heights: 2 rows × 2 columns do not match 5 heights");
    assert_eq!(
        field(2, 2, vec![0.0, NAN, 0.0, 0.0], 1.0, 1.0),
        "heights[1]: must be finite and within 1000000 m of the origin"
    );
    assert_eq!(field(2, 2, vec![0.0; 4], -1.0, 1.0), "size_x: must be finite and > 0, is -1");
}

#[test]
fn bad_joints_are_refused() {
    let mut world = World::default();
    let (a, b) = (world.add_body(ball()).unwrap(), world.add_body(ball().at(Vec3::X * 2.0)).unwrap());
    let gone = world.add_body(ball().at(Vec3::X * 4.0)).unwrap();
    world.remove_body(gone);
    let hinge = || Joint::hinge(a, b, Vec3::X, Vec3::Y);
    let turn = |axis| TurnAxis { axis, drive: Drive::default() };
    let generic = |axes: Vec<TurnAxis>| Joint::generic(a, b, Pose::IDENTITY, [Freedom::Locked; 3], axes);
    let zero_axis = "frame.rotation: must be a unit quaternion, has length 0 (is the axis zero or not finite?)";
    let cases: Vec<(Joint, &str)> = vec![
        (Joint::ball(a, a, Vec3::ZERO), "body_b: must differ from body_a: a body cannot be joined to itself"),
        (Joint::ball(a, gone, Vec3::ZERO), "body_b: no such object: the handle is stale or of another world"),
        (Joint::ball(gone, b, Vec3::ZERO), "body_a: no such object: the handle is stale or of another world"),
        (Joint::ball(a, b, Vec3::new(0.0, 0.0, NAN)), "frame.position: must be finite, is (0, 0, NaN)"),
        (Joint::hinge(a, b, Vec3::ZERO, Vec3::ZERO), zero_axis),
        (Joint::slider(a, b, Vec3::ZERO, Vec3::splat(NAN)), zero_axis),
        (hinge().limit(1.0..=-1.0), "drive.limit: ends are exchanged: lower 1 > upper -1"),
        (hinge().limit(NAN..=1.0), "drive.limit: must not be NaN"),
        (hinge().motor(INF, 1.0), "drive.motor.speed: must be finite, is inf"),
        (hinge().motor(1.0, -1.0), "drive.motor.max_effort: must be ≥ 0, is -1"),
        (hinge().spring(NAN, 1.0, 1.0), "drive.spring.target: must be finite, is NaN"),
        (hinge().spring(0.0, -1.0, 1.0), "drive.spring.stiffness: must be finite and ≥ 0, is -1"),
        (hinge().dry_friction(-1.0), "drive.friction: must be finite and ≥ 0, is -1"),
        (hinge().breaking(0.0, 1.0), "break_force: must be > 0, is 0"),
        (hinge().breaking(1.0, NAN), "break_torque: must be > 0, is NaN"),
        (Joint::ball(a, b, Vec3::X).cone(4.0), "cone: must be in [0, π] rad, is 4"),
        (Joint::rope(a, b, Vec3::ZERO, Vec3::ZERO, -1.0), "range: ends are exchanged: lower 0 > upper -1"),
        (Joint::distance(a, b, Vec3::ZERO, Vec3::ZERO, -2.0..=-1.0), "range: a distance is ≥ 0, lower is -2"),
        (generic(vec![turn(Vec3::X); 4]), "angular: at most 3 axes, has 4"),
        (generic(vec![turn(Vec3::ZERO)]), "angular[0].axis: must not be zero: it is a direction"),
        (
            generic(vec![turn(Vec3::X), turn(Vec3::X)]),
            "angular: the axes must be independent: two are parallel or three in one plane",
        ),
    ];
    for (joint, message) in cases {
        assert_eq!(world.add_joint(joint).expect_err(message).to_string(), message);
    }
    assert_eq!(world.joints().count(), 0);
    let joint = world.add_joint(hinge()).unwrap();
    let edit = world.edit_joint(joint, |j| j.kind = JointKind::Fixed).unwrap_err();
    assert_eq!(edit.to_string(), "kind: cannot change: remove the joint and add another");
    let edit = world.edit_joint(joint, |j| *j = j.clone().limit(2.0..=1.0)).unwrap_err();
    assert_eq!(edit.to_string(), "drive.limit: ends are exchanged: lower 2 > upper 1");
    let JointKind::Hinge { drive } = &world.joint(joint).unwrap().definition().kind else { panic!() };
    assert_eq!(drive.limit, None, "the old definition stays");
}

#[test]
fn bad_edits_are_refused() {
    let mut world = World::default();
    let ball = world.add_body(ball()).unwrap();
    let pair = world.exclude_pair(ball, ball).unwrap_err();
    assert_eq!(pair.to_string(), "body_b: must differ from body_a: it is no pair");
    let before = world.state_hash();
    let nan = Vec3::new(NAN, 0.0, 0.0);
    let mut edit = world.body_mut(ball).unwrap();
    let turned = Pose::from_parts(Vec3::ZERO, Quat::from_xyzw(1.0, 1.0, 0.0, 0.0));
    let results: Vec<(Result<()>, &str)> = vec![
        (edit.set_pose(Pose::from_translation(nan)), "pose.position: must be finite, is (NaN, 0, 0)"),
        (edit.set_pose(Pose::from_translation(Vec3::X * 1e7)), "pose.position: must be within 1000000 m of the origin"),
        (edit.set_pose(turned), "pose.rotation: must be a unit quaternion, has length 1.4142135"),
        (edit.set_velocity(nan), "velocity: must be finite, is (NaN, 0, 0)"),
        (edit.set_angular_velocity(nan), "angular_velocity: must be finite, is (NaN, 0, 0)"),
        (edit.apply_force(nan), "force: must be finite, is (NaN, 0, 0)"),
        (edit.apply_force_at(Vec3::X, nan), "point: must be finite, is (NaN, 0, 0)"),
        (edit.apply_force_at(Vec3::splat(1e38), Vec3::Y * 1e38), "torque: must be finite, is (inf, 0, -inf)"),
        (
            edit.apply_impulse_at(Vec3::splat(1e38), Vec3::Y * 1e38),
            "angular_impulse: must be finite, is (inf, 0, -inf)",
        ),
        (edit.apply_torque(nan), "torque: must be finite, is (NaN, 0, 0)"),
        (edit.apply_impulse(nan), "impulse: must be finite, is (NaN, 0, 0)"),
        (edit.apply_impulse_at(nan, Vec3::X), "impulse: must be finite, is (NaN, 0, 0)"),
        (edit.set_gravity_scale(INF), "gravity_scale: must be finite, is inf"),
        (edit.set_damping(NAN, 0.0), "linear_damping: must be finite and ≥ 0, is NaN"),
        (
            edit.set_material(0, Material { friction: NAN, ..Material::default() }).map(|_| ()),
            "friction: must be finite and ≥ 0, is NaN",
        ),
    ];
    for (result, message) in results {
        assert_eq!(result.expect_err(message).to_string(), message);
    }
    assert!(!edit.set_material(7, Material::default()).unwrap(), "there is no such shape");
    assert_eq!(world.state_hash(), before);
}

#[test]
fn bad_options_are_refused_and_the_old_ones_stay() {
    type Edit = fn(&mut WorldOptions);
    let cases: [(Edit, &str); 14] = [
        (|o| o.gravity.y = NAN, "gravity: must be finite, is (0, NaN, 0)"),
        (|o| o.length_scale = 0.0, "length_scale: must be finite and > 0, is 0"),
        (|o| o.motion.max_speed = INF, "motion.max_speed: must be finite and > 0, is inf"),
        (|o| o.contact.speculative_margin = -1.0, "contact.speculative_margin: must be finite and ≥ 0, is -1"),
        (|o| o.solver.substeps = 0, "solver.substeps: must be in [1, 1000], is 0"),
        (|o| o.solver.sweeps = u32::MAX, "solver.sweeps: must be in [0, 100000], is 4294967295"),
        (|o| o.solver.penetration_recovery.rate = 1.5, "solver.penetration_recovery.rate: must be in [0, 1], is 1.5"),
        (|o| o.solver.warm_start.factor = NAN, "solver.warm_start.factor: must be in [0, 1], is NaN"),
        (|o| o.solver.slop.depth = -0.1, "solver.slop.depth: must be finite and ≥ 0, is -0.1"),
        (
            |o| o.solver.over_relaxation.factor = 2.0,
            "solver.over_relaxation.factor: must be ≥ 1 and < 2 (from 2 on sweeps diverge), is 2",
        ),
        (
            |o| o.solver.over_relaxation.factor = f32::NAN,
            "solver.over_relaxation.factor: must be ≥ 1 and < 2 (from 2 on sweeps diverge), is NaN",
        ),
        (
            |o| o.solver.weight_amplification.factor = 0.5,
            "solver.weight_amplification.factor: must be finite and ≥ 1 (the lower body counts as heavier), is 0.5",
        ),
        (|o| o.rest.sleep.time = NAN, "rest.sleep.time: must be finite and ≥ 0, is NaN"),
        (
            |o| o.rest.aggressive_sleep.thaw_angle = -1.0,
            "rest.aggressive_sleep.thaw_angle: must be finite and ≥ 0, is -1",
        ),
    ];
    for (edit, message) in cases {
        let mut options = WorldOptions::default();
        edit(&mut options);
        assert_eq!(World::new(options.clone()).expect_err(message).to_string(), message);
        let mut world = World::default();
        assert_eq!(world.set_options(options).expect_err(message).to_string(), message);
        assert_eq!(*world.options(), WorldOptions::default());
    }
}

#[test]
fn a_step_that_is_none_does_nothing_and_says_so() {
    let mut world = World::default();
    world.add_body(ball().velocity(Vec3::X)).unwrap();
    let before = world.state_hash();
    for (dt, shown) in
        [(NAN, "NaN"), (0.0, "0e0"), (-0.01, "-1e-2"), (INF, "inf"), (-INF, "-inf"), (1e30, "1e30"), (1e-30, "1e-30")]
    {
        let report = world.step(dt);
        assert_eq!(report.rejected, Some(format!("the step must be in [1e-9, 1e6] s, is {shown}")));
        assert_eq!((world.state_hash(), world.step_count(), world.time()), (before, 0, 0.0));
    }
    assert_eq!(world.step(DT).rejected, None);
    assert_eq!(world.step(1e6).rejected, None);
    assert_eq!(world.step(1e-9).rejected, None);
}

/// A stack, a chain and an onlooker far away.
fn busy() -> (World, Vec<BodyHandle>, BodyHandle) {
    let mut world = World::default();
    world.add_body(Body::fixed(Shape::half_space(Vec3::Y))).unwrap();
    let cube = |i: usize| Body::dynamic(Shape::cuboid(0.25, 0.25, 0.25)).at(Vec3::new(0.0, 0.25 + 0.5 * i as f32, 0.0));
    let mut bodies: Vec<_> = (0..3).map(|i| world.add_body(cube(i)).unwrap()).collect();
    let light = Body::dynamic(Shape::ball(0.01).density(1.0)).at(Vec3::new(0.0, 2.0, 0.0));
    bodies.push(world.add_body(light).unwrap());
    world.add_joint(Joint::ball(bodies[2], bodies[3], Vec3::Y * 2.0)).unwrap();
    let far = world.add_body(Body::dynamic(Shape::ball(0.5)).at(Vec3::new(100.0, 50.0, 0.0))).unwrap();
    (world, bodies, far)
}

#[test]
fn huge_but_valid_input_never_panics_and_the_others_go_on() {
    type Abuse = fn(&mut BodyMut);
    let abuses: [(&str, Abuse); 10] = [
        ("force", |b| b.apply_force(Vec3::splat(1e38)).unwrap()),
        ("force twice", |b| (0..9).for_each(|_| b.apply_force(Vec3::splat(3e38)).unwrap())),
        ("torque", |b| b.apply_torque(Vec3::splat(1e38)).unwrap()),
        ("force far off", |b| b.apply_force_at(Vec3::X * 1e32, Vec3::Y * 1e6).unwrap()),
        ("impulse", |b| b.apply_impulse(Vec3::splat(1e38)).unwrap()),
        ("angular impulse", |b| b.apply_angular_impulse(Vec3::splat(-1e38)).unwrap()),
        ("impulse far off", |b| b.apply_impulse_at(Vec3::X * 1e32, Vec3::Y * 1e6).unwrap()),
        ("velocity", |b| b.set_velocity(Vec3::splat(1e38)).unwrap()),
        ("angular velocity", |b| b.set_angular_velocity(Vec3::splat(1e38)).unwrap()),
        ("pose", |b| b.set_pose(Pose::from_translation(Vec3::splat(1e6))).unwrap()),
    ];
    for (name, abuse) in abuses {
        for victim in 0..4 {
            let (mut world, bodies, far) = busy();
            world.step(DT);
            abuse(&mut world.body_mut(bodies[victim]).unwrap());
            let mut broken = Vec::new();
            for _ in 0..10 {
                let report = world.step(DT);
                broken.extend(report.non_finite);
            }
            // Who is broken is named, and nobody else is.
            assert!(broken.iter().all(|&b| b == bodies[victim]), "{name} on body {victim}: {broken:?}");
            for (handle, body) in world.bodies() {
                let finite = body.center().is_finite() && body.velocity().is_finite() && body.rotation().is_finite();
                assert!(finite || handle == bodies[victim], "{name} on body {victim} broke {handle:?}");
            }
            let fallen = world.body(far).unwrap().velocity().y;
            assert!((fallen + 9.81 * 11.0 * DT).abs() < 1e-3, "{name}: the onlooker does not fall");
            world.validate().unwrap();
        }
    }
}

#[test]
fn a_broken_body_takes_part_again_when_it_is_mended() {
    let (mut world, bodies, _) = busy();
    let top = bodies[3];
    world.body_mut(top).unwrap().apply_impulse(Vec3::X * 3e38).unwrap();
    assert_eq!(world.step(DT).non_finite, [top]);
    assert_eq!(world.step(DT).non_finite, [top]);
    let mut edit = world.body_mut(top).unwrap();
    edit.set_velocity(Vec3::ZERO).unwrap();
    edit.set_angular_velocity(Vec3::ZERO).unwrap();
    assert_eq!(world.step(DT).non_finite, []);
}

#[test]
fn huge_definitions_step_without_panic() {
    let mut world = World::default();
    world.add_body(Body::fixed(Shape::half_space(Vec3::Y))).unwrap();
    let bodies = [
        Body::dynamic(Shape::ball(1e-6)).at(Vec3::Y * 1e-6),
        Body::dynamic(Shape::ball(1e6).density(1e-3)).at(Vec3::Y * 1e6),
        Body::dynamic(Shape::cuboid(1e-4, 1e3, 1e-4)).at(Vec3::new(3.0, 1e3, 0.0)),
        Body::dynamic(Shape::cuboid(0.5, 0.5, 0.5)).mass(1e30).at(Vec3::new(6.0, 0.5, 0.0)),
        Body::dynamic(Shape::cuboid(0.5, 0.5, 0.5)).mass(1e-25).at(Vec3::new(6.0, 1.5, 0.0)),
        Body::kinematic(Shape::ball(1.0)).velocity(Vec3::splat(1e38)).angular_velocity(Vec3::splat(1e38)),
        Body::dynamic(Shape::ball(0.1)).damping(1e38, 1e38).gravity_scale(1e38).at(Vec3::X * -5.0),
        Body::dynamic(Shape::ball(0.1)).continuous().velocity(Vec3::splat(-1e38)).at(Vec3::new(-9.0, 1.0, 0.0)),
    ];
    for body in bodies {
        world.add_body(body).unwrap();
    }
    for dt in [DT, 1e6, 1e-9, DT, 10.0, DT] {
        for _ in 0..5 {
            assert_eq!(world.step(dt).rejected, None);
        }
    }
    world.validate().unwrap();
}
