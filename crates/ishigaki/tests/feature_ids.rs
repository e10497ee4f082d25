//! Semantic contact ids: the same contact keeps its name from frame to frame.

use ishigaki::collision::feature_id::FeatureId;
use ishigaki::collision::narrow_phase::{LocalManifolds, find_manifolds};
use ishigaki::collision::pair_memory::PairMemory;
use ishigaki::{Geometry, Pose, Quat, Vec3};

fn cuboid(x: f32, y: f32, z: f32) -> Geometry {
    Geometry::Cuboid { half_extents: Vec3::new(x, y, z) }
}

fn ids(a: &Geometry, b: &Geometry, pose: &Pose, memory: &mut PairMemory) -> Vec<FeatureId> {
    let mut out = LocalManifolds::new();
    find_manifolds(a, b, pose, 0.02, 1.0, memory, &mut out);
    let ids: Vec<_> = out.iter().flat_map(|m| m.points.iter().map(|p| p.id)).collect();
    let mut unique = ids.clone();
    unique.sort();
    unique.dedup();
    assert_eq!(ids.len(), unique.len(), "two points share an id");
    ids
}

/// Part of the points that find their id in the frame before, over a scripted motion.
fn match_rate(a: &Geometry, b: &Geometry, frames: usize, pose: impl Fn(f32) -> Pose) -> f32 {
    let mut memory = PairMemory::default();
    let mut before = ids(a, b, &pose(0.0), &mut memory);
    let (mut matched, mut total) = (0, 0);
    for frame in 1..frames {
        let now = ids(a, b, &pose(frame as f32 / 60.0), &mut memory);
        assert!(!now.is_empty(), "contact lost in frame {frame}");
        matched += now.iter().filter(|id| before.contains(id)).count();
        total += now.len();
        before = now;
    }
    matched as f32 / total as f32
}

#[test]
fn a_sliding_box_keeps_its_ids() {
    let slide = |t: f32| Pose::from_translation(Vec3::new(0.3 * t - 1.0, 0.997, 0.2 * t));
    let rate = match_rate(&cuboid(2.0, 0.5, 2.0), &cuboid(0.5, 0.5, 0.5), 600, slide);
    assert!(rate > 0.95, "{rate}");
}

#[test]
fn a_slowly_turning_box_keeps_its_ids() {
    let turn = |t: f32| Pose::from_parts(Vec3::new(0.1, 0.997, 0.05), Quat::from_rotation_y(0.2 * t));
    let rate = match_rate(&cuboid(0.5, 0.5, 0.5), &cuboid(0.5, 0.5, 0.5), 600, turn);
    assert!(rate > 0.95, "{rate}");
}

#[test]
fn a_box_that_tips_over_an_edge_keeps_its_ids() {
    // It turns about its lower edge at x = 0.5 from lying on one face to lying on the next.
    let tip = |t: f32| {
        let turn = Quat::from_rotation_z(-0.15 * t);
        let edge = Vec3::new(0.5, 0.497, 0.0);
        Pose::from_parts(edge - turn * Vec3::new(0.5, -0.5, 0.0), turn)
    };
    let rate = match_rate(&cuboid(2.0, 0.5, 2.0), &cuboid(0.5, 0.5, 0.5), 628, tip);
    assert!(rate > 0.95, "{rate}");
}

#[test]
fn a_box_and_the_same_box_as_a_hull_keep_their_ids_on_every_reference() {
    // A slope that trembles about the angle where the reference face changes from one shape to the other.
    let hull: Vec<Vec3> = (0..8)
        .map(|i| {
            let sign = |bit: u32| if i >> bit & 1 == 1 { 0.5 } else { -0.5 };
            Vec3::new(sign(0), sign(1), sign(2))
        })
        .collect();
    let hull = Geometry::ConvexHull(std::sync::Arc::new(ishigaki::ConvexHull::new(&hull).unwrap()));
    let tremble = |t: f32| {
        let turn = Quat::from_rotation_y(0.3) * Quat::from_rotation_x(2e-3 * ((600.0 * t) as f64).sin() as f32);
        Pose::from_parts(Vec3::new(0.2, 0.995, 0.1), turn)
    };
    for b in [&cuboid(0.5, 0.5, 0.5), &hull] {
        let rate = match_rate(&cuboid(0.5, 0.5, 0.5), b, 300, tremble);
        assert!(rate > 0.95, "{rate}");
    }
}

#[test]
fn the_other_reference_face_gives_the_same_ids() {
    let (a, b) = (cuboid(0.5, 0.5, 0.5), cuboid(0.4, 0.3, 0.6));
    let mut same = 0;
    for step in 0..1000 {
        let turn = Quat::from_rotation_y(0.0031 * step as f32 + 0.017);
        let pose = Pose::from_parts(Vec3::new(0.123, 0.797, -0.217), turn);
        let mut now = ids(&a, &b, &pose, &mut PairMemory::default());
        // Of equally good faces the first shape's is the reference: the other order has the other reference.
        let mut other: Vec<_> =
            ids(&b, &a, &pose.inverse(), &mut PairMemory::default()).into_iter().map(FeatureId::swapped).collect();
        now.sort();
        other.sort();
        same += usize::from(now == other);
    }
    // Only where a corner lies within the tolerance of a border may its name depend on the reference.
    assert!(same > 980, "{same} of 1000");
}
