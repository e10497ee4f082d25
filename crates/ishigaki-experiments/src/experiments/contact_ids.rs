//! D4: a warm start needs contacts that keep their names.

use crate::chart::Chart;
use crate::setup::{DT, plain, world};
use crate::{Experiment, Lab, Result, Verdict};
use ishigaki::{Body, Quat, Shape, Vec3, World};

pub const EXPERIMENT: Experiment = Experiment {
    name: "contact-ids",
    rows: &["D4"],
    title: "Contact points that are found again by their semantic id",
    run,
};

/// Part of the points found again in each tenth of a second, and in all.
fn rates(world: &mut World, steps: usize) -> (Vec<(f64, f64)>, f64) {
    let (mut curve, mut all, mut part) = (Vec::new(), (0, 0), (0, 0));
    for step in 1..=steps {
        let report = world.step(DT);
        for sum in [&mut all, &mut part] {
            *sum = (sum.0 + report.ids_matched, sum.1 + report.ids_expected);
        }
        if step % 6 == 0 {
            if part.1 > 0 {
                curve.push((world.time(), 100.0 * part.0 as f64 / part.1 as f64));
            }
            part = (0, 0);
        }
    }
    (curve, 100.0 * all.0 as f64 / all.1.max(1) as f64)
}

fn empty(friction: f32, slope: f32) -> Result<World> {
    let mut world = world(plain(|s| {
        (s.substeps, s.warm_start.enabled, s.slop.enabled, s.penetration_recovery.enabled) = (4, true, true, true);
    }))?;
    // A large box, so that there are features to name on both sides.
    let floor = Body::fixed(Shape::cuboid(50.0, 1.0, 50.0).friction(friction)).rotated(Quat::from_rotation_z(-slope));
    let (sine, cosine) = f64::from(slope).sin_cos();
    world.add_body(floor.at(-Vec3::new(sine as f32, cosine as f32, 0.0)))?;
    Ok(world)
}

type Make = fn() -> Result<World>;

const CASES: [(&str, Make); 5] = [
    ("sliding box", || {
        let mut world = empty(0.05, 0.0)?;
        let sled = Body::dynamic(Shape::cuboid(0.5, 0.25, 0.5).friction(0.05)).at(Vec3::new(-20.0, 0.25, 0.0));
        world.add_body(sled.velocity(Vec3::new(4.0, 0.0, 1.0)))?;
        Ok(world)
    }),
    ("sliding and turning box", || {
        let mut world = empty(0.1, 0.0)?;
        let sled = Body::dynamic(Shape::cuboid(0.5, 0.25, 0.5).friction(0.1)).at(0.25 * Vec3::Y);
        world.add_body(sled.velocity(2.0 * Vec3::X).angular_velocity(2.0 * Vec3::Y))?;
        Ok(world)
    }),
    ("box that rolls over its edges", || {
        let mut world = empty(0.8, 0.5)?;
        let cube = Body::dynamic(Shape::cuboid(0.5, 0.5, 0.5).friction(0.8)).at(Vec3::new(-30.0, 17.5, 0.0));
        world.add_body(cube.angular_velocity(-3.0 * Vec3::Z).velocity(2.0 * Vec3::X))?;
        Ok(world)
    }),
    ("rolling ball", || {
        let mut world = empty(0.6, 0.0)?;
        world.add_body(Body::dynamic(Shape::ball(0.5)).at(0.5 * Vec3::Y).velocity(3.0 * Vec3::X))?;
        Ok(world)
    }),
    ("settling stack of 8", || {
        let mut world = empty(0.6, 0.0)?;
        for i in 0..8 {
            // Dropped from 2 cm onto each other, a little aside.
            let place = Vec3::new(0.03 * (i % 3) as f32, 0.52 + 1.02 * i as f32, 0.02 * (i % 2) as f32);
            world.add_body(Body::dynamic(Shape::cuboid(0.5, 0.5, 0.5)).at(place))?;
        }
        Ok(world)
    }),
];

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let steps = lab.choose(300, 90);
    let mut chart =
        Chart::curves("Points found again, of those of pairs that had points before", "time, s", "found again, %")
            .y_range(0.0, 105.0);
    let mut verdict = Verdict::on("contacts are found again by the features that touch, joints trivially");
    for (i, (name, make)) in CASES.iter().enumerate() {
        lab.progress(i as f64 / CASES.len() as f64, name);
        let (curve, all) = rates(&mut make()?, steps);
        verdict = verdict.at_least(*name, "%", 95.0, all);
        chart = chart.line(*name, curve);
    }
    lab.chart(chart.level(95.0, "95 %"));
    Ok(verdict)
}
