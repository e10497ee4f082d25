//! Hand-down for an island of a batch.

use crate::math::Vec3;
use crate::solver::hand_down::{HandDown, Search, Stand, Support, Wrench};
use crate::solver::wide::batch::Batch;
use crate::world::World;

impl World {
    /// Hands down the momentum of one island; the energy of the residual that it took away, J.
    pub(crate) fn hand_down(&self, batch: &mut Batch, work: &mut HandDown, island: u32) -> f32 {
        work.clear(batch.movers.records());
        work.stands.reserve_exact(batch.islands[island as usize].manifolds as usize);
        for (place, name) in batch.places.iter().zip(0..).filter(|(place, _)| place.island == island) {
            let contact = &self.contacts[place.contact as usize];
            let heights = [contact.body_a, contact.body_b].map(|slot| self.bodies.at(slot).height);
            work.add(name, place.bodies, heights, place.bodies.map(|b| batch.movers.rank(b)));
        }
        for (body, _) in batch.movers.bodies() {
            let (p, l) = batch.movers.impetus(body, &batch.velocities[body as usize]);
            work.needs[body as usize] = Wrench { linear: -p, angular: -l };
        }
        batch.outcome.work += work.solve(&|stand| self.support(batch, stand));
        let (alpha, gain) = search(batch, work).step();
        if gain > 0.0 {
            take(batch, work, alpha);
        }
        gain
    }

    fn support(&self, batch: &Batch, stand: &Stand) -> Support {
        let place = &batch.places[stand.name()];
        let manifold = &self.contacts[place.contact as usize].manifolds[place.manifold as usize];
        let (block, lane) = (&batch.blocks[place.block()], place.lane());
        let mut support = Support::new(manifold, stand.side(), block.friction[lane]);
        let [(v_a, w_a), (v_b, w_b)] = place.bodies.map(|b| velocities(batch, b));
        for (i, (point, at)) in support.points.iter_mut().zip(&manifold.points).enumerate() {
            let (p, disk) = (&block.points[i], &block.disks[i]);
            let approach = manifold.normal.dot(v_a + w_a.cross(at.arm_a) - v_b - w_b.cross(at.arm_b));
            point.lambda = Vec3::new(p.lambda[lane], disk.lambda[0][lane], disk.lambda[1][lane]);
            point.is_active = p.lambda[lane] > 0.0 || approach + p.bias[lane] <= 0.0;
        }
        support
    }
}

fn velocities(batch: &Batch, body: u32) -> (Vec3, Vec3) {
    if body == 0 {
        return (Vec3::ZERO, Vec3::ZERO);
    }
    batch.movers.velocities(body, &batch.velocities[body as usize])
}

/// Along the changes: ½ uᵀM u + biasᵀλ.
fn search(batch: &Batch, work: &HandDown) -> Search {
    let mut search = Search::default();
    for (body, _) in batch.movers.bodies() {
        let (push, velocity) = (&work.pushes[body as usize], &batch.velocities[body as usize]);
        let change = batch.movers.pushed(body, push.linear, push.angular);
        let (force, [linear, turn]) = (push.linear.to_array(), [&change.0[..3], &change.0[4..]]);
        for ((u, d), force) in velocity.0.iter().zip(linear).zip(force) {
            search.slope += f64::from(u * force);
            search.curvature += f64::from(d * force);
        }
        for (u, d) in velocity.0[4..].iter().zip(turn) {
            search.slope += f64::from(u * d);
            search.curvature += f64::from(d * d);
        }
    }
    for (stand, changes) in work.stands.iter().zip(&work.changes) {
        let place = &batch.places[stand.name()];
        let block = &batch.blocks[place.block()];
        for (change, lanes) in changes[..place.size.points()].iter().zip(&block.points) {
            search.slope += f64::from(lanes.bias[place.lane()] * change.x);
        }
    }
    search
}

/// λ += αd, u' with it.
fn take(batch: &mut Batch, work: &HandDown, alpha: f32) {
    for (stand, changes) in work.stands.iter().zip(&work.changes) {
        let place = &batch.places[stand.name()];
        let (block, lane) = (&mut batch.blocks[place.block()], place.lane());
        for (i, change) in changes[..place.size.points()].iter().enumerate() {
            let (p, disk) = (&mut block.points[i], &mut block.disks[i]);
            p.lambda[lane] += alpha * change.x;
            disk.lambda[0][lane] += alpha * change.y;
            disk.lambda[1][lane] += alpha * change.z;
        }
    }
    for body in 1..batch.movers.records() {
        let push = &work.pushes[body];
        let change = batch.movers.pushed(body as u32, alpha * push.linear, alpha * push.angular);
        for (sum, part) in batch.velocities[body].0.iter_mut().zip(change.0) {
            *sum += part;
        }
    }
}
