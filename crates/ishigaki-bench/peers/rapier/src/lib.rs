//! Rapier behind five C functions: create, step, states, destroy, about.

#[path = "../../../src/scene.rs"]
#[allow(dead_code, reason = "the other engines use all of the description")]
mod scene;

use rapier3d::parry::utils::Array2;
use rapier3d::prelude::*;
use scene::{Body, Form, Scene, Shape};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// A world; opaque to the caller.
pub struct World {
    pipeline: PhysicsPipeline,
    gravity: Vector,
    parameters: IntegrationParameters,
    islands: IslandManager,
    broad_phase: DefaultBroadPhase,
    narrow_phase: NarrowPhase,
    bodies: RigidBodySet,
    colliders: ColliderSet,
    joints: ImpulseJointSet,
    multibody_joints: MultibodyJointSet,
    soft_bodies: SoftBodySet,
    ccd: CCDSolver,
    handles: Vec<RigidBodyHandle>,
}

/// A world of a scene in JSON; null if it cannot be built.
///
/// # Safety
/// `json` points to `length` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rapier_create(json: *const u8, length: usize, threads: u32, sleep: bool) -> *mut World {
    // SAFETY: the caller's promise.
    let json = unsafe { std::slice::from_raw_parts(json, length) };
    let made = catch_unwind(|| build(json, threads, sleep));
    made.ok().flatten().map_or(std::ptr::null_mut(), |world| Box::into_raw(Box::new(world)))
}

/// Steps of 1/60 s; false if Rapier panicked.
///
/// # Safety
/// `world` comes from [`rapier_create`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rapier_step(world: *mut World, steps: u32) -> bool {
    // SAFETY: the caller's promise.
    let world = unsafe { &mut *world };
    catch_unwind(AssertUnwindSafe(|| (0..steps).for_each(|_| world.step()))).is_ok()
}

/// Position, rotation, velocity, angular velocity of every body: 13 numbers each.
///
/// # Safety
/// `world` comes from [`rapier_create`]; `out` has room for 13 numbers for each body.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rapier_states(world: *const World, out: *mut f64) {
    // SAFETY: the caller's promise.
    let (world, out) = unsafe {
        let world = &*world;
        (world, std::slice::from_raw_parts_mut(out, 13 * world.handles.len()))
    };
    for (handle, out) in world.handles.iter().zip(out.chunks_exact_mut(13)) {
        let body = &world.bodies[*handle];
        let numbers = (body.translation().to_array().into_iter())
            .chain(body.rotation().to_array())
            .chain(body.linvel().to_array())
            .chain(body.angvel().to_array());
        out.iter_mut().zip(numbers).for_each(|(out, x)| *out = f64::from(x));
    }
}

/// # Safety
/// `world` comes from [`rapier_create`] and is not used any more.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rapier_destroy(world: *mut World) {
    // SAFETY: the caller's promise.
    drop(unsafe { Box::from_raw(world) });
}

/// Lanes of its solver.
#[unsafe(no_mangle)]
pub extern "C" fn rapier_lanes() -> u32 {
    if cfg!(feature = "simd8") { 8 } else { 4 }
}

fn build(json: &[u8], threads: u32, sleep: bool) -> Option<World> {
    let scene: Scene = serde_json::from_slice(json).ok()?;
    let mut world = World {
        pipeline: pipeline(threads)?,
        gravity: scene.gravity.into(),
        parameters: IntegrationParameters::default(),
        islands: IslandManager::new(),
        broad_phase: DefaultBroadPhase::new(),
        narrow_phase: NarrowPhase::new(),
        bodies: RigidBodySet::new(),
        colliders: ColliderSet::new(),
        joints: ImpulseJointSet::new(),
        multibody_joints: MultibodyJointSet::new(),
        soft_bodies: SoftBodySet::default(),
        ccd: CCDSolver::new(),
        handles: Vec::new(),
    };
    for body in &scene.bodies {
        world.add(body, &scene, sleep)?;
    }
    for joint in &scene.joints {
        let [a, b] = joint.bodies.map(|i| world.handles[i]);
        let [at_a, at_b] = joint.anchors.map(Vector::from);
        let ball = SphericalJointBuilder::new().local_anchor1(at_a).local_anchor2(at_b).contacts_enabled(false);
        world.joints.insert(a, b, ball, true);
    }
    // Pairs without a joint would need a hook in every step; no scene has them.
    scene.excluded.is_empty().then_some(world)
}

#[cfg(not(feature = "parallel"))]
fn pipeline(threads: u32) -> Option<PhysicsPipeline> {
    (threads == 1).then(PhysicsPipeline::new)
}

#[cfg(feature = "parallel")]
fn pipeline(threads: u32) -> Option<PhysicsPipeline> {
    let pool = rapier3d::rayon::ThreadPoolBuilder::new().num_threads(threads as usize).build().ok()?;
    let mut pipeline = PhysicsPipeline::new();
    pipeline.set_thread_pool(Some(std::sync::Arc::new(pool)));
    Some(pipeline)
}

impl World {
    fn add(&mut self, body: &Body, scene: &Scene, sleep: bool) -> Option<()> {
        let builder = if body.dynamic { RigidBodyBuilder::dynamic() } else { RigidBodyBuilder::fixed() };
        let builder = builder
            .pose(pose(body.position, body.rotation))
            .linvel(body.velocity.into())
            .angvel(body.angular_velocity.into())
            .can_sleep(sleep);
        let handle = self.bodies.insert(builder);
        let (member, with) = (Group::from_bits_retain(body.member_of), Group::from_bits_retain(body.collides_with));
        let groups = InteractionGroups::new(member, with, InteractionTestMode::And);
        for s in &body.shapes {
            let collider = form(s, scene)?
                .position(pose(s.position, s.rotation))
                .density(s.density)
                .friction(s.friction)
                .restitution(s.restitution)
                .collision_groups(groups);
            self.colliders.insert_with_parent(collider, handle, &mut self.bodies);
        }
        self.handles.push(handle);
        Some(())
    }

    fn step(&mut self) {
        self.pipeline.step(
            self.gravity,
            &self.parameters,
            &mut self.islands,
            &mut self.broad_phase,
            &mut self.narrow_phase,
            &mut self.bodies,
            &mut self.colliders,
            &mut self.joints,
            &mut self.multibody_joints,
            &mut self.soft_bodies,
            &mut self.ccd,
            &(),
            &(),
        );
    }
}

fn pose(position: [f32; 3], rotation: [f32; 4]) -> Pose {
    Pose::from_parts(position.into(), Rotation::from_array(rotation))
}

fn form(shape: &Shape, scene: &Scene) -> Option<ColliderBuilder> {
    Some(match &shape.form {
        &Form::Cuboid([x, y, z]) => ColliderBuilder::cuboid(x, y, z),
        &Form::Ball(radius) => ColliderBuilder::ball(radius),
        &Form::Capsule { half_length, radius } => ColliderBuilder::capsule_y(half_length, radius),
        &Form::Hull(i) => {
            let points: Vec<Vector> = scene.hulls[i].iter().map(|&p| p.into()).collect();
            ColliderBuilder::convex_hull(&points)?
        }
        Form::HalfSpace => ColliderBuilder::new(SharedShape::halfspace(Vector::Y)),
        Form::HeightField { count, heights, size } => {
            // Column by column, rows along z.
            let by_column = (0..count * count).map(|i| heights[(i % count) * count + i / count]).collect();
            let field = Array2::new(*count, *count, by_column);
            ColliderBuilder::heightfield(field, Vector::new(*size, 1.0, *size))
        }
    })
}
