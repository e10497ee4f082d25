//! Default classes and compiler settings of MJCF.

use crate::error::{SceneError, unknown};
use crate::models::xml::{Attributes, Defaults, Document};
use glamx::{DMat3, DPose3, DQuat, DVec3};
use std::collections::BTreeMap;

/// Alternative ways to say a rotation: setting one takes the others back.
const ROTATIONS: [&str; 5] = ["quat", "axisangle", "euler", "xyaxes", "zaxis"];

/// Attributes by element, for each class.
#[derive(Debug, Default)]
pub(crate) struct Classes {
    classes: BTreeMap<String, BTreeMap<String, Defaults>>,
}

impl Classes {
    pub fn read(document: &Document) -> Self {
        let mut classes = Self::default();
        classes.classes.insert("main".into(), BTreeMap::new());
        let sections = document.children(0).iter().rev().filter(|&&c| document.element(c).tag == "default");
        let mut stack: Vec<(usize, Option<String>)> = sections.map(|&c| (c, None)).collect();
        while let Some((id, parent)) = stack.pop() {
            let name = document.element(id).attribute("class").unwrap_or("main").to_owned();
            // A class may be said in several places; a new one starts as its parent.
            let known = classes.classes.get(&name).or_else(|| classes.classes.get(parent.as_ref()?));
            let mut class = known.cloned().unwrap_or_default();
            for &child in document.children(id) {
                let element = document.element(child);
                if element.tag != "default" {
                    overlay(class.entry(element.tag.clone()).or_default(), &element.attributes);
                }
            }
            classes.classes.insert(name.clone(), class);
            let nested = document.children(id).iter().rev().filter(|&&c| document.element(c).tag == "default");
            stack.extend(nested.map(|&c| (c, Some(name.clone()))));
        }
        classes
    }

    /// The attributes of an element over those of its class: its own, else that of the bodies around it.
    pub fn attributes<'a>(
        &'a self,
        document: &'a Document,
        id: usize,
        tag: &str,
        around: Option<&'a str>,
    ) -> Result<Attributes<'a>, SceneError> {
        let name = document.element(id).attribute("class").or(around).unwrap_or("main");
        let class = self.classes.get(name).ok_or_else(|| {
            document.error(id, unknown("default class", name, self.classes.keys().map(String::as_str)))
        })?;
        Ok(document.attributes(id, class.get(tag)))
    }
}

fn overlay(onto: &mut Defaults, attributes: &[(String, String)]) {
    for (name, value) in attributes {
        if ROTATIONS.contains(&name.as_str()) {
            onto.retain(|n, _| !ROTATIONS.contains(&n.as_str()));
        }
        if name != "class" {
            onto.insert(name.clone(), value.clone());
        }
    }
}

/// `<compiler>`: how the rest is to be read.
#[derive(Clone, Debug)]
pub(crate) struct Compiler {
    pub degree: bool,
    eulerseq: Vec<char>,
    pub autolimits: bool,
    /// Always, never, or (`None`) where a body has no `<inertial>`.
    pub inertia_from_geom: Option<bool>,
    pub inertia_groups: [f64; 2],
    pub bound_mass: f64,
    pub bound_inertia: f64,
    pub balance_inertia: bool,
    pub total_mass: Option<f64>,
    pub mesh_dir: String,
    pub strip_path: bool,
}

impl Compiler {
    pub fn read(document: &Document) -> Result<Self, SceneError> {
        let mut c = Self {
            degree: true,
            eulerseq: vec!['x', 'y', 'z'],
            autolimits: true,
            inertia_from_geom: None,
            inertia_groups: [0.0, 5.0],
            bound_mass: 0.0,
            bound_inertia: 0.0,
            balance_inertia: false,
            total_mass: None,
            mesh_dir: String::new(),
            strip_path: false,
        };
        let sections = document.children(0).iter().filter(|&&id| document.element(id).tag == "compiler");
        for &id in sections {
            let a = document.attributes(id, None);
            match a.text("angle") {
                None => {}
                Some("degree") => c.degree = true,
                Some("radian") => c.degree = false,
                Some(other) => return Err(a.error("angle", format!("must be degree or radian, is `{other}`"))),
            }
            if a.text("coordinate").is_some_and(|v| v != "local") {
                let message = "only local coordinates are read: MuJoCo 2.3.3 and later have no others";
                return Err(a.error("coordinate", message));
            }
            if let Some(text) = a.text("eulerseq") {
                c.eulerseq = text.chars().collect();
                if c.eulerseq.len() != 3 || !c.eulerseq.iter().all(|ch| "xyzXYZ".contains(*ch)) {
                    return Err(a.error("eulerseq", "must be three letters of xyzXYZ"));
                }
            }
            if let Some(directory) = a.text("meshdir").or_else(|| a.text("assetdir")) {
                c.mesh_dir = directory.to_owned();
            }
            c.autolimits = a.boolean("autolimits")?.unwrap_or(c.autolimits);
            if a.text("inertiafromgeom").is_some() {
                c.inertia_from_geom = a.tristate("inertiafromgeom")?;
            }
            c.inertia_groups = a.array("inertiagrouprange")?.unwrap_or(c.inertia_groups);
            c.bound_mass = a.number("boundmass")?.unwrap_or(c.bound_mass);
            c.bound_inertia = a.number("boundinertia")?.unwrap_or(c.bound_inertia);
            c.balance_inertia = a.boolean("balanceinertia")?.unwrap_or(c.balance_inertia);
            c.strip_path = a.boolean("strippath")?.unwrap_or(c.strip_path);
            if let Some(total) = a.number("settotalmass")? {
                c.total_mass = (total > 0.0).then_some(total);
            }
        }
        Ok(c)
    }

    pub fn angle(&self, value: f64) -> f64 {
        if self.degree { value.to_radians() } else { value }
    }

    /// `pos` and whichever rotation is said.
    pub fn pose(&self, a: &Attributes) -> Result<DPose3, SceneError> {
        let position = a.array("pos")?.map_or(DVec3::ZERO, DVec3::from_array);
        Ok(DPose3::from_parts(position, self.rotation(a)?))
    }

    pub fn rotation(&self, a: &Attributes) -> Result<DQuat, SceneError> {
        // An element's own way of saying it goes before that of its class.
        let own = |name: &&&str| a.document.element(a.id).attribute(name).is_some();
        let said = ROTATIONS.iter().find(own).or_else(|| ROTATIONS.iter().find(|n| a.text(n).is_some()));
        let unit = |v: DVec3, what: &str| v.try_normalize().ok_or_else(|| a.error(what, "has no direction"));
        match said.copied() {
            Some("axisangle") => {
                let [x, y, z, angle] = a.array("axisangle")?.unwrap_or_default();
                Ok(turn(unit(DVec3::new(x, y, z), "axisangle")?, self.angle(angle)))
            }
            Some("euler") => {
                let angles: [f64; 3] = a.array("euler")?.unwrap_or_default();
                let mut q = DQuat::IDENTITY;
                for (axis, angle) in self.eulerseq.iter().zip(angles) {
                    let about = match axis.to_ascii_lowercase() {
                        'x' => DVec3::X,
                        'y' => DVec3::Y,
                        _ => DVec3::Z,
                    };
                    let part = turn(about, self.angle(angle));
                    // Small letters: about the axes as they have been turned so far; capitals: about the fixed ones.
                    q = if axis.is_ascii_lowercase() { q * part } else { part * q };
                }
                Ok(q.normalize())
            }
            Some("xyaxes") => {
                let [a0, a1, a2, b0, b1, b2] = a.array("xyaxes")?.unwrap_or_default();
                let x = unit(DVec3::new(a0, a1, a2), "xyaxes")?;
                let y = DVec3::new(b0, b1, b2);
                let y = unit(y - x * x.dot(y), "xyaxes")?;
                Ok(DQuat::from_mat3(&DMat3::from_cols(x, y, x.cross(y))).normalize())
            }
            Some("zaxis") => {
                let z = a.array("zaxis")?.map_or(DVec3::Z, DVec3::from_array);
                Ok(DQuat::from_rotation_arc(DVec3::Z, unit(z, "zaxis")?))
            }
            Some(_) => quaternion(a, "quat"),
            None => Ok(DQuat::IDENTITY),
        }
    }
}

/// A quaternion as MuJoCo writes it, w first; need not be normalized.
pub(crate) fn quaternion(a: &Attributes, name: &str) -> Result<DQuat, SceneError> {
    let Some([w, x, y, z]) = a.array(name)? else { return Ok(DQuat::IDENTITY) };
    let q = DQuat::from_xyzw(x, y, z, w);
    let length = q.length();
    if length.is_finite() && length > 1e-10 { Ok(q / length) } else { Err(a.error(name, "has no length")) }
}

/// A rotation about a unit axis, rad; with `libm`, the same on all machines.
pub(crate) fn turn(axis: DVec3, angle: f64) -> DQuat {
    let v = axis * libm::sin(0.5 * angle);
    DQuat::from_xyzw(v.x, v.y, v.z, libm::cos(0.5 * angle))
}
