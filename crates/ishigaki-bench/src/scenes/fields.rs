//! Scenes of any size, for the scaling series: what is near a body does not depend on how many there are.

use super::{GRAVITY, cell, container, mixed};
use crate::scene::{Body, Form, Scene, Shape};
use anyhow::{Context, Result, bail, ensure};
use ishigaki_scenes::named::Random;

/// A scene of the bench with parameters.
pub struct Field {
    /// As given to `--scenes`.
    pub name: &'static str,
    /// Name, default, least and greatest of each.
    pub parameters: &'static [(&'static str, u32, u32, u32)],
    make: fn(&[usize]) -> Scene,
}

/// Greatest number of bodies.
pub const MOST: u32 = 500_000;

/// All of them.
pub const FIELDS: &[Field] = &[
    Field { name: "bed", parameters: &[("n", 1000, 1, MOST)], make: |p| bed(p[0]) },
    Field { name: "sparse", parameters: &[("n", 1000, 100, MOST)], make: |p| sparse(p[0]) },
    Field { name: "walls", parameters: &[("n", 1000, 1, MOST), ("size", 100, 1, MOST)], make: |p| walls(p[0], p[1]) },
];

impl Field {
    /// The scene with some of its parameters.
    ///
    /// # Errors
    /// A parameter that does not exist, is given twice, out of its range or no whole number.
    pub fn build(&self, given: &[(String, f64)]) -> Result<Scene> {
        let mut values: Vec<usize> = self.parameters.iter().map(|p| p.1 as usize).collect();
        for (i, (key, value)) in given.iter().enumerate() {
            let Some(place) = self.parameters.iter().position(|p| p.0 == key) else {
                let known: Vec<&str> = self.parameters.iter().map(|p| p.0).collect();
                bail!("there is no parameter `{key}`; there are {}", known.join(", "));
            };
            ensure!(!given[..i].iter().any(|(earlier, _)| earlier == key), "{key} is given twice");
            values[place] = self.value(place, *value).with_context(|| key.clone())?;
        }
        Ok((self.make)(&values))
    }

    fn value(&self, place: usize, value: f64) -> Result<usize> {
        let (_, _, least, most) = self.parameters[place];
        let inside = (f64::from(least)..=f64::from(most)).contains(&value);
        ensure!(inside && value.fract() == 0.0, "must be a whole number in [{least}, {most}], is {value}");
        Ok(value as usize)
    }
}

/// Layers of [`bed`].
const LAYERS: usize = 10;

/// `n` boxes, balls and capsules of Ishigaki's `pile`, dropped from a grid of 0.9 m ten layers high into an open
/// container: as deep whatever their number, so that loads, contacts of a body and time to settle stay. Seed 23.
fn bed(n: usize) -> Scene {
    let mut random = Random::new(23);
    let mut scene = Scene { gravity: GRAVITY, ..Scene::default() };
    let columns = ceil_sqrt(n.div_ceil(LAYERS));
    container(&mut scene, 0.9 * columns as f32, 5.0);
    for k in 0..n {
        let mut body = Body::new(true, cell(k, columns, 0.9, 0.6), Shape::new(mixed(k, &mut random)));
        body.rotation = random.rotation().to_array();
        scene.bodies.push(body);
    }
    scene
}

/// Cubes in a tower of [`sparse`].
const TOWER: usize = 3;
/// Distance of its towers, m: two meters of air, in which balls of one meter roll.
const PITCH: f32 = 3.0;
/// Of its balls, m/s.
const SPEED: f32 = 2.0;

/// `n` bodies of which one in a hundred moves: towers of three cubes of 1 m in a square, and balls of 1 m across that
/// roll at 2 m/s between rows of them, all the same way, and touch nothing but the ground.
fn sparse(n: usize) -> Scene {
    let mut scene = Scene { gravity: GRAVITY, ..Scene::default() };
    scene.bodies.push(Body::new(false, [0.0; 3], Shape::new(Form::HalfSpace)));
    let balls = n / 100;
    let cubes = n - balls;
    let columns = ceil_sqrt(cubes.div_ceil(TOWER));
    let at = |i: usize| PITCH * (i as f32 - 0.5 * (columns as f32 - 1.0));
    for k in 0..cubes {
        let (tower, height) = (k / TOWER, k % TOWER);
        let position = [at(tower % columns), height as f32 + 0.5, at(tower / columns)];
        scene.bodies.push(Body::new(true, position, Shape::new(Form::Cuboid([0.5; 3]))));
    }
    // Round after round over the lanes, each as far along as its number: no two balls start close together.
    let rounds = balls.div_ceil(columns).max(1);
    for k in 0..balls {
        let (lane, round) = (k % columns, k / columns);
        let along = at(0) + PITCH * (columns * round / rounds) as f32;
        let mut ball = Body::new(true, [along, 0.5, at(lane) + 0.5 * PITCH], Shape::new(Form::Ball(0.5)));
        ball.velocity = [SPEED, 0.0, 0.0];
        ball.angular_velocity = [0.0, 0.0, -SPEED / 0.5];
        scene.bodies.push(ball);
    }
    scene
}

/// Courses of [`walls`].
const COURSES: usize = 10;

/// `n` cubes of 1 m in walls of `size`, the last of the rest: ten courses, every second set off by a quarter of a
/// cube, 2 m of air between walls. Each is an island; all are as high, or lower than ten cubes.
fn walls(n: usize, size: usize) -> Scene {
    let mut scene = Scene { gravity: GRAVITY, ..Scene::default() };
    scene.bodies.push(Body::new(false, [0.0; 3], Shape::new(Form::HalfSpace)));
    let length = size.div_ceil(COURSES);
    let (wide, deep) = (length as f32 + 2.0, 3.0);
    let count = n.div_ceil(size);
    // About square, seen from above.
    let columns = ((count as f32 * deep / wide).sqrt().round() as usize).max(1);
    let rows = count.div_ceil(columns);
    for k in 0..n {
        let (wall, brick) = (k / size, k % size);
        let (course, place) = (brick / length, brick % length);
        let set_off = if course % 2 == 0 { 0.0 } else { 0.25 };
        let x = wide * ((wall % columns) as f32 - 0.5 * columns as f32) + place as f32 + set_off;
        let z = deep * ((wall / columns) as f32 - 0.5 * (rows as f32 - 1.0));
        scene.bodies.push(Body::new(true, [x, course as f32 + 0.5, z], Shape::new(Form::Cuboid([0.5; 3]))));
    }
    scene
}

fn ceil_sqrt(n: usize) -> usize {
    let floor = n.isqrt();
    if floor * floor < n { floor + 1 } else { floor }
}

#[cfg(test)]
mod tests {
    use super::super::find;
    use crate::engine::{Counts, Engine, KINDS, Setup};
    use crate::scene::Scene;
    use ishigaki::WorldOptions;

    fn scene(name: &str) -> Scene {
        find(name).unwrap().build().unwrap()
    }

    fn dynamic(scene: &Scene) -> usize {
        scene.bodies.iter().filter(|b| b.dynamic).count()
    }

    /// Ishigaki after so many steps.
    fn world(scene: &Scene, sleep: bool, steps: u32) -> Box<dyn Engine> {
        let setup = Setup { threads: 1, sleep, phases: false, ishigaki: WorldOptions::default() };
        let mut engine = (KINDS[0].build)(scene, &setup).unwrap();
        engine.step(steps);
        engine
    }

    fn counts(scene: &Scene, sleep: bool, steps: u32) -> Counts {
        world(scene, sleep, steps).counts().unwrap()
    }

    #[test]
    fn there_are_as_many_bodies_as_asked_for() {
        for n in [100, 999, 1000, 12_345] {
            for name in ["bed", "sparse", "walls"] {
                assert_eq!(dynamic(&scene(&format!("{name}:n={n}"))), n, "{name}");
            }
        }
    }

    #[test]
    fn nothing_overlaps_at_the_start() {
        for name in ["bed:n=500", "sparse:n=2000", "walls:n=500:size=1", "walls:n=505:size=10", "walls:n=500:size=70"] {
            let scene = scene(name);
            let states: Vec<_> = scene.bodies.iter().map(crate::engine::State::from).collect();
            let mut meter = crate::meter::Meter::new(&scene).unwrap();
            meter.observe(&states, 1.0);
            assert!(meter.quality().penetration_max < 1e-4, "{name}: {:?}", meter.quality());
        }
    }

    #[test]
    fn every_wall_is_an_island_and_stands() {
        for (size, islands) in [(1, 300), (10, 30), (100, 3), (300, 1), (70, 5)] {
            let scene = scene(&format!("walls:n=300:size={size}"));
            let mut engine = world(&scene, false, 60);
            assert_eq!(engine.counts().unwrap().islands, islands, "walls of {size}");
            let mut states = Vec::new();
            engine.states(&mut states);
            let mut meter = crate::meter::Meter::new(&scene).unwrap();
            meter.observe(&states, 1.0);
            assert!(meter.quality().stands, "walls of {size}: {:?}", meter.quality());
        }
    }

    #[test]
    fn one_in_a_hundred_moves_in_the_sparse_world_and_goes_on() {
        let scene = scene("sparse:n=1500");
        for steps in [120, 600] {
            assert_eq!(counts(&scene, true, steps).asleep, 1485, "after {steps} steps");
        }
        let mut states = Vec::new();
        world(&scene, true, 120).states(&mut states);
        let moving = states.iter().filter(|s| s.velocity[0] > 1.9).count();
        assert_eq!(moving, 15);
    }

    #[test]
    fn a_bed_has_as_many_contacts_for_a_body_whatever_its_size() {
        let per_body =
            [1000, 4000].map(|n| counts(&scene(&format!("bed:n={n}")), false, 150).contacts as f64 / n as f64);
        assert!((per_body[1] / per_body[0] - 1.0).abs() < 0.1, "{per_body:?}");
    }

    #[test]
    fn bad_parameters_say_what_is_possible() {
        let message = |name: &str| format!("{:#}", find(name).unwrap().build().unwrap_err());
        assert!(message("bed:n=0").contains("[1, 500000]"), "{}", message("bed:n=0"));
        assert!(message("bed:n=1.5").contains("whole"));
        assert!(message("walls:m=1").contains("n, size"));
        assert!(message("walls:n=1:n=2").contains("twice"));
    }
}
