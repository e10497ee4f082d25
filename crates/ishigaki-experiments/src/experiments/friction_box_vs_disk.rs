//! C2: two tangents bounded each for itself are a box; Coulomb's law is a disk.

use crate::chart::{Chart, Mark};
use crate::setup::{DT, G, body, plain, world};
use crate::{Experiment, Lab, Result, Verdict};
use ishigaki::{Body, FrictionModel, Shape, Vec3};

pub const EXPERIMENT: Experiment = Experiment {
    name: "friction-box-vs-disk",
    rows: &["C2"],
    title: "A block of 100 kg on the ground, μ = 0.5, pushed with 1.2 μN for a second",
    run,
};

const MU: f32 = 0.5;

/// Speed (m/s) and direction (degrees) after a push along `angle` (degrees from the first tangent).
fn pushed(model: FrictionModel, angle: f64) -> Result<(f64, f64)> {
    let mut world = world(plain(|s| {
        s.friction = model;
        s.warm_start.enabled = true;
        s.sweeps = 30;
    }))?;
    world.add_body(Body::fixed(Shape::half_space(Vec3::Y).friction(MU)))?;
    let slab = Shape::cuboid(0.5, 0.05, 0.5).friction(MU);
    let block = world.add_body(Body::dynamic(slab).mass(100.0).at(0.05 * Vec3::Y))?;
    let (t1, t2) = ishigaki::math::tangents(Vec3::Y);
    let (sine, cosine) = angle.to_radians().sin_cos();
    let push = 1.2 * MU * 100.0 * G * (cosine as f32 * t1 + sine as f32 * t2);
    for _ in 0..60 {
        if let Some(mut block) = world.body_mut(block) {
            block.apply_force(push)?;
        }
        world.step(DT);
    }
    let velocity = body(&world, block)?.velocity();
    let (x, y) = (f64::from(velocity.dot(t1)), f64::from(velocity.dot(t2)));
    Ok((x.hypot(y), y.atan2(x).to_degrees()))
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let step = lab.choose(2.5, 22.5);
    let count = (90.0 / step) as usize;
    let mut seen = Vec::new();
    for (i, model) in [FrictionModel::Disk, FrictionModel::Box].into_iter().enumerate() {
        let mut curve = Vec::new();
        for k in 0..=count {
            lab.progress((i as f64 + k as f64 / count as f64) / 2.0, "pushing");
            let angle = step * k as f64;
            let (speed, direction) = pushed(model, angle)?;
            curve.push((angle, speed, direction));
        }
        seen.push(curve);
    }
    let speeds = |i: usize| seen[i].iter().map(|s| (s.0, s.1)).collect::<Vec<_>>();
    // What does not move has no direction.
    let directions = |i: usize| seen[i].iter().filter(|s| s.1 > 1e-3).map(|s| (s.0, s.2)).collect::<Vec<_>>();
    let g = f64::from(G) * f64::from(MU);
    lab.chart(
        Chart::curves("Speed after a second", "direction of the push from the first tangent, °", "speed, m/s")
            .series("disk", Mark::Dotted, speeds(0))
            .series("box", Mark::Dotted, speeds(1))
            .level(0.2 * g, "0.2 μg: Coulomb")
            .y_range(-0.02, 1.12),
    );
    lab.chart(
        Chart::curves("Direction of the motion", "direction of the push from the first tangent, °", "direction, °")
            .series("disk", Mark::Dotted, directions(0))
            .series("box", Mark::Points, directions(1))
            .series("along the push", Mark::Dashed, vec![(0.0, 0.0), (90.0, 90.0)]),
    );
    let (disk_45, disk_22) = (pushed(FrictionModel::Disk, 45.0)?, pushed(FrictionModel::Disk, 22.5)?);
    let (box_45, box_22) = (pushed(FrictionModel::Box, 45.0)?, pushed(FrictionModel::Box, 22.5)?);
    Ok(Verdict::on("−λ_fric ≤ λ_t ≤ λ_fric on each of two tangents; λ_fric is not defined on the slide, we use μλ_n")
        .near("disk pushed at 45°: speed", "m/s", 0.2 * g, 0.03, disk_45.0)
        .at_most("box pushed at 45°: speed", "m/s", 1e-3, box_45.0)
        .near("disk pushed at 22.5°: direction", "°", 22.5, 0.5, disk_22.1)
        .near("box pushed at 22.5°: direction", "°", 0.0, 0.5, box_22.1)
        .note(
            "The box overestimates friction by up to √2 and makes sliding bend toward its axes: the disk is \
            the default.",
        ))
}
