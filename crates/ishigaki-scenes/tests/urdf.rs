//! URDF: each feature in a few lines of XML, the tree against another reader, and rubbish.

mod common;

use common::{body, data, error_of, joint, mass, read_with};
use ishigaki::{BodyKind, Quat, Vec3};
use ishigaki_scenes::file::{FramesFile, FreedomFile, GeometryFile, JointKindFile};
use ishigaki_scenes::models::{Import, ImportOptions, import, import_urdf_str};

fn read(xml: &str) -> Import {
    read_with(import_urdf_str, xml)
}

fn error(xml: &str) -> String {
    error_of(import_urdf_str, xml)
}

const SOLID: &str = r#"<inertial><mass value="2"/><inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial>"#;

/// Two links and a joint with these insides.
fn pair(kind: &str, inside: &str) -> String {
    format!(
        r#"<robot name="r"><link name="a">{SOLID}</link><link name="b">{SOLID}</link>
           <joint name="j" type="{kind}"><parent link="a"/><child link="b"/>{inside}</joint></robot>"#
    )
}

#[test]
fn a_revolute_joint_stands_where_its_origin_says() {
    let import = read(&pair(
        "revolute",
        r#"<origin xyz="1 2 3" rpy="0.1 0.2 0.3"/><axis xyz="0 0 2"/><limit lower="-1" upper="0.5" effort="3" velocity="4"/>
           <dynamics damping="0.7" friction="0.2"/>"#,
    ));
    let b = body(&import.scene, "b");
    // Turns about the fixed axes: x, then y, then z.
    let turn = Quat::from_rotation_z(0.3) * Quat::from_rotation_y(0.2) * Quat::from_rotation_x(0.1);
    assert!(b.rotation.angle_between(turn) < 1e-3);
    assert_eq!(b.position, Vec3::new(1.0, 2.0, 3.0));
    let j = joint(&import.scene, "j");
    assert!(!j.collide);
    let FramesFile::World(frame) = j.frame else { panic!() };
    assert!((frame.position - b.position).length() < 1e-6);
    assert!((frame.rotation.unwrap() * Vec3::X - turn * Vec3::Z).length() < 1e-6);
    let JointKindFile::Hinge(drive) = j.kind else { panic!() };
    let limit = drive.limit.unwrap();
    assert_eq!((limit.lower, limit.upper), (Some(-1.0), Some(0.5)));
    assert_eq!((drive.spring.unwrap().damping, drive.spring.unwrap().stiffness, drive.friction), (0.7, 0.0, 0.2));
    assert!(import.warnings.iter().any(|w| w.contains("effort, velocity")), "{:?}", import.warnings);
}

#[test]
fn each_type_of_joint_has_its_freedoms() {
    let kind = |kind: &str, inside: &str| read(&pair(kind, inside)).scene.joints.first().map(|j| j.kind.clone());
    assert_eq!(kind("fixed", ""), None);
    assert_eq!(kind("floating", ""), None);
    assert!(matches!(kind("continuous", ""), Some(JointKindFile::Hinge(d)) if d.limit.is_none()));
    let limit = r#"<limit lower="-inf" upper="1" effort="1" velocity="1"/>"#;
    let Some(JointKindFile::Slider(drive)) = kind("prismatic", limit) else { panic!() };
    assert_eq!(drive.limit.map(|l| (l.lower, l.upper)), Some((None, Some(1.0))));
    assert!(matches!(kind("spherical", ""), Some(JointKindFile::Ball { .. })));
    let Some(JointKindFile::Generic { linear, angular }) = kind("planar", r#"<axis xyz="0 1 1"/>"#) else { panic!() };
    assert_eq!(linear.iter().filter(|f| **f != FreedomFile::Locked).count(), 2);
    // The axis of the turn is the normal of the plane: neither slide has a part along it.
    assert!(angular[0].axis.x.abs() < 1e-6 && angular[0].axis.y.abs() < 1e-6, "{}", angular[0].axis);
    // A floating link does not touch its parent either.
    assert_eq!(read(&pair("floating", "")).scene.excluded_pairs.len(), 1);
    assert_eq!(read(&pair("fixed", "")).scene.bodies.len(), 1);
}

#[test]
fn fixed_joints_merge_inertia_exactly() {
    let import = read(&pair("fixed", r#"<origin xyz="1 0 0" rpy="0 0 1.5707963267948966"/>"#));
    let m = mass(body(&import.scene, "a"));
    assert_eq!((m.mass, m.center), (4.0, Vec3::new(0.5, 0.0, 0.0)));
    // Two of 0.1, each 2 kg half a meter from the middle: about y and z 2·(0.1 + 2·0.25), about x 0.2.
    let mut moments = m.principal_inertia.to_array();
    moments.sort_by(f32::total_cmp);
    assert!((moments[0] - 0.2).abs() < 1e-6 && (moments[1] - 1.2).abs() < 1e-6 && (moments[2] - 1.2).abs() < 1e-6);
}

#[test]
fn a_full_inertia_matrix_keeps_its_axes() {
    let xml = r#"<robot name="r"><link name="a"><inertial><origin rpy="0.3 0 0"/><mass value="1"/>
        <inertia ixx="2" iyy="3" izz="4" ixy="0.1" ixz="-0.2" iyz="0.3"/></inertial></link></robot>"#;
    let m = mass(&read(xml).scene.bodies[0]);
    let made = ishigaki::math::rotated_diagonal(m.principal_frame, m.principal_inertia);
    let r = ishigaki::Mat3::from_quat(Quat::from_rotation_x(0.3));
    let given =
        ishigaki::Mat3::from_cols(Vec3::new(2.0, 0.1, -0.2), Vec3::new(0.1, 3.0, 0.3), Vec3::new(-0.2, 0.3, 4.0));
    let difference = made - r * given * r.transpose();
    assert!(difference.to_cols_array().iter().all(|x| x.abs() < 2e-6), "{difference}");
}

#[test]
fn the_root_floats_unless_it_is_called_world_or_the_base_is_fixed() {
    let xml = pair("continuous", "");
    let kind = |xml: &str, fixed_base: bool| {
        let options = ImportOptions { fixed_base, ..Default::default() };
        let scene = import_urdf_str(xml, &data(), &options).unwrap().scene;
        (scene.bodies[0].kind, scene.bodies.len())
    };
    assert_eq!(kind(&xml, false), (BodyKind::Dynamic, 2));
    let scene =
        import_urdf_str(&xml, &data(), &ImportOptions { fixed_base: true, ..Default::default() }).unwrap().scene;
    assert_eq!(body(&scene, "a").kind, BodyKind::Fixed);
    let scene = read(&xml.replace("\"a\"", "\"world\"")).scene;
    assert_eq!(body(&scene, "world").kind, BodyKind::Fixed);
    assert_eq!(body(&scene, "b").kind, BodyKind::Dynamic);
}

#[test]
fn shapes_have_the_file_s_sizes_along_its_z() {
    let xml = format!(
        r#"<robot name="r"><link name="a">{SOLID}
        <collision><geometry><box size="1 2 3"/></geometry></collision>
        <collision><origin xyz="0 0 1"/><geometry><cylinder radius="0.5" length="2"/></geometry></collision>
        <collision><geometry><sphere radius="0.25"/></geometry></collision>
        <collision><geometry><capsule radius="0.1" length="0.6"/></geometry></collision>
        <collision><geometry><mesh filename="tetrahedron.obj" scale="2 2 2"/></geometry></collision>
        <collision><geometry><mesh filename="package://data/tetrahedron.obj"/></geometry></collision>
        <collision><geometry><mesh filename="package://nobody/absent.stl"/></geometry></collision>
        </link></robot>"#
    );
    let Import { scene, warnings } = read(&xml);
    let shapes = &scene.bodies[0].shapes;
    assert_eq!(shapes.len(), 6);
    assert_eq!(shapes[0].geometry, GeometryFile::Cuboid { half_extents: Vec3::new(0.5, 1.0, 1.5) });
    assert_eq!(shapes[1].geometry, GeometryFile::Cylinder { half_height: 1.0, radius: 0.5 });
    assert!((shapes[1].rotation * Vec3::Y).cross(Vec3::Z).length() < 1e-6 && shapes[1].position.z == 1.0);
    assert_eq!(shapes[2].geometry, GeometryFile::Ball { radius: 0.25 });
    assert_eq!(shapes[3].geometry, GeometryFile::Capsule { half_length: 0.3, radius: 0.1 });
    let points = |g: &GeometryFile| match g {
        GeometryFile::ConvexHull(h) => h.points.clone(),
        other => panic!("{other:?}"),
    };
    let reach = |g: &GeometryFile| points(g).iter().map(|p| p.length()).fold(0.0, f32::max);
    assert_eq!((reach(&shapes[4].geometry), reach(&shapes[5].geometry)), (2.0, 1.0));
    assert!(
        warnings.iter().any(|w| w.contains("package://nobody/absent.stl") && w.contains("not there")),
        "{warnings:?}"
    );
}

#[test]
fn inertias_that_no_body_has_are_mended_and_told() {
    let link = |inertial: &str| {
        read(&format!(
            r#"<robot name="r"><link name="w"/><link name="a">{inertial}</link>
               <joint name="j" type="continuous"><parent link="w"/><child link="a"/></joint></robot>"#
        ))
    };
    let massless = link("");
    assert!(massless.warnings.iter().filter(|w| w.contains("no mass")).count() == 2, "{:?}", massless.warnings);
    assert!(mass(body(&massless.scene, "a")).validate().is_ok());
    let flat = link(r#"<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="5"/></inertial>"#);
    assert!(flat.warnings.iter().any(|w| w.contains("raised")));
    let m = mass(body(&flat.scene, "a"));
    assert!(m.validate().is_ok() && m.principal_inertia.max_element() == 5.0);
    let point = link(r#"<inertial><mass value="1"/></inertial>"#);
    assert!(mass(body(&point.scene, "a")).validate().is_ok());
}

#[test]
fn what_is_not_taken_over_is_told() {
    let xml = format!(
        r#"<robot name="r"><link name="a">{SOLID}</link><link name="b">{SOLID}</link>
        <joint name="j" type="continuous"><parent link="a"/><child link="b"/><mimic joint="k"/></joint>
        <gazebo reference="a"/><gazebo/><transmission name="t"/><banana/></robot>"#
    );
    let warnings = read(&xml).warnings;
    for words in [
        ["<gazebo> (2 times)", "model.urdf:3"],
        ["<mimic>", "independently"],
        ["<transmission>", "motors"],
        ["<banana>", "not known"],
        ["collision", "nothing touches"],
    ] {
        assert!(warnings.iter().any(|w| words.iter().all(|word| w.contains(word))), "{words:?} {warnings:#?}");
    }
}

#[test]
fn errors_name_the_line_the_element_and_the_remedy() {
    let cases: [(String, &[&str]); 12] = [
        ("<robot/>".into(), &["no links"]),
        ("<robot><link/></robot>".into(), &["name", "missing"]),
        ("<robot>\n<link name='a'/>\n<link name='a'/></robot>".into(), &["model.urdf:3", "two links"]),
        ("<robot><link name='a'/><link name='b'/></robot>".into(), &["two roots", "`a` and `b`"]),
        (
            pair("fixed", "").replace("child link=\"b\"", "child link=\"bb\""),
            &["unknown link `bb`", "did you mean `b`"],
        ),
        (pair("hinge", ""), &["unknown joint type `hinge`", "revolute"]),
        (pair("fixed", "<origin xyz='1 2'/>"), &["<origin>", "needs 3 numbers"]),
        (pair("fixed", "<origin xyz='1 2 x'/>"), &["`x` is not a number"]),
        (pair("revolute", "<limit lower='2' upper='1'/>"), &["exchanged"]),
        (pair("revolute", "<limit lower='nan' upper='1'/>"), &["NaN"]),
        (pair("continuous", "<axis xyz='0 0 0'/>"), &["no direction"]),
        (pair("fixed", "").replace("value=\"2\"", "value=\"-2\""), &["≥ 0"]),
    ];
    for (xml, words) in cases {
        let message = error(&xml);
        for word in words {
            assert!(message.contains(word), "{xml}\n{message}\nhas no {word}");
        }
    }
    let circle = "<robot><link name='r'/><link name='a'/><link name='b'/>
        <joint name='j' type='fixed'><parent link='a'/><child link='b'/></joint>
        <joint name='k' type='fixed'><parent link='b'/><child link='a'/></joint></robot>";
    assert!(error(circle).contains("circle"));
}

#[test]
fn damaged_files_do_not_panic() {
    let xml = std::fs::read_to_string(data().join("arm.urdf")).unwrap();
    let bytes: Vec<char> = xml.chars().collect();
    for i in 0..bytes.len() {
        for with in ["", "9", "\"", "<"] {
            let damaged: String =
                bytes[..i].iter().copied().chain(with.chars()).chain(bytes[i + 1..].iter().copied()).collect();
            let _ = import_urdf_str(&damaged, &data(), &ImportOptions { ground: true, fixed_base: i % 2 == 0 });
        }
    }
}

#[test]
fn another_reader_finds_the_same_links_and_limits() {
    let path = data().join("arm.urdf");
    let robot = urdf_rs::read_file(&path).unwrap();
    let Import { scene, .. } = import(&path, &ImportOptions { fixed_base: true, ..Default::default() }).unwrap();
    let total: f64 = robot.links.iter().skip(1).map(|l| l.inertial.mass.value).sum();
    let ours: f32 = scene.bodies.iter().filter(|b| b.kind == BodyKind::Dynamic).map(|b| mass(b).mass).sum();
    assert!((total as f32 - ours).abs() < 1e-5 * ours, "{total} {ours}");
    for theirs in robot.joints.iter().filter(|j| j.joint_type == urdf_rs::JointType::Revolute) {
        let JointKindFile::Hinge(drive) = joint(&scene, &theirs.name).kind else { panic!("{}", theirs.name) };
        let limit = drive.limit.unwrap();
        assert_eq!((limit.lower, limit.upper), (Some(theirs.limit.lower as f32), Some(theirs.limit.upper as f32)));
    }
}
