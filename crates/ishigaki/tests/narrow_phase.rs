//! Contacts against brute force in f64, and the cases that make engines stumble.

mod oracle;

use ishigaki::collision::feature_id::FeatureId;
use ishigaki::collision::manifold::LocalManifold;
use ishigaki::collision::narrow_phase::{LocalManifolds, find_manifolds};
use ishigaki::collision::pair_memory::PairMemory;
use ishigaki::{ConvexHull, Geometry, HeightField, Pose, Quat, TriangleMesh, Vec3};
use oracle::{Body, Random, separation_along, signed_distance};
use parry3d::glamx::{DQuat, DVec3};
use std::sync::Arc;

const MARGIN: f32 = 0.02;

/// That of a broken snapshot.
fn with_axis(axis: u32) -> PairMemory {
    let mut memory = PairMemory::default();
    memory.axis = axis;
    memory
}

fn find(a: &Geometry, b: &Geometry, pose: &Pose, scale: f32, memory: &mut PairMemory) -> LocalManifolds {
    let mut out = LocalManifolds::new();
    find_manifolds(a, b, pose, MARGIN * scale, scale, memory, &mut out);
    for manifold in &out {
        let mut ids: Vec<FeatureId> = manifold.points.iter().map(|p| p.id).collect();
        ids.sort();
        ids.dedup();
        assert_eq!(ids.len(), manifold.points.len(), "ids are unique");
        assert!((manifold.normal.length() - 1.0).abs() < 1e-4, "the normal is unit");
        for p in &manifold.points {
            let along = (p.on_a - p.on_b).dot(manifold.normal);
            assert!(
                (along - p.separation).abs() < 1e-4 * scale,
                "separation {} is {along} by its points",
                p.separation
            );
        }
    }
    out
}

fn deepest(manifold: &LocalManifold) -> f32 {
    manifold.points.iter().map(|p| p.separation).fold(f32::INFINITY, f32::min)
}

fn cuboid(x: f32, y: f32, z: f32) -> Geometry {
    Geometry::Cuboid { half_extents: Vec3::new(x, y, z) }
}

fn double(v: Vec3) -> DVec3 {
    DVec3::new(v.x as f64, v.y as f64, v.z as f64)
}

fn body(geometry: &Geometry) -> Body {
    match geometry {
        Geometry::Ball { radius } => Body::hull(vec![DVec3::ZERO], *radius as f64),
        Geometry::Capsule { half_length, radius } => {
            let end = DVec3::Y * *half_length as f64;
            Body::hull(vec![-end, end], *radius as f64)
        }
        Geometry::Cuboid { half_extents } => {
            let corner = |i: u32| {
                let sign = |bit: u32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
                double(*half_extents) * DVec3::new(sign(0), sign(1), sign(2))
            };
            Body::hull((0..8).map(corner).collect(), 0.0)
        }
        Geometry::ConvexHull(hull) => Body::hull(hull.points().iter().map(|&p| double(p)).collect(), 0.0),
        other => panic!("no oracle for {other:?}"),
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Ball,
    Capsule,
    Cuboid,
    Hull,
}

fn random_geometry(random: &mut Random, kind: Kind, scale: f32) -> Geometry {
    let mut size = |low: f32| scale * random.within(low, 0.8);
    match kind {
        Kind::Ball => Geometry::Ball { radius: size(0.1) },
        Kind::Capsule => Geometry::Capsule { half_length: size(0.0), radius: size(0.1) },
        Kind::Cuboid => Geometry::Cuboid { half_extents: Vec3::new(size(0.05), size(0.05), size(0.05)) },
        Kind::Hull => loop {
            let count = 4 + random.below(5);
            let mut coordinate = || scale * random.within(-0.8, 0.8);
            let points: Vec<Vec3> = (0..count).map(|_| Vec3::new(coordinate(), coordinate(), coordinate())).collect();
            if let Ok(hull) = ConvexHull::new(&points)
                && hull.inner_radius() > 0.05 * scale
            {
                return Geometry::ConvexHull(Arc::new(hull));
            }
        },
    }
}

fn random_rotation(random: &mut Random) -> Quat {
    let mut part = || random.within(-1.0, 1.0);
    Quat::from_xyzw(part(), part(), part(), part()).normalize()
}

/// A pose where the two are near each other: overlapping, touching, or apart by a little.
fn random_pose(random: &mut Random, scale: f32) -> Pose {
    let direction = random_rotation(random) * Vec3::X;
    Pose::from_parts(direction * random.within(0.0, 1.6) * scale, random_rotation(random))
}

fn place(body: &Body, pose: &Pose) -> Body {
    let q = pose.rotation;
    let rotation = DQuat::from_xyzw(q.x as f64, q.y as f64, q.z as f64, q.w as f64).normalize();
    body.placed(|p| rotation * p + double(pose.translation))
}

/// Counts of what a sweep over random pairs saw.
#[derive(Default, Debug)]
struct Seen {
    overlapping: usize,
    near: usize,
    mirrored: usize,
    mirror_differs: usize,
}

fn check_pair(a: &Geometry, b: &Geometry, bodies: (&Body, &Body), pose: &Pose, scale: f32, seen: &mut Seen) {
    let (body_a, body_b) = (bodies.0, &place(bodies.1, pose));
    let truth = signed_distance(body_a, body_b);
    let out = find(a, b, pose, scale, &mut PairMemory::default());
    let scale64 = scale as f64;
    let noise = 2e-5 * scale64;
    let Some(manifold) = out.first() else {
        assert!(truth > -noise, "overlap of {truth} missed: {a:?} {b:?} {pose:?}");
        return;
    };
    assert_eq!(out.len(), 1);
    let normal = double(manifold.normal);
    let found = deepest(manifold) as f64;
    let along = separation_along(body_a, body_b, -normal);
    let context = || format!("truth {truth} found {found} along {along}: {a:?} {b:?} {pose:?} {manifold:?}");
    // The preference for faces and the last axis may cost 5 % and 1 mm.
    let lead = 0.053 * truth.abs() + 1.1e-3 * scale64;
    if truth < -noise {
        seen.overlapping += 1;
        assert!(along <= truth + noise && along >= truth - lead, "depth: {}", context());
        // Clipping may leave out a vertex that hangs over the border of the preferred face.
        assert!(found >= along - noise && found <= truth + lead, "deepest point: {}", context());
    } else {
        seen.near += 1;
        assert!(found <= truth + lead, "speculative separation too great: {}", context());
    }
    for p in &manifold.points {
        let off_a = body_a.height_of(double(p.on_a));
        let off_b = body_b.height_of(double(p.on_b));
        // A capsule that meets a face at a slant has its second point under its own surface: its core is clipped.
        // Faces are clipped with a tolerance of 0.1 mm, which reaches farther out at the sharp corners of random hulls.
        let most = scale64 * if [a, b].iter().any(|g| matches!(g, Geometry::ConvexHull(_))) { 1e-2 } else { 3e-4 };
        let least = |body: &Body| if body.edges.len() == 1 { -body.radius } else { -most };
        let on_surfaces = (least(body_a)..most).contains(&off_a) && (least(body_b)..most).contains(&off_b);
        assert!(on_surfaces, "off the surface by {off_a} {off_b}: {}", context());
    }
    // The other order gives the mirror image, except where two axes are equally good (often so, deep inside).
    if truth < -0.03 * scale64 {
        return;
    }
    let mirror = find(b, a, &pose.inverse(), scale, &mut PairMemory::default());
    let ids = |m: &LocalManifold| {
        let mut ids: Vec<FeatureId> = m.points.iter().map(|p| p.id).collect();
        ids.sort();
        ids
    };
    seen.mirrored += 1;
    let same = mirror.first().is_some_and(|mirror| {
        let mut swapped: Vec<FeatureId> = mirror.points.iter().map(|p| p.id.swapped()).collect();
        swapped.sort();
        let turned = -(pose.rotation * mirror.normal);
        (turned - manifold.normal).length() < 1e-3 && swapped == ids(manifold)
    });
    seen.mirror_differs += usize::from(!same);
}

fn sweep(kinds: [Kind; 2], pairs: usize, scale: f32, seed: u64) {
    let mut random = Random(seed);
    let mut seen = Seen::default();
    for _ in 0..pairs / 25 {
        let a = random_geometry(&mut random, kinds[0], scale);
        let b = random_geometry(&mut random, kinds[1], scale);
        let bodies = (body(&a), body(&b));
        for _ in 0..25 {
            let pose = random_pose(&mut random, scale);
            check_pair(&a, &b, (&bodies.0, &bodies.1), &pose, scale, &mut seen);
        }
    }
    println!("{seen:?}");
    assert!(seen.overlapping > pairs / 10, "{seen:?}");
    assert!(seen.mirror_differs * 20 < seen.mirrored, "{seen:?}");
}

#[test]
fn balls_and_capsules_agree_with_brute_force() {
    use Kind::{Ball, Capsule};
    for (i, kinds) in [[Ball, Ball], [Ball, Capsule], [Capsule, Ball], [Capsule, Capsule]].into_iter().enumerate() {
        sweep(kinds, 5_000, 1.0, i as u64);
    }
}

#[test]
fn boxes_agree_with_brute_force() {
    use Kind::Cuboid;
    sweep([Cuboid, Cuboid], 20_000, 1.0, 10);
    sweep([Cuboid, Cuboid], 10_000, 0.01, 11);
}

#[test]
fn hulls_agree_with_brute_force() {
    use Kind::{Cuboid, Hull};
    sweep([Hull, Hull], 20_000, 1.0, 20);
    sweep([Cuboid, Hull], 10_000, 1.0, 21);
    sweep([Hull, Cuboid], 5_000, 0.01, 22);
}

#[test]
fn round_shapes_on_polyhedra_agree_with_brute_force() {
    use Kind::{Ball, Capsule, Cuboid, Hull};
    sweep([Ball, Cuboid], 5_000, 1.0, 30);
    sweep([Cuboid, Ball], 5_000, 0.01, 31);
    sweep([Ball, Hull], 5_000, 1.0, 32);
    sweep([Capsule, Cuboid], 10_000, 1.0, 33);
    sweep([Capsule, Hull], 10_000, 1.0, 34);
    sweep([Cuboid, Capsule], 5_000, 0.01, 35);
}

#[test]
fn thin_plates_and_great_ratios_agree_with_brute_force() {
    let mut random = Random(40);
    let mut seen = Seen::default();
    let plate = cuboid(0.5, 0.0005, 0.5);
    let small = cuboid(0.01, 0.01, 0.01);
    let great = cuboid(10.0, 10.0, 10.0);
    for (a, b, reach) in [(&plate, &plate, 0.3), (&plate, &small, 0.5), (&great, &small, 17.5)] {
        let bodies = (body(a), body(b));
        for _ in 0..1000 {
            let direction = random_rotation(&mut random) * Vec3::X;
            let rotation = random_rotation(&mut random);
            let pose = Pose::from_parts(direction * random.within(0.0, reach), rotation);
            check_pair(a, b, (&bodies.0, &bodies.1), &pose, 1.0, &mut seen);
        }
    }
    assert!(seen.overlapping > 300, "{seen:?}");
}

#[test]
fn a_half_space_touches_every_solid_where_it_is_lowest() {
    let mut random = Random(50);
    let floor = Geometry::HalfSpace { normal: Vec3::Y };
    for _ in 0..5_000 {
        let solids = [
            random_geometry(&mut random, Kind::Ball, 1.0),
            random_geometry(&mut random, Kind::Capsule, 1.0),
            random_geometry(&mut random, Kind::Cuboid, 1.0),
            random_geometry(&mut random, Kind::Hull, 1.0),
            Geometry::Cylinder { half_height: random.within(0.1, 1.0), radius: random.within(0.1, 1.0) },
            Geometry::Cone { half_height: random.within(0.1, 1.0), radius: random.within(0.1, 1.0) },
        ];
        for solid in &solids {
            let rotation = random_rotation(&mut random);
            let pose = Pose::from_parts(Vec3::Y * random.within(-0.5, 1.0), rotation);
            // The bounds are tight for all of these, so their lowest point is the truth.
            let lowest = solid.bounds(&pose).0.y;
            let out = find(&floor, solid, &pose, 1.0, &mut PairMemory::default());
            if lowest > MARGIN + 1e-5 {
                assert!(out.is_empty());
            } else if lowest < MARGIN - 1e-5 {
                assert_eq!(out[0].normal, -Vec3::Y, "B's normal points into the floor");
                assert!((deepest(&out[0]) - lowest).abs() < 2e-4, "{solid:?}: {} {lowest}", deepest(&out[0]));
            }
            let mirror = find(solid, &floor, &pose.inverse(), 1.0, &mut PairMemory::default());
            assert_eq!(mirror.len(), out.len());
        }
    }
}

/// The rectangle around the points of a manifold in X and Z.
fn spread(manifold: &LocalManifold) -> (f32, f32) {
    let low = manifold.points.iter().fold(Vec3::INFINITY, |m, p| m.min(p.on_b));
    let high = manifold.points.iter().fold(Vec3::NEG_INFINITY, |m, p| m.max(p.on_b));
    (high.x - low.x, high.z - low.z)
}

#[test]
fn cylinders_and_cones_stand_on_spread_points_with_constant_names() {
    let floors = [
        (Geometry::HalfSpace { normal: Vec3::Y }, 0.0),
        (cuboid(2.0, 0.5, 2.0), 0.5),
        (Geometry::TriangleMesh(Arc::new(grid(8, 1.0, |_, _| 0.0))), 0.0),
        (Geometry::Cylinder { half_height: 0.5, radius: 0.5 }, 0.5),
    ];
    let solids =
        [Geometry::Cylinder { half_height: 1.0, radius: 0.5 }, Geometry::Cone { half_height: 1.0, radius: 0.5 }];
    for (floor, top) in &floors {
        for solid in &solids {
            let mut memory = PairMemory::default();
            let mut names: Option<Vec<FeatureId>> = None;
            for step in 0..20 {
                // It trembles as a body at rest does.
                let tremble = 1e-5 * (step as f64).sin() as f32;
                let pose = Pose::from_parts(Vec3::new(0.02, top + 0.997, 0.03), Quat::from_rotation_x(tremble));
                let out = find(floor, solid, &pose, 1.0, &mut memory);
                let points: Vec<_> = out.iter().flat_map(|m| m.points.iter()).collect();
                assert!(points.len() >= 3, "{floor:?} {solid:?}: {out:?}");
                for manifold in &out {
                    assert!((manifold.normal + Vec3::Y).length() < 1e-3, "{manifold:?}");
                }
                if out.len() == 1 {
                    let (x, z) = spread(&out[0]);
                    assert!(x > 0.7 && z > 0.7, "points span the base: {x} {z} {out:?}");
                }
                let mut now: Vec<FeatureId> = points.iter().map(|p| p.id).collect();
                now.sort();
                assert!(names.is_none_or(|before| before == now), "names changed on {floor:?}");
                names = Some(now);
            }
        }
    }
}

#[test]
fn what_lies_flat_touches_in_more_than_one_point() {
    let table = cuboid(1.0, 0.5, 1.0);
    let lying = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    let capsule = Geometry::Capsule { half_length: 0.4, radius: 0.2 };
    let cylinder = Geometry::Cylinder { half_height: 0.4, radius: 0.2 };
    let along = |x: f32, y: f32| Pose::from_parts(Vec3::new(x, y, 0.0), lying);
    for solid in [&capsule, &cylinder] {
        // On a face; on an edge of the table from outside it has the face's direction still.
        let out = find(&table, solid, &along(0.1, 0.697), 1.0, &mut PairMemory::default());
        assert_eq!(out[0].points.len(), 2, "{out:?}");
        assert!(spread(&out[0]).1 > 0.79);
        // Two of a kind, side by side.
        let out =
            find(solid, solid, &Pose::from_translation(Vec3::new(0.397, 0.2, 0.0)), 1.0, &mut PairMemory::default());
        assert_eq!(out[0].points.len(), 2, "{out:?}");
    }
    // A capsule along an edge, seen from 45°.
    let out = find(&table, &capsule, &along(1.0 + 0.14, 0.5 + 0.14), 1.0, &mut PairMemory::default());
    assert_eq!(out[0].points.len(), 2, "{out:?}");
}

#[test]
fn curved_pairs_separate_by_the_depth_they_report() {
    let mut random = Random(60);
    let mut overlapping = 0;
    for _ in 0..4_000 {
        let mut size = |low: f32| random.within(low, 0.8);
        let curved = [
            Geometry::Cylinder { half_height: size(0.1), radius: size(0.1) },
            Geometry::Cone { half_height: size(0.1), radius: size(0.1) },
        ];
        let kind = [Kind::Ball, Kind::Capsule, Kind::Cuboid, Kind::Hull][random.below(4)];
        let other = random_geometry(&mut random, kind, 1.0);
        let pairs = [(&curved[0], &other), (&other, &curved[1]), (&curved[0], &curved[1])];
        for (a, b) in pairs {
            let pose = random_pose(&mut random, 1.0);
            let (shape_a, shape_b) = (a.to_parry().unwrap(), b.to_parry().unwrap());
            let identity = Pose::IDENTITY;
            let out = find(a, b, &pose, 1.0, &mut PairMemory::default());
            let distance = parry3d::query::distance(&identity, &*shape_a.0, &pose, &*shape_b.0).unwrap().distance;
            let Some(manifold) = out.first() else {
                let contact = parry3d::query::contact(&identity, &*shape_a.0, &pose, &*shape_b.0, 0.0).unwrap();
                assert!(contact.is_none_or(|c| c.dist > -1e-3), "missed: {a:?} {b:?} {pose:?}");
                continue;
            };
            let found = deepest(manifold);
            if distance > 0.0 {
                // parry's contact and distance differ by this much.
                assert!(found <= distance + 4e-3, "{found} {distance}: {a:?} {b:?} {pose:?}");
            } else {
                overlapping += 1;
                if found < -0.05 {
                    // Deep inside clipping may leave out what hangs over the border of a face.
                    continue;
                }
                // B moved along −normal by the depth (and the tolerances) no longer overlaps.
                let away = -manifold.normal * (-found * 1.06 + 4e-3);
                let moved = Pose::from_parts(pose.translation + away, pose.rotation);
                let left = parry3d::query::distance(&identity, &*shape_a.0, &moved, &*shape_b.0).unwrap().distance;
                assert!(left > 0.0, "still overlapping: {a:?} {b:?} {pose:?} {manifold:?}");
            }
        }
    }
    assert!(overlapping > 3_000);
}

/// A square grid of cells around the origin.
fn grid(cells: usize, cell: f32, height: impl Fn(f32, f32) -> f32) -> TriangleMesh {
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    let at = |i: usize| (i as f32 - 0.5 * cells as f32) * cell;
    for i in 0..=cells {
        for j in 0..=cells {
            vertices.push(Vec3::new(at(i), height(at(i), at(j)), at(j)));
        }
    }
    let number = |i: usize, j: usize| (i * (cells + 1) + j) as u32;
    for i in 0..cells {
        for j in 0..cells {
            let (a, b, c, d) = (number(i, j), number(i, j + 1), number(i + 1, j + 1), number(i + 1, j));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    TriangleMesh::new(vertices, triangles).unwrap()
}

fn sliders() -> Vec<(Geometry, Quat, f32)> {
    let h = Vec3::new(0.3, 0.2, 0.25);
    let corners: Vec<Vec3> = (0..8)
        .map(|i| {
            Vec3::new(
                if i & 1 == 0 { -h.x } else { h.x },
                if i & 2 == 0 { -h.y } else { h.y },
                if i & 4 == 0 { -h.z } else { h.z },
            )
        })
        .collect();
    let lying = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
    vec![
        (Geometry::Cuboid { half_extents: h }, Quat::IDENTITY, h.y),
        (Geometry::Cuboid { half_extents: h }, Quat::from_rotation_y(0.3), h.y),
        (Geometry::ConvexHull(Arc::new(ConvexHull::new(&corners).unwrap())), Quat::from_rotation_y(0.1), h.y),
        (Geometry::Ball { radius: 0.2 }, Quat::IDENTITY, 0.2),
        (Geometry::Capsule { half_length: 0.3, radius: 0.2 }, lying, 0.2),
        (Geometry::Capsule { half_length: 0.3, radius: 0.2 }, Quat::IDENTITY, 0.5),
        (Geometry::Cylinder { half_height: 0.2, radius: 0.3 }, Quat::IDENTITY, 0.2),
    ]
}

#[test]
fn nothing_stumbles_over_a_flat_mesh_or_terrain() {
    let mesh = Geometry::TriangleMesh(Arc::new(grid(10, 0.5, |_, _| 0.0)));
    let field = Geometry::HeightField(Arc::new(HeightField::new(11, 11, vec![0.0; 121], 5.0, 5.0).unwrap()));
    for floor in [&mesh, &field] {
        for (solid, rotation, lowest) in sliders() {
            for overlap in [0.0, 0.001, 0.005] {
                let mut memory = PairMemory::default();
                for step in 0..400 {
                    let x = -1.5 + 0.0076 * step as f32;
                    let pose = Pose::from_parts(Vec3::new(x, lowest - overlap, 0.3 * x + 0.1), rotation);
                    let out = find(floor, &solid, &pose, 1.0, &mut memory);
                    let depth = out.iter().map(deepest).fold(f32::INFINITY, f32::min);
                    assert!((depth + overlap).abs() < 2e-4, "{solid:?} at {x}: {depth}, overlap {overlap}");
                    for manifold in &out {
                        assert!((manifold.normal + Vec3::Y).length() < 1e-3, "{solid:?} at {x}: {manifold:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn nothing_stumbles_over_the_seam_of_flush_boxes() {
    let floor = cuboid(1.0, 0.5, 1.0);
    for (solid, rotation, lowest) in sliders() {
        for overlap in [0.0, 0.001, 0.003, 0.005] {
            let mut memories = [PairMemory::default(); 2];
            for step in 0..1000 {
                let x = -0.8 + 0.00163 * step as f32;
                let mut touched = false;
                for (memory, center) in memories.iter_mut().zip([-1.0, 1.0]) {
                    let position = Vec3::new(x - center, 0.5 + lowest - overlap, 0.1);
                    let out = find(&floor, &solid, &Pose::from_parts(position, rotation), 1.0, memory);
                    for manifold in &out {
                        touched = true;
                        let tilt = (manifold.normal + Vec3::Y).length();
                        // What is round and overlaps the plane overlaps the edge a little before it is over it.
                        let round = matches!(solid, Geometry::Ball { .. } | Geometry::Capsule { .. });
                        let grazes = round && overlap > 0.0 && deepest(manifold) <= 0.0;
                        assert!(tilt < 1e-3 || grazes, "{solid:?} at {x}, overlap {overlap}: {manifold:?}");
                    }
                }
                assert!(touched, "{solid:?} at {x} touches nothing");
            }
        }
    }
}

#[test]
fn ridges_and_borders_of_a_mesh_give_normals_between_their_faces() {
    // A roof: its ridge runs along Z at the height 1, its sides fall at 45°.
    let roof = Geometry::TriangleMesh(Arc::new(grid(2, 1.0, |x, _| 1.0 - x.abs())));
    let ball = Geometry::Ball { radius: 0.3 };
    let out = find(&roof, &ball, &Pose::from_translation(Vec3::new(0.05, 1.29, 0.3)), 1.0, &mut PairMemory::default());
    assert_eq!(out.len(), 1, "one triangle has the ridge: {out:?}");
    let expected = -Vec3::new(0.05, 0.29, 0.0).normalize();
    assert!((out[0].normal - expected).length() < 1e-3, "{out:?}");
    let plank = cuboid(0.4, 0.1, 0.1);
    let out = find(&roof, &plank, &Pose::from_translation(Vec3::new(0.1, 1.098, 0.3)), 1.0, &mut PairMemory::default());
    assert!(!out.is_empty());
    for manifold in &out {
        assert!((manifold.normal + Vec3::Y).length() < 1e-3, "a plank on a ridge stands upright: {out:?}");
    }
    // From below, or with its center under the surface, nothing.
    let below = find(&roof, &ball, &Pose::from_translation(Vec3::new(0.5, 0.3, 0.3)), 1.0, &mut PairMemory::default());
    assert!(below.is_empty(), "{below:?}");
    // A body that sank into a terrain is pushed up.
    let field = Geometry::HeightField(Arc::new(HeightField::new(3, 3, vec![0.0; 9], 4.0, 4.0).unwrap()));
    for solid in [&ball, &plank] {
        let out =
            find(&field, solid, &Pose::from_translation(Vec3::new(0.3, -0.05, 0.2)), 1.0, &mut PairMemory::default());
        assert!(!out.is_empty() && out.iter().all(|m| (m.normal + Vec3::Y).length() < 1e-3), "{out:?}");
    }
}

#[test]
fn degenerate_input_gives_finite_contacts_and_no_panic() {
    let hull = |points: &[[f32; 3]]| {
        let points: Vec<Vec3> = points.iter().map(|&p| p.into()).collect();
        Geometry::ConvexHull(Arc::new(ConvexHull::new(&points).unwrap()))
    };
    let shapes = [
        Geometry::Ball { radius: 0.3 },
        Geometry::Capsule { half_length: 0.0, radius: 0.3 },
        Geometry::Capsule { half_length: 0.5, radius: 0.2 },
        cuboid(0.5, 0.5, 0.5),
        cuboid(0.5, 0.0005, 0.5),
        hull(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
        Geometry::Cylinder { half_height: 0.5, radius: 0.3 },
        Geometry::Cone { half_height: 0.5, radius: 0.3 },
        Geometry::HalfSpace { normal: Vec3::Y },
        Geometry::TriangleMesh(Arc::new(grid(2, 0.5, |_, _| 0.0))),
        Geometry::HeightField(Arc::new(HeightField::new(2, 2, vec![0.0; 4], 1.0, 1.0).unwrap())),
    ];
    let bad = Pose::from_translation(Vec3::new(f32::NAN, 0.0, 0.0));
    let quarter = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    let poses = [
        Pose::IDENTITY,
        Pose::from_rotation(quarter),
        Pose::from_translation(Vec3::new(1.0, 0.0, 0.0)),
        Pose::from_translation(Vec3::new(0.0, 1.0, 0.0)),
        Pose::from_translation(Vec3::new(1.0, 1.0, 1.0)),
        Pose::from_translation(Vec3::splat(1e-20)),
    ];
    for a in &shapes {
        for b in &shapes {
            assert!(find(a, b, &bad, 1.0, &mut PairMemory::default()).is_empty());
            for pose in &poses {
                for axis in [0, 1 << 26, 2 << 26 | 77, 3 << 26 | 0x3ff_ffff, u32::MAX] {
                    for manifold in find(a, b, pose, 1.0, &mut with_axis(axis)) {
                        assert!(!manifold.points.is_empty());
                        assert!(manifold.points.iter().all(|p| p.separation.is_finite() && p.on_a.is_finite()));
                    }
                }
            }
        }
    }
    // Identical centers: solids overlap and must say so.
    for a in &shapes[..8] {
        for b in &shapes[..8] {
            assert!(!find(a, b, &Pose::IDENTITY, 1.0, &mut PairMemory::default()).is_empty(), "{a:?} {b:?}");
        }
    }
}

#[test]
fn a_hull_has_the_faces_a_person_would_count() {
    // A prism of twelve sides, and a cube with points on its faces and edges.
    let ring = |y: f32| {
        (0..12).map(move |i| {
            let angle = i as f64 * std::f64::consts::TAU / 12.0;
            Vec3::new(angle.cos() as f32, y, angle.sin() as f32)
        })
    };
    let prism = ConvexHull::new(&ring(-1.0).chain(ring(1.0)).collect::<Vec<_>>()).unwrap();
    assert_eq!((prism.face_count(), prism.vertices().len()), (14, 24));
    let mut cube = Vec::new();
    for x in -1..=1 {
        for y in -1..=1 {
            for z in -1..=1 {
                cube.push(Vec3::new(x as f32, y as f32, z as f32));
            }
        }
    }
    let cube = ConvexHull::new(&cube).unwrap();
    assert_eq!((cube.face_count(), cube.vertices().len()), (6, 8));
    assert!((cube.inner_radius() - 1.0).abs() < 1e-6);
    for i in 0..cube.face_count() {
        let (normal, corners) = cube.face(i);
        assert_eq!(corners.len(), 4);
        assert!(corners.iter().all(|&c| (cube.vertices()[c as usize].dot(normal) - 1.0).abs() < 1e-6));
    }
}
