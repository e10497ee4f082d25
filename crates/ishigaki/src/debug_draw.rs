//! Lines that show what the engine sees: shapes, bounds, contacts, joints, centers, velocities.
//!
//! The engine draws nothing itself: implement [`DebugDraw`] for your renderer and call [`World::debug_draw`]
//! after each step. The order of the lines depends on the history of calls alone, so pictures can be compared.
//! Colors tell the state of a body: fixed, kinematic, dynamic, asleep (D9), frozen by aggressive sleep (D10).

mod wireframe;

use crate::body::{BodyKind, BodyState};
use crate::math::{Pose, Vec3};
use crate::world::World;

/// Red, green, blue, opacity; linear, in [0, 1].
pub type Color = [f32; 4];

/// A renderer of lines and points. World coordinates, m.
pub trait DebugDraw {
    /// A line from `a` to `b`.
    fn line(&mut self, a: Vec3, b: Vec3, color: Color);

    /// A point; `size` in m.
    fn point(&mut self, position: Vec3, size: f32, color: Color);

    /// Text at a point; ignored unless implemented.
    fn label(&mut self, position: Vec3, text: &str, color: Color) {
        let _ = (position, text, color);
    }
}

/// What is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct DebugDrawOptions {
    /// Wireframes of all shapes.
    pub shapes: bool,
    /// Fat bounds of the broad phase.
    pub bounds: bool,
    /// Contact points, and along each normal the push on the lighter body, as long as its impulse says.
    pub contacts: bool,
    /// The joint's frame on both bodies, and lines from the centers to the anchors.
    pub joints: bool,
    /// Centers of mass.
    pub centers_of_mass: bool,
    /// Velocities of the centers of mass.
    pub velocities: bool,
    /// Angular velocities.
    pub angular_velocities: bool,
    /// Axes of the bodies' frames: x red, y green, z blue.
    pub axes: bool,
    /// Names of bodies and joints.
    pub names: bool,
    /// Length of axes and normals, size of points, spacing of grids: × length scale.
    pub size: f32,
    /// m of line for 1 m/s of a normal impulse over the last step divided by the lighter body's mass.
    pub impulse_scale: f32,
    /// m of line for 1 m/s, and for 1 rad/s.
    pub velocity_scale: f32,
    /// Colors by state.
    pub colors: DebugColors,
}

impl Default for DebugDrawOptions {
    /// Shapes, contacts and joints.
    fn default() -> Self {
        Self {
            shapes: true,
            bounds: false,
            contacts: true,
            joints: true,
            centers_of_mass: false,
            velocities: false,
            angular_velocities: false,
            axes: false,
            names: false,
            size: 0.2,
            impulse_scale: 1.0,
            velocity_scale: 0.1,
            colors: DebugColors::default(),
        }
    }
}

impl DebugDrawOptions {
    /// Everything there is.
    pub fn all() -> Self {
        Self {
            bounds: true,
            centers_of_mass: true,
            velocities: true,
            angular_velocities: true,
            axes: true,
            names: true,
            ..Self::default()
        }
    }
}

/// Colors by state.
#[derive(Clone, Debug, PartialEq)]
pub struct DebugColors {
    /// Fixed bodies.
    pub fixed: Color,
    /// Kinematic bodies.
    pub kinematic: Color,
    /// Dynamic bodies that are simulated.
    pub dynamic: Color,
    /// Dynamic bodies whose island sleeps.
    pub asleep: Color,
    /// Dynamic bodies with a pair frozen by aggressive sleep.
    pub frozen: Color,
    /// Sensors.
    pub sensor: Color,
    /// Bounds of the broad phase.
    pub bounds: Color,
    /// Contact points and normals.
    pub contact: Color,
    /// Contact points and normals of frozen pairs.
    pub frozen_contact: Color,
    /// Anchors of joints.
    pub joint: Color,
    /// Centers of mass.
    pub center: Color,
    /// Velocities.
    pub velocity: Color,
    /// Angular velocities.
    pub angular_velocity: Color,
}

impl Default for DebugColors {
    fn default() -> Self {
        Self {
            fixed: [0.45, 0.45, 0.45, 1.0],
            kinematic: [0.2, 0.6, 1.0, 1.0],
            dynamic: [1.0, 0.75, 0.3, 1.0],
            asleep: [0.35, 0.4, 0.6, 1.0],
            frozen: [0.4, 0.85, 0.9, 1.0],
            sensor: [0.9, 0.9, 0.2, 0.6],
            bounds: [0.5, 0.2, 0.5, 0.5],
            contact: [1.0, 0.2, 0.2, 1.0],
            frozen_contact: [0.3, 0.7, 1.0, 1.0],
            joint: [0.2, 0.9, 0.4, 1.0],
            center: [1.0, 1.0, 1.0, 1.0],
            velocity: [0.3, 1.0, 0.3, 1.0],
            angular_velocity: [1.0, 0.3, 1.0, 1.0],
        }
    }
}

const RED: Color = [1.0, 0.0, 0.0, 1.0];
const GREEN: Color = [0.0, 1.0, 0.0, 1.0];
const BLUE: Color = [0.0, 0.0, 1.0, 1.0];

impl World {
    /// Draws the world as it is after the last step.
    ///
    /// ```
    /// use ishigaki::debug_draw::{Color, DebugDraw, DebugDrawOptions};
    /// use ishigaki::{Body, Shape, Vec3, World, WorldOptions};
    ///
    /// #[derive(Default)]
    /// struct Lines(Vec<(Vec3, Vec3, Color)>);
    ///
    /// impl DebugDraw for Lines {
    ///     fn line(&mut self, a: Vec3, b: Vec3, color: Color) {
    ///         self.0.push((a, b, color));
    ///     }
    ///     fn point(&mut self, _: Vec3, _: f32, _: Color) {}
    /// }
    ///
    /// # fn main() -> ishigaki::Result<()> {
    /// let mut world = World::new(WorldOptions::default())?;
    /// world.add_body(Body::dynamic(Shape::cuboid(0.5, 0.5, 0.5)))?;
    /// let mut lines = Lines::default();
    /// world.debug_draw(&mut lines, &DebugDrawOptions::default());
    /// assert_eq!(lines.0.len(), 12, "the edges of a box");
    /// # Ok(())
    /// # }
    /// ```
    pub fn debug_draw(&self, draw: &mut impl DebugDraw, options: &DebugDrawOptions) {
        let size = options.size * self.options.length_scale;
        let frozen = self.frozen_bodies();
        for (slot, body) in self.bodies.iter().filter(|(_, body)| body.is_finite()) {
            let color = body_color(body, frozen[slot as usize], &options.colors);
            self.draw_shapes(draw, options, body, color, size);
            draw_body(draw, options, body, color, size);
        }
        if options.contacts {
            self.draw_contacts(draw, options, size);
        }
        if options.joints {
            self.draw_joints(draw, options, size);
        }
    }

    /// By slot: whether a pair of the body is frozen.
    fn frozen_bodies(&self) -> Vec<bool> {
        let mut frozen = vec![false; self.bodies.slot_count()];
        for contact in self.contacts.iter().filter(|c| c.is_frozen()) {
            frozen[contact.body_a as usize] = true;
            frozen[contact.body_b as usize] = true;
        }
        frozen
    }

    fn draw_shapes(
        &self,
        draw: &mut impl DebugDraw,
        options: &DebugDrawOptions,
        body: &BodyState,
        color: Color,
        size: f32,
    ) {
        for &slot in &body.shapes {
            let shape = self.shapes.at(slot);
            if options.shapes {
                let color = if shape.shape.sensor { options.colors.sensor } else { color };
                wireframe::geometry(draw, &shape.shape.geometry, &shape.world_from_shape(body), color, size);
            }
            if options.bounds {
                let (min, max) = (shape.bounds_min, shape.bounds_max);
                let center = Pose::from_translation(0.5 * (min + max));
                wireframe::cuboid(draw, &center, 0.5 * (max - min), options.colors.bounds);
            }
        }
    }

    fn draw_contacts(&self, draw: &mut impl DebugDraw, options: &DebugDrawOptions, size: f32) {
        for contact in self.contacts.iter().filter(|c| c.touching && !c.sensor) {
            let colors = &options.colors;
            let color = if contact.is_frozen() { colors.frozen_contact } else { colors.contact };
            let (a, b) = (self.bodies.at(contact.body_a), self.bodies.at(contact.body_b));
            // 1/m is 0 for what does not move: the lighter body has the greater one. The line shows its push.
            let push_a = a.inverse_mass > b.inverse_mass;
            let speed_by_impulse = a.inverse_mass.max(b.inverse_mass);
            for manifold in &contact.manifolds {
                let direction = if push_a { manifold.normal } else { -manifold.normal };
                for point in &manifold.points {
                    let position = if push_a { a.center + point.arm_a } else { b.center + point.arm_b };
                    draw.point(position, 0.25 * size, color);
                    let length = options.impulse_scale * speed_by_impulse * point.impulse;
                    draw.line(position, position + direction * length, color);
                }
            }
        }
    }

    fn draw_joints(&self, draw: &mut impl DebugDraw, options: &DebugDrawOptions, size: f32) {
        for (_, joint) in self.joints.iter() {
            let definition = joint.definition();
            let bodies = (self.body(definition.body_a), self.body(definition.body_b));
            let (Some(a), Some(b)) = bodies else { continue };
            if !(a.is_finite() && b.is_finite()) {
                continue;
            }
            let resolved = &joint.resolved;
            let on_a = Pose::from_parts(a.center, a.rotation) * Pose::from_parts(resolved.anchor_a, resolved.frame_a);
            let on_b = Pose::from_parts(b.center, b.rotation) * Pose::from_parts(resolved.anchor_b, resolved.frame_b);
            let color = options.colors.joint;
            draw.line(a.center, on_a.translation, color);
            draw.line(b.center, on_b.translation, color);
            // Where the anchors should be one point, this line is the joint's error.
            draw.line(on_a.translation, on_b.translation, RED);
            axes(draw, &on_a, size);
            axes(draw, &on_b, 0.75 * size);
            if options.names && !definition.name.is_empty() {
                draw.label(on_a.translation, &definition.name, color);
            }
        }
    }
}

fn body_color(body: &BodyState, frozen: bool, colors: &DebugColors) -> Color {
    match body.kind {
        BodyKind::Fixed => colors.fixed,
        BodyKind::Kinematic => colors.kinematic,
        BodyKind::Dynamic if body.asleep => colors.asleep,
        BodyKind::Dynamic if frozen => colors.frozen,
        BodyKind::Dynamic => colors.dynamic,
    }
}

fn draw_body(draw: &mut impl DebugDraw, options: &DebugDrawOptions, body: &BodyState, color: Color, size: f32) {
    let center = body.center;
    if options.centers_of_mass {
        draw.point(center, 0.25 * size, options.colors.center);
    }
    if options.velocities && body.velocity != Vec3::ZERO {
        draw.line(center, center + options.velocity_scale * body.velocity, options.colors.velocity);
    }
    if options.angular_velocities && body.angular_velocity != Vec3::ZERO {
        let tip = center + options.velocity_scale * body.angular_velocity;
        draw.line(center, tip, options.colors.angular_velocity);
    }
    if options.axes {
        axes(draw, &body.pose(), size);
    }
    if options.names && !body.name.is_empty() {
        draw.label(center, &body.name, color);
    }
}

fn axes(draw: &mut impl DebugDraw, pose: &Pose, size: f32) {
    for (axis, color) in [(Vec3::X, RED), (Vec3::Y, GREEN), (Vec3::Z, BLUE)] {
        draw.line(pose.translation, pose.translation + pose.rotation * axis * size, color);
    }
}
