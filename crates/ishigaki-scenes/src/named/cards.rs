//! Thin things on edge: cards, dominoes, planks.

use super::Builder;
use crate::file::SceneFile;
use ishigaki::math::{asin, cos};
use ishigaki::{Body, Quat, Shape, Vec3};

/// Cards are ten times as large as playing cards: 0.88 × 0.63 m, 0.03 m thick, 800 kg/m³ = 13.3 kg, friction 0.7;
/// the length scale is 0.25 m, so that the slop is 1/24 of a card's thickness. Cards overlap by the slop where they
/// touch: a house that sinks by the slop at each floor would not stand, by its thin cards' measure.
///
/// A floor is a row of leaning pairs, 0.89 m from pair to pair, and level cards from ridge to ridge, which carry the
/// next floor, one pair fewer. Cards lean by 20° (sin = 0.342), so that the feet of a pair stand on the level card
/// below it: a leaning card thrusts by at most tan 20° = 0.36 of its load, below the friction. `floors` floors have
/// floors (3 floors + 1)/2 cards.
pub fn card_house(floors: usize) -> SceneFile {
    const LENGTH: f32 = 0.88;
    const THICK: f32 = 0.03;
    const SPACING: f32 = 0.89;
    const LENGTH_SCALE: f32 = 0.25;
    let size = floors as f32;
    let mut scene = Builder::on_ground(10, [0.0, 0.5 * size + 0.5, 1.2 * size + 2.0], [0.0, 0.4 * size, 0.0]);
    scene.file.options.length_scale = LENGTH_SCALE;
    let overlap = scene.file.options.solver.slop.depth * LENGTH_SCALE;
    scene.file.bodies[0].shapes[0].friction = 0.7;
    let card = Body::dynamic(Shape::cuboid(0.5 * THICK, 0.5 * LENGTH, 0.315).density(800.0).friction(0.7));
    let level = Body::dynamic(Shape::cuboid(0.5 * LENGTH, 0.5 * THICK, 0.315).density(800.0).friction(0.7));
    let sine = 0.342;
    let lean = asin(sine);
    let (sine_half, cosine) = (ishigaki::math::sin(0.5 * lean), cos(lean));
    // Half the height and width of a leaning card's bounds.
    let half_height = 0.5 * (LENGTH * cosine + THICK * sine);
    let half_width = 0.5 * (LENGTH * sine + THICK * cosine);
    let ridge = 2.0 * half_height - overlap;
    let floor_height = ridge + THICK - overlap;
    for floor in 0..floors {
        let pairs = floors - floor;
        let bottom = floor as f32 * floor_height;
        for i in 0..pairs {
            let x = SPACING * (i as f32 - 0.5 * (pairs - 1) as f32);
            for side in [-1.0, 1.0] {
                // The card on the right leans to the left, counter-clockwise about z.
                let rotation = Quat::from_xyzw(0.0, 0.0, side * sine_half, cos(0.5 * lean));
                let center = Vec3::new(x + side * (half_width - 0.5 * overlap), bottom + half_height - overlap, 0.0);
                scene.add(card.clone().at(center).rotated(rotation));
            }
            if i + 1 < pairs {
                let center = Vec3::new(x + 0.5 * SPACING, bottom + ridge + 0.5 * THICK - overlap, 0.0);
                scene.add(level.clone().at(center));
            }
        }
    }
    scene.finish()
}

/// Dominoes of 0.2 × 1 × 0.5 m, 100 kg, 0.6 m from one to the next along x; the first turns about its front lower
/// edge at 2 rad/s, about seven times the energy it takes to fall.
pub fn dominoes(n: usize) -> SceneFile {
    let length = 0.6 * n as f32;
    let mut scene = Builder::on_ground(10, [0.2 * length, 0.25 * length + 2.0, 0.6 * length + 3.0], [0.0, 0.5, 0.0]);
    for k in 0..n {
        let x = 0.6 * (k as f32 - 0.5 * (n as f32 - 1.0));
        let mut domino = Body::dynamic(Shape::cuboid(0.1, 0.5, 0.25)).at(Vec3::new(x, 0.5, 0.0));
        if k == 0 {
            let turn = Vec3::new(0.0, 0.0, -2.0);
            domino = domino.angular_velocity(turn).velocity(turn.cross(Vec3::new(-0.1, 0.5, 0.0))).named("first");
        }
        scene.add(domino);
    }
    scene.finish()
}

/// `n` planks of 1 × 0.1 × 0.5 m, 50 kg, on a fixed table (`table`, 1 m high, its edge at x = 0); the k-th from the
/// top hangs out over the one below it by `fraction`/(2k) m, the lowest over the table's edge.
///
/// The length scale is 0.25 m: the slop of ten planks is less than the ¼ of a plank's height that a stack may move.
/// The k planks from the top down have their common center 1/(2k) m inside the end of the next: below fraction 1
/// the stack stands, above 1 it tips at every level at once.
pub fn overhang(n: usize, fraction: f32) -> SceneFile {
    let mut scene =
        Builder::on_ground(10, [1.0, 2.0 + 0.05 * n as f32, 3.0 + 0.1 * n as f32], [0.5, 1.0 + 0.05 * n as f32, 0.0]);
    scene.file.options.length_scale = 0.25;
    scene.add(Body::fixed(Shape::cuboid(1.0, 0.5, 1.0)).at(Vec3::new(-1.0, 0.5, 0.0)).named("table"));
    let mut end = 0.0;
    for level in 0..n {
        end += fraction / (2 * (n - level)) as f32;
        let center = Vec3::new(end - 0.5, 1.05 + 0.1 * level as f32, 0.0);
        scene.add(Body::dynamic(Shape::cuboid(0.5, 0.05, 0.25)).at(center));
    }
    scene.finish()
}
