//! Laws of contact: bouncing, the cradle, the load on what lies below.

mod laws;

use ishigaki::{Body, BodyHandle, BodyKind, Joint, Shape, Vec3, World};
use laws::{G, STEPS, body, converges, relative, run, world};

/// Heights of the first `count` bounces of a ball dropped from 1 m above its resting place, m.
fn bounce_heights(restitution: f32, count: usize, dt: f32) -> Vec<f64> {
    let mut world = world();
    world.add_body(Body::fixed(Shape::half_space(Vec3::Y))).unwrap();
    let ball = Body::dynamic(Shape::ball(0.1).restitution(restitution)).at(1.1 * Vec3::Y);
    let ball = world.add_body(ball).unwrap();
    let (mut heights, mut last) = (Vec::new(), 0.0_f32);
    while heights.len() < count {
        world.step(dt);
        let state = body(&world, ball);
        let speed = state.velocity().y;
        if last > 0.0 && speed <= 0.0 {
            // The peak between two steps, from energy.
            let peak = state.center().y - 0.1 + speed * speed / (2.0 * G as f32);
            heights.push(f64::from(peak));
        }
        last = speed;
        assert!(world.time() < 20.0, "bounced {} times in 20 s", heights.len());
    }
    heights
}

/// Newton: the n-th bounce reaches e²ⁿ H.
#[test]
fn ball_bounces_by_newtons_law() {
    for (restitution, bounces) in [(0.5_f32, 2), (0.8, 4)] {
        let heights = STEPS.map(|dt| bounce_heights(restitution, bounces, dt));
        let square = f64::from(restitution).powi(2);
        // The mean over the bounces: where in a substep a bounce falls is chance.
        let errors = heights.map(|heights| {
            eprintln!("e = {restitution}: {heights:.4?}");
            let exact = |n: usize| square.powi(n as i32 + 1);
            heights.iter().enumerate().map(|(n, &h)| relative(h, exact(n))).sum::<f64>() / bounces as f64
        });
        converges(&format!("bounces, e = {restitution}"), errors, 1.0, 1e-4, 0.01);
    }
}

/// e = 1: a bounce neither takes nor gives energy, whatever the step.
#[test]
fn perfect_ball_keeps_its_height() {
    let errors = STEPS.map(|dt| {
        let heights = bounce_heights(1.0, 10, dt);
        eprintln!("e = 1: {heights:.4?}");
        relative(heights[9], 1.0)
    });
    converges("ten bounces, e = 1", errors, 1.0, 1e-4, 0.01);
}

/// A cradle of five balls, 1 mm apart, the first drawn aside by 30°, each hung by `hang` 1 m below its anchor on the
/// beam. Gives the height to which the last ball rises and the greatest height of the others then, as parts of the
/// height from which the first fell.
fn cradle(hang: impl Fn(BodyHandle, BodyHandle, Vec3) -> Joint, dt: f32) -> (f64, f64) {
    const BALLS: usize = 5;
    let mut world = world();
    let beam = world.add_body(Body::empty(BodyKind::Fixed)).unwrap();
    let shape = Shape::ball(0.1).density(7800.0).friction(0.0).restitution(1.0);
    let mut balls = Vec::new();
    for k in 0..BALLS {
        let anchor = Vec3::new(0.201 * k as f32, 0.0, 0.0);
        let angle = if k == 0 { std::f64::consts::FRAC_PI_6 } else { 0.0 };
        let center = anchor - Vec3::new(angle.sin() as f32, angle.cos() as f32, 0.0);
        let ball = world.add_body(Body::dynamic(shape.clone()).at(center)).unwrap();
        world.add_joint(hang(beam, ball, anchor)).unwrap();
        balls.push(ball);
    }
    let lift = |world: &World, k: usize| f64::from(1.0 + body(world, balls[k]).center().y);
    let start = lift(&world, 0);
    // Until the last ball turns back.
    let (mut highest, mut others) = (0.0_f64, 0.0_f64);
    while highest < 0.1 * start || lift(&world, BALLS - 1) >= 0.5 * highest {
        world.step(dt);
        let out = lift(&world, BALLS - 1);
        if out > 1e-3 {
            others = (0..BALLS - 1).map(|k| lift(&world, k)).fold(others, f64::max);
        }
        highest = highest.max(out);
        assert!(world.time() < 3.0, "the last ball never turned back: {highest} m");
    }
    let (highest, others) = (highest / start, others / start);
    eprintln!("cradle at 1/{:.0} s: out {highest:.4} of the height, the rest {others:.1e}", 1.0 / dt);
    (highest, others)
}

/// One in, one out: five balls on strings.
#[test]
fn cradle_passes_the_blow_on() {
    for dt in STEPS {
        let string = |beam, ball, anchor| Joint::distance(beam, ball, anchor, Vec3::ZERO, 1.0..=1.0);
        let (out, rest) = cradle(string, dt);
        assert!((out - 1.0).abs() < 0.02, "the last ball rises to {out} of the height");
        // Height goes with the square of the speed: this is a hundredth of it.
        assert!(rest < 1e-4, "the others rise to {rest} of the height");
    }
}

/// A known defect: impacts do not see joints. On rigid arms a ball that is hit must turn as it flies off; the joint makes
/// it turn after the impact, at the cost of 1/(1 + 5L²/2r²) = 0.4 % of the speed at each of four blows, twice that of the
/// height. Steps so long that all blows fall into one substep lose it only once.
#[test]
fn cradle_on_rigid_arms_loses_height() {
    let (out, rest) = cradle(Joint::ball, STEPS[2]);
    assert!(out < 0.985, "{out} of the height: impacts see joints now, make this a law");
    assert!(out > 0.96, "the last ball rises to {out} of the height");
    assert!(rest < 1e-4, "the others rise to {rest} of the height");
}

/// Normal impulse on a body over the last step, N·s, along `up`.
fn impulse_on(world: &World, handle: BodyHandle, up: Vec3) -> f64 {
    let mut sum = 0.0;
    for contact in world.contacts() {
        let sign = match (contact.a.body == handle, contact.b.body == handle) {
            (true, _) => 1.0,
            (_, true) => -1.0,
            _ => continue,
        };
        for manifold in contact.manifolds {
            let impulse: f32 = manifold.points.iter().map(|p| p.impulse).sum();
            sum += f64::from(sign * impulse * manifold.normal.dot(up));
        }
    }
    sum
}

/// Σλ under a stack of n is its weight × Δt: the impulses of all substeps together.
#[test]
fn ground_carries_the_weight_of_the_stack() {
    for dt in STEPS {
        for n in [1, 5, 10] {
            let mut world = world();
            let ground = world.add_body(Body::fixed(Shape::half_space(Vec3::Y))).unwrap();
            let mut weight = 0.0;
            for k in 0..n {
                let cube = Body::dynamic(Shape::cuboid(0.5, 0.5, 0.5)).at((k as f32 + 0.5) * Vec3::Y);
                let cube = world.add_body(cube).unwrap();
                weight += f64::from(body(&world, cube).mass()) * G;
            }
            run(&mut world, 2.0, dt);
            let load = -impulse_on(&world, ground, Vec3::Y) / f64::from(dt);
            eprintln!("stack of {n} at 1/{:.0} s: load off by {:.1e}", 1.0 / dt, relative(load, weight));
            assert!(relative(load, weight) < 0.005, "{load} N under a weight of {weight} N");
        }
    }
}

/// A box on four points: which of the many solutions is not determined, Gauss–Seidel tends to the even one. TALK C6.
///
/// Also after a landing, which leaves most of the load on two opposite corners and a warm start that remembers it. (A
/// hard landing may leave a corner some micrometers above the ground: that one carries nothing, and rightly so.)
#[test]
fn four_points_share_the_load() {
    for dt in STEPS {
        for height in [0.0, 0.02] {
            let mut world = world();
            world.add_body(Body::fixed(Shape::half_space(Vec3::Y))).unwrap();
            let cube = Body::dynamic(Shape::cuboid(0.5, 0.5, 0.5)).at((0.5 + height) * Vec3::Y);
            world.add_body(cube).unwrap();
            run(&mut world, 1.0, dt);
            let view = world.contacts().next().unwrap();
            let loads: Vec<f32> = view.manifolds[0].points.iter().map(|p| p.impulse).collect();
            assert_eq!(loads.len(), 4);
            let mean = loads.iter().sum::<f32>() / 4.0;
            let parts: Vec<f32> = loads.iter().map(|load| load / mean).collect();
            eprintln!("four points after a fall of {height} m at 1/{:.0} s: {parts:.4?} of the mean", 1.0 / dt);
            assert!(parts.iter().all(|part| (part - 1.0).abs() < 0.05), "{parts:?}");
        }
    }
}
