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

/// The rounding of samples, taken as rounding of the largest, rarely makes more than this of a difference: half of the sum of its
/// absolute weights, 2^23/√binom(46, 23). What exceeds it may be a jump.
const ROUNDINGS_OF_A_DIFFERENCE: f64 = 1.46;

/// A jump of a coordinate is at most this many times the difference of the window that shows it most, √binom(46, 23)/binom(22, 7), and
/// this many times in the mean of all places.
const JUMP_OF_A_DIFFERENCE: f64 = 16.83;
const MEAN_JUMP_OF_A_DIFFERENCE: f64 = 6.0;

/// The difference of a window, scaled so that white noise keeps its variance.
static DIFFERENCE: LazyLock<[f64; WINDOW]> = LazyLock::new(|| {
    let mut difference = [0.0; WINDOW];
    difference.copy_from_slice(&Stencil::new(WINDOW - 1).difference);
    difference
});

/// The largest distance from the first sample.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
pub(super) fn furthest(row: &[f64]) -> f64 {
    /// Enough lanes that none waits for the one before.
    const WIDE: usize = 4 * LANES;
    let first = row[0];
    let (groups, rest) = row.as_chunks::<WIDE>();
    let mut lanes = [0.0; WIDE];
    for group in groups {
        for lane in 0..WIDE {
            lanes[lane] = larger((group[lane] - first).abs(), lanes[lane]);
        }
    }
    let rest = rest.iter().map(|x| (x - first).abs());
    rest.chain(lanes).fold(0.0, larger)
}

/// The larger of two numbers, by one instruction.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
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
    /// Of a row that is not larger than `size`, from windows this far apart; `None` if one of them shows more than rounding.
    pub fn of(row: &[f64], stride: usize, size: f64) -> Option<Self> {
        /// Enough for two groups of windows.
        const ENDS: usize = 2 * LANES * P_STRIDE + WINDOW;
        let (from_group, span) = (LANES * stride, (LANES - 1) * stride + WINDOW);
        let limit = rounding(UNIT_ROUNDOFF * size);
        let mut sums = add_windows(row, stride, row[0], limit, WindowSums::default())?;
        // The others go round the end of the row.
        let done = sums.windows * stride;
        let ends: [f64; ENDS] = round_end(row, done);
        let others = (row.len() - done).div_ceil(from_group);
        let ends = &ends[..(others - 1) * from_group + span];
        sums = add_windows(ends, stride, row[0], limit, sums)?;
        let mean = |lanes: [f64; LANES]| lanes.iter().sum::<f64>() / sums.windows as f64;
        Some(Inspection {
            windows: sums.windows,
            noise: mean(sums.differences).sqrt(),
            largest: sums.largest.into_iter().fold(0.0, larger),
            size: sums.sizes.into_iter().fold(0.0, larger),
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
            true => JUMP_OF_A_DIFFERENCE,
            false => MEAN_JUMP_OF_A_DIFFERENCE,
        };
        factor * (self.largest - ROUNDINGS_OF_A_DIFFERENCE * UNIT_ROUNDOFF * size).max(0.0)
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

/// Adds whole groups of [`LANES`] windows of a row, values from `first`; `None` if a difference is not within its limit.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
fn add_windows(
    row: &[f64],
    stride: usize,
    first: f64,
    limit: f64,
    mut sums: WindowSums,
) -> Option<WindowSums> {
    const MIDDLE: usize = WINDOW / 2;
    let weights: &[f64; WINDOW] = &DIFFERENCE;
    let span = (LANES - 1) * stride + WINDOW;
    for group in row.windows(span).step_by(LANES * stride) {
        let [mut differences, mut steps, mut values] = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            let window = group[lane * stride..].first_chunk()?;
            differences[lane] = difference(weights, window, first);
            steps[lane] = window[MIDDLE] - window[MIDDLE - 1];
            values[lane] = window[MIDDLE] - first;
        }
        let mut exceeds = [0; LANES];
        for lane in 0..LANES {
            let size = differences[lane].abs();
            // NaN is not within a limit.
            let within = size <= limit;
            exceeds[lane] = u64::from(!within);
            sums.largest[lane] = larger(size, sums.largest[lane]);
            sums.differences[lane] += size * size;
            sums.steps[lane] += steps[lane] * steps[lane];
            sums.values[lane] += values[lane];
            sums.squares[lane] += values[lane] * values[lane];
            let size = (first + values[lane]).abs();
            sums.sizes[lane] = larger(size, sums.sizes[lane]);
        }
        if exceeds.iter().fold(0, |any, exceeds| any | exceeds) != 0 {
            return None;
        }
        sums.windows += LANES;
    }
    Some(sums)
}

/// The difference of a window, summed in half as many lanes: these are added up for every one. Values count from `first`, or far
/// from the origin they would be rounded more than they are in storage.
#[inline(always)]
fn difference(weights: &[f64; WINDOW], window: &[f64; WINDOW], first: f64) -> f64 {
    const NARROW: usize = LANES / 2;
    let mut lanes = [0.0; NARROW];
    for lane in 0..NARROW {
        lanes[lane] = weights[lane] * (window[lane] - first);
    }
    for k in 1..WINDOW / NARROW {
        for lane in 0..NARROW {
            lanes[lane] += weights[NARROW * k + lane] * (window[NARROW * k + lane] - first);
        }
    }
    (lanes[0] + lanes[2]) + (lanes[1] + lanes[3])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_windows_are_as_stated() {
        let weights = *DIFFERENCE;
        let sum: f64 = weights.iter().map(|w| w.abs()).sum();
        assert!(
            (0.5 * sum / ROUNDINGS_OF_A_DIFFERENCE - 1.0).abs() < 2e-3,
            "{sum}"
        );
        // A jump in each cell, seen by the window that shows it most.
        let shown = |cell: usize| weights[cell + 1..].iter().sum::<f64>().abs();
        let most = |cell: usize| {
            (cell..WINDOW - 1)
                .step_by(Q_STRIDE)
                .map(shown)
                .fold(0.0, f64::max)
        };
        let least = (0..Q_STRIDE).map(most).fold(1.0, f64::min);
        assert!((least * JUMP_OF_A_DIFFERENCE - 1.0).abs() < 1e-3, "{least}");
        let mean = (0..Q_STRIDE).map(most).sum::<f64>() / Q_STRIDE as f64;
        assert!(
            (mean * MEAN_JUMP_OF_A_DIFFERENCE - 1.0).abs() < 0.02,
            "{mean}"
        );
    }
}
