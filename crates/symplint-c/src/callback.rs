//! The caller's step as a map.
//!
//! The diagnosis runs on separate threads, and requests steps through a channel. The thread that called `symplint_check` takes them,
//! one at a time: the caller's code need not be safe for threads.

use std::ffi::{c_int, c_void};
use std::ops::Range;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Mutex, PoisonError};

use symplint::map::{Capabilities, Substeps};
use symplint::{Block, Coordinates, StepFailure, TimeAdvance};

use crate::status::{Failure, SymplintStatus};

/// Advances `samples` states by one step of size `h`, in place, and returns 0. Any other number means that the step failed. The report
/// names this number.
///
/// q[i * samples + k] is the position i of the sample k, and p[i * samples + k] its momentum: one row for each of the `dof` degrees of freedom. In
/// Fortran they are q(samples, dof). The result for a sample must depend on h and this sample only. `samples`
/// may be any number from 1. The function is called on the thread that called `symplint_check`, one call at a time; it
/// must return (no longjmp, no C++ exception).
pub type SymplintStep = Option<
    unsafe extern "C" fn(
        user: *mut c_void,
        h: f64,
        dof: usize,
        samples: usize,
        q: *mut f64,
        p: *mut f64,
    ) -> c_int,
>;

/// Advances `samples` states by substep number `substep`, from 0, of a step of size `h`, in place. The step is all substeps in their
/// order. The rest is as for `SymplintStep`.
pub type SymplintSubstep = Option<
    unsafe extern "C" fn(
        user: *mut c_void,
        substep: usize,
        h: f64,
        dof: usize,
        samples: usize,
        q: *mut f64,
        p: *mut f64,
    ) -> c_int,
>;

/// Reverses `samples` states in time, in place, and returns 0. Any other number ends the check with an error that names it. The function
/// must be its own inverse. The rest is as for `SymplintStep`.
pub type SymplintReversal = Option<
    unsafe extern "C" fn(
        user: *mut c_void,
        dof: usize,
        samples: usize,
        q: *mut f64,
        p: *mut f64,
    ) -> c_int,
>;

/// A call of a function of the caller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Call {
    /// A substep, and the size of the step. A step that is one whole has one substep, 0.
    Substep(usize, f64),
    /// The map that reverses time.
    Reversal,
}

/// States that are to be changed by some calls: rows of q and of p without gaps.
struct Request {
    calls: Vec<Call>,
    samples: usize,
    q: Vec<f64>,
    p: Vec<f64>,
    reply: Sender<Reply>,
}

/// The same states changed, or the call that failed with the number that it returned.
struct Reply {
    failed: Option<(Call, c_int)>,
    q: Vec<f64>,
    p: Vec<f64>,
}

/// The map that asks for steps.
pub struct CallbackMap {
    coordinates: Coordinates,
    /// Names of the substeps; empty for a step that is one whole.
    substeps: Vec<String>,
    has_reversal: bool,
    requests: Mutex<Sender<Request>>,
}

/// The end at which steps are taken.
pub struct Steps {
    dof: usize,
    requests: Receiver<Request>,
}

/// A map with substeps of these names, none if it is one whole, and the end at which its steps are taken.
pub fn callback_map(coordinates: Coordinates, substeps: Vec<String>) -> (CallbackMap, Steps) {
    let (sender, requests) = channel();
    let steps = Steps {
        dof: coordinates.dof(),
        requests,
    };
    let requests = Mutex::new(sender);
    (
        CallbackMap {
            coordinates,
            substeps,
            has_reversal: false,
            requests,
        },
        steps,
    )
}

impl Steps {
    /// Makes all calls that are asked for, until the map is dropped or a reversal fails: by a function of the call, the degrees of
    /// freedom, the samples, and rows of q and of p.
    pub fn serve(
        self,
        mut make: impl FnMut(Call, usize, usize, &mut [f64], &mut [f64]) -> c_int,
    ) -> Result<(), Failure> {
        for mut request in self.requests {
            let failed = request.calls.iter().find_map(|&call| {
                let (q, p) = (&mut request.q, &mut request.p);
                let status = make(call, self.dof, request.samples, q, p);
                (status != 0).then_some((call, status))
            });
            if let Some((Call::Reversal, status)) = failed {
                let text = format!("the reversal returned {status}");
                return Err(Failure::new(SymplintStatus::StepFailed, text));
            }
            let Request { q, p, reply, .. } = request;
            // The diagnosis may have failed meanwhile, and receives no reply then.
            let _ = reply.send(Reply { failed, q, p });
        }
        Ok(())
    }
}

impl CallbackMap {
    /// The same map with a function that reverses time, if there is one.
    pub fn with_reversal(self, has_reversal: bool) -> Self {
        CallbackMap {
            has_reversal,
            ..self
        }
    }

    /// Has these substeps taken.
    fn take(
        &self,
        substeps: Range<usize>,
        h: f64,
        block: &mut Block<'_>,
    ) -> Result<(), StepFailure> {
        self.make(substeps.map(|k| Call::Substep(k, h)).collect(), block)
    }

    /// Has these calls made.
    fn make(&self, calls: Vec<Call>, block: &mut Block<'_>) -> Result<(), StepFailure> {
        let failed = |reason: String| StepFailure { sample: 0, reason };
        let (dof, samples) = (block.dof(), block.len());
        let gone = || failed("the caller takes no more steps".to_owned());
        let mut rows = [Vec::new(), Vec::new()];
        for i in 0..dof {
            rows[0].extend_from_slice(block.q.row(i));
            rows[1].extend_from_slice(block.p.row(i));
        }
        let [q, p] = rows;
        let (reply, replies) = channel();
        let request = Request {
            calls,
            samples,
            q,
            p,
            reply,
        };
        let sent = (self.requests.lock())
            .unwrap_or_else(PoisonError::into_inner)
            .send(request);
        sent.map_err(|_| gone())?;
        let reply = replies.recv().map_err(|_| gone())?;
        if let Some((call, status)) = reply.failed {
            let what = match call {
                Call::Substep(k, _) if k < self.substeps.len() => {
                    format!("substep {} ({})", k + 1, self.substeps[k])
                }
                _ => "the step".to_owned(),
            };
            return Err(failed(format!("{what} returned {status}")));
        }
        for i in 0..dof {
            let row = i * samples..(i + 1) * samples;
            block.q.row_mut(i).copy_from_slice(&reply.q[row.clone()]);
            block.p.row_mut(i).copy_from_slice(&reply.p[row]);
        }
        Ok(())
    }
}

impl TimeAdvance for CallbackMap {
    fn dof(&self) -> usize {
        self.coordinates.dof()
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        self.take(0..self.substeps.len().max(1), h, block)
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            substeps: (!self.substeps.is_empty()).then_some(self),
            reversal: self.has_reversal.then(|| {
                Box::new(|block: &mut Block<'_>| {
                    // If the call fails, no more calls are made, and the diagnosis ends.
                    let _ = self.make(vec![Call::Reversal], block);
                }) as _
            }),
            ..Capabilities::of_coordinates(self.coordinates.clone())
        }
    }
}

impl Substeps for CallbackMap {
    fn substeps(&self) -> usize {
        self.substeps.len()
    }

    fn advance_substep(
        &self,
        substep: usize,
        h: f64,
        block: &mut Block<'_>,
    ) -> Result<(), StepFailure> {
        self.take(substep..substep + 1, h, block)
    }

    fn substep_name(&self, substep: usize) -> String {
        self.substeps[substep].clone()
    }
}
