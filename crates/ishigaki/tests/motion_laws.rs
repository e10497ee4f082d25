//! Laws of free motion: conserved momentum, bounded energy, Dzhanibekov's flips, precession, free fall.

use glam::{DMat3, DQuat, DVec3};
use ishigaki::math::{Mat3, Quat, Vec3, atan2, rotation_from_vector};
use ishigaki::motion::angular_momentum::{Orthonormalization, orthonormalized, turned_matrix};
use ishigaki::motion::{Spin, advance, forces, turned};
use ishigaki::{MassProperties, RotationScheme};

const SCHEMES: [RotationScheme; 3] =
    [RotationScheme::Splitting, RotationScheme::AngularMomentum, RotationScheme::ExplicitEuler];

/// The talk's example: I = (1, 2, 3) kg·m², spinning almost about its middle axis.
fn tumbler() -> Spin {
    Spin::new(Quat::IDENTITY, Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.1, 10.0, 0.1))
}

/// R of a quaternion as it is: not made unit first.
fn matrix(q: Quat) -> DMat3 {
    DMat3::from_quat(DQuat::from_xyzw(q.x.into(), q.y.into(), q.z.into(), q.w.into()))
}

fn orthonormality_error(r: DMat3) -> f64 {
    (r.transpose() * r - DMat3::IDENTITY).to_cols_array().iter().fold(0.0, |m, x| m.max(x.abs()))
}

/// v along the principal axes, in f64.
fn in_principal_axes(spin: &Spin, v: Vec3) -> DVec3 {
    (matrix(spin.rotation) * matrix(spin.principal_frame)).transpose() * v.as_dvec3()
}

/// I ω, in f64.
fn momentum_of_velocity(spin: &Spin) -> DVec3 {
    let body = spin.principal_inertia.as_dvec3() * in_principal_axes(spin, spin.angular_velocity);
    matrix(spin.rotation) * matrix(spin.principal_frame) * body
}

/// ½ ω·Iω, in f64.
fn energy(spin: &Spin) -> f64 {
    let omega = in_principal_axes(spin, spin.angular_velocity);
    0.5 * (spin.principal_inertia.as_dvec3() * omega * omega).element_sum()
}

/// [L²/2I_max, L²/2I_min]: no body with this |L| has another energy.
fn energy_range(spin: &Spin) -> (f64, f64) {
    let square = spin.angular_momentum.as_dvec3().length_squared();
    let i = spin.principal_inertia.as_dvec3();
    (0.5 * square / i.max_element(), 0.5 * square / i.min_element())
}

/// A body without symmetry whose principal axes are oblique.
fn oblique() -> Spin {
    let i = Mat3::from_cols_array_2d(&[[3.0, 0.4, -0.2], [0.4, 2.5, 0.3], [-0.2, 0.3, 2.0]]);
    let mass = MassProperties::from_matrix(1.0, Vec3::ZERO, i).unwrap();
    let mut spin = Spin {
        rotation: rotation_from_vector(Vec3::new(0.5, -1.0, 0.3)),
        principal_frame: mass.principal_frame,
        principal_inertia: mass.principal_inertia,
        inverse_principal_inertia: mass.principal_inertia.recip(),
        angular_momentum: Vec3::ZERO,
        angular_velocity: Vec3::new(3.0, -4.0, 5.0),
    };
    spin.angular_momentum = spin.inertia_times(spin.angular_velocity);
    spin
}

#[test]
fn angular_momentum_is_exact() {
    for start in [tumbler(), oblique()] {
        for scheme in [RotationScheme::Splitting, RotationScheme::AngularMomentum] {
            let mut spin = start;
            let mut worst = 0.0_f64;
            for _ in 0..10_000 {
                advance(scheme, &mut spin, false, 1.0 / 60.0);
                // The vector L is not touched; that of the visible motion, I ω, must agree with it.
                let off = momentum_of_velocity(&spin) - start.angular_momentum.as_dvec3();
                worst = worst.max(off.length());
            }
            assert_eq!(spin.angular_momentum, start.angular_momentum);
            let relative = worst / start.angular_momentum.as_dvec3().length();
            println!("{scheme:?}: error of I ω {relative:e}");
            // ω is f32: a few roundings of |L|, the same after ten steps and ten thousand.
            assert!(relative < 3e-6, "{scheme:?}: {relative:e}");
        }
    }
}

#[test]
fn splitting_keeps_the_energy() {
    let mut spin = tumbler();
    let start = energy(&spin);
    let mut worst = 0.0_f64;
    for _ in 0..600 {
        advance(RotationScheme::Splitting, &mut spin, false, 1.0 / 60.0);
        worst = worst.max((energy(&spin) / start - 1.0).abs());
    }
    println!("splitting: energy error {worst:e}");
    assert!(worst < 2e-4, "{worst:e}");
    // Bounded for all times: an hour later it is no worse.
    for _ in 0..3600 * 60 {
        advance(RotationScheme::Splitting, &mut spin, false, 1.0 / 60.0);
        worst = worst.max((energy(&spin) / start - 1.0).abs());
    }
    println!("splitting: energy error {worst:e} in an hour");
    assert!(worst < 3e-4, "{worst:e} after an hour");
}

#[test]
fn talks_scheme_stays_in_the_range_of_energies_but_drifts() {
    let mut spin = tumbler();
    let (least, most) = energy_range(&spin);
    let start = energy(&spin);
    let mut drift = 0.0_f64;
    for _ in 0..600 {
        advance(RotationScheme::AngularMomentum, &mut spin, false, 1.0 / 60.0);
        let now = energy(&spin);
        assert!(now > least * (1.0 - 1e-6) && now < most * (1.0 + 1e-6), "{now} J outside [{least}, {most}] J");
        drift = drift.max((now / start - 1.0).abs());
    }
    assert!(drift > 0.05, "the first-order rotation drifts; measured {drift}");
}

#[test]
fn explicit_euler_gains_energy_without_bound() {
    let mut spin = tumbler();
    let start = energy(&spin);
    for _ in 0..600 {
        advance(RotationScheme::ExplicitEuler, &mut spin, false, 1.0 / 60.0);
    }
    let gain = energy(&spin) / start;
    println!("explicit Euler: energy x{gain:e} after 10 s");
    assert!(gain > 1e5, "{gain}");
    // Even with an exact rotation.
    let mut spin = tumbler();
    let h = 1.0 / 60.0;
    let mut gains = Vec::new();
    for _ in 0..1200 {
        let omega = spin.angular_velocity;
        spin.angular_velocity -= h * spin.inverse_inertia_times(omega.cross(spin.inertia_times(omega)));
        spin.rotation = turned(spin.rotation, spin.angular_velocity, h);
        gains.push(energy(&spin) / start);
    }
    println!("with an exact rotation: x{:.2} after 10 s, x{:e} after 20 s", gains[599], gains[1199]);
    assert!(gains[599] > 3.0);
    assert!(gains[1199].is_nan() || gains[1199] > 1e6);
}

/// K(k) by the arithmetic–geometric mean.
fn complete_elliptic(k: f64) -> f64 {
    let (mut a, mut b) = (1.0_f64, (1.0 - k * k).sqrt());
    for _ in 0..40 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    std::f64::consts::PI / (2.0 * a)
}

/// Seconds between flips of a free body with I₁ < I₂ < I₃ (Landau & Lifshitz, Mechanics § 37): 2K(k)/ω_p.
fn flip_interval(i: DVec3, omega: DVec3) -> f64 {
    let m2 = (i * omega).length_squared();
    let e2 = (i * omega * omega).element_sum();
    // For M² > 2E I₂ the motion circles I₃; otherwise exchange 1 and 3.
    let (i1, i2, i3) = if m2 > e2 * i.y { (i.x, i.y, i.z) } else { (i.z, i.y, i.x) };
    let rate = ((i3 - i2) * (m2 - e2 * i1) / (i1 * i2 * i3)).sqrt();
    let k2 = (i2 - i1) * (e2 * i3 - m2) / ((i3 - i2) * (m2 - e2 * i1));
    2.0 * complete_elliptic(k2.sqrt()) / rate
}

/// Mean seconds between sign changes of ω about the middle axis, over 20 s.
fn measured_flip_interval(mut spin: Spin, steps_per_second: u32) -> f64 {
    let h = 1.0 / steps_per_second as f32;
    let mut flips = Vec::new();
    let mut before = in_principal_axes(&spin, spin.angular_velocity).y;
    for step in 0..20 * steps_per_second {
        advance(RotationScheme::Splitting, &mut spin, false, h);
        let now = in_principal_axes(&spin, spin.angular_velocity).y;
        if before * now < 0.0 {
            flips.push((f64::from(step) + before / (before - now)) / f64::from(steps_per_second));
        }
        before = now;
    }
    (flips[flips.len() - 1] - flips[0]) / (flips.len() - 1) as f64
}

#[test]
fn dzhanibekov_flips_on_time() {
    let exact = flip_interval(DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.1, 10.0, 0.1));
    assert!((exact - 1.95529).abs() < 5e-6, "closed form {exact}");
    // So near the separatrix (its distance is 5e-5 of the energy) f32 leaves milliseconds.
    for rate in [60, 240, 960] {
        let error = measured_flip_interval(tumbler(), rate) - exact;
        println!("flip interval at 1/{rate}: {error:+.6} s");
        assert!(error.abs() < 5e-3, "at 1/{rate}: {error} s");
    }
}

#[test]
fn splitting_is_of_second_order() {
    // Far from the separatrix the error of the scheme stands out of the rounding.
    let spin = Spin::new(Quat::IDENTITY, Vec3::new(1.0, 2.0, 3.0), Vec3::new(2.0, 10.0, 2.0));
    let exact = flip_interval(spin.principal_inertia.as_dvec3(), spin.angular_velocity.as_dvec3());
    let errors = [30, 60, 120, 240].map(|rate| (measured_flip_interval(spin, rate) - exact).abs());
    println!("flip interval {exact}, errors {errors:?} s");
    let order = (errors[0] / errors[2]).log(4.0);
    assert!((1.7..2.5).contains(&order), "measured order {order}");
    assert!(errors[3] < errors[2] && errors[2] < errors[1] && errors[1] < errors[0]);
}

#[test]
fn symmetric_top_precesses_steadily() {
    // Torque-free, I₁ = I₂: the axis moves on a cone about L at the rate |L|/I₁.
    let axis_start = DVec3::new(0.0, 0.0, 1.0);
    let start = Spin::new(Quat::IDENTITY, Vec3::new(2.0, 2.0, 0.5), Vec3::new(1.5, 0.0, 6.0));
    let momentum = start.angular_momentum.as_dvec3();
    let precession = DQuat::from_axis_angle(momentum.normalize(), momentum.length() / 2.0 * 10.0);
    let expected = precession * axis_start;
    for (rate, tolerance) in [(60_u32, 2e-2), (240, 2e-3)] {
        let mut spin = start;
        for _ in 0..10 * rate {
            advance(RotationScheme::Splitting, &mut spin, false, 1.0 / rate as f32);
        }
        let found = matrix(spin.rotation) * axis_start;
        assert!(found.angle_between(expected) < tolerance, "{} rad", found.angle_between(expected));
    }
}

#[test]
fn fast_spin_about_a_principal_axis_is_exact() {
    // 0.83 rad per step; the angle after n steps is n h ω for every scheme that is exact there.
    let omega = 50.0_f32;
    for (axis, inertia) in
        [(Vec3::X, Vec3::new(1.0, 2.0, 3.0)), (Vec3::Y, Vec3::ONE), (Vec3::Z, Vec3::new(1.0, 2.0, 3.0))]
    {
        let mut spin = Spin::new(Quat::IDENTITY, inertia, axis * omega);
        for _ in 0..600 {
            advance(RotationScheme::Splitting, &mut spin, false, 1.0 / 60.0);
        }
        let angle = 600.0 * f64::from(1.0_f32 / 60.0) * f64::from(omega);
        let expected = DMat3::from_axis_angle(axis.as_dvec3(), angle);
        let off = (matrix(spin.rotation) - expected).to_cols_array().iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        assert!(off < 1e-4, "about {axis}: {off:e}");
    }
}

#[test]
fn wild_tumbling_keeps_momentum_and_energy_range() {
    let mut spin = Spin::new(Quat::IDENTITY, Vec3::new(1.0, 2.0, 2.9), Vec3::new(30.0, 40.0, 5.0));
    let (least, most) = energy_range(&spin);
    let start = energy(&spin);
    for _ in 0..6000 {
        advance(RotationScheme::Splitting, &mut spin, false, 1.0 / 60.0);
        let now = energy(&spin);
        assert!(now > least * (1.0 - 1e-6) && now < most * (1.0 + 1e-6));
        assert!((now / start - 1.0).abs() < 0.5);
    }
}

#[test]
fn rotation_stays_orthonormal_for_a_million_steps() {
    for (scheme, steps) in [(RotationScheme::Splitting, 1_000_000), (RotationScheme::AngularMomentum, 100_000)] {
        for start in [tumbler(), oblique(), Spin::new(Quat::IDENTITY, Vec3::ONE, Vec3::new(1.0, 2.0, 3.0))] {
            let mut spin = start;
            let mut worst = 0.0_f64;
            for step in 0..steps {
                advance(scheme, &mut spin, false, 1.0 / 60.0);
                if step % 100 == 0 {
                    worst = worst.max(orthonormality_error(matrix(spin.rotation)));
                }
            }
            assert!(worst < 1e-6, "{scheme:?}: {worst:e}");
        }
    }
}

#[test]
fn how_the_talks_matrix_is_orthonormalized_decides() {
    // A6: with R never corrected its columns grow; corrected, they stay, and the energy drifts by way of it.
    let run = |how| {
        let inertia = Vec3::new(1.0, 2.0, 3.0);
        let momentum = inertia * Vec3::new(0.1, 10.0, 0.1);
        let (mut r, mut omega) = (Mat3::IDENTITY, Vec3::new(0.1, 10.0, 0.1));
        for _ in 0..600 {
            r = orthonormalized(how, turned_matrix(r, omega, 1.0 / 60.0));
            // ω' = R' I_body⁻¹ R'ᵀ L
            omega = r * ((r.transpose() * momentum) / inertia);
        }
        (r, 0.5 * momentum.dot(omega))
    };
    for how in [Orthonormalization::GramSchmidt, Orthonormalization::Polar] {
        let (r, energy) = run(how);
        assert!(orthonormality_error(r.as_dmat3()) < 1e-6);
        assert!(r.determinant() > 0.0);
        println!("{how:?}: energy {:+.1} %", 100.0 * (energy / 100.025 - 1.0));
    }
    let (r, _) = run(Orthonormalization::None);
    let norm = r.x_axis.length().max(r.y_axis.length()).max(r.z_axis.length());
    println!("None: column norm {norm:e}");
    assert!(norm.is_nan() || norm > 100.0, "{norm}");
}

#[test]
fn polar_factor_is_the_nearest_rotation() {
    // R + h[ω]ₓR has the polar factor exp(atan(h|ω|) [ω/|ω|]ₓ) R.
    let r = Mat3::from_quat(rotation_from_vector(Vec3::new(0.3, -0.8, 0.4)));
    for speed in [0.01, 1.0, 60.0, 500.0_f32] {
        let omega = Vec3::new(2.0, -1.0, 2.0) / 3.0 * speed;
        let angle = atan2(speed / 60.0, 1.0);
        let expected = Mat3::from_quat(rotation_from_vector(omega / speed * angle)) * r;
        let found = orthonormalized(Orthonormalization::Polar, turned_matrix(r, omega, 1.0 / 60.0));
        let off = (found - expected).to_cols_array().iter().fold(0.0_f32, |m, x| m.max(x.abs()));
        assert!(off < 2e-6, "{speed} rad/s: {off:e}");
    }
}

#[test]
fn locked_bodies_keep_their_angular_velocity() {
    for scheme in SCHEMES {
        let mut spin = oblique();
        spin.angular_velocity = Vec3::Z * 2.0;
        for _ in 0..60 {
            advance(scheme, &mut spin, true, 1.0 / 60.0);
        }
        assert_eq!(spin.angular_velocity, Vec3::Z * 2.0);
        let off = momentum_of_velocity(&spin) - spin.angular_momentum.as_dvec3();
        assert!(off.length() < 1e-5);
        let expected = rotation_from_vector(Vec3::Z * 2.0) * oblique().rotation;
        assert!(spin.rotation.dot(expected).abs() > 1.0 - 1e-6);
    }
}

#[test]
fn what_is_not_finite_stays_so() {
    for scheme in SCHEMES {
        for locked in [false, true] {
            for bad in [f32::NAN, f32::INFINITY] {
                let mut spin = tumbler();
                spin.angular_momentum.y = bad;
                spin.angular_velocity.y = bad;
                advance(scheme, &mut spin, locked, 1.0 / 60.0);
                assert!(!spin.rotation.is_finite() || !spin.angular_velocity.is_finite());
            }
        }
    }
    assert!(forces::limited(Vec3::new(f32::NAN, 0.0, 0.0), 10.0).is_nan());
}

#[test]
fn free_fall_is_the_discrete_sum() {
    // A1: g Δt² n(n+1)/2 for symplectic Euler.
    let (h, n) = (1.0_f32 / 64.0, 640);
    let (mut v, mut x) = (Vec3::ZERO, Vec3::ZERO);
    for _ in 0..n {
        v = forces::accelerated(v, Vec3::ZERO, Vec3::splat(0.5), Vec3::NEG_Y * 8.0, h);
        x += h * v;
    }
    // All numbers are binary fractions: no rounding at all.
    assert_eq!(x, Vec3::NEG_Y * 8.0 * h * h * (n * (n + 1) / 2) as f32);
    // Along a locked axis nothing acts.
    let locked = Vec3::new(0.5, 0.0, 0.5);
    let v = forces::accelerated(Vec3::ZERO, Vec3::new(2.0, 2.0, 0.0), locked, Vec3::NEG_Y * 8.0, 0.5);
    assert_eq!(v, Vec3::new(0.5, 0.0, 0.0));
}

#[test]
fn damping_does_not_depend_on_the_step() {
    let once = forces::damping_factor(3.0, 1.0);
    let mut often = 1.0_f32;
    for _ in 0..100 {
        often *= forces::damping_factor(3.0, 0.01);
    }
    assert!((f64::from(once) - (-3.0_f64).exp()).abs() < 1e-7);
    assert!((often / once - 1.0).abs() < 1e-5);
    assert_eq!(forces::damping_factor(0.0, 0.01), 1.0);
}

#[test]
fn torque_adds_up_in_the_momentum() {
    // τ constant in world: L = L₀ + τt whatever the body does meanwhile.
    let torque = Vec3::new(0.25, -0.5, 1.0);
    let mut spin = oblique();
    let start = spin.angular_momentum;
    for _ in 0..256 {
        forces::apply_angular_impulse(&mut spin, torque / 64.0, Vec3::ONE);
        advance(RotationScheme::Splitting, &mut spin, false, 1.0 / 64.0);
    }
    let expected = start + 4.0 * torque;
    assert!((spin.angular_momentum - expected).length() < 1e-5 * expected.length());
    let off = momentum_of_velocity(&spin) - spin.angular_momentum.as_dvec3();
    assert!(off.length() < 1e-6 * f64::from(expected.length()));
    // About a free axis alone, a locked body turns.
    let mut spin = oblique();
    spin.angular_velocity = Vec3::ZERO;
    forces::apply_angular_impulse(&mut spin, Vec3::ONE, Vec3::Y);
    assert!(spin.angular_velocity.y > 0.0 && spin.angular_velocity.x == 0.0 && spin.angular_velocity.z == 0.0);
}

#[test]
fn speed_limits_scale_and_keep_the_direction() {
    let v = forces::limited(Vec3::new(30.0, 40.0, 0.0), 10.0);
    assert!((v - Vec3::new(6.0, 8.0, 0.0)).length() < 1e-5);
    assert_eq!(forces::limited(Vec3::X, 10.0), Vec3::X);
    let mut spin = tumbler();
    let momentum = spin.angular_momentum;
    forces::limit_spin(&mut spin, 1.0);
    assert!((spin.angular_velocity.length() - 1.0).abs() < 1e-6);
    assert!(spin.angular_momentum.angle_between(momentum) < 1e-3);
    assert!((momentum_of_velocity(&spin) - spin.angular_momentum.as_dvec3()).length() < 1e-6);
}
