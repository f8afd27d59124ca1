//! The noise of a function: rounding, single precision, a solver that stops at a tolerance.
//!
//! The sixth difference of a smooth function over a short stretch is below round-off; what is left is noise
//! (Moré & Wild, "Estimating computational noise", SIAM J. Sci. Comput. 33, 2011).

/// Points of a sixth difference.
pub(crate) const POINTS: usize = 7;

/// Steps of a staircase per standard deviation of its rounding, which is uniform: √12.
pub(crate) const STEPS_OF_NOISE: f64 = 3.5;

/// The sixth divided difference at given points, scaled so that independent values of variance 1 give
/// variance 1.
///
/// The points should not be equidistant: on equidistant points a straight line that is rounded to a grid can
/// look exact.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SixthDifference([f64; POINTS]);

impl SixthDifference {
    /// At different points, in any unit.
    pub fn at(points: [f64; POINTS]) -> Self {
        // Newton's divided difference: Σ f(x_j) / Π (x_j − x_m).
        let divided = points.map(|x| {
            let others = points.iter().filter(|&&other| other != x);
            1.0 / others.map(|other| x - other).product::<f64>()
        });
        let gain = divided.iter().map(|a| a * a).sum::<f64>().sqrt();
        SixthDifference(divided.map(|a| a / gain))
    }

    /// Of the values at those points.
    pub fn of(&self, values: &[f64]) -> f64 {
        self.0.iter().zip(values).map(|(a, value)| a * value).sum()
    }
}

/// The sixth differences of a row of points, each of seven neighbours. In one of them alone a lattice may look straight.
#[derive(Clone, Debug)]
pub(crate) struct SixthDifferences(Vec<SixthDifference>);

impl SixthDifferences {
    /// At seven or more different points, in any unit.
    pub fn at(points: &[f64]) -> Self {
        let neighbours = points.windows(POINTS);
        let at = |x: &[f64]| SixthDifference::at(std::array::from_fn(|k| x[k]));
        SixthDifferences(neighbours.map(at).collect())
    }

    /// The root mean square of those of the values at those points.
    pub fn root_mean_square(&self, values: &[f64]) -> f64 {
        let differences = values.windows(POINTS).zip(&self.0);
        let squares: f64 = differences.map(|(x, of)| of.of(x).powi(2)).sum();
        (squares / self.0.len() as f64).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_of_degree_five_vanish_and_grids_do_not() {
        let points = [0.0, 0.87, 2.13, 2.95, 4.18, 5.04, 6.0];
        let difference = SixthDifference::at(points);
        let noise = |f: &dyn Fn(f64) -> f64| difference.of(&points.map(f)).abs();
        assert!(noise(&|x| 1.0 + x - 0.3 * x.powi(5)) < 1e-12);
        assert!(noise(&|x| (0.01 * x).sin()) < 1e-12);
        // A straight line on a grid, in steps of any part of it.
        let noisy = (0..1000)
            .filter(|k| noise(&|x| (x * (0.3 + 0.0137 * f64::from(*k))).round()) > 0.02)
            .count();
        assert!(noisy > 900, "{noisy}");
    }

    #[test]
    fn independent_values_keep_their_variance() {
        let difference = SixthDifference::at([0.0, 1.0, 2.5, 3.0, 4.2, 5.0, 6.1]);
        let squares: f64 = (0..POINTS)
            .map(|k| {
                let unit: [f64; POINTS] = std::array::from_fn(|j| f64::from(u8::from(j == k)));
                difference.of(&unit).powi(2)
            })
            .sum();
        assert!((squares - 1.0).abs() < 1e-14);
    }
}
