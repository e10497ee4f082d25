//! MJCF, MuJoCo's format: <https://mujoco.readthedocs.io/en/stable/XMLreference.html>.
//!
//! Read in the order MuJoCo's compiler works: includes, compiler settings, default classes, bodies, then what refers to
//! them. A second pass over all elements lists what affects the motion and is not taken over ([`audit`]).
//! `mjcf-rs` reads the same format, but drops what it does not know, names no lines and panics on some input; tests
//! compare the two.

mod audit;
mod defaults;
mod extras;
mod geom;
mod joint;

use crate::error::SceneError;
use crate::models::inertia::Inertia;
use crate::models::tree::{Link, Motion, Rules, Tree};
use crate::models::xml::{Attributes, Document};
use crate::models::{Import, ImportOptions, assemble};
use defaults::{Classes, Compiler};
use geom::Assets;
use glamx::{DMat3, DPose3, DVec3};
use std::collections::BTreeMap;
use std::path::Path;

pub(crate) fn import(xml: &str, file: &str, base: &Path, options: &ImportOptions) -> Result<Import, SceneError> {
    let document = Document::parse(xml, file, Some(base))?;
    if document.root().tag != "mujoco" {
        return Err(document.error(0, "the root element of MJCF is <mujoco>"));
    }
    let classes = Classes::read(&document);
    let mut reader = Reader::new(&document, &classes, base)?;
    reader.options()?;
    reader.bodies()?;
    reader.bound_masses()?;
    extras::read(&mut reader)?;
    let mut warnings = reader.warnings;
    audit::audit(&document, &mut warnings);
    let scene = assemble(&reader.tree, options, &mut warnings)?;
    Ok(Import { scene, warnings })
}

struct Reader<'a> {
    document: &'a Document,
    classes: &'a Classes,
    compiler: Compiler,
    assets: Assets,
    tree: Tree,
    /// What may be referred to by name.
    body_names: BTreeMap<&'a str, usize>,
    /// Link and coordinate.
    joint_names: BTreeMap<&'a str, (usize, usize)>,
    geom_names: BTreeMap<&'a str, usize>,
    site_names: BTreeMap<&'a str, (usize, DPose3)>,
    pieces: usize,
    contacts: bool,
    warnings: Vec<String>,
}

/// A body element that waits to be read.
struct BodyTask<'a> {
    element: usize,
    parent: usize,
    around: Option<&'a str>,
    frame: DPose3,
}

/// Where an element stands inside its body: frames and their classes may be around it.
#[derive(Clone, Copy)]
struct Inside<'a> {
    link: usize,
    around: Option<&'a str>,
    frame: DPose3,
}

impl<'a> Reader<'a> {
    fn new(document: &'a Document, classes: &'a Classes, base: &Path) -> Result<Self, SceneError> {
        let compiler = Compiler::read(document)?;
        let assets = Assets::read(document, &compiler, base);
        let mut world = Link::new("world".into(), document.place(0), 0, DPose3::IDENTITY);
        world.place += ": <worldbody>";
        let rules = Rules {
            merge_fixed: false,
            exclude_parent: true,
            exclude_fixed_parent: false,
            mend_inertia: false,
            ground_friction: 1.0,
        };
        let tree = Tree {
            name: document.root().attribute("model").unwrap_or("").to_owned(),
            links: vec![world],
            gravity: DVec3::new(0.0, 0.0, -9.81),
            timestep: 0.002,
            rules,
            excluded: Vec::new(),
            pairs: Vec::new(),
            loops: Vec::new(),
        };
        Ok(Self {
            document,
            classes,
            compiler,
            assets,
            tree,
            body_names: BTreeMap::from([("world", 0)]),
            joint_names: BTreeMap::new(),
            geom_names: BTreeMap::new(),
            site_names: BTreeMap::new(),
            pieces: 0,
            contacts: true,
            warnings: Vec::new(),
        })
    }

    fn options(&mut self) -> Result<(), SceneError> {
        let document = self.document;
        for &id in document.children(0).iter().filter(|&&id| document.element(id).tag == "option") {
            let a = document.attributes(id, None);
            if let Some(gravity) = a.array("gravity")? {
                self.tree.gravity = DVec3::from_array(gravity);
            }
            if let Some(timestep) = a.number("timestep")? {
                if timestep <= 0.0 {
                    return Err(a.error("timestep", format!("must be > 0, is {timestep}")));
                }
                self.tree.timestep = timestep;
            }
            for &flag in document.children(id).iter().filter(|&&f| document.element(f).tag == "flag") {
                let off = |name: &str| document.element(flag).attribute(name) == Some("disable");
                if off("gravity") {
                    self.tree.gravity = DVec3::ZERO;
                }
                if off("filterparent") {
                    self.tree.rules.exclude_parent = false;
                }
                self.contacts &= !off("contact") && !off("constraint");
            }
        }
        Ok(())
    }

    fn bodies(&mut self) -> Result<(), SceneError> {
        let document = self.document;
        let mut tasks: Vec<BodyTask> = Vec::new();
        let sections = document.children(0).iter().rev().filter(|&&id| document.element(id).tag == "worldbody");
        for &element in sections {
            tasks.push(BodyTask { element, parent: usize::MAX, around: None, frame: DPose3::IDENTITY });
        }
        while let Some(task) = tasks.pop() {
            let mut children = self.body(&task)?;
            children.reverse();
            tasks.append(&mut children);
        }
        Ok(())
    }

    /// Reads a body without its children, which are returned.
    fn body(&mut self, task: &BodyTask<'a>) -> Result<Vec<BodyTask<'a>>, SceneError> {
        let document = self.document;
        let a = document.attributes(task.element, None);
        let around = document.element(task.element).attribute("childclass").or(task.around);
        let link = if task.parent == usize::MAX { 0 } else { self.new_link(task, &a)? };
        let inertial = document.child(task.element, "inertial");
        let from_geoms = self.compiler.inertia_from_geom.unwrap_or(inertial.is_none());
        let mut children = Vec::new();
        let start = Inside { link, around, frame: DPose3::IDENTITY };
        let mut stack: Vec<(usize, Inside)> = Vec::new();
        stack.extend(document.children(task.element).iter().rev().map(|&c| (c, start)));
        while let Some((id, inside)) = stack.pop() {
            match document.element(id).tag.as_str() {
                "frame" => {
                    let a = document.attributes(id, None);
                    let around = document.element(id).attribute("childclass").or(inside.around);
                    let frame = inside.frame * self.compiler.pose(&a)?;
                    let inside = Inside { around, frame, ..inside };
                    stack.extend(document.children(id).iter().rev().map(|&c| (c, inside)));
                }
                "body" => {
                    children.push(BodyTask { element: id, parent: link, around: inside.around, frame: inside.frame })
                }
                "geom" => self.geom(id, inside, from_geoms)?,
                "joint" | "freejoint" => {
                    if link == 0 {
                        return Err(document.error(id, "the world has no joints: put it into a <body>"));
                    }
                    self.joint(id, inside)?;
                }
                "site" => {
                    let a = self.classes.attributes(document, id, "site", inside.around)?;
                    if let Some(name) = document.element(id).attribute("name") {
                        self.site_names.insert(name, (link, inside.frame * self.compiler.pose(&a)?));
                    }
                }
                _ => {}
            }
        }
        if let Some(id) = inertial.filter(|_| !from_geoms && link != 0) {
            self.tree.links[link].inertia = self.inertial(id)?;
        }
        Ok(children)
    }

    fn new_link(&mut self, task: &BodyTask<'a>, a: &Attributes<'a>) -> Result<usize, SceneError> {
        let link = self.tree.links.len();
        let name = a.text("name").unwrap_or("");
        if !name.is_empty() && self.body_names.insert(name, link).is_some() {
            return Err(a.error("name", format!("two bodies are called `{name}`")));
        }
        let pose = task.frame * self.compiler.pose(a)?;
        let mut made = Link::new(name.to_owned(), self.document.describe(task.element), task.parent, pose);
        if a.boolean("mocap")?.unwrap_or(false) {
            if task.parent != 0 {
                return Err(a.error("mocap", "only bodies directly in <worldbody> are moved by mocap"));
            }
            made.motion = Motion::Kinematic;
        }
        made.gravity_scale = 1.0 - a.number("gravcomp")?.unwrap_or(0.0);
        self.tree.links.push(made);
        Ok(link)
    }

    fn inertial(&self, id: usize) -> Result<Inertia, SceneError> {
        let a = self.document.attributes(id, None);
        let mass = a.number("mass")?.ok_or_else(|| a.error("mass", "this attribute is missing"))?;
        if mass < 0.0 {
            return Err(a.error("mass", format!("must be ≥ 0, is {mass}")));
        }
        let pose = self.compiler.pose(&a)?;
        let matrix = match (a.array::<6>("fullinertia")?, a.array::<3>("diaginertia")?) {
            (Some([xx, yy, zz, xy, xz, yz]), _) => {
                DMat3::from_cols(DVec3::new(xx, xy, xz), DVec3::new(xy, yy, yz), DVec3::new(xz, yz, zz))
            }
            (None, Some(diagonal)) => DMat3::from_diagonal(DVec3::from_array(diagonal)),
            (None, None) => return Err(a.error("diaginertia", "either this or fullinertia is needed")),
        };
        Ok(Inertia { mass, center: DVec3::ZERO, matrix }.transformed(pose))
    }

    /// The compiler's bounds, balance and total.
    fn bound_masses(&mut self) -> Result<(), SceneError> {
        let c = self.compiler.clone();
        for link in self.tree.links.iter_mut().skip(1) {
            link.inertia.mass = link.inertia.mass.max(c.bound_mass);
            let (moments, axes) = link.inertia.principal();
            let mut bounded = moments.max(DVec3::splat(c.bound_inertia));
            if c.balance_inertia && 2.0 * bounded.max_element() > bounded.element_sum() {
                bounded = DVec3::splat(bounded.element_sum() / 3.0);
            }
            if bounded != moments {
                link.inertia = link.inertia.with_moments(bounded, axes);
            }
        }
        if let Some(total) = c.total_mass {
            let sum: f64 = self.tree.links.iter().skip(1).map(|l| l.inertia.mass).sum();
            if sum > 0.0 {
                for link in &mut self.tree.links {
                    link.inertia = link.inertia.scaled(total / sum);
                }
            }
        }
        Ok(())
    }

    fn warn(&mut self, id: usize, message: impl std::fmt::Display) {
        self.warnings.push(format!("{}: {message}", self.document.describe(id)));
    }

    /// world_from_link when all coordinates are zero.
    fn world_from_link(&self, mut link: usize) -> DPose3 {
        let mut pose = self.tree.links[link].pose;
        while link != 0 {
            link = self.tree.links[link].parent;
            pose = self.tree.links[link].pose * pose;
        }
        pose
    }
}
