//! What the default options must not change: the momentum and energy of a free body, the weight on a scale, and that
//! a tower that is hit falls, without energy from nowhere.

use crate::chart::Chart;
use crate::course::rounded;
use crate::experiments::euler_vs_angular_momentum::energy;
use crate::experiments::weight_feeling::reading;
use crate::setup::{DT, body, scene};
use crate::{Lab, Result, Verdict};
use ishigaki::{Body, Shape, Vec3};

/// Changes over their starts, greatest of the run.
struct FreeBody {
    momentum: f64,
    energy: f64,
}

/// A body of three different moments, turning about the middle one.
fn free_body(seconds: f64) -> Result<FreeBody> {
    let mut scene = scene("dzhanibekov", &[], |_| {})?;
    let handle = scene.bodies[0].1;
    let state = |scene: &ishigaki_scenes::Scene| {
        body(&scene.world, handle).map(|b| (b.angular_momentum().as_dvec3().length(), energy(b)))
    };
    let start = state(&scene)?;
    let mut seen = FreeBody { momentum: 0.0, energy: 0.0 };
    while scene.world.time() < seconds {
        scene.world.step(DT);
        let now = state(&scene)?;
        seen.momentum = seen.momentum.max((now.0 / start.0 - 1.0).abs());
        seen.energy = seen.energy.max((now.1 / start.1 - 1.0).abs());
    }
    Ok(seen)
}

/// A tower that a ball hits near its top.
struct HitTower {
    /// How far the top box came down, m.
    fell: f64,
    /// Highest energy over that at the start, less 1.
    over_start: f64,
    /// Greatest growth from one step to the next, over the energy at the start.
    growth: f64,
}

fn hit_tower(seconds: f64) -> Result<HitTower> {
    let mut scene = scene("tower", &[("n", 10.0)], |_| {})?;
    let top = scene.bodies[10].1;
    let shot = Body::dynamic(Shape::ball(0.5)).density(4000.0).at(Vec3::new(-3.0, 7.5, 0.1)).velocity(10.0 * Vec3::X);
    scene.world.add_body(shot)?;
    let before = body(&scene.world, top)?.center().y;
    let mut energies = Vec::new();
    while scene.world.time() < seconds {
        let report = scene.world.step(DT);
        energies.push(f64::from(report.kinetic_energy) + f64::from(report.potential_energy));
    }
    let growth = energies.windows(2).map(|w| w[1] - w[0]).fold(0.0, f64::max);
    let highest = energies.iter().copied().fold(f64::MIN, f64::max);
    let fell = f64::from(before - body(&scene.world, top)?.center().y);
    Ok(HitTower { fell, over_start: highest / energies[0] - 1.0, growth: growth / energies[0] })
}

pub fn run(lab: &mut Lab<'_>, verdict: Verdict) -> Result<Verdict> {
    let free = free_body(lab.choose(60.0, 1.0))?;
    let scale = reading(5, lab.choose(2.0, 0.5), |_| {})?;
    let hit = hit_tower(lab.choose(10.0, 0.6))?;
    let row = |value: f64, limit: f64, sign: &str| [(value, rounded(value)), (limit, format!("{sign} {limit}"))];
    lab.chart(
        Chart::table("What must not change", "value", ["measured", "limit"])
            .shade(|_| 0.0)
            .row("free body, 60 s: change of |L|, %", row(100.0 * free.momentum, 1e-3, "≤"))
            .row("free body, 60 s: change of the energy, %", row(100.0 * free.energy, 0.1, "≤"))
            .row("scale under 5 boxes: reading off by, %", row(100.0 * (scale - 1.0).abs(), 1.0, "≤"))
            .row("tower of 10 hit by a ball: its top fell by, m", row(hit.fell, 1.0, "≥"))
            .row("the same: energy at most over the start, %", row(100.0 * hit.over_start, 0.0, "≤")),
    );
    Ok(verdict
        .at_most("free body: change of |L|", "", 1e-5, free.momentum)
        .at_most("free body: change of the energy", "", 1e-3, free.energy)
        .near("scale under 5 boxes: reading over weight", "", 1.0, 0.01, scale)
        .at_least("tower hit by a ball: its top fell by", "m", 1.0, hit.fell)
        .at_most("tower hit by a ball: energy over that of the start", "", 0.0, hit.over_start)
        .open("tower hit by a ball: greatest growth of the energy in a step, over the start", "", hit.growth))
}
