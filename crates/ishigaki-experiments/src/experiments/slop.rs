//! D2: without slop, recovery lifts a block off its support, gravity puts it back, and so on.

use crate::chart::{Chart, Mark};
use crate::setup::{DT, add_ground, body, cube, force_between, plain, world};
use crate::{Experiment, Lab, Result, Verdict};
use ishigaki::collision::manifold::Contact;
use ishigaki::{ContactHooks, PairView, PenetrationRecovery, StepContext, Vec3};

pub const EXPERIMENT: Experiment =
    Experiment { name: "slop", rows: &["D2"], title: "A block at rest on the ground, recovery k = 1", run };

/// Contacts as the talk has them: they are there only while things overlap.
struct OverlapOnly;

impl ContactHooks for OverlapOnly {
    fn modify(&mut self, _pair: &PairView<'_>, contact: &mut Contact) {
        if !contact.manifolds().iter().flat_map(|m| &m.points).any(|p| p.separation < 0.0) {
            contact.drop_points();
        }
    }
}

struct Rest {
    /// Time and height above the ground, mm.
    height: Vec<(f64, f64)>,
    /// Time and load of the ground over the weight.
    load: Vec<(f64, f64)>,
    /// How often support switched on or off in the last second.
    toggles: f64,
    /// Peak to peak in the last second, mm.
    shake: f64,
}

fn rest(slop: bool, overlap_only: bool) -> Result<Rest> {
    let mut world = world(plain(|s| {
        s.penetration_recovery = PenetrationRecovery { enabled: true, rate: 1.0, ..PenetrationRecovery::default() };
        s.slop.enabled = slop;
    }))?;
    let ground = add_ground(&mut world)?;
    let block = world.add_body(cube(0.501 * Vec3::Y))?;
    let weight = body(&world, block)?.mass() * crate::setup::G;
    let (mut height, mut load) = (Vec::new(), Vec::new());
    for _ in 0..120 {
        let mut hooks = OverlapOnly;
        let hooks: Option<&mut dyn ContactHooks> = if overlap_only { Some(&mut hooks) } else { None };
        world.step_with(DT, &mut StepContext { clock: None, hooks });
        let now = world.time();
        height.push((now, 1e3 * (f64::from(body(&world, block)?.center().y) - 0.5)));
        load.push((now, f64::from(force_between(&world, ground, block) / weight)));
    }
    let toggles = load[59..].windows(2).filter(|w| (w[0].1 > 0.0) != (w[1].1 > 0.0)).count() as f64;
    let (low, high) = height[60..].iter().fold((f64::MAX, f64::MIN), |(a, b), h| (a.min(h.1), b.max(h.1)));
    Ok(Rest { height, load, toggles, shake: high - low })
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let cases = [("without slop", rest(false, true)?), ("with slop, 5 mm", rest(true, true)?)];
    let speculative = rest(false, false)?;
    let mut heights = Chart::curves("Height of the block above the ground", "time, s", "height, mm");
    let mut loads = Chart::curves("Load on the ground", "time, s", "load / weight");
    let late = |points: &[(f64, f64)]| points.iter().copied().filter(|p| p.0 > 1.5).collect::<Vec<_>>();
    for (name, rest) in &cases {
        heights = heights.line(*name, rest.height.clone());
        loads = loads.line(*name, late(&rest.load));
    }
    let name = "no slop, speculative contacts";
    lab.chart(heights.series(name, Mark::Dashed, speculative.height.clone()));
    lab.chart(loads.series(name, Mark::Dashed, late(&speculative.load)));
    let [(_, off), (_, on)] = &cases;
    Ok(Verdict::on("without slop support switches on and off and the block shakes; leaving a slop of overlap cures it")
        .near("toggles without slop", "/s", 60.0, 2.0, off.toggles)
        .near("peak to peak without slop", "mm", 2.5, 0.5, off.shake)
        .at_most("toggles with slop", "/s", 0.0, on.toggles)
        .at_most("peak to peak with slop", "mm", 0.02, on.shake)
        .open("toggles without slop, with speculative contacts", "/s", speculative.toggles)
        .note(
            "The period is three steps, not two: pushed out, the block coasts for a step before it falls back, \
            since a contact of no depth does not hold it. Measured with contacts that exist only while things \
            overlap, as in the talk. The engine's speculative contacts, which are there before things touch, \
            need no slop for this.",
        ))
}
