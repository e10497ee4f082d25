//! Jolt, by the shim in `peers/jolt`.

use super::{DT, Engine, Setup, State};
use crate::scene::{Body, Form, Scene, Shape};
use anyhow::{Context, ensure};
use ishigaki_bench_jolt::*;
use std::ffi::c_void;

pub fn about() -> String {
    format!("5.0 (sources of joltc-sys 0.3.1), default settings (10 + 2 iterations), {}", ishigaki_bench_jolt::FLAGS)
}

struct Jolt {
    world: *mut c_void,
    /// Numbers of all states, reused.
    numbers: Vec<f64>,
    /// Ran out of the room for pairs or contacts it was given.
    failed: bool,
}

#[allow(unsafe_code)]
pub fn build(scene: &Scene, setup: &Setup) -> anyhow::Result<Box<dyn Engine>> {
    // SAFETY: a pointer to three numbers, read while the call runs. So are all pointers to numbers below.
    let world =
        unsafe { jolt_create(setup.threads, setup.sleep, scene.gravity.as_ptr(), u32::try_from(scene.bodies.len())?) };
    let made = Jolt { world, numbers: vec![0.0; 13 * scene.bodies.len()], failed: false };
    for points in &scene.hulls {
        // SAFETY: as above; `count` points of three numbers each.
        let ok = unsafe { jolt_hull(world, points.as_flattened().as_ptr(), u32::try_from(points.len())?) };
        ensure!(ok, "Jolt cannot make a hull");
    }
    for (i, body) in scene.bodies.iter().enumerate() {
        made.add(body, scene).with_context(|| format!("body {i}"))?;
    }
    for joint in &scene.joints {
        let [a, b] = joint.bodies.map(|i| i as u32);
        // SAFETY: both bodies exist.
        unsafe {
            jolt_joint(world, a, b, joint.anchors[0].as_ptr(), joint.anchors[1].as_ptr());
            jolt_exclude(world, a, b);
        }
    }
    for &[a, b] in &scene.excluded {
        // SAFETY: both bodies exist.
        unsafe { jolt_exclude(world, a as u32, b as u32) };
    }
    // SAFETY: the world is valid.
    unsafe { jolt_finish(world) };
    Ok(Box::new(made))
}

impl Jolt {
    #[allow(unsafe_code)]
    fn add(&self, body: &Body, scene: &Scene) -> anyhow::Result<()> {
        let first = body.shapes.first().context("has no shape")?;
        let same = |s: &Shape| (s.friction, s.restitution);
        ensure!(body.shapes.iter().all(|s| same(s) == same(first)), "friction is the body's in Jolt, not its shapes'");
        for shape in &body.shapes {
            ensure!(self.add_shape(shape, scene), "Jolt cannot make {:?}", shape.form);
        }
        // SAFETY: pointers to three or four numbers each, read while the call runs.
        let ok = unsafe {
            jolt_body(
                self.world,
                body.dynamic,
                body.position.as_ptr(),
                body.rotation.as_ptr(),
                body.velocity.as_ptr(),
                body.angular_velocity.as_ptr(),
                first.friction,
                first.restitution,
                body.member_of,
                body.collides_with,
            )
        };
        ensure!(ok, "Jolt has no room for it");
        Ok(())
    }

    #[allow(unsafe_code)]
    fn add_shape(&self, shape: &Shape, scene: &Scene) -> bool {
        let (world, density) = (self.world, shape.density);
        let (at, turned) = (shape.position.as_ptr(), shape.rotation.as_ptr());
        // SAFETY: pointers to as many numbers as the functions read, valid while they run; hulls exist.
        unsafe {
            match &shape.form {
                Form::Cuboid(half) => jolt_box(world, half.as_ptr(), density, at, turned),
                Form::HalfSpace => {
                    let half = scene.ground_box();
                    let [x, y, z] = shape.position;
                    let below = [x, y - half[1], z];
                    jolt_box(world, half.as_ptr(), density, below.as_ptr(), turned)
                }
                &Form::Ball(radius) => jolt_ball(world, radius, density, at, turned),
                &Form::Capsule { half_length, radius } => jolt_capsule(world, half_length, radius, density, at, turned),
                &Form::Hull(i) => jolt_shared_hull(world, i as u32, density, at, turned),
                Form::HeightField { count, heights, size } => {
                    jolt_field(world, heights.as_ptr(), *count as u32, *size, at, turned)
                }
            }
        }
    }
}

impl Engine for Jolt {
    #[allow(unsafe_code)]
    fn step(&mut self, steps: u32) {
        // SAFETY: the world is valid until `Drop`.
        self.failed |= !unsafe { jolt_step(self.world, DT, steps) };
    }

    #[allow(unsafe_code)]
    fn states(&mut self, states: &mut Vec<State>) {
        // SAFETY: `numbers` holds 13 for each body.
        unsafe { jolt_states(self.world, self.numbers.as_mut_ptr()) };
        super::unpack(&self.numbers, states);
        if self.failed {
            // Not a number: the worst of all measures.
            states.iter_mut().for_each(|s| s.position = [f64::NAN; 3]);
        }
    }
}

impl Drop for Jolt {
    #[allow(unsafe_code)]
    fn drop(&mut self) {
        // SAFETY: made by `jolt_create`, dropped once.
        unsafe { jolt_destroy(self.world) };
    }
}
