//! Handles with generations and the arena they index.
//!
//! A handle stays valid until its object is removed; a stale one finds nothing, even when the slot has
//! been used again. Iteration is by slot index: an order that depends only on the history of calls.

use crate::error::{Error, Result};
use crate::threads::Cut;
use serde::{Deserialize, Serialize};

macro_rules! handle {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        pub struct $name {
            pub(crate) index: u32,
            pub(crate) generation: u32,
        }

        impl $name {
            /// The slot: small, dense, reused after removal. Good for side tables.
            pub fn index(self) -> usize {
                self.index as usize
            }

            /// How often the slot had been used before this object.
            pub fn generation(self) -> u32 {
                self.generation
            }
        }

        impl From<(u32, u32)> for $name {
            fn from((index, generation): (u32, u32)) -> Self {
                Self { index, generation }
            }
        }

        impl From<$name> for (u32, u32) {
            fn from(handle: $name) -> Self {
                (handle.index, handle.generation)
            }
        }
    };
}

handle!(
    /// Names a body of a [`World`](crate::World).
    BodyHandle
);
handle!(
    /// Names a joint of a [`World`](crate::World).
    JointHandle
);

/// Slots with generations; freed slots are reused, the last freed first.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Arena<T> {
    slots: Vec<Slot<T>>,
    free: Vec<u32>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct Slot<T> {
    generation: u32,
    value: Option<T>,
}

impl<T> Default for Arena<T> {
    fn default() -> Self {
        Self { slots: Vec::new(), free: Vec::new() }
    }
}

impl<T> Arena<T> {
    pub fn insert(&mut self, value: T) -> (u32, u32) {
        if let Some(index) = self.free.pop() {
            let slot = &mut self.slots[index as usize];
            slot.value = Some(value);
            (index, slot.generation)
        } else {
            self.slots.push(Slot { generation: 0, value: Some(value) });
            (self.slots.len() as u32 - 1, 0)
        }
    }

    pub fn remove(&mut self, (index, generation): (u32, u32)) -> Option<T> {
        let slot = self.slots.get_mut(index as usize)?;
        if slot.generation != generation {
            return None;
        }
        let value = slot.value.take()?;
        slot.generation = slot.generation.wrapping_add(1);
        self.free.push(index);
        Some(value)
    }

    pub fn get(&self, (index, generation): (u32, u32)) -> Option<&T> {
        let slot = self.slots.get(index as usize)?;
        if slot.generation == generation { slot.value.as_ref() } else { None }
    }

    pub fn get_mut(&mut self, (index, generation): (u32, u32)) -> Option<&mut T> {
        let slot = self.slots.get_mut(index as usize)?;
        if slot.generation == generation { slot.value.as_mut() } else { None }
    }

    /// The object in a slot known to be in use.
    #[track_caller]
    pub fn at(&self, index: u32) -> &T {
        self.slots[index as usize].value.as_ref().expect("slot in use")
    }

    /// The object in a slot known to be in use.
    #[track_caller]
    pub fn at_mut(&mut self, index: u32) -> &mut T {
        self.slots[index as usize].value.as_mut().expect("slot in use")
    }

    pub fn generation_at(&self, index: u32) -> u32 {
        self.slots[index as usize].generation
    }

    /// Objects in slot order.
    pub fn iter(&self) -> impl Iterator<Item = (u32, &T)> {
        self.slots.iter().enumerate().filter_map(|(i, s)| s.value.as_ref().map(|v| (i as u32, v)))
    }

    /// Objects in slots that are chosen: the others are not looked at.
    pub fn iter_where(&self, is_chosen: impl Fn(u32) -> bool) -> impl Iterator<Item = (u32, &T)> {
        let chosen = (0..).zip(&self.slots).filter(move |&(index, _)| is_chosen(index));
        chosen.filter_map(|(index, slot)| slot.value.as_ref().map(|value| (index, value)))
    }

    /// Objects in slot order.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = (u32, &mut T)> {
        self.slots.iter_mut().enumerate().filter_map(|(i, s)| s.value.as_mut().map(|v| (i as u32, v)))
    }

    /// All slots, to be cut in parts.
    pub fn all(&mut self) -> Slots<'_, T> {
        Slots { first: 0, slots: &mut self.slots }
    }

    /// The object in a slot, if there is such a slot and it is in use.
    pub fn in_use(&self, index: u32) -> Option<&T> {
        self.slots.get(index as usize)?.value.as_ref()
    }

    /// Checks that the list of free slots names exactly the empty ones.
    pub fn validate(&self) -> Result<()> {
        let mut free = self.free.clone();
        free.sort_unstable();
        let empty = self.slots.iter().enumerate().filter(|(_, slot)| slot.value.is_none()).map(|(i, _)| i as u32);
        if empty.eq(free) { Ok(()) } else { Err(Error::invalid("free", "does not name exactly the empty slots")) }
    }

    /// How many objects there are.
    pub fn len(&self) -> usize {
        self.slots.len() - self.free.len()
    }

    /// How many slots there are, free ones included: every index is below it.
    pub fn slot_count(&self) -> usize {
        self.slots.len()
    }
}

/// Neighboring slots of an arena.
pub(crate) struct Slots<'a, T> {
    first: u32,
    slots: &'a mut [Slot<T>],
}

impl<T: Send> Cut for Slots<'_, T> {
    fn cut(self, part: usize, of: usize) -> (Self, Self) {
        let middle = self.slots.len() * part / of;
        let (slots, others) = self.slots.split_at_mut(middle);
        (Self { first: self.first, slots }, Self { first: self.first + middle as u32, slots: others })
    }
}

impl<'a, T> Slots<'a, T> {
    /// The objects and their slots.
    pub fn objects(self) -> impl Iterator<Item = (u32, &'a mut T)> {
        self.objects_where(|_| true)
    }

    /// Which slots these are.
    pub fn range(&self) -> std::ops::Range<u32> {
        self.first..self.first + self.slots.len() as u32
    }

    /// The object in a slot among these, known to be in use.
    #[track_caller]
    pub fn at_mut(&mut self, index: u32) -> &mut T {
        self.slots[(index - self.first) as usize].value.as_mut().expect("slot in use")
    }

    /// Those for which what lies at the same place of another list is chosen, with it.
    pub fn objects_with<R>(
        self,
        others: &'a mut [R],
        is_chosen: impl Fn(&R) -> bool,
    ) -> impl Iterator<Item = (&'a mut T, &'a mut R)> {
        let chosen = self.slots.iter_mut().zip(others).filter(move |(_, other)| is_chosen(other));
        chosen.filter_map(|(slot, other)| slot.value.as_mut().map(|value| (value, other)))
    }

    /// Those in slots that are chosen: the others are not looked at.
    pub fn objects_where(self, is_chosen: impl Fn(u32) -> bool) -> impl Iterator<Item = (u32, &'a mut T)> {
        let chosen = (self.first..).zip(self.slots).filter(move |&(index, _)| is_chosen(index));
        chosen.filter_map(|(index, slot)| slot.value.as_mut().map(|value| (index, value)))
    }
}
