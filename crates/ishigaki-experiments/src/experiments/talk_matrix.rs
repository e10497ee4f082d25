//! B12: the talk's example of many bodies: contacts a, b between 0 and 1, c between 0 and 2, equality d between 1 and 2.

use crate::chart::Chart;
use crate::setup::{DT, change_options, plain, world};
use crate::verdict::short;
use crate::{Error, Experiment, Lab, Result, Verdict};
use glam::{DMat3, DVec3};
use ishigaki::constraint::frame::{BodyFrame, JointStep};
use ishigaki::constraint::joint_rows::ResolvedJoint;
use ishigaki::constraint::row::Jacobian;
use ishigaki::{Body, BodyHandle, FrictionModel, Joint, Shape, Vec3, World};

pub const EXPERIMENT: Experiment = Experiment {
    name: "talk-matrix",
    rows: &["B12"],
    title: "The talk's example: contacts a, b (bodies 0, 1), c (0, 2), equality d (1, 2)",
    run,
};

/// Body 0 below, a lying capsule (1) and a ball (2) on it, joined by a rod; nothing is fixed.
fn build() -> Result<(World, [BodyHandle; 3], Joint)> {
    let mut world = world(plain(|s| {
        s.friction = FrictionModel::Off;
        // Recovery would soften d and be seen in its diagonal.
        s.joint_recovery.enabled = false;
    }))?;
    change_options(&mut world, |o| o.gravity = Vec3::ZERO)?;
    let capsule = Shape::capsule_between(Vec3::new(-0.4, 0.0, 0.0), Vec3::new(0.4, 0.0, 0.0), 0.25);
    let bodies = [
        world.add_body(Body::dynamic(Shape::cuboid(1.5, 0.5, 0.75)).density(400.0))?,
        world.add_body(Body::dynamic(capsule).at(Vec3::new(-0.6, 0.75, 0.1)).velocity(-Vec3::Y))?,
        world.add_body(Body::dynamic(Shape::ball(0.3)).at(Vec3::new(0.8, 0.8, -0.2)).velocity(-0.5 * Vec3::Y))?,
    ];
    let rod = Joint::distance(bodies[1], bodies[2], Vec3::new(-0.2, 0.75, 0.1), Vec3::new(0.8, 0.8, -0.2), 0.0..=0.0);
    let length = Vec3::new(1.0, 0.05, -0.3).length();
    let rod = Joint { kind: ishigaki::JointKind::Distance { range: (length..=length).into(), spring: None }, ..rod };
    world.add_joint(rod.clone())?;
    Ok((world, bodies, rod))
}

/// A row and the two bodies it acts on.
type FullRow = (usize, usize, Jacobian);

/// The engine's f32 rows in its order: the joint's, then those of the contacts.
fn rows(world: &World, bodies: &[BodyHandle; 3], rod: &Joint) -> Result<Vec<FullRow>> {
    let index = |handle: BodyHandle| bodies.iter().position(|b| *b == handle);
    let missing = || Error::Missing("a contact with an unknown body".to_string());
    let frame = |handle: BodyHandle| {
        world.body(handle).map(|b| BodyFrame::at_rest(b.center(), b.rotation())).ok_or_else(missing)
    };
    let (a, b) = (frame(rod.body_a)?, frame(rod.body_b)?);
    let mut resolved = ResolvedJoint::new(rod, &a, Vec3::ZERO, &b, Vec3::ZERO);
    let mut specs = Vec::new();
    resolved.rows(&rod.kind, &a, &b, &JointStep { h: DT, recovery_rate: 0.0 }, &mut specs);
    let mut rows: Vec<FullRow> = specs.iter().map(|spec| (1, 2, spec.jacobian)).collect();
    // The contacts of this step, found at the poses before it.
    let mut stepped = world.clone();
    stepped.step(DT);
    for contact in stepped.contacts() {
        let (a, b) = (index(contact.a.body).ok_or_else(missing)?, index(contact.b.body).ok_or_else(missing)?);
        for manifold in contact.manifolds {
            for p in &manifold.points {
                rows.push((a, b, Jacobian::point(manifold.normal, p.arm_a, p.arm_b)));
            }
        }
    }
    Ok(rows)
}

/// J M⁻¹Jᵀ with the whole of J (rows × 18) and of M (18 × 18), widened to f64.
fn dense(world: &World, bodies: &[BodyHandle; 3], rows: &[FullRow]) -> Result<Vec<Vec<f64>>> {
    let mut inverse_masses = Vec::new();
    for handle in bodies {
        let body = world.body(*handle).ok_or_else(|| Error::Missing("a body is gone".to_string()))?;
        let mass = body.mass_properties();
        // Nothing is turned: the principal axes are those of the world.
        let inverse_inertia = mass.principal_inertia.recip().as_dvec3();
        inverse_masses.push((f64::from(1.0 / mass.mass), DMat3::from_diagonal(inverse_inertia)));
    }
    let full: Vec<[[DVec3; 2]; 3]> = rows
        .iter()
        .map(|(a, b, j)| {
            let mut blocks = [[DVec3::ZERO; 2]; 3];
            blocks[*a] = [j.linear.as_dvec3(), j.angular_a.as_dvec3()];
            blocks[*b] = [-j.linear.as_dvec3(), j.angular_b.as_dvec3()];
            blocks
        })
        .collect();
    let entry = |i: &[[DVec3; 2]; 3], j: &[[DVec3; 2]; 3]| {
        (0..3).map(|k| i[k][0].dot(inverse_masses[k].0 * j[k][0]) + i[k][1].dot(inverse_masses[k].1 * j[k][1])).sum()
    };
    Ok(full.iter().map(|i| full.iter().map(|j| entry(i, j)).collect()).collect())
}

/// Least pivot of the Cholesky factorization over the greatest diagonal: ≥ 0 for positive semidefinite matrices.
fn least_pivot(a: &[Vec<f64>]) -> f64 {
    let n = a.len();
    let (mut m, mut least) = (a.to_vec(), f64::INFINITY);
    let greatest = (0..n).map(|i| a[i][i]).fold(0.0, f64::max);
    for k in 0..n {
        least = least.min(m[k][k] / greatest);
        let (above, below) = m.split_at_mut(k + 1);
        for row in below {
            let factor = row[k] / above[k][k];
            row.iter_mut().zip(&above[k]).skip(k).for_each(|(x, pivot)| *x -= factor * pivot);
        }
    }
    least
}

fn run(lab: &mut Lab<'_>) -> Result<Verdict> {
    let (world, bodies, rod) = build()?;
    let export = world.export_lcp(DT)?;
    let a = export.problem.a();
    let rows = rows(&world, &bodies, &rod)?;
    if a.rows() != rows.len() || rows.len() != 4 {
        return Err(Error::Missing(format!("{} rows where the example has 4", a.rows())));
    }
    let full = dense(&world, &bodies, &rows)?;
    let names = ["d (1, 2)", "a (0, 1)", "b (0, 1)", "c (0, 2)"];
    let greatest = full.iter().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
    let mut apart = 0.0_f64;
    let mut table = Chart::table("A = J M⁻¹Jᵀ, 1/t", "1/t", names).shade(f64::abs);
    let mut blocks = Chart::table("Blocks of J: which bodies a row acts on", "blocks", ["body 0", "body 1", "body 2"]);
    for (i, name) in names.iter().enumerate() {
        table = table.row(*name, (0..4).map(|j| (1e3 * a[(i, j)], short(1e3 * a[(i, j)]))));
        apart = (0..4).map(|j| (a[(i, j)] - full[i][j]).abs() / greatest).fold(apart, f64::max);
        let acts = |body: usize| rows[i].0 == body || rows[i].1 == body;
        blocks = blocks
            .row(*name, (0..3).map(|k| (f64::from(u8::from(acts(k))), if acts(k) { "J" } else { "0" }.to_string())));
    }
    lab.chart(blocks);
    lab.chart(table);
    let shared = |i: usize, j: usize| [rows[i].0, rows[i].1].iter().any(|b| [rows[j].0, rows[j].1].contains(b));
    let coupled =
        (0..4).flat_map(|i| (0..4).map(move |j| (i, j))).filter(|&(i, j)| shared(i, j) && a[(i, j)] == 0.0).count();
    Ok(Verdict::on(
        "for many bodies J is sparse, constraint by body, and A = J M⁻¹Jᵀ couples the constraints \
        that share a body",
    )
    .at_most("sparse A from dense A", "of the greatest entry", 1e-12, apart)
    .at_most("asymmetry of A", "of the greatest entry", 1e-12, a.asymmetry() / greatest)
    .at_least("least pivot", "of the greatest diagonal", 0.0, least_pivot(&full))
    .open("entries of rows that share a body and are zero", "", coupled as f64)
    .note(
        "The rows are the engine's in f32, widened to f64: then sparse and dense products differ by \
            rounding alone.",
    ))
}
