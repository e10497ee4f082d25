//! What is kept of a pair of shapes whose bounds overlap: little, since most such pairs never touch.
//!
//! Only pairs with contact points have a [`Contact`](crate::collision::manifold::Contact), which is some ten times
//! as large. Both lists are sorted by (shape_a, shape_b), and every contact with points has its pair.

use crate::collision::pair_memory::PairMemory;
use crate::collision::room::{self, Room};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

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

    /// Its bounds came apart: it only makes room.
    pub fn is_gone(&self) -> bool {
        self.memory.gone
    }
}

/// Pairs in the order of their keys; some of them are gone.
#[derive(Clone, Debug, Default)]
pub(crate) struct PairList {
    pub all: Vec<Pair>,
    /// How many of them only make room.
    gone: usize,
}

impl PairList {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.all.len() - self.gone
    }

    /// Those that are there.
    pub fn iter(&self) -> impl Iterator<Item = &Pair> {
        self.all.iter().filter(|pair| !pair.is_gone())
    }

    /// Whether this one is there.
    pub fn contains(&self, key: (u32, u32)) -> bool {
        self.all.binary_search_by_key(&key, Pair::key).is_ok_and(|at| !self.all[at].is_gone())
    }

    /// Only those that are chosen stay.
    pub fn retain(&mut self, is_chosen: &mut dyn FnMut(&Pair) -> bool) {
        self.all.retain(|pair| !pair.is_gone() && is_chosen(pair));
        self.gone = 0;
    }

    /// Takes these out, which are there.
    pub fn remove(&mut self, indices: impl Iterator<Item = usize>) {
        for index in indices {
            self.all[index].memory.gone = true;
            self.gone += 1;
        }
    }

    /// Puts new ones in, which are sorted; none of them is there yet.
    pub fn insert(&mut self, new: &[(u32, u32)]) {
        if room::is_full_of_gone(self.gone, self.all.len()) {
            self.retain(&mut |_| true);
        }
        if self.gone == 0 {
            return self.merge(new);
        }
        let are_few = room::are_few(new.len(), self.all.len());
        let far: Vec<_> = new.iter().copied().filter(|&key| !self.put_near(key, are_few)).collect();
        self.merge(&far);
    }

    /// Puts one where it was, or, if they are few, where something nearby is gone; whether it is there now.
    fn put_near(&mut self, key: (u32, u32), are_few: bool) -> bool {
        let Self { all, gone } = self;
        let place = all.partition_point(|pair| pair.key() < key);
        let room = || Room::near(place, all.len(), |at| all[at].is_gone());
        let place = if let Some(pair) = all.get(place).filter(|pair| pair.key() == key) {
            if !pair.is_gone() {
                return true;
            }
            place
        } else if let Some(room) = are_few.then(room).flatten() {
            room.make(all)
        } else {
            return false;
        };
        all[place] = Pair::new(key);
        *gone -= 1;
        true
    }

    fn merge(&mut self, new: &[(u32, u32)]) {
        let all = &mut self.all;
        let mut rest = all.len();
        all.extend(new.iter().map(|&key| Pair::new(key)));
        // From the back, each pair moves at most once.
        for (i, &key) in new.iter().enumerate().rev() {
            let place = all[..rest].partition_point(|pair| pair.key() < key);
            all.copy_within(place..rest, place + i + 1);
            all[place + i] = Pair::new(key);
            rest = place;
        }
    }
}

impl Serialize for PairList {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.iter().copied().collect::<Vec<_>>().serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for PairList {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(Self { all: Vec::deserialize(deserializer)?, gone: 0 })
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

    /// All ways in which six pairs may be new, old, gone or nowhere, among few and among many others.
    #[test]
    fn pairs_stay_in_order() {
        for dealt in 0..4_u32.pow(6) {
            let digit = |i: u32| dealt / 4_u32.pow(i) % 4;
            let key = |i: u32| (i / 3, 3 + i);
            let keys = |kind: u32| (0..6).filter(move |&i| digit(i) == kind).map(key);
            let others = (6..if dealt % 2 == 0 { 8 } else { 600 }).map(key);
            let memory = with_axis(7);
            let mut list = PairList::default();
            list.insert(&(0..6).filter(|&i| digit(i) > 1).map(key).chain(others.clone()).collect::<Vec<_>>());
            list.all.iter_mut().for_each(|pair| pair.memory = memory);
            let gone: Vec<_> = list.all.iter().enumerate().filter(|(_, p)| keys(2).any(|k| k == p.key())).collect();
            let gone: Vec<usize> = gone.into_iter().map(|(index, _)| index).collect();
            list.remove(gone.into_iter());
            assert!(keys(2).all(|key| !list.contains(key)) && keys(3).all(|key| list.contains(key)));
            // One of those that are gone comes back.
            let mut new: Vec<_> = keys(1).chain(keys(2).take(1)).collect();
            new.sort_unstable();
            list.insert(&new);
            let mut there: Vec<_> = keys(3).chain(new.iter().copied()).chain(others).collect();
            there.sort_unstable();
            assert!(list.iter().map(Pair::key).eq(there.iter().copied()), "{dealt}");
            assert_eq!(list.len(), there.len(), "{dealt}");
            assert!(list.all.is_sorted_by_key(Pair::key), "{dealt}");
            assert!(list.iter().all(|p| (p.memory.axis == 7) != new.contains(&p.key())), "{dealt}");
        }
    }
}
