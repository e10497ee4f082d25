//! Permutation. TALK D3.
//!
//! Rows mirror the order in which things were stacked, and what a sweep does first the later rows undo in the
//! same way each time: errors pile up. A random order in each sweep, or going forwards and backwards in turn,
//! spreads them: a stack of 10 boxes needs > 3000 sweeps in fixed order, about 300 in either of these.
//! Option: `solver.permutation`; shown by `tests/techniques.rs`.

use crate::options::Permutation;
use serde::{Deserialize, Serialize};

/// A small seeded generator: splitmix64 (Steele, Lea, Flood 2014).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Random(pub u64);

impl Random {
    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number below `n` > 0.
    pub fn below(&mut self, n: u32) -> u32 {
        ((u128::from(self.bits()) * u128::from(n)) >> 64) as u32
    }
}

// ANCHOR: before_sweep
/// Puts the units into the order of the next sweep.
pub fn before_sweep<T>(permutation: Permutation, sweep: u32, random: &mut Random, units: &mut [T]) {
    match permutation {
        Permutation::None => {}
        Permutation::PerStep if sweep > 0 => {}
        Permutation::PerStep | Permutation::PerSweep => shuffle(random, units),
        Permutation::Alternating if sweep > 0 => units.reverse(),
        Permutation::Alternating => {}
    }
}
// ANCHOR_END: before_sweep

/// Fisher–Yates.
fn shuffle<T>(random: &mut Random, units: &mut [T]) {
    for i in (1..units.len()).rev() {
        units.swap(i, random.below(i as u32 + 1) as usize);
    }
}
