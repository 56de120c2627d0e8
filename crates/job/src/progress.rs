//! A counter to watch a task by.

use std::sync::{
    Arc, Mutex, PoisonError,
    atomic::{AtomicU64, Ordering},
};

/// How far a task is. The task writes, anybody reads, at any time and from any thread.
///
/// A task goes through phases ("read", "extract", "write"), each with a total of its own.
#[derive(Clone, Debug, Default)]
pub struct Progress(Arc<State>);

#[derive(Debug, Default)]
struct State {
    phase: Mutex<&'static str>,
    done: AtomicU64,
    total: AtomicU64,
}

/// What [`Progress::snapshot`] saw.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Snapshot {
    /// The current phase; empty before the first.
    pub phase: &'static str,
    /// Units of work done in this phase.
    pub done: u64,
    /// Units of work in this phase; 0 if nobody knows.
    pub total: u64,
}

impl Progress {
    /// Begins a phase of `total` units of work.
    pub fn begin(&self, phase: &'static str, total: u64) {
        // A watcher that panicked while it read the name has not harmed the name.
        *self.0.phase.lock().unwrap_or_else(PoisonError::into_inner) = phase;
        self.0.done.store(0, Ordering::Relaxed);
        self.0.total.store(total, Ordering::Relaxed);
    }

    /// Reports `units` more of work done.
    pub fn advance(&self, units: u64) {
        self.0.done.fetch_add(units, Ordering::Relaxed);
    }

    /// The state now.
    pub fn snapshot(&self) -> Snapshot {
        Snapshot {
            phase: *self.0.phase.lock().unwrap_or_else(PoisonError::into_inner),
            done: self.0.done.load(Ordering::Relaxed),
            total: self.0.total.load(Ordering::Relaxed),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Progress, Snapshot};

    #[test]
    fn a_clone_watches_the_same_task() {
        let task = Progress::default();
        let watcher = task.clone();
        task.begin("read", 10);
        task.advance(3);
        task.advance(4);
        assert_eq!(watcher.snapshot(), Snapshot { phase: "read", done: 7, total: 10 });
    }
}
