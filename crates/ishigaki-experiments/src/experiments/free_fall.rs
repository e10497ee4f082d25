//! A1: the order of the two updates of a step decides how far a body falls.

use crate::chart::{Chart, Mark};
use crate::setup::{DT, G, body, change_options, plain, world};
use crate::{Experiment, Lab, Result, Verdict};
use ishigaki::{Body, Shape, Vec3};

pub const EXPERIMENT: Experiment =
    Experiment { name: "free-fall", rows: &["A1"], title: "A ball falls for a second, in steps", run };

/// How far a ball falls in each of `n` steps of length `dt`, m.
fn fall(n: usize, dt: f32) -> Result<Vec<f64>> {
    let mut world = world(plain(|_| {}))?;
    // From the origin on: there f32 is finest.
    let ball = world.add_body(Body::dynamic(Shape::ball(0.1)).at(Vec3::ZERO))?;
    change_options(&mut world, |o| o.motion.max_speed = 1e6)?;
    let mut fallen = Vec::with_capacity(n);
    for _ in 0..n {
        world.step(dt);
        fallen.push(-f64::from(body(&world, ball)?.center().y));
    }
    Ok(fallen)
}

/// gΔt² n(n ± 1)/2.
fn sum(n: usize, dt: f32, sign: f64) -> f64 {
    let (n, dt) = (n as f64, f64::from(dt));
    f64::from(G) * dt * dt * n * (n + sign) / 2.0
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let fallen = fall(60, DT)?;
    let curve = |f: &dyn Fn(usize) -> f64| (1..=60).map(|n| (n as f64 * f64::from(DT), f(n))).collect::<Vec<_>>();
    let exact = |n: usize| 0.5 * f64::from(G) * (n as f64 * f64::from(DT)).powi(2);
    let millimeters = |y: f64, n: usize| 1e3 * (y - exact(n));
    lab.chart(
        Chart::curves("Distance beyond ½gt², at 60 steps a second", "time, s", "beyond ½gt², mm")
            .series("engine", Mark::Points, curve(&|n| millimeters(fallen[n - 1], n)))
            .series("new v: gΔt² n(n+1)/2", Mark::Line, curve(&|n| millimeters(sum(n, DT, 1.0), n)))
            .series("old v: gΔt² n(n−1)/2", Mark::Dashed, curve(&|n| millimeters(sum(n, DT, -1.0), n))),
    );

    let mut errors = Vec::new();
    for rate in [30, 60, 120, 240, 480, 960] {
        let dt = 1.0 / rate as f32;
        let time = rate as f64 * f64::from(dt);
        let half = 0.5 * f64::from(G) * time * time;
        errors.push((rate as f64, (fall(rate, dt)?[rate - 1] - half).abs() / half));
        lab.progress(rate as f64 / 960.0, "falling");
    }
    let order = (errors[0].1 / errors[4].1).log2() / 4.0;
    lab.chart(
        Chart::curves("Error against ½gt² after one second", "steps per second", "relative error")
            .log(true, true)
            .series("engine", Mark::Dotted, errors),
    );
    let off = (1..=60).map(|n| (fallen[n - 1] / sum(n, DT, 1.0) - 1.0).abs()).fold(0.0, f64::max);
    Ok(Verdict::on("v' = v + Δt F/m, then x' = x + Δt v, with the old v on the slide")
        .near("fall in 60 steps", "m", sum(60, DT, 1.0), 1e-5, fallen[59])
        .at_most("greatest deviation from gΔt² n(n+1)/2", "", 1e-5, off)
        .near("order of the error against ½gt²", "", 1.0, 0.02, order)
        .note(
            "The slide's x' with the old v is explicit Euler and falls short; in the loop of detecting, \
            solving u' and moving with u' it is the new v that counts, and the fall is as much too long.",
        ))
}
