//! How large and how exact each coordinate is.

use std::sync::Arc;

use crate::signal::unwrap_row;
use crate::state::Coordinates;
use crate::state::Ensemble;
use crate::state::coordinate;

/// Sizes and tolerances of the 2d coordinates, positions first.
pub(super) struct Scales {
    /// Half the range of each coordinate along the loop.
    pub size: Vec<f64>,
    /// The reference from which momenta are counted: those of the loop at s = 0, advanced.
    pub p_reference: Vec<f64>,
    /// What an interpolant may be off.
    pub tolerance: Vec<f64>,
    /// Largest absolute value of each coordinate.
    pub magnitude: Vec<f64>,
    /// How far along the loop the rounding of a state is, as a part of one turn.
    pub input_rounding: f64,
}

/// Rounding of a few operations.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Tolerances are this many times the noise.
const SAFETY: f64 = 8.0;

/// Coordinates much smaller than the largest count as this part of it.
const SMALLEST_PART: f64 = 1e-6;

impl Scales {
    /// From a few samples of the advanced loop.
    pub fn new(advanced: &Ensemble, coordinates: &Coordinates, tolerance: f64) -> Self {
        let dof = advanced.dof();
        let mut size: Vec<f64> = Vec::with_capacity(2 * dof);
        let mut magnitude: Vec<f64> = Vec::with_capacity(2 * dof);
        for c in 0..2 * dof {
            let mut row = coordinate(advanced, c).to_vec();
            magnitude.push(row.iter().fold(0.0, |m: f64, v| m.max(v.abs())));
            unwrap_row(&mut row, period(coordinates, c));
            let low = row.iter().copied().fold(f64::INFINITY, f64::min);
            let high = row.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            size.push(0.5 * (high - low));
        }
        for half in size.chunks_exact_mut(dof) {
            let largest = half.iter().copied().fold(0.0, f64::max);
            for size in half {
                *size = size.max(SMALLEST_PART * largest).max(f64::MIN_POSITIVE);
            }
        }
        let tolerances = size.iter().zip(&magnitude);
        Scales {
            tolerance: tolerances
                .map(|(size, magnitude)| tolerance * size + ROUNDING * magnitude)
                .collect(),
            p_reference: (0..dof).map(|i| advanced.p().row(i)[0]).collect(),
            input_rounding: ROUNDING
                * size
                    .iter()
                    .zip(&magnitude)
                    .map(|(s, m)| m / s)
                    .fold(1.0, f64::max),
            size,
            magnitude,
        }
    }

    /// What an interpolant may be off where there is so much noise in each coordinate.
    pub fn allowance(noise: Vec<f64>) -> Arc<[f64]> {
        noise.into_iter().map(|noise| SAFETY * noise).collect()
    }

    /// Raises the tolerances to the noise of the map.
    pub fn allow(&mut self, allowance: &[f64]) {
        for (tolerance, allowance) in self.tolerance.iter_mut().zip(allowance) {
            *tolerance = tolerance.max(*allowance);
        }
    }

    /// Weight of a coordinate beside the others.
    pub fn weight(&self, c: usize) -> f64 {
        1.0 / self.size[c]
    }
}

/// Period of a coordinate: momenta have none.
pub(super) fn period(coordinates: &Coordinates, c: usize) -> f64 {
    if c < coordinates.dof() {
        coordinates.period(c)
    } else {
        0.0
    }
}
