//! The increments of a coordinate along a loop.
//!
//! They are differences: a shift of the origin changes none of them.

use crate::breaks::rounding;
use crate::signal::{Extent, unwrap_row};
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
    /// Of the samples `row` of a coordinate with this period (0: none), stored with relative rounding
    /// errors of `unit_roundoff`.
    pub fn new(row: &[f64], period: f64, unit_roundoff: f64) -> Self {
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
            floor: rounding(unit_roundoff, Extent::of(&unwrapped).magnitude()),
        }
    }

    /// Positions and momenta of one degree of freedom.
    pub fn of(ensemble: &Ensemble, dof: usize, period: f64, unit_roundoff: f64) -> [Self; 2] {
        [
            Increments::new(ensemble.q().row(dof), period, unit_roundoff),
            Increments::new(ensemble.p().row(dof), 0.0, unit_roundoff),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_increment_closes_the_loop() {
        let winding = Increments::new(&[0.1, 0.5, 0.9, 0.3, 0.7], 1.0, f64::EPSILON / 2.0);
        assert_eq!(winding.gain, 2.0);
        assert!(winding.values.iter().all(|d| (d - 0.4).abs() < 1e-15));
    }
}
