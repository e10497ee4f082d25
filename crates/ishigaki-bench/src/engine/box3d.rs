//! Box3D, by its C interface.

use super::{DT, Engine, Setup, State, wide};
use crate::scene::{Body, Form, Scene, Shape};
use ::box3d_sys as b3;
use ::ishigaki::{Pose, Quat, Vec3};
use anyhow::ensure;

/// The number its documentation and samples use.
const SUBSTEPS: i32 = 4;

pub fn about() -> String {
    let flags = env!("BENCH_BOX3D_FLAGS");
    format!("box3d-sys 0.1.16, {SUBSTEPS} substeps, 4 lanes (SSE2 code paths), -O3 {flags}")
}

struct Box3d {
    world: b3::b3WorldId,
    bodies: Vec<b3::b3BodyId>,
    hulls: Vec<*mut b3::b3HullData>,
    /// Box3D refers to height fields, it does not copy them.
    fields: Vec<*mut b3::b3HeightFieldData>,
}

#[allow(unsafe_code)]
pub fn build(scene: &Scene, setup: &Setup) -> anyhow::Result<Box<dyn Engine>> {
    // SAFETY: plain functions on values; the world they name is valid until `Drop`.
    let world = unsafe {
        let mut definition = b3::b3DefaultWorldDef();
        definition.gravity = vector(scene.gravity);
        definition.enableSleep = setup.sleep;
        definition.workerCount = setup.threads;
        b3::b3CreateWorld(&definition)
    };
    let mut made = Box3d { world, bodies: Vec::new(), hulls: Vec::new(), fields: Vec::new() };
    ensure!(scene.excluded.is_empty(), "pairs excluded without a joint are not translated for Box3D");
    for points in &scene.hulls {
        let points: Vec<b3::b3Vec3> = points.iter().map(|&p| vector(p)).collect();
        // SAFETY: pointer and length are those of one vector, which is only read.
        let hull = unsafe { b3::b3CreateHull(points.as_ptr(), points.len() as i32, points.len() as i32) };
        ensure!(!hull.is_null(), "Box3D cannot make a hull");
        made.hulls.push(hull);
    }
    for body in &scene.bodies {
        made.add(body, scene)?;
    }
    for joint in &scene.joints {
        let [a, b] = joint.bodies.map(|i| made.bodies[i]);
        // SAFETY: both bodies belong to this world.
        unsafe {
            let mut definition = b3::b3DefaultSphericalJointDef();
            definition.base.bodyIdA = a;
            definition.base.bodyIdB = b;
            definition.base.localFrameA.p = vector(joint.anchors[0]);
            definition.base.localFrameB.p = vector(joint.anchors[1]);
            b3::b3CreateSphericalJoint(world, &definition);
        }
    }
    Ok(Box::new(made))
}

impl Box3d {
    #[allow(unsafe_code)]
    fn add(&mut self, body: &Body, scene: &Scene) -> anyhow::Result<()> {
        // SAFETY: the world is valid; definitions are only read while the calls run.
        let id = unsafe {
            let mut definition = b3::b3DefaultBodyDef();
            let kind = if body.dynamic { b3::b3BodyType_b3_dynamicBody } else { b3::b3BodyType_b3_staticBody };
            definition.type_ = kind;
            definition.position = vector(origin(body));
            definition.rotation = quaternion(body.rotation);
            definition.linearVelocity = vector(body.velocity);
            definition.angularVelocity = vector(body.angular_velocity);
            b3::b3CreateBody(self.world, &definition)
        };
        self.bodies.push(id);
        for shape in &body.shapes {
            self.add_shape(id, body, shape, scene)?;
        }
        Ok(())
    }

    #[allow(unsafe_code)]
    fn add_shape(&mut self, id: b3::b3BodyId, body: &Body, shape: &Shape, scene: &Scene) -> anyhow::Result<()> {
        let pose = b3::b3Transform { p: vector(shape.position), q: quaternion(shape.rotation) };
        // SAFETY: body and world are valid; hulls and fields live as long as the world.
        unsafe {
            let mut definition = b3::b3DefaultShapeDef();
            definition.density = shape.density;
            definition.baseMaterial.friction = shape.friction;
            definition.baseMaterial.restitution = shape.restitution;
            definition.filter.categoryBits = u64::from(body.member_of);
            definition.filter.maskBits = u64::from(body.collides_with);
            match &shape.form {
                &Form::Cuboid([x, y, z]) => {
                    let hull = b3::b3MakeTransformedBoxHull(x, y, z, pose);
                    b3::b3CreateHullShape(id, &definition, &hull.base);
                }
                Form::HalfSpace => {
                    let [x, y, z] = scene.ground_box();
                    let below = b3::b3Vec3 { x: pose.p.x, y: pose.p.y - y, z: pose.p.z };
                    let hull = b3::b3MakeTransformedBoxHull(x, y, z, b3::b3Transform { p: below, q: pose.q });
                    b3::b3CreateHullShape(id, &definition, &hull.base);
                }
                &Form::Ball(radius) => {
                    let sphere = b3::b3Sphere { center: pose.p, radius };
                    b3::b3CreateSphereShape(id, &definition, &sphere);
                }
                &Form::Capsule { half_length, radius } => {
                    // Its own function for this is inline in a header and not there for others.
                    let local = Pose::from_parts(shape.position.into(), Quat::from_array(shape.rotation));
                    let ends = [-half_length, half_length].map(|y| vector((local * (y * Vec3::Y)).to_array()));
                    let capsule = b3::b3Capsule { center1: ends[0], center2: ends[1], radius };
                    b3::b3CreateCapsuleShape(id, &definition, &capsule);
                }
                &Form::Hull(i) => {
                    ensure!(shape.position == [0.0; 3], "hulls away from the body's origin are not translated");
                    b3::b3CreateHullShape(id, &definition, self.hulls[i]);
                }
                Form::HeightField { count, heights, size } => {
                    self.add_field(id, body, &definition, *count, heights, *size)?;
                }
            }
        }
        Ok(())
    }

    #[allow(unsafe_code)]
    fn add_field(
        &mut self,
        id: b3::b3BodyId,
        body: &Body,
        definition: &b3::b3ShapeDef,
        count: usize,
        heights: &[f32],
        size: f32,
    ) -> anyhow::Result<()> {
        let alone = !body.dynamic && body.shapes.len() == 1 && body.rotation == [0.0, 0.0, 0.0, 1.0];
        ensure!(alone, "a height field needs a fixed, level body of its own");
        let mut heights = heights.to_vec();
        let mut materials = vec![0_u8; (count - 1) * (count - 1)];
        let cell = size / (count - 1) as f32;
        // SAFETY: both vectors have the lengths their counts say and are copied; the field outlives the shape.
        unsafe {
            let field = b3::b3CreateHeightField(&b3::b3HeightFieldDef {
                heights: heights.as_mut_ptr(),
                materialIndices: materials.as_mut_ptr(),
                scale: vector([cell, 1.0, cell]),
                countX: count as i32,
                countZ: count as i32,
                globalMinimumHeight: heights.iter().copied().fold(f32::INFINITY, f32::min),
                globalMaximumHeight: heights.iter().copied().fold(f32::NEG_INFINITY, f32::max),
                clockwiseWinding: false,
            });
            ensure!(!field.is_null(), "Box3D cannot make the height field");
            self.fields.push(field);
            b3::b3CreateHeightFieldShape(id, definition, field);
        }
        Ok(())
    }
}

/// A height field starts at its body's origin and goes along +x and +z: its body is half a field away.
fn origin(body: &Body) -> [f32; 3] {
    let [x, y, z] = body.position;
    match body.shapes.first().map(|s| &s.form) {
        Some(Form::HeightField { size, .. }) => [x - 0.5 * size, y, z - 0.5 * size],
        _ => [x, y, z],
    }
}

fn vector([x, y, z]: [f32; 3]) -> b3::b3Vec3 {
    b3::b3Vec3 { x, y, z }
}

fn quaternion([x, y, z, s]: [f32; 4]) -> b3::b3Quat {
    b3::b3Quat { v: b3::b3Vec3 { x, y, z }, s }
}

impl Engine for Box3d {
    #[allow(unsafe_code)]
    fn step(&mut self, steps: u32) {
        for _ in 0..steps {
            // SAFETY: the world is valid until `Drop`.
            unsafe { b3::b3World_Step(self.world, DT, SUBSTEPS) };
        }
    }

    #[allow(unsafe_code)]
    fn states(&mut self, states: &mut Vec<State>) {
        states.clear();
        for &id in &self.bodies {
            // SAFETY: no body is ever removed.
            let (p, q, v, w) = unsafe {
                (
                    b3::b3Body_GetPosition(id),
                    b3::b3Body_GetRotation(id),
                    b3::b3Body_GetLinearVelocity(id),
                    b3::b3Body_GetAngularVelocity(id),
                )
            };
            states.push(State {
                position: wide([p.x, p.y, p.z]),
                rotation: wide([q.v.x, q.v.y, q.v.z, q.s]),
                velocity: wide([v.x, v.y, v.z]),
                angular_velocity: wide([w.x, w.y, w.z]),
            });
        }
    }
}

impl Drop for Box3d {
    #[allow(unsafe_code)]
    fn drop(&mut self) {
        // SAFETY: all were made by Box3D and are used by nothing else; shapes go before the fields they refer to.
        unsafe {
            b3::b3DestroyWorld(self.world);
            self.hulls.iter().for_each(|&hull| b3::b3DestroyHull(hull));
            self.fields.iter().for_each(|&field| b3::b3DestroyHeightField(field));
        }
    }
}
