//! Independent parts of a step on several threads. Which thread does what changes no bit: parts share nothing, and what
//! they leave is gathered in their order.

/// Threads of a world; none unless they are asked for.
#[derive(Clone, Debug, Default)]
pub(crate) struct Workers {
    #[cfg(feature = "threads")]
    pool: Option<std::sync::Arc<rayon::ThreadPool>>,
}

impl Workers {
    /// Calls `work` on one of the threads, while the others stay awake to help: a step has many short parts, and to wake a
    /// thread takes longer than most of them.
    pub fn inside<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        #[cfg(feature = "threads")]
        if let Some(pool) = self.pool.as_ref().filter(|pool| pool.current_thread_index().is_none()) {
            return pool.install(|| {
                let _awake = Awake::keep(pool);
                work()
            });
        }
        work()
    }

    /// Calls `work` for each item.
    pub fn for_each<T: Send>(&self, items: &mut [T], work: impl Fn(&mut T) + Sync + Send) {
        #[cfg(feature = "threads")]
        if let Some(pool) = self.pool.as_ref().filter(|_| items.len() > 1) {
            pool.install(|| halve((), items, &|(), item: &mut T| work(item)));
            return;
        }
        items.iter_mut().for_each(work);
    }

    /// How many threads there are, the caller's among them.
    pub fn count(&self) -> usize {
        #[cfg(feature = "threads")]
        if let Some(pool) = &self.pool {
            return pool.current_num_threads();
        }
        1
    }

    /// How many parts to cut `items` into: some for each thread, since parts take unequal times; one if there are few.
    pub fn parts(&self, items: usize) -> usize {
        #[cfg(feature = "threads")]
        if let Some(pool) = &self.pool {
            return (items / FEW).clamp(1, 4 * pool.current_num_threads());
        }
        let _ = items;
        1
    }

    /// Cuts `whole` into as many parts as there are outputs, and calls `work` for each part and its output.
    pub fn in_parts<W: Cut, T: Send>(&self, whole: W, outputs: &mut [T], work: impl Fn(W, &mut T) + Sync) {
        #[cfg(feature = "threads")]
        if let Some(pool) = self.pool.as_ref().filter(|_| outputs.len() > 1) {
            pool.install(|| halve(whole, outputs, &work));
            return;
        }
        // One thread alone has one part of all: `parts`.
        match outputs {
            [output] => work(whole, output),
            _ => debug_assert!(outputs.is_empty()),
        }
    }
}

/// While it lives, the other threads of the pool look for work without pause. A thread that has a part in its hands, and
/// while it waits for a piece of that is offered to stay awake, refuses: it would wait for a step that waits for its part.
#[cfg(feature = "threads")]
struct Awake(std::sync::Arc<std::sync::atomic::AtomicBool>);

/// A thread that found no work so often lets others of the machine go first.
#[cfg(feature = "threads")]
const PATIENCE: u32 = 50;
#[cfg(feature = "threads")]
const PAUSE: u32 = 16;

#[cfg(feature = "threads")]
impl Awake {
    /// To be called on a thread of the pool, which goes on at once.
    fn keep(pool: &rayon::ThreadPool) -> Self {
        use std::sync::atomic::Ordering;
        let is_over = std::sync::Arc::new(std::sync::atomic::AtomicBool::new(false));
        let (awake, caller) = (Self(is_over.clone()), rayon::current_thread_index());
        pool.spawn_broadcast(move |context| {
            if AtWork::is_any() {
                return;
            }
            let mut idle = 0;
            while Some(context.index()) != caller && !is_over.load(Ordering::Relaxed) {
                if pool_has_work() {
                    idle = 0;
                } else if idle < PATIENCE {
                    idle += 1;
                    // Who looks without pause takes the lists of work out of the caches of those who work.
                    (0..PAUSE).for_each(|_| std::hint::spin_loop());
                } else {
                    idle = 0;
                    std::thread::yield_now();
                }
            }
        });
        awake
    }
}

#[cfg(feature = "threads")]
impl Drop for Awake {
    fn drop(&mut self) {
        self.0.store(true, std::sync::atomic::Ordering::Relaxed);
    }
}

#[cfg(feature = "threads")]
thread_local! {
    /// How many parts this thread has begun, one within the other.
    static PARTS: std::cell::Cell<u32> = const { std::cell::Cell::new(0) };
}

/// While it lives, its thread has a part in its hands.
#[cfg(feature = "threads")]
struct AtWork;

#[cfg(feature = "threads")]
impl AtWork {
    fn begin() -> Self {
        PARTS.set(PARTS.get() + 1);
        Self
    }

    fn is_any() -> bool {
        PARTS.get() > 0
    }
}

#[cfg(feature = "threads")]
impl Drop for AtWork {
    fn drop(&mut self) {
        PARTS.set(PARTS.get() - 1);
    }
}

/// Does one piece of what the pool has to do, if there is any.
#[cfg(feature = "threads")]
fn pool_has_work() -> bool {
    rayon::yield_now() == Some(rayon::Yield::Executed)
}

/// Fewer items than this are not worth a thread.
#[cfg(feature = "threads")]
const FEW: usize = 128;

/// What can be cut in two.
#[cfg_attr(not(feature = "threads"), allow(dead_code, reason = "one thread takes all"))]
pub(crate) trait Cut: Send + Sized {
    /// The first `part` of `of` parts, and the rest.
    fn cut(self, part: usize, of: usize) -> (Self, Self);
}

/// Nothing but outputs.
impl Cut for () {
    fn cut(self, _part: usize, _of: usize) -> (Self, Self) {
        ((), ())
    }
}

impl<A: Cut, B: Cut> Cut for (A, B) {
    fn cut(self, part: usize, of: usize) -> (Self, Self) {
        let ((a, other_a), (b, other_b)) = (self.0.cut(part, of), self.1.cut(part, of));
        ((a, b), (other_a, other_b))
    }
}

impl<T: Sync> Cut for &[T] {
    fn cut(self, part: usize, of: usize) -> (Self, Self) {
        self.split_at(self.len() * part / of)
    }
}

impl<T: Send> Cut for &mut [T] {
    fn cut(self, part: usize, of: usize) -> (Self, Self) {
        let middle = self.len() * part / of;
        self.split_at_mut(middle)
    }
}

#[cfg(feature = "threads")]
fn halve<W: Cut, T: Send>(whole: W, outputs: &mut [T], work: &(impl Fn(W, &mut T) + Sync)) {
    match outputs {
        [] => {}
        [output] => work(whole, output),
        _ => {
            let half = outputs.len() / 2;
            let (first, rest) = whole.cut(half, outputs.len());
            let (outputs_of_first, outputs_of_rest) = outputs.split_at_mut(half);
            both(|| halve(first, outputs_of_first, work), || halve(rest, outputs_of_rest, work));
        }
    }
}

/// Both, side by side on the threads that this is called on.
#[cfg(feature = "threads")]
fn both(a: impl FnOnce() + Send, b: impl FnOnce() + Send) {
    if rayon::current_thread_index().is_some() {
        let _at_work = AtWork::begin();
        let b = || {
            let _at_work = AtWork::begin();
            b();
        };
        rayon::join(a, b);
        return;
    }
    a();
    b();
}

#[cfg(feature = "threads")]
impl crate::World {
    /// Lets a step use this many threads, the caller's among them; 1 is where a world begins. The same bits for any
    /// number. A clone shares the threads; a world restored from a snapshot has none. During [`World::step`](crate::World::step) they keep their
    /// cores busy, work or not; a world with fewer than 1000 bodies awake is stepped by the caller alone.
    ///
    /// # Errors
    /// No threads, or more than the system gives.
    ///
    /// ```
    /// let mut world = ishigaki::World::default();
    /// world.set_threads(2)?;
    /// assert_eq!(world.threads(), 2);
    /// # Ok::<(), ishigaki::Error>(())
    /// ```
    pub fn set_threads(&mut self, threads: usize) -> crate::Result<()> {
        let refused = |why: String| crate::Error::invalid("threads", why);
        self.workers.pool = match threads {
            0 => return Err(refused("must be at least 1, is 0".to_string())),
            1 => None,
            _ => {
                let builder = rayon::ThreadPoolBuilder::new().num_threads(threads);
                Some(std::sync::Arc::new(builder.build().map_err(|error| refused(error.to_string()))?))
            }
        };
        Ok(())
    }

    /// Threads that a step uses.
    pub fn threads(&self) -> usize {
        self.workers.pool.as_ref().map_or(1, |pool| pool.current_num_threads())
    }
}

#[cfg(all(test, feature = "threads"))]
mod tests {
    /// Parts within parts, so many steps that threads meet in every order: one that waits for a part must not begin to
    /// wait for the end of the step.
    #[test]
    fn no_step_waits_for_itself() {
        for threads in [2, 3, 5] {
            let mut world = crate::World::default();
            world.set_threads(threads).unwrap();
            let workers = &world.workers;
            let mut sums = [0_u64; 12];
            for _ in 0..3000 {
                workers.inside(|| {
                    let mut items: Vec<u64> = (0..48).collect();
                    let mut outputs = [0; 12];
                    workers.in_parts(&mut items[..], &mut outputs, |part, output| {
                        workers.for_each(part, |item| *item = item.wrapping_mul(3));
                        *output = part.iter().sum();
                    });
                    sums.iter_mut().zip(outputs).for_each(|(sum, output)| *sum += output);
                });
            }
            assert_eq!(sums.iter().sum::<u64>(), 3000 * 3 * (47 * 48 / 2));
        }
    }
}
