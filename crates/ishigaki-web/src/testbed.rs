//! A scene that runs: stepping, options, the mouse, snapshots.

use ishigaki::{Body, BodyHandle, BodyKind, QueryFilter, Shape, StepContext, StepReport, Vec3, World};
use ishigaki_recording::About;
use ishigaki_scenes::models::{self, ImportOptions};
use ishigaki_scenes::{Result, Scene, SceneError, SceneFile, named, set_option};

/// Numbers of a pose: position (m), then the quaternion x, y, z, w.
pub const POSE_STRIDE: usize = 7;
/// Numbers that color a body: state, height, island, speed; see [`Testbed::write_states`].
pub const BODY_STRIDE: usize = 4;

/// Natural frequency of the spring between mouse and body, rad/s: firm, and stable at 1/60 s even at a box's corner.
const GRAB_FREQUENCY: f32 = 8.0;

/// Where a scene comes from.
#[derive(Clone, Debug)]
pub enum Source {
    /// A named scene with its parameters.
    Named(String, Vec<(String, f64)>),
    /// A file: its name and its text; JSON, MJCF or URDF.
    File(String, String),
}

/// A body held by the mouse.
#[derive(Clone, Copy, Debug)]
struct Grab {
    body: BodyHandle,
    /// In the body's frame, m.
    anchor_local: Vec3,
    /// World, m.
    target: Vec3,
}

/// A scene that runs.
#[derive(Clone, Debug)]
pub struct Testbed {
    file: SceneFile,
    scene: Scene,
    warnings: Vec<String>,
    grab: Option<Grab>,
    geometry_version: u32,
}

impl Testbed {
    /// Builds the scene.
    ///
    /// # Errors
    /// What the scene or the file cannot mean, with its place.
    pub fn new(source: &Source) -> Result<Self> {
        let (file, warnings) = match source {
            Source::Named(name, parameters) => (named(name, parameters)?, Vec::new()),
            Source::File(name, text) => read_file(name, text)?,
        };
        let scene = file.build()?;
        Ok(Self { file, scene, warnings, grab: None, geometry_version: 0 })
    }

    /// What an importer could not take over.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// The scene as it was built.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The scene as a file.
    pub fn file(&self) -> &SceneFile {
        &self.file
    }

    /// As it is now.
    pub fn world(&self) -> &World {
        &self.scene.world
    }

    /// Bodies, shapes and joints, as a recording describes them.
    pub fn description(&self) -> ishigaki_recording::Scene {
        let about = About { name: self.scene.name.clone(), dt: self.scene.dt, every: 1, contacts: false, camera: None };
        ishigaki_recording::Scene::describe(self.world(), &about)
    }

    /// Raised whenever bodies come or go, so that shapes must be asked for anew.
    pub fn geometry_version(&self) -> u32 {
        self.geometry_version
    }

    /// Back to the start, with the options that are set now.
    ///
    /// # Errors
    /// What a scene with these options cannot mean.
    pub fn reset(&mut self) -> Result<()> {
        let options = self.world().options().clone();
        self.file.options = options;
        self.scene = self.file.build()?;
        self.changed();
        Ok(())
    }

    /// Sets an option by its path; bodies wake.
    ///
    /// # Errors
    /// A path that does not exist, a value that does not fit; nothing changes.
    pub fn set_option(&mut self, path: &str, value: &str) -> Result<()> {
        let mut options = self.world().options().clone();
        set_option(&mut options, path, value)?;
        self.scene.world.set_options(options).map_err(|e| SceneError::from_engine("", e))
    }

    /// One step; `clock` gives seconds.
    pub fn step(&mut self, dt: f32, clock: &mut dyn FnMut() -> f64) -> StepReport {
        self.pull();
        let bodies = self.world().bodies().count();
        let report = self.scene.world.step_with(dt, &mut StepContext { clock: Some(clock), ..StepContext::default() });
        if self.world().bodies().count() != bodies {
            self.changed();
        }
        report
    }

    /// The dynamic body that a ray meets first: its place in the list of bodies, and where.
    pub fn pick(&self, origin: Vec3, direction: Vec3) -> Option<(usize, Vec3)> {
        // Whatever is in front hides what is behind.
        let hit = self.world().cast_ray(origin, direction, f32::MAX, &QueryFilter::new())?;
        let place = self.world().bodies().position(|(handle, _)| handle == hit.shape.body)?;
        let dynamic = self.world().body(hit.shape.body)?.kind() == BodyKind::Dynamic;
        dynamic.then_some((place, hit.point))
    }

    /// Holds a body at a world point with a spring; `false` if there is no such dynamic body.
    pub fn grab(&mut self, place: usize, point: Vec3) -> bool {
        let body = self.world().bodies().nth(place).filter(|(_, body)| body.kind() == BodyKind::Dynamic);
        let grab = body.map(|(body, state)| Grab { body, anchor_local: state.pose().inverse() * point, target: point });
        self.grab = grab;
        self.grab.is_some()
    }

    /// Moves the end of the spring, world, m.
    pub fn drag(&mut self, target: Vec3) {
        if let Some(grab) = &mut self.grab
            && target.is_finite()
        {
            grab.target = target;
        }
    }

    /// Lets go; the body keeps its velocity.
    pub fn release(&mut self) {
        self.grab = None;
    }

    /// The point that is held and where it is pulled to, world, m.
    pub fn grabbed(&self) -> Option<(Vec3, Vec3)> {
        let grab = self.grab?;
        Some((self.world().body(grab.body)?.pose() * grab.anchor_local, grab.target))
    }

    /// A spring with critical damping on the point that is held: F = m (ω² (target − p) − 2 ω v) − m g.
    fn pull(&mut self) {
        let Some(grab) = self.grab else { return };
        let gravity = self.world().options().gravity;
        let Some(mut body) = self.scene.world.body_mut(grab.body) else {
            self.grab = None;
            return;
        };
        let state = body.state();
        let point = state.pose() * grab.anchor_local;
        let velocity = state.velocity_at(point);
        let omega = GRAB_FREQUENCY;
        let acceleration = omega * omega * (grab.target - point) - 2.0 * omega * velocity - gravity;
        let force = state.mass() * acceleration;
        // A body that spins about the point it is held by would do so forever.
        let spin = -state.angular_momentum() * omega * 0.5;
        // Only a body whose numbers ran away refuses; the report names it.
        let _ = body.apply_force_at(force, point);
        let _ = body.apply_torque(spin);
    }

    /// Throws a ball of a density, kg/m³, that cannot pass through anything.
    ///
    /// # Errors
    /// Numbers that make no sense.
    pub fn shoot(&mut self, origin: Vec3, velocity: Vec3, radius: f32, density: f32) -> Result<()> {
        let ball = Body::dynamic(Shape::ball(radius)).density(density).at(origin).velocity(velocity).continuous();
        self.scene.world.add_body(ball.named("shot")).map_err(|e| SceneError::from_engine("ball", e))?;
        self.changed();
        Ok(())
    }

    /// The whole state.
    pub fn snapshot(&self) -> Vec<u8> {
        self.world().snapshot()
    }

    /// Continues from a snapshot, bit for bit.
    ///
    /// # Errors
    /// Bytes that are no snapshot of this version.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<()> {
        self.scene.world = World::restore(bytes).map_err(|e| SceneError::from_engine("", e))?;
        self.changed();
        Ok(())
    }

    fn changed(&mut self) {
        self.grab = None;
        self.geometry_version = self.geometry_version.wrapping_add(1);
    }

    /// [`POSE_STRIDE`] numbers for each body, in slot order.
    pub fn write_poses(&self, out: &mut Vec<f32>) {
        out.clear();
        for (_, body) in self.world().bodies() {
            let pose = body.pose();
            out.extend(pose.translation.to_array());
            out.extend(pose.rotation.to_array());
        }
    }

    /// [`BODY_STRIDE`] numbers for each body, in slot order: state (0 fixed, 1 kinematic, 2 awake, 3 asleep, 4 with a
    /// pair frozen by aggressive sleep), height in hops (−1 without), island, speed in m/s.
    pub fn write_states(&self, out: &mut Vec<f32>) {
        let slots = self.world().bodies().map(|(handle, _)| handle.index() + 1).max().unwrap_or(0);
        let mut frozen = vec![false; slots];
        for contact in self.world().contacts().filter(|c| c.frozen) {
            frozen[contact.a.body.index()] = true;
            frozen[contact.b.body.index()] = true;
        }
        out.clear();
        for (handle, body) in self.world().bodies() {
            let state = match body.kind() {
                BodyKind::Fixed => 0.0,
                BodyKind::Kinematic => 1.0,
                BodyKind::Dynamic if body.is_asleep() => 3.0,
                BodyKind::Dynamic if frozen[handle.index()] => 4.0,
                BodyKind::Dynamic => 2.0,
            };
            let height = body.height().map_or(-1.0, |h| h as f32);
            out.extend([state, height, body.island() as f32, body.velocity().length()]);
        }
    }
}

fn read_file(name: &str, text: &str) -> Result<(SceneFile, Vec<String>)> {
    if text.trim_start().starts_with('<') {
        let options = ImportOptions { ground: true, ..ImportOptions::default() };
        let import = models::import_text(name, text, std::path::Path::new("."), &options)?;
        return Ok((import.scene, import.warnings));
    }
    Ok((SceneFile::from_json(text, name)?, Vec::new()))
}
