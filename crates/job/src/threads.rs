//! How many threads, and whose pool.

use std::{num::NonZeroUsize, sync::Arc};

/// The threads of a task. Results never depend on how many there are.
#[derive(Clone, Debug, Default)]
pub struct Threads(Option<Arc<rayon::ThreadPool>>);

/// The system gave no threads.
#[derive(Debug, thiserror::Error)]
#[error("cannot start {count} threads")]
pub struct ThreadsError {
    /// How many were asked for.
    pub count: NonZeroUsize,
    source: rayon::ThreadPoolBuildError,
}

impl Threads {
    /// A pool of `count` threads of its own.
    ///
    /// # Errors
    ///
    /// If the system does not start them.
    pub fn new(count: NonZeroUsize) -> Result<Self, ThreadsError> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count.get()).build();
        Ok(Self(Some(Arc::new(pool.map_err(|source| ThreadsError { count, source })?))))
    }

    /// Runs `work`, and all that it does in parallel, on these threads.
    pub fn run<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        match &self.0 {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }

    /// How many threads there are.
    pub fn count(&self) -> usize {
        match &self.0 {
            Some(pool) => pool.current_num_threads(),
            None => rayon::current_num_threads(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Threads;
    use std::num::NonZeroUsize;

    #[test]
    fn work_runs_on_the_threads_asked_for() {
        let three = Threads::new(NonZeroUsize::new(3).unwrap()).unwrap();
        assert_eq!(three.count(), 3);
        assert_eq!(three.run(rayon::current_num_threads), 3);
    }
}
