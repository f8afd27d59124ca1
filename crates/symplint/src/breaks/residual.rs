//! What samples say of a jump in one of their cells.
//!
//! The *residual* of a cell is its increment less what the increments on both sides predict: the step that is
//! missing between two smooth functions. With cells twice as wide it grows 32-fold where the coordinate is smooth,
//! twofold at a kink, and not at all at a jump.

use super::limits::{MOST_SUSPECTS, OUTSTANDING, ROUNDINGS, STAYS_IN_WIDE_CELLS};
use crate::signal::UNIT_ROUNDOFF;

/// Which coordinate of a degree of freedom.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Coordinate {
    Q,
    P,
}

/// A cell in which a coordinate looks discontinuous.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Suspect {
    pub dof: usize,
    pub coordinate: Coordinate,
    /// From sample `cell` to sample `cell + 1`, round the loop.
    pub cell: usize,
    /// Size of the residual there.
    pub size: f64,
    /// Standard deviation of the residuals' noise.
    pub noise: f64,
}

impl Suspect {
    /// Whether a jump of this size stands out of the noise.
    pub fn stands_out(&self, jump: f64) -> bool {
        jump > OUTSTANDING * self.noise
    }
}

/// Keeps the most suspicious cells, those that stand out most first.
pub(crate) fn most_outstanding(found: &mut Vec<Suspect>) {
    // A stable sort: equals stay in the order of the degrees of freedom.
    let over_noise = |suspect: &Suspect| suspect.size / suspect.noise;
    found.sort_by(|a, b| over_noise(b).total_cmp(&over_noise(a)));
    found.truncate(MOST_SUSPECTS);
}

/// Samples that are taken in at once.
pub(crate) const GROUP: usize = 16;

/// Samples before a group that its residuals need.
pub(crate) const REACH: usize = 10;

/// A group of samples and those before it.
pub(crate) type Window = [f64; REACH + GROUP];

/// The largest residual of one coordinate round the loop, from samples that pass by in groups.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Residuals {
    largest: f64,
    /// The cell of the largest.
    cell: usize,
    /// The largest from every second sample.
    largest_wide: f64,
    /// Sum of the [`undisturbed`] residuals of full groups.
    undisturbed: f64,
}

impl Residuals {
    /// Takes in `count` samples of a group, of which the first is sample `next` of the loop.
    pub fn add(&mut self, x: &Window, next: usize, count: usize) {
        let (mut narrow, mut wide) = ([0.0; GROUP], [0.0; GROUP]);
        for k in 0..GROUP {
            let at = |back: usize| x[REACH + k - back];
            narrow[k] = residual([at(5), at(4), at(3), at(2), at(1), at(0)]).abs();
            wide[k] = residual([at(10), at(8), at(6), at(4), at(2), at(0)]).abs();
        }
        narrow[count..].fill(0.0);
        wide[count..].fill(0.0);
        let most = |lanes: &[f64; GROUP]| lanes.iter().fold(0.0, |m: f64, &v| m.max(v));
        let largest = most(&narrow);
        if largest > self.largest {
            let lane = narrow.iter().position(|&v| v == largest).unwrap_or(0);
            (self.largest, self.cell) = (largest, next + lane - 3);
        }
        self.largest_wide = self.largest_wide.max(most(&wide));
        if count == GROUP {
            self.undisturbed += undisturbed(&narrow);
        }
    }

    /// The cell that looks discontinuous, if one does, after one revolution of `samples` samples in so many full
    /// `groups`, none of which is larger than `magnitude`.
    pub fn suspect(
        &self,
        dof: usize,
        coordinate: Coordinate,
        [samples, groups]: [usize; 2],
        magnitude: f64,
    ) -> Option<Suspect> {
        let suspect = Suspect {
            dof,
            coordinate,
            cell: self.cell % samples,
            size: self.largest,
            noise: deviation(self.undisturbed, groups),
        };
        let suspicious = self.largest > rounding(UNIT_ROUNDOFF * magnitude)
            && self.largest > STAYS_IN_WIDE_CELLS * self.largest_wide
            && suspect.stands_out(self.largest);
        suspicious.then_some(suspect)
    }
}

/// The sum of the residuals of a group that a jump leaves alone: it disturbs those of five cells, so that of cells four
/// apart the least counts.
fn undisturbed(residuals: &[f64; GROUP]) -> f64 {
    let least = |a: f64, b: f64| if a < b { a } else { b };
    let of_four = |k: usize| {
        let of = |j: usize| residuals[k + 4 * j];
        least(least(of(0), of(1)), least(of(2), of(3)))
    };
    (0..GROUP / 4).map(of_four).sum()
}

/// The standard deviation of the noise of residuals, from the sum of the undisturbed ones in so many groups.
fn deviation(undisturbed: f64, groups: usize) -> f64 {
    /// The expected least of four absolute values of a standard normal distribution, ∫ erfc(x/√2)⁴ dx.
    const LEAST_OF_FOUR: f64 = 0.262;
    undisturbed / (LEAST_OF_FOUR * (groups.max(1) * (GROUP / 4)) as f64)
}

/// The noise of some absolute residuals.
pub(super) fn noise(residuals: &[f64]) -> f64 {
    let (groups, _) = residuals.as_chunks();
    deviation(groups.iter().map(undisturbed).sum(), groups.len())
}

/// Residuals no larger than this are rounding of values below `magnitude`, each by a part `unit_roundoff` of it.
pub(crate) fn rounding(rounding_error: f64) -> f64 {
    ROUNDINGS * rounding_error
}

/// Increments on either side that predict that of a cell.
pub(super) const NEIGHBOURS: usize = 2;

/// The step from x_2 to x_3 that the values of polynomials up to the fourth degree do not explain.
fn residual(x: [f64; 6]) -> f64 {
    (10.0 * (x[3] - x[2]) - 5.0 * (x[4] - x[1]) + (x[5] - x[0])) / 6.0
}

/// The residual of the cell that consists of `width` cells from `first` on, from increments round the loop.
pub(super) fn of_cell(increments: &[f64], first: usize, width: usize) -> f64 {
    of_cells(increments, first, 1, width)[0]
}

/// The residuals of `count` cells that consist of `width` cells from `first` on, from `first` + 1 on, and so forth.
pub(super) fn of_cells(increments: &[f64], first: usize, count: usize, width: usize) -> Vec<f64> {
    let reach = NEIGHBOURS * width;
    let n = increments.len();
    let start = (first + reach * n - reach) % n;
    // With what they need beyond the ends, so that nothing is wrapped for a cell.
    let round = increments.iter().cycle().skip(start);
    let row: Vec<f64> = round.take(count - 1 + 2 * reach + width).copied().collect();
    let wide: Vec<f64> = row.windows(width).map(|cells| cells.iter().sum()).collect();
    let [a, b, c, d, e] = std::array::from_fn(|cell| &wide[cell * width..][..count]);
    let residual = |k: usize| c[k] - 4.0 / 6.0 * (b[k] + d[k]) + 1.0 / 6.0 * (a[k] + e[k]);
    (0..count).map(residual).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_its_residual_and_polynomials_have_none() {
        let step = |x: f64| if x > 0.0 { 0.7 } else { 0.0 };
        let at: [f64; 6] = std::array::from_fn(|k| k as f64 - 2.5);
        assert!((residual(at.map(step)) - 0.7).abs() < 1e-15);
        for power in 0..5 {
            assert!(residual(at.map(|x| x.powi(power))).abs() < 1e-13);
        }
        assert!((residual(at.map(|x| x.powi(5))) - 20.0).abs() < 1e-12);
    }

    #[test]
    fn residuals_grow_with_the_width_of_cells_as_theory_says() {
        let growth = |n: usize, x: &dyn Fn(f64) -> f64| {
            let at = |k: usize| x((k % n) as f64 / n as f64);
            let increments: Vec<f64> = (0..n).map(|k| at(k + 1) - at(k)).collect();
            let largest = |width: usize| {
                let all = of_cells(&increments, 0, n, width).into_iter();
                all.fold(0.0, |m: f64, v| m.max(v.abs()))
            };
            largest(2) / largest(1)
        };
        let smooth = growth(100, &|s| (std::f64::consts::TAU * s).sin());
        assert!((smooth / 32.0 - 1.0).abs() < 0.03, "{smooth}");
        // Twofold, or more where the kink lies off the middle of the wide cells.
        let kinked = growth(512, &|s| (s - 0.3).abs() - 2.0 * (s - 0.8).max(0.0));
        assert!((1.5..4.0).contains(&kinked), "{kinked}");
        let broken = growth(512, &|s| f64::from(s > 0.3) - f64::from(s > 0.8));
        assert!((broken - 1.0).abs() < 1e-15, "{broken}");
    }
}
