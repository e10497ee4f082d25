//! The coordinates between a link and its parent as joints of the engine.
//!
//! MuJoCo lays out any number of slides, hinges and balls on one body, in sequence, each with its own anchor:
//! `R = R(a₁,θ₁) R(a₂,θ₂) …` in the link's frame, so the first axis is fixed to the parent and the last to the link —
//! the order of the engine's generic joint too. One joint of the engine can take up to three slides along
//! perpendicular axes and then up to three independent turns about one common point. What does not fit starts another
//! stage, with a light body between the two.

use super::tree::{Coordinate, CoordinateKind, pose, vec32};
use glamx::{DMat3, DPose3, DQuat, DVec3};
use ishigaki::{Drive, Freedom, JointKind, Range, Spring, TurnAxis};

/// Two turns are independent for the engine from here on; a little over its own bound.
const LEAST_INDEPENDENCE: f64 = 1.1e-2;
/// Anchors nearer than this are one, × (1 + their distance from the origin), m.
const SAME_POINT: f64 = 1e-7;
/// Slides are perpendicular below this cosine.
const PERPENDICULAR: f64 = 1e-6;

/// What one joint of the engine can take.
#[derive(Debug, Default)]
pub(crate) struct Stage {
    slides: Vec<Coordinate>,
    turns: Vec<Coordinate>,
    ball: Option<Coordinate>,
    /// In the link's frame.
    anchor: DVec3,
}

/// Groups a link's coordinates, in order, into as few stages as they fit in.
pub(crate) fn stages(coordinates: &[Coordinate]) -> Vec<Stage> {
    let mut stages: Vec<Stage> = Vec::new();
    for coordinate in coordinates {
        let fits = stages.last_mut().is_some_and(|stage| stage.take(coordinate));
        if !fits {
            let mut stage = Stage { anchor: coordinate.anchor, ..Stage::default() };
            stage.push(coordinate.clone());
            stages.push(stage);
        }
    }
    stages
}

impl Stage {
    fn push(&mut self, coordinate: Coordinate) {
        match coordinate.kind {
            CoordinateKind::Slide => self.slides.push(coordinate),
            CoordinateKind::Hinge => self.turns.push(coordinate),
            CoordinateKind::Ball => self.ball = Some(coordinate),
        }
    }

    /// Takes a coordinate in, if the joint stays one the engine has.
    fn take(&mut self, next: &Coordinate) -> bool {
        if self.ball.is_some() {
            return false;
        }
        match next.kind {
            CoordinateKind::Ball => return false,
            CoordinateKind::Slide => {
                let perpendicular = self.slides.iter().all(|s| s.axis.dot(next.axis).abs() < PERPENDICULAR);
                if !self.turns.is_empty() || self.slides.len() == 3 || !perpendicular {
                    return false;
                }
            }
            CoordinateKind::Hinge => {
                let independent = match self.turns.as_slice() {
                    [] => true,
                    [a] => a.axis.cross(next.axis).length() > LEAST_INDEPENDENCE,
                    [a, b] => a.axis.cross(b.axis).dot(next.axis).abs() > LEAST_INDEPENDENCE,
                    _ => false,
                };
                let point = if independent { self.common_point(next) } else { None };
                let Some(point) = point else { return false };
                self.anchor = point;
            }
        }
        self.push(next.clone());
        true
    }

    /// The point that all axes pass through; where a hinge's anchor sits along its own axis makes no difference.
    fn common_point(&self, next: &Coordinate) -> Option<DVec3> {
        let tolerance = SAME_POINT * (1.0 + next.anchor.length());
        let off = |point: DVec3, c: &Coordinate| (point - c.anchor).cross(c.axis).length();
        let point = match self.turns.as_slice() {
            [] => next.anchor,
            _ if off(self.anchor, next) < tolerance => self.anchor,
            [a] => {
                // The point of a's axis nearest to the new one.
                let normal = a.axis.cross(next.axis);
                let along = (next.anchor - a.anchor).cross(next.axis).dot(normal) / normal.length_squared();
                a.anchor + a.axis * along
            }
            _ => return None,
        };
        (off(point, next) < tolerance && self.turns.iter().all(|a| off(point, a) < tolerance)).then_some(point)
    }

    /// Names of its coordinates: `hip_x+hip_z`.
    pub fn name(&self) -> String {
        let all = self.slides.iter().chain(&self.turns).chain(&self.ball);
        all.map(|c| c.name.as_str()).filter(|n| !n.is_empty()).collect::<Vec<_>>().join("+")
    }

    /// The joint's frame in the world and what it allows.
    pub fn joint(&self, world_from_link: DPose3) -> (DPose3, JointKind) {
        let at = |rotation: DQuat| world_from_link * pose(self.anchor, rotation);
        if let Some(ball) = &self.ball {
            let cone = ball.limit.map(|[_, angle]| angle.clamp(0.0, std::f64::consts::PI) as f32);
            let kind = JointKind::Ball {
                cone,
                twist: cone.map(|c| Range { lower: -c, upper: c }),
                friction: ball.friction as f32,
                damping: ball.damping as f32,
            };
            return (at(DQuat::IDENTITY), kind);
        }
        match (self.slides.as_slice(), self.turns.as_slice()) {
            ([], [turn]) => (at(about(turn.axis)), JointKind::Hinge { drive: drive(turn, 1.0) }),
            ([slide], []) => (at(about(slide.axis)), JointKind::Slider { drive: drive(slide, 1.0) }),
            _ => {
                let basis = self.basis();
                let mut linear = [Freedom::Locked; 3];
                for (i, slide) in self.slides.iter().enumerate() {
                    let sign = basis.col(i).dot(slide.axis).signum();
                    linear[i] = Freedom::Free(drive(slide, sign));
                }
                let local = |axis: DVec3| vec32((basis.transpose() * axis).normalize());
                let turn = |t: &Coordinate| TurnAxis { axis: local(t.axis), drive: drive(t, 1.0) };
                let angular = self.turns.iter().map(turn).collect();
                (at(DQuat::from_mat3(&basis).normalize()), JointKind::Generic { linear, angular })
            }
        }
    }

    /// Right-handed axes whose first are the slides; a third slide may point the other way.
    fn basis(&self) -> DMat3 {
        match self.slides.as_slice() {
            [] => DMat3::IDENTITY,
            [a] => DMat3::from_quat(about(a.axis)),
            [a, b, ..] => {
                let y = (b.axis - a.axis * a.axis.dot(b.axis)).normalize();
                DMat3::from_cols(a.axis, y, a.axis.cross(y))
            }
        }
    }
}

fn about(axis: DVec3) -> DQuat {
    DQuat::from_rotation_arc(DVec3::X, axis)
}

/// What acts on a coordinate; with sign −1 it is counted the other way.
fn drive(c: &Coordinate, sign: f64) -> Drive {
    let limit = c.limit.map(|[lower, upper]| {
        let (lower, upper) = if sign < 0.0 { (-upper, -lower) } else { (lower, upper) };
        Range { lower: lower as f32, upper: upper as f32 }
    });
    let spring = (c.stiffness > 0.0 || c.damping > 0.0).then_some(Spring {
        target: (c.rest * sign) as f32,
        stiffness: c.stiffness as f32,
        damping: c.damping as f32,
    });
    Drive { limit, motor: None, spring, armature: c.armature as f32, friction: c.friction as f32 }
}
