//! Fast bodies pass through nothing: `continuous` balls against thin walls, boxes and triangles.
use ishigaki::*;

const DT: f32 = 1.0 / 60.0;
const SPEED: f32 = 200.0;
const STEPS: usize = 6;

/// splitmix64, for poses.
struct Random(u64);

impl Random {
    /// In [low, high).
    fn within(&mut self, low: f32, high: f32) -> f32 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        low + (high - low) * (((z ^ (z >> 31)) >> 40) as f32 / (1_u64 << 24) as f32)
    }

    fn rotation(&mut self) -> Quat {
        let v = [(); 4].map(|()| self.within(-1.0, 1.0));
        Quat::from_xyzw(v[0], v[1], v[2], v[3] + 1e-3).normalize()
    }
}

/// One shot: a target around the origin whose thin side is z in its frame, and a ball that flies at a point of it.
struct Shot {
    turn: Quat,
    /// In the frame of the target.
    start: Vec3,
    direction: Vec3,
    radius: f32,
    restitution: f32,
}

impl Shot {
    /// At a point (x, y, 0) within `reach`, from an angle of at most 60° against the normal.
    fn new(random: &mut Random, i: usize, reach: f32) -> Self {
        let radius = if i.is_multiple_of(2) { 0.05 } else { 0.025 };
        let restitution = if i.is_multiple_of(4) { 0.8 } else { 0.0 };
        let aim = Vec3::new(random.within(-reach, reach), random.within(-reach, reach), 0.0);
        let slant = random.within(0.0, 1.7);
        let around = random.within(0.0, std::f32::consts::TAU);
        let (sin, cos) = f64::from(around).sin_cos();
        let direction = Vec3::new(slant * cos as f32, slant * sin as f32, -1.0).normalize();
        // The step in which it hits, and where in that step, are left to chance.
        let start = aim - direction * random.within(0.3, 8.0);
        Self { turn: random.rotation(), start, direction, radius, restitution }
    }

    fn ball(&self) -> Body {
        Body::dynamic(Shape::ball(self.radius))
            .at(self.turn * self.start)
            .velocity(self.turn * self.direction * SPEED)
            .restitution(self.restitution)
            .friction(0.3)
            .continuous()
    }

    fn world(&self) -> World {
        World::new(WorldOptions { gravity: Vec3::ZERO, ..WorldOptions::default() }).unwrap()
    }
}

/// Steps and checks what holds in every scene: finite, no energy out of nothing.
fn step(world: &mut World, energy: f32, case: usize) {
    let report = world.step(DT);
    assert!(report.non_finite.is_empty(), "case {case}");
    assert!(report.kinetic_energy <= energy * (1.0 + 1e-3), "case {case}: {} of {energy} J", report.kinetic_energy);
}

fn energy(world: &World, ball: BodyHandle) -> f32 {
    world.body(ball).unwrap().kinetic_energy()
}

/// All shots at a fixed target; the ball stays on the side it came from, in every step.
fn shots_at_wall(shape: &Shape, seed: u64, back: f32) {
    let mut random = Random(seed);
    for case in 0..1000 {
        let shot = Shot::new(&mut random, case, 1.0);
        let mut world = shot.world();
        world.add_body(Body::fixed(shape.clone()).rotated(shot.turn)).unwrap();
        let ball = world.add_body(shot.ball()).unwrap();
        let start_energy = energy(&world, ball);
        for _ in 0..STEPS {
            step(&mut world, start_energy, case);
            let local = shot.turn.inverse() * world.body(ball).unwrap().position();
            let inside = local.x.abs() < 3.0 && local.y.abs() < 3.0;
            assert!(!inside || local.z > back, "case {case}: passed to {local}");
        }
        let after = shot.turn.inverse() * world.body(ball).unwrap().velocity();
        assert!(after.z > -1.0, "case {case}: still flies at the wall with {after}");
    }
}

#[test]
fn nothing_passes_a_thin_wall() {
    shots_at_wall(&Shape::cuboid(5.0, 5.0, 0.01), 1, 0.0);
}

#[test]
fn nothing_passes_a_wall_of_triangles() {
    // 8 × 8 quads over ±5 m, one sheet, seen from +z.
    let n = 8_u32;
    let at = |i: u32| -5.0 + 10.0 * i as f32 / n as f32;
    let vertices = (0..=n).flat_map(|j| (0..=n).map(move |i| Vec3::new(at(i), at(j), 0.0))).collect();
    let quads = (0..n).flat_map(|j| (0..n).map(move |i| j * (n + 1) + i));
    let triangles = quads.flat_map(|v| [[v, v + 1, v + n + 2], [v, v + n + 2, v + n + 1]]).collect();
    shots_at_wall(&Shape::triangle_mesh(vertices, triangles).unwrap(), 2, 0.0);
}

#[test]
fn nothing_passes_a_free_box_without_pushing_it() {
    let mut random = Random(3);
    for case in 0..1000 {
        let shot = Shot::new(&mut random, case, 0.03);
        let mut world = shot.world();
        let half = Vec3::splat(0.05);
        let target = world.add_body(Body::dynamic(Shape::cuboid(half.x, half.y, half.z)).rotated(shot.turn)).unwrap();
        let ball = world.add_body(shot.ball()).unwrap();
        let start_energy = energy(&world, ball);
        let momentum = world.body(ball).unwrap().mass() * world.body(ball).unwrap().velocity();
        let mut hit = false;
        for _ in 0..STEPS {
            step(&mut world, start_energy, case);
            hit |= world.body(target).unwrap().velocity().length() > 0.0;
            let offset =
                shot.turn.inverse() * (world.body(ball).unwrap().center() - world.body(target).unwrap().center());
            let along = offset.dot(shot.direction);
            assert!(hit || along < 0.0, "case {case}: on the far side ({offset}) without having hit");
        }
        assert!(hit, "case {case}: nothing happened");
        let total = world.report().momentum;
        let error = (total - momentum).length() / momentum.length();
        assert!(error < 1e-3, "case {case}: momentum off by {error}");
    }
}

#[test]
fn a_fast_ball_does_not_pass_a_thick_floor_even_without_sweeps() {
    let mut random = Random(4);
    for case in 0..200 {
        let mut world = World::default();
        world.add_body(Body::fixed(Shape::cuboid(20.0, 2.0, 20.0)).at(Vec3::Y * -2.0)).unwrap();
        let radius = if case % 2 == 0 { 0.05 } else { 0.025 };
        let velocity = Vec3::new(random.within(-50.0, 50.0), -100.0, random.within(-50.0, 50.0));
        let height = random.within(0.1, 3.0);
        let ball = Body::dynamic(Shape::ball(radius)).at(Vec3::Y * height).velocity(velocity);
        let ball = world.add_body(ball).unwrap();
        let energy = world.body(ball).unwrap().kinetic_energy();
        for _ in 0..60 {
            let report = world.step(DT);
            assert!(report.non_finite.is_empty());
            assert!(report.kinetic_energy <= 1.02 * energy, "case {case}");
        }
        let state = world.body(ball).unwrap();
        let off = state.position().x.abs().max(state.position().z.abs()) > 20.0;
        assert!(off || state.position().y > radius - 0.05, "case {case}: {}", state.position());
    }
}
