//! How far the samples of a row are from smooth, by a high difference of each window of them.

use std::sync::LazyLock;

use multiversion::multiversion;

use super::{LANES, Stencil, round_end};
use crate::breaks::rounding;
use crate::signal::UNIT_ROUNDOFF;

/// Samples of a window: three registers. Its difference has order 23, and is below rounding if a wavelength has 18 samples or more.
const WINDOW: usize = 3 * LANES;

/// From one window of q to the next: each cell of the loop is among the middle nine of one.
pub(super) const Q_STRIDE: usize = 8;

/// From one window of p to the next. A jump of p counts for no more than the slope of q from one sample to the next, so that it may be
/// larger.
pub(super) const P_STRIDE: usize = 2 * Q_STRIDE;

/// Groups of windows that are added up before a rough row is left.
const GROUPS_AT_ONCE: usize = 8;

/// The rounding of samples, taken as rounding of the largest, rarely makes more than this of a difference: half of the sum of its
/// absolute weights, 2^23/√binom(46, 23). What exceeds it may be a jump.
const MAX_ROUNDINGS: f64 = 1.46;

/// A jump of a coordinate is at most this many times the difference of the window that shows it most, √binom(46, 23)/binom(22, 7), and
/// this many times in the mean of all places.
const MAX_JUMP_OVER_DIFFERENCE: f64 = 16.83;
const MEAN_JUMP_OVER_DIFFERENCE: f64 = 6.0;

/// The difference of a window, scaled so that white noise keeps its variance.
static DIFFERENCE: LazyLock<[f64; WINDOW]> = LazyLock::new(|| {
    let mut difference = [0.0; WINDOW];
    difference.copy_from_slice(&Stencil::new(WINDOW - 1).difference);
    difference
});

/// The larger of two numbers, by one instruction.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

fn largest(lanes: [f64; LANES]) -> f64 {
    lanes.into_iter().fold(0.0, larger)
}

/// What windows of samples show of a coordinate, all round the loop.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Inspection {
    windows: usize,
    /// Standard deviation of the noise.
    pub noise: f64,
    /// The largest difference of a window.
    largest: f64,
    /// The largest absolute value.
    pub size: f64,
    /// Root mean square of its derivative along the loop.
    pub slope: f64,
    /// Standard deviation.
    pub deviation: f64,
}

impl Inspection {
    /// Inspects a row by windows this far apart; `None` if they show more than rounding.
    pub fn of(row: &[f64], stride: usize) -> Option<Self> {
        /// Enough for two groups of windows.
        const ENDS: usize = 2 * LANES * P_STRIDE + WINDOW;
        let (from_group, span) = (LANES * stride, (LANES - 1) * stride + WINDOW);
        let groups = (row.len() - span) / from_group + 1;
        let mut sums = WindowSums::default();
        for group in (0..groups).step_by(GROUPS_AT_ONCE) {
            let count = GROUPS_AT_ONCE.min(groups - group);
            let of_groups = &row[group * from_group..][..(count - 1) * from_group + span];
            sums = add_windows(of_groups, stride, row[0], sums);
            sums.check()?;
        }
        // The others go round the end of the row.
        let done = sums.windows * stride;
        let ends: [f64; ENDS] = round_end(row, done);
        let others = (row.len() - done).div_ceil(from_group);
        let ends = &ends[..(others - 1) * from_group + span];
        sums = add_windows(ends, stride, row[0], sums);
        sums.check()?;
        let mean = |lanes: [f64; LANES]| lanes.iter().sum::<f64>() / sums.windows as f64;
        Some(Inspection {
            windows: sums.windows,
            noise: mean(sums.differences).sqrt(),
            largest: largest(sums.largest),
            size: largest(sums.sizes),
            slope: row.len() as f64 * mean(sums.steps).sqrt(),
            deviation: (mean(sums.squares) - mean(sums.values).powi(2))
                .max(0.0)
                .sqrt(),
        })
    }

    /// The jump that the differences of a coordinate of this size may be, beyond what its rounding makes of them.
    pub fn jump(&self, size: f64) -> f64 {
        // About the largest of this number of differences that are noise.
        let of_noise = (2.0 * (self.windows as f64).ln()).sqrt() * self.noise;
        let factor = match self.largest > of_noise {
            true => MAX_JUMP_OVER_DIFFERENCE,
            false => MEAN_JUMP_OVER_DIFFERENCE,
        };
        factor * (self.largest - MAX_ROUNDINGS * UNIT_ROUNDOFF * size).max(0.0)
    }
}

/// Sums over windows, each over every [`LANES`]th of them.
#[derive(Clone, Copy, Default)]
struct WindowSums {
    windows: usize,
    /// Squares of the differences, and the largest.
    differences: [f64; LANES],
    largest: [f64; LANES],
    /// Squares of the increments in the middle of a window.
    steps: [f64; LANES],
    /// Values there, from the first, their squares, and the largest size.
    values: [f64; LANES],
    squares: [f64; LANES],
    sizes: [f64; LANES],
}

impl WindowSums {
    /// `None` if a difference is larger than what rounding of the largest value so far makes of it, or no number.
    fn check(&self) -> Option<()> {
        let limit = rounding(UNIT_ROUNDOFF * largest(self.sizes));
        let are_numbers = self.differences.iter().all(|sum| sum.is_finite());
        (are_numbers && largest(self.largest) <= limit).then_some(())
    }
}

/// Adds whole groups of [`LANES`] windows of a row, values from `first`.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
fn add_windows(row: &[f64], stride: usize, first: f64, mut sums: WindowSums) -> WindowSums {
    const MIDDLE: usize = WINDOW / 2;
    let weights: &[f64; WINDOW] = &DIFFERENCE;
    let span = (LANES - 1) * stride + WINDOW;
    for group in row.windows(span).step_by(LANES * stride) {
        let [mut steps, mut values] = [[0.0; LANES]; 2];
        let mut parts = [[0.0; PARTS]; LANES];
        for lane in 0..LANES {
            let window = &group[lane * stride..][..WINDOW];
            parts[lane] = difference(weights, window, first);
            steps[lane] = window[MIDDLE] - window[MIDDLE - 1];
            values[lane] = window[MIDDLE] - first;
        }
        // All partial sums before the first total: summed window by window, they take registers of half the width.
        let differences = parts.map(|[a, b, c, d]| (a + c) + (b + d));
        for lane in 0..LANES {
            let size = differences[lane].abs();
            sums.largest[lane] = larger(size, sums.largest[lane]);
            sums.differences[lane] += size * size;
            sums.steps[lane] += steps[lane] * steps[lane];
            sums.values[lane] += values[lane];
            sums.squares[lane] += values[lane] * values[lane];
            let size = (first + values[lane]).abs();
            sums.sizes[lane] = larger(size, sums.sizes[lane]);
        }
        sums.windows += LANES;
    }
    sums
}

/// Partial sums of the difference of a window.
const PARTS: usize = LANES / 2;

/// The difference of a window, in partial sums. Values count from `first`, or far from the origin they would be rounded more than
/// they are in storage.
#[inline(always)]
fn difference(weights: &[f64; WINDOW], window: &[f64], first: f64) -> [f64; PARTS] {
    let mut parts = [0.0; PARTS];
    for k in 0..WINDOW / PARTS {
        for part in 0..PARTS {
            parts[part] += weights[PARTS * k + part] * (window[PARTS * k + part] - first);
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_windows_are_as_stated() {
        let weights = *DIFFERENCE;
        let sum: f64 = weights.iter().map(|w| w.abs()).sum();
        assert!((0.5 * sum / MAX_ROUNDINGS - 1.0).abs() < 2e-3, "{sum}");
        // A jump in each cell, seen by the window that shows it most.
        let shown = |cell: usize| weights[cell + 1..].iter().sum::<f64>().abs();
        let most = |cell: usize| {
            (cell..WINDOW - 1)
                .step_by(Q_STRIDE)
                .map(shown)
                .fold(0.0, f64::max)
        };
        let least = (0..Q_STRIDE).map(most).fold(1.0, f64::min);
        assert!(
            (least * MAX_JUMP_OVER_DIFFERENCE - 1.0).abs() < 1e-3,
            "{least}"
        );
        let mean = (0..Q_STRIDE).map(most).sum::<f64>() / Q_STRIDE as f64;
        assert!(
            (mean * MEAN_JUMP_OVER_DIFFERENCE - 1.0).abs() < 0.02,
            "{mean}"
        );
    }
}
