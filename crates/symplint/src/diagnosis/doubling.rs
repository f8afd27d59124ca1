//! When twice the samples are not worth it.

use super::probe::Measured;
use crate::verdict::MOST_CELLS_APART;

/// A quadrature error of this size is as good as round-off.
const ENOUGH: f64 = 1e-14;

/// Twice the samples that gain less than this factor hit noise: smooth loops gain far more,
/// kinked ones 4 or more, jumps 2, noise of the states √2.
const STALLED: f64 = 1.7;

/// Above this an error that does not fall is not yet noise: the loop is steep somewhere.
const NOISE: f64 = 1e-5;

/// Quadrature errors as the samples are doubled.
pub(super) struct Doubling {
    last_error: f64,
    stalls: usize,
}

/// Where doubling stands.
pub(super) struct Standing {
    /// The quadrature error, relative to the initial integral; infinite where it is not known.
    pub error: f64,
    /// The error that is wanted.
    pub wanted: f64,
    /// Whether it is reached.
    pub enough: bool,
    /// Whether there is noise, which more samples do not cure.
    pub stalled: bool,
    /// Whether samples as many as these see the grid of the map.
    pub sees_the_grid: bool,
}

impl Doubling {
    pub fn new() -> Self {
        Doubling {
            last_error: f64::INFINITY,
            stalls: 0,
        }
    }

    /// Takes in what the samples, twice as many as the last ones, say.
    pub fn proceed(&mut self, measured: &Measured) -> Standing {
        let error = measured.defect.quadrature_error.unwrap_or(f64::INFINITY);
        self.stalls = match error < NOISE && error * STALLED > self.last_error {
            true => self.stalls + 1,
            false => 0,
        };
        self.last_error = error;
        let wanted = ENOUGH.max(4.0 * measured.defect.roundoff);
        Standing {
            error,
            wanted,
            enough: error <= wanted,
            stalled: self.stalls >= 2,
            sees_the_grid: measured.cells_apart <= MOST_CELLS_APART,
        }
    }
}

impl Standing {
    /// Whether no more samples are needed, or none help.
    pub fn is_done(&self) -> bool {
        self.sees_the_grid && (self.enough || self.stalled)
    }
}
