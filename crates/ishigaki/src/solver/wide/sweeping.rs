//! What a thread does to the bodies and blocks that it has in its hands: the passes of a substep.

use crate::solver::wide::contact_block::{self as kernel, Biases, ContactBlock, ScaleLanes, SweepPass, TangentLanes};
use crate::solver::wide::domain::Part;
use crate::solver::wide::lanes::{LANES, Lane, Record, splat, store};
use crate::solver::wide::moving::{self, Motion};
use crate::solver::work;
use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch};
use std::ops::Range;

/// What a sweep does beside its visits.
#[derive(Clone, Copy)]
pub(super) struct Visits {
    pub reversed: bool,
    pub biases: Biases,
    /// λ is what the substep leaves.
    pub add_up: bool,
}

impl Part<'_> {
    /// Forces; what the last substep carried over, if it did.
    pub fn begin(&mut self, level: Level, carries: bool, h: f32) {
        let carried = carries.then_some(&*self.carried);
        let (movers, velocities) = (&mut *self.movers, &mut *self.velocities);
        dispatch!(level, simd => moving::begin_all(simd, movers, carried, velocities, h));
    }

    /// Takes the sweeps over, and moves.
    pub fn advance(&mut self, level: Level, motion: &Motion) {
        let (movers, carried) = (&mut *self.movers, &mut *self.carried);
        let (velocities, ways) = (&mut *self.velocities, &mut *self.displacements);
        dispatch!(level, simd => moving::advance_all(simd, movers, carried, velocities, ways, motion));
    }

    /// Takes the sweeps after the motion over.
    pub fn end(&mut self, level: Level, carries: bool) {
        let (movers, carried) = (&mut *self.movers, carries.then_some(&mut *self.carried));
        let velocities = &*self.velocities;
        dispatch!(level, simd => moving::end_all(simd, movers, carried, velocities));
    }

    /// Rows of the blocks that were filled.
    pub fn prepare(&mut self, level: Level) {
        let (scales, roots) = (self.scales, &*self.roots);
        let (blocks, tangents) = (&mut *self.blocks, &mut *self.tangents);
        dispatch!(level, simd => prepare_all(simd, blocks, tangents, scales, roots));
    }

    /// Inertias of bodies with joints for the rotations as they are.
    pub fn weigh_bodies(&mut self, level: Level) {
        let (movers, roots, old_roots) = (&mut *self.movers, &mut *self.roots, &mut *self.old_roots);
        let (ways, velocities) = (&mut *self.displacements, &mut *self.velocities);
        dispatch!(level, simd => moving::reweigh_all(simd, movers, roots, old_roots, ways, velocities));
    }

    /// Rows of contacts for the inertias as they are; multiply-adds of that.
    pub fn weigh_contacts(&mut self, level: Level) -> u64 {
        let (scales, old, new) = (self.scales, &*self.old_roots, &*self.roots);
        let (blocks, tangents) = (&mut *self.blocks, &mut *self.tangents);
        dispatch!(level, simd => reweigh_all(simd, blocks, tangents, scales, old, new))
    }

    /// u' += J'ᵀλ for some of the blocks.
    pub fn warm_start(&mut self, level: Level, range: Range<usize>) {
        let (scales, blocks, tangents) = (self.scales_of(&range), &self.blocks[range], &*self.tangents);
        let velocities = &mut *self.velocities;
        dispatch!(level, simd => warm_start_all(simd, blocks, tangents, scales, velocities));
    }

    /// A visit to each of some of the blocks.
    pub fn sweep(&mut self, level: Level, pass: &SweepPass, visits: Visits, range: Range<usize>) {
        let (scales, blocks) = (self.scales_of(&range), &mut self.blocks[range]);
        let (velocities, displacements) = (&mut *self.velocities, &*self.displacements);
        let tangents = &*self.tangents;
        dispatch!(level, simd => sweep(simd, blocks, tangents, scales, velocities, displacements, pass, visits));
    }

    pub fn leave(&mut self, level: Level, pass: &SweepPass, biases: Biases) {
        let (blocks, tangents, displacements) = (&mut *self.blocks, &*self.tangents, &*self.displacements);
        dispatch!(level, simd => leave_all(simd, blocks, tangents, displacements, pass, biases));
    }

    /// How far each block is from rest; the greatest change of an impulse that a visit would make.
    pub fn inspect(&mut self, level: Level, pass: &SweepPass, biases: Biases) -> f32 {
        let (blocks, tangents) = (&mut *self.blocks, &*self.tangents);
        let (velocities, unrest) = (&*self.velocities, &mut *self.unrest);
        let mut residual = [0.0; LANES];
        dispatch!(level, simd => inspect_all(simd, blocks, tangents, velocities, pass, biases, unrest, &mut residual));
        residual.into_iter().fold(0.0, f32::max)
    }
}

#[inline(always)]
fn prepare_all<S: Simd>(
    simd: S,
    blocks: &mut [ContactBlock],
    tangents: &mut [TangentLanes],
    scales: &[ScaleLanes],
    roots: &[Record],
) {
    for (k, block) in blocks.iter_mut().enumerate() {
        let tangents = tangents.get_mut(block.tangents as usize);
        kernel::prepare(simd, block, tangents, &scales[k.min(scales.len() - 1)], roots);
    }
}

#[inline(always)]
fn warm_start_all<S: Simd>(
    simd: S,
    blocks: &[ContactBlock],
    tangents: &[TangentLanes],
    scales: &[ScaleLanes],
    velocities: &mut [Record],
) {
    for (k, block) in blocks.iter().enumerate() {
        let tangents = tangents.get(block.tangents as usize);
        kernel::warm_start(simd, block, tangents, &scales[k.min(scales.len() - 1)], velocities);
    }
}

#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "a kernel takes the arrays of a batch")]
fn inspect_all<S: Simd>(
    simd: S,
    blocks: &mut [ContactBlock],
    tangents: &[TangentLanes],
    velocities: &[Record],
    pass: &SweepPass,
    biases: Biases,
    unrest: &mut [Lane],
    residual: &mut Lane,
) {
    let mut greatest = splat(simd, 0.0);
    for (block, unrest) in blocks.iter_mut().zip(unrest) {
        let tangents = tangents.get(block.tangents as usize);
        if biases == Biases::Recover {
            kernel::recover(simd, block, pass);
        }
        let found = kernel::inspect(simd, block, tangents, velocities);
        greatest = found.residual.simd_gt(greatest).select(found.residual, greatest);
        store(found.energy, unrest);
    }
    store(greatest, residual);
}

/// Rows for rotations as they are.
#[inline(always)]
fn reweigh_all<S: Simd>(
    simd: S,
    blocks: &mut [ContactBlock],
    tangents: &mut [TangentLanes],
    scales: &[ScaleLanes],
    old: &[Record],
    new: &[Record],
) -> u64 {
    let mut work = 0;
    for (k, block) in blocks.iter_mut().enumerate() {
        let Some(tangents) = tangents.get_mut(block.tangents as usize) else { continue };
        let turned = block.turned(old);
        if turned != 0 {
            kernel::reweigh(simd, block, tangents, &scales[k.min(scales.len() - 1)], old, new, turned);
            work += u64::from(turned.count_ones()) * work::reweighing(block.size.points() as u64);
        }
    }
    work
}

#[inline(always)]
fn leave_all<S: Simd>(
    simd: S,
    blocks: &mut [ContactBlock],
    tangents: &[TangentLanes],
    displacements: &[Record],
    pass: &SweepPass,
    biases: Biases,
) {
    for block in blocks {
        let separations = kernel::separations(simd, block, tangents.get(block.tangents as usize), displacements);
        kernel::relax(simd, block, &separations, pass, biases == Biases::RelaxLast);
        kernel::leave(simd, block, &separations);
    }
}

/// Each block comes once into the cache for all that a sweep does to it.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "a kernel takes the arrays of a batch")]
fn sweep<S: Simd>(
    simd: S,
    blocks: &mut [ContactBlock],
    tangents: &[TangentLanes],
    scales: &[ScaleLanes],
    velocities: &mut [Record],
    displacements: &[Record],
    pass: &SweepPass,
    visits: Visits,
) {
    let (n, last) = (blocks.len(), scales.len() - 1);
    for i in 0..n {
        let k = if visits.reversed { n - 1 - i } else { i };
        let block = &mut blocks[k];
        let tangents = tangents.get(block.tangents as usize);
        if visits.biases == Biases::Recover {
            kernel::recover(simd, block, pass);
        }
        let has_moved = matches!(visits.biases, Biases::Relax | Biases::RelaxLast);
        // Twice where several sweeps relax; what the last substep leaves nobody asks for.
        let separations = if has_moved || visits.add_up {
            Some(kernel::separations(simd, block, tangents, displacements))
        } else {
            None
        };
        if let Some(separations) = separations.as_ref().filter(|_| has_moved) {
            kernel::relax(simd, block, separations, pass, visits.biases == Biases::RelaxLast);
        }
        kernel::visit(simd, block, tangents, &scales[k.min(last)], velocities, pass);
        if let Some(separations) = separations.as_ref().filter(|_| visits.add_up) {
            kernel::leave(simd, block, separations);
        }
    }
}
