//! What refers to bodies, joints and geoms by name: `<contact>`, `<equality>`, `<actuator>`.

use super::Reader;
use crate::error::{SceneError, unknown};
use crate::models::tree::{CoordinateKind, Loop, Motion, pose};
use crate::models::xml::Attributes;
use glamx::{DPose3, DQuat, DVec3};

pub(super) fn read(reader: &mut Reader) -> Result<(), SceneError> {
    reader.contact()?;
    reader.equality()?;
    reader.actuators()
}

impl<'a> Reader<'a> {
    fn body_named(&self, a: &Attributes, attribute: &str) -> Result<usize, SceneError> {
        let name = a.required(attribute)?;
        let known = || self.body_names.keys().copied();
        let refuse = || a.error(attribute, unknown("body", name, known().collect::<Vec<_>>()));
        self.body_names.get(name).copied().ok_or_else(refuse)
    }

    fn contact(&mut self) -> Result<(), SceneError> {
        let document = self.document;
        let elements: Vec<usize> = document.in_sections("contact").collect();
        for id in elements {
            let a = document.attributes(id, None);
            match document.element(id).tag.as_str() {
                "exclude" => {
                    let pair = [self.body_named(&a, "body1")?, self.body_named(&a, "body2")?];
                    self.tree.excluded.push(pair);
                }
                "pair" => {
                    let geom = |attribute: &str| {
                        let name = a.required(attribute)?;
                        let known: Vec<&str> = self.geom_names.keys().copied().collect();
                        let refuse = || a.error(attribute, unknown("geom", name, known));
                        self.geom_names.get(name).copied().ok_or_else(refuse)
                    };
                    let pair = [geom("geom1")?, geom("geom2")?];
                    if self.contacts {
                        self.tree.pairs.push(pair);
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn equality(&mut self) -> Result<(), SceneError> {
        let document = self.document;
        let elements: Vec<usize> = document.in_sections("equality").collect();
        for id in elements {
            let a = self.classes.attributes(document, id, "equality", None)?;
            if a.boolean("active")? == Some(false) {
                continue;
            }
            let tag = document.element(id).tag.as_str();
            let ball = match tag {
                "connect" => true,
                "weld" => false,
                _ => {
                    self.warn(id, format!("<{tag}> constraints are not known: left out"));
                    continue;
                }
            };
            let (links, frames) = if a.text("site1").is_some() || a.text("site2").is_some() {
                let site = |attribute: &str| {
                    let name = a.required(attribute)?;
                    let known: Vec<&str> = self.site_names.keys().copied().collect();
                    let refuse = || a.error(attribute, unknown("site", name, known));
                    self.site_names.get(name).copied().ok_or_else(refuse)
                };
                let (one, two) = (site("site1")?, site("site2")?);
                ([one.0, two.0], [one.1, two.1])
            } else {
                self.equality_frames(&a, ball)?
            };
            let name = document.element(id).attribute("name").unwrap_or(tag).to_owned();
            self.tree.loops.push(Loop { name, ball, links, frames });
        }
        Ok(())
    }

    /// Where a constraint between two bodies sits on each.
    fn equality_frames(&self, a: &Attributes, ball: bool) -> Result<([usize; 2], [DPose3; 2]), SceneError> {
        let one = self.body_named(a, "body1")?;
        let two = if a.text("body2").is_some() { self.body_named(a, "body2")? } else { 0 };
        let two_from_one = self.world_from_link(two).inverse() * self.world_from_link(one);
        if ball {
            let anchor = a.array("anchor")?.map(DVec3::from_array);
            let anchor = anchor.ok_or_else(|| a.error("anchor", "this attribute is missing"))?;
            let at = pose(anchor, DQuat::IDENTITY);
            return Ok(([one, two], [at, two_from_one * at]));
        }
        // relpose is the second body's pose in the first's; a zero quaternion means: as the file has them.
        let relative = match a.array::<7>("relpose")? {
            Some([x, y, z, w, i, j, k]) if [w, i, j, k] != [0.0; 4] => {
                let q = DQuat::from_xyzw(i, j, k, w);
                pose(DVec3::new(x, y, z), q.normalize())
            }
            _ => two_from_one.inverse(),
        };
        Ok(([one, two], [relative, DPose3::IDENTITY]))
    }

    /// Servos (position, velocity, affine general) act without a controller too: with all controls zero they are
    /// springs and dampers. Motors do nothing until they are controlled.
    fn actuators(&mut self) -> Result<(), SceneError> {
        let document = self.document;
        let elements: Vec<usize> = document.in_sections("actuator").collect();
        let mut idle = Vec::new();
        for id in elements {
            let tag = document.element(id).tag.clone();
            let a = self.classes.attributes(document, id, &tag, None)?;
            let servo = match tag.as_str() {
                "motor" => None,
                "position" => Some((a.number("kp")?.unwrap_or(1.0), a.number("kv")?.unwrap_or(0.0), 0.0)),
                "velocity" => Some((0.0, a.number("kv")?.unwrap_or(1.0), 0.0)),
                "general" if a.text("biastype") == Some("affine") => {
                    let bias = a.list("biasprm", 1, 10)?.unwrap_or_default();
                    let at = |i: usize| bias.get(i).copied().unwrap_or(0.0);
                    Some((-at(1), -at(2), at(0)))
                }
                "general" | "damper" => None,
                other => {
                    self.warn(id, format!("<{other}> actuators are not known: left out"));
                    continue;
                }
            };
            match servo {
                Some((stiffness, damping, force)) => self.servo(&a, stiffness, damping, force)?,
                None => idle.push(id),
            }
        }
        if let Some(&first) = idle.first() {
            let message = format!("{} actuators do nothing until they are controlled: left out", idle.len());
            self.warnings.push(format!("{}: {message}", document.place(first)));
        }
        Ok(())
    }

    /// Force on the joint `g (b + k (−g q) + d (−g q̇))` with gear g.
    fn servo(&mut self, a: &Attributes, stiffness: f64, damping: f64, force: f64) -> Result<(), SceneError> {
        let (link, index) = match a.text("joint").or_else(|| a.text("jointinparent")) {
            Some(name) => *self.joint_names.get(name).ok_or_else(|| {
                let known: Vec<&str> = self.joint_names.keys().copied().collect();
                a.error("joint", unknown("joint", name, known))
            })?,
            None => {
                self.warn(a.id, "only actuators on joints are known: left out");
                return Ok(());
            }
        };
        let gear = a.list("gear", 1, 6)?.and_then(|g| g.first().copied()).unwrap_or(1.0);
        let Motion::Joints(coordinates) = &mut self.tree.links[link].motion else {
            self.warn(a.id, "servos on free joints are not known: left out");
            return Ok(());
        };
        let coordinate = &mut coordinates[index];
        if coordinate.kind == CoordinateKind::Ball || stiffness < 0.0 || damping < 0.0 {
            self.warn(a.id, "servos on ball joints and with negative gains are not known: left out");
            return Ok(());
        }
        let k = stiffness * gear * gear;
        // Two springs are one: k = k₁ + k₂ at the mean of their rest values; a constant force shifts it.
        let sum = coordinate.stiffness + k;
        if sum > 0.0 {
            let pull = coordinate.stiffness * coordinate.rest - k * coordinate.reference + force * gear;
            coordinate.rest = pull / sum;
        }
        coordinate.stiffness = sum;
        coordinate.damping += damping * gear * gear;
        let mut message = "acts as a spring and damper with its control at zero".to_owned();
        if a.text("forcerange").is_some() {
            message += "; its force is not limited";
        }
        self.warn(a.id, message);
        Ok(())
    }
}
