//! Up to three turns one after the other, as coordinates carried from substep to substep. TALK B8, B9.
//!
//! R_rel = Rot(a₁, θ₁)…Rot(a_k, θ_k). Current axes in A's frame: wᵢ = Rot(a₁, θ₁)…Rot(aᵢ₋₁, θᵢ₋₁) aᵢ; ω_B − ω_A = Σ
//! θ̇ᵢ wᵢ. Rates: θ̇ᵢ = gᵢ·(ω_B − ω_A) with the dual basis gᵢ·wⱼ = δᵢⱼ (for k = 2 completed by n = w₁×w₂/|w₁×w₂|). An
//! effort on θᵢ acts along gᵢ, not along the hinge's own axis wᵢ, so that it does work on θᵢ alone; for perpendicular
//! axes they are the same.
//! * k = 0: rotation lock. k = 1: axis and twist. k = 2: angle between a₁ and R_rel a₂ locked, which leaves 1 row
//!   along n; both θ in closed form.
//! * k = 3: nothing locked; θ follows by Newton's method from its last value, δ = log(R_rel Pᵀ), Δθᵢ = gᵢ·δ: measured
//!   against the poses each time, so no drift, and continuous beyond ±π. Where the axes fall into one plane (gimbal
//!   lock) g would be infinite: it becomes the damped least-squares inverse, and efforts stay bounded. Axes that are
//!   not perpendicular cannot reach every orientation; the border is such a place, and is not defended.
//!
//! Test: `joint_rows::dual_basis`, `joint_rows::coordinates_are_recovered`, `joint_rows::gimbal_lock_is_finite`.

use crate::constraint::frame::{FramePair, JointStep};
use crate::constraint::part::angle::Angle;
use crate::constraint::part::axis::{Axis, twist};
use crate::constraint::part::limit_motor::{Coordinate, nearest_turn};
use crate::constraint::row::{Jacobian, RowSpec};
use crate::math::{Mat3, Quat, Vec3, atan2, cos, sin, tangents, vector_from_rotation};
use arrayvec::ArrayVec;

/// Volume of the three axes below which they count as nearly in one plane.
const LEAST_VOLUME: f32 = 0.05;
/// From this rotation, rad, one Newton step, whose error is its square, leaves no more than f32's rounding.
const CLOSE: f32 = 1e-4;
/// Newton steps in one substep; two or three are the rule.
const MOST_STEPS: usize = 8;

/// A sequence of turns at one moment.
#[derive(Clone, Debug)]
pub struct Turns {
    /// The angles of B relative to A, in sequence.
    pub angles: ArrayVec<Coordinate, 3>,
    lock: Lock,
}

/// The rotations that no axis turns about.
#[derive(Clone, Copy, Debug)]
enum Lock {
    All(Angle),
    Across(Axis),
    Between { angle: Coordinate, target: f32 },
    Nothing,
}

impl Turns {
    /// At this moment; `axes` (at most 3, unit) in the joint's frame at zero, `last` the last known angles.
    pub fn new(pair: &FramePair, axes: &[Vec3], last: &[f32]) -> Self {
        let mut angles = ArrayVec::new();
        let lock = match *axes {
            [] => Lock::All(Angle::new(pair)),
            [axis] => {
                angles.push(twist(pair, axis, last[0]));
                Lock::Across(Axis::new(pair, axis))
            }
            [first, second] => {
                let (turns, lock) = two(pair, first, second, [last[0], last[1]]);
                angles.extend(turns);
                lock
            }
            [first, second, third, ..] => {
                angles.extend(three(pair, [first, second, third], [last[0], last[1], last[2]]));
                Lock::Nothing
            }
        };
        Self { angles, lock }
    }

    /// Rows of [`Turns::lock_rows`] for `k` axes.
    pub fn lock_row_count(k: usize) -> usize {
        3 - k.min(3)
    }

    /// The locked rotations: 3 − k rows.
    pub fn lock_rows(&self, step: &JointStep, out: &mut Vec<RowSpec>) {
        match &self.lock {
            Lock::All(angle) => angle.rows(step, out),
            Lock::Across(axis) => axis.rows(step, out),
            Lock::Between { angle, target } => out.push(angle.lock_row(*target, step)),
            Lock::Nothing => {}
        }
    }

    /// How far the locked rotations are off, rad.
    pub fn error(&self) -> f32 {
        match &self.lock {
            Lock::All(angle) => angle.error(),
            Lock::Across(axis) => axis.error(),
            Lock::Between { angle, target } => (angle.value - target).abs(),
            Lock::Nothing => 0.0,
        }
    }
}

/// Angles to start from when none are known: those of the poses, each on the turn nearest to `middles`.
pub fn first_angles(pair: &FramePair, axes: &[Vec3], middles: &[f32]) -> ArrayVec<f32, 3> {
    if let [a, b, c] = *axes {
        let found = search([a, b, c], pair.relative());
        return found.iter().zip(middles).map(|(&angle, &middle)| nearest_turn(angle, middle)).collect();
    }
    Turns::new(pair, axes, middles).angles.iter().map(|angle| angle.value).collect()
}

/// The basis g with gᵢ·wⱼ = δᵢⱼ; damped where the volume of w is below `LEAST_VOLUME`.
pub fn dual(w: [Vec3; 3]) -> [Vec3; 3] {
    let crosses = [w[1].cross(w[2]), w[2].cross(w[0]), w[0].cross(w[1])];
    let volume = w[0].dot(crosses[0]);
    if volume.abs() >= LEAST_VOLUME {
        return crosses.map(|cross| cross / volume);
    }
    // G = (WᵀW + μ²)⁻¹Wᵀ; μ grows from 0 at the threshold, so nothing jumps there.
    let damping = LEAST_VOLUME * LEAST_VOLUME - volume * volume;
    let axes = Mat3::from_cols(w[0], w[1], w[2]);
    let normal = axes.transpose() * axes + Mat3::from_diagonal(Vec3::splat(damping));
    let g = axes * normal.inverse();
    [g.x_axis, g.y_axis, g.z_axis]
}

/// The rotation of three turns and their current axes, in A's frame.
fn forward(axes: [Vec3; 3], angles: [f32; 3]) -> (Quat, [Vec3; 3]) {
    let first = turn(axes[0], angles[0]);
    let second = first * turn(axes[1], angles[1]);
    (second * turn(axes[2], angles[2]), [axes[0], first * axes[1], second * axes[2]])
}

fn turn(axis: Vec3, angle: f32) -> Quat {
    let xyz = axis * sin(0.5 * angle);
    Quat::from_xyzw(xyz.x, xyz.y, xyz.z, cos(0.5 * angle))
}

/// Newton's method from `angles`, halving steps that do not help; gives the rotation (rad) left before the last step.
fn follow(axes: [Vec3; 3], target: Quat, angles: &mut [f32; 3], most_steps: usize) -> f32 {
    let residual = |angles| {
        let (rotation, current) = forward(axes, angles);
        (vector_from_rotation(target * rotation.conjugate()), current)
    };
    let (mut left, mut current) = residual(*angles);
    for _ in 0..most_steps {
        let mut step = dual(current).map(|g| g.dot(left));
        if left.length() < CLOSE {
            *angles = std::array::from_fn(|i| angles[i] + step[i]);
            break;
        }
        let longest = step[0].abs().max(step[1].abs()).max(step[2].abs());
        // More than a radian is beyond what the linear model can promise.
        if longest > 1.0 {
            step = step.map(|s| s / longest);
        }
        let better = [1.0, 0.5, 0.25, 0.125].iter().find_map(|part| {
            let trial: [f32; 3] = std::array::from_fn(|i| angles[i] + part * step[i]);
            let (trial_left, trial_current) = residual(trial);
            (trial_left.length() < left.length()).then_some((trial, trial_left, trial_current))
        });
        let Some(better) = better else { break };
        (*angles, left, current) = better;
    }
    left.length()
}

/// The angles of an orientation without a guess: from zero, then from a coarse grid.
fn search(axes: [Vec3; 3], target: Quat) -> [f32; 3] {
    let mut best = [0.0; 3];
    let mut best_left = follow(axes, target, &mut best, 64);
    for cell in 0..27 {
        if best_left < 1e-4 {
            break;
        }
        let mut angles = [cell % 3, cell / 3 % 3, cell / 9].map(|i: i32| 2.0 * (i - 1) as f32);
        let left = follow(axes, target, &mut angles, 64);
        if left < best_left {
            (best, best_left) = (angles, left);
        }
    }
    best
}

fn three(pair: &FramePair, axes: [Vec3; 3], last: [f32; 3]) -> [Coordinate; 3] {
    let mut angles = last;
    follow(axes, pair.relative(), &mut angles, MOST_STEPS);
    let (_, current) = forward(axes, angles);
    let g = dual(current);
    std::array::from_fn(|i| angle(pair, angles[i], g[i]))
}

fn two(pair: &FramePair, first: Vec3, second: Vec3, last: [f32; 2]) -> ([Coordinate; 2], Lock) {
    let relative = pair.relative();
    // The second axis is fixed to B, seen from A; the first is fixed to A, seen from B.
    let second_in_a = relative * second;
    let first_in_b = relative.conjugate() * first;
    let cross = first.cross(second_in_a);
    let sine = cross.length();
    let n = if sine > 1e-4 { cross / sine } else { tangents(first).0 };
    let [g1, g2, _] = dual([first, second_in_a, n]);
    let angles = [
        angle(pair, azimuth(first, second, second_in_a, last[0]), g1),
        angle(pair, -azimuth(second, first, first_in_b, -last[1]), g2),
    ];
    let between = angle(pair, atan2(sine, first.dot(second_in_a)), n);
    let target = atan2(first.cross(second).length(), first.dot(second));
    (angles, Lock::Between { angle: between, target })
}

/// The angle about `axis` from `from` to `to`, on the turn nearest to `last`; `last` where it is undefined.
fn azimuth(axis: Vec3, from: Vec3, to: Vec3, last: f32) -> f32 {
    let sine = axis.dot(from.cross(to));
    let cosine = from.dot(to) - from.dot(axis) * to.dot(axis);
    if sine.abs() + cosine.abs() < 1e-6 { last } else { nearest_turn(atan2(sine, cosine), last) }
}

/// The angle whose rate is g·(ω_B − ω_A), g in A's frame.
fn angle(pair: &FramePair, value: f32, g: Vec3) -> Coordinate {
    Coordinate::new(value, Jacobian::rotation(pair.frame_a * g).negated(), pair)
}
