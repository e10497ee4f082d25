//! B7: three rows hold two anchors together, whatever pulls.

use crate::chart::{Chart, Mark};
use crate::setup::{DT, G, plain, scene, world};
use crate::{Experiment, Lab, Result, Verdict};
use ishigaki::{Body, BodyKind, Joint, Shape, SolverOptions, Vec3};

pub const EXPERIMENT: Experiment =
    Experiment { name: "ball-joint", rows: &["B7"], title: "Stretch of ball joints under load", run };

/// Greatest gap of a chain after it settled, mm.
fn stretch(links: f64, ratio: f64, solver: SolverOptions, seconds: f64) -> Result<f64> {
    let mut scene = scene("chain", &[("links", links), ("end_mass_ratio", ratio)], |o| o.solver = solver)?;
    let mut gap = 0.0_f32;
    while scene.world.time() < seconds {
        let report = scene.world.step(DT);
        if scene.world.time() > 0.5 * seconds {
            gap = gap.max(report.max_joint_error);
        }
    }
    Ok(1e3 * f64::from(gap))
}

/// Gap of a ball of 1 kg that hangs on its own ball joint, pulled down by `weights` of its weight, mm.
fn pulled(weights: f64, seconds: f64) -> Result<f64> {
    let mut world = world(SolverOptions::default())?;
    let hook = world.add_body(Body::empty(BodyKind::Fixed))?;
    let ball = world.add_body(Body::dynamic(Shape::ball(0.1)).mass(1.0).at(-Vec3::Y))?;
    world.add_joint(Joint::ball(hook, ball, Vec3::ZERO))?;
    let mut gap = 0.0_f32;
    while world.time() < seconds {
        if let Some(mut ball) = world.body_mut(ball) {
            ball.apply_force(-weights as f32 * G * Vec3::Y)?;
        }
        let report = world.step(DT);
        if world.time() > 0.5 * seconds {
            gap = gap.max(report.max_joint_error);
        }
    }
    Ok(1e3 * f64::from(gap))
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let seconds = lab.choose(6.0, 1.0);
    let ratios: &[f64] = lab.choose(&[1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0], &[1.0, 10.0]);
    let talk = || plain(|s| (s.warm_start.enabled, s.sweeps) = (true, 10));
    let mut chart =
        Chart::curves("Chain with a ball at its end, hanging", "mass of the ball / mass of a link", "greatest gap, mm")
            .log(true, true);
    let (mut single, mut chain, mut pull) = (f64::NAN, f64::NAN, Vec::new());
    for &ratio in ratios {
        pull.push((ratio, pulled(ratio, 1.0)?.max(1e-4)));
    }
    let kinds = [
        ("1 link, 10 sweeps", 1.0, true),
        ("10 links, 10 sweeps", 10.0, true),
        ("1 link, default", 1.0, false),
        ("10 links, default", 10.0, false),
    ];
    for (i, (name, links, plain)) in kinds.into_iter().enumerate() {
        let mut points = Vec::new();
        for (k, &ratio) in ratios.iter().enumerate() {
            lab.progress((i as f64 + k as f64 / ratios.len() as f64) / 4.0, name);
            let solver = if plain { talk() } else { SolverOptions::default() };
            points.push((ratio, stretch(links, ratio, solver, seconds)?.max(1e-4)));
        }
        if !plain {
            let greatest = points.iter().map(|p| p.1).fold(0.0, f64::max);
            let at_ten = points.iter().find(|p| p.0 == 10.0).map_or(f64::NAN, |p| p.1);
            if links == 1.0 { single = greatest } else { chain = at_ten }
        }
        chart = chart.series(name, Mark::Dotted, points);
    }
    let alone = pull.iter().map(|p| p.1).fold(0.0, f64::max);
    lab.chart(chart.series("one ball, pulled as hard", Mark::Points, pull));
    Ok(Verdict::on("v_a = v_b: three rows make a ball joint")
        .at_most("one joint, pulled hardest: gap", "mm", 0.01, alone)
        .at_most("a light link between hook and ball, up to 1 : 1000: gap", "mm", 20.0, single)
        .at_most("10 links, end of 10 links' mass: gap", "mm", 5.0, chain)
        .note(
            "The rows of a joint are solved together and leave no gap under a steady load. Where light links carry a heavy \
            body, the talk's sweeps decide how far they stretch; the engine solves the links at once.",
        ))
}
