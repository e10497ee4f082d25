//! One step: the ten stages in their order, and nothing else. The stages live in the folders.

use crate::body::Role;
use crate::collision::link::{Judge, Link};
use crate::collision::pair::clear_burst;
use crate::collision::pairs::Moves;
use crate::collision::proxy::Proxies;
use crate::collision::update::Part;
use crate::hooks::StepContext;
use crate::island::stillness::Stillness;
use crate::island::{aggressive_sleep, sleep};
use crate::math::Vec3;
use crate::report::{Stage, StepReport};
use crate::shape::Groups;
use crate::solver::height;
use crate::solver::joint_link::JointLinks;
use crate::solver::plan::{self, Plan};
use crate::solver::wide::storing::ContactSums;
use crate::world::World;

/// Steps outside this range divide by nothing or leave f32, s.
const SHORTEST_STEP: f32 = 1e-9;
const LONGEST_STEP: f32 = 1e6;

/// Bodies awake that one thread moves in the time that several lose by waiting for each other.
const FEW: usize = 300;

/// Arrays that are used again in each step, so that a settled world allocates nothing.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    /// Of each part of the bodies: some ask for forces of contacts.
    pub hears_forces: Vec<bool>,
    /// Of each body slot: what touches it must be looked at.
    pub stirs: Vec<bool>,
    /// Of all shapes that are there, and perhaps of some that were; nothing until a step asks for it.
    pub groups: Option<Groups>,
    pub moved_shapes: Vec<u32>,
    pub moves: Vec<Moves>,
    pub pair_lists: Vec<Vec<(u32, u32)>>,
    pub new_pairs: Vec<(u32, u32)>,
    pub gone_pairs: Vec<(u32, u32, bool)>,
    pub proxies: Proxies,
    pub narrow: Vec<Part>,
    /// Of the contacts as they were at the end of the last step, at the same places; empty if that is not known.
    pub links: Vec<Link>,
    /// What they were judged by.
    pub judge: Option<Judge>,
    /// A body slept when contacts were looked at, and does no longer.
    pub has_woken: bool,
    pub joint_links: JointLinks,
    pub joint_errors: JointErrors,
    pub joint_sums: Vec<JointErrors>,
    /// Of each body slot, as edited where there is no body; empty if bodies went since.
    pub roles: Vec<Role>,
    pub contact_sums: Vec<ContactSums>,
    pub parents: Vec<u32>,
    pub awake_roots: Vec<bool>,
    pub island_numbers: Vec<u32>,
    pub restless_islands: Vec<bool>,
    pub heights: Vec<u32>,
    pub height: height::Scratch,
    pub stillness: Stillness,
    /// Away for the length of a step.
    pub plan: Option<Box<Plan>>,
}

/// Of the joints that a step solves.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct JointErrors {
    pub joints: usize,
    /// m
    pub greatest: f32,
}

impl JointErrors {
    pub fn add(&mut self, anchor_error: f32) {
        self.joints += 1;
        self.greatest = self.greatest.max(anchor_error);
    }
}

impl std::ops::AddAssign for JointErrors {
    fn add_assign(&mut self, other: Self) {
        self.joints += other.joints;
        self.greatest = self.greatest.max(other.greatest);
    }
}

impl World {
    /// Advances by `dt` seconds. Never fails: the report says what happened.
    ///
    /// ```
    /// use ishigaki::{Body, Shape, Vec3, World};
    /// let mut world = World::default();
    /// let ball = world.add_body(Body::dynamic(Shape::ball(0.5)).at(Vec3::Y * 10.0))?;
    /// let report = world.step(1.0 / 60.0);
    /// assert_eq!(report.bodies, 1);
    /// assert!(world.body(ball).unwrap().velocity().y < 0.0);
    /// # Ok::<(), ishigaki::Error>(())
    /// ```
    pub fn step(&mut self, dt: f32) -> StepReport {
        self.step_with(dt, &mut StepContext::default())
    }

    /// Whether one thread takes a step sooner than several would have met.
    fn is_few(&self) -> bool {
        let awake = match self.report.bodies {
            0 => self.bodies.len(),
            bodies => bodies - self.report.asleep,
        };
        awake < FEW
    }

    /// Advances by `dt` seconds with a clock for stage timings and a say in contacts.
    pub fn step_with(&mut self, dt: f32, context: &mut StepContext<'_>) -> StepReport {
        if self.is_still() && is_step(dt) {
            return self.stay(dt);
        }
        if !self.is_few() {
            let _awake = self.workers.wake();
            return self.take_stages(dt, context);
        }
        let workers = std::mem::take(&mut self.workers);
        let report = self.take_stages(dt, context);
        self.workers = workers;
        report
    }

    fn take_stages(&mut self, dt: f32, context: &mut StepContext<'_>) -> StepReport {
        let mut watch = Watch::start(context.clock.as_deref_mut());
        let mut plan = self.scratch.plan.take().unwrap_or_default();

        // ANCHOR: stages
        if self.begin(dt) {
            watch.lap(Stage::Begin);
            self.find_pairs(dt);
            watch.lap(Stage::FindPairs);
            self.update_contacts(dt, context.hooks.as_deref_mut());
            watch.lap(Stage::UpdateContacts);
            self.build_islands();
            watch.lap(Stage::BuildIslands);
            self.gather_forces(dt);
            watch.lap(Stage::GatherForces);
            self.build_rows(&mut plan, dt);
            watch.lap(Stage::BuildRows);
            plan::plan_sweep(&mut plan, &self.options.solver);
            watch.lap(Stage::PlanSweep);
            self.solve(&mut plan, dt);
            watch.lap(Stage::Solve);
            self.finish_motion(dt);
            watch.lap(Stage::FinishMotion);
            self.put_to_rest(dt);
            self.complete_report(&plan);
            self.notice_stillness();
            watch.lap(Stage::PutToRest);
        }
        // ANCHOR_END: stages

        self.scratch.plan = Some(plan);
        self.report.stage_seconds = watch.seconds;
        self.report.clone()
    }

    /// Forgets the last step; refuses a Δt that is no Δt; takes out bodies that are not finite, slows the too fast.
    pub(crate) fn begin(&mut self, dt: f32) -> bool {
        let mut residuals = std::mem::take(&mut self.report.residual_by_sweep);
        residuals.clear();
        self.report = StepReport { residual_by_sweep: residuals, ..StepReport::default() };
        self.scratch.joint_errors = JointErrors::default();
        clear_burst(&mut self.events);
        self.events.append(&mut self.pending_events);
        if !is_step(dt) {
            self.disturb();
            self.report.rejected =
                Some(format!("the step must be in [{SHORTEST_STEP:e}, {LONGEST_STEP:e}] s, is {dt:e}"));
            return false;
        }
        let sleeps = self.options.rest.sleep.enabled;
        let (max_speed, max_angular_speed) = self.speed_limits();
        let hears = &mut self.scratch.hears_forces;
        hears.clear();
        hears.resize(self.workers.parts(self.bodies.slot_count()), false);
        let stirs = &mut self.scratch.stirs;
        stirs.resize(self.bodies.slot_count(), false);
        self.workers.in_parts((self.bodies.all(), &mut stirs[..]), hears, |(bodies, stirs), hears_forces| {
            for (body, stirs) in bodies.objects_with(stirs, |_| true) {
                *hears_forces |= body.force_threshold.is_some();
                *stirs = false;
                if body.asleep && sleeps && !body.edited {
                    continue;
                }
                body.previous_pose = body.pose();
                body.broken = !(body.is_finite() && body.force.is_finite() && body.torque.is_finite());
                body.limit_speeds(max_speed, max_angular_speed);
                body.limit_forces(max_speed / dt, max_angular_speed / dt);
                if !sleeps && body.asleep {
                    body.wake();
                }
                *stirs = body.is_stirring();
            }
        });
        true
    }

    /// Velocities of kinematic bodies from their targets; gravity and user forces act in each substep.
    pub(crate) fn gather_forces(&mut self, dt: f32) {
        for slot in kinematic(&self.scratch.roles) {
            self.bodies.at_mut(slot).aim_at_target(dt);
        }
    }

    /// m/s and rad/s.
    fn speed_limits(&self) -> (f32, f32) {
        let (motion, root) = (&self.options.motion, self.options.length_scale.sqrt());
        (motion.max_speed * root, motion.max_angular_speed / root)
    }

    /// Exact poses of kinematic bodies, stops at walls.
    fn finish_motion(&mut self, dt: f32) {
        self.stop_at_walls();
        for slot in kinematic(&self.scratch.roles) {
            self.bodies.at_mut(slot).reach_target();
        }
        self.hold_bounds();
        self.pass_time(dt);
    }

    pub(crate) fn pass_time(&mut self, dt: f32) {
        self.time += f64::from(dt);
        self.step_count = self.step_count.saturating_add(1);
    }

    fn put_to_rest(&mut self, dt: f32) {
        let (rest, scale) = (&self.options.rest, self.options.length_scale);
        let enough = sleep::enough_time(&rest.sleep, scale);
        let whole = (self.bodies.all(), &mut self.scratch.roles[..]);
        let mut no_outputs = self.workers.no_outputs(whole.1.len());
        self.workers.in_parts(whole, &mut no_outputs, |(bodies, roles), ()| {
            for (body, role) in bodies.objects_with(roles, |role| !role.sleeps()) {
                if body.edited {
                    body.edited = false;
                }
                if !body.asleep {
                    (body.force, body.torque) = (Vec3::ZERO, Vec3::ZERO);
                }
                if body.is_active() {
                    body.forget_dust();
                    sleep::count_rest_time(body, &rest.sleep, scale, dt);
                    aggressive_sleep::count_rest_steps(body, &rest.aggressive_sleep, scale);
                    role.restless = body.rest_time < enough;
                }
            }
        });
        let restless = &mut self.scratch.restless_islands;
        restless.clear();
        restless.resize(self.report.islands, false);
        for role in self.scratch.roles.iter().filter(|role| role.restless) {
            restless[role.island as usize] = true;
        }
        if rest.sleep.enabled {
            self.put_islands_to_sleep();
        }
        self.tell_impacts();
        self.break_joints();
        self.notice_forces(dt);
    }
}

fn is_step(dt: f32) -> bool {
    (SHORTEST_STEP..=LONGEST_STEP).contains(&dt)
}

/// Slots of the bodies that their users move.
fn kinematic(roles: &[Role]) -> impl Iterator<Item = u32> {
    (0..).zip(roles).filter(|(_, role)| role.kinematic).map(|(slot, _)| slot)
}

/// Laps between stages on the caller's clock.
struct Watch<'a, 'b> {
    clock: Option<&'a mut (dyn FnMut() -> f64 + 'b)>,
    last: f64,
    seconds: [f64; 10],
}

impl<'a, 'b> Watch<'a, 'b> {
    fn start(mut clock: Option<&'a mut (dyn FnMut() -> f64 + 'b)>) -> Self {
        let last = clock.as_mut().map_or(0.0, |read| read());
        Self { clock, last, seconds: [0.0; 10] }
    }

    fn lap(&mut self, stage: Stage) {
        if let Some(clock) = &mut self.clock {
            let now = clock();
            self.seconds[stage as usize] = now - self.last;
            self.last = now;
        }
    }
}
