//! A map written for one state at a time.

use super::{StepFailure, TimeAdvance};
use crate::state::Block;
use crate::state::scratch;

/// Wraps a function `step(h, q, p)` that advances one state in place.
///
/// `q` and `p` are slices of length d.
///
/// ```
/// use symplint::{PerSample, TimeAdvance};
///
/// let drift = PerSample::new(2, |h, q, p| {
///     for (q, p) in q.iter_mut().zip(p) {
///         *q += h * *p;
///     }
/// });
/// assert_eq!(drift.dof(), 2);
/// ```
pub struct PerSample<F> {
    dof: usize,
    step: F,
}

impl<F> PerSample<F>
where
    F: Fn(f64, &mut [f64], &mut [f64]) + Send + Sync,
{
    /// A map on `dof` degrees of freedom.
    pub fn new(dof: usize, step: F) -> Self {
        PerSample { dof, step }
    }
}

impl<F> TimeAdvance for PerSample<F>
where
    F: Fn(f64, &mut [f64], &mut [f64]) + Send + Sync,
{
    fn dof(&self) -> usize {
        self.dof
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        scratch::with_buffer(2 * self.dof, |state| {
            let (q, p) = state.split_at_mut(self.dof);
            for k in 0..block.len() {
                for i in 0..self.dof {
                    q[i] = block.q.row(i)[k];
                    p[i] = block.p.row(i)[k];
                }
                (self.step)(h, q, p);
                for i in 0..self.dof {
                    block.q.row_mut(i)[k] = q[i];
                    block.p.row_mut(i)[k] = p[i];
                }
            }
        });
        Ok(())
    }
}
