//! How long a meeting takes in which everybody comes: `cargo run --release -p ishigaki-team --example meeting -- 2`.
//! Of threads that outnumber the cores it is the time until the system has let each of them run.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

const MEETINGS: u32 = 1000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let threads = std::env::args().nth(1).map_or(Ok(2), |argument| argument.parse())?;
    let team = ishigaki_team::Team::new(threads)?;
    let _awake = team.wake();
    let mut times: Vec<u128> = (0..21).map(|_| nanoseconds(&team)).collect();
    times.sort_unstable();
    println!("{} ns a meeting of {threads} ({} to {})", times[10], times[0], times[20]);
    Ok(())
}

/// Of one meeting, in the mean over many.
#[expect(clippy::disallowed_methods, reason = "it measures; the engine reads no clock")]
fn nanoseconds(team: &ishigaki_team::Team) -> u128 {
    let start = Instant::now();
    for _ in 0..MEETINGS {
        let present = AtomicUsize::new(0);
        team.meet(&|_| {
            present.fetch_add(1, Ordering::Relaxed);
            while present.load(Ordering::Relaxed) < team.threads() {
                std::hint::spin_loop();
            }
        });
    }
    start.elapsed().as_nanos() / u128::from(MEETINGS)
}
