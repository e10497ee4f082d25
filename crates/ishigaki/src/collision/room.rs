//! Room for new entries in long sorted lists.
//!
//! Entries that are gone stay where they are for some steps: a heap of thousands of bodies loses some pairs and contacts in
//! each step and gains as many, and to move all that lie behind takes longer than to find their points. New ones take the
//! place of what is gone nearby.

/// One in so many entries may be gone before all of these leave a list.
const GONE: usize = 16;
/// So many new ones among as many old ones are a burst: the list is gone through as a whole.
const BURST: usize = 64;
/// Room is looked for up to so many places away.
const NEAR: usize = 1024;

/// Whether a list should be rid of what is gone.
pub(crate) fn is_full_of_gone(gone: usize, len: usize) -> bool {
    GONE * gone > len
}

/// Whether so many are put in one by one.
pub(crate) fn are_few(new: usize, len: usize) -> bool {
    BURST * new < len
}

/// Entries that move by one place, toward an entry that is gone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Room {
    gone: usize,
    place: usize,
}

impl Room {
    /// For an entry before the one at `place`, where something is gone nearby.
    pub fn near(place: usize, len: usize, is_gone: impl Fn(usize) -> bool) -> Option<Self> {
        // Whichever is nearer: outward from the place.
        let mut before = (place.saturating_sub(NEAR)..place).rev();
        let mut after = place..len.min(place + NEAR);
        loop {
            let (left, right) = (before.next(), after.next());
            if left.is_none() && right.is_none() {
                return None;
            }
            if let Some(gone) = right.filter(|&at| is_gone(at)).or(left.filter(|&at| is_gone(at))) {
                return Some(Self { gone, place });
            }
        }
    }

    /// Makes it; where the entry goes.
    pub fn make<T>(self, list: &mut [T]) -> usize {
        if self.gone < self.place {
            (self.gone + 1..self.place).for_each(|at| list.swap(at - 1, at));
            self.place - 1
        } else {
            (self.place..self.gone).rev().for_each(|at| list.swap(at, at + 1));
            self.place
        }
    }
}
