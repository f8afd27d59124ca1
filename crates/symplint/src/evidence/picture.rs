//! The given loop before and after a step, for a figure.

use crate::loops::Loop;
use crate::signal::unwrap_row;
use crate::state::{Coordinates, Ensemble, SMALL_MEMORY};

/// Samples of the given loop before and after one step. Periodic coordinates are unwrapped along the loop, so that a curve shows breaks
/// only where the map makes them.
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
    const MAX_SAMPLES: usize = 1024;

    /// Makes a picture of an ensemble before a step and the same ensemble after it.
    pub(crate) fn of(
        step_size: Option<f64>,
        before: &Ensemble,
        after: &Ensemble,
        coordinates: &Coordinates,
    ) -> Self {
        let mut before = Self::shown(before);
        unwrap(&mut before, coordinates);
        Self::unwrapped(step_size, before, Self::shown(after), coordinates)
    }

    fn unwrapped(
        step_size: Option<f64>,
        before: Ensemble,
        mut after: Ensemble,
        coordinates: &Coordinates,
    ) -> Self {
        unwrap(&mut after, coordinates);
        let mut block = after.block();
        for i in 0..before.dof() {
            let (q, p) = (before.q().row(i), before.p().row(i));
            bring_near(block.q.row_mut(i), q, coordinates.period(i));
            bring_near(block.p.row_mut(i), p, coordinates.momentum_period(i));
        }
        LoopPicture {
            step_size,
            before,
            after,
        }
    }

    /// The samples of an ensemble that a picture shows.
    pub(crate) fn shown(ensemble: &Ensemble) -> Ensemble {
        let affordable = SMALL_MEMORY / (32 * ensemble.dof().max(1));
        ensemble.thinned(affordable.clamp(1, Self::MAX_SAMPLES))
    }

    /// Makes a picture from samples `after` a step, which [`shown`](Self::shown) took from this number of equispaced samples of a loop.
    pub(crate) fn of_loop(
        step_size: Option<f64>,
        phase_loop: &dyn Loop,
        (after, samples): (Ensemble, usize),
        coordinates: &Coordinates,
    ) -> Self {
        let every = samples.div_ceil(after.samples());
        let s: Vec<f64> = (0..after.samples())
            .map(|k| (k * every) as f64 / samples as f64)
            .collect();
        let mut before = Ensemble::zeros(after.dof(), after.samples());
        phase_loop.sample(&s, &mut before.block());
        Self::unwrapped(step_size, before, after, coordinates)
    }
}

/// Unwraps all coordinates that have a period.
fn unwrap(samples: &mut Ensemble, coordinates: &Coordinates) {
    let dof = samples.dof();
    let mut block = samples.block();
    for i in 0..dof {
        unwrap_row(block.q.row_mut(i), coordinates.period(i));
        unwrap_row(block.p.row_mut(i), coordinates.momentum_period(i));
    }
}

/// Moves a row by whole periods, so that its first value is near the first value of another row.
fn bring_near(row: &mut [f64], other: &[f64], period: f64) {
    if let (Some(first), Some(near)) = (row.first(), other.first())
        && period > 0.0
    {
        let shift = ((near - first) / period).round() * period;
        row.iter_mut().for_each(|value| *value += shift);
    }
}
