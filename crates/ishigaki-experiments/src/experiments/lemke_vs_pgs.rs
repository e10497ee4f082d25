//! C3, C4, C7: pivoting and sweeping find the same velocities.

use crate::chart::Chart;
use crate::setup::{DT, plain, scene, world};
use crate::{Experiment, Lab, Result, Verdict};
use ishigaki::lcp::{BoxLcp, Matrix, Method, Order, Settings};
use ishigaki::{Body, FrictionModel, Joint, Shape, Vec3};
use ishigaki_scenes::named::Random;

pub const EXPERIMENT: Experiment = Experiment {
    name: "lemke-vs-pgs",
    rows: &["C3", "C4", "C7"],
    title: "Lemke, Dantzig, PGS and NNCG on the same box LCPs",
    run,
};

/// Problems of the engine without friction, and random ones: name, problem.
fn problems(random_ones: usize, size: usize) -> Result<Vec<(String, BoxLcp)>> {
    let mut problems = Vec::new();
    for (name, scene_name, parameters) in [("stack", "tower", [("n", 4.0)]), ("pyramid", "pyramid", [("base", 3.0)])] {
        let scene = scene(scene_name, &parameters, |o| o.solver = plain(|s| s.friction = FrictionModel::Off))?;
        problems.push((name.to_string(), scene.world.export_lcp(DT)?.problem));
    }
    problems.push(("chain".to_string(), chain()?));
    let mut random = Random::new(3);
    for k in 0..random_ones {
        problems.push((format!("random {}", k + 1), random_box_lcp(&mut random, size)?));
    }
    Ok(problems)
}

/// Six balls joined by rods over a box: equalities, contacts and limits at once.
fn chain() -> Result<BoxLcp> {
    let mut world = world(plain(|s| {
        s.friction = FrictionModel::Off;
        s.joint_recovery.enabled = false;
    }))?;
    world.add_body(Body::fixed(Shape::cuboid(1.2, 0.5, 1.0)).at(-0.5 * Vec3::Y))?;
    let mut last = None;
    for k in 0..6 {
        let center = Vec3::new(0.5 * k as f32 - 1.25, 0.2, 0.0);
        let ball = world.add_body(Body::dynamic(Shape::ball(0.2)).at(center).velocity(Vec3::new(
            0.0,
            -0.5,
            0.1 * k as f32,
        )))?;
        if let Some(last) = last {
            world.add_joint(Joint::ball_about(last, ball, center - 0.25 * Vec3::X, Vec3::X).cone(0.3))?;
        }
        last = Some(ball);
    }
    Ok(world.export_lcp(DT)?.problem)
}

/// Symmetric positive definite A = BᵀB + 0.1, bounds of every kind.
fn random_box_lcp(random: &mut Random, n: usize) -> Result<BoxLcp> {
    let mut number = |size: f32| f64::from(random.between(-size, size));
    let b: Vec<Vec<f64>> = (0..n).map(|_| (0..n).map(|_| number(1.0)).collect()).collect();
    let a = Matrix::from_fn(n, n, |i, j| {
        let product: f64 = b.iter().map(|row| row[i] * row[j]).sum();
        product / n as f64 + if i == j { 0.1 } else { 0.0 }
    });
    let offsets = (0..n).map(|_| number(1.0)).collect();
    let bounds = |i: usize| match i % 4 {
        0 => (0.0, f64::INFINITY),
        1 => (f64::NEG_INFINITY, f64::INFINITY),
        2 => (-0.5, 0.5),
        _ => (f64::NEG_INFINITY, 0.2),
    };
    let (lower, upper) = (0..n).map(bounds).unzip();
    Ok(BoxLcp::new(a, offsets, lower, upper)?)
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let problems = problems(lab.choose(5, 1), lab.choose(40, 12))?;
    let sweeps = lab.choose(200_000, 30_000);
    const METHODS: [(&str, Method); 4] = [
        ("PGS", Method::ProjectedGaussSeidel),
        ("block PGS", Method::BlockProjectedGaussSeidel),
        ("NNCG", Method::Nncg),
        ("Dantzig", Method::Dantzig),
    ];
    let settings = Settings { tolerance: 1e-13, order: Order::Alternating, ..Settings::sweeps(sweeps) };
    let mut bars = Chart::bars(
        "Greatest difference of w from that of Lemke's method",
        "difference, 10⁻¹² m/s",
        METHODS.map(|m| m.0),
    )
    .log(false, true);
    let mut chart = Chart::curves("The pyramid by sweeps", "sweeps", "residual / that of the start").log(true, true);
    let mut worst = [0.0_f64; METHODS.len()];
    let (mut lemke_worst, count) = (0.0_f64, problems.len());
    for (i, (name, problem)) in problems.iter().enumerate() {
        lab.progress(i as f64 / count as f64, name);
        let lemke = Method::Lemke.solve(problem, &settings);
        let size = problem.residual(&problem.cold_start());
        lemke_worst = lemke_worst.max(lemke.residual / size);
        let mut values = Vec::new();
        for ((label, method), worst) in METHODS.iter().zip(&mut worst) {
            let solution = method.solve(problem, &settings);
            let apart = solution.w.iter().zip(&lemke.w).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            *worst = worst.max(apart);
            values.push((1e12 * apart).max(1e-6));
            if name.starts_with("pyramid") && *label != "Dantzig" {
                let curve = solution.residuals.iter().enumerate().map(|(k, r)| ((k + 1) as f64, r / size));
                chart = chart.line(*label, curve.filter(|p| p.1 > 1e-10).collect());
            }
        }
        bars = bars.group(name.as_str(), values);
    }
    lab.chart(bars);
    lab.chart(chart);
    let mut verdict = Verdict::on(
        "the box LCP has one solution of velocities; Lemke finds it by pivots, \
        projected Gauss–Seidel in the limit",
    )
    .at_most("Lemke: residual over that of the start", "", 1e-8, lemke_worst);
    for ((label, _), worst) in METHODS.iter().zip(worst) {
        verdict = verdict.at_most(format!("{label}: w differs by"), "m/s", 1e-8, worst);
    }
    Ok(verdict.note(
        "λ itself may differ where A is singular, as with four points to a face; w may not. The \
        slide's Lemke–Howson is the method for bimatrix games; Lemke's is meant.",
    ))
}
