//! Sums of products of samples a few places apart.

use std::ops::Range;

use multiversion::multiversion;

use super::{LANES, round_end};
use crate::signal::prefetch_next_row;

/// Lags that are summed in one pass: half of those of the highest order. They keep their sums in registers.
pub(super) const LAGS: usize = 5;

/// Samples on either side that the highest order needs.
pub(super) const REACH: usize = 2 * LAGS;

/// Samples whose products are summed before the sum is added to the others: rounding grows with the root of this number.
const SAMPLES_OF_SUM: usize = 512;

/// R_k = Σ_j p_j (q_{j+k} − q_{j−k}) round the loop for the [`LAGS`] lags k after `done`.
pub(super) fn add_lags(q: &[f64], p: &[f64], done: usize, sums: &mut [f64; REACH]) {
    /// Whole groups of samples that have all neighbours in their row begin here.
    const START: usize = REACH.next_multiple_of(LANES);
    /// Most samples that have not, as whole groups.
    const ENDS: usize = (REACH + LANES - 1 + START).next_multiple_of(LANES);
    let samples = q.len();
    let sums = &mut sums[done..done + LAGS];
    let end = (samples - REACH) / LANES * LANES;
    for from in (START..end).step_by(SAMPLES_OF_SUM) {
        let to = (from + SAMPLES_OF_SUM).min(end);
        let of_run = lag_sums(q, p, from..to, done, p[0]);
        sums.iter_mut().zip(of_run).for_each(|(sum, r)| *sum += r);
    }
    // The others go round the end of the row; for a sample without a neighbour there, p is the one that all are counted from, and adds
    // nothing.
    let from = end.max(START);
    let count = samples - from + START;
    let q_ends: [f64; ENDS + 2 * REACH] = round_end(q, from - REACH);
    let mut p_ends: [f64; ENDS + 2 * REACH] = round_end(p, from - REACH);
    p_ends[REACH + count..].fill(p[0]);
    let of_ends = lag_sums(&q_ends, &p_ends, REACH..REACH + ENDS, done, p[0]);
    sums.iter_mut().zip(of_ends).for_each(|(sum, r)| *sum += r);
}

/// Σ (p_j − `reference`) (q_{j+k} − q_{j−k}) for whole groups of j, and the [`LAGS`] lags k after `done`.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
fn lag_sums(q: &[f64], p: &[f64], range: Range<usize>, done: usize, reference: f64) -> [f64; LAGS] {
    let (from, to) = (range.start, range.end);
    let mut sums = [[0.0; LANES]; LAGS];
    let groups = p[from..to].as_chunks::<LANES>().0;
    let shifted = |start: usize| q[start..start + to - from].as_chunks::<LANES>().0;
    let ahead: [_; LAGS] = std::array::from_fn(|k| shifted(from + done + k + 1));
    let behind: [_; LAGS] = std::array::from_fn(|k| shifted(from - done - k - 1));
    for (group, values) in groups.iter().enumerate() {
        // These rows are in the cache: load the next ones.
        prefetch_next_row(q, from + group * LANES);
        prefetch_next_row(p, from + group * LANES);
        let mut centred = [0.0; LANES];
        for lane in 0..LANES {
            centred[lane] = values[lane] - reference;
        }
        for k in 0..LAGS {
            let (ahead, behind) = (&ahead[k][group], &behind[k][group]);
            for lane in 0..LANES {
                sums[k][lane] += centred[lane] * (ahead[lane] - behind[lane]);
            }
        }
    }
    sums.map(|lanes| lanes.iter().sum())
}

#[cfg(test)]
mod tests {
    use super::super::tests::row;
    use super::*;

    #[test]
    fn lag_sums_are_those_of_the_definition() {
        for samples in [32, 33, 40, 63, 100, 519, 531, 1600] {
            let (q, p) = (
                row(samples, |s| (97.0 * s * s).sin()),
                row(samples, |s| (71.0 * s).cos()),
            );
            let mut sums = [0.0; REACH];
            add_lags(&q, &p, 0, &mut sums);
            add_lags(&q, &p, LAGS, &mut sums);
            for (k, sum) in (1..).zip(sums) {
                let around = |j: usize| q[(j + k) % samples] - q[(j + samples - k) % samples];
                let expected: f64 = (0..samples).map(|j| p[j] * around(j)).sum();
                let off = (sum - expected).abs();
                assert!(off < 1e-14 * samples as f64, "{samples}, {k}: {off:e}");
            }
        }
    }
}
