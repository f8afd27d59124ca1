//! What samples say of a jump in one of their cells.
//!
//! The *residual* of a cell is its increment less what the increments on both sides predict: the step that is
//! missing between two smooth functions. With cells twice as wide it grows 32-fold where the coordinate is smooth,
//! twofold at a kink, and not at all at a jump.

use super::limits::{MOST_SUSPECTS, OUTSTANDING, ROUNDING, STAYS_IN_WIDE_CELLS};

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
    /// Sum of the least residuals of cells four apart: those that a jump leaves alone.
    least: f64,
}

/// The expected least of four absolute values of a standard normal distribution, ∫ erfc(x/√2)⁴ dx.
const LEAST_OF_FOUR: f64 = 0.262;

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
            for k in 0..GROUP / 4 {
                let of_two = |a: f64, b: f64| if a < b { a } else { b };
                self.least += of_two(
                    of_two(narrow[k], narrow[k + 4]),
                    of_two(narrow[k + 8], narrow[k + 12]),
                );
            }
        }
    }

    /// Standard deviation of the noise of residuals in so many full groups, as far as there is noise.
    fn noise(&self, groups: usize) -> f64 {
        let of_four = groups * (GROUP / 4);
        self.least / (LEAST_OF_FOUR * of_four.max(1) as f64)
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
            noise: self.noise(groups),
        };
        let suspicious = self.largest > ROUNDING * magnitude
            && self.largest > STAYS_IN_WIDE_CELLS * self.largest_wide
            && suspect.stands_out(self.largest);
        suspicious.then_some(suspect)
    }
}

/// The step from x_2 to x_3 that the values of polynomials up to the fourth degree do not explain.
pub(super) fn residual(x: [f64; 6]) -> f64 {
    (10.0 * (x[3] - x[2]) - 5.0 * (x[4] - x[1]) + (x[5] - x[0])) / 6.0
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
}
