//! B8: two rows more than a ball joint keep an axis.

use crate::chart::Chart;
use crate::setup::{DT, G, plain, world};
use crate::{Experiment, Lab, Result, Verdict};
use ishigaki::{Body, BodyKind, Joint, Shape, SolverOptions, Vec3};

pub const EXPERIMENT: Experiment =
    Experiment { name: "hinge", rows: &["B8"], title: "A door of 50 kg on a hinge, pulled at its far corner", run };

/// Axis error over time, degrees, with a pull of `pull` weights at the far upper corner, out and down.
fn door(pull: f32, solver: SolverOptions, seconds: f64) -> Result<Vec<(f64, f64)>> {
    let mut world = world(solver)?;
    let frame = world.add_body(Body::empty(BodyKind::Fixed).at(Vec3::Y))?;
    let panel = Body::dynamic(Shape::cuboid(0.5, 1.0, 0.03)).mass(50.0).at(Vec3::new(0.5, 1.0, 0.0));
    let panel = world.add_body(panel)?;
    let joint = world.add_joint(Joint::hinge(frame, panel, Vec3::Y, Vec3::Y).dry_friction(2.0))?;
    let mut errors = Vec::new();
    while world.time() < seconds {
        if let Some(mut body) = world.body_mut(panel) {
            let corner = body.state().pose() * Vec3::new(0.5, 1.0, 0.0);
            body.apply_force_at(pull * 50.0 * G * Vec3::new(0.3, -1.0, 0.2), corner)?;
        }
        world.step(DT);
        let angle = world.joint(joint).map_or(f32::NAN, |j| j.angle_error());
        errors.push((world.time(), f64::from(angle).to_degrees().max(1e-6)));
    }
    Ok(errors)
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let seconds = lab.choose(5.0, 1.0);
    let mut chart = Chart::curves("Angle between the axis of the door and that of its frame", "time, s", "angle, °")
        .log(false, true);
    let mut verdict = Verdict::on("a ball joint and two rows t·(ω_A − ω_B) = 0 make a hinge");
    for (i, pull) in [0.0_f32, 1.0, 10.0].into_iter().enumerate() {
        for (name, solver) in
            [("10 sweeps", plain(|s| s.warm_start.enabled = true)), ("default", SolverOptions::default())]
        {
            lab.progress(i as f64 / 3.0, name);
            let errors = door(pull, solver, seconds)?;
            let worst = errors.iter().map(|e| e.1).fold(0.0, f64::max);
            if name == "default" {
                verdict = verdict.at_most(format!("pulled with {pull} × its weight: axis off by"), "°", 0.1, worst);
            }
            chart = chart.line(format!("{pull} × its weight, {name}"), errors);
        }
    }
    lab.chart(chart);
    Ok(verdict)
}
