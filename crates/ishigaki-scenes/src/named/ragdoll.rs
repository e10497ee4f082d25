//! People without will.

use super::{Builder, Random};
use crate::file::{FrameFile, FramesFile, JointFile, JointKindFile, LimitFile, SceneFile};
use ishigaki::math::{cos, sin};
use ishigaki::{Body, Pose, Quat, Shape, Vec3};

/// One limb: a capsule between two points, standing upright with the arms spread, feet at y = 0, facing +z.
struct Limb {
    name: &'static str,
    from: [f32; 3],
    to: [f32; 3],
    radius: f32,
    /// kg.
    mass: f32,
}

const fn limb(name: &'static str, from: [f32; 3], to: [f32; 3], radius: f32, mass: f32) -> Limb {
    Limb { name, from, to, radius, mass }
}

/// Eleven limbs, 1.76 m, 70 kg.
const LIMBS: [Limb; 11] = [
    limb("pelvis", [-0.08, 0.97, 0.0], [0.08, 0.97, 0.0], 0.11, 9.8),
    limb("torso", [0.0, 1.15, 0.0], [0.0, 1.36, 0.0], 0.14, 22.4),
    limb("head", [0.0, 1.60, 0.0], [0.0, 1.66, 0.0], 0.10, 5.6),
    limb("upper_arm_left", [0.22, 1.42, 0.0], [0.45, 1.42, 0.0], 0.045, 2.1),
    limb("lower_arm_left", [0.55, 1.42, 0.0], [0.78, 1.42, 0.0], 0.04, 1.6),
    limb("upper_arm_right", [-0.22, 1.42, 0.0], [-0.45, 1.42, 0.0], 0.045, 2.1),
    limb("lower_arm_right", [-0.55, 1.42, 0.0], [-0.78, 1.42, 0.0], 0.04, 1.6),
    limb("upper_leg_left", [0.1, 0.55, 0.0], [0.1, 0.86, 0.0], 0.075, 8.0),
    limb("lower_leg_left", [0.1, 0.07, 0.0], [0.1, 0.44, 0.0], 0.055, 4.4),
    limb("upper_leg_right", [-0.1, 0.55, 0.0], [-0.1, 0.86, 0.0], 0.075, 8.0),
    limb("lower_leg_right", [-0.1, 0.07, 0.0], [-0.1, 0.44, 0.0], 0.055, 4.4),
];

/// What a joint of the body can do.
enum Motion {
    /// A ball joint: the limb stays within a cone (half angle, rad) about its axis, and twists by so much either way.
    Cone(f32, f32),
    /// A ball joint too: bends about an axis from straight to an angle, rad, and a little beyond straight. Its cone is
    /// about the half-bent limb, so it also gives way sideways, as much as it is bent.
    Bend([f32; 3], f32),
}

/// Parent limb, child limb, anchor, the direction of the child from the anchor, range.
type LimbJoint = (usize, usize, [f32; 3], [f32; 3], Motion);

const JOINTS: [LimbJoint; 10] = [
    (0, 1, [0.0, 1.06, 0.0], [0.0, 1.0, 0.0], Motion::Cone(0.5, 0.5)),
    // The neck nods by 40° and does not turn backwards: 70° either way.
    (1, 2, [0.0, 1.50, 0.0], [0.0, 1.0, 0.0], Motion::Cone(0.7, 1.2)),
    (1, 3, [0.17, 1.42, 0.0], [1.0, 0.0, 0.0], Motion::Cone(1.5, 1.2)),
    (3, 4, [0.50, 1.42, 0.0], [1.0, 0.0, 0.0], Motion::Bend([0.0, -1.0, 0.0], 2.4)),
    (1, 5, [-0.17, 1.42, 0.0], [-1.0, 0.0, 0.0], Motion::Cone(1.5, 1.2)),
    (5, 6, [-0.50, 1.42, 0.0], [-1.0, 0.0, 0.0], Motion::Bend([0.0, 1.0, 0.0], 2.4)),
    (0, 7, [0.1, 0.91, 0.0], [0.0, -1.0, 0.0], Motion::Cone(1.2, 0.6)),
    (7, 8, [0.1, 0.49, 0.0], [0.0, -1.0, 0.0], Motion::Bend([1.0, 0.0, 0.0], 2.3)),
    (0, 9, [-0.1, 0.91, 0.0], [0.0, -1.0, 0.0], Motion::Cone(1.2, 0.6)),
    (9, 10, [-0.1, 0.49, 0.0], [0.0, -1.0, 0.0], Motion::Bend([1.0, 0.0, 0.0], 2.3)),
];

/// One ragdoll whose feet are 0.5 m above the ground, leaning forward by 0.2 rad: eleven capsules, 70 kg, 1.76 m,
/// friction 0.6, arms spread. All ten joints are ball joints with cone and twist limits (neck: cone 0.7 rad, twist
/// ±1.2 rad); the cones of elbows and knees are about the half-bent limb, so that they bend one way (2.4 and 2.3 rad,
/// 0.05 beyond straight). Each joint has a dry friction of 0.5 N·m. Limbs do not touch those they are joined to.
pub fn ragdoll() -> SceneFile {
    let mut scene = Builder::on_ground(10, [2.5, 2.0, 4.0], [0.0, 0.8, 0.0]);
    let lean = Quat::from_xyzw(sin(0.1), 0.0, 0.0, cos(0.1));
    add(&mut scene, Pose::from_parts(Vec3::new(0.0, 0.5, 0.0), lean), "");
    scene.finish()
}

/// `n` ragdolls as in [`ragdoll`], each turned at random in all directions, dropped from a grid of 2.4 m in layers of
/// k × k, k the least with 4 k² ≥ n, so that about four lie on each other; the lowest layer is centered 1.5 m above
/// the ground, the next 2.4 m higher. Seed 11. Names end in the ragdoll's number: `head_3`.
pub fn ragdolls(n: usize) -> SceneFile {
    const SPACING: f32 = 2.4;
    let mut columns = 1;
    while 4 * columns * columns < n {
        columns += 1;
    }
    let width = SPACING * columns as f32;
    let mut scene = Builder::on_ground(15, [0.8 * width + 3.0, 0.6 * width + 4.0, 1.2 * width + 5.0], [0.0, 1.0, 0.0]);
    let mut random = Random::new(11);
    for k in 0..n {
        let (layer, place) = (k / (columns * columns), k % (columns * columns));
        let middle = 0.5 * (columns as f32 - 1.0);
        let cell = Vec3::new((place % columns) as f32 - middle, layer as f32, (place / columns) as f32 - middle);
        let rotation = random.rotation();
        // Turn about the middle of the body, 0.9 m above the feet.
        let feet = SPACING * cell + 1.5 * Vec3::Y - rotation * (0.9 * Vec3::Y);
        add(&mut scene, Pose::from_parts(feet, rotation), &format!("_{k}"));
    }
    scene.finish()
}

fn add(scene: &mut Builder, world_from_doll: Pose, suffix: &str) {
    let poses = LIMBS.map(|l| {
        let (from, to) = (Vec3::from(l.from), Vec3::from(l.to));
        let along = (to - from).normalize_or_zero();
        world_from_doll * Pose::from_parts(0.5 * (from + to), Quat::from_rotation_arc(Vec3::Y, along))
    });
    let mut indices = [0; LIMBS.len()];
    for (i, (l, pose)) in LIMBS.iter().zip(poses).enumerate() {
        let capsule = Shape::capsule(0.5 * (Vec3::from(l.to) - Vec3::from(l.from)).length(), l.radius);
        indices[i] = scene.add(Body::dynamic(capsule).mass(l.mass).posed(pose).named(format!("{}{suffix}", l.name)));
    }
    for (parent, child, anchor, direction, motion) in &JOINTS {
        let (anchor, direction) = (Vec3::from(*anchor), Vec3::from(*direction));
        // The cone is about the parent's axis: the child's own, or that of the half-bent child.
        let (axis, kind) = match motion {
            Motion::Cone(cone, twist) => (direction, cone_kind(*cone, *twist)),
            Motion::Bend(about, most) => {
                let half = 0.5 * (most - BEYOND_STRAIGHT);
                let about = Vec3::from(*about) * sin(0.5 * half);
                let turn = Quat::from_xyzw(about.x, about.y, about.z, cos(0.5 * half));
                (turn * direction, cone_kind(0.5 * (most + BEYOND_STRAIGHT), BEND_TWIST))
            }
        };
        let child_frame = Pose::from_parts(anchor, Quat::from_rotation_arc(Vec3::X, direction));
        let arc = Quat::from_rotation_arc(direction, axis);
        let parent_frame = Pose::from_parts(anchor, arc * child_frame.rotation);
        let local = |limb: usize, frame: Pose| {
            let pose = poses[limb].inverse() * (world_from_doll * frame);
            FrameFile { position: pose.translation, rotation: Some(pose.rotation), axis: None }
        };
        let frames = FramesFile::Local { a: local(*parent, parent_frame), b: local(*child, child_frame) };
        scene.join(JointFile::new(indices[*parent], indices[*child], kind, frames));
    }
}

/// Dry friction of every joint, N·m: what makes a ragdoll die.
const JOINT_FRICTION: f32 = 0.5;
/// How far elbows and knees go beyond straight, rad.
const BEYOND_STRAIGHT: f32 = 0.05;
/// How far elbows and knees twist either way, rad.
const BEND_TWIST: f32 = 0.3;

fn cone_kind(cone: f32, twist: f32) -> JointKindFile {
    let twist = LimitFile { lower: Some(-twist), upper: Some(twist) };
    JointKindFile::Ball { cone: Some(cone), twist: Some(twist), friction: JOINT_FRICTION, damping: 0.0 }
}
