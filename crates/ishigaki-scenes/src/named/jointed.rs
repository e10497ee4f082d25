//! Bodies held by joints.

use super::Builder;
use crate::file::{BodyRef, DriveFile, FrameFile, FramesFile, JointFile, JointKindFile, SceneFile};
use ishigaki::math::{cos, sin};
use ishigaki::{Body, BodyKind, Quat, Shape, Vec3};

/// A ball joint without limits at a world point.
pub(super) fn ball(a: impl Into<BodyRef>, b: impl Into<BodyRef>, anchor: Vec3) -> JointFile {
    let kind = JointKindFile::Ball { cone: None, twist: None, friction: 0.0, damping: 0.0 };
    JointFile::new(a, b, kind, FramesFile::World(FrameFile::at(anchor)))
}

fn hinge(a: usize, b: usize, anchor: Vec3, axis: Vec3) -> JointFile {
    let frame = FramesFile::World(FrameFile::about(anchor, axis));
    JointFile::new(a, b, JointKindFile::Hinge(DriveFile::default()), frame)
}

/// Mass of a link of [`chain`], kg: a cylinder 0.8 m long and a ball, both of radius 0.1 m, 1000 kg/m³.
pub(super) const LINK_MASS: f32 = 1000.0 * std::f32::consts::PI * 0.01 * (0.8 + 4.0 / 3.0 * 0.1);

/// `links` capsules 1 m long over all, radius 0.1 m, 29.3 kg, joined tip to tip by ball joints, from a fixed ball
/// (`hook`) at the origin downwards, or along x if it shall `swing`; at the last tip hangs a ball (`end`) of radius
/// 0.3 m and `end_mass_ratio` × the mass of a link, its surface at the tip. No ground.
pub fn chain(links: usize, end_mass_ratio: f32, swing: bool) -> SceneFile {
    let length = links as f32;
    let mut scene = Builder::new(10, [0.0, -0.4 * length, 1.4 * length + 4.0], [0.0, -0.5 * length, 0.0]);
    let hook = scene.add(Body::fixed(Shape::ball(0.1)).named("hook"));
    let (along, rotation) = if swing {
        let half = std::f32::consts::FRAC_1_SQRT_2;
        // A quarter turn about z takes the capsule's y axis to −x.
        (Vec3::X, Quat::from_xyzw(0.0, 0.0, half, half))
    } else {
        (Vec3::NEG_Y, Quat::IDENTITY)
    };
    let mut last = hook;
    for k in 0..links {
        let center = (k as f32 + 0.5) * along;
        let link = scene.add(Body::dynamic(Shape::capsule(0.4, 0.1)).at(center).rotated(rotation));
        scene.join(ball(last, link, k as f32 * along));
        last = link;
    }
    let end = Body::dynamic(Shape::ball(0.3)).mass(end_mass_ratio * LINK_MASS);
    let end = scene.add(end.at((length + 0.3) * along).named("end"));
    scene.join(ball(last, end, length * along));
    scene.finish()
}

/// `n` × `n` balls of radius 0.4 m, 268 kg, 1 m apart in a level net, each tied to its neighbors by ball joints half
/// way; those of the first row (z = 0) are fixed. The balls do not touch each other. No ground.
pub fn joint_grid(n: usize) -> SceneFile {
    let size = n as f32;
    let mut scene = Builder::new(10, [0.9 * size, 0.2 * size, 1.4 * size], [0.0, -0.4 * size, 0.3 * size]);
    let at = |row: usize, column: usize| Vec3::new(column as f32 - 0.5 * (size - 1.0), 0.0, row as f32);
    let mut grid = Vec::with_capacity(n * n);
    for row in 0..n {
        for column in 0..n {
            let kind = if row == 0 { BodyKind::Fixed } else { BodyKind::Dynamic };
            let shape = Shape::ball(0.4).groups(2, 1);
            grid.push(scene.add(Body::new(kind, shape).at(at(row, column))));
        }
    }
    for row in 0..n {
        for column in 0..n {
            let here = grid[row * n + column];
            // Two fixed bodies need no joint.
            if column + 1 < n && row > 0 {
                scene.join(ball(here, grid[row * n + column + 1], at(row, column) + 0.5 * Vec3::X));
            }
            if row + 1 < n {
                scene.join(ball(here, grid[(row + 1) * n + column], at(row, column) + 0.5 * Vec3::Z));
            }
        }
    }
    scene.finish()
}

/// `planks` planks of 0.9 × 0.2 × 2 m, 500 kg/m³ = 180 kg, 1 m from one to the next along an arc of 0.8 rad that sags
/// between two fixed blocks (`left`, `right`), 5 m above the ground; hinged in the middle of the gaps and at the ends,
/// and damped by .5/s, as wood and rope are; three cubes of 0.5 m, 62.5 kg each, lie at ¼, ½ and ¾ of the way.
pub fn bridge(planks: usize) -> SceneFile {
    const HEIGHT: f32 = 5.0;
    const HALF_ARC: f32 = 0.4;
    let count = planks as f32;
    let mut scene = Builder::on_ground(10, [0.0, HEIGHT + 3.0, 0.8 * count + 6.0], [0.0, HEIGHT - 1.0, 0.0]);
    let step = 2.0 * HALF_ARC / count;
    let radius = 0.5 / sin(0.5 * step);
    let on_arc = |angle: f32, inward: f32| {
        let r = radius - inward;
        Vec3::new(r * sin(angle), HEIGHT + radius * cos(HALF_ARC) - r * cos(angle), 0.0)
    };
    let joint_at = |k: usize| on_arc(step * k as f32 - HALF_ARC, 0.0);
    let block = |x| Body::fixed(Shape::cuboid(1.0, 0.1, 1.0)).at(Vec3::new(x, HEIGHT, 0.0));
    let end = radius * sin(HALF_ARC) + 1.05;
    let mut last = scene.add(block(-end).named("left"));
    let turned = |angle: f32| Quat::from_xyzw(0.0, 0.0, sin(0.5 * angle), cos(0.5 * angle));
    for k in 0..planks {
        let center = 0.5 * (joint_at(k) + joint_at(k + 1));
        let plank = Body::dynamic(Shape::cuboid(0.45, 0.1, 1.0)).density(500.0).damping(0.5, 0.5);
        let plank = scene.add(plank.at(center).rotated(turned(step * (k as f32 + 0.5) - HALF_ARC)));
        scene.join(hinge(last, plank, joint_at(k), Vec3::Z));
        last = plank;
    }
    let right = scene.add(block(end).named("right"));
    scene.join(hinge(last, right, joint_at(planks), Vec3::Z));
    for part in [0.25, 0.5, 0.75] {
        // In the middle of a plank, whose upper side is .1 m inside its chord.
        let k = (part * count).floor().min(count - 1.0);
        let angle = step * (k + 0.5) - HALF_ARC;
        let sagitta = radius * (1.0 - cos(0.5 * step));
        let center = on_arc(angle, sagitta + 0.1 + 0.25);
        let cube = Body::dynamic(Shape::cuboid(0.25, 0.25, 0.25)).density(500.0);
        scene.add(cube.at(center).rotated(turned(angle)));
    }
    scene.finish()
}

/// `balls` steel balls (7800 kg/m³) of radius 0.1 m, 1 mm apart along x, each on a string of 1 m from a fixed body
/// (`beam`, y = 2 m) to its center; the first is drawn aside by 30° toward −x. Restitution 1, no friction.
///
/// Strings, not rigid arms: a ball on an arm that is hit must turn, which costs it 0.4 % of its speed at each blow.
pub fn newtons_cradle(balls: usize) -> SceneFile {
    const SPACING: f32 = 0.201;
    let mut scene = Builder::new(10, [0.0, 1.5, 2.0 + 0.3 * balls as f32], [0.0, 1.3, 0.0]);
    let above = 2.0 * Vec3::Y;
    let beam = scene.add(Body::empty(BodyKind::Fixed).at(above).named("beam"));
    let shape = Shape::ball(0.1).density(7800.0).friction(0.0).restitution(1.0);
    for k in 0..balls {
        let hook = SPACING * (k as f32 - 0.5 * (balls as f32 - 1.0)) * Vec3::X;
        let angle = if k == 0 { -std::f32::consts::FRAC_PI_6 } else { 0.0 };
        let center = above + hook + Vec3::new(sin(angle), -cos(angle), 0.0);
        let ball = scene.add(Body::dynamic(shape.clone()).at(center));
        let string = JointKindFile::Distance { lower: 1.0, upper: Some(1.0), spring: None };
        let ends = FramesFile::Local { a: FrameFile::at(hook), b: FrameFile::default() };
        scene.join(JointFile::new(beam, ball, string, ends));
    }
    scene.finish()
}
