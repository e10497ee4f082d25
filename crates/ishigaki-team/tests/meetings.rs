//! Meetings in which helpers come, come late or do not come; also run by Miri.

use ishigaki_team::Team;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

const MEETINGS: usize = if cfg!(miri) { 40 } else { 20_000 };

/// Gives the numbers below `count` out one by one.
fn share_out(next: &AtomicUsize, count: usize, mut each: impl FnMut(usize)) {
    while let Some(item) = Some(next.fetch_add(1, Ordering::Relaxed)).filter(|&item| item < count) {
        each(item);
    }
}

#[test]
fn all_is_done_once_when_a_meeting_is_over() {
    for threads in [1, 2, 3, 5] {
        let team = Team::new(threads).unwrap();
        assert_eq!(team.threads(), threads);
        let awake = team.wake();
        for meeting in 0..MEETINGS {
            // On the caller's stack: whoever looks at it after the meeting is found out.
            let items: Vec<Mutex<usize>> = (0..7).map(Mutex::new).collect();
            let next = AtomicUsize::new(0);
            team.meet(&|number| {
                assert!(number < threads);
                share_out(&next, items.len(), |item| *items[item].lock().unwrap() += meeting);
            });
            let items: Vec<usize> = items.into_iter().map(|item| item.into_inner().unwrap()).collect();
            assert_eq!(items, (meeting..meeting + 7).collect::<Vec<_>>());
        }
        drop(awake);
    }
}

/// Each thread works until it has seen the others.
#[test]
fn helpers_come() {
    let team = Team::new(3).unwrap();
    let _awake = team.wake();
    let present = [const { AtomicUsize::new(0) }; 3];
    team.meet(&|number| {
        present[number].fetch_add(1, Ordering::Relaxed);
        while present.iter().any(|times| times.load(Ordering::Relaxed) == 0) {
            std::thread::yield_now();
        }
    });
    assert!(present.iter().all(|times| times.load(Ordering::Relaxed) == 1));
}

#[test]
fn nobody_comes_who_sleeps() {
    let team = Team::new(2).unwrap();
    for _ in 0..3 {
        drop(team.wake());
        let calls = Mutex::new(Vec::new());
        team.meet(&|number| calls.lock().unwrap().push(number));
        assert_eq!(calls.into_inner().unwrap(), [0]);
    }
}

/// Within a meeting, and from another thread while the team meets, work is the caller's own.
#[test]
fn meetings_within_meetings() {
    let team = Team::new(2).unwrap();
    let _awake = team.wake();
    let inner = AtomicUsize::new(0);
    team.meet(&|_| {
        let numbers = Mutex::new(Vec::new());
        team.meet(&|number| numbers.lock().unwrap().push(number));
        assert_eq!(numbers.into_inner().unwrap(), [0]);
        inner.fetch_add(1, Ordering::Relaxed);
        std::thread::scope(|scope| {
            scope.spawn(|| team.meet(&|number| assert_eq!(number, 0)));
        });
    });
    assert!((1..=2).contains(&inner.into_inner()));
}

#[test]
fn a_panic_reaches_the_caller_and_leaves_the_team_as_it_was() {
    let team = Team::new(2).unwrap();
    let _awake = team.wake();
    let meet = |who: usize| {
        let has_come = AtomicUsize::new(0);
        let met = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            team.meet(&|number| {
                has_come.fetch_add(1, Ordering::Relaxed);
                while has_come.load(Ordering::Relaxed) < 2 {
                    std::thread::yield_now();
                }
                if number == who {
                    std::panic::resume_unwind(Box::new(number));
                }
            });
        }));
        met.map_err(|panic| *panic.downcast::<usize>().unwrap())
    };
    assert_eq!([meet(0), meet(1), meet(2)], [Err(0), Err(1), Ok(())]);
}

#[test]
fn teams_end() {
    for threads in 1..4 {
        let team = Team::new(threads).unwrap();
        let awake = team.wake();
        drop(team);
        drop(awake);
    }
}
