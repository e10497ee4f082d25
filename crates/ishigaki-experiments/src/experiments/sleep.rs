//! D9: islands that rest are not solved; sleep follows from stability and does not make it.

use crate::chart::Chart;
use crate::setup::{DT, scene};
use crate::{Experiment, Lab, Result, Verdict};
use ishigaki::{Body, Shape, Vec3};

pub const EXPERIMENT: Experiment =
    Experiment { name: "sleep", rows: &["D9"], title: "A wall comes to rest, sleeps, and is woken by a ball", run };

struct Night {
    /// Time and part of the bodies asleep, %.
    asleep: Vec<(f64, f64)>,
    /// Time and time of a step, ms.
    cost: Vec<(f64, f64)>,
    /// Steps from the contact of the ball to a wall that is all awake.
    waking: f64,
    /// Greatest move of a center of the wall before the ball came, mm.
    moved: f64,
}

fn night(lab: &Lab<'_>, sleep: bool, columns: f64, seconds: f64) -> Result<Night> {
    let mut scene = scene("wall", &[("columns", columns), ("rows", 6.0)], |o| o.rest.sleep.enabled = sleep)?;
    let world = &mut scene.world;
    let wall: Vec<_> = scene.bodies.iter().skip(1).map(|b| b.1).collect();
    let starts: Vec<Vec3> = wall.iter().filter_map(|b| world.body(*b)).map(|b| b.center()).collect();
    let mut night = Night { asleep: Vec::new(), cost: Vec::new(), waking: f64::NAN, moved: 0.0 };
    let (mut ball, mut touched) = (None, None);
    while world.time() < seconds {
        if ball.is_none() && world.time() > 0.6 * seconds {
            night.moved = wall
                .iter()
                .zip(&starts)
                .filter_map(|(b, s)| world.body(*b).map(|b| b.center() - *s))
                .map(|d| 1e3 * f64::from(d.length()))
                .fold(0.0, f64::max);
            let shot =
                Body::dynamic(Shape::ball(0.2)).density(200.0).at(Vec3::new(0.0, 1.5, 4.0)).velocity(-12.0 * Vec3::Z);
            ball = Some(world.add_body(shot)?);
        }
        let (report, time) = lab.time(|| world.step(DT).clone());
        let now = world.time();
        let count = wall.iter().filter(|b| world.body(**b).is_some_and(|b| b.is_asleep())).count();
        night.asleep.push((now, 100.0 * count as f64 / wall.len() as f64));
        night.cost.push((now, 1e3 * time));
        if let Some(ball) = ball {
            let touches = world.contacts().any(|c| {
                (c.a.body == ball && wall.contains(&c.b.body)) || (c.b.body == ball && wall.contains(&c.a.body))
            });
            touched = touched.or(touches.then_some(report.bodies).map(|_| world.step_count()));
        }
        if let (Some(step), true, true) = (touched, count == 0, night.waking.is_nan()) {
            night.waking = (world.step_count() - step) as f64;
        }
    }
    Ok(night)
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let (columns, seconds) = lab.choose((16.0, 8.0), (4.0, 5.0));
    lab.progress(0.0, "with sleep");
    let with = night(lab, true, columns, seconds)?;
    lab.progress(0.5, "without");
    let without = night(lab, false, columns, seconds)?;
    lab.chart(
        Chart::curves("Bodies of the wall asleep; a ball comes after 60 % of the time", "time, s", "asleep, %")
            .y_range(0.0, 105.0)
            .line("sleep", with.asleep.clone())
            .line("no sleep", without.asleep.clone()),
    );
    lab.chart(
        Chart::curves("Time of a step (on this machine)", "time, s", "ms")
            .log(false, true)
            .line("sleep", with.cost.clone())
            .line("no sleep", without.cost.clone()),
    );
    let before = |curve: &[(f64, f64)]| {
        let mut late: Vec<f64> = curve.iter().filter(|c| (0.5..0.6).contains(&(c.0 / seconds))).map(|c| c.1).collect();
        late.sort_by(f64::total_cmp);
        late.get(late.len() / 2).copied().unwrap_or(f64::NAN)
    };
    let awake = with.asleep.iter().position(|a| a.1 >= 100.0).map_or(f64::NAN, |i| with.asleep[i].0);
    Ok(Verdict::on("islands at rest are put to sleep as a whole; sleep does not stabilize, it follows from stability")
        .near("asleep before the ball", "%", 100.0, 0.0, before(&with.asleep))
        .open("all asleep after", "s", awake)
        .at_least("time of a step without sleep over with", "×", 10.0, before(&without.cost) / before(&with.cost))
        .at_most("steps from the touch to all awake", "", 1.0, with.waking)
        .at_most("without sleep the wall stands too: greatest move", "mm", 5.0, without.moved)
        .note("Awake, a wall at rest takes one substep of two sweeps: sleep has less left to save than the talk's engine had."))
}
