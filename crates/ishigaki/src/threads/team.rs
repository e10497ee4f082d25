//! The threads that help the caller of a step. They sleep between steps; during a step they look for work without pause,
//! since to wake one takes longer than most parts of a step.
//!
//! The caller is one of the team and works where it is: were it to wait for another thread to take the step, a system
//! that wakes threads where they last ran would put two of them on one core, and leave its own idle.

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// A thread that found no work so often lets others of the machine go first.
const PATIENCE: u32 = 50;
/// Who looks without pause takes the lists of work out of the caches of those who work.
const PAUSE: u32 = 16;

/// Threads beside the caller's.
#[derive(Debug)]
pub(super) struct Team {
    pub helpers: ThreadPool,
    /// Helpers that look for work.
    awake: AtomicUsize,
}

impl Team {
    /// So many threads, the caller's among them; two at least.
    pub fn new(threads: usize) -> Result<Self, ThreadPoolBuildError> {
        let helpers = ThreadPoolBuilder::new().num_threads(threads - 1).build()?;
        Ok(Self { helpers, awake: AtomicUsize::new(0) })
    }

    /// How many threads there are, the caller's among them.
    pub fn threads(&self) -> usize {
        self.helpers.current_num_threads() + 1
    }

    /// Helpers that would take a part at once.
    pub fn awake(&self) -> usize {
        self.awake.load(Ordering::Relaxed)
    }

    /// Number of this thread, from 0, if it helps.
    pub fn helper(&self) -> Option<usize> {
        self.helpers.current_thread_index()
    }
}

/// While it lives, the helpers of a team are awake.
pub(super) struct Awake(Arc<AtomicBool>);

impl Awake {
    /// Wakes them; who calls this goes on at once.
    pub fn keep(team: &Arc<Team>) -> Self {
        let is_over = Arc::new(AtomicBool::new(false));
        let awake = Self(is_over.clone());
        let of_team = team.clone();
        team.helpers.spawn_broadcast(move |_| {
            of_team.awake.fetch_add(1, Ordering::Relaxed);
            let mut idle = 0;
            while !is_over.load(Ordering::Relaxed) {
                if rayon::yield_now() == Some(rayon::Yield::Executed) {
                    idle = 0;
                } else if idle < PATIENCE {
                    idle += 1;
                    (0..PAUSE).for_each(|_| std::hint::spin_loop());
                } else {
                    idle = 0;
                    std::thread::yield_now();
                }
            }
            of_team.awake.fetch_sub(1, Ordering::Relaxed);
        });
        awake
    }
}

impl Drop for Awake {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}
