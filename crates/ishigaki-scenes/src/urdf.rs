//! URDF, the format of ROS: <http://wiki.ros.org/urdf/XML>.
//!
//! Links joined by fixed joints become one body. The root link floats freely unless it is named `world` or the base is
//! asked to be fixed. Neighbors in the tree do not touch, as in all programs that read the format. `urdf-rs` reads it
//! too, with five XML and text crates and without lines; tests compare the two.

use crate::error::{SceneError, unknown};
use crate::mesh::{self, Hull};
use crate::models::inertia::Inertia;
use crate::models::tree::{Coordinate, CoordinateKind, Link, Motion, Piece, Rules, Surface, Tree, pose, y_to_z};
use crate::models::xml::{Attributes, Document};
use crate::models::{Import, ImportOptions, assemble};
use glamx::{DMat3, DPose3, DQuat, DVec3};
use ishigaki::{ConvexHull, Geometry, Vec3};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The format has no step: a common one for robots, s.
const TIMESTEP: f64 = 1.0 / 240.0;
/// The format has no friction (Gazebo adds its own): the engine's default.
const FRICTION: f64 = 0.6;
/// Limits beyond this are meant to be none (rad, m).
const NO_LIMIT: f64 = 1e6;
/// Elements of links and joints that are read or only seen.
const KNOWN: [&str; 14] = [
    "inertial",
    "visual",
    "collision",
    "origin",
    "parent",
    "child",
    "axis",
    "limit",
    "dynamics",
    "calibration",
    "material",
    "mimic",
    "safety_controller",
    "self_collision_checking",
];

pub(crate) fn import(xml: &str, file: &str, base: &Path, options: &ImportOptions) -> Result<Import, SceneError> {
    let document = Document::parse(xml, file, None)?;
    if document.root().tag != "robot" {
        return Err(document.error(0, "the root element of URDF is <robot>"));
    }
    let mut reader = Reader { document: &document, base, meshes: BTreeMap::new(), pieces: 0, warnings: Vec::new() };
    let tree = reader.tree(options)?;
    let mut warnings = reader.warnings;
    if tree.links.iter().all(|l| l.pieces.is_empty()) {
        warnings.push(format!("{file}: no link has a collision shape: nothing touches"));
    }
    audit(&document, &mut warnings);
    let scene = assemble(&tree, options, &mut warnings)?;
    Ok(Import { scene, warnings })
}

struct Reader<'a> {
    document: &'a Document,
    base: &'a Path,
    /// By file and scale; `None` for those that cannot be read.
    meshes: BTreeMap<(String, [u64; 3]), Option<Arc<ConvexHull>>>,
    pieces: usize,
    warnings: Vec<String>,
}

/// The links and joints of the document by name.
struct Graph<'a> {
    links: BTreeMap<&'a str, usize>,
    /// Joint elements from each parent, in the file's order.
    children: BTreeMap<&'a str, Vec<(usize, &'a str)>>,
    root: &'a str,
}

impl<'a> Reader<'a> {
    fn tree(&mut self, options: &ImportOptions) -> Result<Tree, SceneError> {
        let graph = self.graph()?;
        let fixed = options.fixed_base || graph.root == "world";
        let root_place = self.document.describe(graph.links[graph.root]);
        let world_name = if fixed { graph.root } else { "world" };
        let mut links = vec![Link::new(world_name.to_owned(), root_place, 0, DPose3::IDENTITY)];
        let motion = if fixed { Motion::Welded } else { Motion::Free { damping: 0.0 } };
        let mut stack = vec![(graph.root, 0, DPose3::IDENTITY, motion)];
        while let Some((name, parent, pose, motion)) = stack.pop() {
            let id = graph.links[name];
            let mut link = Link::new(name.to_owned(), self.document.describe(id), parent, pose);
            link.motion = motion;
            self.link(id, &mut link)?;
            let index = links.len();
            links.push(link);
            for &(joint, child) in graph.children.get(name).into_iter().flatten().rev() {
                let (pose, motion) = self.joint(joint)?;
                stack.push((child, index, pose, motion));
            }
        }
        if links.len() <= graph.links.len() {
            let message = "some links are joined in a circle and never reach the root: a robot is a tree";
            return Err(self.document.error(0, message));
        }
        Ok(Tree {
            name: self.document.root().attribute("name").unwrap_or("").to_owned(),
            links,
            gravity: DVec3::new(0.0, 0.0, -9.81),
            timestep: TIMESTEP,
            rules: Rules {
                merge_fixed: true,
                exclude_parent: true,
                exclude_fixed_parent: true,
                mend_inertia: true,
                ground_friction: FRICTION,
            },
            excluded: Vec::new(),
            pairs: Vec::new(),
            loops: Vec::new(),
        })
    }

    fn graph(&self) -> Result<Graph<'a>, SceneError> {
        let document = self.document;
        let of =
            |tag: &'static str| document.children(0).iter().copied().filter(move |&c| document.element(c).tag == tag);
        let mut links = BTreeMap::new();
        for id in of("link") {
            let name = document.attributes(id, None).required("name")?;
            if links.insert(name, id).is_some() {
                return Err(document.error(id, format!("two links are called `{name}`")));
            }
        }
        let mut children: BTreeMap<&str, Vec<(usize, &str)>> = BTreeMap::new();
        let mut has_parent: BTreeMap<&str, usize> = BTreeMap::new();
        for id in of("joint") {
            let end = |tag: &str| {
                let element = document.child(id, tag);
                let element = element.ok_or_else(|| document.error(id, format!("<{tag} link=\"…\"/> is missing")))?;
                let a = document.attributes(element, None);
                let name = a.required("link")?;
                let known = || unknown("link", name, links.keys().copied().collect::<Vec<_>>());
                if links.contains_key(name) { Ok(name) } else { Err(a.error("link", known())) }
            };
            let (parent, child) = (end("parent")?, end("child")?);
            if let Some(other) = has_parent.insert(child, id) {
                let message = format!("link `{child}` has a second parent: the other is {}", document.describe(other));
                return Err(document.error(id, message));
            }
            children.entry(parent).or_default().push((id, child));
        }
        let mut roots = of("link")
            .filter_map(|id| document.element(id).attribute("name"))
            .filter(|name| !has_parent.contains_key(name));
        let root = match roots.next() {
            Some(root) => root,
            None if links.is_empty() => return Err(document.error(0, "has no links")),
            None => return Err(document.error(0, "has no root: its links are joined in a circle")),
        };
        if let Some(other) = roots.next() {
            let message = format!("has two roots, `{root}` and `{other}`: join one of them to the other by a <joint>");
            return Err(document.error(0, message));
        }
        Ok(Graph { links, children, root })
    }

    fn warn(&mut self, id: usize, message: impl std::fmt::Display) {
        self.warnings.push(format!("{}: {message}", self.document.describe(id)));
    }

    /// `<origin xyz rpy>` of an element: turns about the fixed x, y, z.
    fn origin(&self, id: usize) -> Result<DPose3, SceneError> {
        let Some(origin) = self.document.child(id, "origin") else { return Ok(DPose3::IDENTITY) };
        let a = self.document.attributes(origin, None);
        let [roll, pitch, yaw] = a.array("rpy")?.unwrap_or([0.0; 3]);
        let about = |axis: DVec3, angle: f64| {
            let v = axis * libm::sin(0.5 * angle);
            DQuat::from_xyzw(v.x, v.y, v.z, libm::cos(0.5 * angle))
        };
        let rotation = about(DVec3::Z, yaw) * about(DVec3::Y, pitch) * about(DVec3::X, roll);
        Ok(pose(a.array("xyz")?.map_or(DVec3::ZERO, DVec3::from_array), rotation.normalize()))
    }

    fn link(&mut self, id: usize, link: &mut Link) -> Result<(), SceneError> {
        let document = self.document;
        if let Some(inertial) = document.child(id, "inertial") {
            link.inertia = self.inertial(inertial)?;
        }
        for &collision in document.children(id).iter().filter(|&&c| document.element(c).tag == "collision") {
            let Some(geometry) = document.child(collision, "geometry") else {
                return Err(document.error(collision, "<geometry> is missing"));
            };
            let origin = self.origin(collision)?;
            let Some(&form) = document.children(geometry).first() else {
                return Err(
                    document.error(geometry, "is empty: it needs a <box>, <cylinder>, <sphere>, <capsule> or <mesh>")
                );
            };
            if let Some((geometry, turn)) = self.geometry(form)? {
                // All shapes touch each other but for neighbors.
                let surface =
                    Surface { contype: 1, conaffinity: 1, condim: 3, priority: 0, friction: [FRICTION, 0.0, 0.0] };
                let pose = origin * pose(DVec3::ZERO, turn);
                link.pieces.push(Piece { id: self.pieces, geometry, pose, surface });
                self.pieces += 1;
            }
        }
        Ok(())
    }

    fn inertial(&self, id: usize) -> Result<Inertia, SceneError> {
        let document = self.document;
        let mass = match document.child(id, "mass") {
            Some(mass) => document.attributes(mass, None).not_negative("value")?,
            None => return Err(document.error(id, "<mass value=\"…\"/> is missing")),
        };
        let mut matrix = DMat3::ZERO;
        if let Some(inertia) = document.child(id, "inertia") {
            let a = document.attributes(inertia, None);
            let at = |name: &str| Ok::<f64, SceneError>(a.number(name)?.unwrap_or(0.0));
            let (xx, yy, zz) = (at("ixx")?, at("iyy")?, at("izz")?);
            let (xy, xz, yz) = (at("ixy")?, at("ixz")?, at("iyz")?);
            matrix = DMat3::from_cols(DVec3::new(xx, xy, xz), DVec3::new(xy, yy, yz), DVec3::new(xz, yz, zz));
        }
        Ok(Inertia { mass, center: DVec3::ZERO, matrix }.transformed(self.origin(id)?))
    }

    /// A shape and the turn that lays the engine's along the file's z; `None` with a warning for what cannot be read.
    fn geometry(&mut self, id: usize) -> Result<Option<(Geometry, DQuat)>, SceneError> {
        let a = self.document.attributes(id, None);
        let positive = |name: &str| match a.number(name)? {
            Some(x) if x > 0.0 => Ok(x as f32),
            other => Err(a.error(name, format!("must be > 0, is {}", other.unwrap_or(0.0)))),
        };
        let made = match self.document.element(id).tag.as_str() {
            "box" => {
                let size: [f64; 3] = a.array("size")?.ok_or_else(|| a.error("size", "this attribute is missing"))?;
                if size.iter().any(|&s| s <= 0.0) {
                    return Err(a.error("size", format!("must be > 0, is {size:?}")));
                }
                let half_extents = Vec3::from_array(size.map(|s| (0.5 * s) as f32));
                (Geometry::Cuboid { half_extents }, DQuat::IDENTITY)
            }
            "sphere" => (Geometry::Ball { radius: positive("radius")? }, DQuat::IDENTITY),
            "cylinder" => {
                let (half_height, radius) = (0.5 * positive("length")?, positive("radius")?);
                (Geometry::Cylinder { half_height, radius }, y_to_z())
            }
            "capsule" => {
                let (half_length, radius) = (0.5 * positive("length")?, positive("radius")?);
                (Geometry::Capsule { half_length, radius }, y_to_z())
            }
            "mesh" => return Ok(self.mesh(&a)?.map(|hull| (Geometry::ConvexHull(hull), DQuat::IDENTITY))),
            other => {
                self.warn(id, format!("<{other}> shapes are not known: the link touches nothing there"));
                return Ok(None);
            }
        };
        Ok(Some(made))
    }

    fn mesh(&mut self, a: &Attributes) -> Result<Option<Arc<ConvexHull>>, SceneError> {
        let file = a.required("filename")?;
        let scale = a.array("scale")?.unwrap_or([1.0; 3]);
        let key = (file.to_owned(), scale.map(f64::to_bits));
        if let Some(known) = self.meshes.get(&key) {
            return Ok(known.clone());
        }
        let made = resolve(self.base, file).and_then(|path| {
            let mut soup = mesh::load(&path).map_err(|e| format!("{} {e}", path.display()))?;
            for v in &mut soup.vertices {
                *v *= DVec3::from_array(scale);
            }
            if scale.iter().product::<f64>() < 0.0 {
                soup.triangles.iter_mut().for_each(|t| t.swap(1, 2));
            }
            let hull: Hull = mesh::hull(&soup).map_err(|e| format!("{} {e}", path.display()))?;
            let told = hull.approximation();
            Ok((ConvexHull::new(&hull.points).map_err(|e| e.to_string())?, told))
        });
        let hull = match made {
            Ok((hull, told)) => {
                if let Some(told) = told {
                    self.warn(a.id, format!("{file} {told}"));
                }
                Some(Arc::new(hull))
            }
            Err(message) => {
                self.warn(a.id, format!("{message}: the link touches nothing there"));
                None
            }
        };
        self.meshes.insert(key, hull.clone());
        Ok(hull)
    }

    /// Pose of the child in the parent, and how it moves.
    fn joint(&mut self, id: usize) -> Result<(DPose3, Motion), SceneError> {
        let document = self.document;
        let a = document.attributes(id, None);
        let origin = self.origin(id)?;
        let kind = a.required("type")?;
        let axis = match document.child(id, "axis") {
            Some(element) => {
                let a = document.attributes(element, None);
                let axis = a.array("xyz")?.map_or(DVec3::X, DVec3::from_array);
                let needed = !matches!(kind, "fixed" | "floating" | "spherical");
                match axis.try_normalize() {
                    Some(axis) => axis,
                    None if needed => return Err(a.error("xyz", "has no direction")),
                    None => DVec3::X,
                }
            }
            None => DVec3::X,
        };
        let mut coordinate = Coordinate {
            name: a.text("name").unwrap_or("").to_owned(),
            kind: CoordinateKind::Hinge,
            anchor: DVec3::ZERO,
            axis,
            limit: None,
            rest: 0.0,
            reference: 0.0,
            stiffness: 0.0,
            damping: 0.0,
            armature: 0.0,
            friction: 0.0,
        };
        if let Some(dynamics) = document.child(id, "dynamics") {
            let a = document.attributes(dynamics, None);
            coordinate.damping = a.not_negative("damping")?;
            coordinate.friction = a.not_negative("friction")?;
        }
        let motion = match kind {
            "fixed" => Motion::Welded,
            "floating" => Motion::Free { damping: 0.0 },
            "continuous" => Motion::Joints(vec![coordinate]),
            "revolute" => {
                coordinate.limit = self.limit(id)?;
                Motion::Joints(vec![coordinate])
            }
            "prismatic" => {
                coordinate.kind = CoordinateKind::Slide;
                coordinate.limit = self.limit(id)?;
                Motion::Joints(vec![coordinate])
            }
            "spherical" => {
                coordinate.kind = CoordinateKind::Ball;
                Motion::Joints(vec![coordinate])
            }
            "planar" => {
                // In the plane whose normal is the axis, and about the axis.
                let one = axis.any_orthonormal_vector();
                let slide = |axis: DVec3, name: &str| Coordinate {
                    kind: CoordinateKind::Slide,
                    axis,
                    name: name.to_owned(),
                    ..coordinate.clone()
                };
                let slides = [slide(one, &coordinate.name), slide(axis.cross(one), "")];
                let turn = Coordinate { name: String::new(), ..coordinate.clone() };
                Motion::Joints(slides.into_iter().chain([turn]).collect())
            }
            other => {
                let known = ["fixed", "revolute", "continuous", "prismatic", "floating", "planar", "spherical"];
                return Err(a.error("type", unknown("joint type", other, known)));
            }
        };
        Ok((origin, motion))
    }

    fn limit(&mut self, id: usize) -> Result<Option<[f64; 2]>, SceneError> {
        let Some(element) = self.document.child(id, "limit") else {
            self.warn(id, "has no <limit>: its range is not limited");
            return Ok(None);
        };
        let a = self.document.attributes(element, None);
        // Infinity is written by some for no limit.
        let end = |name: &str, beyond: f64| {
            let Some(text) = a.text(name) else { return Ok(0.0) };
            match text.trim().parse::<f64>() {
                Ok(x) if x.is_nan() => Err(a.error(name, "must not be NaN")),
                Ok(x) if x.abs() > NO_LIMIT => Ok(beyond.copysign(x)),
                Ok(x) => Ok(x),
                Err(_) => Err(a.error(name, format!("`{}` is not a number", crate::models::xml::shortened(text)))),
            }
        };
        let range = [end("lower", f64::INFINITY)?, end("upper", f64::INFINITY)?];
        if range[0] > range[1] {
            return Err(a.error("lower", format!("ends are exchanged: {} > {}", range[0], range[1])));
        }
        if range == [0.0, 0.0] {
            self.warn(id, "its range is [0, 0]: it cannot move");
        }
        Ok((range != [f64::NEG_INFINITY, f64::INFINITY]).then_some(range))
    }
}

/// Where a mesh is: `package://name/…` is looked for beside and above the file, and in ROS_PACKAGE_PATH.
fn resolve(base: &Path, file: &str) -> Result<PathBuf, String> {
    if let Some(rest) = file.strip_prefix("package://") {
        let (package, inside) = rest.split_once('/').unwrap_or((rest, ""));
        // `ancestors` of a relative path stops too early.
        let start = std::fs::canonicalize(base).unwrap_or_else(|_| base.to_owned());
        let mut roots: Vec<PathBuf> = Vec::new();
        for folder in start.ancestors() {
            if folder.file_name().is_some_and(|n| n == package) {
                roots.push(folder.to_owned());
            }
            roots.push(folder.join(package));
        }
        if let Some(paths) = std::env::var_os("ROS_PACKAGE_PATH") {
            roots.extend(std::env::split_paths(&paths).map(|p| p.join(package)));
        }
        let found = roots.iter().map(|r| r.join(inside)).find(|p| p.is_file());
        return found.ok_or_else(|| {
            format!("{file} is not there: looked for a folder `{package}` at and above {}", start.display())
        });
    }
    let path = file.strip_prefix("file://").unwrap_or(file);
    let path = base.join(path);
    if path.is_file() { Ok(path) } else { Err(format!("{} is not there", path.display())) }
}

/// What affects the motion and is not taken over.
fn audit(document: &Document, warnings: &mut Vec<String>) {
    let mut found: BTreeMap<&str, (usize, usize, &str)> = BTreeMap::new();
    let mut tell = |what: &'static str, id: usize, why: &'static str| {
        found.entry(what).or_insert((0, id, why)).0 += 1;
    };
    let mut unknown: BTreeMap<&str, (usize, usize)> = BTreeMap::new();
    for &id in document.children(0) {
        let tag = document.element(id).tag.as_str();
        match tag {
            "gazebo" => tell("<gazebo>", id, "Gazebo's own settings (friction, stiffness, plugins …) are left out"),
            "transmission" | "ros2_control" => tell("<transmission>", id, "there are no motors: left out"),
            "link" | "joint" | "material" => {}
            other => unknown.entry(other).or_insert((0, id)).0 += 1,
        }
        if !["link", "joint"].contains(&tag) {
            continue;
        }
        for &child in document.children(id) {
            let element = document.element(child);
            match element.tag.as_str() {
                "mimic" => tell("<mimic>", child, "the joint moves independently of the one it should mimic"),
                "safety_controller" => tell("<safety_controller>", child, "soft limits are left out"),
                "limit" if element.attribute("effort").or(element.attribute("velocity")).is_some() => {
                    tell("<limit effort, velocity>", child, "there are no motors: left out");
                }
                other if !KNOWN.contains(&other) => unknown.entry(other).or_insert((0, child)).0 += 1,
                _ => {}
            }
        }
    }
    let times = |count: usize| if count > 1 { format!(" ({count} times)") } else { String::new() };
    for (what, (count, first, why)) in found {
        warnings.push(format!("{}: {what}{}: {why}", document.place(first), times(count)));
    }
    for (tag, (count, first)) in unknown {
        warnings.push(format!("{}: <{tag}>{}: not known: left out", document.place(first), times(count)));
    }
}
