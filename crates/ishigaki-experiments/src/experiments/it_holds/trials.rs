//! The scenes and what they are held to.

/// What a scene is held to. Overlap, drift and gap are in mm, and without limit where there is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rule {
    /// It stands to the end.
    Stands { pen: Option<f64>, drift: Option<f64> },
    /// It would be good if it stood.
    ShouldStand,
    /// No joint opens further than this.
    Joints { gap: f64 },
    /// It tumbles and comes to rest: overlaps of the points that touch at the end.
    Rests { mean: f64, most: f64 },
}

/// A named scene and its rule.
pub struct Trial {
    pub label: &'static str,
    pub scene: &'static str,
    pub parameters: &'static [(&'static str, f64)],
    pub seconds: f64,
    pub rule: Rule,
}

const fn trial(
    label: &'static str,
    scene: &'static str,
    parameters: &'static [(&'static str, f64)],
    seconds: f64,
    rule: Rule,
) -> Trial {
    Trial { label, scene, parameters, seconds, rule }
}

const STANDS: Rule = Rule::Stands { pen: None, drift: None };

const fn stands_within(pen: f64) -> Rule {
    Rule::Stands { pen: Some(pen), drift: None }
}

const fn joints(gap: f64) -> Rule {
    Rule::Joints { gap }
}

/// The first are cheap enough for tests.
pub const TRIALS: [Trial; 14] = [
    trial("tower of 40", "tower", &[("n", 40.0)], 60.0, Rule::Stands { pen: Some(8.0), drift: Some(10.0) }),
    trial("10 boxes, top 1000 ×", "heavy_on_light", &[("n", 10.0), ("ratio", 1000.0)], 30.0, STANDS),
    trial(
        "chain of 100, end 1000 ×, hanging",
        "chain",
        &[("links", 100.0), ("end_mass_ratio", 1000.0)],
        10.0,
        joints(10.0),
    ),
    trial("tower of 160", "tower", &[("n", 160.0)], 60.0, STANDS),
    trial("tower of 400", "tower", &[("n", 400.0)], 20.0, Rule::ShouldStand),
    trial("10 boxes, top 100 ×", "heavy_on_light", &[("n", 10.0), ("ratio", 100.0)], 30.0, stands_within(10.0)),
    trial("10 boxes, top 10000 ×", "heavy_on_light", &[("n", 10.0), ("ratio", 10_000.0)], 30.0, STANDS),
    trial(
        "chain of 100, end 1000 ×, swinging",
        "chain",
        &[("links", 100.0), ("end_mass_ratio", 1000.0), ("swing", 1.0)],
        10.0,
        joints(50.0),
    ),
    trial("net 30 × 30", "joint_grid", &[("n", 30.0)], 5.0, joints(15.0)),
    trial("wall", "wall", &[], 30.0, STANDS),
    trial("pyramid of 30", "pyramid", &[("base", 30.0)], 10.0, STANDS),
    trial("200 ragdolls", "ragdolls", &[("n", 200.0)], 5.0, joints(40.0)),
    trial("pile of 4000", "pile", &[("n", 4000.0)], 8.0, Rule::Rests { mean: 2.3, most: 40.0 }),
    trial("pyramid of 100", "pyramid", &[("base", 100.0)], 60.0, stands_within(10.0)),
];
