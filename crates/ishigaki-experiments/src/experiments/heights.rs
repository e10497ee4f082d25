//! D5: the height of a body is its distance from the ground in hops over contacts.

use crate::chart::Chart;
use crate::setup::{DT, add_ground, body, cube, plain, run as advance, world};
use crate::{Experiment, Lab, Result, Verdict};
use ishigaki::{Body, BodyKind, Height, Joint, Shape, Vec3};

pub const EXPERIMENT: Experiment = Experiment {
    name: "heights",
    rows: &["D5"],
    title: "Heights: hops over contacts to a fixed or kinematic body",
    run,
};

fn text(height: Option<u32>) -> (f64, String) {
    (height.map_or(0.0, f64::from), height.map_or_else(|| "none".to_string(), |h| h.to_string()))
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    const BASE: usize = 6;
    let mut world_a = world(plain(|_| {}))?;
    add_ground(&mut world_a)?;
    let mut pyramid = Vec::new();
    for row in 0..BASE {
        let cubes = BASE - row;
        let mut boxes = Vec::new();
        for i in 0..cubes {
            let place = Vec3::new(i as f32 - 0.5 * (cubes - 1) as f32, row as f32 + 0.5, 0.0);
            boxes.push(world_a.add_body(cube(place))?);
        }
        pyramid.push(boxes);
    }
    world_a.step(DT);
    let columns = (1..=BASE).map(|i| format!("box {i}"));
    let (mut table, mut wrong) = (Chart::table("A pyramid: heights of its boxes, row by row", "hops", columns), 0.0);
    for (row, boxes) in pyramid.iter().enumerate().rev() {
        let mut cells = Vec::new();
        for &b in boxes {
            let height = body(&world_a, b)?.height();
            wrong += f64::from(u8::from(height != Some(row as u32 + 1)));
            cells.push(text(height));
        }
        cells.resize(BASE, (0.0, " ".to_string()));
        table = table.row(format!("row {}", row + 1), cells);
    }
    lab.chart(table);

    let mut b = world(plain(|_| {}))?;
    let ground = add_ground(&mut b)?;
    let lift = b.add_body(Body::kinematic(Shape::cuboid(1.0, 0.5, 1.0)).at(Vec3::new(5.0, 0.5, 0.0)))?;
    let load = b.add_body(cube(Vec3::new(5.0, 1.5, 0.0)))?;
    let ball = b.add_body(Body::dynamic(Shape::ball(0.5)).at(Vec3::new(-5.0, 1.0, 0.0)))?;
    let hook = b.add_body(Body::empty(BodyKind::Fixed).at(Vec3::new(0.0, 9.0, 0.0)))?;
    let bob = b.add_body(Body::dynamic(Shape::ball(0.1)).at(Vec3::new(0.0, 8.0, 0.0)))?;
    b.add_joint(Joint::ball(hook, bob, Vec3::new(0.0, 9.0, 0.0)))?;
    b.step(DT);
    let cases = [
        ("ground", ground),
        ("kinematic lift", lift),
        ("on the lift", load),
        ("ball in the air", ball),
        ("hangs on a joint", bob),
    ];
    let first: Vec<Option<u32>> = cases.iter().map(|(_, h)| b.body(*h).and_then(|s| s.height())).collect();
    advance(&mut b, 60);
    let later: Vec<Option<u32>> = cases.iter().map(|(_, h)| b.body(*h).and_then(|s| s.height())).collect();
    crate::setup::change_options(&mut b, |o| o.solver.height = Height { through_joints: true })?;
    b.step(DT);
    let joints: Vec<Option<u32>> = cases.iter().map(|(_, h)| b.body(*h).and_then(|s| s.height())).collect();
    let table = Chart::table("Other bodies", "hops", cases.iter().map(|c| c.0))
        .row("at first", first.iter().map(|h| text(*h)))
        .row("a second later", later.iter().map(|h| text(*h)))
        .row("joints are hops too", joints.iter().map(|h| text(*h)));
    lab.chart(table);
    let expected = [
        [Some(0), Some(0), Some(1), None, None],
        [Some(0), Some(0), Some(1), Some(1), None],
        [Some(0), Some(0), Some(1), Some(1), Some(1)],
    ];
    let found = [first, later, joints];
    let others = found.iter().flatten().zip(expected.iter().flatten()).filter(|(a, b)| a != b).count() as f64;
    Ok(Verdict::on("the height of a body is its shortest distance, in hops over contacts, to a fixed body")
        .at_most("boxes of a pyramid with a wrong height", "", 0.0, wrong)
        .at_most("other bodies with a wrong height", "", 0.0, others))
}
