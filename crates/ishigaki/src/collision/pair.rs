//! What is kept of a pair of shapes whose bounds overlap: little, since most such pairs never touch.
//!
//! Only pairs with contact points have a [`Contact`](crate::collision::manifold::Contact), which is some ten times
//! as large. Both lists are sorted by (shape_a, shape_b), and every contact has its pair.

use crate::collision::manifold::Contact;
use crate::collision::pair_memory::PairMemory;
use serde::{Deserialize, Serialize};

/// A pair of shapes whose fat bounds overlap.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Pair {
    /// Slots of the shapes; `shape_a < shape_b`.
    pub shape_a: u32,
    pub shape_b: u32,
    pub memory: PairMemory,
}

impl Pair {
    /// As the broad phase has just found it.
    pub fn new((shape_a, shape_b): (u32, u32)) -> Self {
        Self { shape_a, shape_b, memory: PairMemory::default() }
    }

    pub fn key(&self) -> (u32, u32) {
        (self.shape_a, self.shape_b)
    }
}

/// Puts the sorted `new` pairs into the sorted `pairs`; none of them is there yet.
pub(crate) fn insert_pairs(pairs: &mut Vec<Pair>, new: &[(u32, u32)]) {
    let mut rest = pairs.len();
    pairs.extend(new.iter().map(|&key| Pair::new(key)));
    // From the back, each pair moves at most once.
    for (i, &key) in new.iter().enumerate().rev() {
        let place = pairs[..rest].partition_point(|pair| pair.key() < key);
        pairs.copy_within(place..rest, place + i + 1);
        pairs[place + i] = Pair::new(key);
        rest = place;
    }
}

/// Takes the pairs with these indices out, which come in their order.
pub(crate) fn remove_pairs(pairs: &mut Vec<Pair>, gone: impl Iterator<Item = usize>) {
    // Up to the first of them all stay where they are.
    let (mut kept, mut next) = (0, 0);
    for index in gone {
        if kept < next {
            pairs.copy_within(next..index, kept);
        }
        (kept, next) = (kept + index - next, index + 1);
    }
    if kept < next {
        pairs.copy_within(next.., kept);
        pairs.truncate(kept + pairs.len() - next);
    }
}

/// Puts the sorted `new` contacts into the sorted `contacts`, and empties `new`.
pub(crate) fn insert_contacts(contacts: &mut Vec<Contact>, new: &mut Vec<Contact>) {
    let mut rest = contacts.len();
    if contacts.last().zip(new.first()).is_none_or(|(last, first)| last.key() < first.key()) {
        append(contacts, new);
        return;
    }
    // Contacts are large: as above they move at most once, changing places with the new ones at the end.
    contacts.extend((0..new.len()).map(|_| Contact::new((0, 0), (0, 0), false)));
    while let Some(contact) = new.pop() {
        let key = contact.key();
        while rest > 0 && contacts[rest - 1].key() > key {
            contacts.swap(rest + new.len(), rest - 1);
            rest -= 1;
        }
        let place = rest + new.len();
        contacts[place] = contact;
    }
}

/// Puts `more` at the end of `list`, and leaves it empty; without a second copy where there is nothing before it.
pub(crate) fn append<T>(list: &mut Vec<T>, more: &mut Vec<T>) {
    if list.is_empty() {
        std::mem::swap(list, more);
    } else {
        list.append(more);
    }
}

/// Empties a list that is long in few steps only, and keeps no more room than most steps need.
pub(crate) fn clear_burst<T>(list: &mut Vec<T>) {
    /// A list with room for more items gives it back.
    const USUAL: usize = 1024;
    if list.capacity() > USUAL {
        *list = Vec::new();
    }
    list.clear();
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with_axis(axis: u32) -> PairMemory {
        let mut memory = PairMemory::default();
        memory.axis = axis;
        memory
    }

    /// All ways to deal six keys to two lists.
    #[test]
    fn lists_are_merged_in_order() {
        let keys: Vec<(u32, u32)> = (0..6).map(|i| (i / 3, 3 + i)).collect();
        for dealt in 0..64_u32 {
            let (new, old): (Vec<_>, Vec<_>) = keys.iter().partition(|key| dealt >> (key.1 - 3) & 1 == 1);
            let memory = with_axis(7);
            let mut pairs: Vec<Pair> = old.iter().map(|&key: &(u32, u32)| Pair { memory, ..Pair::new(key) }).collect();
            insert_pairs(&mut pairs, &new);
            assert!(pairs.iter().map(Pair::key).eq(keys.iter().copied()), "{dealt}");
            assert!(pairs.iter().all(|p| (p.memory.axis == 7) == old.contains(&p.key())));
            let mut gone = new.iter().map(|key| keys.iter().position(|k| k == key).unwrap());
            remove_pairs(&mut pairs, &mut gone);
            assert!(pairs.iter().map(Pair::key).eq(old.iter().copied()), "{dealt}");
            let make = |keys: &[(u32, u32)]| keys.iter().map(|&key| Contact::new(key, key, false)).collect::<Vec<_>>();
            let (mut contacts, mut fresh) = (make(&old), make(&new));
            insert_contacts(&mut contacts, &mut fresh);
            assert!(contacts.iter().map(Contact::key).eq(keys.iter().copied()) && fresh.is_empty(), "{dealt}");
            assert!(contacts.iter().all(|c| (c.body_a, c.body_b) == c.key()));
        }
    }
}
