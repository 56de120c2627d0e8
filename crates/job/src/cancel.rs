//! A token to stop a task with.

use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
};

/// Shared between a task and whoever may want to stop it.
///
/// A task looks at it between pieces of work that take milliseconds, so it stops soon, not at once.
#[derive(Clone, Debug, Default)]
pub struct CancelToken(Arc<AtomicBool>);

/// The task was stopped from outside; what it had begun is gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

impl CancelToken {
    /// Asks the task to stop. There is no way back.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether somebody asked.
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// The same as an error to leave with.
    ///
    /// # Errors
    ///
    /// [`Cancelled`] if somebody asked.
    pub fn check(&self) -> Result<(), Cancelled> {
        if self.is_cancelled() { Err(Cancelled) } else { Ok(()) }
    }
}
