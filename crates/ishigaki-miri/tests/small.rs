//! Everything a step touches, under the eyes of an interpreter that finds undefined
//! behavior in us and in what we depend on.

use ishigaki::World;
use ishigaki_miri::small_world;

#[test]
fn a_step_a_snapshot_and_a_removal() {
    let mut world = small_world().unwrap();
    for _ in 0..2 {
        let report = world.step(1.0 / 60.0);
        assert!(report.rejected.is_none() && report.non_finite.is_empty());
    }
    assert!(world.contacts().count() >= 2, "the box on the ground, the ball on the box");

    let mut restored = World::restore(&world.snapshot()).unwrap();
    world.step(1.0 / 60.0);
    restored.step(1.0 / 60.0);
    assert_eq!(world.state_hash(), restored.state_hash());

    let (top, _) = world.bodies().nth(2).unwrap();
    assert!(world.remove_body(top));
    world.step(1.0 / 60.0);
    assert_eq!(world.bodies().count(), 3);
}
