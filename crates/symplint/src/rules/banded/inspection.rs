//! How far the samples of a row are from smooth, by a high difference of each window of them.

use std::sync::LazyLock;

use super::{LANES, RUN, Stencil};
use crate::breaks::rounding;
use crate::signal::UNIT_ROUNDOFF;

/// Samples of a window: three groups. Its difference has order 23, and is below rounding if a wavelength has 18 samples or more.
const WINDOW: usize = 3 * LANES;

/// From one window of q to the next: each cell of the loop is among the middle nine of one.
const Q_STRIDE: usize = LANES;

/// From one window of p to the next. A jump of p counts for no more than the slope of q from one sample to the next, so that it may be
/// larger.
pub(super) const P_STRIDE: usize = 2 * Q_STRIDE;

/// The rounding of samples, taken as rounding of the largest, rarely makes more than this of a difference: half of the sum of its
/// absolute weights, 2^23/√binom(46, 23). What exceeds it may be a jump.
const MAX_ROUNDINGS: f64 = 1.46;

/// A jump of a coordinate is at most this many times the difference of the window that shows it most, √binom(46, 23)/binom(22, 7), and
/// this many times in the mean of all places.
const MAX_JUMP_OVER_DIFFERENCE: f64 = 16.83;
const MEAN_JUMP_OVER_DIFFERENCE: f64 = 6.0;

/// The difference of a window, scaled so that white noise keeps its variance.
pub(super) static DIFFERENCE: LazyLock<[[f64; LANES]; 3]> = LazyLock::new(|| {
    let mut difference = [[0.0; LANES]; 3];
    (difference.as_flattened_mut()).copy_from_slice(&Stencil::new(WINDOW - 1).difference);
    difference
});

/// The larger of two numbers, by one instruction.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

fn largest<const COUNT: usize>(lanes: [f64; COUNT]) -> f64 {
    lanes.into_iter().fold(0.0, larger)
}

/// What windows of samples show of a coordinate, all round the loop.
#[derive(Clone, Copy, Debug)]
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
    /// The largest amplitude of a mode near the Nyquist mode. The difference of a window is 2^23/√binom(46, 23) = 2.9 times the amplitude
    /// of such a mode, taken as twice.
    pub fn shortest_mode(&self) -> f64 {
        0.5 * self.largest
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

/// Samples of a span: as many as its windows of q cover. A span begins every [`P_STRIDE`] samples.
pub(super) const SPAN: usize = P_STRIDE - Q_STRIDE + WINDOW;

/// Sums over the windows of q.
pub(super) type QWindows = Windows<{ P_STRIDE / Q_STRIDE }>;

/// Sums over the windows of p.
pub(super) type PWindows = Windows<1>;

/// Windows of a coordinate by spans, each with this number of them, [`Q_STRIDE`] apart.
pub(super) struct Windows<const COUNT: usize> {
    sums: Sums<COUNT>,
    /// The differences of a run in four parts each, before they are added up: one after the other, that takes longer than all else.
    parts: [[[f64; 4]; COUNT]; RUN / P_STRIDE],
}

#[derive(Clone, Copy)]
struct Sums<const COUNT: usize> {
    spans: usize,
    /// Squares of the differences, and the largest.
    differences: [f64; COUNT],
    largest: [f64; COUNT],
    samples: SampleSums,
}

/// Sums over the samples in the middle of the first window of each span.
#[derive(Clone, Copy, Default)]
pub(super) struct SampleSums {
    /// Squares of the increments up to them.
    steps: [f64; LANES],
    /// Their values, less the first of the row, the squares of these, and the largest size.
    values: [f64; LANES],
    squares: [f64; LANES],
    sizes: [f64; LANES],
}

impl<const COUNT: usize> Windows<COUNT> {
    pub fn new() -> Self {
        Windows {
            sums: Sums::new(),
            parts: [[[0.0; 4]; COUNT]; RUN / P_STRIDE],
        }
    }

    /// Forgets all spans.
    pub fn clear(&mut self) {
        self.sums = Sums::new();
    }

    pub fn spans(&self) -> usize {
        self.sums.spans
    }

    pub fn samples(&self) -> SampleSums {
        self.sums.samples
    }

    /// Adds the span of this number in the run that begins at `span`. The sums over samples are apart, to stay in registers.
    #[inline(always)]
    pub fn add(
        &mut self,
        number: usize,
        span: &[f64],
        first: f64,
        [before, middle, behind]: &[[f64; LANES]; 3],
        sums: &mut SampleSums,
    ) {
        let groups = span.as_chunks::<LANES>().0;
        let previous = &span[LANES - 1..].as_chunks::<LANES>().0[0];
        let mut differences = [[0.0; LANES]; COUNT];
        for lane in 0..LANES {
            // Far from the origin, values would be rounded more than they are in storage.
            let value = |group: usize| groups[group][lane] - first;
            for (k, difference) in differences.iter_mut().enumerate() {
                difference[lane] = before[lane] * value(k)
                    + middle[lane] * value(k + 1)
                    + behind[lane] * value(k + 2);
            }
            let step = groups[1][lane] - previous[lane];
            sums.steps[lane] += step * step;
            sums.values[lane] += value(1);
            sums.squares[lane] += value(1) * value(1);
            sums.sizes[lane] = larger(groups[1][lane].abs(), sums.sizes[lane]);
        }
        self.parts[number] = differences.map(halved::<8, 4>);
    }

    /// Adds up the differences of a run with this number of spans.
    #[inline(always)]
    pub fn end_run(&mut self, spans: usize, samples: SampleSums) {
        let (mut squares, mut largest) = (self.sums.differences, self.sums.largest);
        for parts in &self.parts[..spans] {
            let halves = parts.map(halved::<4, 2>);
            for k in 0..COUNT {
                let difference = halves[k][0] + halves[k][1];
                squares[k] += difference * difference;
                largest[k] = larger(difference.abs(), largest[k]);
            }
        }
        self.sums = Sums {
            spans: self.sums.spans + spans,
            differences: squares,
            largest,
            samples,
        };
    }

    /// `None` if a difference is larger than what rounding of the largest value so far makes of it, or no number.
    pub fn check(&self) -> Option<()> {
        let limit = rounding(UNIT_ROUNDOFF * largest(self.sums.samples.sizes));
        let are_numbers = self.sums.differences.iter().all(|sum| sum.is_finite());
        (are_numbers && largest(self.sums.largest) <= limit).then_some(())
    }

    /// What the windows show of a coordinate with this number of samples.
    pub fn inspection(&self, samples: usize) -> Inspection {
        let sums = &self.sums;
        let windows = sums.spans * COUNT;
        let mean = |lanes: [f64; LANES]| lanes.iter().sum::<f64>() / (sums.spans * LANES) as f64;
        Inspection {
            windows,
            noise: (sums.differences.iter().sum::<f64>() / windows as f64).sqrt(),
            largest: largest(sums.largest),
            size: largest(sums.samples.sizes),
            slope: samples as f64 * mean(sums.samples.steps).sqrt(),
            deviation: (mean(sums.samples.squares) - mean(sums.samples.values).powi(2))
                .max(0.0)
                .sqrt(),
        }
    }
}

impl<const COUNT: usize> Sums<COUNT> {
    fn new() -> Self {
        Sums {
            spans: 0,
            differences: [0.0; COUNT],
            largest: [0.0; COUNT],
            samples: SampleSums::default(),
        }
    }
}

/// The sums of one number of the first half and one of the second.
#[inline(always)]
fn halved<const ALL: usize, const HALF: usize>(numbers: [f64; ALL]) -> [f64; HALF] {
    std::array::from_fn(|k| numbers[k] + numbers[k + HALF])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_windows_are_as_stated() {
        let weights = DIFFERENCE.as_flattened();
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
