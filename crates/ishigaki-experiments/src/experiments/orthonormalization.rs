//! A2, A6: the talk's R' = R + Δt [ω]ₓ R is no rotation; what is done about it decides where the energy goes.

use crate::chart::Chart;
use crate::setup::DT;
use crate::{Experiment, Lab, Result, Verdict};
use glam::{DMat3, DQuat};
use ishigaki::motion::angular_momentum::{Orthonormalization, orthonormalized, turned_matrix};
use ishigaki::motion::{Spin, advance};
use ishigaki::{Mat3, Quat, RotationScheme, Vec3};

pub const EXPERIMENT: Experiment = Experiment {
    name: "orthonormalization",
    rows: &["A2", "A6"],
    title: "R' = R + Δt [ω]ₓ R, made orthonormal in three ways",
    run,
};

const INERTIA: Vec3 = Vec3::new(1.0, 2.0, 3.0);

/// Longest column and energy over its start, step by step for 10 s at 60 Hz.
fn watch(how: Orthonormalization) -> Vec<(f64, f64)> {
    let start = Vec3::new(0.1, 10.0, 0.1);
    let momentum = INERTIA * start;
    let (mut r, mut omega) = (Mat3::IDENTITY, start);
    let mut seen = Vec::new();
    for _ in 0..600 {
        r = orthonormalized(how, turned_matrix(r, omega, DT));
        // ω' = R' I_body⁻¹ R'ᵀ L
        omega = r * ((r.transpose() * momentum) / INERTIA);
        let longest = r.x_axis.length().max(r.y_axis.length()).max(r.z_axis.length());
        seen.push((f64::from(longest), f64::from(momentum.dot(omega) / momentum.dot(start))));
    }
    seen
}

/// Greatest |RᵀR − I| of the engine's unit quaternion over `steps` steps.
fn orthonormality(scheme: RotationScheme, steps: u32) -> Vec<(f64, f64)> {
    let mut spin = Spin::new(Quat::IDENTITY, INERTIA, Vec3::new(0.1, 10.0, 0.1));
    let (mut worst, mut seen, mut next) = (0.0_f64, Vec::new(), 1);
    for step in 1..=steps {
        advance(scheme, &mut spin, false, DT);
        if step % 16 == 0 || step < 64 {
            let q = spin.rotation;
            let r = DMat3::from_quat(DQuat::from_xyzw(q.x.into(), q.y.into(), q.z.into(), q.w.into()));
            let error = (r.transpose() * r - DMat3::IDENTITY).to_cols_array();
            worst = error.iter().fold(worst, |m, x| m.max(x.abs()));
        }
        if step == next || step == steps {
            seen.push((f64::from(step), worst));
            next = (next * 5).div_ceil(4) + 1;
        }
    }
    seen
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let kinds = [
        ("not at all", Orthonormalization::None),
        ("Gram–Schmidt, columns in turn", Orthonormalization::GramSchmidt),
        ("polar: the nearest rotation", Orthonormalization::Polar),
    ];
    let runs = kinds.map(|(name, how)| (name, watch(how)));
    let curve = |f: &dyn Fn(&(f64, f64)) -> f64, seen: &[(f64, f64)]| {
        seen.iter().enumerate().map(|(i, s)| ((i + 1) as f64 * f64::from(DT), f(s))).collect::<Vec<_>>()
    };
    let mut columns = Chart::curves("Longest column of R", "time, s", "length").log(false, true);
    let mut energies =
        Chart::curves("Energy", "time, s", "energy / energy at the start").log(false, true).y_range(0.1, 10.0);
    for (name, seen) in &runs {
        columns = columns.line(*name, curve(&|s| s.0, seen));
        energies = energies.line(*name, curve(&|s| s.1, seen));
    }
    lab.chart(columns);
    lab.chart(energies);

    let steps = lab.choose(1_000_000, 20_000);
    let mut kept = Chart::curves("Unit quaternion: ‖RᵀR − I‖", "steps", "greatest so far").log(true, true);
    let mut worst = 0.0_f64;
    for (i, (name, scheme)) in
        [("splitting", RotationScheme::Splitting), ("the talk's four steps", RotationScheme::AngularMomentum)]
            .into_iter()
            .enumerate()
    {
        lab.progress(i as f64 / 2.0, name);
        let seen = orthonormality(scheme, steps);
        worst = seen.iter().fold(worst, |m, s| m.max(s.1));
        kept = kept.line(name, seen);
    }
    lab.chart(kept.level(1e-6, "1e-6"));

    let drift = |i: usize| runs[i].1.last().map_or(f64::NAN, |s| 100.0 * (s.1 - 1.0));
    let longest = |i: usize| runs[i].1.iter().map(|s| s.0).filter(|l| l.is_finite()).fold(0.0, f64::max);
    Ok(Verdict::on("R has orthonormal columns; R' = R + Δt [ω]ₓ R keeps them")
        .at_most("‖RᵀR − I‖ of the engine", "", 1e-6, worst)
        .at_least("never made orthonormal: longest column", "", 100.0, longest(0))
        .near("Gram–Schmidt: longest column", "", 1.0, 1e-5, longest(1))
        .near("polar: longest column", "", 1.0, 1e-5, longest(2))
        .open("Gram–Schmidt: energy after 10 s", "%", drift(1))
        .open("polar: energy after 10 s", "%", drift(2))
        .note(
            "The slide does not say that R' must be made orthonormal again: without it R explodes. How it is \
            done decides which way the energy drifts (−22 % … +100 % in an f64 prototype).",
        ))
}
