//! Seeded mutations of good inputs: case `i` of seed `s` is the same on every machine.

use ishigaki_fuzz::corpus::{self, Seed};
use ishigaki_fuzz::mutate::{self, Random};
use ishigaki_fuzz::{Outcome, Target, check};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

const HELP: &str = "usage: cargo xtask fuzz [--seed N] [--iterations N | --seconds S] [--case N] [--target NAME]
  --seed N        the stream of mutations; default 1
  --iterations N  that many cases; default 10000
  --seconds S     as many cases as fit
  --case N        only this case, as named by a failure
  --target NAME   only scene_json, mjcf, urdf, snapshot or recording";

/// A case that takes longer hangs.
const PATIENCE: Duration = Duration::from_secs(60);
/// Failures that are shown before the run ends.
const MOST_FAILURES: usize = 10;

struct Options {
    seed: u64,
    cases: std::ops::Range<u64>,
    seconds: Option<u64>,
    target: Option<Target>,
}

fn main() -> ExitCode {
    let options = match parse(std::env::args().skip(1)) {
        Ok(options) => options,
        Err(message) => {
            eprintln!("{message}\n{HELP}");
            return ExitCode::from(2);
        }
    };
    // Library users may step on a thread: its stack is smaller than the main one, so recursion shows here first.
    let run = std::thread::spawn(move || run(&options));
    if run.join().unwrap_or(false) { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn parse(mut arguments: impl Iterator<Item = String>) -> Result<Options, String> {
    let mut options = Options { seed: 1, cases: 0..10_000, seconds: None, target: None };
    while let Some(flag) = arguments.next() {
        let value = arguments.next().ok_or_else(|| format!("{flag} needs a value"))?;
        let number = || value.parse::<u64>().map_err(|_| format!("{flag} {value}: must be a whole number"));
        match flag.as_str() {
            "--seed" => options.seed = number()?,
            "--iterations" => options.cases = 0..number()?,
            "--case" => options.cases = number()?..number()?.saturating_add(1),
            "--seconds" => (options.seconds, options.cases) = (Some(number()?), 0..u64::MAX),
            "--target" => {
                let target = Target::ALL.into_iter().find(|t| t.name() == value);
                options.target = Some(target.ok_or_else(|| format!("--target {value}: no such target"))?);
            }
            _ => return Err(format!("unknown option {flag}")),
        }
    }
    Ok(options)
}

#[expect(clippy::disallowed_methods, reason = "the ban is the engine's; this run ends by time")]
fn now() -> Instant {
    Instant::now()
}

/// Number of the case that runs; the watchdog ends the program if it stays.
static CASE: AtomicU64 = AtomicU64::new(u64::MAX);

fn watch(seed: u64, input: PathBuf) {
    std::thread::spawn(move || {
        let (mut last, mut since) = (u64::MAX, now());
        loop {
            std::thread::sleep(Duration::from_secs(1));
            let case = CASE.load(Ordering::Relaxed);
            if case != last {
                (last, since) = (case, now());
            } else if since.elapsed() > PATIENCE {
                eprintln!("HANGS: --seed {seed} --case {case}; the input is in {}", input.display());
                std::process::exit(1);
            }
        }
    });
}

fn run(options: &Options) -> bool {
    let folder = PathBuf::from(std::env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into())).join("fuzz");
    // Where the input is found if the process is killed or aborts.
    let current = folder.join("current");
    if let Err(e) = std::fs::create_dir_all(&folder) {
        eprintln!("{}: {e}", folder.display());
        return false;
    }
    let mut seeds = corpus::all();
    seeds.retain(|seed| options.target.is_none_or(|target| target == seed.target));
    if seeds.is_empty() {
        eprintln!("no seeds for this target");
        return false;
    }
    watch(options.seed, current.clone());

    let start = now();
    let (mut outcomes, mut failures, mut cases) = ([[0u64; 3]; Target::ALL.len()], Vec::new(), 0u64);
    for case in options.cases.clone() {
        if options.seconds.is_some_and(|s| start.elapsed() >= Duration::from_secs(s)) || failures.len() == MOST_FAILURES
        {
            break;
        }
        CASE.store(case, Ordering::Relaxed);
        let (seed, input) = input_of(options.seed, case, &seeds);
        if let Err(e) = std::fs::write(&current, &input) {
            eprintln!("{}: {e}", current.display());
            return false;
        }
        match catch_unwind(AssertUnwindSafe(|| check(seed.target, &input))) {
            Ok(outcome) => outcomes[seed.target as usize][outcome as usize] += 1,
            Err(_) => {
                let kept = folder.join(format!("{}-{}-{case}", seed.target.name(), options.seed));
                let kept_or_lost =
                    std::fs::write(&kept, &input).map_or_else(|e| e.to_string(), |()| kept.display().to_string());
                eprintln!(
                    "FAILED: --seed {} --case {case} ({} from {}); the input is in {kept_or_lost}",
                    options.seed,
                    seed.target.name(),
                    seed.name
                );
                failures.push(case);
            }
        }
        cases += 1;
    }
    for target in Target::ALL {
        let count = |outcome: Outcome| outcomes[target as usize][outcome as usize];
        println!(
            "fuzz: {:<10} {:>6} stepped, {:>6} refused, {:>6} too large",
            target.name(),
            count(Outcome::Stepped),
            count(Outcome::Refused),
            count(Outcome::TooLarge)
        );
    }
    println!(
        "fuzz: seed {}, {} good inputs, {cases} cases in {:.1} s, {} failed",
        options.seed,
        seeds.len(),
        start.elapsed().as_secs_f64(),
        failures.len()
    );
    failures.is_empty()
}

/// The input of a case: first every good input as it is, then mutations.
fn input_of(seed: u64, case: u64, seeds: &[Seed]) -> (&Seed, Vec<u8>) {
    if let Some(good) = usize::try_from(case).ok().and_then(|i| seeds.get(i)) {
        return (good, good.data.clone());
    }
    let mut random = Random::new(seed, case);
    // Few mutated snapshots: the checksum refuses all but one in four billion.
    let mut good = &seeds[random.below(seeds.len())];
    if good.target == Target::Snapshot && random.below(8) > 0 {
        good = &seeds[random.below(seeds.len())];
    }
    let input = match good.target {
        Target::Snapshot | Target::Recording => mutate::bytes(&mut random, &good.data),
        Target::SceneJson if random.below(10) > 0 => match serde_json::from_slice(&good.data) {
            Ok(tree) => mutate::json(&mut random, &tree).into_bytes(),
            // An input that is wrong on purpose.
            Err(_) => mutate::text(&mut random, &good.data),
        },
        _ => mutate::text(&mut random, &good.data),
    };
    (good, input)
}
