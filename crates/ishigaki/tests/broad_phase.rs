//! The broad phase against all pairs of boxes.

use ishigaki::Vec3;
use ishigaki::collision::broad_phase::BroadPhase;
use std::collections::BTreeMap;

/// A small generator (xorshift64*), so that the scenes are the same everywhere.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 16
    }

    fn below(&mut self, n: u64) -> u64 {
        self.next() % n
    }

    fn between(&mut self, lower: f32, upper: f32) -> f32 {
        lower + (upper - lower) * (self.below(1 << 24) as f32 / (1 << 24) as f32)
    }

    fn vector(&mut self, lower: f32, upper: f32) -> Vec3 {
        Vec3::new(self.between(lower, upper), self.between(lower, upper), self.between(lower, upper))
    }

    /// Mostly small, sometimes wide as a scene, sometimes on a grid so that boxes just touch, rarely unbounded.
    fn bounds(&mut self) -> (Vec3, Vec3) {
        match self.below(100) {
            0 => (Vec3::splat(-1e8), Vec3::splat(1e8)),
            1 => (Vec3::splat(f32::NEG_INFINITY), Vec3::new(f32::INFINITY, 0.0, f32::INFINITY)),
            2 => (Vec3::splat(f32::NAN), Vec3::splat(1.0)),
            3..10 => {
                let min = self.vector(-10.0, 0.0);
                (min, min + self.vector(0.0, 10.0))
            }
            10..40 => {
                let min = self.vector(-10.0, 10.0).floor();
                (min, min + Vec3::ONE)
            }
            _ => {
                let min = self.vector(-10.0, 10.0);
                (min, min + self.vector(0.1, 1.5))
            }
        }
    }
}

type Boxes = BTreeMap<u32, (Vec3, Vec3)>;

fn touch(a: (Vec3, Vec3), b: (Vec3, Vec3)) -> bool {
    (0..3).all(|i| a.0[i] <= b.1[i] && b.0[i] <= a.1[i])
}

fn all_pairs(boxes: &Boxes, moved: &[u32], is_wanted: impl Fn(u32, u32) -> bool) -> Vec<(u32, u32)> {
    let mut pairs = Vec::new();
    for (&a, &box_a) in boxes {
        for (&b, &box_b) in boxes.range(a + 1..) {
            if (moved.contains(&a) || moved.contains(&b)) && touch(box_a, box_b) && is_wanted(a, b) {
                pairs.push((a, b));
            }
        }
    }
    pairs
}

fn wanted(a: u32, b: u32) -> bool {
    !(a + b).is_multiple_of(7)
}

fn rebuilt(boxes: &Boxes) -> BroadPhase {
    let mut broad_phase = BroadPhase::new();
    broad_phase.rebuild(boxes.iter().map(|(&slot, &(min, max))| (slot, min, max)));
    broad_phase
}

#[test]
fn pairs_are_those_of_all_boxes() {
    let mut random = Random(5);
    let mut boxes = Boxes::new();
    let mut broad_phase = BroadPhase::new();
    let mut pairs = Vec::new();
    let mut seen = 0;
    for round in 0..400 {
        let mut moved = Vec::new();
        // Grows to about 150 boxes, then shrinks to nothing and grows again.
        let shrinking = round % 200 > 150;
        for _ in 0..random.below(20) {
            let slot = random.below(200) as u32;
            let (min, max) = random.bounds();
            match (boxes.contains_key(&slot), random.below(4)) {
                (true, 0) => {
                    broad_phase.remove(slot);
                    boxes.remove(&slot);
                }
                (true, _) if shrinking => {
                    broad_phase.remove(slot);
                    boxes.remove(&slot);
                }
                (true, _) => {
                    broad_phase.update(slot, min, max);
                    boxes.insert(slot, (min, max));
                    moved.push(slot);
                }
                (false, _) if shrinking => broad_phase.remove(slot),
                (false, _) => {
                    broad_phase.insert(slot, min, max);
                    boxes.insert(slot, (min, max));
                    moved.push(slot);
                }
            }
        }
        // A slot may have moved and then gone, or moved twice.
        broad_phase.pairs_of(&moved, wanted, &mut pairs);
        assert_eq!(pairs, all_pairs(&boxes, &moved, wanted), "round {round}");
        seen += pairs.len();
        let mut again = Vec::new();
        rebuilt(&boxes).pairs_of(&moved, wanted, &mut again);
        assert_eq!(pairs, again, "rebuilt in round {round}");
        broad_phase.clone().pairs_of(&moved, wanted, &mut again);
        assert_eq!(pairs, again);
    }
    assert!(seen > 5_000, "a test that sees no pairs proves nothing: {seen}");
}

#[test]
fn queries_find_what_touches_the_box() {
    let mut random = Random(9);
    let boxes: Boxes = (0..150).map(|slot| (slot, random.bounds())).collect();
    let broad_phase = rebuilt(&boxes);
    let mut found = Vec::new();
    for _ in 0..300 {
        let query = random.bounds();
        broad_phase.query_aabb(query.0, query.1, &mut found);
        let expected: Vec<u32> = boxes.iter().filter(|(_, b)| touch(**b, query)).map(|(slot, _)| *slot).collect();
        assert_eq!(found, expected);
    }
}

#[test]
fn search_finds_the_least_cost_and_all_ties() {
    // Cost: distance of a point from the box. Many boxes share corners, so ties abound.
    let distance = |point: Vec3, min: Vec3, max: Vec3| (point.clamp(min, max) - point).length();
    let mut random = Random(21);
    let boxes: Boxes = (0..200)
        .map(|slot| {
            let min = random.vector(-6.0, 6.0).floor();
            (slot, (min, min + Vec3::ONE))
        })
        .collect();
    let broad_phase = rebuilt(&boxes);
    let mut visits = 0;
    for _ in 0..300 {
        let point = (2.0 * random.vector(-8.0, 8.0)).floor() / 2.0;
        let cost = |slot: u32| distance(point, boxes[&slot].0, boxes[&slot].1);
        let mut best = (3.0_f32, u32::MAX);
        broad_phase.search(
            best.0,
            |min, max| Some(distance(point, min, max)),
            |slot| {
                visits += 1;
                if (cost(slot), slot) < best {
                    best = (cost(slot), slot);
                }
                best.0
            },
        );
        let expected = boxes.keys().map(|&slot| (cost(slot), slot)).filter(|c| c.0 <= 3.0);
        let expected = expected.min_by(|a, b| a.partial_cmp(b).unwrap()).unwrap_or((3.0, u32::MAX));
        assert_eq!(best, expected);
    }
    assert!(visits < 300 * 200 / 4, "{visits} visits: it must not look at everything");
}

#[test]
fn bounds_are_what_was_put_in() {
    let mut broad_phase = BroadPhase::new();
    broad_phase.insert(3, Vec3::ZERO, Vec3::ONE);
    broad_phase.insert(8, Vec3::splat(-1e8), Vec3::splat(1e8));
    broad_phase.insert(9, Vec3::splat(f32::NAN), Vec3::ONE);
    assert_eq!(broad_phase.bounds(3), Some((Vec3::ZERO, Vec3::ONE)));
    assert_eq!(broad_phase.bounds(8), Some((Vec3::splat(-1e8), Vec3::splat(1e8))));
    assert_eq!(broad_phase.bounds(9), None);
    // From large to small and from small to not finite: never in two places.
    broad_phase.update(8, Vec3::ZERO, Vec3::ONE);
    broad_phase.update(3, Vec3::ZERO, Vec3::splat(f32::NAN));
    let mut found = Vec::new();
    broad_phase.query_aabb(Vec3::splat(-10.0), Vec3::splat(10.0), &mut found);
    assert_eq!(found, [8]);
    broad_phase.remove(8);
    broad_phase.remove(8);
    broad_phase.query_aabb(Vec3::splat(-10.0), Vec3::splat(10.0), &mut found);
    assert!(found.is_empty());
}

#[test]
fn a_tree_of_few_boxes_is_rebuilt_whatever_their_slots() {
    for slots in [&[][..], &[7], &[1, 5], &[5, 1], &[2, 3, 9]] {
        let mut broad_phase = BroadPhase::new();
        broad_phase.rebuild(slots.iter().map(|&slot| (slot, Vec3::splat(slot as f32), Vec3::splat(slot as f32 + 0.5))));
        for slot in 0..10 {
            let low = Vec3::splat(slot as f32);
            let expected = slots.contains(&slot).then_some((low, low + 0.5));
            assert_eq!(broad_phase.bounds(slot), expected, "slot {slot} of {slots:?}");
        }
        slots.iter().for_each(|&slot| broad_phase.remove(slot));
        let mut left = Vec::new();
        broad_phase.query_aabb(Vec3::splat(-1.0), Vec3::splat(20.0), &mut left);
        assert!(left.is_empty(), "{left:?} are left of {slots:?}");
    }
}

#[test]
fn many_boxes_moved_at_once_are_where_they_were_put() {
    let mut random = Random(11);
    let mut boxes: BTreeMap<u32, (Vec3, Vec3)> = (0..120).map(|slot| (slot, random.bounds())).collect();
    let mut broad_phase = rebuilt(&boxes);
    let mut found = Vec::new();
    for round in 0..60 {
        // From a few to all of them, and some that were not there before.
        let share = 1 + round % 12;
        let slots: Vec<u32> = (0..130).filter(|_| random.below(share) == 0).collect();
        for &slot in &slots {
            boxes.insert(slot, random.bounds());
        }
        broad_phase.update_all(&slots, |slot| boxes[&slot]);
        for _ in 0..10 {
            let min = random.vector(-10.0, 8.0);
            let max = min + random.vector(0.0, 4.0);
            broad_phase.query_aabb(min, max, &mut found);
            let touch = |b: &(Vec3, Vec3)| b.0.cmple(max).all() && min.cmple(b.1).all();
            let is_number = |b: &(Vec3, Vec3)| !b.0.is_nan() && !b.1.is_nan();
            let expected: Vec<u32> =
                boxes.iter().filter(|(_, b)| is_number(b) && touch(b)).map(|(&slot, _)| slot).collect();
            assert_eq!(found, expected, "round {round}");
        }
    }
}
