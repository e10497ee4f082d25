use super::*;
use crate::scene::{BallJoint, Body, Form, Shape};

const LATER: f64 = 1.0;

fn ground() -> Body {
    Body::new(false, [0.0; 3], Shape::new(Form::HalfSpace))
}

fn at(form: Form, position: [f32; 3]) -> Body {
    Body::new(true, position, Shape::new(form))
}

fn scene(bodies: Vec<Body>) -> Scene {
    Scene { gravity: [0.0, -9.81, 0.0], bodies, ..Scene::default() }
}

/// What the meter says of a scene in which nothing has moved yet.
fn judged(scene: &Scene) -> Quality {
    let states: Vec<State> = scene.bodies.iter().map(State::from).collect();
    let mut meter = Meter::new(scene).unwrap();
    meter.observe(&states, LATER);
    meter.quality()
}

fn cube() -> Form {
    Form::Cuboid([0.5; 3])
}

#[track_caller]
fn near(value: f64, expected: f64) {
    assert!((value - expected).abs() < 1e-6, "{value} instead of {expected}");
}

#[test]
fn overlaps_of_all_forms_are_seen() {
    let below = [0.0, 0.0, 0.0];
    let cases: [(Form, [f32; 3], f64); 5] = [
        (cube(), [0.3, 0.99, 0.2], 0.01),
        (Form::Ball(0.5), [0.0, 0.98, 0.0], 0.02),
        (Form::Capsule { half_length: 0.5, radius: 0.25 }, [0.1, 1.22, 0.0], 0.03),
        (Form::Ball(0.5), [0.0, 1.02, 0.0], 0.0),
        (cube(), [0.0, 1.0, 0.0], 0.0),
    ];
    for (form, position, depth) in cases {
        near(judged(&scene(vec![at(cube(), below), at(form.clone(), position)])).penetration_max, depth);
        near(judged(&scene(vec![at(form, position), at(cube(), below)])).penetration_max, depth);
    }
}

#[test]
fn hulls_overlap_as_the_box_they_span() {
    let corners: Vec<[f32; 3]> = (0..8).map(|i| [0, 1, 2].map(|k| if i >> k & 1 == 0 { -0.5 } else { 0.5 })).collect();
    let mut scene = scene(vec![at(cube(), [0.0; 3]), at(Form::Hull(0), [0.2, 0.96, -0.1])]);
    scene.hulls.push(corners);
    near(judged(&scene).penetration_max, 0.04);
}

#[test]
fn a_box_on_edge_is_as_deep_in_the_ground_as_its_edge() {
    let mut body = at(cube(), [0.0, 0.7, 0.0]);
    let half = std::f32::consts::FRAC_PI_8;
    body.rotation = [half.sin(), 0.0, 0.0, half.cos()];
    near(judged(&scene(vec![ground(), body])).penetration_max, std::f64::consts::FRAC_1_SQRT_2 - f64::from(0.7_f32));
}

#[test]
fn terrain_is_measured_along_its_normal() {
    let heights = (0..16).map(|i| (i % 4) as f32).collect();
    // Slope 1 along x: cells of 1 m, 1 m higher each.
    let field = Form::HeightField { count: 4, heights, size: 3.0 };
    let terrain = Body::new(false, [0.0; 3], Shape::new(field));
    let ball = at(Form::Ball(0.5), [0.0, 2.0, 0.0]);
    near(judged(&scene(vec![terrain, ball])).penetration_max, 0.5 - 0.5 * std::f64::consts::FRAC_1_SQRT_2);
}

#[test]
fn what_may_not_touch_does_not_count() {
    let mut joined = scene(vec![at(cube(), [0.0; 3]), at(cube(), [0.0, 0.9, 0.0])]);
    joined.joints.push(BallJoint { bodies: [0, 1], anchors: [[0.0, 0.5, 0.0], [0.0, -0.5, 0.0]] });
    let quality = judged(&joined);
    near(quality.penetration_max, 0.0);
    near(quality.joint_gap_max, 0.1);
    let mut groups = scene(vec![at(cube(), [0.0; 3]), at(cube(), [0.0, 0.9, 0.0])]);
    for body in &mut groups.bodies {
        (body.member_of, body.collides_with) = (2, 1);
    }
    near(judged(&groups).penetration_max, 0.0);
}

#[test]
fn overlaps_of_the_first_half_second_do_not_count() {
    let scene = scene(vec![at(cube(), [0.0; 3]), at(cube(), [0.0, 0.9, 0.0])]);
    let states: Vec<State> = scene.bodies.iter().map(State::from).collect();
    let mut meter = Meter::new(&scene).unwrap();
    meter.observe(&states, 0.5);
    near(meter.quality().penetration_max, 0.0);
}

#[test]
fn drift_is_horizontal_and_standing_is_any_way() {
    let scene = scene(vec![ground(), at(cube(), [0.0, 1.0, 0.0])]);
    let mut states: Vec<State> = scene.bodies.iter().map(State::from).collect();
    let mut meter = Meter::new(&scene).unwrap();
    states[1].position = [0.03, 0.8, 0.04];
    meter.observe(&states, LATER);
    near(meter.quality().drift_max, 0.05);
    assert!(meter.quality().stands, "it sank by a fifth of its edge");
    states[1].position = [0.0, 0.7, 0.0];
    meter.observe(&states, LATER);
    assert!(!meter.quality().stands);
    states[1].position = [0.0, 1.0, 0.0];
    meter.observe(&states, LATER);
    assert!(!meter.quality().stands, "what fell once does not stand");
}

#[test]
fn not_a_number_is_the_worst_of_all() {
    let scene = scene(vec![ground(), at(cube(), [0.0, 0.5, 0.0])]);
    let mut states: Vec<State> = scene.bodies.iter().map(State::from).collect();
    states[1].position = [f64::NAN; 3];
    let mut meter = Meter::new(&scene).unwrap();
    meter.observe(&states, LATER);
    let quality = meter.quality();
    assert_eq!((quality.penetration_max, quality.drift_max), (f64::INFINITY, f64::INFINITY));
    assert!(!quality.stands);
}

#[test]
fn energy_of_a_turning_body_follows_from_its_inertia() {
    let mut body = at(Form::Cuboid([1.0, 0.5, 0.25]), [0.0; 3]);
    body.angular_velocity = [0.0, 2.0, 0.0];
    let free = Scene { bodies: vec![body], ..Scene::default() };
    let mut meter = Meter::new(&free).unwrap();
    let mut states: Vec<State> = free.bodies.iter().map(State::from).collect();
    // ½ m/12 (2² + ½²) ω² about y.
    let mass = 1000.0 * 2.0 * 1.0 * 0.5;
    near(meter.first_energy / (0.5 * mass / 12.0 * 4.25 * 4.0), 1.0);
    states[0].angular_velocity = [0.0, 4.0, 0.0];
    meter.observe(&states, LATER);
    near(meter.quality().energy_change, 3.0);
}
