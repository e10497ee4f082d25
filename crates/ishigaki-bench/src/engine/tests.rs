//! Every engine of this build does what the scene says, as far as a law says what that is.

use super::*;
use crate::scene::{BallJoint, Body, Form, Scene, Shape};

const G: f64 = 9.81;

fn setup() -> Setup {
    Setup { threads: 1, sleep: false, phases: false, ishigaki: WorldOptions::default() }
}

/// States of all bodies after so many steps, in every engine.
fn after(scene: &Scene, steps: u32) -> Vec<(&'static str, Vec<State>)> {
    let run = |kind: &Kind| {
        let mut engine = (kind.build)(scene, &setup()).unwrap();
        engine.step(steps);
        let mut states = Vec::new();
        engine.states(&mut states);
        assert_eq!(states.len(), scene.bodies.len(), "{}", kind.name);
        (kind.name, states)
    };
    KINDS.iter().map(run).collect()
}

fn scene(bodies: Vec<Body>) -> Scene {
    Scene { gravity: [0.0, -9.81, 0.0], bodies, ..Scene::default() }
}

fn ground() -> Body {
    Body::new(false, [0.0; 3], Shape::new(Form::HalfSpace))
}

fn forms() -> Vec<Form> {
    vec![Form::Cuboid([0.5; 3]), Form::Ball(0.5), Form::Capsule { half_length: 0.25, radius: 0.25 }, Form::Hull(0)]
}

/// A cube of 1 m as a hull.
fn corners() -> Vec<[f32; 3]> {
    (0..8).map(|i| [0, 1, 2].map(|k| if i >> k & 1 == 0 { -0.5 } else { 0.5 })).collect()
}

#[test]
fn bodies_fall_as_they_should_and_nothing_dampens_them() {
    let mut scene = scene(forms().into_iter().map(|f| Body::new(true, [0.0; 3], Shape::new(f))).collect());
    for (i, body) in scene.bodies.iter_mut().enumerate() {
        body.position[0] = 10.0 * i as f32;
        body.velocity = [1.0, 0.0, 0.0];
    }
    scene.hulls.push(corners());
    for (name, states) in after(&scene, 60) {
        for (i, s) in states.iter().enumerate() {
            assert!((s.velocity[1] + G).abs() < 1e-2, "{name}, body {i}: {s:?}");
            assert!((s.position[0] - 10.0 * i as f64 - 1.0).abs() < 1e-3, "{name}, body {i}: {s:?}");
            // Substeps of any number end between the two sums of a first-order method.
            assert!((s.position[1] + 0.5 * G).abs() < 0.5 * G / 60.0 + 1e-2, "{name}, body {i}: {s:?}");
        }
    }
}

#[test]
fn every_form_comes_to_lie_on_ground_and_terrain() {
    let heights = (0..64).map(|i| if i / 8 < 4 { 3.0 } else { 0.0 }).collect();
    // Level where z > 2, high where z < −2: bodies at low x are where a transposed terrain would be high.
    let terrain = Body::new(false, [0.0; 3], Shape::new(Form::HeightField { count: 8, heights, size: 28.0 }));
    for floor in [ground(), terrain] {
        let mut scene = scene(vec![floor]);
        scene.hulls.push(corners());
        for (i, form) in forms().into_iter().enumerate() {
            scene.bodies.push(Body::new(true, [2.3 * i as f32 - 4.2, 0.7, 3.0], Shape::new(form)));
        }
        for (name, states) in after(&scene, 120) {
            for (i, s) in states.iter().enumerate().skip(1) {
                // The capsule may have fallen over by now.
                assert!((0.2..0.52).contains(&s.position[1]), "{name}, body {i}: {s:?}");
            }
        }
    }
}

#[test]
fn a_pendulum_hangs_from_its_anchor_and_does_not_touch_its_hook() {
    let mut hanging = scene(vec![
        Body::new(false, [0.0; 3], Shape::new(Form::Ball(0.4))),
        Body::new(true, [0.0, -0.5, 0.0], Shape::new(Form::Ball(0.4))),
    ]);
    hanging.joints.push(BallJoint { bodies: [0, 1], anchors: [[0.0; 3], [0.0, 0.5, 0.0]] });
    for (name, states) in after(&hanging, 120) {
        assert!((states[1].position[1] + 0.5).abs() < 1e-3, "{name}: {:?}", states[1]);
    }
}

#[test]
fn groups_that_exclude_each_other_pass_through() {
    let mut falling = scene(vec![ground(), Body::new(true, [0.0, 0.5, 0.0], Shape::new(Form::Ball(0.5)))]);
    (falling.bodies[1].member_of, falling.bodies[1].collides_with) = (2, 2);
    for (name, states) in after(&falling, 60) {
        assert!(states[1].position[1] < -3.0, "{name}: {:?}", states[1]);
    }
}

#[test]
fn mass_follows_from_density_and_form() {
    // A ball of twice the density on a seesaw arm of half the length: level, if masses are right.
    let mut seesaw = scene(vec![
        Body::new(false, [0.0, 0.0, 0.0], Shape::new(Form::Ball(0.01))),
        Body::new(true, [0.0, 0.0, 0.0], Shape::new(Form::Cuboid([0.1; 3]))),
    ]);
    let mut heavy = Shape { position: [1.0, 0.0, 0.0], ..Shape::new(Form::Ball(0.3)) };
    heavy.density = 2000.0;
    let light = Shape { position: [-2.0, 0.0, 0.0], ..Shape::new(Form::Ball(0.3)) };
    seesaw.bodies[1].shapes.extend([heavy, light]);
    seesaw.joints.push(BallJoint { bodies: [0, 1], anchors: [[0.0; 3], [0.0; 3]] });
    for (name, states) in after(&seesaw, 60) {
        let tilt = states[1].rotation[2].abs();
        assert!(tilt < 1e-2, "{name}: {:?}", states[1]);
    }
}
