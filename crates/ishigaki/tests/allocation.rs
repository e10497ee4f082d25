//! A settled world allocates nothing in a step. Option by option, since each takes another path.
use ishigaki::*;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// Counts what this thread asks of the system's allocator.
struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

#[expect(unsafe_code, reason = "an allocator cannot be written without; it hands everything on to the system's")]
// SAFETY: every call goes to `System` with the arguments it came with; the counter is a plain thread-local number.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: the caller's promises about `layout` are passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: `pointer` came from `System` with this `layout`.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: `pointer` came from `System` with this `layout`; the caller's promises about `size` are passed on.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Stacks of boxes, a hull, balls and capsules, a hanging chain; settled.
fn settled(edit: impl FnOnce(&mut WorldOptions)) -> World {
    let mut options = WorldOptions::default();
    options.rest.sleep.enabled = false;
    edit(&mut options);
    let mut world = World::new(options).unwrap();
    world.add_body(Body::fixed(Shape::cuboid(20.0, 0.5, 20.0)).at(Vec3::Y * -0.5)).unwrap();
    for i in 0..12 {
        let at = Vec3::new((i / 4) as f32, 0.25 + 0.5 * (i % 4) as f32, 0.0);
        world.add_body(Body::dynamic(Shape::cuboid(0.25, 0.25, 0.25)).at(at)).unwrap();
    }
    world.add_body(Body::dynamic(Shape::ball(0.2)).at(Vec3::new(0.0, 0.2, 2.0))).unwrap();
    world.add_body(Body::dynamic(Shape::capsule(0.3, 0.2)).at(Vec3::new(2.0, 0.5, 2.0))).unwrap();
    let corners: Vec<Vec3> = (0..8)
        .map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 0.4 - Vec3::splat(0.2))
        .collect();
    world.add_body(Body::dynamic(Shape::convex_hull(&corners).unwrap()).at(Vec3::new(4.0, 0.2, 2.0))).unwrap();
    let mut last = world.add_body(Body::fixed(Shape::ball(0.05)).at(Vec3::new(-2.0, 3.0, 0.0))).unwrap();
    for i in 1..5 {
        let at = Vec3::new(-2.0, 3.0 - 0.3 * i as f32, 0.0);
        let link = world.add_body(Body::dynamic(Shape::capsule(0.08, 0.05)).at(at)).unwrap();
        world.add_joint(Joint::ball(last, link, at + Vec3::Y * 0.15).cone(1.0)).unwrap();
        last = link;
    }
    for _ in 0..200 {
        world.step(1.0 / 60.0);
    }
    world
}

fn allocations(world: &mut World) -> usize {
    let before = ALLOCATIONS.get();
    for _ in 0..100 {
        world.step(1.0 / 60.0);
    }
    ALLOCATIONS.get() - before
}

#[test]
fn a_settled_step_allocates_nothing() {
    type Case = (&'static str, fn(&mut WorldOptions));
    let cases: [Case; 7] = [
        ("default", |_| ()),
        ("aggressive sleep off", |o| o.rest.aggressive_sleep.enabled = false),
        ("sleep on", |o| o.rest.sleep.enabled = true),
        ("as in the talk", |o| o.solver = SolverOptions::talk()),
        ("plain", |o| o.solver = SolverOptions::plain()),
        ("shock propagation", |o| o.solver.shock_propagation.enabled = true),
        ("residual by sweep", |o| o.report.residual_by_sweep = true),
    ];
    for (name, edit) in cases {
        let mut world = settled(edit);
        let count = allocations(&mut world);
        // The report that is handed out carries the residuals in a list of its own.
        let allowed = if name == "residual by sweep" { 100 } else { 0 };
        assert_eq!(count, allowed, "{name}: allocations in 100 steps");
    }
    // The counter counts.
    let before = ALLOCATIONS.get();
    drop(std::hint::black_box(vec![1_u8; 100]));
    assert_eq!(ALLOCATIONS.get(), before + 1);
}
