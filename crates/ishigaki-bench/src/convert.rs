//! From Ishigaki's scene file to a scene for every engine.
//!
//! What some engine cannot say alike is left out or refused: ball joints keep their point but not their limits,
//! friction and damping; a mass given for a body becomes the density that gives it.

use crate::scene::{BallJoint, Body, Form, Scene, Shape};
use crate::solid;
use anyhow::{Context, Result, bail, ensure};
use ishigaki::{BodyKind, Pose, Vec3};
use ishigaki_scenes::SceneFile;
use ishigaki_scenes::file::{
    BodyFile, BodyRef, FramesFile, GeometryFile, JointFile, JointKindFile, MassFile, ShapeFile,
};

/// The same scene, or why it cannot be.
pub fn convert(file: &SceneFile) -> Result<Scene> {
    let mut scene = Scene { gravity: file.options.gravity.to_array(), ..Scene::default() };
    let shared: Vec<&String> = file.hulls.keys().collect();
    scene.hulls = file.hulls.values().map(|hull| hull.points.iter().map(Vec3::to_array).collect()).collect();
    for (i, b) in file.bodies.iter().enumerate() {
        let body = body(b, &shared, &mut scene.hulls).with_context(|| format!("bodies[{i}]"))?;
        scene.bodies.push(body);
    }
    for (i, joint) in file.joints.iter().enumerate() {
        let joint = ball_joint(joint, file).with_context(|| format!("joints[{i}]"))?;
        scene.joints.push(joint);
    }
    for pair in &file.excluded_pairs {
        scene.excluded.push([index(&pair[0], file)?, index(&pair[1], file)?]);
    }
    Ok(scene)
}

fn body(body: &BodyFile, shared: &[&String], hulls: &mut Vec<Vec<[f32; 3]>>) -> Result<Body> {
    let dynamic = match body.kind {
        BodyKind::Dynamic => true,
        BodyKind::Fixed => false,
        BodyKind::Kinematic => bail!("kinematic bodies are not translated"),
    };
    let mut shapes = Vec::with_capacity(body.shapes.len());
    for s in &body.shapes {
        shapes.push(shape(s, shared, hulls)?);
    }
    match body.mass {
        None => {}
        Some(MassFile::Density(density)) => shapes.iter_mut().for_each(|s| s.density = density),
        Some(MassFile::Total(mass)) => {
            let have: f64 = shapes.iter().map(|s| solid::mass(s, hulls)).sum();
            shapes.iter_mut().for_each(|s| s.density *= (f64::from(mass) / have) as f32);
        }
        Some(MassFile::Properties(_)) => bail!("mass properties that do not follow from shapes are not translated"),
    }
    let first = body.shapes.first();
    ensure!(!dynamic || first.is_some(), "a dynamic body needs a shape");
    let groups = |s: &ShapeFile| (s.member_of, s.collides_with);
    ensure!(body.shapes.windows(2).all(|w| groups(&w[0]) == groups(&w[1])), "its shapes are in different groups");
    let (member_of, collides_with) = first.map_or((1, u32::MAX), groups);
    Ok(Body {
        dynamic,
        position: body.position.to_array(),
        rotation: body.rotation.to_array(),
        velocity: body.velocity.to_array(),
        angular_velocity: body.angular_velocity.to_array(),
        shapes,
        member_of,
        collides_with,
    })
}

fn shape(shape: &ShapeFile, shared: &[&String], hulls: &mut Vec<Vec<[f32; 3]>>) -> Result<Shape> {
    let form = match &shape.geometry {
        GeometryFile::Ball { radius } => Form::Ball(*radius),
        GeometryFile::Cuboid { half_extents } => Form::Cuboid(half_extents.to_array()),
        GeometryFile::Capsule { half_length, radius } => Form::Capsule { half_length: *half_length, radius: *radius },
        GeometryFile::HalfSpace { normal } => {
            ensure!(*normal == Vec3::Y, "only half-spaces that look up are translated");
            Form::HalfSpace
        }
        GeometryFile::ConvexHull(hull) => {
            hulls.push(hull.points.iter().map(Vec3::to_array).collect());
            Form::Hull(hulls.len() - 1)
        }
        GeometryFile::SharedHull(name) => {
            Form::Hull(shared.iter().position(|s| *s == name).with_context(|| format!("there is no hull `{name}`"))?)
        }
        GeometryFile::HeightField { rows, columns, heights, size_x, size_z } if rows == columns && size_x == size_z => {
            Form::HeightField { count: *rows, heights: heights.clone(), size: *size_x }
        }
        _ => bail!("only balls, boxes, capsules, hulls, half-spaces and square height fields are translated"),
    };
    ensure!(!shape.sensor, "sensors are not translated");
    Ok(Shape {
        form,
        position: shape.position.to_array(),
        rotation: shape.rotation.to_array(),
        density: shape.density,
        friction: shape.friction,
        restitution: shape.restitution,
    })
}

fn ball_joint(joint: &JointFile, file: &SceneFile) -> Result<BallJoint> {
    ensure!(matches!(joint.kind, JointKindFile::Ball { .. }), "only ball joints are translated");
    ensure!(!joint.collide, "joints whose bodies touch are not translated");
    let bodies = [index(&joint.body_a, file)?, index(&joint.body_b, file)?];
    let anchors = match &joint.frame {
        FramesFile::Local { a, b } => [a.position, b.position],
        FramesFile::World(frame) => bodies.map(|i| {
            let body = &file.bodies[i];
            Pose::from_parts(body.position, body.rotation).inverse().transform_point(frame.position)
        }),
    };
    Ok(BallJoint { bodies, anchors: anchors.map(|p| p.to_array()) })
}

fn index(body: &BodyRef, file: &SceneFile) -> Result<usize> {
    let found = match body {
        BodyRef::Index(i) => (*i < file.bodies.len()).then_some(*i),
        BodyRef::Name(name) => file.bodies.iter().position(|b| b.name == *name),
    };
    found.with_context(|| format!("there is no body {body:?}"))
}
