//! Where the eye stands. Without a wish it stands so that everything that moves fills the picture.

use ishigaki::math::{cos, sin, tan, tangents};
use ishigaki::{BodyKind, Vec3};
use ishigaki_recording::{BodyEntry, BodyRecord, Frame, Scene, ShapeEntry};

/// Vertical angle of view, rad: long enough a lens that upright things look upright.
const FIELD_OF_VIEW: f32 = 0.5;
/// Share of the picture that stays free at each side.
const MARGIN: f32 = 0.09;
/// How steeply the eye looks down, rad.
const PITCH: f32 = 0.27;
/// The same for what is spread out flat on the ground.
const PITCH_OF_FLAT: f32 = 0.62;
/// How far it stands to the side of the front, rad.
const YAW: f32 = 0.55;
/// Things that are so many times farther from the middle than most others are not waited for.
const STRAY: f32 = 4.0;

/// An eye and what it looks at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where the eye is, world, m.
    pub eye: Vec3,
    /// What is in the middle of the picture, world, m.
    pub target: Vec3,
}

/// A camera made ready: rays through points of the picture.
#[derive(Clone, Copy, Debug)]
pub struct Lens {
    pub eye: Vec3,
    pub forward: Vec3,
    pub right: Vec3,
    pub up: Vec3,
    /// Half the picture's width and height at distance 1.
    half: (f32, f32),
}

impl Camera {
    /// Sees all that moves, from the front, a little from the side and from above.
    pub fn framing(scene: &Scene, frame: &Frame, aspect: f32) -> Self {
        let points = subject(scene, frame);
        Self::fitting(&points, three_quarters(&points, scene.up), scene.up, aspect)
    }

    /// As near as it can be in the direction `back` from the points and still see them all.
    fn fitting(points: &[Vec3], back: Vec3, up: Vec3, aspect: f32) -> Self {
        let lens = Lens::new(Self { eye: back, target: Vec3::ZERO }, up, aspect);
        let free = 1.0 - 2.0 * MARGIN;
        let (tx, ty) = (free * lens.half.0, free * lens.half.1);
        // A point (x, y, z) of the eye's axes is seen if |x − eₓ| ≤ tₓ (z − e_z), so for all of them
        // e_z ≤ −(max(x − tₓz) + max(−x − tₓz)) / 2tₓ, with eₓ in the middle; the same for y.
        let most = |f: &dyn Fn(&Vec3) -> f32| points.iter().map(f).fold(f32::NEG_INFINITY, f32::max);
        let along = |axis: Vec3, t: f32| {
            let plus = most(&|p| p.dot(axis) - t * p.dot(lens.forward));
            let minus = most(&|p| -p.dot(axis) - t * p.dot(lens.forward));
            ((plus, -minus), -0.5 * (plus + minus) / t)
        };
        let ((x, zx), (y, zy)) = (along(lens.right, tx), along(lens.up, ty));
        let z = zx.min(zy);
        // Where one direction has room to spare, the margins on its two sides become equal.
        let centered = |axis: Vec3, t: f32, (plus, minus): (f32, f32)| {
            let slope = |at: f32| move |p: &Vec3| (p.dot(axis) - at) / (p.dot(lens.forward) - z).max(1e-6);
            let (mut low, mut high) = (plus + t * z, minus - t * z);
            for _ in 0..40 {
                let middle = 0.5 * (low + high);
                let slope = slope(middle);
                let is_low = most(&|p| slope(p)) > most(&|p| -slope(p));
                (low, high) = if is_low { (middle, high) } else { (low, middle) };
            }
            0.5 * (low + high)
        };
        let eye = lens.right * centered(lens.right, tx, x) + lens.up * centered(lens.up, ty, y) + lens.forward * z;
        let depth = points.iter().map(|p| (*p - eye).dot(lens.forward)).sum::<f32>() / points.len() as f32;
        Self { eye, target: eye + lens.forward * depth.max(1e-3) }
    }
}

/// Corners of the bounds of everything that the picture is about: what moves, and what small things hold it.
pub fn subject(scene: &Scene, frame: &Frame) -> Vec<Vec3> {
    let corners = |moving: bool| {
        let bodies = scene.bodies.iter().zip(&frame.bodies);
        let chosen = bodies.filter(move |(body, _)| (body.kind == BodyKind::Dynamic) == moving);
        chosen.flat_map(|(body, record)| body_corners(scene, body, record))
    };
    let moving = without_strays(corners(true).flatten().collect());
    if moving.is_empty() {
        let fixed = without_strays(corners(false).flatten().collect());
        return if fixed.is_empty() { vec![Vec3::splat(-1.0), Vec3::ONE] } else { fixed };
    }
    let (least, greatest) = bounds(&moving);
    let size = greatest - least;
    let near = |shape: &[Vec3; 8]| {
        let (low, high) = bounds(shape);
        let center = 0.5 * (low + high);
        (high - low).length() < 1.2 * size.length()
            && center.cmpge(least - 0.25 * size.length()).all()
            && center.cmple(greatest + 0.25 * size.length()).all()
    };
    let holders: Vec<Vec3> = corners(false).filter(near).flatten().collect();
    moving.into_iter().chain(holders).collect()
}

/// Corners of the bounds of each shape of a body that can be seen.
fn body_corners<'a>(
    scene: &'a Scene,
    body: &'a BodyEntry,
    record: &'a BodyRecord,
) -> impl Iterator<Item = [Vec3; 8]> + use<'a> {
    let seen = !record.absent && record.is_finite();
    let shapes = body.shapes.iter().filter(move |shape| seen && !shape.sensor);
    let corners = |shape: &ShapeEntry| {
        let (center, half) = crate::solid::local_box(&scene.geometries[shape.geometry])?;
        let pose = record.pose() * shape.pose();
        let sign = |i: usize, bit: usize| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
        Some(std::array::from_fn(|i| pose * (center + half * Vec3::new(sign(i, 0), sign(i, 1), sign(i, 2)))))
    };
    shapes.filter_map(corners).filter(|corners| corners.iter().all(|corner| corner.is_finite()))
}

/// Least and greatest coordinates.
pub fn bounds(points: &[Vec3]) -> (Vec3, Vec3) {
    points.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)))
}

/// One body that flew away would make all the others small.
fn without_strays(points: Vec<Vec3>) -> Vec<Vec3> {
    let middle = |axis: Vec3| {
        let mut along: Vec<f32> = points.iter().map(|p| p.dot(axis)).collect();
        along.sort_by(f32::total_cmp);
        along.get(along.len() / 2).copied().unwrap_or(0.0)
    };
    let center = Vec3::new(middle(Vec3::X), middle(Vec3::Y), middle(Vec3::Z));
    let mut distances: Vec<f32> = points.iter().map(|p| (*p - center).length()).collect();
    distances.sort_by(f32::total_cmp);
    let usual = distances.get(distances.len() * 4 / 5).copied().unwrap_or(0.0);
    let near: Vec<Vec3> = points.iter().copied().filter(|p| (*p - center).length() <= STRAY * usual).collect();
    if near.is_empty() { points } else { near }
}

/// Unit direction from the subject to the eye; the front is the wider side.
fn three_quarters(points: &[Vec3], up: Vec3) -> Vec3 {
    // Axes of the ground that are the world's own when Y or Z is up.
    let (first, second) = if up.abs().max_element() > 0.99 {
        let first = if up.x.abs() > 0.5 { Vec3::Y } else { Vec3::X };
        (first, first.cross(up))
    } else {
        tangents(up)
    };
    let extent = |axis: Vec3| {
        let along = || points.iter().map(|p| p.dot(axis));
        along().fold(f32::NEG_INFINITY, f32::max) - along().fold(f32::INFINITY, f32::min)
    };
    let (side, front) = if extent(first) >= 0.8 * extent(second) { (first, second) } else { (second, -first) };
    let level = (front * cos(YAW) + side * sin(YAW)).normalize();
    let flat = 1.0 - extent(up) / extent(first).min(extent(second)).max(1e-6);
    let pitch = PITCH + (PITCH_OF_FLAT - PITCH) * flat.clamp(0.0, 1.0);
    level * cos(pitch) + up * sin(pitch)
}

impl Lens {
    pub fn new(camera: Camera, up: Vec3, aspect: f32) -> Self {
        let forward = (camera.target - camera.eye).try_normalize().unwrap_or(Vec3::NEG_Z);
        let right = forward.cross(up).try_normalize().unwrap_or_else(|| tangents(forward).0);
        let half_height = tan(0.5 * FIELD_OF_VIEW);
        Self { eye: camera.eye, forward, right, up: right.cross(forward), half: (aspect * half_height, half_height) }
    }

    /// Unit direction through a point of the picture, both coordinates in [0, 1] from the upper left.
    pub fn direction(&self, x: f32, y: f32) -> Vec3 {
        let across = self.right * ((2.0 * x - 1.0) * self.half.0);
        (self.forward + across + self.up * ((1.0 - 2.0 * y) * self.half.1)).normalize()
    }

    /// Size of a pixel at distance 1, m.
    pub fn pixel(&self, height: usize) -> f32 {
        2.0 * self.half.1 / height as f32
    }
}
