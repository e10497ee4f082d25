//! From a tree of links to a scene: welded links merged, poses composed, coordinates made joints.
//!
//! Exact where the engine allows it: a link that cannot move relative to its parent becomes part of the parent's body
//! (shapes and inertia by parallel axes) instead of being held by a joint that could give.

use super::contact::{Exceptions, groups, materials};
use super::inertia::Inertia;
use super::stage::stages;
use super::tree::{Link, Motion, Piece, Surface, Tree, pose, pose32, vec32};
use super::{ImportOptions, lowest};
use crate::error::SceneError;
use crate::file::{BodyFile, BodyRef, FrameFile, FramesFile, JointFile, SceneFile};
use glamx::{DPose3, DQuat, DVec3};
use ishigaki::{Body, BodyKind, Geometry, JointKind, MassProperties, MassSource, Pose, Shape, WorldOptions};
use std::collections::{BTreeMap, BTreeSet};

/// Part of a body's mass that goes to each light body between it and its parent.
const LIGHT: f64 = 0.05;
/// Least radius of gyration of a body, m: below it the inertia is taken as missing.
const LEAST_GYRATION: f64 = 1e-3;
/// What a link that moves but has no mass is given: kg, and m of gyration.
const MISSING_MASS: (f64, f64) = (0.01, 0.01);

pub(crate) fn assemble(
    tree: &Tree,
    options: &ImportOptions,
    warnings: &mut Vec<String>,
) -> Result<SceneFile, SceneError> {
    let places = Places::of(tree);
    let mut assembly = Assembly {
        tree,
        places: &places,
        scene: SceneFile::default(),
        body_of: BTreeMap::new(),
        excluded: BTreeSet::new(),
        warnings,
    };
    assembly.scene.name.clone_from(&tree.name);
    assembly.scene.dt = tree.timestep as f32;
    assembly.scene.options = WorldOptions { gravity: vec32(tree.gravity), ..WorldOptions::default() };
    let shapes = assembly.shapes(options);
    assembly.bodies(&shapes)?;
    assembly.joints()?;
    assembly.loops()?;
    assembly.exclude();
    if let Some(ground) = shapes.ground {
        assembly.scene.bodies.push((&Body::fixed(ground).named("ground")).into());
    }
    Ok(assembly.scene)
}

/// Where each link is and whose body it is part of.
struct Places {
    /// The link whose body this one is part of.
    root: Vec<usize>,
    root_from_link: Vec<DPose3>,
    world_from_link: Vec<DPose3>,
    fixed: Vec<bool>,
    /// The links whose body is a root's, itself first.
    members: Vec<Vec<usize>>,
}

impl Places {
    fn of(tree: &Tree) -> Self {
        let count = tree.links.len();
        let mut places = Self {
            root: (0..count).collect(),
            root_from_link: vec![DPose3::IDENTITY; count],
            world_from_link: vec![DPose3::IDENTITY; count],
            fixed: vec![false; count],
            members: vec![Vec::new(); count],
        };
        for (i, link) in tree.links.iter().enumerate() {
            let parent = link.parent;
            let at_root = i == 0;
            places.world_from_link[i] = if at_root { link.pose } else { places.world_from_link[parent] * link.pose };
            if at_root {
                places.fixed[i] = matches!(link.motion, Motion::Welded);
                continue;
            }
            if !matches!(link.motion, Motion::Welded) {
                continue;
            }
            places.fixed[i] = places.fixed[parent];
            if !places.fixed[i] || tree.rules.merge_fixed {
                places.root[i] = places.root[parent];
                places.root_from_link[i] = places.root_from_link[parent] * link.pose;
            }
        }
        for i in 0..count {
            places.members[places.root[i]].push(i);
        }
        places
    }
}

/// The engine's shapes by link.
struct Shapes {
    of_link: Vec<Vec<Shape>>,
    ground: Option<Shape>,
}

struct Assembly<'a> {
    tree: &'a Tree,
    places: &'a Places,
    scene: SceneFile,
    /// Index in the scene of the body of a root link.
    body_of: BTreeMap<usize, usize>,
    /// By index in the scene, smaller first.
    excluded: BTreeSet<(usize, usize)>,
    warnings: &'a mut Vec<String>,
}

impl Assembly<'_> {
    fn root_members(&self, root: usize) -> impl Iterator<Item = (usize, &Link)> {
        self.places.members[root].iter().map(|&i| (i, &self.tree.links[i]))
    }

    /// Shapes with their groups and materials.
    fn shapes(&mut self, options: &ImportOptions) -> Shapes {
        let links = &self.tree.links;
        let floor = self.ground(options);
        let mut pieces: Vec<&Piece> = links.iter().flat_map(|l| &l.pieces).collect();
        pieces.extend(&floor);
        let (groups, exact) = groups(&pieces, &self.exceptions());
        if !exact {
            let message =
                "contact filters: more than 32 kinds of shapes; the last of them touch more than the file says";
            self.warnings.push(message.into());
        }
        let (materials, inexact) = materials(&pieces);
        self.warnings.extend(inexact);
        let mut made = pieces.iter().zip(groups).zip(materials).map(|((piece, groups), material)| {
            let mut shape = Shape::new(piece.geometry.clone()).posed(pose32(piece.pose)).material(material);
            shape.groups = groups;
            shape
        });
        let of_link = links.iter().map(|l| made.by_ref().take(l.pieces.len()).collect()).collect();
        Shapes { of_link, ground: made.next() }
    }

    /// A floor under the lowest point of the model, unless it has one.
    fn ground(&self, options: &ImportOptions) -> Option<Piece> {
        let all = || self.tree.links.iter().enumerate().flat_map(|(i, l)| l.pieces.iter().map(move |p| (i, p)));
        if !options.ground || all().any(|(_, p)| matches!(p.geometry, Geometry::HalfSpace { .. })) {
            return None;
        }
        let up = (-self.tree.gravity).try_normalize().unwrap_or(DVec3::Z);
        let heights = all().filter_map(|(i, p)| lowest(&p.geometry, self.places.world_from_link[i] * p.pose, up));
        let lowest = heights.fold(f64::INFINITY, f64::min);
        let height = if lowest.is_finite() { lowest } else { 0.0 };
        let surface = Surface {
            contype: u32::MAX,
            conaffinity: u32::MAX,
            condim: 3,
            priority: 0,
            friction: [self.tree.rules.ground_friction, 0.0, 0.0],
        };
        Some(Piece {
            id: usize::MAX,
            geometry: Geometry::HalfSpace { normal: vec32(up) },
            pose: pose(up * height, DQuat::IDENTITY),
            surface,
        })
    }

    /// Exclusions of links that are only a part of a body go by shape; the others by body.
    fn exceptions(&self) -> Exceptions {
        let key = |a: usize, b: usize| (a.min(b), a.max(b));
        let mut exceptions = Exceptions::default();
        for &[a, b] in &self.tree.excluded {
            if self.whole(a) && self.whole(b) {
                continue;
            }
            for p in &self.tree.links[a].pieces {
                exceptions.never.extend(self.tree.links[b].pieces.iter().map(|q| key(p.id, q.id)));
            }
        }
        exceptions.always.extend(self.tree.pairs.iter().map(|&[a, b]| key(a, b)));
        exceptions
    }

    /// Whether all shapes of a link's body are the link's.
    fn whole(&self, link: usize) -> bool {
        self.root_members(self.places.root[link]).all(|(i, l)| i == link || l.pieces.is_empty())
    }

    fn bodies(&mut self, shapes: &Shapes) -> Result<(), SceneError> {
        for root in 0..self.tree.links.len() {
            if self.places.root[root] != root {
                continue;
            }
            let mut body = Body::empty(BodyKind::Fixed);
            let mut inertia = Inertia::ZERO;
            let mut weight = 0.0;
            for (i, link) in self.root_members(root) {
                let root_from_link = self.places.root_from_link[i];
                let part = link.inertia.transformed(root_from_link);
                inertia = if inertia == Inertia::ZERO { part } else { inertia.merged(&part) };
                weight += link.inertia.mass * link.gravity_scale;
                for (shape, piece) in shapes.of_link[i].iter().zip(&link.pieces) {
                    body.shapes.push(shape.clone().posed(pose32(root_from_link * piece.pose)));
                }
            }
            let link = &self.tree.links[root];
            // A place that cannot move and has no shape is made when a joint needs it.
            if self.places.fixed[root] && body.shapes.is_empty() {
                continue;
            }
            body.name.clone_from(&link.name);
            body.pose = pose32(self.places.world_from_link[root]);
            match &link.motion {
                _ if self.places.fixed[root] => {}
                Motion::Kinematic => body.kind = BodyKind::Kinematic,
                motion => {
                    body.kind = BodyKind::Dynamic;
                    let inertia = self.moving(link, inertia)?;
                    body.gravity_scale = if weight == 0.0 { 1.0 } else { (weight / inertia.mass) as f32 };
                    if weight == 0.0 && link.gravity_scale == 0.0 {
                        body.gravity_scale = 0.0;
                    }
                    if let Motion::Free { damping } = motion {
                        self.free_damping(link, *damping, &inertia, &mut body);
                    }
                    self.light_bodies(root, &inertia, &mut body)?;
                }
            }
            body.validate().map_err(|e| SceneError::from_engine(&link.place, e))?;
            self.body_of.insert(root, self.scene.bodies.len());
            self.scene.bodies.push(BodyFile::from(&body));
        }
        Ok(())
    }

    /// The inertia of a body that moves, mended or refused if no body has it.
    fn moving(&mut self, link: &Link, mut inertia: Inertia) -> Result<Inertia, SceneError> {
        let mend = self.tree.rules.mend_inertia;
        let mut warn = |message: String| self.warnings.push(format!("{}: {message}", link.place));
        let numbers = inertia.matrix.to_cols_array();
        if !(inertia.mass.is_finite() && inertia.center.is_finite() && numbers.iter().all(|x| x.is_finite())) {
            return Err(link.error("mass or inertia is too large to compute with"));
        }
        if inertia.mass <= 0.0 {
            if !mend {
                return Err(link.error("moves but has no mass: give it an <inertial> or geoms with density or mass"));
            }
            let (mass, gyration) = MISSING_MASS;
            warn(format!("moves but has no mass: {mass} kg within {gyration} m assumed"));
            inertia = Inertia::diagonal(mass, DVec3::splat(mass * gyration * gyration));
        }
        let (mut moments, axes) = inertia.principal();
        let least = inertia.mass * LEAST_GYRATION * LEAST_GYRATION;
        let before = moments;
        if moments.min_element() < -1e-9 * moments.max_element().abs() - 1e-30 {
            let message = format!("the inertia has a negative principal moment: {moments}");
            if !mend {
                return Err(link.error(message));
            }
            warn(format!("{message}: raised"));
        }
        // Points and needles: MuJoCo refuses zero; a body of 1 mm is as good as a point.
        if moments.min_element() <= 1e-6 * least {
            moments = moments.max(DVec3::splat(least));
            warn(format!("the inertia ({before}) is (nearly) zero: moments raised to {least:e} kg·m²"));
        }
        let sum = moments.element_sum();
        let greatest = moments.max_element();
        if 2.0 * greatest > 1.009 * sum {
            if !mend {
                let message = "no body has this inertia: a principal moment is greater than the sum of the others; correct it or set <compiler balanceinertia=\"true\"/>";
                return Err(link.error(message));
            }
            // The two smaller ones share what is missing.
            let missing = 0.5 * (2.0 * greatest - sum);
            let raised = DVec3::from_array(moments.to_array().map(|m| if m == greatest { m } else { m + missing }));
            warn(format!("no body has the moments {moments}: the smaller ones raised to {raised}"));
            moments = raised;
        }
        if moments != before {
            inertia = inertia.with_moments(moments, axes);
        }
        Ok(inertia)
    }

    fn free_damping(&mut self, link: &Link, damping: f64, inertia: &Inertia, body: &mut Body) {
        if damping <= 0.0 {
            return;
        }
        let mean = inertia.principal().0.element_sum() / 3.0;
        body.linear_damping = (damping / inertia.mass) as f32;
        body.angular_damping = (damping / mean) as f32;
        self.warnings.push(format!(
            "{}: damping of the free joint becomes the body's: exact for its velocity, for the mean moment of inertia else",
            link.place
        ));
    }

    /// Gives the body its mass, less what the light bodies between it and its parent take.
    fn light_bodies(&mut self, root: usize, inertia: &Inertia, body: &mut Body) -> Result<(), SceneError> {
        let link = &self.tree.links[root];
        let count = match &link.motion {
            Motion::Joints(coordinates) => stages(coordinates).len().saturating_sub(1),
            _ => 0,
        };
        for i in 0..count {
            let mut light = Body::empty(BodyKind::Dynamic).named(format!("{}/{}", link.name, i + 1)).posed(body.pose);
            light.mass = explicit(&inertia.scaled(LIGHT));
            light.gravity_scale = body.gravity_scale;
            light.validate().map_err(|e| SceneError::from_engine(&link.place, e))?;
            self.scene.bodies.push(BodyFile::from(&light));
        }
        body.mass = explicit(&inertia.scaled(1.0 - LIGHT * count as f64));
        if count > 0 {
            self.warnings.push(format!(
                "{}: its joints do not fit into one (different anchors, or more than three axes): {count} light bodies with {} % of its mass each stand between them",
                link.place,
                LIGHT * 100.0
            ));
        }
        Ok(())
    }

    fn joints(&mut self) -> Result<(), SceneError> {
        for (i, link) in self.tree.links.iter().enumerate() {
            let parent = self.places.root[link.parent];
            let fixed_parent = self.places.fixed[parent];
            let excluded =
                if fixed_parent { self.tree.rules.exclude_fixed_parent } else { self.tree.rules.exclude_parent };
            match &link.motion {
                Motion::Joints(coordinates) => {
                    let a = self.body_at(parent);
                    let b = self.body_at(i);
                    let stages = stages(coordinates);
                    let count = stages.len();
                    for (k, stage) in stages.iter().enumerate() {
                        let (frame, kind) = stage.joint(self.places.world_from_link[i]);
                        // Light bodies stand right before their body.
                        let first = if k == 0 { a } else { b - (count - k) };
                        let second = b - (count - 1 - k);
                        let collide = !excluded || count > 1;
                        self.push_joint(&link.place, stage.name(), [first, second], pose32(frame), &kind, collide)?;
                    }
                    if excluded && count > 1 {
                        self.excluded.insert((a.min(b), a.max(b)));
                    }
                }
                Motion::Free { .. } if excluded && i != 0 && !fixed_parent => {
                    let (a, b) = (self.body_at(parent), self.body_at(i));
                    self.excluded.insert((a.min(b), a.max(b)));
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// The body of a root link; a fixed one without shapes is made now.
    fn body_at(&mut self, root: usize) -> usize {
        let root = if self.places.fixed[root] && !self.body_of.contains_key(&root) { 0 } else { root };
        if let Some(&body) = self.body_of.get(&root) {
            return body;
        }
        let mut body = Body::empty(BodyKind::Fixed).named(&self.tree.links[root].name);
        body.pose = pose32(self.places.world_from_link[root]);
        self.scene.bodies.push(BodyFile::from(&body));
        self.body_of.insert(root, self.scene.bodies.len() - 1);
        self.scene.bodies.len() - 1
    }

    fn push_joint(
        &mut self,
        place: &str,
        name: String,
        bodies: [usize; 2],
        frame: Pose,
        kind: &JointKind,
        collide: bool,
    ) -> Result<(), SceneError> {
        // The engine checks a joint's numbers only together with handles: any two different ones will do.
        let handles = [ishigaki::BodyHandle::from((0, 0)), ishigaki::BodyHandle::from((1, 0))];
        let definition = ishigaki::Joint::new(handles[0], handles[1], kind.clone(), frame);
        definition.validate().map_err(|e| SceneError::from_engine(place, e))?;
        self.scene.joints.push(JointFile {
            name,
            body_a: BodyRef::Index(bodies[0]),
            body_b: BodyRef::Index(bodies[1]),
            kind: kind.into(),
            frame: FramesFile::World(FrameFile::from(frame)),
            collide,
            break_force: None,
            break_torque: None,
        });
        Ok(())
    }

    fn loops(&mut self) -> Result<(), SceneError> {
        for joint in &self.tree.loops {
            let roots = joint.links.map(|l| self.places.root[l]);
            let place = format!("equality `{}`", joint.name);
            if roots[0] == roots[1] || roots.iter().all(|&r| self.places.fixed[r]) {
                self.warnings.push(format!("{place}: its two bodies cannot move relative to each other: left out"));
                continue;
            }
            let frames = [0, 1].map(|k| self.places.root_from_link[joint.links[k]] * joint.frames[k]);
            let bodies = roots.map(|r| self.body_at(r));
            let kind = if joint.ball {
                JointKind::Ball { cone: None, twist: None, friction: 0.0, damping: 0.0 }
            } else {
                JointKind::Fixed
            };
            // `body_at` may have taken the world for a fixed link without shapes: go through the world's frame.
            let local = |k: usize| {
                let world = self.places.world_from_link[roots[k]] * frames[k];
                let body = &self.scene.bodies[bodies[k]];
                let at = Pose::from_parts(body.position, body.rotation);
                FrameFile::from(at.inverse() * pose32(world))
            };
            let frame = FramesFile::Local { a: local(0), b: local(1) };
            self.scene.joints.push(JointFile {
                name: joint.name.clone(),
                body_a: BodyRef::Index(bodies[0]),
                body_b: BodyRef::Index(bodies[1]),
                kind: (&kind).into(),
                frame,
                collide: true,
                break_force: None,
                break_torque: None,
            });
        }
        Ok(())
    }

    fn exclude(&mut self) {
        for &[a, b] in &self.tree.excluded {
            let roots = [a, b].map(|l| self.places.root[l]);
            if !(self.whole(a) && self.whole(b)) || roots[0] == roots[1] {
                continue;
            }
            if let (Some(&a), Some(&b)) = (self.body_of.get(&roots[0]), self.body_of.get(&roots[1])) {
                self.excluded.insert((a.min(b), a.max(b)));
            }
        }
        let pairs = self.excluded.iter().map(|&(a, b)| [BodyRef::Index(a), BodyRef::Index(b)]);
        self.scene.excluded_pairs = pairs.collect();
    }
}

fn explicit(inertia: &Inertia) -> MassSource {
    let (moments, axes) = inertia.principal();
    MassSource::Explicit(MassProperties {
        mass: inertia.mass as f32,
        center: vec32(inertia.center),
        principal_inertia: vec32(moments),
        principal_frame: super::tree::quat32(axes),
    })
}
