//! Single bodies that show a law.

use super::Builder;
use super::jointed::ball;
use crate::file::SceneFile;
use ishigaki::math::{cos, sin};
use ishigaki::{Body, BodyKind, MassProperties, Quat, Shape, Vec3};

/// A free body (`body`) of 1 kg with principal inertia (1, 2, 3) kg·m², turning at (0.1, 10, 0.1) rad/s, without
/// gravity: it flips about its middle axis every 1.95529 s. Its shape, a plate, is for the eye.
pub fn dzhanibekov() -> SceneFile {
    let mut scene = Builder::new(20, [4.0, 3.0, 7.0], [0.0, 0.0, 0.0]);
    scene.file.options.gravity = Vec3::ZERO;
    let properties = MassProperties {
        mass: 1.0,
        center: Vec3::ZERO,
        principal_inertia: Vec3::new(1.0, 2.0, 3.0),
        principal_frame: Quat::IDENTITY,
    };
    // A plate of sides 2√6 and 2√3 has these moments.
    let body = Body::dynamic(Shape::cuboid(2.449, 1.732, 0.02)).mass_properties(properties);
    scene.add(body.angular_velocity(Vec3::new(0.1, 10.0, 0.1)).sleepless().named("body"));
    scene.finish()
}

/// A top (`top`) of 1 kg on a ball joint at its tip, the origin: center 0.2 m from the tip, inertia about the center
/// 0.02 kg·m² about its axis and 0.0125 across, leaning 0.35 rad toward +x, spinning at 60 rad/s about its axis.
///
/// It starts in the slow regular precession: Ω about the vertical solves
/// I₁ Ω² cosθ − I₃ ω₃ Ω + m g d = 0 with I₁ = 0.0525 about the tip, so Ω = 1.763 rad/s, a turn in 3.56 s.
pub fn spinning_top() -> SceneFile {
    const D: f32 = 0.2;
    const AXIAL: f32 = 0.02;
    const ACROSS: f32 = 0.0125;
    const SPIN: f32 = 60.0;
    let lean = 0.35;
    let mut scene = Builder::new(10, [0.5, 0.5, 1.0], [0.0, 0.15, 0.0]);
    let stand = scene.add(Body::empty(BodyKind::Fixed).named("stand"));
    let properties = MassProperties {
        mass: 1.0,
        center: D * Vec3::Y,
        principal_inertia: Vec3::new(ACROSS, AXIAL, ACROSS),
        principal_frame: Quat::IDENTITY,
    };
    let weight = -scene.file.options.gravity.y;
    let about_tip = (ACROSS + D * D) * cos(lean);
    let momentum = AXIAL * SPIN;
    let precession = (momentum - (momentum * momentum - 4.0 * about_tip * weight * D).sqrt()) / (2.0 * about_tip);
    let axis = Vec3::new(sin(lean), cos(lean), 0.0);
    let angular_velocity = precession * Vec3::Y + (SPIN - precession * cos(lean)) * axis;
    // A cone on its tip: half a turn about x, and up by half its height.
    let cone =
        Shape::cone(0.12, 0.15).posed(ishigaki::Pose::from_parts(0.12 * Vec3::Y, Quat::from_xyzw(1.0, 0.0, 0.0, 0.0)));
    let top = Body::dynamic(cone)
        .mass_properties(properties)
        .rotated(Quat::from_xyzw(0.0, 0.0, -sin(0.5 * lean), cos(0.5 * lean)))
        .angular_velocity(angular_velocity)
        .velocity(angular_velocity.cross(D * axis));
    let top = scene.add(top.sleepless().named("top"));
    scene.join(ball(stand, top, Vec3::ZERO));
    scene.finish()
}

/// A fixed half-space (`slope`) through the origin that falls toward +x by `angle` degrees, and on it a block
/// (`block`) of 1 × 0.2 × 1 m, 200 kg, at rest; both have `friction`. Flat, so that it slides before it tips.
///
/// It slides where tan(angle) > friction, with acceleration g (sin − friction · cos).
pub fn sliding_block(angle: f32, friction: f32) -> SceneFile {
    let angle = angle * (std::f32::consts::PI / 180.0);
    let mut scene = Builder::new(5, [3.0, 3.0, 8.0], [3.0, -1.0, 0.0]);
    let normal = Vec3::new(sin(angle), cos(angle), 0.0);
    scene.add(Body::fixed(Shape::half_space(normal).friction(friction)).named("slope"));
    let block = Body::dynamic(Shape::cuboid(0.5, 0.1, 0.5).friction(friction));
    let rotation = Quat::from_xyzw(0.0, 0.0, -sin(0.5 * angle), cos(0.5 * angle));
    scene.add(block.at(0.1 * normal).rotated(rotation).named("block"));
    scene.finish()
}
