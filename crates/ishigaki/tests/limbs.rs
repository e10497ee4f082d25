//! A limb that lies on the ground with one end, and is hit on the other, is not driven into the ground.
use ishigaki::collision::narrow_phase::{LocalManifolds, find_manifolds};
use ishigaki::collision::pair_memory::PairMemory;
use ishigaki::*;

const RADIUS: f32 = 0.055;
const HALF_LENGTH: f32 = 0.185;

/// The deepest that an end of the limb was below the ground, m, at `steps_per_second`.
fn depth_when_hit(tilt: f32, speed: f32, steps_per_second: f32) -> f32 {
    let mut world = World::default();
    world.add_body(Body::fixed(Shape::half_space(Vec3::Y))).unwrap();
    let along = Vec3::new((1.0 - tilt * tilt).sqrt(), tilt, 0.0);
    let limb = Body::dynamic(Shape::capsule(HALF_LENGTH, RADIUS))
        .mass(4.4)
        .at(Vec3::Y * (RADIUS + HALF_LENGTH * tilt))
        .rotated(Quat::from_rotation_arc(Vec3::Y, along));
    let limb = world.add_body(limb).unwrap();
    // Just above the higher end.
    let high = Vec3::Y * (RADIUS + 2.0 * HALF_LENGTH * tilt) + Vec3::X * HALF_LENGTH * along.x;
    let fist =
        Body::dynamic(Shape::ball(0.14)).mass(22.0).at(high + Vec3::Y * (RADIUS + 0.15)).velocity(Vec3::NEG_Y * speed);
    world.add_body(fist).unwrap();
    let mut deepest = 0.0_f32;
    for _ in 0..(0.2 * steps_per_second) as usize {
        world.step(1.0 / steps_per_second);
        let limb = world.body(limb).unwrap();
        let half = limb.rotation() * (HALF_LENGTH * Vec3::Y);
        let lowest = (limb.position() + half).y.min((limb.position() - half).y) - RADIUS;
        deepest = deepest.max(-lowest);
    }
    deepest
}

#[test]
fn what_hits_a_limb_does_not_drive_it_into_the_ground() {
    for steps_per_second in [60.0, 120.0, 240.0] {
        for tilt in [0.1, 0.2, 0.3, 0.4] {
            for speed in [5.0, 10.0] {
                let depth = depth_when_hit(tilt, speed, steps_per_second);
                assert!(depth < RADIUS, "tilt {tilt}, {speed} m/s, {steps_per_second} Hz: {} mm", 1e3 * depth);
            }
        }
    }
}

/// Tilted by asin(rise / length), its higher end is `rise` above the lower one.
#[test]
fn a_capsule_near_a_half_space_has_points_at_both_ends() {
    let (half_length, radius) = (0.2, 0.05);
    let (floor, capsule) = (Geometry::HalfSpace { normal: Vec3::Y }, Geometry::Capsule { half_length, radius });
    for (rise, lowest, ends) in
        [(0.0, 0.0, 2), (0.1, -0.01, 2), (0.18, 0.019, 2), (0.25, 0.0, 1), (0.4, 0.0, 1), (0.1, 0.021, 0)]
    {
        let sine = rise / (2.0 * half_length);
        let along = Vec3::new((1.0_f32 - sine * sine).sqrt(), sine, 0.0);
        let center = Vec3::Y * (lowest + radius + half_length * sine);
        let pose = Pose::from_parts(center, Quat::from_rotation_arc(Vec3::Y, along));
        let mut out = LocalManifolds::new();
        find_manifolds(&floor, &capsule, &pose, 0.02, 1.0, &mut PairMemory::default(), &mut out);
        let mut gaps: Vec<f32> = out.iter().flat_map(|m| &m.points).map(|p| p.separation).collect();
        gaps.sort_by(f32::total_cmp);
        assert_eq!(gaps.len(), ends, "rise {rise}: {gaps:?}");
        for (gap, expected) in gaps.iter().zip([lowest, lowest + rise]) {
            assert!((gap - expected).abs() < 1e-5, "rise {rise}: {gap} {expected}");
        }
    }
}
