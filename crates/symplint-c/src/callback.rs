//! The caller's step as a map.
//!
//! The diagnosis runs on threads of its own. Steps are asked for through a channel and taken on the thread that called
//! `symplint_check`, one at a time: the caller's code need not be safe for threads.

use std::ffi::{c_int, c_void};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Mutex, PoisonError};

use symplint::map::Capabilities;
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

/// States that are to be advanced: rows of q and of p without gaps.
struct Request {
    h: f64,
    samples: usize,
    q: Vec<f64>,
    p: Vec<f64>,
    reply: Sender<Reply>,
}

/// The same states advanced, and what the step returned.
struct Reply {
    status: c_int,
    q: Vec<f64>,
    p: Vec<f64>,
}

/// The map that asks for steps.
pub struct CallbackMap {
    coordinates: Coordinates,
    requests: Mutex<Sender<Request>>,
}

/// The end at which steps are taken.
pub struct Steps {
    dof: usize,
    requests: Receiver<Request>,
}

/// A map, and the end at which its steps are taken.
pub fn callback_map(coordinates: Coordinates) -> (CallbackMap, Steps) {
    let (sender, requests) = channel();
    let steps = Steps {
        dof: coordinates.dof(),
        requests,
    };
    let requests = Mutex::new(sender);
    (
        CallbackMap {
            coordinates,
            requests,
        },
        steps,
    )
}

impl Steps {
    /// Takes all steps that are asked for, until the map is dropped.
    ///
    /// # Safety
    /// `step` does what [`SymplintStep`] says, with this `user`.
    pub unsafe fn take(
        self,
        step: unsafe extern "C" fn(*mut c_void, f64, usize, usize, *mut f64, *mut f64) -> c_int,
        user: *mut c_void,
    ) {
        self.serve(|h, dof, samples, q, p| {
            let (q, p) = (q.as_mut_ptr(), p.as_mut_ptr());
            // SAFETY: both have dof × samples values, no other code uses them meanwhile, and the caller promises the rest.
            unsafe { step(user, h, dof, samples, q, p) }
        });
    }

    /// The same by a function of h, the degrees of freedom, the samples, and rows of q and of p.
    pub fn serve(self, mut step: impl FnMut(f64, usize, usize, &mut [f64], &mut [f64]) -> c_int) {
        for mut request in self.requests {
            let Request { h, samples, .. } = request;
            let status = step(h, self.dof, samples, &mut request.q, &mut request.p);
            let Request { q, p, reply, .. } = request;
            // Nobody waits for it where the diagnosis has failed meanwhile.
            let _ = reply.send(Reply { status, q, p });
        }
    }
}

impl TimeAdvance for CallbackMap {
    fn dof(&self) -> usize {
        self.coordinates.dof()
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
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
        let Reply { status, q, p } = replies.recv().map_err(|_| gone())?;
        if status != 0 {
            return Err(failed(format!("the step returned {status}")));
        }
        for i in 0..dof {
            let row = i * samples..(i + 1) * samples;
            block.q.row_mut(i).copy_from_slice(&q[row.clone()]);
            block.p.row_mut(i).copy_from_slice(&p[row]);
        }
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities::of_coordinates(self.coordinates.clone())
    }
}
