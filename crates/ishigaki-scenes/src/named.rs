//! Named scenes: each a function from parameters to a [`SceneFile`], the same on every machine.
//!
//! Unless a scene says otherwise: Y is up, gravity 9.81 m/s²; the ground is a half-space with its surface at y = 0,
//! body 0, called `ground`; boxes are cubes of 1 m, 1000 kg/m³, friction 0.6, restitution 0; what touches does so
//! exactly, without gap or overlap. Seeded scenes use the [`Random`] of this module.

mod cards;
mod jointed;
mod laws;
mod masonry;
mod pile;
mod ragdoll;
mod random;
mod stacks;

pub use cards::{card_house, dominoes, overhang};
pub use jointed::{bridge, chain, joint_grid, newtons_cradle};
pub use laws::{dzhanibekov, sliding_block, spinning_top};
pub use masonry::{arch, wall};
pub use pile::pile;
pub use ragdoll::{ragdoll, ragdolls};
pub use random::Random;
pub use stacks::{heavy_on_light, many_pyramids, plank_on_two_towers, pyramid, scale_under_stack, tower};

use crate::error::{Result, SceneError, unknown};
use crate::file::{BodyFile, CameraFile, JointFile, SceneFile};
use ishigaki::{Body, Shape, Vec3};

/// A parameter of a named scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// As given to [`named`].
    pub name: &'static str,
    /// What it is if it is not given.
    pub default: f64,
    /// Least and greatest value.
    pub range: (f64, f64),
    /// Of the value; empty for counts and ratios.
    pub unit: &'static str,
    /// Whether it must be a whole number.
    pub whole: bool,
    /// What it does.
    pub doc: &'static str,
}

/// A named scene.
#[derive(Clone, Copy, Debug)]
pub struct SceneInfo {
    /// As given to [`named`].
    pub name: &'static str,
    /// What it shows, in a line.
    pub summary: &'static str,
    /// In the order of the function's arguments.
    pub parameters: &'static [Parameter],
    make: fn(&[f64]) -> SceneFile,
}

/// All named scenes, by subject.
pub fn list() -> &'static [SceneInfo] {
    SCENES
}

/// A scene by its name, with some of its parameters.
///
/// ```
/// let file = ishigaki_scenes::named("pyramid", &[("base".to_string(), 3.0)])?;
/// assert_eq!(file.bodies.len(), 1 + 6);
/// # Ok::<(), ishigaki_scenes::SceneError>(())
/// ```
///
/// # Errors
/// A scene or parameter that does not exist, a parameter given twice, out of its range, or with a fraction where it
/// is a count; the message says what exists.
pub fn named(name: &str, parameters: &[(String, f64)]) -> Result<SceneFile> {
    let info = SCENES
        .iter()
        .find(|s| s.name == name)
        .ok_or_else(|| SceneError::invalid("scene", unknown("scene", name, SCENES.iter().map(|s| s.name))))?;
    let mut values: Vec<f64> = info.parameters.iter().map(|p| p.default).collect();
    for (i, (key, value)) in parameters.iter().enumerate() {
        let names = info.parameters.iter().map(|p| p.name);
        let Some(place) = info.parameters.iter().position(|p| p.name == key) else {
            return Err(SceneError::invalid(name, unknown("parameter", key, names)));
        };
        if parameters[..i].iter().any(|(earlier, _)| earlier == key) {
            return Err(SceneError::invalid(format!("{name}.{key}"), "is given twice"));
        }
        info.parameters[place].check(name, *value)?;
        values[place] = *value;
    }
    let mut file = (info.make)(&values);
    file.name = name.to_string();
    file.description = info.summary.to_string();
    Ok(file)
}

impl Parameter {
    fn check(&self, scene: &str, value: f64) -> Result<()> {
        let place = format!("{scene}.{}", self.name);
        let (least, most) = self.range;
        if self.whole && value.fract() != 0.0 {
            return Err(SceneError::invalid(place, format!("must be a whole number, is {value}")));
        }
        if !(least..=most).contains(&value) {
            let space = if self.unit.is_empty() { "" } else { " " };
            let (least, most, value) = (short(least), short(most), short(value));
            let message = format!("must be in [{least}, {most}]{space}{}, is {value}", self.unit);
            return Err(SceneError::invalid(place, message));
        }
        Ok(())
    }
}

/// 1e300 instead of three hundred zeros.
fn short(value: f64) -> String {
    if value.abs() < 1e6 { value.to_string() } else { format!("{value:e}") }
}

const fn count(name: &'static str, default: u32, least: u32, most: u32, doc: &'static str) -> Parameter {
    Parameter { name, default: default as f64, range: (least as f64, most as f64), unit: "", whole: true, doc }
}

const fn number(
    name: &'static str,
    default: f64,
    range: (f64, f64),
    unit: &'static str,
    doc: &'static str,
) -> Parameter {
    Parameter { name, default, range, unit, whole: false, doc }
}

/// `make` gets one checked value for each parameter, in order; counts are whole and small, so `as` is exact.
const SCENES: &[SceneInfo] = &[
    SceneInfo {
        name: "tower",
        summary: "A single column of boxes.",
        parameters: &[count("n", 10, 1, 10_000, "boxes")],
        make: |p| tower(p[0] as usize),
    },
    SceneInfo {
        name: "wall",
        summary: "A brick wall in running bond.",
        parameters: &[count("columns", 20, 1, 1000, "bricks in a course"), count("rows", 10, 1, 1000, "courses")],
        make: |p| wall(p[0] as usize, p[1] as usize),
    },
    SceneInfo {
        name: "pyramid",
        summary: "An upright triangle of boxes, each on two others.",
        parameters: &[count("base", 10, 1, 400, "boxes in the lowest row")],
        make: |p| pyramid(p[0] as usize),
    },
    SceneInfo {
        name: "many_pyramids",
        summary: "A field of pyramids: many islands of the same size.",
        parameters: &[
            count("rows", 5, 1, 100, "pyramids along z"),
            count("columns", 5, 1, 100, "pyramids along x"),
            count("base", 10, 1, 50, "boxes in the lowest row of each"),
        ],
        make: |p| many_pyramids(p[0] as usize, p[1] as usize, p[2] as usize),
    },
    SceneInfo {
        name: "arch",
        summary: "A semicircular arch of wedge stones without mortar; thinner than 0.1075 no arch stands.",
        parameters: &[
            count("stones", 21, 3, 1001, "wedge stones"),
            number("thickness", 0.15, (0.01, 1.0), "", "thickness over mean radius, t/R"),
        ],
        make: |p| arch(p[0] as usize, p[1] as f32),
    },
    SceneInfo {
        name: "card_house",
        summary: "A house of cards.",
        parameters: &[count("floors", 3, 1, 50, "floors")],
        make: |p| card_house(p[0] as usize),
    },
    SceneInfo {
        name: "dominoes",
        summary: "A row of dominoes, the first one pushed.",
        parameters: &[count("n", 30, 1, 10_000, "dominoes")],
        make: |p| dominoes(p[0] as usize),
    },
    SceneInfo {
        name: "overhang",
        summary: "Planks that lean out over a table's edge as the harmonic series; stands below fraction 1.",
        parameters: &[
            count("n", 10, 1, 1000, "planks"),
            number("fraction", 0.9, (0.0, 2.0), "", "of the greatest overhang that stands"),
        ],
        make: |p| overhang(p[0] as usize, p[1] as f32),
    },
    SceneInfo { name: "ragdoll", summary: "A ragdoll of 70 kg that is dropped.", parameters: &[], make: |_| ragdoll() },
    SceneInfo {
        name: "ragdolls",
        summary: "Ragdolls dropped onto each other.",
        parameters: &[count("n", 20, 1, 5000, "ragdolls")],
        make: |p| ragdolls(p[0] as usize),
    },
    SceneInfo {
        name: "chain",
        summary: "A hanging chain with a ball at its end.",
        parameters: &[
            count("links", 20, 1, 10_000, "links of 1 m"),
            number("end_mass_ratio", 10.0, (1e-3, 1e6), "", "mass of the ball over that of a link"),
            count("swing", 0, 0, 1, "0: hangs down; 1: starts level"),
        ],
        make: |p| chain(p[0] as usize, p[1] as f32, p[2] != 0.0),
    },
    SceneInfo {
        name: "joint_grid",
        summary: "A net of balls and ball joints that hangs from one edge.",
        parameters: &[count("n", 20, 2, 200, "balls along each edge")],
        make: |p| joint_grid(p[0] as usize),
    },
    SceneInfo {
        name: "bridge",
        summary: "A rope bridge of hinged planks with boxes on it.",
        parameters: &[count("planks", 20, 2, 1000, "planks of 1 m")],
        make: |p| bridge(p[0] as usize),
    },
    SceneInfo {
        name: "newtons_cradle",
        summary: "A row of hanging balls, the first drawn aside by 30°.",
        parameters: &[count("balls", 5, 2, 100, "balls")],
        make: |p| newtons_cradle(p[0] as usize),
    },
    SceneInfo {
        name: "heavy_on_light",
        summary: "A column of equal boxes below one that is much heavier or lighter.",
        parameters: &[
            count("n", 5, 2, 1000, "boxes, the top one included"),
            number("ratio", 100.0, (1e-3, 1e6), "", "mass of the top box over that of each other"),
        ],
        make: |p| heavy_on_light(p[0] as usize, p[1] as f32),
    },
    SceneInfo {
        name: "pile",
        summary: "Boxes, balls and capsules dropped into an open container.",
        parameters: &[count("n", 500, 1, 50_000, "bodies, of the three forms in turn")],
        make: |p| pile(p[0] as usize),
    },
    SceneInfo {
        name: "dzhanibekov",
        summary: "A free body that turns about its middle axis and flips every 1.955 s.",
        parameters: &[],
        make: |_| dzhanibekov(),
    },
    SceneInfo {
        name: "spinning_top",
        summary: "A fast top on its tip that precesses evenly, once in 3.56 s.",
        parameters: &[],
        make: |_| spinning_top(),
    },
    SceneInfo {
        name: "sliding_block",
        summary: "A block on a slope: it slides where tan(angle) exceeds friction.",
        parameters: &[
            number("angle", 20.0, (0.0, 80.0), "°", "of the slope"),
            number("friction", 0.6, (0.0, 10.0), "", "Coulomb's μ of block and slope"),
        ],
        make: |p| sliding_block(p[0] as f32, p[1] as f32),
    },
    SceneInfo {
        name: "plank_on_two_towers",
        summary: "A heavy plank on two level towers of different brick counts: heights in hops mislead.",
        parameters: &[
            count("left", 3, 1, 100, "bricks of the left tower"),
            count("right", 6, 1, 100, "bricks of the right tower"),
        ],
        make: |p| plank_on_two_towers(p[0] as usize, p[1] as usize),
    },
    SceneInfo {
        name: "scale_under_stack",
        summary: "Boxes on a scale that should read their whole weight.",
        parameters: &[count("n", 5, 1, 1000, "boxes")],
        make: |p| scale_under_stack(p[0] as usize),
    },
];

/// A scene file in the making.
struct Builder {
    file: SceneFile,
}

impl Builder {
    /// An empty scene, `seconds` long at 60 Hz, seen from `eye`.
    fn new(seconds: u32, eye: [f32; 3], target: [f32; 3]) -> Self {
        let camera = CameraFile { position: eye.into(), target: target.into() };
        Self { file: SceneFile { steps: seconds * 60, camera: Some(camera), ..SceneFile::default() } }
    }

    /// The same with the ground at y = 0.
    fn on_ground(seconds: u32, eye: [f32; 3], target: [f32; 3]) -> Self {
        let mut builder = Self::new(seconds, eye, target);
        builder.add(Body::fixed(Shape::half_space(Vec3::Y)).named("ground"));
        builder
    }

    /// Gives the body's index.
    fn add(&mut self, body: impl Into<BodyFile>) -> usize {
        self.file.bodies.push(body.into());
        self.file.bodies.len() - 1
    }

    fn join(&mut self, joint: JointFile) {
        self.file.joints.push(joint);
    }

    fn finish(self) -> SceneFile {
        self.file
    }
}

/// A cube of 1 m.
fn cube() -> Body {
    Body::dynamic(Shape::cuboid(0.5, 0.5, 0.5))
}
