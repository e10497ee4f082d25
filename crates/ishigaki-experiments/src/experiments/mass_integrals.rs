//! A4: mass, center and inertia of each basic shape against volume integrals by sampling.

use crate::chart::Chart;
use crate::{Experiment, Lab, Result, Verdict};
use glam::{DMat3, DVec3};
use ishigaki::{MassProperties, Pose, Quat, Shape, Vec3};
use ishigaki_scenes::named::Random;

pub const EXPERIMENT: Experiment = Experiment {
    name: "mass-integrals",
    rows: &["A4"],
    title: "Formulas of mass and inertia against sampled volume integrals",
    run,
};

/// A shape, the half size of a box around it, and whether a point is inside.
struct Case {
    name: &'static str,
    shape: Shape,
    half: DVec3,
    inside: Box<dyn Fn(DVec3) -> bool>,
}

impl Case {
    fn new(name: &'static str, shape: Shape, half: [f64; 3], inside: impl Fn(DVec3) -> bool + 'static) -> Self {
        Self { name, shape, half: DVec3::from_array(half), inside: Box::new(inside) }
    }
}

fn in_capsule(x: DVec3) -> bool {
    (x - DVec3::new(0.0, x.y.clamp(-0.6, 0.6), 0.0)).length() < 0.4
}

fn in_box(x: DVec3, center: DVec3, half: DVec3) -> bool {
    (x - center).abs().cmplt(half).all()
}

fn cases() -> Result<Vec<Case>> {
    // An octahedron of unequal axes as a hull.
    let axes = DVec3::new(0.9, 0.5, 0.7);
    let corners: Vec<Vec3> =
        [Vec3::X, Vec3::Y, Vec3::Z].iter().flat_map(|&e| [e, -e]).map(|e| e * axes.as_vec3()).collect();
    let quarter = Quat::from_xyzw(0.0, 0.0, 0.5_f32.sqrt(), 0.5_f32.sqrt());
    let hammer = Shape::compound(vec![
        Shape::cylinder(0.5, 0.1).at(Vec3::new(0.0, -0.3, 0.0)),
        Shape::cuboid(0.15, 0.4, 0.15).posed(Pose::from_parts(Vec3::new(0.0, 0.35, 0.0), quarter)),
    ]);
    Ok(vec![
        Case::new("ball", Shape::ball(0.7), [0.7; 3], |x| x.length() < 0.7),
        Case::new("box", Shape::cuboid(0.5, 1.0, 1.5), [0.6, 1.1, 1.6], |x| {
            in_box(x, DVec3::ZERO, DVec3::new(0.5, 1.0, 1.5))
        }),
        Case::new("capsule", Shape::capsule(0.6, 0.4), [0.4, 1.0, 0.4], in_capsule),
        Case::new("cylinder", Shape::cylinder(0.8, 0.5), [0.5, 0.8, 0.5], |x| x.x.hypot(x.z) < 0.5),
        Case::new("cone", Shape::cone(0.9, 0.6), [0.6, 0.9, 0.6], |x| x.x.hypot(x.z) < 0.6 * (0.9 - x.y) / 1.8),
        Case::new("hull", Shape::convex_hull(&corners)?, axes.to_array(), move |x| {
            (x / axes).abs().element_sum() < 1.0
        }),
        Case::new("compound", hammer, [0.4, 0.8, 0.15], |x| {
            // Handle and head touch in y = 0.2 and do not overlap.
            (x.x.hypot(x.z) < 0.1 && (-0.8..0.2).contains(&x.y))
                || in_box(x, DVec3::new(0.0, 0.35, 0.0), DVec3::new(0.4, 0.15, 0.15))
        }),
    ])
}

fn outer(v: DVec3) -> DMat3 {
    DMat3::from_cols(v * v.x, v * v.y, v * v.z)
}

/// Mass, center and inertia about the center by one random point in each of `n`³ cells.
fn sampled(case: &Case, n: u32) -> (f64, DVec3, DMat3) {
    let mut random = Random::new(7);
    let cell = 2.0 * case.half / f64::from(n);
    let (mut count, mut first, mut second) = (0.0, DVec3::ZERO, DMat3::ZERO);
    for i in 0..n * n * n {
        let place = DVec3::new(f64::from(i % n), f64::from(i / n % n), f64::from(i / (n * n)));
        let jitter = DVec3::from_array([(); 3].map(|()| f64::from(random.unit())));
        let x = cell * (place + jitter) - case.half;
        if (case.inside)(x) {
            count += 1.0;
            first += x;
            second += outer(x);
        }
    }
    let (weight, center) = (f64::from(case.shape.density) * cell.element_product(), first / count);
    let covariance = weight * (second - count * outer(center));
    let trace = covariance.x_axis.x + covariance.y_axis.y + covariance.z_axis.z;
    (weight * count, center, DMat3::from_diagonal(DVec3::splat(trace)) - covariance)
}

fn greatest(m: DMat3) -> f64 {
    m.to_cols_array().iter().fold(0.0, |a, x| a.max(x.abs()))
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let n = lab.choose(140, 60);
    let mut chart = Chart::bars(
        format!("Relative deviation of the formula from {} samples", u64::from(n).pow(3)),
        "relative deviation",
        ["mass", "center", "inertia"],
    )
    .log(false, true);
    let (cases, mut worst) = (cases()?, 0.0_f64);
    let count = cases.len();
    for (i, case) in cases.iter().enumerate() {
        lab.progress(i as f64 / count as f64, case.name);
        let (mass, center, inertia) = sampled(case, n);
        let found = MassProperties::of_shapes(std::slice::from_ref(&case.shape));
        let deviations = [
            (f64::from(found.mass) / mass - 1.0).abs(),
            (found.center.as_dvec3() - center).length() / case.half.max_element(),
            greatest(found.matrix().as_dmat3() - inertia) / greatest(inertia),
        ];
        worst = deviations.iter().copied().fold(worst, f64::max);
        chart = chart.group(case.name, deviations);
    }
    lab.chart(chart);

    // M/12 · diag(y²+z², z²+x², x²+y²) with full edges 1, 2, 3 m and 60 kg: 5 · (13, 10, 5) kg·m².
    let brick = MassProperties::of_shapes(&[Shape::cuboid(0.5, 1.0, 1.5).density(10.0)]);
    let off = (brick.principal_inertia - Vec3::new(65.0, 50.0, 25.0)).length();
    Ok(Verdict::on("I = R I' Rᵀ, with a formula for I' of each basic shape")
        .at_most("worst deviation from the integrals", "", lab.choose(1e-3, 5e-3), worst)
        .at_most("box, from the slide's formula", "kg·m²", 0.0, f64::from(off)))
}
