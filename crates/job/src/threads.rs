//! How many threads, and whose pool.

use std::{num::NonZeroUsize, sync::Arc};

/// The threads of a task. Results never depend on how many there are.
#[derive(Clone, Debug, Default)]
pub struct Threads(Option<Arc<rayon::ThreadPool>>);

/// Why there are no threads.
#[derive(Debug, thiserror::Error)]
pub enum ThreadsError {
    /// The caller's fault: a machine that starts so many has no time for anything else.
    #[error("{count} threads were asked for, at most {} can be", Threads::MOST)]
    TooMany {
        /// How many were asked for.
        count: NonZeroUsize,
    },

    /// The system does not start them.
    #[error("cannot start {count} threads")]
    NotStarted {
        /// How many were asked for.
        count: NonZeroUsize,
        /// Its reason.
        source: rayon::ThreadPoolBuildError,
    },
}

impl Threads {
    /// More threads than this are taken for a mistake.
    pub const MOST: usize = 1024;

    /// A pool of `count` threads of its own.
    ///
    /// # Errors
    ///
    /// If that is more than [`MOST`](Self::MOST), or the system does not start them.
    pub fn new(count: NonZeroUsize) -> Result<Self, ThreadsError> {
        if count.get() > Self::MOST {
            return Err(ThreadsError::TooMany { count });
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count.get()).build();
        let pool = pool.map_err(|source| ThreadsError::NotStarted { count, source })?;
        Ok(Self(Some(Arc::new(pool))))
    }

    /// Runs `work`, and all that it does in parallel, on these threads.
    pub fn run<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        let Some(pool) = &self.0 else { return work() };
        let (mut work, mut result) = (Some(work), None);
        install(pool, &mut || result = work.take().map(|work| work()));
        result.expect("the pool does all work that it is given")
    }

    /// How many threads there are.
    pub fn count(&self) -> usize {
        match &self.0 {
            Some(pool) => pool.current_num_threads(),
            None => rayon::current_num_threads(),
        }
    }
}

/// Not generic, for the reason that [`Work`](crate::Work) has.
fn install(pool: &rayon::ThreadPool, work: &mut (dyn FnMut() + Send)) {
    pool.install(work);
}

#[cfg(test)]
mod tests {
    use super::Threads;
    use std::num::NonZeroUsize;

    #[test]
    fn a_mistyped_number_of_threads_starts_none() {
        let count = NonZeroUsize::new(100_000).unwrap();
        let error = Threads::new(count).unwrap_err();
        assert_eq!(error.to_string(), "100000 threads were asked for, at most 1024 can be");
    }

    #[test]
    fn work_runs_on_the_threads_asked_for() {
        let three = Threads::new(NonZeroUsize::new(3).unwrap()).unwrap();
        assert_eq!(three.count(), 3);
        assert_eq!(three.run(rayon::current_num_threads), 3);
    }
}
