//! What can be drawn over the bodies: contacts with their impulses, and the engine's own lines.

use ishigaki::debug_draw::{Color, DebugColors, DebugDraw, DebugDrawOptions};
use ishigaki::math::tangents;
use ishigaki::{BodyKind, Vec3, World};

/// What [`lines`] draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Overlay {
    /// Fat bounds of the broad phase.
    Bounds,
    /// Frames of joints, and lines from centers to anchors.
    Joints,
    /// Centers of mass.
    Centers,
    /// Velocities and angular velocities.
    Velocities,
    /// One stroke for each constraint row of contacts, along its direction, and the bodies it couples.
    Rows,
}

impl Overlay {
    /// By its name on the page.
    pub fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "bounds" => Self::Bounds,
            "joints" => Self::Joints,
            "centers" => Self::Centers,
            "velocities" => Self::Velocities,
            "rows" => Self::Rows,
            _ => return None,
        })
    }
}

/// Segments: seven numbers for each end, its position (m), then red, green, blue and opacity.
#[derive(Debug, Default)]
struct Segments(Vec<f32>);

impl DebugDraw for Segments {
    fn line(&mut self, a: Vec3, b: Vec3, color: Color) {
        for end in [a, b] {
            self.0.extend(end.to_array());
            self.0.extend(color);
        }
    }

    /// A cross: lines show it at any distance.
    fn point(&mut self, position: Vec3, size: f32, color: Color) {
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            self.line(position - size * axis, position + size * axis, color);
        }
    }
}

/// Line segments, 14 numbers each: two ends of position (m), red, green, blue, opacity.
pub fn lines(world: &World, overlay: Overlay) -> Vec<f32> {
    let mut segments = Segments::default();
    if overlay == Overlay::Rows {
        rows(world, &mut segments);
        return segments.0;
    }
    let options = DebugDrawOptions {
        shapes: false,
        contacts: false,
        bounds: overlay == Overlay::Bounds,
        joints: overlay == Overlay::Joints,
        centers_of_mass: overlay == Overlay::Centers,
        velocities: overlay == Overlay::Velocities,
        angular_velocities: overlay == Overlay::Velocities,
        colors: DebugColors { bounds: [0.62, 0.35, 0.75, 0.8], ..DebugColors::default() },
        ..DebugDrawOptions::default()
    };
    world.debug_draw(&mut segments, &options);
    segments.0
}

const NORMAL_ROW: Color = [0.95, 0.35, 0.25, 1.0];
const FRICTION_ROW: Color = [0.25, 0.6, 0.95, 1.0];
const COUPLING: Color = [0.6, 0.6, 0.6, 0.6];

/// J of a contact row has the row's direction in it: n for the normal row, two tangents for friction.
fn rows(world: &World, segments: &mut Segments) {
    let size = 0.12 * world.options().length_scale;
    for contact in world.contacts() {
        let (Some(a), Some(b)) = (world.body(contact.a.body), world.body(contact.b.body)) else { continue };
        for manifold in contact.manifolds {
            let (tangent_1, tangent_2) = tangents(manifold.normal);
            for point in &manifold.points {
                let at = a.center() + point.arm_a;
                segments.line(at, at + 2.0 * size * manifold.normal, NORMAL_ROW);
                segments.line(at - size * tangent_1, at + size * tangent_1, FRICTION_ROW);
                segments.line(at - size * tangent_2, at + size * tangent_2, FRICTION_ROW);
                for body in [a, b].into_iter().filter(|body| body.kind() == BodyKind::Dynamic) {
                    segments.line(body.center(), at, COUPLING);
                }
            }
        }
    }
}

/// Eight numbers for each contact point: position (m), the unit direction in which the lighter body is pushed, the
/// speed that the impulse of the last step would give that body (m/s), 1 if the pair is frozen. Bodies that sleep are
/// not solved: their impulse is the one they will start from when they wake.
pub fn contact_arrows(world: &World) -> Vec<f32> {
    let mut out = Vec::new();
    let substeps = world.options().solver.substeps as f32;
    for contact in world.contacts() {
        let (Some(a), Some(b)) = (world.body(contact.a.body), world.body(contact.b.body)) else { continue };
        // The mass of what does not move is infinite.
        let push_a = a.mass() < b.mass();
        let inverse_mass = 1.0 / a.mass().min(b.mass());
        let asleep = [a, b].iter().all(|body| body.is_asleep() || body.kind() != BodyKind::Dynamic);
        for manifold in contact.manifolds {
            let direction = if push_a { manifold.normal } else { -manifold.normal };
            for point in &manifold.points {
                let at = if push_a { a.center() + point.arm_a } else { b.center() + point.arm_b };
                out.extend(at.to_array());
                out.extend(direction.to_array());
                let impulse = if asleep { substeps * point.lambda_normal } else { point.impulse };
                out.extend([inverse_mass * impulse, f32::from(u8::from(contact.frozen))]);
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use ishigaki::{Body, Shape};

    #[test]
    fn arrows_of_a_resting_box_carry_its_weight() {
        let mut world = World::default();
        world.add_body(Body::fixed(Shape::half_space(Vec3::Y))).unwrap();
        world.add_body(Body::dynamic(Shape::cuboid(0.5, 0.5, 0.5)).at(Vec3::Y * 0.5)).unwrap();
        let dt = 1.0 / 60.0;
        // Awake, then asleep.
        for asleep in [0, 1] {
            for _ in 0..if asleep == 0 { 20 } else { 100 } {
                world.step(dt);
            }
            assert_eq!(world.report().asleep, asleep);
            let arrows = contact_arrows(&world);
            let (arrows, rest) = arrows.as_chunks::<8>();
            assert!(rest.is_empty() && arrows.len() == 4);
            assert!(arrows.iter().all(|a| a[4] > 0.99), "all push up");
            // Σλ = m g Δt, so the speeds add up to g Δt.
            let sum: f32 = arrows.iter().map(|a| a[6]).sum();
            assert!((sum / (9.81 * dt) - 1.0).abs() < 0.01, "{sum}");
        }
        assert_eq!(lines(&world, Overlay::Rows).len() % 14, 0);
    }
}
