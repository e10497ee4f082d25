//! `<joint>` and `<freejoint>`.

use super::{Inside, Reader};
use crate::error::SceneError;
use crate::models::tree::{Coordinate, CoordinateKind, Motion};
use crate::models::xml::Attributes;
use glamx::DVec3;

impl<'a> Reader<'a> {
    pub(super) fn joint(&mut self, id: usize, inside: Inside<'a>) -> Result<(), SceneError> {
        let document = self.document;
        let free_element = document.element(id).tag == "freejoint";
        // A <freejoint> takes no defaults.
        let a = if free_element {
            document.attributes(id, None)
        } else {
            self.classes.attributes(document, id, "joint", inside.around)?
        };
        let kind = match a.text("type").unwrap_or("hinge") {
            _ if free_element => return self.free(id, inside.link, &a),
            "free" => return self.free(id, inside.link, &a),
            "hinge" => CoordinateKind::Hinge,
            "slide" => CoordinateKind::Slide,
            "ball" => CoordinateKind::Ball,
            other => return Err(a.error("type", format!("must be free, ball, slide or hinge, is `{other}`"))),
        };
        let coordinate = self.coordinate(kind, inside, &a)?;
        let link = &mut self.tree.links[inside.link];
        let index = match &mut link.motion {
            Motion::Welded => {
                link.motion = Motion::Joints(vec![coordinate]);
                0
            }
            Motion::Joints(coordinates) => {
                coordinates.push(coordinate);
                coordinates.len() - 1
            }
            Motion::Free { .. } => return Err(document.error(id, "a body with a free joint can have no other")),
            Motion::Kinematic => return Err(document.error(id, "a mocap body cannot have joints")),
        };
        self.name_joint(id, inside.link, index)
    }

    fn name_joint(&mut self, id: usize, link: usize, index: usize) -> Result<(), SceneError> {
        if let Some(name) = self.document.element(id).attribute("name")
            && self.joint_names.insert(name, (link, index)).is_some()
        {
            return Err(self.document.error(id, format!("two joints are called `{name}`")));
        }
        Ok(())
    }

    fn free(&mut self, id: usize, link: usize, a: &Attributes) -> Result<(), SceneError> {
        let made = &self.tree.links[link];
        if made.parent != 0 {
            return Err(self.document.error(id, "only bodies directly in <worldbody> can be free"));
        }
        if !matches!(made.motion, Motion::Welded) {
            return Err(self.document.error(id, "a body with a free joint can have no other"));
        }
        let damping = a.not_negative("damping")?;
        for name in ["stiffness", "armature", "frictionloss"] {
            let value = a.not_negative(name)?;
            if value > 0.0 {
                self.warn(id, format!("{name} {value} of a free joint is left out"));
            }
        }
        self.tree.links[link].motion = Motion::Free { damping };
        self.name_joint(id, link, 0)
    }

    fn coordinate(&mut self, kind: CoordinateKind, inside: Inside, a: &Attributes) -> Result<Coordinate, SceneError> {
        let anchor = inside.frame * a.array("pos")?.map_or(DVec3::ZERO, DVec3::from_array);
        let axis = a.array("axis")?.map_or(DVec3::Z, DVec3::from_array);
        let axis = axis.try_normalize().ok_or_else(|| a.error("axis", "has no direction"))?;
        // Angles of hinges and balls are in the file's unit; lengths of slides are not.
        let unit = |v: f64| if kind == CoordinateKind::Slide { v } else { self.compiler.angle(v) };
        let reference = unit(a.number("ref")?.unwrap_or(0.0));
        let rest = unit(a.number("springref")?.unwrap_or(0.0));
        let range = a.array("range")?.map(|r: [f64; 2]| r.map(unit));
        // MuJoCo takes "0 0" for no range.
        let has_range = range.is_some_and(|r| r != [0.0, 0.0]);
        let limited = a.tristate("limited")?.unwrap_or(self.compiler.autolimits && has_range);
        let mut limit = None;
        if limited {
            let range = range.filter(|_| has_range).ok_or_else(|| a.error("range", "a limited joint needs a range"))?;
            if range[0] > range[1] {
                return Err(a.error("range", format!("ends are exchanged: {} > {}", range[0], range[1])));
            }
            limit = Some(if kind == CoordinateKind::Ball { range } else { range.map(|r| r - reference) });
        } else if has_range && a.tristate("limited")?.is_none() {
            self.warn(a.id, "has a range that is not used: <compiler autolimits=\"false\"/> and no `limited`");
        }
        let coordinate = Coordinate {
            name: a.document.element(a.id).attribute("name").unwrap_or("").to_owned(),
            kind,
            anchor,
            axis: inside.frame.rotation * axis,
            limit,
            rest: if kind == CoordinateKind::Ball { 0.0 } else { rest - reference },
            reference,
            stiffness: a.not_negative("stiffness")?,
            damping: a.not_negative("damping")?,
            armature: a.not_negative("armature")?,
            friction: a.not_negative("frictionloss")?,
        };
        if kind == CoordinateKind::Ball {
            if limit.is_some() {
                self.warn(a.id, "the limit of the whole rotation becomes one of the cone and one of the twist");
            }
            for (name, value) in [("stiffness", coordinate.stiffness), ("armature", coordinate.armature)] {
                if value > 0.0 {
                    self.warn(a.id, format!("{name} {value} of a ball joint is left out"));
                }
            }
        }
        Ok(coordinate)
    }
}
