//! What stages ask of a joint beside its rows, close together in memory: joints themselves are thirty times as large.
//!
//! Made when the first step after a change of joints asks for them, in the order of slots.

use crate::body::BodyState;
use crate::handle::Arena;
use crate::solver::wide::joints;
use crate::world::JointState;

/// A joint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointLink {
    /// Its slot.
    pub joint: u32,
    /// Slots of its bodies.
    pub bodies: [u32; 2],
    /// The wide path has rows for it.
    pub fits: bool,
    /// What it has beside them, as [`Parts::kind`](crate::solver::wide::joint_block::Parts::kind) says it.
    pub kind: u8,
    /// No joint before it joins the same two, whatever does not move being one.
    pub is_first: bool,
    /// It may break.
    pub breaks: bool,
}

/// Links of all joints.
pub(crate) fn collect(joints: &Arena<JointState>, bodies: &Arena<BodyState>, links: &mut Vec<JointLink>) {
    links.clear();
    links.extend(joints.iter().map(|(slot, joint)| {
        let definition = &joint.definition;
        JointLink {
            joint: slot,
            bodies: [definition.body_a.index, definition.body_b.index],
            fits: joints::fits(definition),
            kind: joints::kind(definition),
            is_first: false,
            breaks: definition.break_force.is_some() || definition.break_torque.is_some(),
        }
    }));
    let ground = bodies.slot_count() as u32;
    let pair = |link: &JointLink| {
        let [a, b] = link.bodies.map(|slot| if bodies.at(slot).is_dynamic() { slot } else { ground });
        (a.min(b), a.max(b))
    };
    let mut pairs: Vec<_> = links.iter().enumerate().map(|(index, link)| (pair(link), index)).collect();
    pairs.sort_unstable();
    pairs.dedup_by_key(|(pair, _)| *pair);
    for (_, index) in pairs {
        links[index].is_first = true;
    }
}
