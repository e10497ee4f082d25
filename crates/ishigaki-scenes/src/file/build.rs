//! From a scene file to a world.

use super::shape::Shared;
use super::{BodyRef, CameraFile, JointFile, SceneFile};
use crate::error::{Result, SceneError, unknown};
use ishigaki::{BodyHandle, Joint, JointHandle, World};
use std::collections::BTreeMap;

/// A world with the names of its parts.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Ready to step.
    pub world: World,
    /// Names and handles in the file's order; a body without a name is called `body3` after its place.
    pub bodies: Vec<(String, BodyHandle)>,
    /// Names and handles in the file's order; a joint without a name is called `joint3` after its place.
    pub joints: Vec<(String, JointHandle)>,
    /// Suggested length of a step, s.
    pub dt: f32,
    /// Suggested number of steps.
    pub steps: u32,
    /// The scene's name.
    pub name: String,
    /// What it shows.
    pub description: String,
    /// Where a viewer should look from.
    pub camera: Option<CameraFile>,
}

impl Scene {
    /// The first body of a name.
    pub fn body(&self, name: &str) -> Option<BodyHandle> {
        self.bodies.iter().find(|(n, _)| n == name).map(|&(_, handle)| handle)
    }

    /// The first joint of a name.
    pub fn joint(&self, name: &str) -> Option<JointHandle> {
        self.joints.iter().find(|(n, _)| n == name).map(|&(_, handle)| handle)
    }
}

impl SceneFile {
    /// Makes the world.
    ///
    /// # Errors
    /// The first definition that makes no sense, with its path: a number the engine refuses, a reference to a body,
    /// hull or mesh that is not there or whose name is not unique.
    pub fn build(&self) -> Result<Scene> {
        if !(self.dt.is_finite() && self.dt > 0.0) {
            return Err(SceneError::invalid("dt", format!("must be finite and > 0, is {}", self.dt)));
        }
        self.options.validate().map_err(|e| SceneError::from_engine("", e.within("options")))?;
        let mut world =
            World::new(self.options.clone()).map_err(|e| SceneError::from_engine("", e.within("options")))?;
        let bodies = self.build_bodies(&mut world)?;
        let names = Names::new(&bodies);
        let mut joints = Vec::with_capacity(self.joints.len());
        for (i, joint) in self.joints.iter().enumerate() {
            let name = name_or("joint", &joint.name, i);
            let place = titled("joints", &joint.name, i);
            joints.push((name.clone(), add_joint(&mut world, joint, name, &place, &names)?));
        }
        for (i, pair) in self.excluded_pairs.iter().enumerate() {
            self.exclude(&mut world, pair, &format!("excluded_pairs[{i}]"), &names)?;
        }
        Ok(Scene {
            world,
            bodies,
            joints,
            dt: self.dt,
            steps: self.steps,
            name: self.name.clone(),
            description: self.description.clone(),
            camera: self.camera,
        })
    }

    fn build_bodies(&self, world: &mut World) -> Result<Vec<(String, BodyHandle)>> {
        let shared = Shared::new(&self.hulls, &self.meshes)?;
        let mut bodies = Vec::with_capacity(self.bodies.len());
        for (i, body) in self.bodies.iter().enumerate() {
            let name = name_or("body", &body.name, i);
            let place = titled("bodies", &body.name, i);
            let refuse = |e| SceneError::from_engine(&place, e);
            let definition = body.build(&name, &shared).map_err(refuse)?;
            let handle = world.add_body(definition).map_err(refuse)?;
            if let Some(force) = body.force_threshold {
                if !(force.is_finite() && force >= 0.0) {
                    let message = format!("must be finite and ≥ 0, is {force}");
                    return Err(SceneError::invalid(format!("{place}: force_threshold"), message));
                }
                world.set_force_threshold(handle, Some(force));
            }
            bodies.push((name, handle));
        }
        Ok(bodies)
    }

    fn exclude(&self, world: &mut World, pair: &[BodyRef; 2], place: &str, names: &Names) -> Result<()> {
        let a = names.find(&pair[0], &format!("{place}[0]"))?;
        let b = names.find(&pair[1], &format!("{place}[1]"))?;
        if a == b {
            return Err(SceneError::invalid(place, "names one body twice: a pair has two bodies"));
        }
        world.exclude_pair(a, b).map_err(|e| SceneError::from_engine(place, e))
    }
}

fn add_joint(world: &mut World, joint: &JointFile, name: String, place: &str, names: &Names) -> Result<JointHandle> {
    let body_a = names.find(&joint.body_a, &format!("{place}: body_a"))?;
    let body_b = names.find(&joint.body_b, &format!("{place}: body_b"))?;
    let refuse = |e| SceneError::from_engine(place, without_drive(e));
    let definition = Joint {
        name,
        body_a,
        body_b,
        kind: (&joint.kind).into(),
        frames: joint.frame.build().map_err(refuse)?,
        collide: joint.collide,
        break_force: joint.break_force,
        break_torque: joint.break_torque,
    };
    world.add_joint(definition).map_err(refuse)
}

/// The file has a hinge's limit, motor and spring in the hinge itself, not in its `drive`.
fn without_drive(error: ishigaki::Error) -> ishigaki::Error {
    match error {
        ishigaki::Error::Invalid { place, message } => {
            let place = place.strip_prefix("drive.").unwrap_or(&place).to_string();
            ishigaki::Error::Invalid { place, message }
        }
        other => other,
    }
}

fn name_or(what: &str, name: &str, index: usize) -> String {
    if name.is_empty() { format!("{what}{index}") } else { name.to_string() }
}

/// `bodies[3] "brick"`.
fn titled(list: &str, name: &str, index: usize) -> String {
    if name.is_empty() { format!("{list}[{index}]") } else { format!("{list}[{index}] \"{name}\"") }
}

/// The bodies by name and by index.
struct Names<'a> {
    bodies: &'a [(String, BodyHandle)],
    /// The first two bodies of each name.
    by_name: BTreeMap<&'a str, (usize, Option<usize>)>,
}

impl<'a> Names<'a> {
    fn new(bodies: &'a [(String, BodyHandle)]) -> Self {
        let mut by_name: BTreeMap<&str, (usize, Option<usize>)> = BTreeMap::new();
        for (i, (name, _)) in bodies.iter().enumerate() {
            by_name.entry(name).and_modify(|(_, second)| _ = second.get_or_insert(i)).or_insert((i, None));
        }
        Self { bodies, by_name }
    }

    fn find(&self, body: &BodyRef, place: &str) -> Result<BodyHandle> {
        match body {
            BodyRef::Index(i) => self.bodies.get(*i).map(|b| b.1).ok_or_else(|| {
                let message =
                    format!("there is no body {i}: the scene has {} bodies, counted from 0", self.bodies.len());
                SceneError::invalid(place, message)
            }),
            BodyRef::Name(name) => match self.by_name.get(name.as_str()) {
                Some(&(i, None)) => Ok(self.bodies[i].1),
                Some(&(i, Some(j))) => {
                    let message = format!(
                        "the name `{name}` is shared by bodies[{i}] and bodies[{j}]: rename one or refer by index"
                    );
                    Err(SceneError::invalid(place, message))
                }
                None => Err(SceneError::invalid(place, self.unknown(name))),
            },
        }
    }

    fn unknown(&self, name: &str) -> String {
        // A scene may have thousands: name a few.
        let some: Vec<&str> = self.by_name.keys().copied().take(12).collect();
        let mut message = match crate::error::nearest(name, self.by_name.keys().copied()) {
            Some(near) => format!("unknown body `{name}`; did you mean `{near}`?"),
            None => unknown("body", name, some.iter().copied()),
        };
        if self.by_name.len() > some.len() && !message.ends_with('?') {
            message.push_str(", …");
        }
        message
    }
}
