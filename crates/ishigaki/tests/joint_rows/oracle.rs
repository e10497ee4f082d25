//! The constraint functions of all joints once more, in f64 and written differently, and a small exact solver.

use ishigaki::constraint::joint_rows::{BodyFrame, ResolvedJoint};
use ishigaki::constraint::row::RowSpec;
use ishigaki::math::{Quat, Vec3, tangents};
use ishigaki::{Drive, Freedom, JointKind, Range};
use parry3d::glamx::{DMat3, DQuat, DVec3};
use std::f64::consts::PI;

/// Seeded numbers (SplitMix64).
pub struct Random(pub u64);

impl Random {
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn within(&mut self, lower: f64, upper: f64) -> f64 {
        lower + (upper - lower) * self.unit()
    }

    pub fn vector(&mut self, size: f64) -> DVec3 {
        DVec3::new(self.within(-size, size), self.within(-size, size), self.within(-size, size))
    }

    pub fn direction(&mut self) -> DVec3 {
        loop {
            let v = self.vector(1.0);
            if (0.1..1.0).contains(&v.length()) {
                return v.normalize();
            }
        }
    }

    pub fn rotation(&mut self) -> DQuat {
        DQuat::from_axis_angle(self.direction(), self.within(-PI, PI))
    }
}

pub fn narrow(v: DVec3) -> Vec3 {
    Vec3::new(v.x as f32, v.y as f32, v.z as f32)
}

pub fn wide(v: Vec3) -> DVec3 {
    DVec3::new(v.x.into(), v.y.into(), v.z.into())
}

pub fn narrow_rotation(q: DQuat) -> Quat {
    Quat::from_xyzw(q.x as f32, q.y as f32, q.z as f32, q.w as f32)
}

pub fn wide_rotation(q: Quat) -> DQuat {
    DQuat::from_xyzw(q.x.into(), q.y.into(), q.z.into(), q.w.into()).normalize()
}

/// A pose of a center of mass.
#[derive(Clone, Copy, Debug)]
pub struct Placed {
    pub center: DVec3,
    pub rotation: DQuat,
}

impl Placed {
    pub fn of(frame: &BodyFrame) -> Self {
        Self { center: wide(frame.center), rotation: wide_rotation(frame.rotation) }
    }

    pub fn frame(&self) -> BodyFrame {
        BodyFrame::at_rest(narrow(self.center), narrow_rotation(self.rotation.normalize()))
    }

    pub fn moved(&self, velocity: DVec3, angular_velocity: DVec3, time: f64) -> Self {
        Self {
            center: self.center + velocity * time,
            rotation: (DQuat::from_scaled_axis(angular_velocity * time) * self.rotation).normalize(),
        }
    }
}

/// The rotation vector, angle in [0, π].
pub fn log(q: DQuat) -> DVec3 {
    let q = if q.w < 0.0 { -q } else { q };
    let sine = q.xyz().length();
    if sine < 1e-12 { q.xyz() * 2.0 } else { q.xyz() * (2.0 * sine.atan2(q.w) / sine) }
}

/// Π Rot(aᵢ, θᵢ) and the current axes.
pub fn product(axes: &[DVec3], angles: &[f64]) -> (DQuat, Vec<DVec3>) {
    let mut rotation = DQuat::IDENTITY;
    let mut current = Vec::new();
    for (axis, angle) in axes.iter().zip(angles) {
        current.push(rotation * *axis);
        rotation *= DQuat::from_axis_angle(*axis, *angle);
    }
    (rotation, current)
}

/// Solves R = exp(ε·locked directions) Π Rot(aᵢ, θᵢ) for (θ, ε) by Newton with a numerical derivative.
fn turns(axes: &[DVec3], relative: DQuat, guess: &[f64]) -> [f64; 3] {
    let k = axes.len();
    let residual = |x: [f64; 3]| {
        let (rotation, w) = product(axes, &x[..k]);
        let error = match k {
            0 => DVec3::from_array(x),
            1 => {
                let y = w[0].any_orthonormal_vector();
                y * x[1] + w[0].cross(y) * x[2]
            }
            2 => w[0].cross(w[1]).normalize() * x[2],
            _ => DVec3::ZERO,
        };
        log(relative * (DQuat::from_scaled_axis(error) * rotation).conjugate())
    };
    let mut x = [0.0; 3];
    x[..k].copy_from_slice(&guess[..k]);
    for _ in 0..20 {
        let r = residual(x);
        let column = |i: usize| {
            let (mut up, mut down) = (x, x);
            up[i] += 1e-6;
            down[i] -= 1e-6;
            (residual(up) - residual(down)) / 2e-6
        };
        let dx = DMat3::from_cols(column(0), column(1), column(2)).inverse() * -r;
        for i in 0..3 {
            x[i] += dx[i];
        }
        if dx.length() < 1e-13 {
            break;
        }
    }
    x
}

fn drive_values(drive: &Drive, q: f64, out: &mut Vec<Option<f64>>) {
    let soft = usize::from(drive.spring.is_some() || drive.armature > 0.0)
        + usize::from(drive.motor.is_some())
        + usize::from(drive.friction > 0.0);
    out.extend(std::iter::repeat_n(Some(q), soft));
    limit_values(drive.limit.as_ref(), q, out);
}

fn limit_values(limit: Option<&Range>, q: f64, out: &mut Vec<Option<f64>>) {
    let Some(limit) = limit else { return };
    if limit.lower.is_finite() {
        out.push(Some(q));
    }
    if limit.upper.is_finite() && limit.upper != limit.lower {
        out.push(Some(-q));
    }
}

/// For each row the function whose derivative J is, `None` for rows that are rates only. `angles`: about where the
/// generic joint's angles are.
pub fn values(kind: &JointKind, joint: &ResolvedJoint, a: &Placed, b: &Placed, angles: &[f64]) -> Vec<Option<f64>> {
    let frame_a = a.rotation * wide_rotation(joint.frame_a);
    let frame_b = b.rotation * wide_rotation(joint.frame_b);
    let anchor_a = a.center + a.rotation * wide(joint.anchor_a);
    let anchor_b = b.center + b.rotation * wide(joint.anchor_b);
    let relative = frame_a.conjugate() * frame_b;
    let offset = frame_a.conjugate() * (anchor_b - anchor_a);
    let x_b = relative * DVec3::X;
    let mut out = Vec::new();
    let point = |out: &mut Vec<Option<f64>>| out.extend((anchor_a - anchor_b).to_array().map(Some));
    let rotation_lock = |out: &mut Vec<Option<f64>>| out.extend((-log(relative)).to_array().map(Some));
    let axis_lock = |out: &mut Vec<Option<f64>>, axis: Vec3| {
        let a = wide(axis);
        let b = relative * a;
        let cross = a.cross(b);
        let e = cross.normalize_or_zero() * cross.length().atan2(a.dot(b));
        let (t1, t2) = tangents(axis);
        out.extend([Some(-wide(t1).dot(e)), Some(-wide(t2).dot(e))]);
    };
    let twist = |axis: DVec3| {
        // Undo the swing by the shortest rotation, then read the angle off.
        let swing = DQuat::from_rotation_arc(axis, relative * axis);
        log(swing.conjugate() * relative).dot(axis)
    };
    match kind {
        JointKind::Ball { cone, twist: range, friction, damping } => {
            out.extend(vec![None; 3 * usize::from(*friction > 0.0) + 3 * usize::from(*damping > 0.0)]);
            limit_values(range.as_ref(), twist(DVec3::X), &mut out);
            if let Some(cone) = cone {
                assert!(*cone > 0.0);
                out.push(Some(-x_b.x.clamp(-1.0, 1.0).acos()));
            }
            point(&mut out);
        }
        JointKind::Hinge { drive } => {
            drive_values(drive, twist(DVec3::X), &mut out);
            axis_lock(&mut out, Vec3::X);
            point(&mut out);
        }
        JointKind::Slider { drive } => {
            drive_values(drive, offset.x, &mut out);
            rotation_lock(&mut out);
            out.extend([Some(-offset.y), Some(-offset.z)]);
        }
        JointKind::Fixed => {
            rotation_lock(&mut out);
            point(&mut out);
        }
        JointKind::Distance { range, spring } => {
            let d = offset.length();
            out.extend(spring.map(|_| Some(d)));
            // No distance falls below 0: that end has no row.
            let lower = if range.lower > 0.0 { range.lower } else { f32::NEG_INFINITY };
            limit_values(Some(&Range { lower, ..*range }), d, &mut out);
        }
        JointKind::Generic { linear, angular } => {
            for (i, freedom) in linear.iter().enumerate() {
                if let Freedom::Free(drive) = freedom {
                    drive_values(drive, offset[i], &mut out);
                }
            }
            let axes: Vec<DVec3> = angular.iter().map(|turn| wide(turn.axis).normalize()).collect();
            let x = turns(&axes, relative, angles);
            for (turn, angle) in angular.iter().zip(x) {
                drive_values(&turn.drive, angle, &mut out);
            }
            match axes.len() {
                0 => rotation_lock(&mut out),
                1 => axis_lock(&mut out, angular[0].axis.normalize()),
                2 => out.push(Some(-x[2])),
                _ => {}
            }
            let locked: Vec<usize> = (0..3).filter(|&i| linear[i] == Freedom::Locked).collect();
            if locked.len() == 3 {
                point(&mut out);
            } else {
                out.extend(locked.into_iter().map(|i| Some(-offset[i])));
            }
        }
    }
    out
}

/// Velocities of two bodies: v_A, ω_A, v_B, ω_B.
pub type Velocities = [DVec3; 4];

/// J as four vectors.
pub fn jacobian(row: &RowSpec) -> [DVec3; 4] {
    let j = &row.jacobian;
    [wide(j.linear), wide(j.angular_a), -wide(j.linear), wide(j.angular_b)]
}

pub fn rate(row: &RowSpec, u: &Velocities) -> f64 {
    jacobian(row).iter().zip(u).map(|(j, u)| j.dot(*u)).sum()
}

/// Projected Gauss–Seidel in f64 until it stands; `inverse_mass`: of v_A, ω_A, v_B, ω_B (spheres). Gives λ.
pub fn solve(rows: &[RowSpec], inverse_mass: [f64; 4], u: &mut Velocities) -> Vec<f64> {
    let mut lambdas = vec![0.0; rows.len()];
    for _ in 0..20_000 {
        let mut change: f64 = 0.0;
        for (row, lambda) in rows.iter().zip(&mut lambdas) {
            let j = jacobian(row);
            let gamma = f64::from(row.softness);
            let a: f64 = (0..4).map(|i| j[i].length_squared() * inverse_mass[i]).sum::<f64>() + gamma;
            let w = rate(row, u) + gamma * *lambda + f64::from(row.bias);
            let new = (*lambda - w / a).clamp(row.lower.into(), row.upper.into());
            for i in 0..4 {
                u[i] += j[i] * (inverse_mass[i] * (new - *lambda));
            }
            change = change.max((new - *lambda).abs());
            *lambda = new;
        }
        if change < 1e-12 {
            break;
        }
    }
    lambdas
}

/// Nothing is NaN, J is finite and not zero.
pub fn assert_sound(rows: &[RowSpec], context: &str) {
    for (i, row) in rows.iter().enumerate() {
        let j = &row.jacobian;
        let finite = j.linear.is_finite() && j.angular_a.is_finite() && j.angular_b.is_finite();
        assert!(finite && row.bias.is_finite() && row.relax_bias.is_finite(), "{context}: row {i} {row:?}");
        assert!(
            row.softness.is_finite() && row.softness >= 0.0 && row.lower <= row.upper,
            "{context}: row {i} {row:?}"
        );
        let size = j.linear.length() + j.angular_a.length();
        assert!((1e-3..1e3).contains(&size), "{context}: row {i} has |J| {size}: {row:?}");
    }
}
