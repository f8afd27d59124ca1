//! The increments of a coordinate along a loop.
//!
//! They are differences: a shift of the origin changes none of them.

use crate::breaks::rounding;
use crate::signal::unwrap_row;
use crate::state::Ensemble;

/// The increments of one coordinate from sample to sample, the last one back to the first.
#[derive(Clone, Debug)]
pub(super) struct Increments {
    pub values: Vec<f64>,
    /// What one revolution adds to the coordinate: winding × period.
    pub gain: f64,
    /// Residuals below this are the rounding of the stored values.
    pub floor: f64,
}

impl Increments {
    /// Of the samples `row` of a coordinate with this period (0: none), stored with rounding errors of this size.
    pub fn new(row: &[f64], period: f64, rounding_error: f64) -> Self {
        let mut unwrapped = row.to_vec();
        let gain = unwrap_row(&mut unwrapped, period) as f64 * period;
        let n = unwrapped.len();
        let values = (0..n)
            .map(|k| match k + 1 {
                next if next < n => unwrapped[next] - unwrapped[k],
                _ => unwrapped[0] + gain - unwrapped[k],
            })
            .collect();
        Increments {
            values,
            gain,
            floor: rounding(rounding_error),
        }
    }

    /// Positions and momenta of one degree of freedom.
    pub fn of(ensemble: &Ensemble, dof: usize, periods: [f64; 2], errors: [f64; 2]) -> [Self; 2] {
        [
            Increments::new(ensemble.q().row(dof), periods[0], errors[0]),
            Increments::new(ensemble.p().row(dof), periods[1], errors[1]),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_increment_closes_the_loop() {
        let winding = Increments::new(&[0.1, 0.5, 0.9, 0.3, 0.7], 1.0, 1e-16);
        assert_eq!(winding.gain, 2.0);
        assert!(winding.values.iter().all(|d| (d - 0.4).abs() < 1e-15));
    }
}
