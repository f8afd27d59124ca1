//! The given loop before and after a step, for a figure.

use crate::loops::Loop;
use crate::state::{Ensemble, SMALL_MEMORY};

/// Samples of the given loop before and after one step.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct LoopPicture {
    /// The size of the step, if it is known.
    pub step_size: Option<f64>,
    /// The samples before the step.
    pub before: Ensemble,
    /// The same samples after it.
    pub after: Ensemble,
}

impl LoopPicture {
    /// Samples at most: more only make files large.
    const MOST_SAMPLES: usize = 1024;

    /// Makes a picture of an ensemble before a step and the same ensemble after it.
    pub(crate) fn of(step_size: Option<f64>, before: &Ensemble, after: &Ensemble) -> Self {
        LoopPicture {
            step_size,
            before: Self::shown(before),
            after: Self::shown(after),
        }
    }

    /// The samples of an ensemble that a picture shows.
    pub(crate) fn shown(ensemble: &Ensemble) -> Ensemble {
        let affordable = SMALL_MEMORY / (32 * ensemble.dof().max(1));
        ensemble.thinned(affordable.clamp(1, Self::MOST_SAMPLES))
    }

    /// Makes a picture from samples `after` a step, which [`shown`](Self::shown) took from this number of equispaced samples of a loop.
    pub(crate) fn of_loop(
        step_size: Option<f64>,
        phase_loop: &dyn Loop,
        (after, samples): (Ensemble, usize),
    ) -> Self {
        let every = samples.div_ceil(after.samples());
        let s: Vec<f64> = (0..after.samples())
            .map(|k| (k * every) as f64 / samples as f64)
            .collect();
        let mut before = Ensemble::zeros(after.dof(), after.samples());
        phase_loop.sample(&s, &mut before.block());
        LoopPicture {
            step_size,
            before,
            after,
        }
    }
}
