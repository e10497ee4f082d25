//! The scenes of the table: Ishigaki's named scenes, and a few more that only the bench needs.

mod fields;

use crate::convert::convert;
use crate::scene::{Body, Form, Scene, Shape};
use anyhow::{Context, Result, bail};
use fields::{FIELDS, Field};
use ishigaki::math::{cos, sin};
use ishigaki_scenes::SceneFile;
use ishigaki_scenes::named::Random;

pub use fields::MOST;

/// A scene of the table.
#[derive(Clone, Debug)]
pub struct Entry {
    /// As given to `--scenes` and shown in the table.
    pub name: String,
    /// Suggested number of steps of 1/60 s.
    pub steps: u32,
    /// Parts that are reported apart, besides the whole: name, first step, step after the last.
    pub parts: &'static [(&'static str, u32, u32)],
    source: Source,
}

#[derive(Clone, Debug)]
enum Source {
    Named(String, Vec<(String, f64)>),
    Field(String, Vec<(String, f64)>),
    File(String),
    Own(fn() -> Scene),
}

/// A scene of Ishigaki's under a short name: name, scene, parameters, steps.
type Alias = (&'static str, &'static str, &'static [(&'static str, f64)], u32);

const ALIASES: [Alias; 14] = [
    ("tower20", "tower", &[("n", 20.0)], 600),
    ("tower80", "tower", &[("n", 80.0)], 600),
    ("pyramid30", "pyramid", &[("base", 30.0)], 300),
    ("pyramid100", "pyramid", &[("base", 100.0)], 200),
    ("many_pyramids100", "many_pyramids", &[("rows", 10.0), ("columns", 10.0), ("base", 10.0)], 200),
    ("many_pyramids196", "many_pyramids", &[("rows", 14.0), ("columns", 14.0), ("base", 10.0)], 200),
    ("pile4000", "pile", &[("n", 4000.0)], 300),
    ("ragdolls200", "ragdolls", &[("n", 200.0)], 300),
    ("joint_grid30", "joint_grid", &[("n", 30.0)], 300),
    ("joint_grid100", "joint_grid", &[("n", 100.0)], 200),
    ("heavy_on_light10", "heavy_on_light", &[("n", 10.0), ("ratio", 100.0)], 600),
    ("chain20", "chain", &[("links", 20.0), ("end_mass_ratio", 10.0)], 600),
    ("chain20_swing", "chain", &[("links", 20.0), ("end_mass_ratio", 10.0), ("swing", 1.0)], 600),
    ("chain100_heavy", "chain", &[("links", 100.0), ("end_mass_ratio", 1000.0)], 600),
];

/// Scenes of the bench alone: name, what it is, steps.
type Own = (&'static str, fn() -> Scene, u32);

const OWN: [Own; 3] =
    [("hulls1000", || hulls(1000), 300), ("terrain1000", || terrain(1000), 300), ("free_body", free_body, 1200)];

/// Falls for 2.5 s, then lies.
const PILE_PARTS: &[(&str, u32, u32)] = &[("falling", 0, 150), ("resting", 150, 300)];

/// All scenes of the default table.
pub fn list() -> Vec<Entry> {
    let aliases = ALIASES.iter().map(|&(name, scene, parameters, steps)| Entry {
        name: name.to_string(),
        steps,
        parts: if name == "pile4000" { PILE_PARTS } else { &[] },
        source: Source::Named(scene.to_string(), parameters.iter().map(|&(k, v)| (k.to_string(), v)).collect()),
    });
    let own = OWN.iter().map(|&(name, make, steps)| Entry {
        name: name.to_string(),
        steps,
        parts: &[],
        source: Source::Own(make),
    });
    aliases.chain(own).collect()
}

/// A scene by its name in the table, as a scene of Ishigaki's with parameters (`pyramid:base=40`), or as a file.
pub fn find(text: &str) -> Result<Entry> {
    if let Some(entry) = list().into_iter().find(|e| e.name == text) {
        return Ok(entry);
    }
    let other = |steps, source| Entry { name: text.to_string(), steps, parts: &[], source };
    if text.ends_with(".json") {
        return Ok(other(300, Source::File(text.to_string())));
    }
    let mut words = text.split(':');
    let name = words.next().unwrap_or_default();
    let parameters = words.map(|word| {
        let (key, value) = word.split_once('=').with_context(|| format!("`{word}` in `{text}` is not KEY=VALUE"))?;
        Ok((key.to_string(), value.parse().with_context(|| format!("`{value}` in `{text}` is not a number"))?))
    });
    let parameters = parameters.collect::<Result<Vec<(String, f64)>>>()?;
    if FIELDS.iter().any(|f| f.name == name) {
        return Ok(other(300, Source::Field(name.to_string(), parameters)));
    }
    if !ishigaki_scenes::list().iter().any(|s| s.name == name) {
        let table: Vec<String> = list().into_iter().map(|e| e.name).collect();
        let fields = FIELDS.iter().map(|f| f.name);
        let named: Vec<&str> = ishigaki_scenes::list().iter().map(|s| s.name).chain(fields).collect();
        bail!(
            "there is no scene `{text}`; the table has {}; with parameters, as in pyramid:base=40, there are {}; \
             a path that ends in .json names a scene file",
            table.join(", "),
            named.join(", ")
        );
    }
    Ok(other(300, Source::Named(name.to_string(), parameters)))
}

impl Entry {
    /// The scene for every engine.
    ///
    /// # Errors
    /// Parameters out of range, a file that cannot be read, or things in it that not all engines can do.
    pub fn build(&self) -> Result<Scene> {
        match &self.source {
            Source::Named(name, parameters) => convert(&ishigaki_scenes::named(name, parameters)?),
            Source::Field(name, parameters) => field(name).and_then(|field| field.build(parameters)),
            Source::File(path) => convert(&SceneFile::load(path)?),
            Source::Own(make) => Ok(make()),
        }
        .with_context(|| format!("scene `{}`", self.name))
    }
}

fn field(name: &str) -> Result<&'static Field> {
    FIELDS.iter().find(|f| f.name == name).with_context(|| format!("there is no scene `{name}`"))
}

const GRAVITY: [f32; 3] = [0.0, -9.81, 0.0];

/// `n` hulls of eight kinds, 14 points each on ellipsoids of half axes 0.15 to 0.3 m, dropped from a grid of 0.9 m into
/// an open container as in Ishigaki's `pile`. Seed 21.
fn hulls(n: usize) -> Scene {
    let mut random = Random::new(21);
    let mut scene = Scene { gravity: GRAVITY, ..Scene::default() };
    for _ in 0..8 {
        let axes = [(); 3].map(|()| random.between(0.15, 0.3));
        let points = (0..14).map(|_| {
            let [x, y, z] = (random.rotation() * ishigaki::Vec3::X).to_array();
            [x * axes[0], y * axes[1], z * axes[2]]
        });
        scene.hulls.push(points.collect());
    }
    let columns = 8;
    let width = 0.9 * columns as f32;
    container(&mut scene, width, 0.25 * width + 0.5);
    for k in 0..n {
        let position = cell(k, columns, 0.9, 0.6);
        let mut body = Body::new(true, position, Shape::new(Form::Hull(k % 8)));
        body.rotation = random.rotation().to_array();
        scene.bodies.push(body);
    }
    scene
}

/// `n` boxes of edges 0.3 to 0.6 m, dropped from a grid of 1 m onto a bowl-shaped terrain of waves, 64 × 64 points
/// over 32 × 32 m. Seed 22.
fn terrain(n: usize) -> Scene {
    const COUNT: usize = 64;
    const SIZE: f32 = 32.0;
    let mut random = Random::new(22);
    let mut scene = Scene { gravity: GRAVITY, ..Scene::default() };
    let along = |i: usize| SIZE * (i as f32 / (COUNT - 1) as f32 - 0.5);
    let heights = (0..COUNT * COUNT).map(|i| {
        let (x, z) = (along(i % COUNT), along(i / COUNT));
        0.02 * (x * x + z * z) + 0.4 * sin(0.9 * x) * cos(0.8 * z)
    });
    let field = Form::HeightField { count: COUNT, heights: heights.collect(), size: SIZE };
    scene.bodies.push(Body::new(false, [0.0; 3], Shape::new(field)));
    for k in 0..n {
        let half = [(); 3].map(|()| random.between(0.15, 0.3));
        let mut body = Body::new(true, cell(k, 16, 1.0, 4.0), Shape::new(Form::Cuboid(half)));
        body.rotation = random.rotation().to_array();
        scene.bodies.push(body);
    }
    scene
}

/// A free box of 2 × 1 × 0.5 m without gravity that turns about its middle axis, nearly: it flips again and again, and
/// its energy should stay.
fn free_body() -> Scene {
    let mut body = Body::new(true, [0.0; 3], Shape::new(Form::Cuboid([1.0, 0.5, 0.25])));
    body.angular_velocity = [0.05, 5.0, 0.05];
    Scene { bodies: vec![body], ..Scene::default() }
}

/// Place of the k-th body of a grid of `columns` × `columns` layers, the lowest `height` cells above the ground.
fn cell(k: usize, columns: usize, spacing: f32, height: f32) -> [f32; 3] {
    let (layer, place) = (k / (columns * columns), k % (columns * columns));
    let middle = 0.5 * (columns as f32 - 1.0);
    let at = |i: usize| spacing * (i as f32 - middle);
    [at(place % columns), spacing * (layer as f32 + height), at(place / columns)]
}

/// The k-th of boxes, balls and capsules in turn, as in Ishigaki's `pile`: greatest extent 0.25 to 0.5 m.
fn mixed(k: usize, random: &mut Random) -> Form {
    let size = random.between(0.25, 0.5);
    match k % 3 {
        0 => Form::Cuboid([0.5 * size, 0.5 * random.between(0.25, size), 0.5 * random.between(0.25, size)]),
        1 => Form::Ball(0.5 * size),
        _ => Form::Capsule { half_length: 0.25 * size, radius: 0.25 * size },
    }
}

/// The ground and four fixed walls, 1 m thick, around a square of `width`.
fn container(scene: &mut Scene, width: f32, half_height: f32) {
    scene.bodies.push(Body::new(false, [0.0; 3], Shape::new(Form::HalfSpace)));
    let out = 0.5 * width + 0.5;
    for (x, z) in [(-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0)] {
        let (half_x, half_z) = if x == 0.0 { (0.5 * width + 1.0, 0.5) } else { (0.5, 0.5 * width) };
        let wall = Shape::new(Form::Cuboid([half_x, half_height, half_z]));
        scene.bodies.push(Body::new(false, [x * out, half_height, z * out], wall));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scene_of_the_table_can_be_built_and_starts_without_deep_overlap() {
        for entry in list() {
            let scene = entry.build().unwrap();
            let states: Vec<_> = scene.bodies.iter().map(crate::engine::State::from).collect();
            let mut meter = crate::meter::Meter::new(&scene).unwrap();
            meter.observe(&states, 1.0);
            let quality = meter.quality();
            assert!(quality.penetration_max < 1e-4, "{}: {quality:?}", entry.name);
            assert!(quality.joint_gap_max < 1e-4, "{}: {quality:?}", entry.name);
        }
    }

    #[test]
    fn a_name_that_is_not_known_says_what_is() {
        let message = find("pyramidd").unwrap_err().to_string();
        assert!(message.contains("pyramid100") && message.contains("pyramid:base=40"), "{message}");
        assert!(find("pyramid:base").unwrap_err().to_string().contains("KEY=VALUE"));
        assert_eq!(find("pyramid:base=3").unwrap().build().unwrap().bodies.len(), 7);
        assert!(find("pyramid:base=3.5").unwrap().build().is_err());
    }
}
