//! Threads for the work of the library.
//!
//! Never those of rayon's global pool. A process that was forked, as `multiprocessing` and web servers fork, has the pool of its
//! parent without the threads, and waits for them for ever. And a step that calls the library would wait for threads that
//! all wait for the step: so a diagnosis has its own threads, or that of the user alone, and everything else shares some.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};

use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::calls::SIGNALS;
use crate::error::other_error;

/// This number of new threads, or one for each processor, and never more: they would only take time to start.
///
/// # Errors
/// If there can be no threads, or a warning about their number is an error.
pub fn own(py: Python<'_>, threads: Option<usize>) -> PyResult<ThreadPool> {
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    if let Some(count) = threads.filter(|&count| count > processors) {
        let s = if processors == 1 { "" } else { "s" };
        let note = format!(
            "threads={count} exceeds the number of processors; {processors} thread{s} will be used"
        );
        let note = std::ffi::CString::new(note).expect("a text without zeros");
        PyErr::warn(py, &py.get_type::<PyUserWarning>(), &note, 2)?;
    }
    let count = threads.map_or(0, |count| count.min(processors));
    let pool = ThreadPoolBuilder::new().num_threads(count);
    (pool.build()).map_err(|error| other_error(py, &format!("cannot start threads: {error}")))
}

/// Makes this thread, as long as it lives, do by itself whatever it divides for several.
pub fn alone(py: Python<'_>) -> PyResult<()> {
    // It may be so already. A thread cannot leave a pool that it belongs to, so the pool is kept.
    if rayon::current_thread_index().is_none() {
        let pool = ThreadPoolBuilder::new().num_threads(1).use_current_thread();
        let pool = (pool.build()).map_err(|error| other_error(py, &error.to_string()))?;
        std::mem::forget(pool);
    }
    Ok(())
}

/// The threads that this process shares.
pub fn shared(py: Python<'_>) -> PyResult<&'static ThreadPool> {
    // With the process that it belongs to. Of another one the threads are not here, and it is never dropped.
    static SHARED: Mutex<Option<(u32, &'static ThreadPool)>> = Mutex::new(None);
    let process = std::process::id();
    // The interpreter is held as long as this is locked, and Python holds it when it forks.
    let mut shared = SHARED.lock().unwrap_or_else(PoisonError::into_inner);
    match *shared {
        Some((owner, pool)) if owner == process => Ok(pool),
        _ => {
            let pool = Box::leak(Box::new(own(py, None)?));
            *shared = Some((process, pool));
            Ok(pool)
        }
    }
}

/// Runs `work` on the shared threads. Ctrl-C ends the wait for it: then it continues, and what it finds is dropped.
///
/// # Errors
/// If there are no threads; the exception that a signal raises.
pub fn run<R: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce() -> R + Send + 'static,
) -> PyResult<R> {
    let (sender, mut results) = channel();
    shared(py)?.spawn(move || {
        // Nobody waits any more where a signal came.
        let _ = sender.send(catch_unwind(AssertUnwindSafe(work)));
    });
    loop {
        let next;
        (results, next) = py.detach(move || {
            let next = results.recv_timeout(SIGNALS);
            (results, next)
        });
        match next {
            Ok(Ok(result)) => return Ok(result),
            Ok(Err(panic)) => resume_unwind(panic),
            Err(RecvTimeoutError::Timeout) => py.check_signals()?,
            Err(RecvTimeoutError::Disconnected) => {
                return Err(other_error(py, "a thread ended without a result"));
            }
        }
    }
}
