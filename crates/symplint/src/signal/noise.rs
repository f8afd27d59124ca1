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

/// Errors are counted this many times what samples show of them: of white noise, they show its standard deviation. Conventional.
pub(crate) const SAFETY: f64 = 4.0;

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

/// States on both sides of the one in the middle of a row, in spacings. They are not equidistant: stairs whose height divides the
/// spacing would
/// look straight.
pub(crate) const NODES_BESIDE: [f64; 12] = [
    -5.81, -5.23, -3.88, -3.17, -1.83, -0.92, 1.13, 2.21, 2.94, 4.27, 4.79, 6.17,
];

/// Neighbours of a row that may be equal: rows of more lie on one stair of what rounds them.
const MAX_EQUAL_NEIGHBOURS: usize = 2;

/// Noise at one place counts no more than this many times that at others: a break may lie near it.
pub(crate) const MAX_NOISE_OVER_OTHERS: f64 = 16.0;

/// The sixth differences of a row: of the states [`NODES_BESIDE`] the middle, and of that.
pub(crate) fn of_a_row() -> SixthDifferences {
    SixthDifferences::at(&row(NODES_BESIDE, 0.0))
}

fn row(beside: [f64; NODES_BESIDE.len()], middle: f64) -> [f64; NODES_BESIDE.len() + 1] {
    let (before, after) = beside.split_at(NODES_BESIDE.len() / 2);
    let mut all = before.iter().chain([&middle]).chain(after);
    std::array::from_fn(|_| *all.next().expect("one more than there are beside it"))
}

/// The standard deviation of a value at one place, from rows of rising spacing.
///
/// The smallest spacing counts at which neighbours differ: it is least misled by a steep function, and a smaller one sees the stairs
/// of single precision only now and then. If every spacing has equal neighbours, the largest noise counts.
#[derive(Clone, Copy, Default)]
pub(crate) struct Noise {
    value: f64,
    /// Whether a spacing was found at which neighbours differ, so that larger ones are not needed.
    pub resolved: bool,
}

impl Noise {
    /// Adds the differences of the neighbouring values from the value in the middle, at one spacing; `of_a_row` is [`of_a_row`].
    pub fn add(&mut self, of_a_row: &SixthDifferences, differences: [f64; NODES_BESIDE.len()]) {
        if self.resolved {
            return;
        }
        let row = row(differences, 0.0);
        let shown = of_a_row.root_mean_square(&row);
        let equal = row.windows(2).filter(|pair| pair[0] == pair[1]).count();
        self.resolved = equal <= MAX_EQUAL_NEIGHBOURS;
        self.value = match self.resolved {
            true => shown,
            false => self.value.max(shown),
        };
    }

    /// `None` if the value does not respond at all.
    pub fn value(self) -> Option<f64> {
        (self.resolved || self.value > 0.0).then_some(self.value)
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
