//! When twice the samples are not worth it.

use crate::diagnosis::limits::{
    MAX_ERROR_IN_ROUNDINGS, MAX_GAIN_OF_NOISE, MAX_GAIN_OF_SPIKES, MAX_NOISE, MAX_RESOLVED_ERROR,
};
use crate::evidence::MAX_CELLS_BETWEEN_SAMPLES;
use crate::rules::LoopAfterStep;

/// Quadrature errors as the samples are doubled.
pub(in crate::diagnosis) struct Convergence {
    last_error: f64,
    stalls: usize,
}

/// How far the quadrature has converged.
pub(in crate::diagnosis) struct ConvergenceState {
    /// The quadrature error, relative to the initial integral; infinite where it is not known.
    pub error: f64,
    /// The error that is wanted.
    pub wanted: f64,
    /// Whether it is reached.
    pub enough: bool,
    /// Whether there is noise, which more samples do not reduce.
    pub stalled: bool,
    /// Whether the last doubling reduced it by no more than at a spike of one sample, whose part of a sum halves.
    pub may_be_spike: bool,
    /// Whether samples as many as these resolve the grid of the map.
    pub resolves_grid: bool,
}

impl Convergence {
    pub fn new() -> Self {
        Convergence {
            last_error: f64::INFINITY,
            stalls: 0,
        }
    }

    /// Takes in what the samples, twice as many as the last ones, show. If the map rounds, independent errors of this
    /// number of samples leave `of_rounding` of the integral, relative to it: twice the samples gain √2.
    pub fn proceed(
        &mut self,
        advanced: &LoopAfterStep,
        of_rounding: Option<f64>,
    ) -> ConvergenceState {
        let error = advanced.defect.quadrature_error.unwrap_or(f64::INFINITY);
        // If the map rounds, any error that does not fall is noise.
        let (noise, most_stalls) = match of_rounding {
            Some(_) => (f64::INFINITY, 1),
            None => (MAX_NOISE, 2),
        };
        let may_be_spike = error * MAX_GAIN_OF_SPIKES >= self.last_error;
        self.stalls = match error <= noise && error * MAX_GAIN_OF_NOISE >= self.last_error {
            true => self.stalls + 1,
            false => 0,
        };
        self.last_error = error;
        let floor = MAX_ERROR_IN_ROUNDINGS * of_rounding.unwrap_or(0.0);
        let wanted = wanted(advanced).max(floor);
        ConvergenceState {
            error,
            wanted,
            enough: error <= wanted,
            stalled: self.stalls >= most_stalls,
            may_be_spike,
            resolves_grid: advanced.cells_apart <= MAX_CELLS_BETWEEN_SAMPLES,
        }
    }
}

/// The quadrature error that is as good as round-off.
pub(in crate::diagnosis) fn wanted(advanced: &LoopAfterStep) -> f64 {
    MAX_RESOLVED_ERROR.max(4.0 * advanced.defect.roundoff)
}

impl ConvergenceState {
    /// Whether no more samples are needed, or none help.
    pub fn is_done(&self) -> bool {
        self.resolves_grid && (self.enough || self.stalled)
    }
}
