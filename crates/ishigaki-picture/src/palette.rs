//! What has which color. All colors are linear.

use ishigaki::{BodyKind, Vec3};
use ishigaki_recording::{BodyEntry, BodyRecord, Frame, Geometry, Scene};
use std::mem::{Discriminant, discriminant};

/// What colors say.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Coloring {
    /// Bodies of one figure, or of one form and name (numbers left out), are of one family.
    #[default]
    Name,
    /// From the ground up: dark to light.
    Height,
    /// What touches has one color.
    Island,
    /// Awake, asleep, frozen by aggressive sleep.
    State,
}

impl Coloring {
    /// All, by the names of the command line.
    pub const ALL: [(&'static str, Self); 4] =
        [("name", Self::Name), ("height", Self::Height), ("island", Self::Island), ("state", Self::State)];
}

/// sRGB of the families: stones, glazes and woods that get along with each other.
const FAMILIES: [u32; 10] =
    [0xD3B58C, 0x6FA3BF, 0xC9796A, 0x9DB77C, 0xE0BE6E, 0x8F8CC0, 0x6DB0A2, 0xD191AE, 0xB59B85, 0x87A8D0];
/// Toward which each body of a family leans a little: no two stones of a wall are quite alike.
const LEANING: [u32; 2] = [0xB98A5E, 0xB7B5AE];
/// What does not move.
const FIXED: u32 = 0xB4B2AC;
/// What its user moves.
const KINEMATIC: u32 = 0x7FA3C4;
/// Stops of the ramp of heights (after viridis, lighter at its ends).
const RAMP: [u32; 6] = [0x4B3F86, 0x3F6AA0, 0x2F8F93, 0x48B07A, 0x9CC74C, 0xF2DB4E];
const AWAKE: u32 = 0xE0A050;
const ASLEEP: u32 = 0x7884A0;
const FROZEN: u32 = 0x62B6C8;
/// Contact points and impulses.
pub const CONTACT: u32 = 0xD8323C;

/// The color of each body of a frame.
pub fn colors(scene: &Scene, frame: &Frame, coloring: Coloring) -> Vec<Vec3> {
    let families = families(scene);
    let top = frame.bodies.iter().filter_map(|body| body.height).max().unwrap_or(1).max(1);
    let color = |(i, record): (usize, &BodyRecord)| {
        match scene.bodies[i].kind {
            BodyKind::Fixed => return linear(FIXED),
            BodyKind::Kinematic => return linear(KINEMATIC),
            BodyKind::Dynamic => {}
        }
        match coloring {
            Coloring::Name => leaning(linear(FAMILIES[families[i] % FAMILIES.len()]), i as u32),
            Coloring::Height => record.height.map_or(linear(ASLEEP), |h| ramp(h as f32 / top as f32)),
            Coloring::Island => {
                let family = record.island.map_or(0, |island| (mixed(island) >> 8) as usize);
                linear(FAMILIES[family % FAMILIES.len()])
            }
            Coloring::State if record.frozen => linear(FROZEN),
            Coloring::State if record.asleep => linear(ASLEEP),
            Coloring::State => linear(AWAKE),
        }
    };
    frame.bodies.iter().enumerate().map(color).collect()
}

/// What hangs together by joints is one family; of the rest, bodies of one form whose names differ only in numbers
/// are one. Families are counted as they appear.
fn families(scene: &Scene) -> Vec<usize> {
    let figures = figures(scene);
    let mut known: Vec<(Option<usize>, String, Option<Discriminant<Geometry>>)> = Vec::new();
    let family = |(i, body): (usize, &BodyEntry)| {
        if body.kind != BodyKind::Dynamic {
            return 0;
        }
        let key = match figures[i] {
            Some(figure) => (Some(figure), String::new(), None),
            None => {
                let letters = body.name.chars().filter(|c| c.is_alphabetic()).collect();
                let form = body.shapes.first().map(|shape| discriminant(&scene.geometries[shape.geometry]));
                (None, letters, form)
            }
        };
        known.iter().position(|k| *k == key).unwrap_or_else(|| {
            known.push(key);
            known.len() - 1
        })
    };
    scene.bodies.iter().enumerate().map(family).collect()
}

/// For each body that a joint ties to another moving one, the number of the lowest body of its figure.
fn figures(scene: &Scene) -> Vec<Option<usize>> {
    fn root(of: &mut [usize], mut body: usize) -> usize {
        while of[body] != body {
            of[body] = of[of[body]];
            body = of[body];
        }
        body
    }
    let mut of: Vec<usize> = (0..scene.bodies.len()).collect();
    let mut tied = vec![false; of.len()];
    for joint in &scene.joints {
        let (a, b) = (joint.body_a as usize, joint.body_b as usize);
        if [a, b].iter().all(|&body| scene.bodies[body].kind == BodyKind::Dynamic) {
            let (a_root, b_root) = (root(&mut of, a), root(&mut of, b));
            of[a_root.max(b_root)] = a_root.min(b_root);
            (tied[a], tied[b]) = (true, true);
        }
    }
    (0..of.len()).map(|body| tied[body].then(|| root(&mut of, body))).collect()
}

fn leaning(color: Vec3, number: u32) -> Vec3 {
    let [warm, gray] = [0x51_u32, 0xA7].map(|salt| fraction(number.wrapping_mul(977).wrapping_add(salt)));
    let color = color.lerp(color * linear(LEANING[0]) * 1.9, 0.45 * warm);
    let color = color.lerp(linear(LEANING[1]), 0.25 * gray);
    color * (0.88 + 0.24 * fraction(number))
}

fn ramp(at: f32) -> Vec3 {
    let at = at.clamp(0.0, 1.0) * (RAMP.len() - 1) as f32;
    let first = (at as usize).min(RAMP.len() - 2);
    linear(RAMP[first]).lerp(linear(RAMP[first + 1]), at - first as f32)
}

/// In [0, 1), the same for the same number.
pub fn fraction(number: u32) -> f32 {
    (mixed(number) >> 8) as f32 / (1 << 24) as f32
}

/// A number whose bits all depend on all bits (Wellons, "lowbias32").
pub fn mixed(number: u32) -> u32 {
    let x = (number ^ (number >> 16)).wrapping_mul(0x7feb_352d);
    let x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// A color as it is written for the web, as light.
pub fn linear(srgb: u32) -> Vec3 {
    let channel = |shift: u32| {
        let value = f64::from(srgb >> shift & 0xFF) / 255.0;
        (if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }) as f32
    };
    Vec3::new(channel(16), channel(8), channel(0))
}

/// Light as a byte of a picture.
pub fn byte(light: f32) -> u8 {
    let light = f64::from(light.clamp(0.0, 1.0));
    let value = if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 };
    (255.0 * value).round() as u8
}
