//! Parts of a whole, given out to a team.
//!
//! Each thread takes first what lies where it took in other stages, so that bodies and blocks stay in the cache of one
//! core, then what others have left. The caller waits without sleeping: to be woken takes longer than most parts.

use super::Cut;
use super::team::Team;
use arrayvec::ArrayVec;
use std::cell::Cell;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Shares that are given out one by one, at most; with more outputs some have several.
const MOST: usize = 64;
/// Pauses, some ten microseconds, after which others of the machine may go first.
const PATIENCE: u32 = 1000;
/// Pauses in which a helper that is done leaves its job.
const LEAVING: u32 = 8;

thread_local! {
    /// This thread works on a share: parts of that are its own.
    static IS_AT_WORK: Cell<bool> = const { Cell::new(false) };
}

/// A part of the whole and where its outputs go.
type Share<'a, W, T> = (W, &'a mut [T]);

/// All shares; whoever takes one leaves nothing in its place.
struct Shares<'a, W, T>(ArrayVec<Mutex<Option<Share<'a, W, T>>>, MOST>);

/// Calls `work` with a part of `whole` for each output, side by side on the threads of a team.
pub(super) fn share_out<W: Cut, T: Send>(team: &Team, whole: W, outputs: &mut [T], work: &(impl Fn(W, &mut T) + Sync)) {
    let helpers = team.awake().min(outputs.len() - 1);
    if helpers == 0 || IS_AT_WORK.get() || team.helper().is_some() {
        return work_on((whole, outputs), work);
    }
    let shares = Shares::new(whole, outputs);
    let at_work = AtomicUsize::new(helpers);
    team.helpers.in_place_scope(|scope| {
        for _ in 0..helpers {
            scope.spawn(|_| {
                let _done = Done(&at_work);
                shares.take(team, work);
            });
        }
        shares.take(team, work);
        // Nothing is left to take: what is not done is in the hands of helpers.
        wait_for(&at_work);
        // A scope that finds a helper still inside sleeps until it is out.
        (0..LEAVING).for_each(|_| std::hint::spin_loop());
    });
}

impl<'a, W: Cut, T: Send> Shares<'a, W, T> {
    /// Shares with as many outputs each; there are some.
    fn new(whole: W, outputs: &'a mut [T]) -> Self {
        let count = outputs.len().min(MOST);
        let (mut whole, mut outputs) = (whole, outputs);
        let mut shares = ArrayVec::new();
        for left in (2..=count).rev() {
            let size = outputs.len() / left;
            let (first, rest) = whole.cut(size, outputs.len());
            let (of_first, of_rest) = outputs.split_at_mut(size);
            shares.push(Mutex::new(Some((first, of_first))));
            (whole, outputs) = (rest, of_rest);
        }
        shares.push(Mutex::new(Some((whole, outputs))));
        Self(shares)
    }

    /// Works on what nobody has taken yet, from the place of this thread on.
    fn take(&self, team: &Team, work: &impl Fn(W, &mut T)) {
        let _at_work = AtWork::begin();
        let number = team.helper().map_or(0, |helper| helper + 1);
        let count = self.0.len();
        let first = count * number / team.threads();
        for k in 0..count {
            // Whoever holds the lock is about to take it.
            let share = self.0[(first + k) % count].try_lock().ok().and_then(|mut share| share.take());
            if let Some(share) = share {
                work_on(share, work);
            }
        }
    }
}

/// Its outputs, one by one.
fn work_on<W: Cut, T>((mut whole, mut outputs): Share<'_, W, T>, work: &impl Fn(W, &mut T)) {
    while outputs.len() > 1 {
        let (first, rest) = whole.cut(1, outputs.len());
        let (of_first, of_rest) = outputs.split_at_mut(1);
        work(first, &mut of_first[0]);
        (whole, outputs) = (rest, of_rest);
    }
    if let [output] = outputs {
        work(whole, output);
    }
}

/// Without sleeping; where a helper seems to wait for a core, it may have this one.
fn wait_for(helpers: &AtomicUsize) {
    let mut waited = 0;
    while helpers.load(Ordering::Acquire) > 0 {
        if waited < PATIENCE {
            waited += 1;
            std::hint::spin_loop();
        } else {
            waited = 0;
            std::thread::yield_now();
        }
    }
}

/// While it lives, its thread works on a share.
struct AtWork;

impl AtWork {
    fn begin() -> Self {
        IS_AT_WORK.set(true);
        Self
    }
}

impl Drop for AtWork {
    fn drop(&mut self) {
        IS_AT_WORK.set(false);
    }
}

/// Counts a helper as done when it goes, also where the work panics: the caller waits for it.
struct Done<'a>(&'a AtomicUsize);

impl Drop for Done<'_> {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Release);
    }
}
