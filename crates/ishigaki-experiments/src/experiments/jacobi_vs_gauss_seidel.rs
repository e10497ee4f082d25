//! C5: Gauss–Seidel uses what it has just found, and needs half the sweeps of Jacobi.

use crate::chart::Chart;
use crate::setup::{DT, G, add_column, plain, scene, world};
use crate::{Experiment, Lab, Result, Verdict};
use ishigaki::FrictionModel;
use ishigaki::lcp::{BoxLcp, Method, Settings};

pub const EXPERIMENT: Experiment = Experiment {
    name: "jacobi-vs-gauss-seidel",
    rows: &["C5"],
    title: "Jacobi and Gauss–Seidel on matrices of the engine",
    run,
};

/// The first step of a column of `n` balls, one row to a contact.
fn column(n: usize) -> Result<BoxLcp> {
    let mut world = world(plain(|s| s.friction = FrictionModel::Off))?;
    add_column(&mut world, n)?;
    Ok(world.export_lcp(DT)?.problem)
}

/// Greatest speed of a ball after each sweep, over gΔt, until it is 0.3 %.
fn speeds(problem: &BoxLcp, method: Method) -> Vec<(f64, f64)> {
    let mut settings = Settings { tolerance: 0.0, ..Settings::sweeps(1) };
    let mut seen = Vec::new();
    for sweep in 1..=4000 {
        let solution = method.solve(problem, &settings);
        // Contacts from the ground up: the speed of a ball is the sum of the gaps' rates below it.
        let (mut speed, mut greatest) = (0.0, 0.0_f64);
        for w in &solution.w {
            speed += w;
            greatest = greatest.max(f64::abs(speed));
        }
        seen.push((f64::from(sweep), greatest / f64::from(G * DT)));
        if greatest < 0.003 * f64::from(G * DT) {
            break;
        }
        settings.start = Some(solution.lambda);
    }
    seen
}

/// The first sweep from which on the speed is at most 1 %.
fn to_one_percent(seen: &[(f64, f64)]) -> f64 {
    let last = seen.iter().rposition(|s| s.1 > 0.01);
    last.and_then(|i| seen.get(i + 1)).map_or(f64::NAN, |s| s.0)
}

/// What is left of the error by one sweep, in the end.
fn rate(seen: &[(f64, f64)]) -> f64 {
    let n = seen.len();
    (seen[n - 1].1 / seen[n - 21].1).powf(0.05)
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let mut verdict = Verdict::on("Gauss–Seidel needs 1.5 to 2 times fewer sweeps than Jacobi");
    let mut chart = Chart::curves("Column of n balls", "sweeps", "greatest speed / gΔt").log(true, true);
    let cases: &[(usize, f64, f64, f64)] =
        lab.choose(&[(10, 392.0, 192.0, 2.04), (20, 1570.0, 776.0, 2.02)], &[(10, 392.0, 192.0, 2.04)]);
    for (i, &(n, slow, fast, ratio)) in cases.iter().enumerate() {
        lab.progress(i as f64 / 3.0, &format!("column of {n}"));
        let problem = column(n)?;
        let (jacobi, gauss_seidel) = (speeds(&problem, Method::Jacobi), speeds(&problem, Method::GaussSeidel));
        let (j, g) = (to_one_percent(&jacobi), to_one_percent(&gauss_seidel));
        verdict = verdict
            .near(format!("n = {n}: Jacobi, sweeps to 1 %"), "", slow, 3.0, j)
            .near(format!("n = {n}: Gauss–Seidel, sweeps to 1 %"), "", fast, 3.0, g)
            .near(format!("n = {n}: ratio"), "", ratio, 0.01, j / g)
            .near(format!("n = {n}: ρ_GS / ρ_J²"), "", 1.0, 1e-3, rate(&gauss_seidel) / rate(&jacobi).powi(2));
        chart = chart.line(format!("n = {n}, Jacobi"), jacobi).line(format!("n = {n}, Gauss–Seidel"), gauss_seidel);
    }
    lab.chart(chart.level(0.01, "1 %"));

    lab.progress(0.7, "pyramid");
    let base = lab.choose(6.0, 3.0);
    let pyramid = scene("pyramid", &[("base", base)], |o| o.solver = plain(|s| s.friction = FrictionModel::Off))?;
    let problem = pyramid.world.export_lcp(DT)?.problem;
    let settings = Settings { tolerance: 0.0, ..Settings::sweeps(lab.choose(200, 60)) };
    let mut chart = Chart::curves(
        format!("Pyramid of {base} boxes at its base, no friction"),
        "sweeps",
        "residual / that of the first",
    )
    .log(false, true);
    let mut last = Vec::new();
    for (name, method) in
        [("projected Jacobi", Method::ProjectedJacobi), ("projected Gauss–Seidel", Method::ProjectedGaussSeidel)]
    {
        let residuals = method.solve(&problem, &settings).residuals;
        let start = residuals.first().copied().unwrap_or(f64::NAN);
        let curve: Vec<(f64, f64)> =
            residuals.iter().enumerate().map(|(i, r)| ((i + 1) as f64, (r / start).min(1e12))).collect();
        last.push(curve.last().map_or(f64::NAN, |c| c.1));
        chart = chart.line(name, curve.into_iter().filter(|c| c.1 < 1e6).collect());
    }
    lab.chart(chart);
    Ok(verdict
        .at_least("pyramid: residual of Jacobi, over its first", "×", 10.0, last[0])
        .at_most("pyramid: residual of Gauss–Seidel, over its first", "×", 0.2, last[1])
        .note("Jacobi diverges where many rows meet in a body, as in pyramids, with four points to a face."))
}
