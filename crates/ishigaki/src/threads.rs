//! Independent parts of a step on several threads. Which thread does what changes no bit: parts share nothing, and what
//! they leave is gathered in their order.

/// Threads of a world; none unless they are asked for.
#[derive(Clone, Debug, Default)]
pub(crate) struct Workers {
    #[cfg(feature = "threads")]
    pool: Option<std::sync::Arc<rayon::ThreadPool>>,
}

impl Workers {
    /// Calls `work` for each item.
    pub fn for_each<T: Send>(&self, items: &mut [T], work: impl Fn(&mut T) + Sync + Send) {
        #[cfg(feature = "threads")]
        if let Some(pool) = self.pool.as_ref().filter(|_| items.len() > 1) {
            use rayon::prelude::*;
            pool.install(|| items.par_iter_mut().with_max_len(1).for_each(work));
            return;
        }
        items.iter_mut().for_each(work);
    }
}

#[cfg(feature = "threads")]
impl crate::World {
    /// Lets a step use this many threads, the caller's among them; 1 is where a world begins. The same bits for any
    /// number. A clone shares the threads; a world restored from a snapshot has none.
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
