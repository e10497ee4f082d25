//! Batches back into the world; contacts are measured on the way.

use crate::collision::link::Link;
use crate::collision::manifold::{Contact, Manifold};
use crate::collision::update::Touch;
use crate::solver::wide::Wide;
use crate::solver::wide::batch::{Batch, Place};
use crate::step::JointErrors;
use crate::world::World;

/// What a part of the contacts shows at the end of a step.
#[derive(Clone, Debug, Default)]
pub(crate) struct ContactSums {
    /// Contacts with points, sensors aside.
    pub contacts: usize,
    /// Greatest overlap, m.
    pub max_penetration: f32,
    /// What bounced within the step touched, though a gap was there before and after it.
    pub impacts: Vec<Touch>,
}

impl World {
    /// Takes over what the batches found, and sums up all contacts.
    pub(crate) fn store_batches(&mut self, wide: &mut Wide, dt: f32) {
        let full = self.options.solver.substeps as f32;
        for batch in &wide.batches[..wide.used] {
            self.report.work += batch.outcome.work;
            self.report.residual = self.report.residual.max(batch.outcome.residual);
            for &(body, steps) in &batch.outcome.pauses {
                self.bodies.at_mut(body).no_correction_until = self.step_count + steps;
            }
        }
        self.store_joints(wide, dt);
        let batches = &wide.batches[..wide.used];
        if wide.used > 0 {
            let mut no_outputs = self.workers.no_outputs(self.bodies.slot_count());
            self.workers.in_parts(self.bodies.all(), &mut no_outputs, |bodies, ()| {
                let batch_of = |slot: u32| batches.get(wide.batch_of[slot as usize] as usize);
                for (slot, body) in bodies.objects_where(|slot| batch_of(slot).is_some()) {
                    if let Some(batch) = batch_of(slot) {
                        batch.movers.store(wide.index_of[slot as usize], body);
                    }
                }
            });
        }
        let mut sums = std::mem::take(&mut self.scratch.contact_sums);
        sums.clear();
        sums.resize_with(self.workers.parts(self.contacts.len()), ContactSums::default);
        let whole = (&mut self.contacts[..], &self.scratch.links[..]);
        self.workers.in_parts(whole, &mut sums, |(contacts, links), sums| {
            for (contact, link) in contacts.iter_mut().zip(links) {
                if let Some(batch) = batches.get(link.batch as usize) {
                    store_contact(batch, link.place as usize, contact, full);
                }
                sums.add(contact, link);
            }
        });
        self.scratch.contact_sums = sums;
    }

    /// Impulses, forces and errors of joints.
    fn store_joints(&mut self, wide: &Wide, dt: f32) {
        let batches = &wide.batches[..wide.used];
        if batches.iter().all(|batch| batch.joints.is_empty()) {
            return;
        }
        let mut sums = std::mem::take(&mut self.scratch.joint_sums);
        sums.clear();
        sums.resize(self.workers.parts(self.joints.slot_count()), JointErrors::default());
        self.workers.in_parts(self.joints.all(), &mut sums, |mut joints, errors| {
            for batch in batches {
                for place in batch.joints.places_in(joints.range()) {
                    let joint = joints.at_mut(place.joint);
                    batch.joints.store(place, joint, dt);
                    errors.add(joint.anchor_error);
                }
            }
        });
        sums.iter().for_each(|&errors| self.scratch.joint_errors += errors);
        self.scratch.joint_sums = sums;
    }
}

impl ContactSums {
    fn add(&mut self, contact: &mut Contact, link: &Link) {
        if !link.meets() {
            return;
        }
        self.contacts += 1;
        if link.sleeps {
            self.max_penetration = self.max_penetration.max(link.depth());
            return;
        }
        let mut is_hit = false;
        for point in contact.manifolds.iter().flat_map(|m| &m.points) {
            self.max_penetration = self.max_penetration.max(-point.separation);
            is_hit |= point.impulse > 0.0;
        }
        if is_hit && !contact.touching {
            self.impacts.push(Touch::change(contact, true));
        }
    }
}

/// Impulses and separations of a contact whose first manifold has this place in its batch.
fn store_contact(batch: &Batch, first: usize, contact: &mut Contact, full_substeps: f32) {
    // Stored impulses are those of a substep as the options have it.
    let share = batch.substeps as f32 / full_substeps;
    for (manifold, place) in contact.manifolds.iter_mut().zip(&batch.places[first..]) {
        store_manifold(batch, place, manifold, share);
    }
}

fn store_manifold(batch: &Batch, place: &Place, manifold: &mut Manifold, share: f32) {
    let (block, lane) = (&batch.blocks[place.block()], place.lane());
    for (i, point) in manifold.points.iter_mut().enumerate() {
        let (p, disk) = (&block.points[i], &block.disks[i]);
        point.lambda_normal = share * p.lambda[lane];
        point.lambda_friction = [share * disk.lambda[0][lane], share * disk.lambda[1][lane]];
        point.impulse = p.total[lane];
        point.separation = p.separation[lane];
    }
    (manifold.lambda_torsion, manifold.lambda_rolling) = (0.0, [0.0; 2]);
}
