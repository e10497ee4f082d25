//! Level correction: what it holds, and that it changes neither what is right nor what falls.

use ishigaki::{Body, BodyHandle, Shape, Vec3, World, WorldOptions};

const DT: f32 = 1.0 / 60.0;
const G: f32 = 9.81;

fn world(change: impl FnOnce(&mut WorldOptions)) -> World {
    let mut options = WorldOptions::default();
    options.rest.sleep.enabled = false;
    change(&mut options);
    World::new(options).unwrap()
}

fn cube(center: Vec3, density: f32) -> Body {
    Body::dynamic(Shape::cuboid(0.5, 0.5, 0.5)).density(density).at(center)
}

/// The ground and `n` cubes of 1 m; the top one `ratio` times as dense.
fn add_tower(world: &mut World, n: usize, ratio: f32) -> Vec<BodyHandle> {
    world.add_body(Body::fixed(Shape::half_space(Vec3::Y))).unwrap();
    let density = |k: usize| if k + 1 == n { 1000.0 * ratio } else { 1000.0 };
    (0..n).map(|k| world.add_body(cube(Vec3::new(0.0, k as f32 + 0.5, 0.0), density(k))).unwrap()).collect()
}

fn center(world: &World, body: BodyHandle) -> Vec3 {
    world.body(body).unwrap().center()
}

/// How far the top went in `seconds`, m.
fn top_moves(n: usize, ratio: f32, seconds: f32, change: impl FnOnce(&mut WorldOptions)) -> f32 {
    let mut world = world(change);
    let boxes = add_tower(&mut world, n, ratio);
    let top = *boxes.last().unwrap();
    let start = center(&world, top);
    for _ in 0..(seconds / DT) as usize {
        world.step(DT);
    }
    (center(&world, top) - start).length()
}

/// Neither corrected nor begun with the weights above.
fn without(options: &mut WorldOptions) {
    options.solver.level_correction.enabled = false;
    options.solver.wide.seed = false;
}

#[test]
fn a_tower_of_160_stands_to_the_millimeter() {
    let on = top_moves(160, 1.0, 5.0, |_| ());
    let off = top_moves(160, 1.0, 5.0, without);
    eprintln!("top of a tower of 160 after 5 s: {:.3} mm on, {:.0} mm off", 1e3 * on, 1e3 * off);
    assert!(on < 2e-3, "{on} m");
    assert!(off > 0.1, "it stands without: {off} m");
}

#[test]
fn light_boxes_bear_what_is_ten_thousand_times_as_heavy() {
    let on = top_moves(10, 1e4, 5.0, |_| ());
    let off = top_moves(10, 1e4, 5.0, without);
    eprintln!("a load of 10000 on nine boxes after 5 s: {:.2} mm on, {:.0} mm off", 1e3 * on, 1e3 * off);
    assert!(on < 0.03, "{on} m");
    assert!(off > 1.0, "it stands without: {off} m");
}

/// The ground bears the whole weight: nothing is attenuated.
#[test]
fn a_scale_reads_the_weight() {
    for (n, ratio) in [(20, 1.0), (10, 100.0)] {
        let mut world = world(|_| ());
        let boxes = add_tower(&mut world, n, ratio);
        let weight: f32 = boxes.iter().map(|&b| world.body(b).unwrap().mass() * G * DT).sum();
        for _ in 0..120 {
            world.step(DT);
        }
        let on_ground = world.contacts().filter(|c| c.a.body == boxes[0] || c.b.body == boxes[0]);
        let load: f32 = on_ground
            .filter(|c| c.a.body != boxes[1] && c.b.body != boxes[1])
            .flat_map(|c| c.manifolds)
            .flat_map(|m| &m.points)
            .map(|p| p.impulse)
            .sum();
        assert!((load / weight - 1.0).abs() < 0.01, "{n} boxes: reads {load} of {weight} N s");
    }
}

/// Without its lowest box a tower falls freely: nothing hangs in the air.
#[test]
fn what_loses_its_support_falls_at_once() {
    let mut world = world(|_| ());
    let boxes = add_tower(&mut world, 10, 1.0);
    for _ in 0..60 {
        world.step(DT);
    }
    assert!(world.remove_body(boxes[0]));
    let start = center(&world, boxes[9]);
    for _ in 0..12 {
        world.step(DT);
    }
    let (fallen, free) = (start.y - center(&world, boxes[9]).y, 0.5 * G * (12.0 * DT) * (12.0 * DT));
    assert!((fallen / free - 1.0).abs() < 0.1, "fell {fallen} m, freely {free} m");
}

/// A hit adds no energy, and a hard one fells the tower.
#[test]
fn a_hit_tower_gains_no_energy() {
    let mut world = world(|_| ());
    let boxes = add_tower(&mut world, 20, 1.0);
    for _ in 0..60 {
        world.step(DT);
    }
    let mut ball = Body::dynamic(Shape::ball(0.5)).density(4000.0).at(Vec3::new(-2.0, 15.0, 0.0));
    ball.velocity = Vec3::new(30.0, 0.0, 0.0);
    world.add_body(ball).unwrap();
    let energy = |world: &World| world.report().kinetic_energy + world.report().potential_energy;
    world.step(DT);
    let start = energy(&world);
    for _ in 0..180 {
        world.step(DT);
        assert!(energy(&world) < start * 1.001, "{} of {start} J", energy(&world));
    }
    assert!(center(&world, boxes[19]).y < 15.0, "it still stands: {}", center(&world, boxes[19]));
}

/// The energy that is minimized needs symmetric masses: with amplified ones the technique stays out.
#[test]
fn stays_out_where_masses_are_amplified() {
    let hash = |enabled| {
        let mut world = world(|o| {
            o.solver.weight_amplification.enabled = true;
            o.solver.level_correction.enabled = enabled;
        });
        add_tower(&mut world, 8, 1.0);
        for _ in 0..30 {
            world.step(DT);
        }
        world.snapshot_positions()
    };
    assert_eq!(hash(true), hash(false));
}

trait Positions {
    fn snapshot_positions(&self) -> Vec<[u32; 3]>;
}

impl Positions for World {
    /// Bits of all centers: the hash of a world covers its options.
    fn snapshot_positions(&self) -> Vec<[u32; 3]> {
        self.bodies().map(|(_, b)| b.center().to_array().map(f32::to_bits)).collect()
    }
}
