//! Eight ball joints side by side: a point in common, with cone, twist range, dry friction and damping. DESIGN, "Fast path".
//!
//! The rows are those of `constraint/ball.rs` in velocities weighted by inertia, as in `contact_block.rs`; the three of the point
//! are solved together by LDLᵀ (`block.rs`), an end of a range with its point (`reference.rs`). Poses come from the bodies
//! after each motion, and rows follow them: no joint is asked one by one.
//! No closures in here, as in `contact_block.rs`. Held to the reference by `tests/wide.rs`.
#![expect(clippy::needless_range_loop, reason = "kernels walk several arrays of rows in step")]

use crate::solver::wide::lanes::{LANES, Lane, Lane3};

mod turn;
mod visit;

pub use turn::{Aim, see, turn};
pub use visit::{add_up, change_of_point, greatest_change, greatest_turn, visit, warm_start};

const ZERO: Lane = [0.0; LANES];
const ZERO3: Lane3 = [ZERO; 3];

/// Range of the twist in `ranges`.
pub const TWIST: usize = 0;
/// The cone.
pub const CONE: usize = 1;
/// Friction in `drags`.
pub const FRICTION: usize = 0;
/// Damping.
pub const DAMPING: usize = 1;

/// The ends of ranges in the order of rows: which range, and whether it is the upper end. A cone has no lower one.
pub const ENDS: [(usize, usize); 3] = [(TWIST, 0), (TWIST, 1), (CONE, 1)];

/// What joints of a block have beside the point: what none has is not visited.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Parts {
    /// Cones or ranges of the twist.
    pub ranges: bool,
    /// Friction or damping.
    pub drags: bool,
}

impl Parts {
    /// How many kinds of blocks there are.
    pub const KINDS: usize = 4;

    /// Number of this kind.
    pub fn kind(self) -> usize {
        usize::from(self.ranges) + 2 * usize::from(self.drags)
    }

    /// The kind of that number.
    pub fn of_kind(kind: usize) -> Self {
        Self { ranges: kind % 2 == 1, drags: kind >= 2 }
    }
}

/// A range of one angle, of eight joints.
#[derive(Clone, Copy, Debug)]
pub struct RangeLanes {
    /// Lower and upper end, rad; infinite where there is none.
    pub limits: [Lane; 2],
    /// Turns are counted from here, rad.
    pub middle: Lane,
    /// Part of an error that is taken back: less where the angle loses its meaning.
    trust: Lane,
    /// World axis g of the angle's rate g·(ω_B − ω_A).
    axis: Lane3,
    /// J' of the rate, of A and B.
    angular: [Lane3; 2],
    /// J M⁻¹Jᵀ.
    k: Lane,
    /// 1 / what the point leaves free of it; known once an end is at work.
    free_mass: Lane,
    is_free_mass_known: bool,
    /// C ≥ 0 inside, rad, of both ends.
    pub gaps: [Lane; 2],
    /// Impulses, N·m·s.
    pub lambda: [Lane; 2],
    /// Summed over the substeps.
    pub total: [Lane; 2],
    /// Of the recovery by poses.
    pushed: [Lane; 2],
}

/// Torques against turning about the world axes, of eight joints.
#[derive(Clone, Copy, Debug)]
pub struct DragLanes {
    /// γ: 0 for friction, 1/(h d) for damping, 1/(kg·m²).
    pub softness: Lane,
    /// Greatest impulse, N·m·s; 0 where there is none.
    pub reach: Lane,
    /// N·m·s.
    pub lambda: Lane3,
    /// Summed over the substeps.
    pub total: Lane3,
}

/// Eight joints: what a visit reads comes first, and lies close together.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug)]
pub struct JointBlock {
    /// Index of A and B in the batch; 0 is whatever does not move.
    pub bodies: [[u32; LANES]; 2],
    /// m^−½.
    pub inverse_mass: [Lane; 2],
    /// I^−½ of round bodies, 1/(kg^½·m).
    pub root_inertia: [Lane; 2],
    /// L of J M⁻¹Jᵀ = L D Lᵀ: 10, 20, 21.
    lower: Lane3,
    /// 1/D.
    inverse_pivots: Lane3,
    /// p_A − p_B, m.
    pub gap: Lane3,
    /// What the way along arcs adds to it in this substep, m/s.
    arc: Lane3,
    /// Impulse on A in world, N·s.
    pub lambda: Lane3,
    /// J' of the rows along x, y, z for rotations of A and B; of round bodies the arm times I^−½ takes the place of the first.
    angular: [[Lane3; 3]; 2],
    /// Summed over the substeps.
    pub total: Lane3,
    /// Where their poses are.
    pub poses: [[u32; LANES]; 2],
    /// Anchors from the centers of mass, in the axes of the bodies, m.
    pub anchors: [Lane3; 2],
    /// All moments of inertia of each of the bodies are the same: rows are a vector product.
    pub is_round: bool,
    /// Which of the [`TurnLanes`] belong to it; beyond all of them if it asks nothing of rotations.
    pub turns: u32,
}

/// What eight joints ask of rotations: twist, cone, friction, damping.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug)]
pub struct TurnLanes {
    /// What is visited.
    pub parts: Parts,
    /// `body_from_frame`.
    pub frames: [[Lane; 4]; 2],
    /// I^−½, where there are drags: xx, xy, xz, and yy, yz, zz.
    inertia: [[Lane3; 2]; 2],
    /// Friction, damping.
    pub drags: [DragLanes; 2],
    /// Twist, cone.
    pub ranges: [RangeLanes; 2],
}

impl JointBlock {
    /// In the place of [`Self::turns`]: nothing.
    pub const NO_TURNS: u32 = u32::MAX;

    /// Eight joints that do nothing.
    pub const EMPTY: Self = Self {
        bodies: [[0; LANES]; 2],
        inverse_mass: [ZERO; 2],
        root_inertia: [ZERO; 2],
        lower: ZERO3,
        inverse_pivots: ZERO3,
        gap: ZERO3,
        arc: ZERO3,
        lambda: ZERO3,
        angular: [[ZERO3; 3]; 2],
        total: ZERO3,
        poses: [[0; LANES]; 2],
        anchors: [ZERO3; 2],
        is_round: true,
        turns: Self::NO_TURNS,
    };

    /// Before all its lanes are filled.
    pub fn begin(&mut self, turns: u32) {
        (self.inverse_mass, self.total) = (Self::EMPTY.inverse_mass, Self::EMPTY.total);
        (self.is_round, self.turns) = (true, turns);
    }

    /// For another step of the same joints.
    pub fn renew(&mut self, warm_scale: f32) {
        self.total = Self::EMPTY.total;
        self.lambda.as_flattened_mut().iter_mut().for_each(|lambda| *lambda *= warm_scale);
    }
}

impl TurnLanes {
    /// Eight joints that turn freely.
    const EMPTY: Self = Self {
        parts: Parts { ranges: false, drags: false },
        frames: [[ZERO, ZERO, ZERO, [1.0; LANES]]; 2],
        inertia: [[ZERO3; 2]; 2],
        drags: [DragLanes { softness: ZERO, reach: ZERO, lambda: ZERO3, total: ZERO3 }; 2],
        ranges: [RangeLanes {
            limits: [[f32::NEG_INFINITY; LANES], [f32::INFINITY; LANES]],
            middle: ZERO,
            trust: ZERO,
            axis: ZERO3,
            angular: [ZERO3; 2],
            k: ZERO,
            free_mass: ZERO,
            is_free_mass_known: false,
            gaps: [[f32::INFINITY; LANES]; 2],
            lambda: [ZERO; 2],
            total: [ZERO; 2],
            pushed: [ZERO; 2],
        }; 2],
    };

    /// Before its lanes are filled.
    pub fn new(parts: Parts) -> Self {
        Self { parts, ..Self::EMPTY }
    }

    /// The world axis of a range's angle in a lane.
    pub fn axis(&self, range: usize, lane: usize) -> crate::math::Vec3 {
        let [x, y, z] = self.ranges[range].axis.map(|lanes| lanes[lane]);
        crate::math::Vec3::new(x, y, z)
    }
}

/// What all visits of a sweep share: which part of errors it meets.
#[derive(Clone, Copy, Debug)]
pub struct JointPass {
    /// 1/h, 1/s.
    pub per_second: f32,
    /// What velocities must meet.
    pub aim: Target,
    /// β/h in the recovery by poses, else 0; 1/s.
    pub recovery: f32,
    /// A visit to the point goes this many times as far: `over_relaxation.rs`.
    pub reach: f32,
}

/// What joints ask of velocities: `joint_recovery.rs`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// Before the motion: the chord that ends on the arc.
    ChordToArc,
    /// After it: the chord that leaves it.
    ChordFromArc,
    /// Part of the errors back, by impulses that begin at 0 and are forgotten.
    Poses,
}

impl JointPass {
    /// Before the motion.
    pub fn velocity(h: f32) -> Self {
        Self { per_second: 1.0 / h, aim: Target::ChordToArc, recovery: 0.0, reach: 1.0 }
    }

    /// After the motion, with over-relaxation by `reach`.
    pub fn relax(h: f32, reach: f32) -> Self {
        Self { aim: Target::ChordFromArc, reach, ..Self::velocity(h) }
    }

    /// For the velocities that take the part `rate` of the errors back.
    pub fn recovery(h: f32, rate: f32) -> Self {
        Self { aim: Target::Poses, recovery: rate / h, ..Self::velocity(h) }
    }

    /// Whether impulses are those of the recovery by poses.
    pub fn by_pose(&self) -> bool {
        self.aim == Target::Poses
    }
}
