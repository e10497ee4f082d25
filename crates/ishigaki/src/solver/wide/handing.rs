//! Hand-down for an island of a batch.

use crate::math::Vec3;
use crate::solver::hand_down::{HandDown, Search, Support, Wrench};
use crate::solver::wide::batch::{Batch, Place};
use crate::world::World;

impl World {
    /// Hands down the momentum of one island; the energy of the residual that it took away, J.
    pub(crate) fn hand_down(&self, batch: &mut Batch, work: &mut HandDown, island: u32) -> f32 {
        work.clear(batch.movers.records());
        for p in 0..batch.places.len() {
            let place = batch.places[p];
            if place.island == island {
                work.supports.extend(self.support(batch, p as u32, &place));
            }
        }
        for support in &work.supports {
            for body in [support.upper, support.lower].map(|b| b as usize).into_iter().filter(|&b| b != 0) {
                let (p, l) = batch.movers.impetus(body as u32, &batch.velocities[body]);
                work.needs[body] = Wrench { linear: -p, angular: -l };
            }
        }
        batch.outcome.work += work.solve();
        let (alpha, gain) = search(batch, work).step();
        if gain > 0.0 {
            take(batch, work, alpha);
        }
        gain
    }

    fn support(&self, batch: &Batch, name: u32, place: &Place) -> Option<Support> {
        let contact = &self.contacts[place.contact as usize];
        let heights = [contact.body_a, contact.body_b].map(|slot| self.bodies.at(slot).height);
        let manifold = &contact.manifolds[place.manifold as usize];
        let (block, lane) = (&batch.blocks[place.block as usize], place.lane as usize);
        let mut support = Support::new(name, manifold, place.bodies, heights, block.friction[lane])?;
        let [(v_a, w_a), (v_b, w_b)] = place.bodies.map(|b| velocities(batch, b));
        for (i, (point, at)) in support.points.iter_mut().zip(&manifold.points).enumerate() {
            let (p, disk) = (&block.points[i], &block.disks[i]);
            let approach = manifold.normal.dot(v_a + w_a.cross(at.arm_a) - v_b - w_b.cross(at.arm_b));
            point.lambda = Vec3::new(p.lambda[lane], disk.lambda[0][lane], disk.lambda[1][lane]);
            point.is_active = p.lambda[lane] > 0.0 || approach + p.bias[lane] <= 0.0;
        }
        Some(support)
    }
}

fn velocities(batch: &Batch, body: u32) -> (Vec3, Vec3) {
    if body == 0 {
        return (Vec3::ZERO, Vec3::ZERO);
    }
    batch.movers.velocities(body, &batch.velocities[body as usize])
}

/// Along the changes: ½u'² + biasᵀλ.
fn search(batch: &Batch, work: &HandDown) -> Search {
    let mut search = Search::default();
    for body in 1..=batch.movers.slots.len() {
        let (push, velocity) = (&work.pushes[body], &batch.velocities[body]);
        let change = batch.movers.pushed(body as u32, push.linear, push.angular);
        for (u, d) in velocity.0.iter().zip(change.0) {
            search.slope += f64::from(u * d);
            search.curvature += f64::from(d * d);
        }
    }
    for support in &work.supports {
        let place = &batch.places[support.name as usize];
        let block = &batch.blocks[place.block as usize];
        for (point, lanes) in support.points[..support.count as usize].iter().zip(&block.points) {
            search.slope += f64::from(lanes.bias[place.lane as usize] * point.change.x);
        }
    }
    search
}

/// λ += αd, u' += αM^−½Jᵀd.
fn take(batch: &mut Batch, work: &HandDown, alpha: f32) {
    for support in &work.supports {
        let place = &batch.places[support.name as usize];
        let (block, lane) = (&mut batch.blocks[place.block as usize], place.lane as usize);
        for (i, point) in support.points[..support.count as usize].iter().enumerate() {
            let (p, disk) = (&mut block.points[i], &mut block.disks[i]);
            p.lambda[lane] += alpha * point.change.x;
            disk.lambda[0][lane] += alpha * point.change.y;
            disk.lambda[1][lane] += alpha * point.change.z;
        }
    }
    for body in 1..=batch.movers.slots.len() {
        let push = &work.pushes[body];
        let change = batch.movers.pushed(body as u32, alpha * push.linear, alpha * push.angular);
        for (sum, part) in batch.velocities[body].0.iter_mut().zip(change.0) {
            *sum += part;
        }
    }
}
