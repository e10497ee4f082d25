//! The functions of `shim.cpp`, which says what they do.

use std::ffi::c_void;

/// Compiler flags of Jolt and shim.
pub const FLAGS: &str = env!("JOLT_FLAGS");

unsafe extern "C" {
    pub fn jolt_create(threads: u32, sleep: bool, gravity: *const f32, bodies: u32) -> *mut c_void;
    pub fn jolt_hull(world: *mut c_void, points: *const f32, count: u32) -> bool;
    pub fn jolt_box(world: *mut c_void, half: *const f32, density: f32, at: *const f32, turned: *const f32) -> bool;
    pub fn jolt_ball(world: *mut c_void, radius: f32, density: f32, at: *const f32, turned: *const f32) -> bool;
    pub fn jolt_capsule(
        world: *mut c_void,
        half_length: f32,
        radius: f32,
        density: f32,
        at: *const f32,
        turned: *const f32,
    ) -> bool;
    pub fn jolt_shared_hull(world: *mut c_void, hull: u32, density: f32, at: *const f32, turned: *const f32) -> bool;
    pub fn jolt_field(
        world: *mut c_void,
        heights: *const f32,
        count: u32,
        size: f32,
        at: *const f32,
        turned: *const f32,
    ) -> bool;
    pub fn jolt_body(
        world: *mut c_void,
        dynamic: bool,
        at: *const f32,
        turned: *const f32,
        velocity: *const f32,
        angular_velocity: *const f32,
        friction: f32,
        restitution: f32,
        member_of: u32,
        collides_with: u32,
    ) -> bool;
    pub fn jolt_exclude(world: *mut c_void, a: u32, b: u32);
    pub fn jolt_joint(world: *mut c_void, a: u32, b: u32, anchor_a: *const f32, anchor_b: *const f32);
    pub fn jolt_finish(world: *mut c_void);
    pub fn jolt_step(world: *mut c_void, dt: f32, steps: u32) -> bool;
    pub fn jolt_states(world: *mut c_void, out: *mut f64);
    pub fn jolt_destroy(world: *mut c_void);
}
