//! Calls of Python functions from the threads of a diagnosis, all of them on the thread that started it.
//!
//! Simulation codes need not be safe on several threads, and Python delivers Ctrl-C to its main thread alone. So the
//! diagnosis runs beside the thread of the user, which serves its calls one by one, and holds the interpreter only
//! then.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use pyo3::exceptions::PyException;
use pyo3::prelude::*;
use symplint::{Block, StepFailure};

use crate::memory::{Loan, lend};

/// How often Python may look whether Ctrl-C was pressed, where nothing else happens.
pub const SIGNALS: Duration = Duration::from_millis(50);

/// Whether all states are finite now, or why they were not advanced.
pub type Answer = Result<bool, StepFailure>;

/// What is asked of the thread of the user.
pub enum Call {
    /// Advance the states of a block.
    Step(f64, Loan<Answer>),
    /// Put the states of a block on the constraint manifold.
    Project(Loan<Answer>),
    /// Write the states of a loop at these parameters.
    Loop(Vec<f64>, Loan<Answer>),
    /// So many more points will be measured.
    Planned(usize),
    /// A point was measured, at this step size.
    Measured(f64),
    /// There will be no more calls.
    Finished,
}

/// Where the threads of a diagnosis send their calls.
pub struct Caller {
    calls: Mutex<Sender<Call>>,
    /// Set when the user stops the diagnosis: no more calls.
    stopped: AtomicBool,
}

impl Caller {
    /// Whether the user stopped the diagnosis.
    pub fn is_stopped(&self) -> bool {
        self.stopped.load(Ordering::Relaxed)
    }

    /// No more calls.
    fn stop(&self) {
        self.stopped.store(true, Ordering::Relaxed);
    }

    /// Lends a block for a call, and waits for the answer.
    ///
    /// # Errors
    /// That of the call; if the diagnosis was stopped.
    pub fn lend(&self, block: &mut Block<'_>, call: impl FnOnce(Loan<Answer>) -> Call) -> Answer {
        if self.is_stopped() {
            return Err(stopped());
        }
        lend(block, |loan| self.tell(call(loan))).unwrap_or_else(|| Err(stopped()))
    }

    /// Sends a call without waiting.
    pub fn tell(&self, call: Call) {
        let calls = self.calls.lock().unwrap_or_else(PoisonError::into_inner);
        // Nobody listens any more only if the diagnosis was stopped.
        let _ = calls.send(call);
    }
}

/// The failure of a step that is not taken because the diagnosis was stopped.
pub fn stopped() -> StepFailure {
    StepFailure {
        sample: 0,
        reason: "the diagnosis was stopped".to_owned(),
    }
}

/// Runs `work` beside this thread, which serves its calls meanwhile.
///
/// # Errors
/// What stops the diagnosis: an exception that `serve` returns, or the one that Ctrl-C raises.
pub fn run<R: Send>(
    py: Python<'_>,
    work: impl FnOnce(&Caller) -> R + Send,
    mut serve: impl FnMut(Python<'_>, Call) -> PyResult<()>,
) -> PyResult<R> {
    let (sender, mut calls) = channel();
    let caller = Caller {
        calls: Mutex::new(sender),
        stopped: AtomicBool::new(false),
    };
    std::thread::scope(|scope| {
        let caller = &caller;
        let worker = scope.spawn(move || {
            let _finished = Finished(caller);
            work(caller)
        });
        let mut stopped_by = None;
        loop {
            let next;
            (calls, next) = py.detach(move || {
                let next = calls.recv_timeout(SIGNALS);
                (calls, next)
            });
            let served = match next {
                Ok(Call::Finished) | Err(RecvTimeoutError::Disconnected) => break,
                Ok(call) if stopped_by.is_none() => serve(py, call),
                // A call is dropped, which tells whoever waits for it.
                Ok(_) | Err(RecvTimeoutError::Timeout) => Ok(()),
            };
            if let Err(error) = served.and_then(|()| py.check_signals()) {
                caller.stop();
                // After the first, which is the reason, Ctrl-C may be pressed again.
                stopped_by.get_or_insert(error);
            }
        }
        let result = py.detach(|| worker.join());
        match (stopped_by, result) {
            (Some(error), _) => Err(error),
            (None, Ok(result)) => Ok(result),
            (None, Err(panic)) => std::panic::resume_unwind(panic),
        }
    })
}

/// Says that the diagnosis is over, even if it panicked.
struct Finished<'a>(&'a Caller);

impl Drop for Finished<'_> {
    fn drop(&mut self) {
        self.0.tell(Call::Finished);
    }
}

/// Whether an exception ends a program where nothing catches it: Ctrl-C, `sys.exit`.
pub fn ends_programs(py: Python<'_>, error: &PyErr) -> bool {
    !error.is_instance_of::<PyException>(py)
}
