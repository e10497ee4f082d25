//! A6: integrating Euler's equation in ω blows up; carrying L does not.

use crate::chart::Chart;
use crate::setup::{DT, change_options, plain, world};
use crate::{Experiment, Lab, Result, Verdict};
use glam::{DQuat, DVec3};
use ishigaki::{Body, BodyState, MassProperties, Quat, RotationScheme, Shape, Vec3};

pub const EXPERIMENT: Experiment = Experiment {
    name: "euler-vs-angular-momentum",
    rows: &["A6"],
    title: "A free body of moments (1, 2, 3) kg·m² that starts at (0.1, 10, 0.1) rad/s",
    run,
};

/// kg·m².
pub const MOMENTS: DVec3 = DVec3::new(1.0, 2.0, 3.0);
/// rad/s.
pub const SPIN: Vec3 = Vec3::new(0.1, 10.0, 0.1);

/// A body with these moments and this spin, without gravity in mind.
pub fn tumbler() -> Body {
    let properties = MassProperties {
        mass: 1.0,
        center: Vec3::ZERO,
        principal_inertia: MOMENTS.as_vec3(),
        principal_frame: Quat::IDENTITY,
    };
    Body::dynamic(Shape::ball(0.1)).mass_properties(properties).angular_velocity(SPIN)
}

/// ω in the body's axes, in f64.
pub fn body_spin(state: &BodyState) -> DVec3 {
    let q = state.rotation();
    DQuat::from_xyzw(q.x.into(), q.y.into(), q.z.into(), q.w.into()).normalize().conjugate()
        * state.angular_velocity().as_dvec3()
}

/// ½ Σ I ω², J.
pub fn energy(state: &BodyState) -> f64 {
    0.5 * (MOMENTS * body_spin(state).powf(2.0)).element_sum()
}

/// Time, energy over its start, |Iω| over its start.
fn watch(scheme: RotationScheme, seconds: f64) -> Result<Vec<(f64, f64, f64)>> {
    let mut world = world(plain(|_| {}))?;
    change_options(&mut world, |o| {
        o.gravity = Vec3::ZERO;
        o.motion.rotation = scheme;
        // The guard against numbers that run away would hide how far they run.
        o.motion.max_angular_speed = 1e9;
    })?;
    let body = world.add_body(tumbler())?;
    let mut states = Vec::new();
    let momentum = |state: &BodyState| (MOMENTS * body_spin(state)).length();
    while let Some(state) = world.body(body) {
        states.push((world.time(), energy(state), momentum(state)));
        if world.time() >= seconds {
            break;
        }
        world.step(DT);
    }
    let (_, e, l) = states[0];
    Ok(states.into_iter().map(|(t, energy, momentum)| (t, energy / e, momentum / l)).collect())
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let schemes = [
        ("ω carried (explicit Euler)", RotationScheme::ExplicitEuler),
        ("L carried, as in the talk", RotationScheme::AngularMomentum),
        ("L carried, splitting", RotationScheme::Splitting),
    ];
    let mut runs = Vec::new();
    for (i, (name, scheme)) in schemes.into_iter().enumerate() {
        lab.progress(i as f64 / 3.0, name);
        runs.push((name, watch(scheme, 10.0)?));
    }
    let start = energy_of_start();
    let square = (MOMENTS * SPIN.as_dvec3()).length_squared();
    let (least, most) = (square / (2.0 * 3.0) / start, square / 2.0 / start);
    let mut energies = Chart::curves("Energy", "time, s", "energy / energy at the start").log(false, true);
    let mut momenta = Chart::curves("Angular momentum |Iω|", "time, s", "| |Iω|/|L₀| − 1 |").log(false, true);
    for (name, states) in &runs {
        energies = energies.line(*name, states.iter().map(|s| (s.0, s.1)).collect());
        momenta = momenta.line(*name, states.iter().map(|s| (s.0, (s.2 - 1.0).abs().max(1e-9))).collect());
    }
    lab.chart(energies.level(most, "L²/2I₁: the most there can be").level(least, "L²/2I₃: the least"));
    lab.chart(momenta);

    let last = |i: usize| runs[i].1.last().map_or(f64::NAN, |s| s.1);
    let range = |i: usize| runs[i].1.iter().fold((f64::MAX, f64::MIN), |(a, b), s| (a.min(s.1), b.max(s.1)));
    let momentum = |i: usize| runs[i].1.iter().map(|s| (s.2 - 1.0).abs()).fold(0.0, f64::max);
    let splitting = range(2);
    Ok(Verdict::on("integrating Euler's equation directly blows up; carrying L does not")
        .near("ω carried: energy after 10 s", "×", 1.2e6, 0.4e6, last(0))
        .at_least("L carried: least energy", "×", least * (1.0 - 1e-6), range(1).0)
        .at_most("L carried: most energy", "×", most * (1.0 + 1e-6), range(1).1)
        .at_most("L carried: |Iω| off by", "", 3e-6, momentum(1).max(momentum(2)))
        .at_most("splitting: energy off by", "", 2e-4, (splitting.1 - 1.0).max(1.0 - splitting.0))
        .note(
            "The energy of the talk's scheme stays in its range but drifts inside it; the splitting of row A7 \
            keeps it.",
        ))
}

fn energy_of_start() -> f64 {
    0.5 * (MOMENTS * SPIN.as_dvec3().powf(2.0)).element_sum()
}
