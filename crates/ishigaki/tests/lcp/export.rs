//! A step of the engine as a problem of the laboratory: the same λ, the same w.

use crate::problems::distance;
use ishigaki::lcp::{ExportedLcp, Method, RowKind, Settings, Status, lemke};
use ishigaki::{Body, BodyHandle, FrictionModel, Joint, Permutation, Shape, SolverOptions, Vec3, World, WorldOptions};

const DT: f32 = 1.0 / 60.0;

/// One substep of many sweeps without relaxing: the λ that stay are those of the exported problem.
fn options(change: impl FnOnce(&mut SolverOptions)) -> WorldOptions {
    let mut solver = SolverOptions { sweeps: 4000, ..SolverOptions::plain() };
    solver.permutation = Permutation::Alternating;
    change(&mut solver);
    let mut options = WorldOptions { solver, ..WorldOptions::default() };
    options.rest.sleep.enabled = false;
    options.rest.aggressive_sleep.enabled = false;
    options
}

/// Three boxes on each other, pushed aside, and a box that hangs on a ball joint.
fn world(change: impl FnOnce(&mut SolverOptions)) -> World {
    let mut world = World::new(options(change)).unwrap();
    let ground = world.add_body(Body::fixed(Shape::half_space(Vec3::Y))).unwrap();
    let cube = |x: f32, y: f32| Body::dynamic(Shape::cuboid(0.5, 0.5, 0.5)).mass(2.0).at(Vec3::new(x, y, 0.0));
    for k in 0..3 {
        let push = Vec3::new(0.3 * k as f32, 0.0, 0.1);
        world.add_body(cube(0.02 * k as f32, k as f32 + 0.499).velocity(push)).unwrap();
    }
    let bob = world.add_body(cube(5.0, 3.0)).unwrap();
    world.add_joint(Joint::ball(ground, bob, Vec3::new(4.4, 3.4, 0.3))).unwrap();
    world
}

/// λ that the engine stored in its contacts after a step, in the order of the rows.
fn stored(world: &World, export: &ExportedLcp) -> Vec<Option<f64>> {
    let model = world.options().solver.friction;
    let mut lambda: Vec<Option<f64>> = vec![None; export.labels.len()];
    let mut row = export.labels.iter().position(|l| l.kind != RowKind::Joint).unwrap();
    for contact in world.contacts() {
        for m in contact.manifolds {
            for p in m.points.iter().filter(|_| model != FrictionModel::Off) {
                for impulse in p.lambda_friction {
                    lambda[row] = Some(impulse.into());
                    row += 1;
                }
            }
            for p in &m.points {
                lambda[row] = Some(p.lambda_normal.into());
                row += 1;
            }
        }
    }
    assert_eq!(row, lambda.len());
    lambda
}

/// N·s and m/s: of bodies of 2 kg, by sums in f32.
const ROUNDING: f64 = 1e-5;

/// The engine's λ after a step, and the problem that it was to solve before.
fn step(change: impl Fn(&mut SolverOptions), what: &str) -> (ExportedLcp, Vec<f64>) {
    let mut world = world(change);
    let before = world.snapshot();
    let export = world.export_lcp(DT).unwrap();
    assert_eq!(world.snapshot(), before, "{what}: the export changed the world");
    world.step(DT);
    // Joints keep their λ to themselves; here they share no body with the contacts.
    let exact = Method::ProjectedGaussSeidel.solve(&export.problem, &Settings::default());
    let lambda: Vec<f64> = stored(&world, &export).iter().zip(&exact.lambda).map(|(e, l)| e.unwrap_or(*l)).collect();
    let residual = export.problem.residual(&lambda);
    assert!(residual < ROUNDING, "{what}: the engine leaves {residual:e}");
    (export, lambda)
}

/// `cold`: the methods find the engine's w from nothing, since there is no other. Otherwise they stay where the engine is.
fn compare(change: impl Fn(&mut SolverOptions), methods: &[Method], cold: bool, what: &str) {
    let (export, lambda) = step(change, what);
    let start = (!cold).then(|| lambda.clone());
    let settings = Settings { sweeps: 200_000, tolerance: 1e-12, start, ..Settings::default() };
    let w = export.problem.w(&lambda);
    for method in methods {
        let solution = method.solve(&export.problem, &settings);
        assert_eq!(solution.status, Status::Solved, "{what}: {} {:e}", method.name(), solution.residual);
        let error = distance(&w, &solution.w);
        eprintln!("{what}: {} rows, {}: w differs by {error:.1e}", w.len(), method.name());
        assert!(error < ROUNDING, "{what}: {}: {error:e}", method.name());
    }
}

#[test]
fn the_engine_solves_the_exported_problem() {
    let no_friction = |s: &mut SolverOptions| s.friction = FrictionModel::Off;
    compare(no_friction, &[Method::Lemke, Method::Dantzig, Method::ProjectedGaussSeidel], true, "no friction");
    // With friction several w may be solutions: a method that starts at the engine's stays there.
    let boxes = |s: &mut SolverOptions| s.friction = FrictionModel::Box;
    compare(boxes, &[Method::ProjectedGaussSeidel], false, "box");
    compare(|_| {}, &[Method::ProjectedGaussSeidel, Method::BlockProjectedGaussSeidel], false, "disk");
    // And the exact method finds one of them.
    let solution = lemke(&world(boxes).export_lcp(DT).unwrap().problem, &Settings::default());
    assert!(solution.status == Status::Solved && solution.residual < 1e-10, "{:e}", solution.residual);
}

#[test]
fn weight_amplification_is_exported_as_it_is() {
    let amplified = |s: &mut SolverOptions| {
        s.friction = FrictionModel::Box;
        s.weight_amplification.enabled = true;
    };
    compare(amplified, &[Method::Lemke, Method::ProjectedGaussSeidel], true, "WA");
    let [plain, amplified] = [world(|_| {}), world(amplified)].map(|w| w.export_lcp(DT).unwrap().problem);
    assert!(plain.a().asymmetry() < 1e-12, "{:e}", plain.a().asymmetry());
    assert!(amplified.a().asymmetry() > 0.01, "{:e}", amplified.a().asymmetry());
}

#[test]
fn labels_say_where_rows_come_from() {
    let world = world(|_| {});
    let export = world.export_lcp(DT).unwrap();
    let handles: Vec<BodyHandle> = world.bodies().map(|(handle, _)| handle).collect();
    let of = |kind| export.labels.iter().filter(move |l| l.kind == kind);
    assert_eq!(of(RowKind::Joint).count(), 3);
    assert!(of(RowKind::Joint).all(|l| l.bodies == [handles[0], handles[4]]));
    assert_eq!(of(RowKind::Normal).count(), 12);
    assert_eq!(of(RowKind::Tangent).count(), 24);
    for k in 0..3 {
        let pair = [handles[k], handles[k + 1]];
        let rows: Vec<_> = export.labels.iter().filter(|l| pair.iter().all(|h| l.bodies.contains(h))).collect();
        assert_eq!(rows.len(), 12);
        assert!(rows.iter().all(|l| l.group == rows[0].group), "one manifold, one group");
    }
    // Equality rows have no bounds; tangents hang on the normal of their point.
    let problem = &export.problem;
    for (i, label) in export.labels.iter().enumerate() {
        match (label.kind, &problem.friction()[i]) {
            (RowKind::Joint, None) => assert!(problem.lower()[i] == f64::NEG_INFINITY),
            (RowKind::Normal, None) => assert!((problem.lower()[i], problem.upper()[i]) == (0.0, f64::INFINITY)),
            (RowKind::Tangent, Some(f)) => {
                assert_eq!(f.normals.len(), 1);
                assert_eq!(export.labels[f.normals[0]], ishigaki::lcp::RowLabel { kind: RowKind::Normal, ..*label });
                assert!(f.partner.is_some() && f.coefficient > 0.0);
            }
            other => panic!("row {i}: {other:?}"),
        }
    }
}

#[test]
fn a_warm_start_is_near_the_solution_of_a_world_at_rest() {
    let mut world = world(|s| {
        s.warm_start.enabled = true;
        s.sweeps = 50;
    });
    (0..60).for_each(|_| drop(world.step(DT)));
    let export = world.export_lcp(DT).unwrap();
    let residual = |start: &[f64]| export.problem.residual(start);
    assert!(residual(&export.start) < 0.1 * residual(&vec![0.0; export.start.len()]));
}

#[test]
fn a_step_that_is_no_step_is_refused() {
    for dt in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let error = World::default().export_lcp(dt).unwrap_err().to_string();
        assert!(error.starts_with("dt: the step must be in"), "{error}");
    }
    let empty = World::default().export_lcp(DT).unwrap();
    assert!(empty.problem.is_empty() && lemke(&empty.problem, &Settings::default()).status == Status::Solved);
}
