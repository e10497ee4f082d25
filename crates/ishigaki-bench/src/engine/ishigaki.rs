//! Ishigaki itself.

use super::{Counts, DT, Engine, Setup, State, wide};
use crate::scene::{Body, Form, Scene, Shape};
use anyhow::Context;
use ishigaki::{BodyHandle, JointFrames, JointKind, Pose, Quat, Stage, StepContext, StepReport, Vec3, World};
use std::sync::Arc;
use std::time::Instant;

pub fn about() -> String {
    let flags = env!("BENCH_RUST_FLAGS");
    format!("version {}, default options, {flags}", env!("CARGO_PKG_VERSION"))
}

struct Ishigaki {
    world: World,
    bodies: Vec<BodyHandle>,
    /// Seconds in each stage; `None` if nobody asked.
    stages: Option<[f64; 10]>,
    counts: Counts,
}

pub fn build(scene: &Scene, setup: &Setup) -> anyhow::Result<Box<dyn Engine>> {
    let mut options = setup.ishigaki.clone();
    options.gravity = Vec3::from_array(scene.gravity);
    options.rest.sleep.enabled = setup.sleep;
    let mut world = World::new(options)?;
    world.set_threads(setup.threads as usize)?;
    let hulls = scene.hulls.iter().map(|points| {
        let points: Vec<Vec3> = points.iter().map(|&p| Vec3::from_array(p)).collect();
        Ok(Arc::new(ishigaki::ConvexHull::new(&points)?))
    });
    let hulls = hulls.collect::<anyhow::Result<Vec<_>>>()?;
    let mut bodies = Vec::with_capacity(scene.bodies.len());
    for (i, body) in scene.bodies.iter().enumerate() {
        let definition = definition(body, &hulls).with_context(|| format!("body {i}"))?;
        bodies.push(world.add_body(definition).with_context(|| format!("body {i}"))?);
    }
    for joint in &scene.joints {
        let [a, b] = joint.bodies.map(|i| bodies[i]);
        let kind = JointKind::Ball { cone: None, twist: None, friction: 0.0, damping: 0.0 };
        let mut definition = ishigaki::Joint::new(a, b, kind, Pose::IDENTITY);
        let [a, b] = joint.anchors.map(|p| Pose::from_parts(Vec3::from_array(p), Quat::IDENTITY));
        definition.frames = JointFrames::Local { a, b };
        world.add_joint(definition)?;
    }
    for &[a, b] in &scene.excluded {
        world.exclude_pair(bodies[a], bodies[b])?;
    }
    Ok(Box::new(Ishigaki { world, bodies, stages: setup.phases.then_some([0.0; 10]), counts: Counts::default() }))
}

fn definition(body: &Body, hulls: &[Arc<ishigaki::ConvexHull>]) -> anyhow::Result<ishigaki::Body> {
    let kind = if body.dynamic { ishigaki::BodyKind::Dynamic } else { ishigaki::BodyKind::Fixed };
    let mut definition = ishigaki::Body::empty(kind);
    for s in &body.shapes {
        definition.shapes.push(shape(s, hulls)?.groups(body.member_of, body.collides_with));
    }
    definition.pose = pose(body.position, body.rotation);
    definition.velocity = Vec3::from_array(body.velocity);
    definition.angular_velocity = Vec3::from_array(body.angular_velocity);
    Ok(definition)
}

fn shape(shape: &Shape, hulls: &[Arc<ishigaki::ConvexHull>]) -> anyhow::Result<ishigaki::Shape> {
    let made = match &shape.form {
        &Form::Cuboid([x, y, z]) => ishigaki::Shape::cuboid(x, y, z),
        &Form::Ball(radius) => ishigaki::Shape::ball(radius),
        &Form::Capsule { half_length, radius } => ishigaki::Shape::capsule(half_length, radius),
        &Form::Hull(i) => ishigaki::Shape::new(ishigaki::Geometry::ConvexHull(hulls[i].clone())),
        Form::HalfSpace => ishigaki::Shape::half_space(Vec3::Y),
        Form::HeightField { count, heights, size } => {
            ishigaki::Shape::height_field(*count, *count, heights.clone(), *size, *size)?
        }
    };
    let made = made.density(shape.density).friction(shape.friction).restitution(shape.restitution);
    Ok(made.posed(pose(shape.position, shape.rotation)))
}

fn pose(position: [f32; 3], rotation: [f32; 4]) -> Pose {
    Pose::from_parts(Vec3::from_array(position), Quat::from_array(rotation))
}

impl Engine for Ishigaki {
    fn step(&mut self, steps: u32) {
        for _ in 0..steps {
            match &mut self.stages {
                None => self.counts = counts(&self.world.step(DT)),
                Some(sums) => {
                    let start = Instant::now();
                    let mut clock = || start.elapsed().as_secs_f64();
                    let mut context = StepContext { clock: Some(&mut clock), hooks: None };
                    let report = self.world.step_with(DT, &mut context);
                    sums.iter_mut().zip(report.stage_seconds).for_each(|(sum, seconds)| *sum += seconds);
                    self.counts = counts(&report);
                }
            }
        }
    }

    fn states(&mut self, states: &mut Vec<State>) {
        states.clear();
        for &handle in &self.bodies {
            // Nothing is ever removed from a bench world.
            let Some(body) = self.world.body(handle) else { continue };
            states.push(State {
                position: wide(body.position().to_array()),
                rotation: wide(body.rotation().to_array()),
                velocity: wide(body.velocity().to_array()),
                angular_velocity: wide(body.angular_velocity().to_array()),
            });
        }
    }

    fn phases(&self) -> Vec<(&'static str, f64)> {
        let names = Stage::ALL.map(Stage::name);
        self.stages.map(|sums| names.into_iter().zip(sums).collect()).unwrap_or_default()
    }

    fn counts(&self) -> Option<Counts> {
        Some(self.counts)
    }
}

fn counts(report: &StepReport) -> Counts {
    Counts { islands: report.islands, contacts: report.contacts, asleep: report.asleep }
}
