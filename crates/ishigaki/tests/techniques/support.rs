//! Worlds and measures that the tests share.

use ishigaki::*;

pub const DT: f32 = 1.0 / 60.0;
pub const G: f32 = 9.81;
/// Of every box and ball of a stack, kg.
pub const MASS: f32 = 1000.0;

/// `SolverOptions::plain()` and what the test switches.
pub fn plain(change: impl FnOnce(&mut SolverOptions)) -> SolverOptions {
    let mut solver = SolverOptions::plain();
    change(&mut solver);
    solver
}

/// An empty world where nothing rests, so that the solver is looked at alone.
pub fn world(solver: SolverOptions) -> World {
    let mut options = WorldOptions { solver, ..WorldOptions::default() };
    options.rest.sleep.enabled = false;
    options.rest.aggressive_sleep.enabled = false;
    World::new(options).unwrap()
}

pub fn change_options(world: &mut World, change: impl FnOnce(&mut WorldOptions)) {
    let mut options = world.options().clone();
    change(&mut options);
    world.set_options(options).unwrap();
}

/// A half-space with its surface at y = 0.
pub fn add_ground(world: &mut World) -> BodyHandle {
    world.add_body(Body::fixed(Shape::half_space(Vec3::Y))).unwrap()
}

/// A cube of 1 m with its center at `center`.
pub fn cube(center: Vec3) -> Body {
    Body::dynamic(Shape::cuboid(0.5, 0.5, 0.5)).mass(MASS).at(center)
}

/// The ground and `n` cubes of 1 m exactly one above the other.
pub fn add_stack(world: &mut World, n: usize) -> (BodyHandle, Vec<BodyHandle>) {
    let ground = add_ground(world);
    let add = |k| world.add_body(cube(Vec3::new(0.0, k as f32 + 0.5, 0.0))).unwrap();
    (ground, (0..n).map(add).collect())
}

/// The ground and `n` balls of 1 m, one above the other, that can only move up and down: one row for each contact.
pub fn add_column(world: &mut World, n: usize) -> (BodyHandle, Vec<BodyHandle>) {
    let ground = add_ground(world);
    let ball =
        Body::dynamic(Shape::ball(0.5)).mass(MASS).lock_translation([true, false, true]).lock_rotation([true; 3]);
    let add = |k| world.add_body(ball.clone().at(Vec3::new(0.0, k as f32 + 0.5, 0.0))).unwrap();
    (ground, (0..n).map(add).collect())
}

pub fn run(world: &mut World, steps: usize) {
    for _ in 0..steps {
        world.step(DT);
    }
}

pub fn body(world: &World, handle: BodyHandle) -> &BodyState {
    world.body(handle).unwrap()
}

/// Normal force of the contacts between `lower` and what lies on it over the last step, N.
pub fn load_on(world: &World, lower: BodyHandle, upper: BodyHandle) -> f32 {
    let between =
        |c: &ContactView<'_>| (c.a.body == lower && c.b.body == upper) || (c.a.body == upper && c.b.body == lower);
    let points = world.contacts().filter(between).flat_map(|c| c.manifolds).flat_map(|m| &m.points);
    points.map(|p| p.impulse).sum::<f32>() / DT
}

/// Mean of [`load_on`] over the next `steps` steps in units of the weight of one box.
pub fn mean_load(world: &mut World, lower: BodyHandle, upper: BodyHandle, steps: usize) -> f32 {
    let mut sum = 0.0;
    for _ in 0..steps {
        world.step(DT);
        sum += load_on(world, lower, upper);
    }
    sum / (steps as f32 * MASS * G)
}
