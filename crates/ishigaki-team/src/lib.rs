//! Threads that meet in a fraction of a microsecond.
//!
//! A physics step has some hundred pieces of a few microseconds that several threads may share. Pools that put each piece
//! on a list cost a microsecond for it; here a [`Team`] has one piece at a time, and who helps looks for it without pause
//! while [`Awake`] lives and a moment longer, since one step often follows another; asleep otherwise. Nobody waits for who
//! comes late: a [`meeting`](Team::meet) is over when all that came have left, and all of them call the same function, which gives out what there is to do as it likes.
//!
//! ```
//! use std::sync::atomic::{AtomicUsize, Ordering};
//! let team = ishigaki_team::Team::new(2)?;
//! let _awake = team.wake();
//! let (next, sum) = (AtomicUsize::new(0), AtomicUsize::new(0));
//! team.meet(&|_thread| {
//!     loop {
//!         let item = next.fetch_add(1, Ordering::Relaxed);
//!         if item >= 100 {
//!             break;
//!         }
//!         sum.fetch_add(item, Ordering::Relaxed);
//!     }
//! });
//! assert_eq!(sum.into_inner(), 4950);
//! # Ok::<(), std::io::Error>(())
//! ```
//!
//! The only unsafe code of the engine is here: who may share a [`Team`], and how a meeting is opened and joined, under the eyes
//! of Miri.

use std::any::Any;
use std::cell::UnsafeCell;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, JoinHandle};

/// Pauses, some ten microseconds, after which others of the machine may go first.
const PATIENCE: u32 = 1000;

/// Pauses for which helpers stay up though nobody asked for it: as long.
const LINGER: u32 = PATIENCE;

/// What all who meet call, with their number.
type Work<'a> = dyn Fn(usize) + Sync + 'a;

/// Threads beside the caller's. They end when it is dropped.
pub struct Team {
    shared: Arc<Shared>,
    helpers: Vec<JoinHandle<()>>,
}

/// While it lives, the helpers of a team look for meetings without pause.
pub struct Awake(Arc<Shared>);

/// What the threads of a team have in common.
struct Shared {
    meeting: Meeting,
    /// Somebody calls to meetings, and nobody else may.
    is_called: AtomicBool,
    /// How many [`Awake`] live.
    awake: AtomicUsize,
    /// The team is dropped.
    is_over: AtomicBool,
    /// How many helpers sleep; the two above change under it.
    sleepers: Mutex<usize>,
    wakes: Condvar,
    /// What a helper's work left when it panicked.
    panic: Mutex<Option<Box<dyn Any + Send>>>,
}

/// What helpers look at while they wait: alone in its cache lines.
#[repr(align(128))]
struct Meeting {
    /// [`OPEN`](Self::OPEN) if there is one; how many helpers are inside, in units of [`INSIDE`](Self::INSIDE); its number, in
    /// units of [`NUMBER`](Self::NUMBER).
    state: AtomicU64,
    work: UnsafeCell<Option<&'static Work<'static>>>,
}

// SAFETY: all but `work` may be shared. Who has `Shared::is_called` alone writes it, before the meeting is open and while nobody
// is inside; helpers that are inside read it, which they become only while the meeting is open. `state` orders the two: it
// is released with `OPEN` after the writing, acquired by who goes inside, released by who leaves, acquired before `work` is
// written again. What it refers to is `Sync`.
#[allow(unsafe_code, reason = "the compiler cannot see who writes when")]
unsafe impl Sync for Meeting {}

impl Meeting {
    const OPEN: u64 = 1;
    const INSIDE: u64 = 2;
    const NUMBER: u64 = 1 << 16;
    const INSIDE_MASK: u64 = Self::NUMBER - Self::INSIDE;

    /// Lets helpers in. The caller has `Shared::is_called`, and does not let what it gives out go before `work` ends.
    #[allow(unsafe_code, reason = "helpers live longer than what they work on")]
    fn open<'a>(&'a self, work: &'a Work<'a>) -> Open<'a> {
        // SAFETY: the longer life is a pretence that nobody can use: `Open::drop` does not return before the meeting is closed
        // and the last helper has left, also when the caller's own work panics, and helpers keep nothing. `Open` is private
        // and never leaked.
        let work = unsafe { std::mem::transmute::<&'a Work<'a>, &'static Work<'static>>(work) };
        // SAFETY: no meeting is open and nobody is inside, as `Open::drop` left it; the caller alone may call.
        unsafe { *self.work.get() = Some(work) };
        let number = self.state.load(Ordering::Relaxed) & !(Self::NUMBER - 1);
        self.state.store(number.wrapping_add(Self::NUMBER) | Self::OPEN, Ordering::Release);
        Open(self)
    }

    /// Takes part in a meeting that is open, unless it is the `last` one of this helper; its number, if it was.
    #[allow(unsafe_code, reason = "the counterpart of `open`")]
    fn join(&self, last: u64, take_part: impl FnOnce(&Work<'_>)) -> Option<u64> {
        let seen = self.state.load(Ordering::Relaxed);
        let number = seen / Self::NUMBER;
        if seen & Self::OPEN == 0 || number == last {
            return None;
        }
        // Fails if the meeting was closed meanwhile, or another helper came.
        self.state.compare_exchange(seen, seen + Self::INSIDE, Ordering::Acquire, Ordering::Relaxed).ok()?;
        let _inside = Inside(self);
        // SAFETY: this thread is inside, so that `work` is not written; what it refers to lives until all have left.
        if let Some(work) = unsafe { *self.work.get() } {
            take_part(work);
        }
        Some(number)
    }
}

/// While it lives, helpers may come.
struct Open<'a>(&'a Meeting);

impl Drop for Open<'_> {
    /// Without sleeping; where a helper seems to wait for a core, it may have this one.
    fn drop(&mut self) {
        let state = &self.0.state;
        let mut seen = state.fetch_and(!Meeting::OPEN, Ordering::Acquire);
        let mut waited = 0;
        while seen & Meeting::INSIDE_MASK != 0 {
            waited = pause(waited);
            seen = state.load(Ordering::Acquire);
        }
    }
}

/// While it lives, a helper is inside.
struct Inside<'a>(&'a Meeting);

impl Drop for Inside<'_> {
    fn drop(&mut self) {
        self.0.state.fetch_sub(Meeting::INSIDE, Ordering::Release);
    }
}

/// Waits for a moment; how often it did without letting others go first.
fn pause(waited: u32) -> u32 {
    if waited < PATIENCE {
        std::hint::spin_loop();
        waited + 1
    } else {
        std::thread::yield_now();
        0
    }
}

impl std::fmt::Debug for Team {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Team").field("threads", &self.threads()).finish_non_exhaustive()
    }
}

impl Team {
    /// So many threads, the caller's among them; one at least.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn new(threads: usize) -> std::io::Result<Self> {
        let shared = Arc::new(Shared {
            meeting: Meeting { state: AtomicU64::new(0), work: UnsafeCell::new(None) },
            is_called: AtomicBool::new(false),
            awake: AtomicUsize::new(0),
            is_over: AtomicBool::new(false),
            sleepers: Mutex::new(0),
            wakes: Condvar::new(),
            panic: Mutex::new(None),
        });
        let mut team = Self { shared, helpers: Vec::new() };
        for number in 1..threads {
            let shared = team.shared.clone();
            let helper = Builder::new().name(format!("ishigaki-{number}")).spawn(move || shared.help(number))?;
            team.helpers.push(helper);
        }
        Ok(team)
    }

    /// How many threads there are, the caller's among them.
    pub fn threads(&self) -> usize {
        self.helpers.len() + 1
    }

    /// Wakes the helpers for as long as what this gives lives. Who calls it goes on at once.
    pub fn wake(&self) -> Awake {
        self.shared.wake(|shared| {
            shared.awake.fetch_add(1, Ordering::Relaxed);
        });
        Awake(self.shared.clone())
    }

    /// Calls `work` on this thread, with 0, and on each helper that comes while that lasts, with its number from 1 on. Returns
    /// when all of them are done. Alone where nobody is awake, or the team meets already.
    ///
    /// # Panics
    /// If `work` does, on any thread.
    pub fn meet(&self, work: &Work<'_>) {
        let shared = &*self.shared;
        if !shared.is_awake() || shared.is_called.swap(true, Ordering::Acquire) {
            return work(0);
        }
        let called = Called(&shared.is_called);
        let open = shared.meeting.open(work);
        work(0);
        drop(open);
        drop(called);
        let panic = shared.panic.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(panic) = panic {
            resume_unwind(panic);
        }
    }
}

/// While it lives, its thread alone calls to meetings.
struct Called<'a>(&'a AtomicBool);

impl Drop for Called<'_> {
    fn drop(&mut self) {
        self.0.store(false, Ordering::Release);
    }
}

impl Drop for Team {
    fn drop(&mut self) {
        self.shared.wake(|shared| shared.is_over.store(true, Ordering::Relaxed));
        for helper in self.helpers.drain(..) {
            // It catches what panics.
            let _ = helper.join();
        }
    }
}

impl Drop for Awake {
    fn drop(&mut self) {
        self.0.awake.fetch_sub(1, Ordering::Relaxed);
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, usize> {
        self.sleepers.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Tells helpers that something changed: none of them is between its look at it and its sleep.
    fn wake(&self, change: impl FnOnce(&Self)) {
        let sleepers = self.lock();
        change(self);
        let anyone_sleeps = *sleepers > 0;
        drop(sleepers);
        if anyone_sleeps {
            self.wakes.notify_all();
        }
    }

    fn is_over(&self) -> bool {
        self.is_over.load(Ordering::Relaxed)
    }

    fn is_awake(&self) -> bool {
        self.awake.load(Ordering::Relaxed) > 0
    }

    /// What a helper does until the team is dropped.
    fn help(&self, number: usize) {
        let take_part = |work: &Work<'_>| {
            if let Err(panic) = catch_unwind(AssertUnwindSafe(|| work(number))) {
                *self.panic.lock().unwrap_or_else(PoisonError::into_inner) = Some(panic);
            }
        };
        let (mut last, mut waited, mut lingered) = (0, 0, 0);
        while !self.is_over() {
            if self.is_awake() {
                lingered = 0;
                match self.meeting.join(last, take_part) {
                    Some(meeting) => (last, waited) = (meeting, 0),
                    None => waited = pause(waited),
                }
            } else if lingered < LINGER {
                std::hint::spin_loop();
                lingered += 1;
            } else {
                self.sleep();
            }
        }
    }

    /// Until the helpers are woken or their team is dropped.
    fn sleep(&self) {
        let mut sleepers = self.lock();
        *sleepers += 1;
        while !self.is_over() && !self.is_awake() {
            sleepers = self.wakes.wait(sleepers).unwrap_or_else(PoisonError::into_inner);
        }
        *sleepers -= 1;
    }
}
