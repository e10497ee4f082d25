//! MJCF: each feature in a few lines of XML, one file with all of them against MuJoCo's own numbers, the body tree
//! against another reader, and rubbish.

mod common;

use common::{body, data, error_of, joint, mass, read_with};
use ishigaki::{Combine, Quat, Vec3};
use ishigaki_scenes::file::{
    BodyFile, BodyRef, FramesFile, FreedomFile, GeometryFile, JointFile, JointKindFile, SceneFile,
};
use ishigaki_scenes::models::{Import, ImportOptions, import, import_mjcf_str};

fn read(xml: &str) -> Import {
    read_with(import_mjcf_str, xml)
}

fn error(xml: &str) -> String {
    error_of(import_mjcf_str, xml)
}

/// A document with this in its worldbody.
fn world(inside: &str) -> String {
    format!("<mujoco><worldbody>{inside}</worldbody></mujoco>")
}

/// Inertia about the center in world axes: xx yy zz xy xz yz.
fn inertia_world(body: &BodyFile) -> [f32; 6] {
    let p = mass(body);
    let m = ishigaki::math::rotated_diagonal(body.rotation * p.principal_frame, p.principal_inertia);
    [m.x_axis.x, m.y_axis.y, m.z_axis.z, m.x_axis.y, m.x_axis.z, m.y_axis.z]
}

fn near(a: Vec3, b: [f32; 3], tolerance: f32) -> bool {
    (a - Vec3::from_array(b)).length() < tolerance
}

/// Place and orientation of body B when A stays and the joint has these coordinates, by the engine's definition.
fn moved(scene: &SceneFile, joint: &JointFile, coordinates: &[f32], bodies: &mut [(Vec3, Quat)]) {
    let index = |r: &BodyRef| match r {
        BodyRef::Index(i) => *i,
        BodyRef::Name(n) => panic!("{n}"),
    };
    let (a, b) = (index(&joint.body_a), index(&joint.body_b));
    let FramesFile::World(frame) = joint.frame else { panic!("{:?}", joint.frame) };
    let (origin, turn) = (frame.position, frame.rotation.unwrap_or(Quat::IDENTITY));
    let mut next = coordinates.iter().copied();
    let (mut shift, mut rotation) = (Vec3::ZERO, Quat::IDENTITY);
    match &joint.kind {
        JointKindFile::Hinge(_) => rotation = Quat::from_rotation_x(next.next().unwrap()),
        JointKindFile::Slider(_) => shift.x = next.next().unwrap(),
        JointKindFile::Generic { linear, angular } => {
            for (i, freedom) in linear.iter().enumerate() {
                if *freedom != FreedomFile::Locked {
                    shift[i] = next.next().unwrap();
                }
            }
            for axis in angular {
                rotation *= Quat::from_axis_angle(axis.axis, next.next().unwrap());
            }
        }
        other => panic!("{other:?}"),
    }
    // World motion of B with A at its place in the file, then A's own motion.
    let w = turn * rotation * turn.inverse();
    let at = |p: Vec3| origin + turn * shift + w * (p - origin);
    let (zero_a, zero_b) = (&scene.bodies[a], &scene.bodies[b]);
    let (pa, qa) = bodies[a];
    let along = qa * zero_a.rotation.inverse();
    let p = pa + along * (at(zero_b.position) - zero_a.position);
    bodies[b] = (p, along * w * zero_b.rotation);
}

fn zero_poses(scene: &SceneFile) -> Vec<(Vec3, Quat)> {
    scene.bodies.iter().map(|b| (b.position, b.rotation)).collect()
}

// --- Against MuJoCo -------------------------------------------------------------------------------------------------

/// Name, mass, center of mass (world), inertia about it in world axes (xx yy zz xy xz yz): MuJoCo 4.0.0 on
/// `features.xml`, bodies welded together taken as one.
type Reference = (&'static str, f64, [f64; 3], [f64; 3], [f64; 6]);
const MUJOCO: [Reference; 4] = [
    (
        "base",
        1.762504137,
        [0.0, 0.0, 1.0],
        [0.035047973, 0.03496654, 1.22058733],
        [
            0.05926565830397763,
            0.0659382006712589,
            0.020225335889953625,
            0.003249771052400756,
            0.004656009945083528,
            -0.011143201354466057,
        ],
    ),
    (
        "arm",
        3.500000139,
        [0.374517345, 0.063570651, 1.125281803],
        [0.287816616, 0.032317684, 1.303355722],
        [
            0.1299120267771294,
            0.14118868697281256,
            0.03745661190529131,
            -0.0029842384606382044,
            0.03350102727429943,
            0.022633250945602885,
        ],
    ),
    (
        "hand",
        0.4,
        [0.373273288, -0.176479027, 1.563887098],
        [0.336061836, -0.179865724, 1.561928004],
        [
            0.00198937472272745,
            0.001190180896256835,
            0.002320444381015718,
            0.00039164990416457713,
            0.000140478249503595,
            0.00026939557284736326,
        ],
    ),
    ("gantry", 4.0, [0.0, 2.0, 1.0], [0.0, 2.0, 1.0], [0.026666667, 0.026666667, 0.026666667, 0.0, 0.0, 0.0]),
];

#[test]
fn bodies_are_mujocos() {
    let Import { scene, .. } = import(&data().join("features.xml"), &ImportOptions::default()).unwrap();
    assert_eq!(scene.dt, 0.004);
    assert_eq!(scene.options.gravity, Vec3::new(0.0, 0.0, -9.8));
    for (name, expected_mass, position, center, inertia) in MUJOCO {
        let found = body(&scene, name);
        // Light bodies between a body and its parent take a part of its mass, in the same form.
        let light: Vec<&BodyFile> = scene.bodies.iter().filter(|b| b.name.starts_with(&format!("{name}/"))).collect();
        let total: f32 = mass(found).mass + light.iter().map(|b| mass(b).mass).sum::<f32>();
        assert!((f64::from(total) - expected_mass).abs() < 1e-6 * expected_mass, "{name}: {total}");
        assert!(near(found.position, position.map(|x| x as f32), 1e-6), "{name}: {}", found.position);
        let world_center = found.position + found.rotation * mass(found).center;
        assert!(near(world_center, center.map(|x| x as f32), 1e-6), "{name}: {world_center}");
        let part = mass(found).mass / total;
        for (i, (is, expected)) in inertia_world(found).iter().zip(inertia).enumerate() {
            assert!(
                (f64::from(is / part) - expected).abs() < 2e-6 * inertia[0].abs().max(1e-2),
                "{name} {i}: {is} {expected}"
            );
        }
    }
}

#[test]
fn all_that_is_not_taken_over_is_told() {
    let Import { scene, warnings } = import(&data().join("features.xml"), &ImportOptions::default()).unwrap();
    let told = |words: &[&str]| warnings.iter().any(|w| words.iter().all(|word| w.contains(word)));
    assert!(told(&["features.xml:29", "ellipsoid", "hull"]), "{warnings:#?}");
    assert!(told(&["wrist", "cone"]), "{warnings:#?}");
    assert!(told(&["gantry", "light bodies"]), "{warnings:#?}");
    assert!(told(&["servo", "spring and damper"]), "{warnings:#?}");
    assert!(told(&["1 actuators", "controlled"]), "{warnings:#?}");
    assert_eq!(warnings.len(), 5, "{warnings:#?}");
    // The inactive weld is no joint; the string is one between the hand and the puppet.
    assert!(scene.joints.iter().all(|j| j.name != "clamp"));
    assert!(matches!(joint(&scene, "string").kind, JointKindFile::Ball { .. }));
    assert_eq!(body(&scene, "puppet").kind, ishigaki::BodyKind::Kinematic);
    assert_eq!(body(&scene, "hand").gravity_scale, 0.0);
    // The servo on `yaw`: k = 20·3², rest at q = 0; `ref` is 0 there. The hinge's own damping is added to 2·3².
    let JointKindFile::Generic { angular, .. } = &joint(&scene, "lift+pitch+yaw").kind else { panic!() };
    let drive = angular[1].drive;
    let spring = drive.spring.unwrap();
    assert_eq!((spring.stiffness, spring.target), (180.0, 0.0));
    assert!((spring.damping - 18.1).abs() < 1e-5);
    assert_eq!((drive.armature, drive.friction), (0.02, 0.3));
}

// --- Joints ---------------------------------------------------------------------------------------------------------

#[test]
fn three_hinges_are_one_joint_turning_in_declared_order() {
    let xml = world(
        r#"<body name="a" pos="0 0 1"><freejoint/><geom size="0.1"/>
             <body name="b" pos="0.3 0 0" euler="0 0 90">
               <joint name="x" axis="1 0 0" pos="0.1 0 0" range="-10 20"/>
               <joint name="y" axis="0 1 0" pos="0.1 0 0" stiffness="2" damping="3"/>
               <joint name="z" axis="0 0 1" pos="0.1 0 0" armature="0.4"/>
               <geom size="0.1"/></body></body>"#,
    );
    let Import { scene, warnings } = read(&xml);
    assert_eq!(warnings, Vec::<String>::new());
    assert_eq!(scene.joints.len(), 1);
    let joint = joint(&scene, "x+y+z");
    assert!(!joint.collide, "neighbors do not touch");
    let JointKindFile::Generic { linear, angular } = &joint.kind else { panic!("{:?}", joint.kind) };
    assert!(linear.iter().all(|f| *f == FreedomFile::Locked));
    let limit = angular[0].drive.limit.unwrap();
    assert!(
        (limit.lower.unwrap() + 10_f32.to_radians()).abs() < 1e-6
            && (limit.upper.unwrap() - 20_f32.to_radians()).abs() < 1e-6
    );
    assert_eq!(angular[1].drive.spring.map(|s| (s.stiffness, s.damping)), Some((2.0, 3.0)));
    assert_eq!(angular[2].drive.armature, 0.4);
    // MuJoCo: R = R₀ Rx(α) Ry(β) Rz(γ) in the body's frame, and the anchor stays where it is.
    let q = [0.3, -0.5, 0.8];
    let mut poses = zero_poses(&scene);
    moved(&scene, joint, &q, &mut poses);
    let start = Quat::from_rotation_z(90_f32.to_radians());
    let expected = start * Quat::from_rotation_x(q[0]) * Quat::from_rotation_y(q[1]) * Quat::from_rotation_z(q[2]);
    let (p, r) = poses[1];
    assert!(r.angle_between(expected) < 1e-3, "{r} {expected}");
    let anchor = Vec3::new(0.1, 0.0, 0.0);
    assert!((p + r * anchor - (Vec3::new(0.3, 0.0, 1.0) + start * anchor)).length() < 1e-6);
}

#[test]
fn slides_and_a_hinge_to_the_world_are_one_joint_that_lets_the_body_touch_the_floor() {
    // As the planar robots of Gymnasium stand: the axes of the slides need not be x and z, nor right-handed.
    let xml = world(
        r#"<geom type="plane" size="1 1 1"/><body name="b" pos="0 0 1.25">
             <joint name="down" type="slide" axis="0 0 -1" ref="1.25" range="1 2" limited="true"/>
             <joint name="right" type="slide" axis="1 0 0" springref="0.5" stiffness="4"/>
             <joint name="third" type="slide" axis="0 1 0" range="-0.1 0.3"/>
             <joint name="turn" axis="0 1 0" pos="0.2 0 0"/><geom size="0.1"/></body>"#,
    );
    let Import { scene, .. } = read(&xml);
    let joint = joint(&scene, "down+right+third+turn");
    assert!(joint.collide);
    let JointKindFile::Generic { linear, angular } = &joint.kind else { panic!("{:?}", joint.kind) };
    assert_eq!(angular.len(), 1);
    let drive = |f: &FreedomFile| match f {
        FreedomFile::Free(d) => *d,
        FreedomFile::Locked => panic!("locked"),
    };
    // Counted from the pose in the file: 1 − 1.25 … 2 − 1.25.
    let range = |f: &FreedomFile| drive(f).limit.map(|l| (l.lower.unwrap(), l.upper.unwrap()));
    assert_eq!(range(&linear[0]), Some((-0.25, 0.75)));
    assert_eq!(drive(&linear[1]).spring.unwrap().target, 0.5);
    // (−z) × x = −y: the third slide is counted the other way.
    assert_eq!(range(&linear[2]), Some((-0.3, 0.1)));
    let mut poses = zero_poses(&scene);
    moved(&scene, joint, &[0.2, 0.4, -0.1, 0.5], &mut poses);
    let (p, r) = poses[usize::from(scene.bodies[1].name == "b")];
    let turned = Quat::from_rotation_y(0.5);
    assert!(r.angle_between(turned) < 1e-3);
    let anchor = Vec3::new(0.2, 0.0, 0.0);
    let expected = Vec3::new(0.4, 0.1, 1.05) + anchor - turned * anchor;
    assert!((p - expected).length() < 1e-6, "{p} {expected}");
}

#[test]
fn hinges_that_do_not_fit_get_light_bodies_and_move_as_they_should() {
    // Parallel hinges at different anchors, as in a folding rule.
    let xml = world(
        r#"<body name="b"><joint name="p" axis="0 0 1"/><joint name="q" axis="0 0 1" pos="0.5 0 0"/>
             <geom type="box" size="0.1 0.2 0.3" pos="0.7 0 0"/></body>"#,
    );
    let Import { scene, warnings } = read(&xml);
    assert!(warnings.iter().any(|w| w.contains("light bodies")), "{warnings:?}");
    let (light, heavy) = (body(&scene, "b/1"), body(&scene, "b"));
    let total = mass(light).mass + mass(heavy).mass;
    assert!((total - 48.0).abs() < 1e-3 && mass(light).mass < 0.06 * total);
    assert_eq!(scene.joints.len(), 2);
    let mut poses = zero_poses(&scene);
    moved(&scene, joint(&scene, "p"), &[0.3], &mut poses);
    moved(&scene, joint(&scene, "q"), &[-0.8], &mut poses);
    let b = scene.bodies.iter().position(|b| b.name == "b").unwrap();
    let (p, r) = poses[b];
    assert!(r.angle_between(Quat::from_rotation_z(-0.5)) < 1e-3);
    let anchor = Vec3::new(0.5, 0.0, 0.0);
    assert!((p + r * anchor - Quat::from_rotation_z(0.3) * anchor).length() < 1e-6);
}

#[test]
fn hinges_whose_axes_meet_are_one_joint_wherever_their_anchors_are_written() {
    // Both axes pass through (0.5, 0.2, 0).
    let xml = world(
        r#"<body name="b"><joint name="p" axis="1 0 0" pos="0.1 0.2 0"/><joint name="q" axis="0 1 0" pos="0.5 0 0"/>
             <geom size="0.1"/></body>"#,
    );
    let Import { scene, warnings } = read(&xml);
    assert_eq!(warnings, Vec::<String>::new());
    let FramesFile::World(frame) = joint(&scene, "p+q").frame else { panic!() };
    assert!(near(frame.position, [0.5, 0.2, 0.0], 1e-6), "{}", frame.position);
}

#[test]
fn ref_and_springref_are_counted_from_the_pose_in_the_file() {
    let hinge = |attributes: &str| {
        let xml = world(&format!(r#"<body><joint name="j" {attributes}/><geom size="0.1"/></body>"#));
        let JointKindFile::Hinge(drive) = joint(&read(&xml).scene, "j").kind else { panic!() };
        drive
    };
    let drive = hinge(r#"ref="30" springref="45" stiffness="1" range="0 90""#);
    let limit = drive.limit.unwrap();
    assert!((drive.spring.unwrap().target - 15_f32.to_radians()).abs() < 1e-6);
    assert!((limit.lower.unwrap() + 30_f32.to_radians()).abs() < 1e-6);
    assert!((limit.upper.unwrap() - 60_f32.to_radians()).abs() < 1e-6);
    assert_eq!(hinge(r#"range="0 90" limited="false""#).limit, None);
    assert_eq!(hinge("").spring, None);
}

#[test]
fn autolimits_off_needs_limited() {
    let xml = |limited: &str| {
        format!(
            r#"<mujoco><compiler autolimits="false"/><worldbody><body><joint name="j" range="0 90" {limited}/>
               <geom size="0.1"/></body></worldbody></mujoco>"#
        )
    };
    let drive = |import: &Import| match joint(&import.scene, "j").kind {
        JointKindFile::Hinge(d) => d,
        _ => panic!(),
    };
    let off = read(&xml(""));
    assert_eq!(drive(&off).limit, None);
    assert!(off.warnings.iter().any(|w| w.contains("not used")));
    assert!(drive(&read(&xml(r#"limited="true""#))).limit.is_some());
}

// --- Bodies, masses, geoms ------------------------------------------------------------------------------------------

#[test]
fn welded_bodies_become_one_with_their_common_inertia() {
    let whole = read(&world(r#"<body name="b"><freejoint/><geom type="box" size="1 0.25 0.125"/></body>"#));
    let halves = read(&world(
        r#"<body name="b"><freejoint/><geom type="box" size="0.5 0.25 0.125" pos="-0.5 0 0"/>
             <body pos="0.5 0 0" euler="180 0 0"><geom type="box" size="0.5 0.25 0.125"/></body></body>"#,
    ));
    assert_eq!(halves.scene.bodies.len(), 1);
    assert_eq!(halves.scene.bodies[0].shapes.len(), 2);
    let (a, b) = (mass(&whole.scene.bodies[0]), mass(&halves.scene.bodies[0]));
    assert!((a.mass - b.mass).abs() < 1e-3 && (a.center - b.center).length() < 1e-6);
    let (ia, ib) = (inertia_world(&whole.scene.bodies[0]), inertia_world(&halves.scene.bodies[0]));
    assert!(ia.iter().zip(ib).all(|(a, b)| (a - b).abs() < 1e-4), "{ia:?} {ib:?}");
}

#[test]
fn compiler_settings_change_masses_as_mujocos_do() {
    let with = |compiler: &str, inside: &str| {
        let xml = format!("<mujoco><compiler {compiler}/><worldbody>{inside}</worldbody></mujoco>");
        let scene = read(&xml).scene;
        scene.bodies.iter().map(mass).collect::<Vec<_>>()
    };
    let two =
        r#"<body><freejoint/><geom size="0.1" mass="1"/></body><body><freejoint/><geom size="0.1" mass="3"/></body>"#;
    let total = with(r#"settotalmass="10""#, two);
    assert_eq!((total[0].mass, total[1].mass), (2.5, 7.5));
    assert!((total[0].principal_inertia.x - 0.4 * 2.5 * 0.01).abs() < 1e-7);
    assert_eq!(with(r#"boundmass="2" boundinertia="0.05""#, two)[0].mass, 2.0);
    assert_eq!(with(r#"boundmass="2" boundinertia="0.05""#, two)[0].principal_inertia, Vec3::splat(0.05));
    let both =
        r#"<body><freejoint/><inertial pos="0 0 0" mass="5" diaginertia="1 1 1"/><geom size="0.1" mass="1"/></body>"#;
    assert_eq!(with("", both)[0].mass, 5.0);
    assert_eq!(with(r#"inertiafromgeom="true""#, both)[0].mass, 1.0);
    let odd = r#"<body><freejoint/><inertial pos="0 0 0" mass="5" diaginertia="1 1 4"/></body>"#;
    assert_eq!(with(r#"balanceinertia="true""#, odd)[0].principal_inertia, Vec3::splat(2.0));
    assert!(error(&world(odd)).contains("balanceinertia"));
    let grouped = r#"<body><freejoint/><geom size="0.1" mass="1" group="3"/><geom size="0.1" mass="2"/></body>"#;
    assert_eq!(with(r#"inertiagrouprange="0 2""#, grouped)[0].mass, 2.0);
}

#[test]
fn fromto_and_size_make_the_same_capsule() {
    let one = read(&world(r#"<body><freejoint/><geom type="capsule" fromto="0 0 -0.2 0 0 0.2" size="0.05"/></body>"#));
    let two = read(&world(r#"<body><freejoint/><geom type="capsule" size="0.05 0.2"/></body>"#));
    let (one, two) = (&one.scene.bodies[0], &two.scene.bodies[0]);
    assert_eq!(one.shapes[0].geometry, two.shapes[0].geometry);
    assert_eq!(one.shapes[0].geometry, GeometryFile::Capsule { half_length: 0.2, radius: 0.05 });
    // The engine's capsules lie along y, MuJoCo's along z.
    let along = one.shapes[0].rotation * Vec3::Y;
    assert!(along.cross(Vec3::Z).length() < 1e-6);
    assert!((mass(one).principal_inertia.length() - mass(two).principal_inertia.length()).abs() < 1e-6);
}

#[test]
fn a_floor_is_a_half_space_and_ground_is_added_only_without_one() {
    let xml = world(
        r#"<geom type="plane" size="1 1 1" pos="0 0 0.5"/><body pos="0 0 2"><freejoint/><geom size="0.1"/></body>"#,
    );
    let options = ImportOptions { ground: true, ..Default::default() };
    let scene = import_mjcf_str(&xml, &data(), &options).unwrap().scene;
    assert_eq!(scene.bodies.len(), 2);
    let floor = &body(&scene, "world").shapes[0];
    assert!(
        matches!(floor.geometry, GeometryFile::HalfSpace { normal } if (floor.rotation * normal - Vec3::Z).length() < 1e-6)
    );
    assert_eq!(floor.position.z, 0.5);
    let xml = world(r#"<body pos="0 0 2"><freejoint/><geom type="capsule" size="0.1 0.3"/></body>"#);
    let scene = import_mjcf_str(&xml, &data(), &options).unwrap().scene;
    let ground = &body(&scene, "ground").shapes[0];
    assert!((ground.position.z - 1.6).abs() < 1e-6, "under the lowest point: {}", ground.position);
}

#[test]
fn height_fields_stand_as_written() {
    // Two rows (north, south), three columns; rises to 0.5 m at the north-east corner.
    let xml = r#"<mujoco><asset><hfield name="h" nrow="2" ncol="3" size="2 1 0.5 0.1" elevation="0 0 4  0 0 0"/></asset>
        <worldbody><geom type="hfield" hfield="h"/></worldbody></mujoco>"#;
    let scene = read(xml).scene;
    let shape = &scene.bodies[0].shapes[0];
    let GeometryFile::HeightField { rows, columns, heights, size_x, size_z } = &shape.geometry else { panic!() };
    assert_eq!((*rows, *columns, *size_x, *size_z), (2, 3, 4.0, 2.0));
    let top = heights.iter().position(|&h| h == 0.5).unwrap();
    // The engine: columns along x, rows along its z.
    let (row, column) = (top / columns, top % columns);
    let local = Vec3::new(column as f32 / 2.0 * size_x - 2.0, heights[top], row as f32 * size_z - 1.0);
    assert!(near(shape.rotation * local, [2.0, 1.0, 0.5], 1e-6), "{}", shape.rotation * local);
}

#[test]
fn classes_and_includes_are_resolved() {
    let scene = import(&data().join("including.xml"), &ImportOptions::default()).unwrap().scene;
    // The class of the included file, the childclass of the including one.
    let m = mass(body(&scene, "included"));
    assert!((m.mass - 4.0 / 3.0 * std::f32::consts::PI * 0.001 * 250.0).abs() < 1e-6, "{}", m.mass);
    assert_eq!(body(&scene, "included").shapes[0].friction, 0.25);
}

// --- Contacts -------------------------------------------------------------------------------------------------------

#[test]
fn exclusions_hit_bodies_or_only_their_welded_parts() {
    let xml = |part: &str| {
        format!(
            r#"<mujoco><worldbody>
             <body name="a"><freejoint/><geom size="0.1"/><body name="part"><geom size="0.2"/></body></body>
             <body name="b"><freejoint/><geom size="0.3"/></body></worldbody>
             <contact><exclude body1="{part}" body2="b"/></contact></mujoco>"#
        )
    };
    let touches = |scene: &SceneFile, shape: usize| {
        let (s, t) = (&scene.bodies[0].shapes[shape], &scene.bodies[1].shapes[0]);
        s.member_of & t.collides_with != 0 && t.member_of & s.collides_with != 0
    };
    let scene = read(&xml("part")).scene;
    assert!(touches(&scene, 0) && !touches(&scene, 1));
    assert!(scene.excluded_pairs.is_empty());
    let xml = xml("a").replace(r#"<body name="part"><geom size="0.2"/></body>"#, "");
    assert_eq!(read(&xml).scene.excluded_pairs, vec![[BodyRef::Index(0), BodyRef::Index(1)]]);
}

#[test]
fn friction_is_the_greater_of_the_two() {
    let scene = read(&world(
        r#"<geom type="plane" size="1 1 1" friction="0.7"/>
           <body><freejoint/><geom size="0.1" condim="6" friction="0.3 0.02 0.001"/></body>"#,
    ))
    .scene;
    let ball = &scene.bodies[1].shapes[0];
    assert_eq!((ball.friction, ball.friction_combine), (0.3, Combine::Maximum));
    assert_eq!((ball.torsional_friction, ball.rolling_friction), (0.02, 0.001));
    assert_eq!(scene.bodies[0].shapes[0].torsional_friction, 0.0);
}

// --- Errors ---------------------------------------------------------------------------------------------------------

#[test]
fn errors_name_the_line_the_element_and_the_remedy() {
    let cases: [(&str, &[&str]); 18] = [
        ("<mujoco>\n<worldbody>", &["model.xml:", "not well-formed"]),
        (
            "<mujoco><worldbody>\n<body name='b'>\n<joint/></body></worldbody></mujoco>",
            &["model.xml:2", "\"b\"", "no mass"],
        ),
        (
            "<mujoco><worldbody>\n<geom name='g' size='1 x'/></worldbody></mujoco>",
            &[":2", "<geom name=\"g\">", "`x` is not a number"],
        ),
        ("<mujoco><worldbody><geom size='nan'/></worldbody></mujoco>", &["size", "finite"]),
        ("<mujoco><worldbody><geom size='1e300'/></worldbody></mujoco>", &["size", "within"]),
        ("<mujoco><worldbody><geom type='box' size='1 1'/></worldbody></mujoco>", &["box needs 3"]),
        ("<mujoco><worldbody><geom type='blob' size='1'/></worldbody></mujoco>", &["blob"]),
        ("<mujoco><worldbody><geom type='mesh' mesh='m'/></worldbody></mujoco>", &["unknown mesh `m`"]),
        ("<mujoco><worldbody><geom class='c' size='1'/></worldbody></mujoco>", &["unknown default class `c`"]),
        (
            "<mujoco><worldbody><body><joint axis='0 0 0'/><geom size='1'/></body></worldbody></mujoco>",
            &["axis", "no direction"],
        ),
        ("<mujoco><worldbody><body><joint range='2 1'/><geom size='1'/></body></worldbody></mujoco>", &["exchanged"]),
        (
            "<mujoco><worldbody><body><freejoint/><geom type='plane' size='1 1 1'/></body></worldbody></mujoco>",
            &["planes"],
        ),
        ("<mujoco><option timestep='0'/></mujoco>", &["timestep", "> 0"]),
        ("<mujoco><compiler eulerseq='xyzz'/></mujoco>", &["eulerseq"]),
        ("<mujoco><include file='not there.xml'/></mujoco>", &["not there.xml"]),
        ("<mujoco><contact><exclude body1='a' body2='b'/></contact></mujoco>", &["unknown body `a`"]),
        (
            "<mujoco><asset><mesh name='m' file='m.dae'/></asset><worldbody><geom type='mesh' mesh='m'/></worldbody></mujoco>",
            &["dae", "STL"],
        ),
        ("<robot/>", &["<mujoco>"]),
    ];
    for (xml, words) in cases {
        let message = error(xml);
        for word in words {
            assert!(message.contains(word), "{xml}\n{message}\nhas no {word}");
        }
    }
    assert!(
        import(&data().join("circle.xml"), &ImportOptions::default())
            .unwrap_err()
            .to_string()
            .contains("includes itself")
    );
    assert!(import(&data().join("absent.xml"), &ImportOptions::default()).is_err());
}

#[test]
fn deep_nesting_is_read() {
    let depth = 20_000;
    let xml =
        world(&format!("{}{}", "<body pos='0 0 0.001'><geom size='0.01'/>".repeat(depth), "</body>".repeat(depth)));
    let scene = read(&xml).scene;
    assert_eq!(scene.bodies.len(), depth, "bodies that cannot move stay apart");
}

/// Every place of a valid file with a character taken out, doubled or replaced: an error or a scene, never a panic.
#[test]
fn damaged_files_do_not_panic() {
    let xml = std::fs::read_to_string(data().join("features.xml")).unwrap();
    let bytes: Vec<char> = xml.chars().collect();
    for i in (0..bytes.len()).step_by(7) {
        for (k, with) in ["", "9", "-", "\"", "<", "e9", " "].into_iter().enumerate() {
            if (i / 7 + k) % 3 != 0 {
                continue;
            }
            let damaged: String =
                bytes[..i].iter().copied().chain(with.chars()).chain(bytes[i + 1..].iter().copied()).collect();
            let _ = import_mjcf_str(&damaged, &data(), &ImportOptions { ground: true, ..Default::default() });
        }
    }
}

// --- Against another reader -----------------------------------------------------------------------------------------

#[test]
fn another_reader_finds_the_same_tree() {
    let path = data().join("features.xml");
    let model = mjcf_rs::Model::from_file(&path).unwrap();
    let scene = import(&path, &ImportOptions::default()).unwrap().scene;
    let world = |mut id: usize| {
        let mut pose = model.bodies[id].body.pose;
        while let Some(parent) = model.bodies[id].parent {
            id = parent;
            pose = model.bodies[id].body.pose * pose;
        }
        pose
    };
    let mut compared = 0;
    for (id, entry) in model.bodies_iter() {
        let name = entry.body.name.clone().unwrap();
        let Some(found) = scene.bodies.iter().find(|b| b.name == name) else { continue };
        let pose = world(id);
        let p = Vec3::new(pose.translation.x as f32, pose.translation.y as f32, pose.translation.z as f32);
        assert!((found.position - p).length() < 1e-5, "{name}: {} {p}", found.position);
        compared += 1;
    }
    assert_eq!(compared, 6);
}
