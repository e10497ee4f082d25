//! Where a ray meets a shape, in the shape's own frame: closed forms, parry for surfaces of many triangles.

use ishigaki::Vec3;
use ishigaki_recording::Geometry;
use parry3d::query::{Ray, RayCast};
use parry3d::shape::TriMesh;

/// A shape that rays can meet; lengths in m.
pub enum Solid {
    Ball {
        radius: f32,
    },
    Cuboid {
        half: Vec3,
    },
    Capsule {
        half: f32,
        radius: f32,
    },
    Cylinder {
        half: f32,
        radius: f32,
    },
    Cone {
        half: f32,
        radius: f32,
    },
    /// Outward unit normals n and offsets d: inside where all n·x ≤ d.
    Hull {
        planes: Vec<(Vec3, f32)>,
    },
    Mesh(Box<TriMesh>),
}

/// Distance along the ray and outward unit normal.
pub type Hit = (f32, Vec3);

impl Solid {
    /// `None` for half-spaces, which are no solids here, and for numbers that make no sense.
    pub fn new(geometry: &Geometry) -> Option<Self> {
        let (_, extent) = local_box(geometry)?;
        if !extent.is_finite() {
            return None;
        }
        Some(match geometry {
            &Geometry::Ball { radius } => Self::Ball { radius },
            &Geometry::Cuboid { half_extents } => Self::Cuboid { half: half_extents },
            &Geometry::Capsule { half_length, radius } => Self::Capsule { half: half_length, radius },
            &Geometry::Cylinder { half_height, radius } => Self::Cylinder { half: half_height, radius },
            &Geometry::Cone { half_height, radius } => Self::Cone { half: half_height, radius },
            Geometry::ConvexHull { vertices, faces } => Self::Hull { planes: planes(&points(vertices), faces) },
            Geometry::HalfSpace { .. } => return None,
            Geometry::TriangleMesh { vertices, triangles } => {
                let corners = triangles.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
                Self::Mesh(Box::new(TriMesh::new(points(vertices), corners).ok()?))
            }
            Geometry::HeightField { rows, columns, size_x, size_z, heights } => {
                let (points, corners) = terrain(*rows, *columns, *size_x, *size_z, heights);
                Self::Mesh(Box::new(TriMesh::new(points, corners).ok()?))
            }
        })
    }

    /// The first point of the surface within `reach` along a ray with a unit direction that begins outside.
    pub fn cast(&self, origin: Vec3, direction: Vec3, reach: f32) -> Option<Hit> {
        let hit = match self {
            &Self::Ball { radius } => ball(origin, direction, radius),
            &Self::Cuboid { half } => cuboid(origin, direction, half),
            &Self::Capsule { half, radius } => {
                let cap = |at: f32| {
                    let center = Vec3::Y * at;
                    ball(origin - center, direction, radius)
                };
                nearest([tube(origin, direction, half, radius), cap(half), cap(-half)])
            }
            &Self::Cylinder { half, radius } => {
                let lid = |at: f32| disk(origin, direction, at, radius);
                nearest([tube(origin, direction, half, radius), lid(half), lid(-half)])
            }
            &Self::Cone { half, radius } => {
                nearest([mantle(origin, direction, half, radius), disk(origin, direction, -half, radius), None])
            }
            Self::Hull { planes } => hull(origin, direction, planes),
            Self::Mesh(mesh) => surface(mesh, origin, direction, reach),
        };
        hit.filter(|&(t, _)| t > 0.0 && t < reach)
    }
}

impl Solid {
    /// How far a point of the surface with this normal is from the nearest edge, m, and the normal on the other side
    /// of it; `None` where there is no edge.
    pub fn edge(&self, point: Vec3, normal: Vec3) -> Option<(f32, Vec3)> {
        match self {
            &Self::Cuboid { half } => {
                let on = normal.abs().max_position();
                let inward = half - point.abs();
                let axis = (0..3).filter(|&k| k != on).min_by(|&a, &b| inward[a].total_cmp(&inward[b]))?;
                let mut other = [0.0; 3];
                other[axis] = point[axis].signum();
                Some((inward[axis], Vec3::from_array(other)))
            }
            &Self::Cylinder { half, radius } => {
                let level = Vec3::new(point.x, 0.0, point.z);
                let lid = Vec3::Y * point.y.signum();
                if normal.y.abs() > 0.5 {
                    Some((radius - level.length(), level.normalize_or(Vec3::X)))
                } else {
                    Some((half - point.y.abs(), lid))
                }
            }
            Self::Hull { planes } => {
                let others = planes.iter().filter(|(n, _)| n.dot(normal) < 0.9999);
                // Within the face the way to the edge is longer than that to the other plane.
                let distance = |&(n, offset): &(Vec3, f32)| {
                    let slope = (1.0 - n.dot(normal) * n.dot(normal)).max(1e-4).sqrt();
                    ((offset - n.dot(point)) / slope, n)
                };
                others.map(distance).min_by(|a, b| a.0.total_cmp(&b.0))
            }
            _ => None,
        }
    }

    /// A length that says how small it is, m: edges are worn in proportion.
    pub fn thickness(&self) -> f32 {
        match self {
            &Self::Cuboid { half } => half.min_element(),
            &Self::Cylinder { half, radius } => half.min(radius),
            Self::Hull { planes } => {
                // The width in the direction of the narrowest face.
                let width = |&(n, offset): &(Vec3, f32)| {
                    let across =
                        |&(m, other): &(Vec3, f32)| if m.dot(n) < -0.9 { offset + other } else { f32::INFINITY };
                    planes.iter().map(across).fold(f32::INFINITY, f32::min)
                };
                let least = planes.iter().map(width).fold(f32::INFINITY, f32::min);
                let far = planes.iter().map(|p| p.1.abs()).fold(0.0, f32::max);
                0.5 * least.min(far)
            }
            _ => 0.0,
        }
    }
}

/// Center and half extents of the box around a geometry along its own axes; `None` if it has no bounds.
pub fn local_box(geometry: &Geometry) -> Option<(Vec3, Vec3)> {
    let around = |half: Vec3| Some((Vec3::ZERO, half.abs()));
    match geometry {
        &Geometry::Ball { radius } => around(Vec3::splat(radius)),
        &Geometry::Cuboid { half_extents } => around(half_extents),
        &Geometry::Capsule { half_length, radius } => around(Vec3::new(radius, half_length + radius, radius)),
        &Geometry::Cylinder { half_height, radius } | &Geometry::Cone { half_height, radius } => {
            around(Vec3::new(radius, half_height, radius))
        }
        Geometry::ConvexHull { vertices, .. } | Geometry::TriangleMesh { vertices, .. } => {
            let least = points(vertices).into_iter().fold(Vec3::INFINITY, Vec3::min);
            let greatest = points(vertices).into_iter().fold(Vec3::NEG_INFINITY, Vec3::max);
            Some((0.5 * (least + greatest), 0.5 * (greatest - least)))
        }
        Geometry::HalfSpace { .. } => None,
        Geometry::HeightField { size_x, size_z, heights, .. } => {
            let least = heights.iter().copied().fold(f32::INFINITY, f32::min);
            let greatest = heights.iter().copied().fold(f32::NEG_INFINITY, f32::max);
            let half = Vec3::new(0.5 * size_x, 0.5 * (greatest - least), 0.5 * size_z);
            Some((Vec3::Y * (0.5 * (least + greatest)), half))
        }
    }
}

fn points(flat: &[f32]) -> Vec<Vec3> {
    flat.chunks_exact(3).map(|p| Vec3::new(p[0], p[1], p[2])).collect()
}

/// A terrain as triangles: a tree of triangles answers rays faster than a walk over cells.
fn terrain(rows: usize, columns: usize, size_x: f32, size_z: f32, heights: &[f32]) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let along = |i: usize, count: usize, size: f32| (i as f32 / (count - 1) as f32 - 0.5) * size;
    let point = |(i, &height): (usize, &f32)| {
        Vec3::new(along(i % columns, columns, size_x), height, along(i / columns, rows, size_z))
    };
    let points = heights.iter().enumerate().map(point).collect();
    let mut corners = Vec::with_capacity(2 * (rows - 1) * (columns - 1));
    for row in 0..rows - 1 {
        for column in 0..columns - 1 {
            let here = (row * columns + column) as u32;
            let below = here + columns as u32;
            corners.push([here, below, here + 1]);
            corners.push([below, below + 1, here + 1]);
        }
    }
    (points, corners)
}

fn planes(vertices: &[Vec3], faces: &[Vec<u32>]) -> Vec<(Vec3, f32)> {
    let plane = |face: &Vec<u32>| {
        let at = |i: usize| vertices[face[i % face.len()] as usize] - vertices[face[0] as usize];
        let normal = (0..face.len()).map(|i| at(i).cross(at(i + 1))).sum::<Vec3>().try_normalize()?;
        Some((normal, normal.dot(vertices[face[0] as usize])))
    };
    faces.iter().filter_map(plane).collect()
}

fn nearest(hits: [Option<Hit>; 3]) -> Option<Hit> {
    hits.into_iter().flatten().filter(|hit| hit.0 > 0.0).min_by(|a, b| a.0.total_cmp(&b.0))
}

/// |o + t d|² = r².
fn ball(o: Vec3, d: Vec3, radius: f32) -> Option<Hit> {
    let b = o.dot(d);
    // The nearest point of the ray first: the plain discriminant loses its digits far away.
    let nearest = o - b * d;
    let rest = radius * radius - nearest.length_squared();
    (rest >= 0.0).then(|| {
        let t = -b - rest.sqrt();
        (t, (o + t * d) / radius)
    })
}

fn cuboid(o: Vec3, d: Vec3, half: Vec3) -> Option<Hit> {
    let inverse = Vec3::ONE / d;
    let (a, b) = ((-half - o) * inverse, (half - o) * inverse);
    let (enter, leave) = (a.min(b), a.max(b));
    let t = enter.max_element();
    if t > leave.min_element() {
        return None;
    }
    let mut normal = [0.0; 3];
    // There is none if the ray lies in the plane of a side: then it misses.
    let axis = (0..3).find(|&k| enter[k] == t)?;
    normal[axis] = -d[axis].signum();
    Some((t, Vec3::from_array(normal)))
}

/// The side of a cylinder: x² + z² = r², |y| ≤ h.
fn tube(o: Vec3, d: Vec3, half: f32, radius: f32) -> Option<Hit> {
    let (o2, d2) = (Vec3::new(o.x, 0.0, o.z), Vec3::new(d.x, 0.0, d.z));
    let a = d2.length_squared();
    if a < 1e-12 {
        return None;
    }
    let b = o2.dot(d2) / a;
    let rest = radius * radius - (o2 - b * d2).length_squared();
    if rest < 0.0 {
        return None;
    }
    let t = -b - (rest / a).sqrt();
    let p = o + t * d;
    (p.y.abs() <= half).then(|| (t, Vec3::new(p.x, 0.0, p.z) / radius))
}

/// A disk at height `y`, seen from outside: from above if `y` is positive.
fn disk(o: Vec3, d: Vec3, y: f32, radius: f32) -> Option<Hit> {
    let side = y.signum();
    if side * d.y >= 0.0 {
        return None;
    }
    let t = (y - o.y) / d.y;
    let p = o + t * d;
    (p.x * p.x + p.z * p.z <= radius * radius).then_some((t, Vec3::Y * side))
}

/// The side of a cone: x² + z² = k² (h − y)², |y| ≤ h, with k = r / 2h.
fn mantle(o: Vec3, d: Vec3, half: f32, radius: f32) -> Option<Hit> {
    let k2 = (0.5 * radius / half) * (0.5 * radius / half);
    let below = half - o.y;
    let a = d.x * d.x + d.z * d.z - k2 * d.y * d.y;
    let b = o.x * d.x + o.z * d.z + k2 * below * d.y;
    let c = o.x * o.x + o.z * o.z - k2 * below * below;
    let rest = b * b - a * c;
    if rest < 0.0 || a == 0.0 {
        return None;
    }
    let at = |t: f32| {
        let p = o + t * d;
        let normal = Vec3::new(p.x, k2 * (half - p.y), p.z).try_normalize()?;
        (t > 0.0 && p.y.abs() <= half && normal.dot(d) < 0.0).then_some((t, normal))
    };
    let root = rest.sqrt();
    nearest([at((-b - root) / a), at((-b + root) / a), None])
}

fn hull(o: Vec3, d: Vec3, planes: &[(Vec3, f32)]) -> Option<Hit> {
    let (mut enter, mut leave, mut normal) = (f32::NEG_INFINITY, f32::INFINITY, Vec3::Y);
    for &(n, offset) in planes {
        let (height, speed) = (offset - n.dot(o), n.dot(d));
        if speed == 0.0 {
            if height < 0.0 {
                return None;
            }
        } else if speed < 0.0 {
            if height / speed > enter {
                (enter, normal) = (height / speed, n);
            }
        } else {
            leave = leave.min(height / speed);
        }
    }
    (enter <= leave).then_some((enter, normal))
}

/// A surface is seen from both sides.
fn surface(mesh: &TriMesh, o: Vec3, d: Vec3, reach: f32) -> Option<Hit> {
    let hit = mesh.cast_local_ray_and_get_normal(&Ray::new(o, d), reach, false)?;
    let normal = hit.normal.try_normalize()?;
    Some((hit.time_of_impact, if normal.dot(d) > 0.0 { -normal } else { normal }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rays from all around toward points inside: where they hit, the surface is, and its normal points outward.
    #[test]
    fn rays_end_on_the_surface() {
        let corners = [[-1.0, -1.0, -1.0], [1.0, -1.0, -1.0], [0.0, -1.0, 1.0], [0.0, 1.0, 0.0]];
        let faces = vec![vec![0, 1, 2], vec![0, 3, 1], vec![1, 3, 2], vec![2, 3, 0]];
        let round = |p: Vec3| (p.x * p.x + p.z * p.z).sqrt();
        type Depth = Box<dyn Fn(Vec3) -> f32>;
        let cases: Vec<(Geometry, Depth)> = vec![
            (Geometry::Ball { radius: 0.7 }, Box::new(|p| p.length() - 0.7)),
            (
                Geometry::Cuboid { half_extents: Vec3::new(0.5, 0.7, 0.9) },
                Box::new(|p| (p.abs() - Vec3::new(0.5, 0.7, 0.9)).max_element()),
            ),
            (
                Geometry::Capsule { half_length: 0.6, radius: 0.4 },
                Box::new(|p| (p - Vec3::Y * p.y.clamp(-0.6, 0.6)).length() - 0.4),
            ),
            (
                Geometry::Cylinder { half_height: 0.6, radius: 0.4 },
                Box::new(move |p| (round(p) - 0.4).max(p.y.abs() - 0.6)),
            ),
            (
                Geometry::Cone { half_height: 0.6, radius: 0.6 },
                Box::new(move |p| (round(p) - 0.5 * (0.6 - p.y)).max(-0.6 - p.y)),
            ),
            (
                Geometry::ConvexHull { vertices: corners.concat(), faces: faces.clone() },
                Box::new(move |p| {
                    let at = |i: u32| Vec3::from_array(corners[i as usize]);
                    let depth = |f: &Vec<u32>| {
                        let n = (at(f[1]) - at(f[0])).cross(at(f[2]) - at(f[0])).normalize();
                        n.dot(p - at(f[0]))
                    };
                    faces.iter().map(depth).fold(f32::NEG_INFINITY, f32::max)
                }),
            ),
        ];
        for (geometry, depth) in cases {
            let solid = Solid::new(&geometry).unwrap();
            let mut hits = 0;
            for i in 0..4000u32 {
                let random = |k: u32| 2.0 * crate::palette::fraction(7 * i + k) - 1.0;
                let origin = 3.0 * Vec3::new(random(0), random(1), random(2)).normalize();
                let toward = 0.9 * Vec3::new(random(3), random(4), random(5));
                let direction = (toward - origin).normalize();
                match solid.cast(origin, direction, 100.0) {
                    Some((t, normal)) => {
                        hits += 1;
                        let p = origin + t * direction;
                        assert!(depth(p).abs() < 2e-5, "{geometry:?}: {p} is {} m off", depth(p));
                        assert!(normal.is_normalized() && normal.dot(direction) < 1e-3, "{geometry:?} at {p}");
                        assert!(depth(p + 1e-3 * normal) > 0.0, "{geometry:?}: the normal points inward");
                    }
                    // A ray through a point well inside hits.
                    None => assert!(depth(toward) > -1e-4, "{geometry:?}: missed {toward}"),
                }
            }
            assert!(hits > 500);
        }
    }
}
