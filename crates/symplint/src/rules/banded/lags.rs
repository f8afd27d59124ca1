//! Sums of products of samples a few places apart.

use std::ops::Range;

use multiversion::multiversion;

use super::{LANES, RUN, round_end};
use crate::signal::prefetch;

/// Lags that are summed in one pass: half of those of the highest order. They keep their sums in registers.
pub(super) const LAGS: usize = 5;

/// Samples on either side that the highest order needs.
pub(super) const REACH: usize = 2 * LAGS;

/// Whole groups of samples that have all neighbours in their row begin here.
const START: usize = REACH.next_multiple_of(LANES);

/// The samples of a row whose neighbours are in their row, in whole groups.
fn inner(samples: usize) -> Range<usize> {
    START..(samples - REACH) / LANES * LANES
}

/// Adds R_k = Σ_j p_j (q_{j+k} − q_{j−k}) over the inner samples of a run for the [`LAGS`] lags k after `done`.
pub(super) fn add_lags(
    q: &[f64],
    p: &[f64],
    run: Range<usize>,
    done: usize,
    sums: &mut [f64; REACH],
) {
    let inner = inner(q.len());
    let range = run.start.max(inner.start)..run.end.min(inner.end);
    if !range.is_empty() {
        add(sums, done, lag_sums(q, p, range, done, p[0]));
    }
}

/// Adds the samples that are in no run: their neighbours are round the end of the row.
pub(super) fn add_lags_of_ends(q: &[f64], p: &[f64], done: usize, sums: &mut [f64; REACH]) {
    /// The most of them, as whole groups.
    const ENDS: usize = (REACH + LANES - 1 + START).next_multiple_of(LANES);
    let Range { start, end } = inner(q.len());
    let count = q.len() - end + start;
    let q_ends: [f64; ENDS + 2 * REACH] = round_end(q, end - REACH);
    let mut p_ends: [f64; ENDS + 2 * REACH] = round_end(p, end - REACH);
    // The samples behind these are in a run. With the p that all are counted from, they add nothing.
    p_ends[REACH + count..].fill(p[0]);
    add(
        sums,
        done,
        lag_sums(&q_ends, &p_ends, REACH..REACH + ENDS, done, p[0]),
    );
}

fn add(sums: &mut [f64; REACH], done: usize, of_lags: [f64; LAGS]) {
    sums[done..]
        .iter_mut()
        .zip(of_lags)
        .for_each(|(sum, r)| *sum += r);
}

/// Σ (p_j − `reference`) (q_{j+k} − q_{j−k}) for whole groups of j, and the [`LAGS`] lags k after `done`.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
fn lag_sums(q: &[f64], p: &[f64], range: Range<usize>, done: usize, reference: f64) -> [f64; LAGS] {
    let (start, count) = (range.start, range.len());
    let shifted = |start: usize| q[start..][..count].as_chunks::<LANES>().0.iter();
    let pairs = |lag: usize| shifted(start + lag).zip(shifted(start - lag));
    let groups = p[range].as_chunks::<LANES>().0.iter();
    // One iterator for all lags: none of them has to be tested for its end.
    let groups = groups.zip(pairs(done + 1)).zip(pairs(done + 2));
    let groups = groups
        .zip(pairs(done + 3))
        .zip(pairs(done + 4))
        .zip(pairs(done + 5));
    let mut sums = [[0.0; LANES]; LAGS];
    for (((((values, one), two), three), four), five) in groups {
        // This run is in the cache: load the next one.
        prefetch(values, RUN);
        prefetch(one.0, RUN);
        let centred = values.map(|p| p - reference);
        for (sums, (ahead, behind)) in sums.iter_mut().zip([one, two, three, four, five]) {
            for lane in 0..LANES {
                sums[lane] += centred[lane] * (ahead[lane] - behind[lane]);
            }
        }
    }
    sums.map(|lanes| lanes.iter().sum())
}

#[cfg(test)]
mod tests {
    use super::super::runs;
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
            for done in [0, LAGS] {
                runs(samples).for_each(|run| add_lags(&q, &p, run, done, &mut sums));
                add_lags_of_ends(&q, &p, done, &mut sums);
            }
            for (k, sum) in (1..).zip(sums) {
                let around = |j: usize| q[(j + k) % samples] - q[(j + samples - k) % samples];
                let expected: f64 = (0..samples).map(|j| p[j] * around(j)).sum();
                let off = (sum - expected).abs();
                assert!(off < 1e-14 * samples as f64, "{samples}, {k}: {off:e}");
            }
        }
    }
}
