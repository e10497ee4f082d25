//! The snippets of the book (`book/src`), each run as a test: the chapters take them from here by their anchors.

// ANCHOR: first_world
use ishigaki::{Body, Shape, Vec3, World, WorldOptions};

/// A ball falls from 3 m and comes to rest on the ground.
#[test]
fn first_world() -> ishigaki::Result<()> {
    let mut world = World::new(WorldOptions::default())?;
    world.add_body(Body::fixed(Shape::half_space(Vec3::Y)))?;
    let ball = world.add_body(Body::dynamic(Shape::ball(0.5)).density(600.0).at(3.0 * Vec3::Y))?;
    for _ in 0..120 {
        world.step(1.0 / 60.0);
    }
    let height = world.body(ball).map_or(f32::NAN, |state| state.position().y);
    assert!((height - 0.5).abs() < 0.02);
    Ok(())
}
// ANCHOR_END: first_world

// ANCHOR: free_fall
/// v' = v + Δt g, x' = x + Δt v': after n steps a body has fallen by gΔt² n(n+1)/2.
#[test]
fn free_fall() -> ishigaki::Result<()> {
    let mut options = WorldOptions::default();
    options.solver.substeps = 1;
    let mut world = World::new(options)?;
    let ball = world.add_body(Body::dynamic(Shape::ball(0.1)))?;
    let (n, dt) = (60, 1.0 / 60.0);
    for _ in 0..n {
        world.step(dt);
    }
    let fallen = world.body(ball).map_or(f32::NAN, |state| -state.position().y);
    let sum = 9.81 * dt * dt * (n * (n + 1)) as f32 / 2.0;
    assert!((fallen - sum).abs() < 1e-4, "{fallen} m instead of {sum} m");
    Ok(())
}
// ANCHOR_END: free_fall

// ANCHOR: tumbling
/// A free body of three different moments, ten seconds at 60 Hz: what each scheme makes of its energy.
#[test]
fn tumbling() {
    use ishigaki::motion::{Spin, advance};
    use ishigaki::{Quat, RotationScheme};

    let energy_after = |scheme| {
        let mut spin = Spin::new(Quat::IDENTITY, Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.1, 10.0, 0.1));
        let start = spin.kinetic_energy();
        for _ in 0..600 {
            advance(scheme, &mut spin, false, 1.0 / 60.0);
        }
        spin.kinetic_energy() / start
    };
    assert!(energy_after(RotationScheme::ExplicitEuler) > 1e5); // ω is the state: it explodes
    let talk = energy_after(RotationScheme::AngularMomentum); // L is the state: bounded, but it drifts
    assert!((2.0 / 3.0 - 1e-3..2.0 + 1e-3).contains(&talk));
    let splitting = energy_after(RotationScheme::Splitting); // L is the state, turned axis by axis
    assert!((splitting - 1.0).abs() < 2e-4);
}
// ANCHOR_END: tumbling

// ANCHOR: axis_velocity
/// w = J u for a contact is the velocity of the two touching points, projected on the normal.
#[test]
fn axis_velocity() {
    use ishigaki::constraint::row::Jacobian;

    let normal = Vec3::Y;
    let (arm_a, arm_b) = (Vec3::new(0.3, -0.5, 0.1), Vec3::new(-0.2, 0.4, 0.0));
    let (v_a, omega_a) = (Vec3::new(1.0, -2.0, 0.5), Vec3::new(0.2, 0.0, 3.0));
    let (v_b, omega_b) = (Vec3::new(0.0, 0.5, 0.0), Vec3::new(-1.0, 2.0, 0.0));

    let j = Jacobian::point(normal, arm_a, arm_b);
    let w = j.linear.dot(v_a - v_b) + j.angular_a.dot(omega_a) + j.angular_b.dot(omega_b);

    let point_of_a = v_a + omega_a.cross(arm_a);
    let point_of_b = v_b + omega_b.cross(arm_b);
    assert!((w - normal.dot(point_of_a - point_of_b)).abs() < 1e-6);
}
// ANCHOR_END: axis_velocity

// ANCHOR: door
/// A door that opens by at most 1.5 rad, pushed by a draft: the hinge holds it, the range stops it.
#[test]
fn door() -> ishigaki::Result<()> {
    use ishigaki::{BodyKind, Joint};

    let mut world = World::default();
    let frame = world.add_body(Body::empty(BodyKind::Fixed))?;
    let panel = Body::dynamic(Shape::cuboid(0.5, 1.0, 0.03)).mass(30.0).at(Vec3::new(0.5, 1.0, 0.0));
    let door = world.add_body(panel)?;
    let hinge = world.add_joint(Joint::hinge(frame, door, Vec3::Y, Vec3::Y).limit(0.0..=1.5))?;
    for _ in 0..240 {
        if let Some(mut door) = world.body_mut(door) {
            door.apply_torque(20.0 * Vec3::Y)?;
        }
        world.step(1.0 / 60.0);
    }
    let angle = world.joint(hinge).map_or(f32::NAN, |joint| joint.coordinates()[0]);
    assert!((angle - 1.5).abs() < 0.02, "{angle} rad");
    Ok(())
}
// ANCHOR_END: door

// ANCHOR: lcp
/// A step of the engine as a box LCP, solved by pivoting and by sweeping: the same velocities.
#[test]
fn step_as_lcp() -> ishigaki::Result<()> {
    use ishigaki::lcp::{Method, Settings, Status};

    let mut options = WorldOptions::default();
    options.solver.friction = ishigaki::FrictionModel::Off;
    let mut world = World::new(options)?;
    world.add_body(Body::fixed(Shape::half_space(Vec3::Y)))?;
    for k in 0..3 {
        world.add_body(Body::dynamic(Shape::cuboid(0.5, 0.5, 0.5)).at((k as f32 + 0.5) * Vec3::Y))?;
    }
    let problem = world.export_lcp(1.0 / 60.0)?.problem;
    let lemke = Method::Lemke.solve(&problem, &Settings::default());
    let pgs = Method::ProjectedGaussSeidel.solve(&problem, &Settings::default());
    assert_eq!((lemke.status, pgs.status), (Status::Solved, Status::Solved));
    for (exact, swept) in lemke.w.iter().zip(&pgs.w) {
        assert!((exact - swept).abs() < 1e-8);
    }
    Ok(())
}
// ANCHOR_END: lcp

// ANCHOR: murty
/// w = Aλ + b with 0 ≤ λ ⟂ w ≥ 0, by hand: one row presses, the other lets go.
#[test]
fn two_rows_by_hand() -> ishigaki::Result<()> {
    use ishigaki::lcp::{BoxLcp, Matrix, Settings, projected_gauss_seidel};

    let a = Matrix::from_fn(2, 2, |i, j| if i == j { 2.0 } else { 1.0 });
    let problem = BoxLcp::new(a, vec![-4.0, 1.0], vec![0.0; 2], vec![f64::INFINITY; 2])?;
    let solution = projected_gauss_seidel(&problem, &Settings::default());
    // λ = (2, 0): the first row is solved, w₁ = 0; the second opens, w₂ = 2 + 1 = 3.
    assert!((solution.lambda[0] - 2.0).abs() < 1e-9 && solution.lambda[1] == 0.0);
    assert!(solution.w[0].abs() < 1e-9 && (solution.w[1] - 3.0).abs() < 1e-9);
    Ok(())
}
// ANCHOR_END: murty

// ANCHOR: switches
/// From the talk's recipe, one technique left out: everything else stays as it was.
#[test]
fn one_technique_left_out() -> ishigaki::Result<()> {
    use ishigaki::SolverOptions;

    let mut options = WorldOptions { solver: SolverOptions::talk(), ..WorldOptions::default() };
    options.solver.warm_start.enabled = false;
    options.rest.sleep.enabled = false; // what sleeps shows nothing
    let mut world = World::new(options)?;
    world.add_body(Body::fixed(Shape::half_space(Vec3::Y)))?;
    world.add_body(Body::dynamic(Shape::cuboid(0.5, 0.5, 0.5)).at(0.5 * Vec3::Y))?;
    let report = world.step(1.0 / 60.0);
    assert!(report.residual.is_finite() && report.rejected.is_none());
    Ok(())
}
// ANCHOR_END: switches

// ANCHOR: scale_reading
/// What the ground carries under a stack of ten, in weights of a box, without and with WA.
#[test]
fn scale_reading() -> ishigaki::Result<()> {
    use ishigaki::SolverOptions;

    let reading = |amplify: bool| -> ishigaki::Result<f32> {
        let mut solver = SolverOptions { sweeps: 8, relax_sweeps: 0, ..SolverOptions::default() };
        solver.weight_amplification.enabled = amplify;
        let mut world = World::new(WorldOptions { solver, ..WorldOptions::default() })?;
        let ground = world.add_body(Body::fixed(Shape::half_space(Vec3::Y)))?;
        for k in 0..10 {
            let cube = Body::dynamic(Shape::cuboid(0.5, 0.5, 0.5)).mass(1000.0);
            world.add_body(cube.at((k as f32 + 0.5) * Vec3::Y))?;
        }
        for _ in 0..20 {
            world.step(1.0 / 60.0);
        }
        let on_ground = world.contacts().filter(|c| c.a.body == ground || c.b.body == ground);
        let impulses = on_ground.flat_map(|c| c.manifolds).flat_map(|m| &m.points).map(|p| p.impulse);
        Ok(impulses.sum::<f32>() * 60.0 / (1000.0 * 9.81))
    };
    let (plain, amplified) = (reading(false)?, reading(true)?);
    assert!((plain - 10.0).abs() < 0.2, "plain: {plain}");
    // Σ 1.4⁻ʲ, j = 0 … 9
    let series: f64 = (0..10).map(|j| 1.4_f64.powi(-j)).sum();
    assert!((f64::from(amplified) - series).abs() < 0.2, "WA: {amplified}");
    Ok(())
}
// ANCHOR_END: scale_reading

// ANCHOR: wake
/// A stack sleeps; its lowest box is taken away, and the others fall at the next step.
#[test]
fn a_sleeping_stack_falls_when_its_support_goes() -> ishigaki::Result<()> {
    let mut world = World::default();
    world.add_body(Body::fixed(Shape::half_space(Vec3::Y)))?;
    let mut boxes = Vec::new();
    for k in 0..3 {
        boxes.push(world.add_body(Body::dynamic(Shape::cuboid(0.5, 0.5, 0.5)).at((k as f32 + 0.5) * Vec3::Y))?);
    }
    for _ in 0..120 {
        world.step(1.0 / 60.0);
    }
    assert!(world.body(boxes[2]).is_some_and(|state| state.is_asleep()));
    world.remove_body(boxes[0]);
    world.step(1.0 / 60.0);
    let speed = world.body(boxes[1]).map_or(f32::NAN, |state| -state.velocity().y);
    assert!((speed - 9.81 / 60.0).abs() < 0.01, "{speed} m/s");
    Ok(())
}
// ANCHOR_END: wake
