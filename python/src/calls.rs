//! Calls of Python functions from a diagnosis, all of them on the thread that started it.
//!
//! Simulation codes need not be safe on several threads, and Python delivers Ctrl-C to its main thread alone. If the
//! diagnosis has one thread, it is the thread of the user: states stay in the cache of one core. If it has more, or the
//! map needs no Python, it runs in parallel with the thread of the user, which serves its calls one by one. Either way the
//! interpreter is held only for the calls.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use pyo3::exceptions::PyException;
use pyo3::prelude::*;
use symplint::diagnosis::Progress;
use symplint::map::Difference;
use symplint::{Block, Ensemble, StepFailure};

use crate::memory::{Loan, lend};

/// How often Python may look whether Ctrl-C was pressed, where nothing else happens.
pub const SIGNALS: Duration = Duration::from_millis(50);

/// Whether all states are finite now, or why they were not advanced.
pub type Answer = Result<bool, StepFailure>;

/// The calls to the thread of the user.
pub enum Call {
    /// Advance the states of a block.
    Step(f64, Loan<Answer>),
    /// Advance the states of a block by this part of the step.
    Part(usize, f64, Loan<Answer>),
    /// Advance states together with tangent vectors: a block of twice as many degrees of freedom, the states first.
    Tangents(f64, Loan<Answer>),
    /// Write the energy of each state of a block into its first row of positions.
    Energy(Loan<Answer>),
    /// Reverse the states of a block in time.
    Reverse(Loan<Answer>),
    /// These states will have to be advanced.
    Begin(f64, Ensemble),
    /// Write how results of workers for the same states differ, if they do. The block has no meaning.
    Compare(Arc<OnceLock<Difference>>, Loan<Answer>),
    /// Put the states of a block on the constraint manifold.
    Project(Loan<Answer>),
    /// Write the states of a loop at these parameters.
    Loop(Vec<f64>, Loan<Answer>),
    /// The diagnosis begins.
    Started(Arc<Progress>),
    /// So many more points will be measured.
    Planned(usize),
    /// A point was measured, at this step size.
    Measured(f64),
    /// There will be no more calls.
    Finished,
}

/// The receiver of the calls of a diagnosis.
pub trait Caller: Sync {
    /// Makes a call, which may be served later.
    fn tell(&self, call: Call);

    /// Whether the user stopped the diagnosis: then calls are dropped.
    fn is_stopped(&self) -> bool;
}

/// Lends a block for a call, and waits for the answer.
///
/// # Errors
/// That of the call; if the diagnosis was stopped.
pub fn call(
    caller: &dyn Caller,
    block: &mut Block<'_>,
    of: impl FnOnce(Loan<Answer>) -> Call,
) -> Answer {
    lend(block, |loan| caller.tell(of(loan))).unwrap_or_else(|| Err(stopped()))
}

/// The failure of a step that is not taken because the diagnosis was stopped.
pub fn stopped() -> StepFailure {
    StepFailure {
        sample: 0,
        reason: "the diagnosis was stopped".to_owned(),
    }
}

/// Serves the calls of a diagnosis on the thread that makes them.
struct Here<S> {
    server: Mutex<Server<S>>,
    stopped: AtomicBool,
}

struct Server<S> {
    serve: S,
    /// The exception that stopped the diagnosis.
    stopped_by: Option<PyErr>,
    /// When Python last looked for signals.
    looked: Instant,
}

impl<S: FnMut(Python<'_>, Call) -> PyResult<()> + Send> Here<S> {
    /// Serves a call, or none, and looks for signals.
    fn serve(&self, server: &mut Server<S>, call: Option<Call>) {
        if self.stopped.load(Ordering::Relaxed) {
            // The thread that waits for an answer receives an error when the call is dropped.
            return;
        }
        let served = Python::attach(|py| {
            let served = call.map_or(Ok(()), |call| (server.serve)(py, call));
            served.and_then(|()| py.check_signals())
        });
        server.looked = Instant::now();
        if let Err(error) = served {
            self.stopped.store(true, Ordering::Relaxed);
            server.stopped_by = Some(error);
        }
    }
}

impl<S: FnMut(Python<'_>, Call) -> PyResult<()> + Send> Caller for Here<S> {
    fn tell(&self, call: Call) {
        let mut server = self.server.lock().unwrap_or_else(PoisonError::into_inner);
        self.serve(&mut server, Some(call));
    }

    fn is_stopped(&self) -> bool {
        // Without any call for long, Ctrl-C is seen here.
        if let Ok(mut server) = self.server.try_lock()
            && server.looked.elapsed() > SIGNALS
        {
            self.serve(&mut server, None);
        }
        self.stopped.load(Ordering::Relaxed)
    }
}

/// Runs `work` on this thread, which serves its calls, too.
///
/// # Errors
/// What stops the diagnosis: an exception that `serve` returns, or the one that Ctrl-C raises.
pub fn run_here<R: Send>(
    py: Python<'_>,
    work: impl FnOnce(&dyn Caller) -> R + Send,
    serve: impl FnMut(Python<'_>, Call) -> PyResult<()> + Send,
) -> PyResult<R> {
    let here = Here {
        server: Mutex::new(Server {
            serve,
            stopped_by: None,
            looked: Instant::now(),
        }),
        stopped: AtomicBool::new(false),
    };
    let result = py.detach(|| work(&here));
    let server = (here.server.into_inner()).unwrap_or_else(PoisonError::into_inner);
    server.stopped_by.map_or(Ok(result), Err)
}

/// Sends the calls of a diagnosis to another thread.
struct Beside {
    calls: Mutex<Sender<Call>>,
    stopped: AtomicBool,
}

impl Caller for Beside {
    fn tell(&self, call: Call) {
        if self.is_stopped() {
            return;
        }
        self.send(call);
    }

    fn is_stopped(&self) -> bool {
        self.stopped.load(Ordering::Relaxed)
    }
}

impl Beside {
    fn send(&self, call: Call) {
        let calls = self.calls.lock().unwrap_or_else(PoisonError::into_inner);
        // Nobody listens any more only if the diagnosis was stopped.
        let _ = calls.send(call);
    }
}

/// Runs `work` in parallel with this thread, which serves its calls meanwhile.
///
/// # Errors
/// What stops the diagnosis: an exception that `serve` returns, or the one that Ctrl-C raises.
pub fn run_beside<R: Send>(
    py: Python<'_>,
    work: impl FnOnce(&dyn Caller) -> R + Send,
    mut serve: impl FnMut(Python<'_>, Call) -> PyResult<()>,
) -> PyResult<R> {
    let (sender, mut calls) = channel();
    let caller = Beside {
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
                // A call is dropped, which informs the thread that waits for it.
                Ok(_) | Err(RecvTimeoutError::Timeout) => Ok(()),
            };
            if let Err(error) = served.and_then(|()| py.check_signals()) {
                caller.stopped.store(true, Ordering::Relaxed);
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
struct Finished<'a>(&'a Beside);

impl Drop for Finished<'_> {
    fn drop(&mut self) {
        self.0.send(Call::Finished);
    }
}

/// Whether an exception ends a program where nothing catches it: Ctrl-C, `sys.exit`.
pub fn ends_programs(py: Python<'_>, error: &PyErr) -> bool {
    !error.is_instance_of::<PyException>(py)
}
