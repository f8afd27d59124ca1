//! Sums of products of samples a few places apart.

use std::ops::Range;

use multiversion::multiversion;

use super::{LANES, RUN};

/// Lags that are summed in one pass: half of those of the highest order. They keep their sums in registers.
pub(super) const LAGS: usize = 5;

/// Neighbours on either side that the highest order needs, rounded up to whole groups.
const REACH: usize = (2 * LAGS).next_multiple_of(LANES);

/// Groups by which the sums lag behind the copy: what was just stored cannot be loaded at another place at once.
const DELAY: usize = 4;

/// Samples before those that are copied next.
pub(super) const MARGIN: usize = REACH + DELAY * LANES;

/// Copies of samples of q, and of p less the first of its row, with what is beside them round the loop: for q its samples, for p zeros,
/// which add nothing.
#[derive(Default)]
pub(super) struct Padded {
    pub q: Vec<f64>,
    pub p: Vec<f64>,
}

impl Padded {
    /// Begins with every second sample, of which a run is copied at a time. Before the first there are the last ones, with zeros of p: they
    /// are summed by [`close`](Self::close).
    pub fn open(&mut self, q: &[f64]) {
        self.resize(RUN / 2);
        let last = q[q.len() - 2 * MARGIN..].iter().step_by(2);
        (self.q.iter_mut().zip(last)).for_each(|(to, from)| *to = *from);
        self.p[..MARGIN].fill(0.0);
    }

    /// Makes room for the next run behind one of this number of samples, of which the last groups are yet to be summed.
    pub fn advance(&mut self, samples: usize) {
        for row in [&mut self.q, &mut self.p] {
            row.copy_within(samples..samples + MARGIN, 0);
        }
    }

    /// Adds the last groups of every second sample. Behind the margin there are `copied` ones, of which the first `own` are before the end of
    /// the row.
    pub fn close(&mut self, q: &[f64], copied: usize, own: usize, sums: &mut [f64]) {
        let next = q[2 * (copied - own)..].iter().step_by(2);
        let behind = &mut self.q[MARGIN + copied..][..REACH];
        behind
            .iter_mut()
            .zip(next)
            .for_each(|(to, from)| *to = *from);
        self.p[MARGIN + own..MARGIN + copied].fill(0.0);
        self.add_lags::<0>(copied + REACH..MARGIN + own, sums);
    }

    /// Whole rows. Returns where they are.
    pub fn copy(&mut self, q: &[f64], p: &[f64]) -> Range<usize> {
        let samples = q.len();
        let own = MARGIN..MARGIN + samples;
        self.resize(samples);
        self.q[..MARGIN].copy_from_slice(&q[samples - MARGIN..]);
        self.q[own.clone()].copy_from_slice(q);
        self.q[own.end..].copy_from_slice(&q[..MARGIN]);
        self.p[..MARGIN].fill(0.0);
        (self.p[own.clone()].iter_mut().zip(p)).for_each(|(to, x)| *to = x - p[0]);
        self.p[own.end..].fill(0.0);
        own
    }

    fn resize(&mut self, samples: usize) {
        self.q.resize(samples + 2 * MARGIN, 0.0);
        self.p.resize(samples + 2 * MARGIN, 0.0);
    }

    /// Adds Σ_j p_j (q_{j+k} − q_{j−k}) for the samples at these places, and the [`LAGS`] lags k after `DONE`.
    pub fn add_lags<const DONE: usize>(&self, places: Range<usize>, sums: &mut [f64]) {
        for run in places.clone().step_by(RUN) {
            let groups = (places.end.min(run + RUN) - run).div_ceil(LANES);
            let (q, p) = (&self.q[run - REACH..], &self.p[run - REACH..]);
            add(lag_sums::<DONE>(q, p, groups), sums);
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

/// Adds the terms of the group at [`REACH`]: `q` and `p` begin with its neighbours.
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
        for samples in [48, 49, 56, 63, 100, 519, 531, 1600] {
            let (q, p) = (
                row(samples, |s| (97.0 * s * s).sin()),
                row(samples, |s| (71.0 * s).cos()),
            );
            let places = padded.copy(&q, &p);
            let mut sums = [0.0; 2 * LAGS];
            padded.add_lags::<0>(places.clone(), &mut sums);
            padded.add_lags::<LAGS>(places, &mut sums[LAGS..]);
            for (k, sum) in (1..).zip(sums) {
                let around = |j: usize| q[(j + k) % samples] - q[(j + samples - k) % samples];
                let expected: f64 = (0..samples).map(|j| p[j] * around(j)).sum();
                let off = (sum - expected).abs();
                assert!(off < 1e-14 * samples as f64, "{samples}, {k}: {off:e}");
            }
        }
    }
}
