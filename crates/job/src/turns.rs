//! Tasks that run at the same time and pass one point one after another, in their order.
//!
//! A task whose results go behind those of the task before must know how much that makes. If tasks begin in
//! their order, the one before is hardly ever later: so nobody waits long, and nobody is woken.

use crate::Work;
use rayon::prelude::*;
use std::{
    hint::spin_loop,
    sync::atomic::{AtomicBool, AtomicUsize, Ordering},
    thread,
};

/// The order of some tasks, and which of them is next.
///
/// ```
/// use isokit_job::Turns;
/// use std::sync::Mutex;
///
/// let (turns, said) = (Turns::default(), Mutex::new(vec![]));
/// let task = |(): &mut (), n: usize| {
///     let long = n * n; // what takes time is done at the same time
///     if turns.wait(n) {
///         said.lock().unwrap().push(long);
///         turns.pass();
///     }
///     Ok::<(), ()>(())
/// };
/// turns.run(4, 2, || (), task).unwrap();
/// assert_eq!(said.into_inner().unwrap(), [0, 1, 4, 9]);
/// ```
#[derive(Debug, Default)]
pub struct Turns {
    begun: AtomicUsize,
    passed: AtomicUsize,
    is_over: AtomicBool,
}

/// Looks before a thread that waits lets others go first.
const LOOKS: usize = 256;

impl Turns {
    /// Runs tasks `0..count`, which begin in this order, on at most so many threads of the pool that this is
    /// called in. Each thread makes what it needs for its tasks once.
    ///
    /// # Errors
    ///
    /// The error of a task; then no other begins, and who waits waits no longer.
    pub fn run<S, E: Send>(
        &self,
        count: usize,
        threads: usize,
        begin: impl Fn() -> S + Sync,
        task: impl Fn(&mut S, usize) -> Result<(), E> + Sync,
    ) -> Result<(), E> {
        let work: Work<'_, _, _> = &|_| {
            let _end = EndInPanic(self);
            let mut own = begin();
            while !self.is_over() {
                let n = self.begun.fetch_add(1, Ordering::Relaxed);
                if n >= count {
                    break;
                }
                task(&mut own, n).inspect_err(|_| self.end())?;
            }
            Ok(())
        };
        (0..threads.min(count)).into_par_iter().with_max_len(1).map(work).collect()
    }

    /// Waits until all tasks before `n` have passed. False if they never will.
    pub fn wait(&self, n: usize) -> bool {
        self.until(|| (self.passed.load(Ordering::Acquire) == n).then_some(())).is_some()
    }

    /// Lets the next one pass. To be called by the one whose turn it is.
    pub fn pass(&self) {
        self.passed.fetch_add(1, Ordering::Release);
    }

    /// Waits for something that a task which began before will do. Nothing if it never will.
    pub fn until<R>(&self, mut look: impl FnMut() -> Option<R>) -> Option<R> {
        for looks in 1.. {
            match look() {
                None if self.is_over() => break,
                None if looks % LOOKS == 0 => thread::yield_now(),
                None => spin_loop(),
                found => return found,
            }
        }
        None
    }

    /// No further task begins, and who waits waits no longer.
    pub fn end(&self) {
        self.is_over.store(true, Ordering::Release);
    }

    /// Whether somebody called [`end`](Self::end).
    pub fn is_over(&self) -> bool {
        self.is_over.load(Ordering::Acquire)
    }
}

/// Nobody waits for a thread that panics.
struct EndInPanic<'a>(&'a Turns);

impl Drop for EndInPanic<'_> {
    fn drop(&mut self) {
        if thread::panicking() {
            self.0.end();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Turns;
    use std::{
        panic::{AssertUnwindSafe, catch_unwind},
        sync::{Mutex, OnceLock},
    };

    #[test]
    fn tasks_pass_in_order_on_any_number_of_threads() {
        for threads in [1, 2, 7] {
            let (turns, passed) = (Turns::default(), Mutex::new(vec![]));
            let done: Vec<OnceLock<usize>> = (0..50).map(|_| OnceLock::new()).collect();
            let task = |tasks: &mut usize, n: usize| {
                *tasks += 1;
                done[n].set(n).unwrap();
                let before = n.checked_sub(1).map(|m| turns.until(|| done[m].get()).unwrap());
                assert_eq!(before.copied(), n.checked_sub(1));
                assert!(turns.wait(n));
                passed.lock().unwrap().push(n);
                turns.pass();
                Ok::<(), ()>(())
            };
            turns.run(50, threads, || 0, task).unwrap();
            assert!(passed.into_inner().unwrap().into_iter().eq(0..50));
        }
    }

    #[test]
    fn an_error_ends_it_for_all() {
        let turns = Turns::default();
        let task = |(): &mut (), n: usize| match n {
            3 => Err("three"),
            _ if turns.wait(n) => {
                turns.pass();
                Ok(())
            }
            _ => Ok(()),
        };
        assert_eq!(turns.run(1000, 4, || (), task), Err("three"));
        assert!(turns.is_over() && !turns.wait(1000));
    }

    #[test]
    fn nobody_waits_for_a_task_that_panics() {
        let turns = Turns::default();
        let task = |(): &mut (), n: usize| {
            assert_ne!(n, 0, "the first panics");
            assert!(!turns.wait(n), "it never passes");
            Ok::<(), ()>(())
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        let run = || pool.install(|| turns.run(2, 2, || (), task));
        assert!(catch_unwind(AssertUnwindSafe(run)).is_err());
    }
}
