//! D10: resting pairs keep their Jacobians; the LCP's structure stops changing, and bodies are still simulated.

use crate::chart::Chart;
use crate::setup::{DT, G, body, run as advance, scene};
use crate::{Experiment, Lab, Result, Verdict};
use ishigaki::{Body, BodyHandle, ContactView, Material, Pose, Quat, Shape, Vec3, World, WorldOptions};

pub const EXPERIMENT: Experiment = Experiment {
    name: "aggressive-sleep",
    rows: &["D10"],
    title: "Aggressive sleep: between resting bodies the Jacobians are kept",
    run,
};

/// What a wall does while it settles.
struct Wall {
    calls: Vec<(f64, f64)>,
    frozen: Vec<(f64, f64)>,
    speed: Vec<(f64, f64)>,
    /// Set of contact ids changed, in the last second.
    churn: f64,
    /// Σ impulse of each contact at the end, N·s.
    loads: Vec<f32>,
}

fn ids(world: &World) -> String {
    world.contacts().flat_map(|c| c.manifolds).flat_map(|m| &m.points).map(|p| format!("{:?}", p.id)).collect()
}

fn settle(aggressive: bool, columns: f64, seconds: f64) -> Result<Wall> {
    let mut scene =
        scene("wall", &[("columns", columns), ("rows", 5.0)], |o| o.rest.aggressive_sleep.enabled = aggressive)?;
    let world = &mut scene.world;
    let mut wall = Wall { calls: vec![], frozen: vec![], speed: vec![], churn: 0.0, loads: vec![] };
    let mut last = String::new();
    while world.time() < seconds {
        let report = world.step(DT).clone();
        let now = world.time();
        wall.calls.push((now, report.narrow_phase_calls as f64));
        wall.frozen.push((now, report.frozen as f64));
        wall.speed.push((now, f64::from(report.max_speed).max(1e-9)));
        if now > seconds - 1.0 {
            let ids = ids(world);
            wall.churn += f64::from(u8::from(!last.is_empty() && ids != last));
            last = ids;
        }
    }
    let sum = |c: ContactView<'_>| -> f32 { c.manifolds.iter().flat_map(|m| &m.points).map(|p| p.impulse).sum() };
    wall.loads = world.contacts().map(sum).collect();
    Ok(wall)
}

/// A tower of cubes on a floor, frozen.
fn frozen_tower(kinematic: bool, count: usize) -> Result<(World, BodyHandle, Vec<BodyHandle>)> {
    let mut options = WorldOptions::default();
    options.rest.sleep.enabled = false;
    options.rest.aggressive_sleep.enabled = true;
    let mut world = World::new(options)?;
    let slab = Shape::cuboid(20.0, 0.5, 20.0);
    let floor = if kinematic { Body::kinematic(slab) } else { Body::fixed(slab) };
    let floor = world.add_body(floor.at(-0.5 * Vec3::Y))?;
    let mut cubes = Vec::new();
    for i in 0..count {
        let cube = Body::dynamic(Shape::cuboid(0.25, 0.25, 0.25)).at(Vec3::new(0.0, 0.25 + 0.5 * i as f32, 0.0));
        cubes.push(world.add_body(cube)?);
    }
    advance(&mut world, 120);
    Ok((world, floor, cubes))
}

/// Speed that the upper cubes have gained in the step after their support went, over gΔt.
fn falls() -> Result<f64> {
    let (mut world, _, cubes) = frozen_tower(false, 3)?;
    world.remove_body(cubes[0]);
    world.step(DT);
    Ok(f64::from(-body(&world, cubes[1])?.velocity().y / (G * DT)))
}

/// Speed of a frozen cube a second after the floor became a belt of 1 m/s.
fn rides() -> Result<f64> {
    let (mut world, floor, cubes) = frozen_tower(false, 1)?;
    let belt = Material { surface_velocity: Vec3::X, ..Material::default() };
    if let Some(mut floor) = world.body_mut(floor) {
        floor.set_material(0, belt)?;
    }
    advance(&mut world, 60);
    Ok(f64::from(body(&world, cubes[0])?.velocity().x))
}

/// How far a frozen cube slides in a second on a floor tilted slowly to `angle` (rad), m. μ = 0.6 = tan 31°.
fn slides(angle: f32) -> Result<f64> {
    let (mut world, slope, cubes) = frozen_tower(true, 1)?;
    for i in 1..=240 {
        let tilt = Quat::from_rotation_z(angle * (i as f32 / 180.0).min(1.0));
        if let Some(mut slope) = world.body_mut(slope) {
            slope.set_kinematic_target(Pose::from_parts(tilt * (-0.5 * Vec3::Y), tilt))?;
        }
        world.step(DT);
    }
    let before = body(&world, cubes[0])?.position();
    advance(&mut world, 60);
    Ok(f64::from((body(&world, cubes[0])?.position() - before).length()))
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let (columns, seconds) = lab.choose((12.0, 12.0), (4.0, 4.0));
    lab.progress(0.0, "with aggressive sleep");
    let on = settle(true, columns, seconds)?;
    lab.progress(0.4, "without");
    let off = settle(false, columns, seconds)?;
    lab.progress(0.8, "waking");
    let pair = |title: &str, y: &str, log: bool, a: &[(f64, f64)], b: &[(f64, f64)]| {
        Chart::curves(title, "time, s", y)
            .log(false, log)
            .line("aggressive sleep", a.to_vec())
            .line("without", b.to_vec())
    };
    lab.chart(pair("A wall settles: calls of the narrow phase", "calls in a step", false, &on.calls, &off.calls));
    lab.chart(pair("Pairs that are frozen, near ones included", "pairs", false, &on.frozen, &off.frozen));
    lab.chart(pair("Greatest speed", "speed, m/s", true, &on.speed, &off.speed));
    let last_second = |curve: &[(f64, f64)]| {
        let late: Vec<f64> = curve.iter().filter(|c| c.0 > seconds - 1.0).map(|c| c.1).collect();
        late.iter().sum::<f64>() / late.len().max(1) as f64
    };
    let (calls_on, calls_off) = (last_second(&on.calls), last_second(&off.calls));
    let (speed_on, speed_off) = (last_second(&on.speed), last_second(&off.speed));
    let most = off.loads.iter().fold(0.0_f32, |m, l| m.max(*l));
    let apart = on.loads.iter().zip(&off.loads).map(|(a, b)| (a - b).abs() / most).fold(0.0_f32, f32::max);
    Ok(Verdict::on("at rest the LCP's structure stops changing, bodies calm down, and there is no wrong rest")
        .at_least("narrow-phase calls saved at rest", "%", 90.0, 100.0 * (1.0 - calls_on / calls_off))
        .at_most("changes of the set of contact ids in the last second", "", 0.0, on.churn)
        .at_most("mean greatest speed at rest over that without", "×", 1.0, speed_on / speed_off)
        .open("mean greatest speed at rest", "μm/s", 1e6 * speed_on)
        .open("mean greatest speed at rest without", "μm/s", 1e6 * speed_off)
        .at_most("contacts of the wall: impulses differ by", "% of the greatest", 1.0, 100.0 * f64::from(apart))
        .near("support removed: speed in the next step", "gΔt", 1.0, 0.05, falls()?)
        .near("belt started under it: speed after a second", "m/s", 1.0, 0.02, rides()?)
        .at_most("slope of 28° < 31°: slides", "m", 1e-3, slides(28_f32.to_radians())?)
        .at_least("slope of 36° > 31°: slides", "m", 0.3, slides(36_f32.to_radians())?)
        .note("What moves at rest is rounding, with aggressive sleep and without; one substep leaves more of it than four."))
}
