//! Worlds and measures that experiments share.

use crate::{Error, Result};
use ishigaki::{Body, BodyHandle, BodyState, ContactView, Shape, SolverOptions, Vec3, World, WorldOptions};
use ishigaki_scenes::{Scene, named};

/// Of a step, s.
pub const DT: f32 = 1.0 / 60.0;
/// Default gravity, m/s².
pub const G: f32 = 9.81;
/// Of every box and ball of a stack, kg.
pub const MASS: f32 = 1000.0;

/// `SolverOptions::plain()` and what the experiment switches.
pub fn plain(change: impl FnOnce(&mut SolverOptions)) -> SolverOptions {
    let mut solver = SolverOptions::plain();
    change(&mut solver);
    solver
}

/// An empty world where nothing rests, so that the solver is looked at alone.
pub fn world(solver: SolverOptions) -> Result<World> {
    let mut options = WorldOptions { solver, ..WorldOptions::default() };
    options.rest.sleep.enabled = false;
    options.rest.aggressive_sleep.enabled = false;
    Ok(World::new(options)?)
}

/// Edits the options of a world.
pub fn change_options(world: &mut World, change: impl FnOnce(&mut WorldOptions)) -> Result<()> {
    let mut options = world.options().clone();
    change(&mut options);
    Ok(world.set_options(options)?)
}

/// A named scene with some of its parameters and other options.
pub fn scene(name: &str, parameters: &[(&str, f64)], change: impl FnOnce(&mut WorldOptions)) -> Result<Scene> {
    let parameters: Vec<_> = parameters.iter().map(|(key, value)| (key.to_string(), *value)).collect();
    let mut file = named(name, &parameters)?;
    file.options.rest.sleep.enabled = false;
    change(&mut file.options);
    Ok(file.build()?)
}

/// A half-space with its surface at y = 0.
pub fn add_ground(world: &mut World) -> Result<BodyHandle> {
    Ok(world.add_body(Body::fixed(Shape::half_space(Vec3::Y)))?)
}

/// A cube of 1 m with its center at `center`.
pub fn cube(center: Vec3) -> Body {
    Body::dynamic(Shape::cuboid(0.5, 0.5, 0.5)).mass(MASS).at(center)
}

/// The ground and `n` cubes of 1 m exactly one above the other.
pub fn add_stack(world: &mut World, n: usize) -> Result<(BodyHandle, Vec<BodyHandle>)> {
    let ground = add_ground(world)?;
    let boxes: std::result::Result<Vec<_>, _> =
        (0..n).map(|k| world.add_body(cube(Vec3::new(0.0, k as f32 + 0.5, 0.0)))).collect();
    Ok((ground, boxes?))
}

/// The ground and `n` balls of 1 m, one above the other, that can only move up and down: one row for each contact.
pub fn add_column(world: &mut World, n: usize) -> Result<(BodyHandle, Vec<BodyHandle>)> {
    let ground = add_ground(world)?;
    let ball =
        Body::dynamic(Shape::ball(0.5)).mass(MASS).lock_translation([true, false, true]).lock_rotation([true; 3]);
    let balls: std::result::Result<Vec<_>, _> =
        (0..n).map(|k| world.add_body(ball.clone().at(Vec3::new(0.0, k as f32 + 0.5, 0.0)))).collect();
    Ok((ground, balls?))
}

/// Steps without looking.
pub fn run(world: &mut World, steps: usize) {
    for _ in 0..steps {
        world.step(DT);
    }
}

/// A body that must be there.
pub fn body(world: &World, handle: BodyHandle) -> Result<&BodyState> {
    world.body(handle).ok_or_else(|| Error::Missing("a body of the experiment is gone".to_string()))
}

/// Normal force of the contacts between two bodies over the last step, N.
pub fn force_between(world: &World, one: BodyHandle, other: BodyHandle) -> f32 {
    let between =
        |c: &ContactView<'_>| (c.a.body == one && c.b.body == other) || (c.a.body == other && c.b.body == one);
    let points = world.contacts().filter(between).flat_map(|c| c.manifolds).flat_map(|m| &m.points);
    points.map(|p| p.impulse).sum::<f32>() / DT
}

/// From which sweep on (counted from 1) the residual stays at or below `part` of `scale`; `None` if it does not.
pub fn sweeps_to(residuals: &[f32], part: f32, scale: f32) -> Option<usize> {
    match residuals.iter().rposition(|r| *r > part * scale) {
        None => Some(1),
        Some(last) if last + 1 < residuals.len() => Some(last + 2),
        Some(_) => None,
    }
}

/// (k, y) for k = 1, 2, …
pub fn counted(values: impl IntoIterator<Item = f32>) -> Vec<(f64, f64)> {
    values.into_iter().enumerate().map(|(i, y)| ((i + 1) as f64, f64::from(y))).collect()
}
