//! Sums of products of samples a few places apart.

use multiversion::multiversion;

use super::{LANES, RUN};

/// Lags that are summed in one pass: half of those of the highest order. They keep their sums in registers.
pub(super) const LAGS: usize = 5;

/// Lags of the highest order, in whole groups: so far the neighbours of a sample reach.
const REACH: usize = (2 * LAGS).next_multiple_of(LANES);

/// Groups between the one that is copied and the one that is summed: the neighbours of this one are stored by then.
pub(super) const DELAY: usize = 2;

/// Samples on either side of a row.
pub(super) const MARGIN: usize = REACH + DELAY * LANES;

/// A row of q between samples from its other end, and one of p, less its first sample, between zeros: each group has its neighbours beside it,
/// and what is no sample adds nothing.
#[derive(Default)]
pub(in crate::rules) struct Padded {
    pub q: Vec<f64>,
    pub p: Vec<f64>,
}

impl Padded {
    /// Makes room for this number of samples, with what is beside them; `q` are the samples or, with a `stride` of 2, twice their number.
    pub fn open(&mut self, samples: usize, q: &[f64], stride: usize) {
        self.q.resize(samples + 2 * MARGIN, 0.0);
        self.p.resize(samples + 2 * MARGIN, 0.0);
        let last = &q[q.len() - stride * MARGIN..];
        (self.q.iter_mut().zip(last.iter().step_by(stride))).for_each(|(to, from)| *to = *from);
        self.p[..MARGIN].fill(0.0);
        self.close(q, stride);
    }

    /// Writes what is behind the last sample.
    pub fn close(&mut self, q: &[f64], stride: usize) {
        let behind = self.q.len() - MARGIN;
        (self.q[behind..].iter_mut().zip(q.iter().step_by(stride)))
            .for_each(|(to, from)| *to = *from);
        self.p[behind..].fill(0.0);
    }

    /// Whole rows.
    pub fn copy(&mut self, q: &[f64], p: &[f64]) {
        let samples = MARGIN..MARGIN + q.len();
        self.open(q.len(), q, 1);
        self.q[samples.clone()].copy_from_slice(q);
        (self.p[samples].iter_mut().zip(p)).for_each(|(to, x)| *to = x - p[0]);
    }

    /// Adds Σ_j p_j (q_{j+k} − q_{j−k}) for the samples from `start` on and the [`LAGS`] lags k after `DONE`.
    pub fn add_lags<const DONE: usize>(&self, start: usize, sums: &mut [f64]) {
        let end = self.q.len() - 2 * MARGIN;
        for run in (start..end).step_by(RUN) {
            let groups = (end.min(run + RUN) - run).div_ceil(LANES);
            let part = MARGIN - REACH + run..;
            let of_run = lag_sums::<DONE>(&self.q[part.clone()], &self.p[part], groups);
            add(of_run, sums);
        }
    }
}

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
fn lag_sums<const DONE: usize>(q: &[f64], p: &[f64], groups: usize) -> [[f64; LANES]; LAGS] {
    let mut sums = [[0.0; LANES]; LAGS];
    for group in 0..groups {
        add_group::<DONE>(&q[group * LANES..], &p[group * LANES..], &mut sums);
    }
    sums
}

/// Adds the terms of the group that has its neighbours in front of it at the beginning of `q` and `p`.
#[inline(always)]
pub(super) fn add_group<const DONE: usize>(q: &[f64], p: &[f64], sums: &mut [[f64; LANES]; LAGS]) {
    // Each on its own: put together from parts of its neighbours, it would take longer.
    let p = group_at(p, REACH);
    for (lag, sums) in (DONE + 1..).zip(sums) {
        let (ahead, behind) = (group_at(q, REACH + lag), group_at(q, REACH - lag));
        for lane in 0..LANES {
            sums[lane] += p[lane] * (ahead[lane] - behind[lane]);
        }
    }
}

#[inline(always)]
fn group_at(row: &[f64], at: usize) -> &[f64; LANES] {
    &row[at..].as_chunks().0[0]
}

/// Adds the sums of a run.
pub(super) fn add(of_run: [[f64; LANES]; LAGS], sums: &mut [f64]) {
    for (sum, lanes) in sums.iter_mut().zip(of_run) {
        *sum += lanes.iter().sum::<f64>();
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::row;
    use super::*;

    #[test]
    fn lag_sums_are_those_of_the_definition() {
        let mut padded = Padded::default();
        for samples in [32, 33, 40, 63, 100, 519, 531, 1600] {
            let (q, p) = (
                row(samples, |s| (97.0 * s * s).sin()),
                row(samples, |s| (71.0 * s).cos()),
            );
            padded.copy(&q, &p);
            let mut sums = [0.0; 2 * LAGS];
            padded.add_lags::<0>(0, &mut sums);
            padded.add_lags::<LAGS>(0, &mut sums[LAGS..]);
            for (k, sum) in (1..).zip(sums) {
                let around = |j: usize| q[(j + k) % samples] - q[(j + samples - k) % samples];
                let expected: f64 = (0..samples).map(|j| p[j] * around(j)).sum();
                let off = (sum - expected).abs();
                assert!(off < 1e-14 * samples as f64, "{samples}, {k}: {off:e}");
            }
        }
    }
}
