//! What is written is read again; what is wrong is refused with its place; nothing panics.

use ishigaki::{Body, BodyHandle, BodyKind, Joint, JointKind, Pose, Quat, Shape, Vec3, World};
use ishigaki_recording::{About, Error, Geometry, KEY_INTERVAL, Recorder, Recording};

const DT: f32 = 1.0 / 60.0;

/// One body of every form, falling on the ground; two of them joined.
fn zoo() -> (World, Vec<BodyHandle>) {
    let corners = [[0.0, 0.0, 0.0], [0.5, 0.0, 0.1], [0.0, 0.6, 0.0], [0.1, 0.1, 0.7]].map(Vec3::from_array);
    let lid = Shape::cuboid(0.3, 0.05, 0.3).at(Vec3::new(0.0, 0.4, 0.0));
    let dynamic = [
        Shape::ball(0.4),
        Shape::cuboid(0.3, 0.2, 0.1),
        Shape::cuboid(0.3, 0.2, 0.1),
        Shape::capsule(0.3, 0.2),
        Shape::cylinder(0.3, 0.2),
        Shape::cone(0.3, 0.2),
        Shape::convex_hull(&corners).unwrap(),
        Shape::compound(vec![Shape::ball(0.3), lid]),
    ];
    let mesh = Shape::triangle_mesh(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap();
    let field = Shape::height_field(2, 3, vec![0.0, 0.1, 0.2, 0.3, 0.4, 0.5], 2.0, 1.0).unwrap();
    let mut world = World::default();
    let mut bodies: Vec<Body> = vec![Body::fixed(Shape::half_space(Vec3::Y)).named("ground")];
    bodies.push(Body::fixed(mesh).at(Vec3::new(0.0, 0.5, 9.0)));
    bodies.push(Body::kinematic(field).at(Vec3::new(0.0, 0.5, -9.0)));
    bodies.extend(
        (0..)
            .zip(dynamic)
            .map(|(i, shape)| Body::dynamic(shape).named(format!("body {i}")).at(Vec3::new(2.0 * i as f32, 0.7, 0.0))),
    );
    let handles = world.add_bodies(bodies).unwrap();
    let hinge = JointKind::Hinge { drive: ishigaki::Drive::default() };
    let frame = Pose::from_parts(Vec3::new(1.0, 0.7, 0.0), Quat::from_rotation_y(0.5));
    world.add_joint(Joint::new(handles[3], handles[4], hinge, frame)).unwrap();
    (world, handles)
}

fn about() -> About {
    About { name: "zoo".into(), dt: DT, contacts: true, ..About::default() }
}

/// Records `steps` steps; gives the worlds of all frames.
fn record(mut world: World, about: &About, steps: u64) -> (Vec<u8>, Vec<World>) {
    let mut recorder = Recorder::new(Vec::new(), &world, about).unwrap();
    let mut worlds = vec![world.clone()];
    for step in 1..=steps {
        world.step(about.dt);
        recorder.step(&world).unwrap();
        if step % about.every == 0 || step == steps {
            worlds.push(world.clone());
        }
    }
    (recorder.finish(&world).unwrap(), worlds)
}

fn small() -> Vec<u8> {
    let mut world = World::default();
    world.add_body(Body::fixed(Shape::half_space(Vec3::Y))).unwrap();
    world.add_body(Body::dynamic(Shape::ball(0.5)).at(Vec3::Y * 0.5)).unwrap();
    record(world, &about(), 3).0
}

fn read(bytes: &[u8]) -> Recording<'_> {
    Recording::read(bytes).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn frames_hold_the_worlds_bit_for_bit_in_any_order() {
    let (world, handles) = zoo();
    let (bytes, worlds) = record(world, &about(), 150);
    let recording = read(&bytes);
    assert_eq!(recording.len(), 151);
    assert!(worlds.len() > 2 * KEY_INTERVAL, "more than one key frame");
    for i in [150, 0, 1, 63, 64, 65, 127, 128, 3, 149] {
        let (frame, world) = (recording.frame(i).unwrap(), &worlds[i]);
        assert_eq!((frame.measures.step, frame.measures.time), (world.step_count(), world.time()));
        assert_eq!(Some(frame.measures), recording.measures(i));
        for (&handle, record) in handles.iter().zip(&frame.bodies) {
            let body = world.body(handle).unwrap();
            assert_eq!((record.position, record.rotation), (body.position(), body.rotation()), "frame {i}");
            assert_eq!((record.asleep, record.height), (body.is_asleep(), body.height()));
        }
        let points: usize = world.contacts().flat_map(|c| c.manifolds).map(|m| m.points.len()).sum();
        assert_eq!(frame.contacts.len(), points);
    }
    assert_eq!(recording.frame(151), None);
}

#[test]
fn lambda_carries_the_weight() {
    let mut options = ishigaki::WorldOptions::default();
    options.rest.sleep.enabled = false;
    let mut world = World::new(options).unwrap();
    world.add_body(Body::fixed(Shape::half_space(Vec3::Y))).unwrap();
    world.add_body(Body::dynamic(Shape::cuboid(0.3, 0.2, 0.1)).mass(2.0).at(Vec3::Y * 0.2)).unwrap();
    let (bytes, _) = record(world, &about(), 60);
    let last = read(&bytes).frame(60).unwrap();
    let impulse: f32 = last.contacts.iter().map(|c| c.impulse).sum();
    let expected = 2.0 * 9.81 * DT;
    assert!((impulse - expected).abs() < 0.02 * expected, "Σλ = {impulse}, weight·Δt = {expected}");
    assert_eq!(last.contacts.len(), 4);
    for contact in &last.contacts {
        assert_eq!(contact.normal.abs(), Vec3::Y);
        let corner = contact.point.abs() - Vec3::new(0.3, 0.0, 0.1);
        assert!(corner.length() < 0.01, "{contact:?}");
    }
}

#[test]
fn the_scene_says_all_that_is_needed_to_draw() {
    let (world, _) = zoo();
    let (bytes, worlds) = record(world, &about(), 1);
    let recording = read(&bytes);
    let scene = recording.scene();
    assert_eq!((scene.name.as_str(), scene.dt, scene.every, scene.contacts), ("zoo", DT, 1, true));
    assert_eq!(scene.up, Vec3::Y);
    assert_eq!(scene.bodies.len(), 11);
    // Two cuboids are one form; the compound is two shapes.
    assert_eq!(scene.geometries.len(), 11);
    assert_eq!(scene.bodies[4].shapes[0].geometry, scene.bodies[5].shapes[0].geometry);
    assert_eq!(scene.bodies[10].shapes.len(), 2);
    assert_eq!(scene.bodies[10].shapes[1].position, Vec3::new(0.0, 0.4, 0.0));
    assert_eq!(scene.bodies[0].kind, BodyKind::Fixed);
    assert_eq!((scene.bodies[0].name.as_str(), scene.bodies[0].mass), ("ground", None));
    assert!(scene.geometries.iter().any(|g| matches!(g, Geometry::ConvexHull { faces, .. } if faces.len() == 4)));
    let options: ishigaki::WorldOptions = serde_json::from_value(scene.options.clone()).unwrap();
    assert_eq!(&options, worlds[0].options());

    // Both bodies put the joint at the same place.
    let (joint, frame) = (&scene.joints[0], recording.frame(0).unwrap());
    let on = |body: u32, place: Pose| frame.bodies[body as usize].pose() * place;
    let (a, b) = (on(joint.body_a, joint.frame_a.pose()), on(joint.body_b, joint.frame_b.pose()));
    assert_eq!(joint.kind, "hinge");
    assert!((a.translation - Vec3::new(1.0, 0.7, 0.0)).length() < 1e-5, "{a:?}");
    assert!((a.translation - b.translation).length() < 1e-5 && a.rotation.angle_between(b.rotation) < 1e-3);
}

#[test]
fn a_world_at_rest_costs_little() {
    let (world, _) = zoo();
    let (bytes, worlds) = record(world, &About { contacts: false, ..about() }, 3000);
    let last = worlds.last().unwrap();
    assert!(last.bodies().filter(|(_, b)| b.is_asleep()).count() >= 6, "most of it sleeps");
    assert_eq!(read(&bytes).len(), 3001);
    let full = 3001 * (64 + 12 + 11 * 40);
    // Until it sleeps every body changes in its last bits.
    assert!(bytes.len() < full * 2 / 5, "{} bytes, {full} without changes", bytes.len());
}

#[test]
fn frames_that_are_left_out_and_a_last_one_that_is_not() {
    let (world, handles) = zoo();
    let (bytes, worlds) = record(world, &About { every: 4, ..about() }, 10);
    let recording = read(&bytes);
    let steps: Vec<u64> = (0..recording.len()).map(|i| recording.measures(i).unwrap().step).collect();
    assert_eq!(steps, [0, 4, 8, 10]);
    let last = recording.frame(3).unwrap();
    assert_eq!(last.bodies[3].position, worlds[3].body(handles[3]).unwrap().position());
}

#[test]
fn bodies_come_and_go() {
    let (mut world, handles) = zoo();
    let mut recorder = Recorder::new(Vec::new(), &world, &about()).unwrap();
    world.remove_body(handles[3]);
    world.add_body(Body::dynamic(Shape::ball(0.1)).at(Vec3::new(2.0, 2.0, 0.0))).unwrap();
    world.step(DT);
    recorder.step(&world).unwrap();
    let bytes = recorder.finish(&world).unwrap();
    let recording = read(&bytes);
    let (before, after) = (recording.frame(0).unwrap(), recording.frame(1).unwrap());
    assert!(!before.bodies[3].absent && after.bodies[3].absent);
    assert_eq!(after.bodies[3].position, before.bodies[3].position);
    assert_eq!(after.bodies.len(), 11);
}

#[test]
fn an_empty_world_is_a_recording() {
    let (bytes, _) = record(World::default(), &About::default(), 2);
    assert_eq!(read(&bytes).frame(2).unwrap().bodies, []);
}

#[test]
fn cut_off_at_any_byte_it_says_so_and_keeps_the_whole_frames() {
    let bytes = small();
    let whole = read(&bytes);
    let mut most = 0;
    for length in 0..bytes.len() {
        let cut = &bytes[..length];
        match Recording::read(cut) {
            Err(Error::NotARecording) => assert_eq!(length, 0),
            Err(Error::Truncated { at, frames }) => {
                assert!(at <= length as u64, "cut at {length}, says {at}");
                match Recording::recover(cut) {
                    Ok((part, error)) => {
                        assert_eq!(error, Some(Error::Truncated { at, frames }));
                        assert_eq!(part.len(), frames);
                        assert_eq!(part.frame(frames - 1), whole.frame(frames - 1));
                    }
                    Err(error) => assert_eq!((error, frames), (Error::Truncated { at, frames: 0 }, 0)),
                }
                assert!(frames >= most, "frames do not vanish as the file grows");
                most = frames;
            }
            other => panic!("cut at {length}: {other:?}"),
        }
    }
    assert_eq!(most, 4);
}

#[test]
fn every_flipped_bit_is_found() {
    let good = small();
    for bit in 0..8 * good.len() {
        let mut bytes = good.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        let error = Recording::read(&bytes).expect_err("a flipped bit");
        match bit / 8 {
            0..8 => assert_eq!(error, Error::NotARecording),
            8..16 => assert!(matches!(error, Error::Damaged { at: 0, .. }), "bit {bit}: {error}"),
            // A wrong end cannot be told from a missing one.
            byte if byte + 20 >= good.len() => {}
            byte => {
                let Error::Damaged { at, .. } = error else { panic!("bit {bit}: {error}") };
                assert!(at <= byte as u64, "byte {byte} is damaged, says {at}");
            }
        }
    }
}

#[test]
fn foreign_files_and_other_versions_are_told_apart() {
    assert_eq!(Recording::read(b"").unwrap_err(), Error::NotARecording);
    assert_eq!(Recording::read(b"ISHIGAKI snapshot").unwrap_err(), Error::NotARecording);
    let mut bytes = small();
    bytes[8] = 2;
    let checksum = crc32(&bytes[..12]).to_le_bytes();
    bytes[12..16].copy_from_slice(&checksum);
    assert_eq!(Recording::read(&bytes).unwrap_err(), Error::Version { found: 2 });
    let mut longer = small();
    longer.push(0);
    assert!(matches!(Recording::read(&longer).unwrap_err(), Error::Damaged { frames: 4, .. }));
}

/// Bit by bit, as the format's description says it.
fn crc32(bytes: &[u8]) -> u32 {
    let mut crc = u32::MAX;
    for &byte in bytes {
        crc ^= u32::from(byte);
        for _ in 0..8 {
            crc = if crc & 1 == 1 { crc >> 1 ^ 0xEDB8_8320 } else { crc >> 1 };
        }
    }
    !crc
}

/// Replaces words of a good recording and mends the checksums: only the checks of the content are left.
#[test]
fn hostile_content_with_right_checksums_is_refused_or_read_never_a_panic() {
    let good = small();
    let mut refused = 0;
    for at in (16..good.len() - 4).step_by(4) {
        for word in [0, 1, 2, 7, 64, 0xFFFF, 0x7FFF_FFFF, u32::MAX] {
            let mut bytes = good.clone();
            bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
            mend(&mut bytes);
            match Recording::recover(&bytes) {
                Ok((recording, error)) => {
                    refused += usize::from(error.is_some());
                    (0..recording.len()).for_each(|i| assert!(recording.frame(i).is_some()));
                }
                Err(_) => refused += 1,
            }
        }
    }
    assert!(refused > 1000, "{refused}");
}

fn mend(bytes: &mut [u8]) {
    let mut at = 16;
    while at + 12 <= bytes.len() {
        let length = u32::from_le_bytes(bytes[at + 4..at + 8].try_into().unwrap()) as usize;
        let Some(end) = at.checked_add(8 + length).filter(|&end| end + 4 <= bytes.len()) else { return };
        let checksum = crc32(&bytes[at..end]).to_le_bytes();
        bytes[end..end + 4].copy_from_slice(&checksum);
        at = end + 4;
    }
}
