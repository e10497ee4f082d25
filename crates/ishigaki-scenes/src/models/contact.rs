//! MuJoCo's contact filters and friction as the engine has them.
//!
//! MuJoCo lets shapes a and b touch if `contype_a & conaffinity_b` **or** `contype_b & conaffinity_a`; the engine asks
//! both ways (**and**). Exact nevertheless: shapes fall into few classes; each class becomes one group, whose mask
//! names the classes it touches. Friction: MuJoCo takes the greater of the two (`condim`, and each coefficient).

use super::tree::{Piece, Surface};
use ishigaki::{Combine, Groups, Material, Vec3};
use std::collections::{BTreeMap, BTreeSet};

/// MuJoCo's rule.
pub(crate) fn may_touch(a: Surface, b: Surface) -> bool {
    a.contype & b.conaffinity != 0 || b.contype & a.conaffinity != 0
}

/// Explicit exceptions from the rule, by shape id.
#[derive(Debug, Default)]
pub(crate) struct Exceptions {
    /// These never touch, smaller id first.
    pub never: BTreeSet<(usize, usize)>,
    /// These always do.
    pub always: BTreeSet<(usize, usize)>,
}

impl Exceptions {
    fn allow(&self, a: &Piece, b: &Piece) -> bool {
        let key = (a.id.min(b.id), a.id.max(b.id));
        self.always.contains(&key) || (!self.never.contains(&key) && may_touch(a.surface, b.surface))
    }

    fn concerns(&self, id: usize) -> bool {
        self.never.iter().chain(&self.always).any(|&(a, b)| a == id || b == id)
    }
}

/// Group bits of each shape, in order, such that two shapes are allowed if and only if the rule allows them; `false`
/// if there are more than 32 kinds and some had to share a bit (they then touch more than they should).
pub(crate) fn groups(pieces: &[&Piece], exceptions: &Exceptions) -> (Vec<Groups>, bool) {
    // Shapes with the same masks that no exception names are of one kind.
    let mut kinds: Vec<&Piece> = Vec::new();
    let mut index = BTreeMap::new();
    let kind_of: Vec<usize> = pieces
        .iter()
        .map(|p| {
            let own = exceptions.concerns(p.id).then_some(p.id);
            *index.entry((p.surface.contype, p.surface.conaffinity, own)).or_insert_with(|| {
                kinds.push(p);
                kinds.len() - 1
            })
        })
        .collect();
    // Kinds that touch the same kinds are one class.
    let rows: Vec<Vec<bool>> = kinds.iter().map(|a| kinds.iter().map(|b| exceptions.allow(a, b)).collect()).collect();
    let mut classes: Vec<&Vec<bool>> = Vec::new();
    let class_of: Vec<usize> = rows
        .iter()
        .map(|row| {
            classes.iter().position(|c| *c == row).unwrap_or_else(|| {
                classes.push(row);
                classes.len() - 1
            })
        })
        .collect();
    // A class that touches nothing needs no bit.
    let touching: Vec<usize> = (0..classes.len()).filter(|&c| classes[c].contains(&true)).collect();
    let bit = |class: usize| -> u32 { touching.iter().position(|&c| c == class).map_or(0, |i| 1 << i.min(31)) };
    let mut masks = [0_u32; 32];
    for kind in 0..kinds.len() {
        let own = bit(class_of[kind]);
        for other in 0..kinds.len() {
            if rows[kind][other] && own != 0 {
                masks[own.trailing_zeros() as usize] |= bit(class_of[other]);
            }
        }
    }
    let of_piece = |&kind: &usize| {
        let member_of = bit(class_of[kind]);
        let collides_with = if member_of == 0 { 0 } else { masks[member_of.trailing_zeros() as usize] };
        Groups { member_of, collides_with }
    };
    (kind_of.iter().map(of_piece).collect(), touching.len() <= 32)
}

/// Material of each shape, in order; and a sentence about the pairs whose friction the engine cannot tell apart.
pub(crate) fn materials(pieces: &[&Piece]) -> (Vec<Material>, Option<String>) {
    let mut kinds: Vec<(Surface, usize)> = Vec::new();
    let kind_of: Vec<usize> = pieces
        .iter()
        .map(|p| match kinds.iter().position(|(s, _)| *s == p.surface) {
            Some(kind) => {
                kinds[kind].1 += 1;
                kind
            }
            None => {
                kinds.push((p.surface, 1));
                kinds.len() - 1
            }
        })
        .collect();
    let made: Vec<Material> = kinds.iter().map(|(s, _)| material(*s, &kinds)).collect();
    let mut wrong = None;
    let mut count = 0;
    for (i, (a, several)) in kinds.iter().enumerate() {
        for (j, (b, _)) in kinds.iter().enumerate().take(i + 1) {
            if (i == j && *several < 2) || !may_touch(*a, *b) {
                continue;
            }
            let (wanted, is) = (mujoco_friction(*a, *b), mixed(&made[i], &made[j]));
            if wanted.iter().zip(is).any(|(w, i)| (w - f64::from(i)).abs() > 1e-6 * (1.0 + w)) {
                count += 1;
                wrong.get_or_insert((wanted, is));
            }
        }
    }
    let warning = wrong.map(|(wanted, is)| {
        format!(
            "friction of {count} kinds of pairs differs from the file's rule (greater of the two, by condim and priority): for example (slide, spin, roll) {wanted:?} becomes {is:?}"
        )
    });
    (kind_of.iter().map(|&k| made[k]).collect(), warning)
}

/// The greater wins in pairs with friction; shapes without (condim 1) leave it to the other.
fn material(s: Surface, kinds: &[(Surface, usize)]) -> Material {
    let rough = |o: &&(Surface, usize)| o.0.condim >= 3 && may_touch(s, o.0);
    let hidden = s.condim == 1 && kinds.iter().filter(rough).all(|(o, _)| o.friction[0] >= s.friction[0]);
    Material {
        friction: if hidden { 0.0 } else { s.friction[0] as f32 },
        // `Maximum` wins over `Minimum`: two shapes without friction take the smaller, often 0.
        friction_combine: if s.condim == 1 { Combine::Minimum } else { Combine::Maximum },
        restitution: 0.0,
        restitution_combine: Combine::Maximum,
        torsional_friction: if s.condim >= 4 { s.friction[1] as f32 } else { 0.0 },
        rolling_friction: if s.condim >= 6 { s.friction[2] as f32 } else { 0.0 },
        surface_velocity: Vec3::ZERO,
    }
}

/// What the engine makes of two materials.
fn mixed(a: &Material, b: &Material) -> [f32; 3] {
    [
        a.friction_combine.mix(b.friction_combine, a.friction, b.friction),
        a.torsional_friction.max(b.torsional_friction),
        a.rolling_friction.max(b.rolling_friction),
    ]
}

/// What MuJoCo makes of two shapes.
pub(crate) fn mujoco_friction(a: Surface, b: Surface) -> [f64; 3] {
    let (condim, [slide, spin, roll]) = match a.priority.cmp(&b.priority) {
        std::cmp::Ordering::Greater => (a.condim, a.friction),
        std::cmp::Ordering::Less => (b.condim, b.friction),
        std::cmp::Ordering::Equal => {
            (a.condim.max(b.condim), std::array::from_fn(|i| a.friction[i].max(b.friction[i])))
        }
    };
    let from = |least: u8, value: f64| if condim >= least { value } else { 0.0 };
    [from(3, slide), from(4, spin), from(6, roll)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use glamx::DPose3;
    use ishigaki::Geometry;

    fn piece(id: usize, contype: u32, conaffinity: u32, condim: u8, friction: f64) -> Piece {
        let surface = Surface { contype, conaffinity, condim, priority: 0, friction: [friction, 0.005, 0.0001] };
        Piece { id, geometry: Geometry::Ball { radius: 1.0 }, pose: DPose3::IDENTITY, surface }
    }

    /// Against the rule itself, over masks drawn from all 3-bit combinations.
    #[test]
    fn groups_follow_the_rule_of_either_direction() {
        for seed in 0..200_u32 {
            let draw = |k: u32| (seed.wrapping_mul(2_654_435_761).wrapping_add(k.wrapping_mul(40_503)) >> 7) & 7;
            let pieces: Vec<Piece> =
                (0..12).map(|i| piece(i, draw(2 * i as u32), draw(2 * i as u32 + 1), 3, 1.0)).collect();
            let mut exceptions = Exceptions::default();
            exceptions.never.insert((draw(50) as usize, 8));
            exceptions.always.insert((draw(51) as usize, 9));
            let refs: Vec<&Piece> = pieces.iter().collect();
            let (groups, exact) = groups(&refs, &exceptions);
            assert!(exact);
            for (i, a) in pieces.iter().enumerate() {
                for (j, b) in pieces.iter().enumerate() {
                    let key = (i.min(j), i.max(j));
                    let rule = exceptions.always.contains(&key)
                        || (may_touch(a.surface, b.surface) && !exceptions.never.contains(&key));
                    assert_eq!(groups[i].allow(groups[j]), rule, "seed {seed}: {i} {j}");
                }
            }
        }
    }

    #[test]
    fn more_than_32_kinds_touch_at_least_what_they_should() {
        // Kind i touches kind i only: 40 classes do not fit into 32 bits.
        let pieces: Vec<Piece> = (0..40).map(|i| piece(i, 0, 0, 3, 1.0)).collect();
        let mut exceptions = Exceptions::default();
        for i in 0..40 {
            exceptions.always.insert((i, (i + 1) % 40));
        }
        exceptions.always = exceptions.always.iter().map(|&(a, b)| (a.min(b), a.max(b))).collect();
        let refs: Vec<&Piece> = pieces.iter().collect();
        let (groups, exact) = groups(&refs, &exceptions);
        assert!(!exact);
        for &(a, b) in &exceptions.always {
            assert!(groups[a].allow(groups[b]), "{a} {b}");
        }
    }

    #[test]
    fn condim_1_is_frictionless_against_itself_and_takes_the_floor_s() {
        // Hopper: body (0.9, condim 1), foot (2.0, condim 1), floor (1.0, condim 3).
        let pieces = [piece(0, 1, 1, 1, 0.9), piece(1, 1, 1, 1, 2.0), piece(2, 1, 1, 3, 1.0)];
        let refs: Vec<&Piece> = pieces.iter().collect();
        let (m, warning) = materials(&refs);
        assert_eq!(warning, None);
        assert_eq!(mixed(&m[0], &m[1])[0], 0.0);
        assert_eq!(mixed(&m[0], &m[2])[0], 1.0);
        assert_eq!(mixed(&m[1], &m[2])[0], 2.0);
    }

    #[test]
    fn two_feet_rougher_than_the_floor_are_told() {
        let pieces = [piece(0, 1, 1, 1, 1.9), piece(1, 1, 1, 1, 1.9), piece(2, 1, 1, 3, 0.7)];
        let refs: Vec<&Piece> = pieces.iter().collect();
        assert!(materials(&refs).1.is_some());
    }
}
