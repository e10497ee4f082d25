//! Scaling: what a body costs in worlds of more and more bodies, in islands of more and more bodies, by threads.
//!
//! Each series is a row of scenes in which the surroundings of a body stay the same and one number grows. All engines,
//! with all numbers of threads, run each scene in lockstep. Every point counts the same steps of the same scene, or
//! a scene that comes to rest would be compared with itself at another age.

mod plot;
mod report;

use crate::engine::{Kind, Setup};
use crate::lockstep::{self, Course, Looks, Player};
use crate::memory;
use crate::progress::Progress;
use crate::scene::Scene;
use crate::scenes;
use crate::{Arguments, say, write};
use anyhow::{Context, Result, bail, ensure};
use report::{Point, Row};

/// Sizes of worlds unless `--sizes` says otherwise.
const SIZES: [u32; 5] = [1_000, 3_000, 10_000, 30_000, 100_000];
/// Bodies in all islands of the series of islands.
const TOTAL: u32 = 20_000;
/// Steps that count.
const STEPS: u32 = 60;
/// Of stepping, for an engine and a point, s.
const LIMIT: f64 = 300.0;

/// What grows along a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Axis {
    /// Bodies in the world.
    Bodies,
    /// Bodies in an island.
    IslandSize,
}

/// Scenes in which one number grows.
#[derive(Debug)]
pub struct Series {
    /// As given to `--series`.
    pub name: &'static str,
    /// For the reader of `--list`.
    pub about: &'static str,
    /// What grows.
    pub axis: Axis,
    /// Whether bodies may fall asleep.
    pub sleep: bool,
    /// Steps before those that count: until what falls lies, what is stacked carries, what rests sleeps.
    warm_up: u32,
    /// The name of the scene, from bodies in an island, where islands grow, and bodies in all.
    scene: fn(u32, u32) -> String,
}

/// All of them.
pub const SERIES: &[Series] = &[
    Series {
        name: "pile",
        about: "boxes, balls and capsules dropped into a container, ten layers deep",
        axis: Axis::Bodies,
        sleep: false,
        warm_up: 150,
        scene: |_, n| format!("bed:n={n}"),
    },
    Series {
        name: "pyramids",
        about: "pyramids of base 10, each of 55 cubes",
        axis: Axis::Bodies,
        sleep: false,
        warm_up: 60,
        scene: |_, n| pyramids(n),
    },
    Series {
        name: "sparse",
        about: "towers of three that sleep, and one body in a hundred that rolls between them; with sleep",
        axis: Axis::Bodies,
        sleep: true,
        warm_up: 120,
        scene: |_, n| format!("sparse:n={n}"),
    },
    Series {
        name: "islands",
        about: "20,000 cubes in walls of 1, 10, 100, … 20,000, ten courses high",
        axis: Axis::IslandSize,
        sleep: false,
        warm_up: 60,
        scene: |size, n| format!("walls:n={n}:size={size}"),
    },
];

/// Rows and columns of pyramids for about so many bodies: not quite a square if that comes closer.
fn pyramids(n: u32) -> String {
    let count = (n / 55).max(1);
    let columns = |rows: u32| (f64::from(n) / f64::from(55 * rows)).round() as u32;
    let off = |rows: &u32| n.abs_diff(55 * rows * columns(*rows));
    // The scene has at most 100 columns.
    let least = count.isqrt().div_ceil(2).max(count.div_ceil(100));
    let rows = (least..=count.isqrt()).min_by_key(off).unwrap_or(1);
    format!("many_pyramids:rows={rows}:columns={}:base=10", columns(rows).max(1))
}

/// What is to be measured.
pub struct Plan {
    series: Vec<&'static Series>,
    sizes: Vec<u32>,
    most: u32,
    players: Vec<Player>,
    setup: Setup,
}

impl Plan {
    /// What the arguments say.
    ///
    /// # Errors
    /// Arguments that make no sense.
    pub fn new(arguments: &Arguments, kinds: &[Kind], setup: &Setup) -> Result<Self> {
        let threads = if arguments.threads.is_empty() { &[1, 2] } else { arguments.threads.as_slice() };
        let most = arguments.max_bodies;
        let sizes = if arguments.sizes.is_empty() { SIZES.to_vec() } else { arguments.sizes.clone() };
        ensure!(sizes.windows(2).all(|w| w[0] < w[1]), "--sizes must rise");
        ensure!(sizes[0] <= most, "--max-bodies {most} leaves none of the sizes, the least is {}", sizes[0]);
        Ok(Self {
            series: chosen(&arguments.series)?,
            sizes: sizes.into_iter().filter(|&n| n <= most).collect(),
            most,
            players: lockstep::players(kinds, threads),
            setup: setup.clone(),
        })
    }

    /// The numbers along a series, bodies or bodies in an island, and the scene of each.
    fn scenes(&self, series: &Series) -> Vec<(u32, String)> {
        let total = self.most.min(TOTAL);
        match series.axis {
            Axis::Bodies => self.sizes.iter().map(|&n| (n, (series.scene)(n, n))).collect(),
            Axis::IslandSize => island_sizes(total).into_iter().map(|n| (n, (series.scene)(n, total))).collect(),
        }
    }
}

/// Powers of ten, and all bodies in one.
fn island_sizes(total: u32) -> Vec<u32> {
    let powers = (0..6).map(|power| 10_u32.pow(power)).take_while(|&size| size < total);
    powers.chain([total]).collect()
}

/// Series by their names; all without any.
fn chosen(names: &[String]) -> Result<Vec<&'static Series>> {
    let mut list: Vec<&Series> = Vec::new();
    for name in names {
        let Some(series) = SERIES.iter().find(|s| s.name == name) else {
            let known: Vec<&str> = SERIES.iter().map(|s| s.name).collect();
            bail!("there is no series `{name}`; there are {}", known.join(", "));
        };
        ensure!(!list.iter().any(|s| s.name == name), "series `{name}` is given twice");
        list.push(series);
    }
    Ok(if list.is_empty() { SERIES.iter().collect() } else { list })
}

/// Measures and reports.
///
/// # Errors
/// A scene that an engine cannot build, files that cannot be written.
pub fn perform(arguments: &Arguments, plan: &Plan) -> Result<()> {
    if !arguments.json {
        say(&report::table_head())?;
    }
    let mut rows = Vec::new();
    for series in &plan.series {
        let mut players = plan.players.clone();
        for (number, name) in plan.scenes(series) {
            if players.is_empty() {
                break;
            }
            let new = measure(arguments, plan, series, (number, &name), &players)?;
            // Who has no time for a scene has none for a larger one.
            let in_time = |p: &Player| new.iter().any(|r| r.is_of(p) && r.ms_median.is_some());
            if series.axis == Axis::Bodies {
                players.retain(in_time);
            }
            if !arguments.json {
                new.iter().try_for_each(|row| say(&report::table_line(row)))?;
            }
            rows.extend(new);
        }
    }
    if arguments.json {
        say(&serde_json::to_string_pretty(&rows)?)?;
    } else if arguments.phases {
        say(&report::stage_tables(&rows))?;
    }
    if let Some(path) = &arguments.csv {
        write(path, &report::csv(&rows))?;
    }
    if let Some(path) = &arguments.plot {
        write(path, &plot::draw(&rows))?;
    }
    Ok(())
}

/// All players in one scene of a series.
fn measure(
    arguments: &Arguments,
    plan: &Plan,
    series: &Series,
    (number, name): (u32, &str),
    players: &[Player],
) -> Result<Vec<Row>> {
    let scene = scenes::find(name)?.build()?;
    let course = Course {
        steps: series.warm_up + arguments.steps.unwrap_or(STEPS),
        turn: arguments.turn,
        warm_up: series.warm_up,
        limit: arguments.limit.unwrap_or(LIMIT),
        looks: Looks::AtEnd,
    };
    let setup = Setup { sleep: series.sleep || arguments.sleep, ..plan.setup.clone() };
    let progress = Progress::new(arguments.quiet);
    progress.log(&format!("{} {number}: {name}, {} steps", series.name, course.steps));
    let mut done = |steps| progress.tell(&format!("{} {number}: step {steps} of {}", series.name, course.steps));
    let runs = lockstep::run(&scene, players, &setup, &course, &mut done);
    progress.tell("");
    let runs = runs.with_context(|| format!("scene `{name}`"))?;
    let memory = |engine: &str, threads: u32| {
        if arguments.no_memory {
            return None;
        }
        progress.tell(&format!("{} {number}: memory of {engine}", series.name));
        let child =
            memory::Child { scene: name, threads, sleep: setup.sleep, set: &arguments.set, steps: course.steps };
        let peak = memory::measure(&child.arguments(course.limit.min(60.0)), engine);
        progress.tell("");
        peak
    };
    let point = Point { series, number, scene: name, bodies: dynamic(&scene), sleep: setup.sleep };
    Ok(report::rows(&point, &runs, memory))
}

/// Each value once, in the order in which they come.
fn distinct<T: PartialEq>(values: impl Iterator<Item = T>) -> Vec<T> {
    let mut list = Vec::new();
    for value in values {
        if !list.contains(&value) {
            list.push(value);
        }
    }
    list
}

fn dynamic(scene: &Scene) -> usize {
    scene.bodies.iter().filter(|b| b.dynamic).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::MOST;

    fn scene(series: &str, number: u32) -> Scene {
        let series = SERIES.iter().find(|s| s.name == series).unwrap();
        scenes::find(&(series.scene)(number, if series.axis == Axis::Bodies { number } else { TOTAL }))
            .unwrap()
            .build()
            .unwrap()
    }

    #[test]
    fn worlds_have_as_many_bodies_as_they_promise() {
        for series in SERIES.iter().filter(|s| s.axis == Axis::Bodies) {
            for n in SIZES {
                let bodies = dynamic(&scene(series.name, n)) as f64;
                let off = (bodies / f64::from(n) - 1.0).abs();
                assert!(off <= if series.name == "pyramids" { 0.02 } else { 0.0 }, "{} {n}: {bodies}", series.name);
            }
        }
    }

    #[test]
    fn the_least_and_the_largest_world_can_be_described() {
        for series in SERIES.iter().filter(|s| s.axis == Axis::Bodies) {
            assert!(dynamic(&scene(series.name, 100)) >= 55, "{}", series.name);
        }
        assert!(dynamic(&scene("pyramids", MOST)) > 490_000);
    }

    #[test]
    fn islands_are_cut_from_the_same_total() {
        assert_eq!(island_sizes(TOTAL), [1, 10, 100, 1000, 10_000, 20_000]);
        assert_eq!(island_sizes(1000), [1, 10, 100, 1000]);
        for size in island_sizes(TOTAL) {
            assert_eq!(dynamic(&scene("islands", size)), 20_000);
        }
    }

    #[test]
    fn each_value_comes_once_in_order() {
        assert_eq!(distinct([3, 1, 3, 2, 1].into_iter()), [3, 1, 2]);
    }

    #[test]
    fn a_series_that_is_not_known_says_what_is() {
        let names = |list: &[&str]| list.iter().map(ToString::to_string).collect::<Vec<_>>();
        assert_eq!(chosen(&[]).unwrap().len(), SERIES.len());
        assert_eq!(chosen(&names(&["sparse"])).unwrap()[0].name, "sparse");
        assert!(chosen(&names(&["heap"])).unwrap_err().to_string().contains("pyramids"));
        assert!(chosen(&names(&["pile", "pile"])).unwrap_err().to_string().contains("twice"));
    }
}
