//! What affects the motion and is not taken over: every element and attribute is looked up here, and whatever the
//! importer does not read and is not merely seen is told, once for all its places.

use crate::models::xml::Document;
use std::collections::BTreeMap;

/// Sections without any effect on the motion.
const HARMLESS_SECTIONS: [&str; 5] = ["visual", "statistic", "size", "custom", "sensor"];
/// Elements without any effect on the motion.
const HARMLESS_ELEMENTS: [&str; 9] =
    ["camera", "light", "site", "texture", "material", "skin", "numeric", "text", "tuple"];

/// Attributes that are read, or only seen, by element.
const KNOWN: [(&str, &str); 20] = [
    ("mujoco", "model"),
    (
        "compiler",
        "angle coordinate eulerseq meshdir assetdir texturedir autolimits inertiafromgeom inertiagrouprange boundmass \
         boundinertia balanceinertia settotalmass strippath discardvisual usethread convexhull fusestatic saveinertial",
    ),
    ("option", "timestep gravity"),
    ("body", "name class childclass pos quat axisangle euler xyaxes zaxis mocap gravcomp user sleep"),
    ("worldbody", "childclass name"),
    ("frame", "name childclass pos quat axisangle euler xyaxes zaxis"),
    ("inertial", "pos quat axisangle euler xyaxes zaxis mass diaginertia fullinertia"),
    (
        "joint",
        "name class type pos axis limited range stiffness damping springref ref armature frictionloss group user",
    ),
    ("freejoint", "name group align user"),
    (
        "geom",
        "name class type size pos quat axisangle euler xyaxes zaxis fromto friction mass density contype conaffinity \
         condim group priority mesh hfield material rgba user",
    ),
    (
        "mesh",
        "name class file scale refpos refquat vertex face inertia normal texcoord smoothnormal material builtin \
         content_type",
    ),
    ("hfield", "name file size nrow ncol elevation content_type"),
    ("exclude", "name body1 body2 class"),
    ("pair", "name geom1 geom2 class"),
    ("connect", "name class active body1 body2 anchor site1 site2"),
    ("weld", "name class active body1 body2 relpose site1 site2"),
    ("default", "class"),
    ("include", "file"),
    ("motor", "name class group joint gear ctrllimited ctrlrange forcelimited forcerange user"),
    ("equality", "active"),
];

/// Why an attribute or element is not taken over.
const REASONS: [(&str, &str, &str); 34] = [
    ("", "solref", "constraints are hard, not springs: left out"),
    ("", "solimp", "constraints are hard, not springs: left out"),
    ("", "solreflimit", "limits are hard, not springs: left out"),
    ("", "solimplimit", "limits are hard, not springs: left out"),
    ("", "solreffriction", "friction is exact: left out"),
    ("", "solimpfriction", "friction is exact: left out"),
    ("", "solmix", "contacts are hard: left out"),
    ("", "margin", "contacts and limits act at zero distance: left out"),
    ("", "gap", "contacts act at zero distance: left out"),
    ("geom", "fluidshape", "there is no fluid: left out"),
    ("geom", "fluidcoef", "there is no fluid: left out"),
    ("geom", "shellinertia", "solid inertia is taken"),
    ("option", "density", "there is no fluid: left out"),
    ("option", "viscosity", "there is no fluid: left out"),
    ("option", "wind", "there is no wind: left out"),
    ("option", "integrator", "the engine steps in its own way"),
    ("option", "solver", "the engine solves in its own way"),
    ("option", "iterations", "the engine solves in its own way"),
    ("option", "tolerance", "the engine solves in its own way"),
    ("option", "cone", "the friction cone is round"),
    ("option", "impratio", "the engine solves in its own way"),
    ("option", "jacobian", "the engine solves in its own way"),
    ("option", "noslip_iterations", "the engine solves in its own way"),
    ("option", "ls_iterations", "the engine solves in its own way"),
    ("joint", "springdamper", "left out: give stiffness and damping"),
    ("joint", "actuatorfrcrange", "forces of actuators are not limited: left out"),
    ("joint", "actuatorgravcomp", "left out"),
    ("mesh", "maxhullvert", "hulls are simplified by the importer's own bound"),
    ("tendon", "", "tendons are left out"),
    ("keyframe", "", "keyframes are left out: the model is in the pose of its bodies"),
    ("deformable", "", "soft bodies are left out"),
    ("extension", "", "plugins are left out"),
    ("plugin", "", "plugins are left out"),
    ("weld", "torquescale", "the weld is rigid: left out"),
];

/// Elements that make bodies in ways that are not known here.
const MAKERS: [&str; 6] = ["attach", "replicate", "composite", "flexcomp", "model", "flex"];

pub(super) fn audit(document: &Document, warnings: &mut Vec<String>) {
    let mut found: BTreeMap<(String, String), (usize, usize)> = BTreeMap::new();
    // The section, or the element inside it, decides what is looked at: a tendon's <joint> is not a body's.
    let mut stack: Vec<usize> = vec![0];
    while let Some(id) = stack.pop() {
        let element = document.element(id);
        let tag = element.tag.as_str();
        if HARMLESS_SECTIONS.contains(&tag) || HARMLESS_ELEMENTS.contains(&tag) {
            continue;
        }
        let mut told = |attribute: &str| {
            found.entry((tag.to_owned(), attribute.to_owned())).or_insert((0, id)).0 += 1;
        };
        match tag {
            "tendon" | "keyframe" | "deformable" | "extension" | "plugin" => {
                if !document.children(id).is_empty() || tag == "plugin" {
                    told("");
                }
                continue;
            }
            "flag" => {
                for (name, value) in &element.attributes {
                    let taken = ["gravity", "filterparent", "contact"].contains(&name.as_str());
                    // All flags that are on by default are said by "disable"; the others do not move anything.
                    if !taken && value == "disable" && !["warmstart", "energy", "midphase"].contains(&name.as_str()) {
                        told(name);
                    }
                }
                continue;
            }
            // Read one by one, with their own warnings.
            "actuator" => continue,
            "mujoco" | "worldbody" | "asset" | "contact" | "default" => {}
            // Inside <default> any actuator or constraint may be named.
            "position" | "velocity" | "general" | "damper" | "cylinder" | "muscle" | "adhesion" | "intvelocity" => {
                continue;
            }
            _ if MAKERS.contains(&tag) => {
                told("");
                continue;
            }
            _ if !KNOWN.iter().any(|(t, _)| *t == tag) => {
                // Constraints of an unknown kind have been told by their reader.
                if !["tendon", "joint", "flex", "flexvert"].contains(&tag) {
                    told("");
                }
                continue;
            }
            _ => {}
        }
        let known = KNOWN.iter().find(|(t, _)| *t == tag).map_or("", |(_, names)| *names);
        for (name, value) in &element.attributes {
            if !known.split_whitespace().any(|n| n == name) && !is_nothing(tag, name, value) {
                told(name);
            }
        }
        // The children of an <equality> joint or tendon constraint are told as a whole.
        let children = document.children(id).iter().rev();
        if tag == "equality" {
            stack.extend(children.filter(|&&c| ["connect", "weld"].contains(&document.element(c).tag.as_str())));
        } else {
            stack.extend(children);
        }
    }
    for ((tag, attribute), (count, first)) in found {
        let reason = |t: &str, a: &str| REASONS.iter().find(|r| r.0 == t && r.1 == a).map(|r| r.2);
        let why = reason(&tag, &attribute).or_else(|| reason("", &attribute).filter(|_| !attribute.is_empty()));
        let maker = MAKERS.contains(&tag.as_str()).then_some("not known: the bodies it makes are missing");
        let why = why.or(maker).unwrap_or("not known: left out");
        let what = if attribute.is_empty() { format!("<{tag}>") } else { format!("<{tag} {attribute}>") };
        let times = if count > 1 { format!(" ({count} times)") } else { String::new() };
        warnings.push(format!("{}: {what}{times}: {why}", document.place(first)));
    }
}

/// A value that says what is so anyway.
fn is_nothing(tag: &str, attribute: &str, value: &str) -> bool {
    let zero = value.split_whitespace().all(|w| w.parse::<f64>() == Ok(0.0));
    match (tag, attribute) {
        (_, "margin" | "gap") | ("option", "density" | "viscosity" | "wind") => zero,
        ("option", "cone") => value == "elliptic",
        _ => false,
    }
}
