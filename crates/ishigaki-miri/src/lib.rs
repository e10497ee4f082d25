//! A world small enough for Miri. In a package of its own: Miri would otherwise have to compile all that the engine's
//! other tests depend on, which takes longer than the test.

use ishigaki::{Body, Joint, Jointed, Shape, Vec3, World, WorldOptions};

/// A box on the ground, a ball on the box, and a pendulum.
///
/// # Errors
/// None: the definitions are good.
pub fn small_world() -> ishigaki::Result<World> {
    // One substep touches all that four touch, in a quarter of the interpreter's time.
    let mut options = WorldOptions::default();
    options.solver.substeps = 1;
    options.solver.jointed = Jointed::ALIKE;
    let mut world = World::new(options)?;
    let ground = world.add_body(Body::fixed(Shape::half_space(Vec3::Y)))?;
    world.add_body(Body::dynamic(Shape::cuboid(0.5, 0.5, 0.5)).at(Vec3::new(0.0, 0.5, 0.0)))?;
    world.add_body(Body::dynamic(Shape::ball(0.25)).at(Vec3::new(0.1, 1.25, 0.0)))?;
    let bob = world.add_body(Body::dynamic(Shape::ball(0.1)).at(Vec3::new(5.0, 2.0, 0.0)))?;
    world.add_joint(Joint::hinge(ground, bob, Vec3::new(4.0, 2.0, 0.0), Vec3::Z))?;
    Ok(world)
}
