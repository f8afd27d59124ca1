//! The caller's step as a map.
//!
//! The diagnosis runs on threads of its own. Steps are asked for through a channel and taken on the thread that called
//! `symplint_check`, one at a time: the caller's code need not be safe for threads.

use std::ffi::{c_int, c_void};
use std::ops::Range;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Mutex, PoisonError};

use symplint::map::{Capabilities, Substeps};
use symplint::{Block, Coordinates, StepFailure, TimeAdvance};

/// Advances `samples` states by one step of size `h`, in place, and returns 0; any other number says that the step cannot
/// be taken, and is named in the report.
///
/// q[i * samples + k] is the position i of the sample k, and p[i * samples + k] its momentum: one row for each of the `dof` degrees of freedom. In
/// Fortran they are q(samples, dof). The result for a sample must depend on nothing but h and the sample itself. `samples`
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

/// Advances `samples` states by one substep of a step of size `h`, in place; substeps count from 0. All of them in their order make up the
/// step. The rest is as for `SymplintStep`.
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

/// States that are to be advanced by some substeps: rows of q and of p without gaps.
struct Request {
    substeps: Range<usize>,
    h: f64,
    samples: usize,
    q: Vec<f64>,
    p: Vec<f64>,
    reply: Sender<Reply>,
}

/// The same states advanced, or the substep that failed with what it returned.
struct Reply {
    failed: Option<(usize, c_int)>,
    q: Vec<f64>,
    p: Vec<f64>,
}

/// The map that asks for steps.
pub struct CallbackMap {
    coordinates: Coordinates,
    /// Names of the substeps; empty for a step that is one whole.
    substeps: Vec<String>,
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
            requests,
        },
        steps,
    )
}

impl Steps {
    /// Takes all steps that are asked for, until the map is dropped: by a function of the substep, h, the degrees of freedom, the
    /// samples, and rows of q and of p. A step that is one whole has one substep, 0.
    pub fn serve(
        self,
        mut take: impl FnMut(usize, f64, usize, usize, &mut [f64], &mut [f64]) -> c_int,
    ) {
        for mut request in self.requests {
            let (h, samples) = (request.h, request.samples);
            let failed = request.substeps.clone().find_map(|substep| {
                let (q, p) = (&mut request.q, &mut request.p);
                let status = take(substep, h, self.dof, samples, q, p);
                (status != 0).then_some((substep, status))
            });
            let Request { q, p, reply, .. } = request;
            // The diagnosis may have failed meanwhile, and receives no reply then.
            let _ = reply.send(Reply { failed, q, p });
        }
    }
}

impl CallbackMap {
    /// Has these substeps taken.
    fn take(
        &self,
        substeps: Range<usize>,
        h: f64,
        block: &mut Block<'_>,
    ) -> Result<(), StepFailure> {
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
            substeps,
            h,
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
        if let Some((substep, status)) = reply.failed {
            let what = match self.substeps.get(substep) {
                Some(name) => format!("substep {} ({name})", substep + 1),
                None => "the step".to_owned(),
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
