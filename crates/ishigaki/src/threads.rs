//! Independent parts of a step on several threads. Which thread does what changes no bit: parts share nothing, and what
//! they leave is gathered in their order.

#[cfg(feature = "threads")]
mod share;

/// Threads of a world; none but the caller's unless they are asked for.
#[derive(Clone, Debug, Default)]
pub(crate) struct Workers {
    #[cfg(feature = "threads")]
    team: Option<std::sync::Arc<ishigaki_team::Team>>,
}

/// While it lives, threads that help are awake.
pub(crate) struct Awake {
    #[cfg(feature = "threads")]
    _team: Option<ishigaki_team::Awake>,
}

/// Fewer items than this are not worth a thread.
#[cfg(feature = "threads")]
const FEW: usize = 48;

impl Workers {
    /// Wakes those who help, for as long as what this gives lives.
    pub fn wake(&self) -> Awake {
        Awake {
            #[cfg(feature = "threads")]
            _team: self.team.as_ref().map(|team| team.wake()),
        }
    }

    /// Calls `work` for each item.
    pub fn for_each<T: Send>(&self, items: &mut [T], work: impl Fn(&mut T) + Sync + Send) {
        #[cfg(feature = "threads")]
        if let Some(team) = self.team.as_ref().filter(|_| items.len() > 1) {
            return share::share_out(team, (), items, &|(), item: &mut T| work(item));
        }
        items.iter_mut().for_each(work);
    }

    /// How many threads there are, the caller's among them.
    pub fn count(&self) -> usize {
        #[cfg(feature = "threads")]
        if let Some(team) = &self.team {
            return team.threads();
        }
        1
    }

    /// How many parts to cut `items` into: some for each thread, since parts take unequal times; one if there are few.
    pub fn parts(&self, items: usize) -> usize {
        #[cfg(feature = "threads")]
        if let Some(team) = &self.team {
            return (items / FEW).clamp(1, 8 * team.threads());
        }
        let _ = items;
        1
    }

    /// For work on so many items that leaves nothing but what it does to them.
    pub fn no_outputs(&self, items: usize) -> Vec<()> {
        vec![(); self.parts(items)]
    }

    /// Cuts `whole` into as many parts as there are outputs, and calls `work` for each part and its output.
    pub fn in_parts<W: Cut, T: Send>(&self, whole: W, outputs: &mut [T], work: impl Fn(W, &mut T) + Sync) {
        #[cfg(feature = "threads")]
        if let Some(team) = self.team.as_ref().filter(|_| outputs.len() > 1) {
            return share::share_out(team, whole, outputs, &work);
        }
        // One thread alone has one part of all: `parts`.
        match outputs {
            [output] => work(whole, output),
            _ => debug_assert!(outputs.is_empty()),
        }
    }
}

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

/// Of indices.
impl Cut for std::ops::Range<usize> {
    fn cut(self, part: usize, of: usize) -> (Self, Self) {
        let middle = self.start + self.len() * part / of;
        (self.start..middle, middle..self.end)
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
impl crate::World {
    /// Lets a step use this many threads, the caller's among them; 1 is where a world begins. The same bits for any
    /// number. A clone shares the threads; a world restored from a snapshot has none. During [`World::step`](crate::World::step), and some ten
    /// microseconds after it, they keep their cores busy, work or not; a world with fewer than 300 bodies awake is stepped by the caller alone.
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
        self.workers.team = match threads {
            0 => return Err(refused("must be at least 1, is 0".to_string())),
            1 => None,
            _ => Some(std::sync::Arc::new(
                ishigaki_team::Team::new(threads).map_err(|error| refused(error.to_string()))?,
            )),
        };
        Ok(())
    }

    /// Threads that a step uses.
    pub fn threads(&self) -> usize {
        self.workers.count()
    }
}

#[cfg(all(test, feature = "threads"))]
mod tests {
    /// Parts within parts, and more items than shares, so many steps that threads meet in every order.
    #[test]
    fn all_parts_are_done_once() {
        for threads in [2, 3, 5] {
            let mut world = crate::World::default();
            world.set_threads(threads).unwrap();
            let workers = &world.workers;
            let mut sums = [0_u64; 100];
            for _ in 0..3000 {
                let _awake = workers.wake();
                let mut items: Vec<u64> = (0..400).collect();
                let mut outputs = [0; 100];
                workers.in_parts(&mut items[..], &mut outputs, |part, output| {
                    workers.for_each(part, |item| *item = item.wrapping_mul(3));
                    *output = part.iter().sum();
                });
                sums.iter_mut().zip(outputs).for_each(|(sum, output)| *sum += output);
            }
            assert_eq!(sums.iter().sum::<u64>(), 3000 * 3 * (399 * 400 / 2));
        }
    }
}
