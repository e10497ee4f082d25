//! How bright a point is: a sun with a disk, a sky that is shaded where it cannot be seen, a ground with a grid.

use crate::camera::Lens;
use crate::palette;
use crate::stage::{Met, Stage};
use ishigaki::Vec3;
use ishigaki::math::{cos, exp, sin, tangents};

/// Half the width of the sun's disk, as a slope: larger than ours, for soft shadows.
const SUN_RADIUS: f32 = 0.035;
/// Light of the sun and of the sky, linear.
const SUN: Vec3 = Vec3::new(2.15, 2.03, 1.84);
const SKY: Vec3 = Vec3::new(0.62, 0.69, 0.80);
/// Light that the ground throws back.
const GROUND_GLOW: Vec3 = Vec3::new(0.40, 0.37, 0.34);
/// A white surface that faces the sun is a little over 1.
const EXPOSURE: f32 = 0.47;
/// How clearly an arrow is seen through a body.
const SHINING_THROUGH: f32 = 0.7;
/// Rays into the sky from each point.
const SKY_RAYS: u32 = 3;
/// Picture of emptiness, sRGB: above and at the horizon.
const ZENITH: u32 = 0xC3D0DE;
const HORIZON: u32 = 0xEEF1F3;
/// The ground, sRGB, and how much darker its lines are.
const GROUND: u32 = 0xD5D3CE;
const LINE: f32 = 0.74;

/// The lamps of a picture.
pub struct Light {
    up: Vec3,
    toward_sun: Vec3,
    sun_axes: (Vec3, Vec3),
    /// How far around a point the sky can be hidden, m.
    near: f32,
    /// Between the lines of the ground's grid, m.
    spacing: f32,
    /// Where the ground begins to vanish in the haze, m.
    haze: f32,
    horizon: Vec3,
    zenith: Vec3,
    /// Of a pixel at distance 1, m.
    pixel: f32,
}

impl Light {
    /// The sun stands over the eye's left shoulder; `size` of what is looked at and its `distance`, m.
    pub fn new(lens: &Lens, up: Vec3, size: f32, distance: f32, pixel: f32) -> Self {
        let level = (lens.forward - up * lens.forward.dot(up)).try_normalize().unwrap_or(lens.up);
        let side = level.cross(up).try_normalize().unwrap_or(lens.right);
        let toward_sun = (up * 1.05 - side * 0.75 - level * 0.55).normalize();
        Self {
            up,
            toward_sun,
            sun_axes: tangents(toward_sun),
            near: 0.3 * size,
            spacing: spacing(size),
            haze: distance + 1.5 * size,
            horizon: palette::linear(HORIZON),
            zenith: palette::linear(ZENITH),
            pixel,
        }
    }

    /// Light that comes along a ray; `seed` makes the samples of a point.
    pub fn along(&self, stage: &Stage, origin: Vec3, direction: Vec3, seed: Seed) -> Vec3 {
        let met = stage.cast(origin, direction, f32::MAX);
        let distance = met.as_ref().map_or(f32::MAX, |met| met.distance);
        let light = met.map_or_else(|| self.background(direction), |met| self.of(stage, met, origin, direction, seed));
        match stage.overlay().and_then(|overlay| overlay.cast(origin, direction, f32::MAX)) {
            Some(mark) => {
                let shade = 0.6 + 0.4 * mark.normal.dot(self.toward_sun).max(0.0);
                light.lerp(mark.color * shade, if mark.distance <= distance { 1.0 } else { SHINING_THROUGH })
            }
            None => light,
        }
    }

    fn of(&self, stage: &Stage, met: Met, origin: Vec3, direction: Vec3, seed: Seed) -> Vec3 {
        let background = self.background(direction);
        let point = origin + met.distance * direction;
        let color = self.color(&met, direction);
        let lit = color * self.received(stage, &met, point, seed);
        // Only the ground reaches far enough to be hazy.
        let far = if met.grid.is_some() {
            1.0 - exp(-((met.distance - self.haze).max(0.0) / (2.2 * self.haze)))
        } else {
            0.0
        };
        tone(lit).lerp(background, far)
    }

    fn background(&self, direction: Vec3) -> Vec3 {
        let height = direction.dot(self.up).max(0.0);
        self.horizon.lerp(self.zenith, (2.5 * height).min(1.0))
    }

    fn color(&self, met: &Met, direction: Vec3) -> Vec3 {
        let Some((u, v)) = met.grid else { return met.color };
        let slant = met.normal.dot(direction).abs().max(0.02);
        let footprint = met.distance * self.pixel / slant;
        let width = (0.012 * self.spacing).max(0.75 * met.distance * self.pixel);
        let line = line(u, self.spacing, width, footprint).max(line(v, self.spacing, width, footprint));
        palette::linear(GROUND) * (1.0 - (1.0 - LINE) * line)
    }

    /// What falls on a point: sun where it is seen, sky where it is seen.
    fn received(&self, stage: &Stage, met: &Met, point: Vec3, seed: Seed) -> Vec3 {
        let normal = met.normal;
        // Away from the surface by more than rounding, or it would shade itself.
        let start = point + normal * (1e-4 * met.distance);
        let facing = normal.dot(self.toward_sun);
        let mut sun = Vec3::ZERO;
        if facing > 0.0 {
            let (a, b) = seed.pair(0);
            let (radius, angle) = (SUN_RADIUS * a.sqrt(), std::f32::consts::TAU * b);
            let offset = self.sun_axes.0 * (radius * cos(angle)) + self.sun_axes.1 * (radius * sin(angle));
            if !stage.is_blocked(start, (self.toward_sun + offset).normalize(), f32::MAX) {
                sun = SUN * facing;
            }
        }
        let (t1, t2) = tangents(normal);
        let mut open = 0.0;
        for i in 1..=SKY_RAYS {
            // Toward the sky as a surface sees it: more of what is straight ahead.
            let (a, b) = seed.pair(i);
            let (radius, angle) = (a.sqrt(), std::f32::consts::TAU * b);
            let level = t1 * (radius * cos(angle)) + t2 * (radius * sin(angle));
            let toward = (level + normal * (1.0 - a).max(1e-4).sqrt()).normalize();
            open += if stage.is_blocked(start, toward, self.near) { 0.0 } else { 1.0 };
        }
        open /= SKY_RAYS as f32;
        let upward = 0.5 + 0.5 * normal.dot(self.up);
        let ambient = GROUND_GLOW.lerp(SKY, upward) * (0.25 + 0.75 * open);
        (sun + ambient) * EXPOSURE
    }
}

/// A stream of samples that fill their square evenly (Roberts' R2 sequence), shifted from pixel to pixel.
#[derive(Clone, Copy)]
pub struct Seed {
    /// Of the pixel, in [0, 1).
    pub shift: (f32, f32),
    /// Number of the sample in its pixel, and how many there are.
    pub sample: u32,
    pub samples: u32,
}

impl Seed {
    fn pair(&self, stream: u32) -> (f32, f32) {
        let n = (stream * self.samples + self.sample + 1) as f32;
        let wrap = |x: f32| x - x.floor();
        (wrap(self.shift.0 + 0.754_877_7 * n), wrap(self.shift.1 + 0.569_840_3 * n))
    }
}

/// How much of a footprint around `x` a line of the grid covers.
fn line(x: f32, spacing: f32, width: f32, footprint: f32) -> f32 {
    let distance = (x / spacing - (x / spacing).round()).abs() * spacing;
    let covered = ((0.5 * (width + footprint) - distance) / footprint).clamp(0.0, 1.0) * (width / footprint).min(1.0);
    // Where lines are nearer than pixels there is only their mean.
    let fade = (spacing / (6.0 * footprint)).clamp(0.0, 1.0);
    covered * fade
}

/// 1, 2 or 5 times a power of ten: about a sixth of what is looked at.
fn spacing(size: f32) -> f32 {
    let mut spacing = 1e-3;
    for (i, factor) in [2.0, 2.5, 2.0].iter().cycle().enumerate() {
        if spacing * 6.0 >= size || i > 40 {
            break;
        }
        spacing *= factor;
    }
    spacing
}

/// Bright light fades into white instead of being cut off.
fn tone(light: Vec3) -> Vec3 {
    let curve = |x: f32| if x < 0.6 { x } else { 0.6 + 0.4 * (1.0 - exp(-(x - 0.6) / 0.4)) };
    Vec3::new(curve(light.x), curve(light.y), curve(light.z))
}
