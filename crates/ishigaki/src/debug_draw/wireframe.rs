//! The edges of each geometry, and a few lines on the round ones.

use super::{Color, DebugDraw};
use crate::math::{Pose, Vec3, cos, sin, tangents};
use crate::shape::{ConvexHull, Geometry, HeightField};
use std::f32::consts::{PI, TAU};

/// Straight pieces of a full circle.
const SEGMENTS: u32 = 24;

/// Squares from the middle of a half-space's grid to its rim.
const GRID: i32 = 10;

/// Draws a geometry at `pose`; `spacing` is that of a half-space's grid, m.
pub(super) fn geometry(draw: &mut impl DebugDraw, geometry: &Geometry, pose: &Pose, color: Color, spacing: f32) {
    match geometry {
        Geometry::Ball { radius } => {
            for (u, v) in [(Vec3::X, Vec3::Y), (Vec3::Y, Vec3::Z), (Vec3::Z, Vec3::X)] {
                arc(draw, pose, Vec3::ZERO, u * *radius, v * *radius, TAU, color);
            }
        }
        Geometry::Cuboid { half_extents } => cuboid(draw, pose, *half_extents, color),
        Geometry::Capsule { half_length, radius } => capsule(draw, pose, *half_length, *radius, color),
        Geometry::Cylinder { half_height, radius } => cylinder(draw, pose, *half_height, *radius, color),
        Geometry::Cone { half_height, radius } => cone(draw, pose, *half_height, *radius, color),
        Geometry::ConvexHull(hull) => convex_hull(draw, pose, hull, color),
        Geometry::HalfSpace { normal } => half_space(draw, pose, *normal, spacing, color),
        Geometry::TriangleMesh(mesh) => {
            for &[i, j, k] in mesh.triangles() {
                let [a, b, c] = [i, j, k].map(|i| *pose * mesh.vertices()[i as usize]);
                draw.line(a, b, color);
                draw.line(b, c, color);
                draw.line(c, a, color);
            }
        }
        Geometry::HeightField(field) => height_field(draw, pose, field, color),
        Geometry::Compound(shapes) => {
            for shape in shapes {
                self::geometry(draw, &shape.geometry, &(*pose * shape.pose), color, spacing);
            }
        }
    }
}

fn convex_hull(draw: &mut impl DebugDraw, pose: &Pose, hull: &ConvexHull, color: Color) {
    let (points, corners) = (hull.polyhedron.points(), hull.polyhedron.vertices_adj_to_face());
    for face in hull.polyhedron.faces() {
        let first = face.first_vertex_or_edge as usize;
        let around = &corners[first..first + face.num_vertices_or_edges as usize];
        for (&i, &j) in around.iter().zip(around.iter().cycle().skip(1)) {
            // Two faces share an edge and go along it in opposite directions: one of them draws it.
            if i < j {
                draw.line(*pose * points[i as usize], *pose * points[j as usize], color);
            }
        }
    }
}

/// The twelve edges of a box.
pub(super) fn cuboid(draw: &mut impl DebugDraw, pose: &Pose, half: Vec3, color: Color) {
    for axis in 0..3 {
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        for (sign_b, sign_c) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            let mut start = Vec3::ZERO;
            start[axis] = -half[axis];
            start[b] = sign_b * half[b];
            start[c] = sign_c * half[c];
            let mut end = start;
            end[axis] = half[axis];
            draw.line(*pose * start, *pose * end, color);
        }
    }
}

/// center + u cos φ + v sin φ for φ from 0 to `angle` (rad).
fn arc(draw: &mut impl DebugDraw, pose: &Pose, center: Vec3, u: Vec3, v: Vec3, angle: f32, color: Color) {
    let segments = (SEGMENTS as f32 * angle / TAU) as u32;
    let mut from = *pose * (center + u);
    for i in 1..=segments {
        let phi = angle * i as f32 / segments as f32;
        let to = *pose * (center + u * cos(phi) + v * sin(phi));
        draw.line(from, to, color);
        from = to;
    }
}

/// Four directions about Y.
const AROUND: [Vec3; 4] = [Vec3::X, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Z];

fn circle_about_y(draw: &mut impl DebugDraw, pose: &Pose, height: f32, radius: f32, color: Color) {
    arc(draw, pose, Vec3::Y * height, Vec3::X * radius, Vec3::Z * radius, TAU, color);
}

fn cylinder(draw: &mut impl DebugDraw, pose: &Pose, half_height: f32, radius: f32, color: Color) {
    for height in [half_height, -half_height] {
        circle_about_y(draw, pose, height, radius, color);
    }
    for direction in AROUND {
        let (up, out) = (Vec3::Y * half_height, direction * radius);
        draw.line(*pose * (out + up), *pose * (out - up), color);
    }
}

fn capsule(draw: &mut impl DebugDraw, pose: &Pose, half_length: f32, radius: f32, color: Color) {
    cylinder(draw, pose, half_length, radius, color);
    for side in [Vec3::X, Vec3::Z] {
        for up in [Vec3::Y, Vec3::NEG_Y] {
            arc(draw, pose, up * half_length, side * radius, up * radius, PI, color);
        }
    }
}

fn cone(draw: &mut impl DebugDraw, pose: &Pose, half_height: f32, radius: f32, color: Color) {
    circle_about_y(draw, pose, -half_height, radius, color);
    let up = Vec3::Y * half_height;
    for direction in AROUND {
        draw.line(*pose * up, *pose * (direction * radius - up), color);
    }
}

/// A grid on the surface around its origin, and the normal.
fn half_space(draw: &mut impl DebugDraw, pose: &Pose, normal: Vec3, spacing: f32, color: Color) {
    let (u, v) = tangents(normal);
    // Five times the size of points and axes: a floor with fewer lines than what stands on it.
    let step = 5.0 * spacing;
    let reach = step * GRID as f32;
    for i in -GRID..=GRID {
        let at = step * i as f32;
        for (along, across) in [(u, v), (v, u)] {
            draw.line(*pose * (across * at - along * reach), *pose * (across * at + along * reach), color);
        }
    }
    draw.line(*pose * Vec3::ZERO, *pose * (normal * step), color);
}

/// The lines of the grid.
fn height_field(draw: &mut impl DebugDraw, pose: &Pose, field: &HeightField, color: Color) {
    let (rows, columns) = field.dimensions();
    let (size_x, size_z) = field.size();
    let point = |row: usize, column: usize| {
        let x = (column as f32 / (columns - 1) as f32 - 0.5) * size_x;
        let z = (row as f32 / (rows - 1) as f32 - 0.5) * size_z;
        *pose * Vec3::new(x, field.heights()[row * columns + column], z)
    };
    for row in 0..rows {
        for column in 0..columns {
            if column + 1 < columns {
                draw.line(point(row, column), point(row, column + 1), color);
            }
            if row + 1 < rows {
                draw.line(point(row, column), point(row + 1, column), color);
            }
        }
    }
}
