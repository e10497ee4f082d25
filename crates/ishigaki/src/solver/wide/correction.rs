//! Level correction for islands of a batch: their rows as the reference has them, corrected there, and brought back.
//!
//! Islands at rest never come here. The rows are made once in a step, at the first correction.

use crate::constraint::contact::{self, Layout, Surface};
use crate::solver::manifold_block::ManifoldBlock;
use crate::solver::plan::{ManifoldRows, Plan};
use crate::solver::table::{Row, SolverBody, couple_disks};
use crate::solver::wide::batch::Batch;
use crate::solver::wide::contact_block::{ContactBlock, SweepPass};
use crate::world::World;

impl World {
    /// Corrects the loads of the wanted islands (by their index in the batch).
    pub(crate) fn correct_loads(&self, batch: &mut Batch, aid: &mut Plan, wanted: &[bool], pass: &SweepPass) {
        if aid.manifolds.is_empty() || aid.rows_of != wanted {
            self.make_rows(batch, aid, wanted);
        }
        for place in batch.places.iter().filter(|p| wanted[p.island as usize]) {
            for body in place.bodies.into_iter().filter(|&b| b != 0) {
                let (v, w) = batch.movers.velocities(body, &batch.velocities[body as usize]);
                let body = &mut aid.bodies[batch.movers.rank(body) as usize];
                (body.velocity, body.angular_velocity) = (v, w);
                (body.forced_velocity, body.forced_spin) = (v, w);
            }
        }
        let chosen = batch.places.iter().filter(|p| wanted[p.island as usize]);
        for (place, m) in chosen.zip(&aid.manifolds) {
            copy_in(&batch.blocks[place.block()], place.lane(), m, &mut aid.rows);
        }
        self.correct_levels(aid, pass.h);
        let chosen = batch.places.iter().filter(|p| wanted[p.island as usize]);
        for (place, m) in chosen.zip(&aid.manifolds) {
            copy_out(&mut batch.blocks[place.block()], place.lane(), m, &aid.rows);
        }
        self.bring_back(batch, aid, wanted);
    }

    fn make_rows(&self, batch: &Batch, aid: &mut Plan, wanted: &[bool]) {
        aid.rows_of.clear();
        aid.rows_of.extend_from_slice(wanted);
        aid.rows.clear();
        aid.manifolds.clear();
        aid.manifold_blocks.clear();
        aid.blocks.clear();
        aid.bodies.clear();
        aid.bodies.resize(batch.movers.records(), SolverBody::GROUND);
        for (record, slot) in batch.movers.bodies() {
            let (body, state) = (&mut aid.bodies[batch.movers.rank(record) as usize], self.bodies.at(slot));
            body.inverse_mass = state.inverse_mass_by_axis();
            body.inverse_inertia = state.inverse_inertia_world();
            body.inertia = state.inertia_world();
            body.height = state.height;
        }
        let model = self.options.solver.friction;
        for place in batch.places.iter().filter(|p| wanted[p.island as usize]) {
            let contact = &self.contacts[place.contact as usize];
            let manifold = &contact.manifolds[place.manifold as usize];
            let surface = Surface { friction: contact.friction, ..Surface::default() };
            let first = aid.rows.len();
            let ranks = place.bodies.map(|body| batch.movers.rank(body));
            contact::rows(manifold, &surface, model, first as u32, |spec| {
                let mut row = Row::of_contact(&spec, ranks[0], ranks[1]);
                row.refresh_mass(&aid.bodies);
                aid.rows.push(row);
            });
            couple_disks(&mut aid.rows[first..]);
            let m = ManifoldRows {
                contact: place.contact,
                manifold: place.manifold,
                first: first as u32,
                layout: Layout::new(manifold.points.len(), &surface, model),
                surface,
                restitution: 0.0,
            };
            let mut block = ManifoldBlock::new(&m);
            block.refresh(&aid.rows);
            aid.manifold_blocks.push(block);
            aid.manifolds.push(m);
        }
    }

    /// The change of each body's velocity, once.
    fn bring_back(&self, batch: &mut Batch, aid: &mut Plan, wanted: &[bool]) {
        for p in 0..batch.places.len() {
            let place = batch.places[p];
            if !wanted[place.island as usize] {
                continue;
            }
            for body in place.bodies.map(|b| b as usize).into_iter().filter(|&b| b != 0) {
                let now = &mut aid.bodies[batch.movers.rank(body as u32) as usize];
                let change = (now.velocity - now.forced_velocity, now.angular_velocity - now.forced_spin);
                (now.forced_velocity, now.forced_spin) = (now.velocity, now.angular_velocity);
                let weighted = batch.movers.weighted(body as u32, change.0, change.1);
                for (sum, part) in batch.velocities[body].0.iter_mut().zip(weighted.0) {
                    *sum += part;
                }
            }
        }
    }
}

fn copy_in(block: &ContactBlock, lane: usize, m: &ManifoldRows, rows: &mut [Row]) {
    let rows = &mut rows[m.first as usize..(m.first + m.layout.total()) as usize];
    let normal = m.layout.first_normal() as usize;
    for i in 0..m.layout.normals as usize {
        let (p, disk) = (&block.points[i], &block.disks[i]);
        rows[normal + i].lambda = p.lambda[lane];
        rows[normal + i].bias = p.bias[lane];
        if m.layout.tangents > 0 {
            rows[2 * i].lambda = disk.lambda[0][lane];
            rows[2 * i + 1].lambda = disk.lambda[1][lane];
        }
    }
}

fn copy_out(block: &mut ContactBlock, lane: usize, m: &ManifoldRows, rows: &[Row]) {
    let rows = &rows[m.first as usize..(m.first + m.layout.total()) as usize];
    let normal = m.layout.first_normal() as usize;
    for i in 0..m.layout.normals as usize {
        let (p, disk) = (&mut block.points[i], &mut block.disks[i]);
        p.lambda[lane] = rows[normal + i].lambda;
        if m.layout.tangents > 0 {
            disk.lambda[0][lane] = rows[2 * i].lambda;
            disk.lambda[1][lane] = rows[2 * i + 1].lambda;
        }
    }
}
