//! A moving body in a batch: its state over the substeps, and its mass-weighted velocity.
//!
//! The state is (v, L, pose), as in the reference; solver impulses change L by exactly I^½Δu'.

use crate::body::BodyState;
use crate::math::{Mat3, Quat, Vec3, rotated_diagonal};
use crate::motion::{self, Spin, forces};
use crate::options::RotationScheme;
use crate::solver::wide::lanes::Record;

/// One body over the substeps of a step.
#[derive(Clone, Copy, Debug)]
pub struct Mover {
    /// Its slot in the world.
    pub slot: u32,
    /// 1/kg.
    pub inverse_mass: f32,
    /// m^½.
    root_mass: f32,
    /// m^−½.
    pub inverse_root_mass: f32,
    /// I^½ in world at the start of the step.
    root_inertia: Mat3,
    /// I^−½, symmetric: xx, xy, xz, yy, yz, zz.
    pub inverse_root_inertia: [f32; 6],
    spin: Spin,
    velocity: Vec3,
    center: Vec3,
    force: Vec3,
    torque: Vec3,
    acceleration: Vec3,
    damping: [f32; 2],
    /// L has changed, and ω does not follow it yet.
    is_stale: bool,
}

/// What moves all bodies alike.
#[derive(Clone, Copy, Debug)]
pub struct MotionLimits {
    /// m/s.
    pub speed: f32,
    /// rad/s.
    pub angular_speed: f32,
}

impl Mover {
    /// An active dynamic body without locked axes.
    pub fn new(slot: u32, body: &BodyState, gravity: Vec3) -> Self {
        let spin = body.spin();
        let (root_inertia, inverse_root_inertia) = roots_of(&spin);
        let inverse_mass = body.inverse_mass;
        let mass = if inverse_mass > 0.0 { 1.0 / inverse_mass } else { 0.0 };
        Self {
            slot,
            inverse_mass,
            root_mass: mass.sqrt(),
            inverse_root_mass: inverse_mass.sqrt(),
            root_inertia,
            inverse_root_inertia,
            spin,
            velocity: body.velocity,
            center: body.center,
            force: body.force,
            torque: body.torque,
            acceleration: gravity * body.gravity_scale,
            damping: [body.linear_damping, body.angular_damping],
            is_stale: false,
        }
    }

    /// Center of mass, m.
    pub fn center(&self) -> Vec3 {
        self.center
    }

    /// `world_from_body`.
    pub fn rotation(&self) -> Quat {
        self.spin.rotation
    }

    /// ω, rad/s.
    pub fn angular_velocity(&self) -> Vec3 {
        self.spin.angular_velocity
    }

    /// R, L and ω.
    pub fn spin(&self) -> &Spin {
        &self.spin
    }

    /// I^−½ as a record: xx, xy, xz, 0, yy, yz, zz, 0.
    pub fn inverse_root_record(&self) -> Record {
        let [xx, xy, xz, yy, yz, zz] = self.inverse_root_inertia;
        Record([xx, xy, xz, 0.0, yy, yz, zz, 0.0])
    }

    /// I^½ as a record.
    pub fn root_record(&self) -> Record {
        let [x, y, z] = [self.root_inertia.x_axis, self.root_inertia.y_axis, self.root_inertia.z_axis];
        Record([x.x, y.x, z.x, 0.0, y.y, z.y, z.z, 0.0])
    }

    /// Takes I^½ and I^−½ that were found for the rotation as it is; the way of the step so far is weighted by them.
    pub fn weigh(&mut self, root: [f32; 6], inverse_root: [f32; 6], displacement: &mut Record) {
        let (way, turn) = self.velocities(displacement);
        let [xx, xy, xz, yy, yz, zz] = root;
        let columns = [Vec3::new(xx, xy, xz), Vec3::new(xy, yy, yz), Vec3::new(xz, yz, zz)];
        self.root_inertia = Mat3::from_cols(columns[0], columns[1], columns[2]);
        self.inverse_root_inertia = inverse_root;
        *displacement = self.weighted(way, turn);
    }

    /// Puts the body somewhere else; L stays, ω is to follow.
    pub fn put(&mut self, center: Vec3, rotation: Quat) {
        self.center = center;
        self.spin.rotation = rotation;
        self.is_stale = true;
    }

    /// ω = I⁻¹L has been found.
    pub fn take_spin(&mut self, angular_velocity: Vec3) {
        if self.is_stale {
            self.spin.angular_velocity = angular_velocity;
            self.is_stale = false;
        }
    }

    /// ω = I⁻¹L, by itself.
    pub fn find_spin(&mut self) {
        if self.is_stale {
            self.take_spin(self.spin.inverse_inertia_times(self.spin.angular_momentum));
        }
    }

    /// R and ω have been found.
    pub fn take_turn(&mut self, rotation: Quat, angular_velocity: Vec3) {
        (self.spin.rotation, self.spin.angular_velocity) = (rotation, angular_velocity);
    }

    /// R and ω after `h` seconds, by itself.
    pub fn turn(&mut self, scheme: RotationScheme, h: f32) {
        motion::advance(scheme, &mut self.spin, false, h);
    }

    /// u' = (m^½ v, I^½ ω).
    pub fn record(&self) -> Record {
        let v = self.root_mass * self.velocity;
        let w = self.root_inertia * self.spin.angular_velocity;
        Record([v.x, v.y, v.z, 0.0, w.x, w.y, w.z, 0.0])
    }

    /// v and ω of a mass-weighted velocity.
    pub fn velocities(&self, u: &Record) -> (Vec3, Vec3) {
        let [vx, vy, vz, _, wx, wy, wz, _] = u.0;
        let [xx, xy, xz, yy, yz, zz] = self.inverse_root_inertia;
        let w = Vec3::new(xx * wx + xy * wy + xz * wz, xy * wx + yy * wy + yz * wz, xz * wx + yz * wy + zz * wz);
        (self.inverse_root_mass * Vec3::new(vx, vy, vz), w)
    }

    /// The mass-weighted velocity of v and ω.
    pub fn weighted(&self, velocity: Vec3, angular_velocity: Vec3) -> Record {
        let (v, w) = (self.root_mass * velocity, self.root_inertia * angular_velocity);
        Record([v.x, v.y, v.z, 0.0, w.x, w.y, w.z, 0.0])
    }

    /// M^−½ times an impulse, N·s, and an angular impulse, N·m·s: the change of u' that they make.
    pub fn pushed(&self, impulse: Vec3, torque: Vec3) -> Record {
        let v = self.inverse_root_mass * impulse;
        let [xx, xy, xz, yy, yz, zz] = self.inverse_root_inertia;
        let w = Vec3::new(
            xx * torque.x + xy * torque.y + xz * torque.z,
            xy * torque.x + yy * torque.y + yz * torque.z,
            xz * torque.x + yz * torque.y + zz * torque.z,
        );
        Record([v.x, v.y, v.z, 0.0, w.x, w.y, w.z, 0.0])
    }

    /// M^½u' = (m v, I ω) of a mass-weighted velocity, N·s and N·m·s.
    pub fn momentum(&self, u: &Record) -> (Vec3, Vec3) {
        let [vx, vy, vz, _, wx, wy, wz, _] = u.0;
        (self.root_mass * Vec3::new(vx, vy, vz), self.root_inertia * Vec3::new(wx, wy, wz))
    }

    /// v += h(F/m + g), L += hτ, damping. Gives u'.
    pub fn begin(&mut self, h: f32) -> Record {
        let inverse = Vec3::splat(self.inverse_mass);
        self.velocity = forces::accelerated(self.velocity, self.force, inverse, self.acceleration, h);
        self.velocity *= forces::damping_factor(self.damping[0], h);
        if self.torque != Vec3::ZERO {
            forces::apply_angular_impulse(&mut self.spin, h * self.torque, Vec3::ONE);
        }
        if self.damping[1] != 0.0 {
            forces::damp_spin(&mut self.spin, forces::damping_factor(self.damping[1], h));
        }
        self.record()
    }

    /// Takes over what sweeps made of u', ω but for lanes to find; gives the change.
    pub fn take(&mut self, before: &Record, after: &Record) -> Record {
        let change: [f32; 8] = std::array::from_fn(|k| after.0[k] - before.0[k]);
        let [vx, vy, vz, _, wx, wy, wz, _] = change;
        self.velocity += self.inverse_root_mass * Vec3::new(vx, vy, vz);
        let turn = self.root_inertia * Vec3::new(wx, wy, wz);
        if turn != Vec3::ZERO {
            self.spin.angular_momentum += turn;
            self.is_stale = true;
        }
        Record(change)
    }

    /// x += h v; adds the way and the turn of `h` seconds to the mass-weighted displacement.
    pub fn advance(&mut self, limits: MotionLimits, h: f32, displacement: &mut Record) {
        self.velocity = forces::limited(self.velocity, limits.speed);
        forces::limit_spin(&mut self.spin, limits.angular_speed);
        let way = self.weighted(h * self.velocity, h * self.spin.angular_velocity);
        for (sum, part) in displacement.0.iter_mut().zip(way.0) {
            *sum += part;
        }
        self.center += h * self.velocity;
    }

    /// Into the world.
    pub fn store(&self, body: &mut BodyState) {
        body.velocity = self.velocity;
        body.center = self.center;
        body.rotation = self.spin.rotation;
        body.angular_momentum = self.spin.angular_momentum;
        body.angular_velocity = self.spin.angular_velocity;
    }
}

/// I^½ and I^−½ in world.
fn roots_of(spin: &Spin) -> (Mat3, [f32; 6]) {
    let axes = spin.world_from_principal();
    let root = |v: Vec3| Vec3::new(v.x.sqrt(), v.y.sqrt(), v.z.sqrt());
    let inverse = rotated_diagonal(axes, root(spin.inverse_principal_inertia));
    let [x, y, z] = [inverse.x_axis, inverse.y_axis, inverse.z_axis];
    (rotated_diagonal(axes, root(spin.principal_inertia)), [x.x, y.x, z.x, y.y, z.y, z.z])
}
