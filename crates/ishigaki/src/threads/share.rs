//! Parts of a whole, given out to a team.
//!
//! Each thread takes first what lies where it took in other stages, so that bodies and blocks stay in the cache of one
//! core, then what others have left.

use super::Cut;
use arrayvec::ArrayVec;
use ishigaki_team::Team;
use std::sync::Mutex;

/// Shares that are given out one by one, at most; with more outputs some have several.
const MOST: usize = 64;

/// A part of the whole and where its outputs go.
type Share<'a, W, T> = (W, &'a mut [T]);

/// All shares; whoever takes one leaves nothing in its place.
struct Shares<'a, W, T>(ArrayVec<Mutex<Option<Share<'a, W, T>>>, MOST>);

/// Calls `work` with a part of `whole` for each output, side by side on the threads of a team.
pub(super) fn share_out<W: Cut, T: Send>(team: &Team, whole: W, outputs: &mut [T], work: &(impl Fn(W, &mut T) + Sync)) {
    let mut shares = Shares(ArrayVec::new());
    shares.fill(whole, outputs);
    team.meet(&|number| shares.take(number, team.threads(), work));
}

impl<'a, W: Cut, T: Send> Shares<'a, W, T> {
    /// Shares with as many outputs each; there are some. They are filled where they are: moving room for all of them takes
    /// longer than a meeting.
    fn fill(&mut self, whole: W, outputs: &'a mut [T]) {
        let count = outputs.len().min(MOST);
        let (mut whole, mut outputs) = (whole, outputs);
        for left in (2..=count).rev() {
            let size = outputs.len() / left;
            let (first, rest) = whole.cut(size, outputs.len());
            let (of_first, of_rest) = outputs.split_at_mut(size);
            self.0.push(Mutex::new(Some((first, of_first))));
            (whole, outputs) = (rest, of_rest);
        }
        self.0.push(Mutex::new(Some((whole, outputs))));
    }

    /// Works on what nobody has taken yet, from the place of this thread on.
    fn take(&self, number: usize, threads: usize, work: &impl Fn(W, &mut T)) {
        let count = self.0.len();
        let first = count * number / threads;
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
