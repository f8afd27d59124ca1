//! What the increments of a coordinate say of its smoothness.
//!
//! The increment over one cell, less what its neighbours predict, is a *residual*. When the cells are
//! twice as wide, it grows 2^m-fold where the coordinate is smooth (m = 3, 5, 7 for the stencils
//! here), twofold at a kink, and not at all at a jump. Residuals are differences: a shift of
//! the origin changes none of them.

use crate::signal::unwrap_row;
use crate::state::Ensemble;

/// Weights of the neighbours at distance 1, 2, 3 in a residual; the cell itself has weight 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stencil(&'static [f64]);

/// From the shortest, which crowded jumps disturb least, to the most sensitive one.
pub(super) const STENCILS: [Stencil; 3] = [
    Stencil(&[-1.0 / 2.0]),
    Stencil(&[-4.0 / 6.0, 1.0 / 6.0]),
    Stencil(&[-15.0 / 20.0, 6.0 / 20.0, -1.0 / 20.0]),
];

impl Stencil {
    /// Cells on either side.
    pub fn reach(self) -> usize {
        self.0.len()
    }

    /// The residual of the cell that consists of `width` cells of `increments` from `first` on,
    /// against neighbours as wide, round the loop.
    pub fn residual(self, increments: &[f64], first: usize, width: usize) -> f64 {
        let n = increments.len();
        let wide = |offset: isize| -> f64 {
            let start = (first as isize + offset * width as isize).rem_euclid(n as isize) as usize;
            (start..start + width).map(|k| increments[k % n]).sum()
        };
        let neighbours = self.0.iter().enumerate().map(|(j, weight)| {
            let distance = j as isize + 1;
            weight * (wide(-distance) + wide(distance))
        });
        wide(0) + neighbours.sum::<f64>()
    }

    /// The increment of cell `k` that leaves no residual.
    pub fn predict(self, increments: &[f64], k: usize) -> f64 {
        increments[k] - self.residual(increments, k, 1)
    }
}

/// The increments of one coordinate from sample to sample, the last one back to the first.
#[derive(Clone, Debug)]
pub(super) struct Increments {
    pub values: Vec<f64>,
    /// What one turn adds to the coordinate: winding × period.
    pub gain: f64,
    /// Residuals below this are the rounding of the stored values.
    pub floor: f64,
}

/// The rounding errors of the few values in a residual, with room for those of the step itself.
const FLOOR: f64 = 16.0;

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
        let largest = unwrapped.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        Increments {
            values,
            gain,
            floor: FLOOR * unit_roundoff * largest,
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

    /// Samples of a function of s, as increments.
    fn sampled(n: usize, x: impl Fn(f64) -> f64) -> Vec<f64> {
        let row: Vec<f64> = (0..n).map(|k| x(k as f64 / n as f64)).collect();
        Increments::new(&row, 0.0, f64::EPSILON / 2.0).values
    }

    fn largest(increments: &[f64], stencil: Stencil, width: usize) -> f64 {
        (0..increments.len())
            .map(|k| stencil.residual(increments, k, width).abs())
            .fold(0.0, f64::max)
    }

    #[test]
    fn residuals_grow_as_theory_says() {
        let smooth = sampled(100, |s| (std::f64::consts::TAU * s).sin());
        let kinked = sampled(512, |s| (s - 0.3).abs() - 2.0 * (s - 0.8).max(0.0));
        let broken = sampled(512, |s| f64::from(s > 0.3) - f64::from(s > 0.8));
        for (stencil, power) in STENCILS.into_iter().zip([3, 5, 7]) {
            let growth = |x: &[f64]| largest(x, stencil, 2) / largest(x, stencil, 1);
            let expected = 2f64.powi(power);
            assert!((growth(&smooth) / expected - 1.0).abs() < 0.03);
            // Twofold, or more where the kink lies off the middle of the wide cells.
            assert!((1.5..4.0).contains(&growth(&kinked)), "{}", growth(&kinked));
            assert_eq!(growth(&broken), 1.0);
            assert_eq!(largest(&broken, stencil, 1), 1.0);
        }
    }

    #[test]
    fn the_last_increment_closes_the_loop() {
        let winding = Increments::new(&[0.1, 0.5, 0.9, 0.3, 0.7], 1.0, f64::EPSILON / 2.0);
        assert_eq!(winding.gain, 2.0);
        assert!(winding.values.iter().all(|d| (d - 0.4).abs() < 1e-15));
    }
}
