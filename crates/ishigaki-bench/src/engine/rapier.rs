//! Rapier, from the shared libraries that build.rs makes of `peers/rapier`.

use super::{Engine, Setup, State};
use crate::scene::Scene;
use anyhow::{Context, bail, ensure};
use libloading::{Library, Symbol};
use std::ffi::c_void;

const SERIAL: &str = env!("BENCH_RAPIER_SERIAL");
const PARALLEL: Option<&str> = option_env!("BENCH_RAPIER_PARALLEL");

pub fn about() -> String {
    let lanes = open(SERIAL).map_or(0, |l| l.lanes);
    format!("0.36.1, default parameters (4 iterations), {lanes} lanes, {}, fat LTO", env!("BENCH_RAPIER_FLAGS"))
}

type Create = unsafe extern "C" fn(*const u8, usize, u32, bool) -> *mut c_void;
type Step = unsafe extern "C" fn(*mut c_void, u32) -> bool;
type States = unsafe extern "C" fn(*const c_void, *mut f64);
type Destroy = unsafe extern "C" fn(*mut c_void);

/// The functions of one library.
struct Functions {
    create: Create,
    step: Step,
    states: States,
    destroy: Destroy,
    lanes: u32,
}

#[allow(unsafe_code)]
fn open(path: &str) -> anyhow::Result<Functions> {
    // SAFETY: the library is our own; loading it runs no code but Rust's.
    let library = unsafe { Library::new(path) }.with_context(|| format!("{path}: build the bench again"))?;
    // Never closed: threads of Rapier's pool may outlive a world, and `Functions` outlives this function.
    let library: &'static Library = Box::leak(Box::new(library));
    // SAFETY: the names and types are those of peers/rapier/src/lib.rs.
    unsafe {
        let lanes: Symbol<unsafe extern "C" fn() -> u32> = library.get(b"rapier_lanes")?;
        Ok(Functions {
            create: *library.get::<Create>(b"rapier_create")?,
            step: *library.get::<Step>(b"rapier_step")?,
            states: *library.get::<States>(b"rapier_states")?,
            destroy: *library.get::<Destroy>(b"rapier_destroy")?,
            lanes: lanes(),
        })
    }
}

struct Rapier {
    functions: Functions,
    world: *mut c_void,
    /// Numbers of all states, reused.
    numbers: Vec<f64>,
    failed: bool,
}

#[allow(unsafe_code)]
pub fn build(scene: &Scene, setup: &Setup) -> anyhow::Result<Box<dyn Engine>> {
    ensure!(scene.excluded.is_empty(), "Rapier excludes pairs without a joint only by a hook in every step");
    let path = match (setup.threads, PARALLEL) {
        (1, _) => SERIAL,
        (_, Some(path)) => path,
        (threads, None) => bail!("{threads} threads need the feature `rapier-parallel`"),
    };
    let functions = open(path)?;
    let json = serde_json::to_vec(scene)?;
    // SAFETY: pointer and length are those of one vector, which the function only reads while it runs.
    let world = unsafe { (functions.create)(json.as_ptr(), json.len(), setup.threads, setup.sleep) };
    ensure!(!world.is_null(), "Rapier cannot build the scene");
    Ok(Box::new(Rapier { functions, world, numbers: vec![0.0; 13 * scene.bodies.len()], failed: false }))
}

impl Engine for Rapier {
    #[allow(unsafe_code)]
    fn step(&mut self, steps: u32) {
        // A world in which Rapier panicked stands still: the meter sees bodies that do not move, the table says why.
        if !self.failed {
            // SAFETY: `world` lives as long as `self`.
            self.failed = !unsafe { (self.functions.step)(self.world, steps) };
        }
    }

    #[allow(unsafe_code)]
    fn states(&mut self, states: &mut Vec<State>) {
        // SAFETY: `world` lives as long as `self`; `numbers` holds 13 for each body.
        unsafe { (self.functions.states)(self.world, self.numbers.as_mut_ptr()) };
        super::unpack(&self.numbers, states);
        if self.failed {
            // Not a number: the worst of all measures.
            states.iter_mut().for_each(|s| s.position = [f64::NAN; 3]);
        }
    }
}

impl Drop for Rapier {
    #[allow(unsafe_code)]
    fn drop(&mut self) {
        // SAFETY: made by `create`, dropped once.
        unsafe { (self.functions.destroy)(self.world) };
    }
}
