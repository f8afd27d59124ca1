//! One pass over the samples of a degree of freedom.

use multiversion::multiversion;

use super::inspection::{DIFFERENCE, Inspection, P_STRIDE, PWindows, QWindows, SPAN};
use super::lags::{LAGS, MARGIN, Padded, add, add_group};
use super::{LANES, RUN};
use crate::signal::prefetch;

/// Samples from those that are visited to those that are loaded into the cache: more of them than memory takes time for, and all in the
/// first cache.
const AHEAD: usize = 256;

/// What a visit collects, kept for the next.
pub(in crate::rules) struct Visit {
    of_q: QWindows,
    of_p: PWindows,
    /// Every second sample of a run; all samples if the rule copies them.
    pub(super) padded: Padded,
}

impl Visit {
    pub fn new() -> Self {
        Visit {
            of_q: QWindows::new(),
            of_p: PWindows::new(),
            padded: Padded::default(),
        }
    }

    /// Inspects both coordinates, copies every second sample and adds their lags to `sums`; `None` if samples show more than rounding.
    /// The number of samples is even.
    pub(super) fn visit(
        &mut self,
        q: &[f64],
        p: &[f64],
        sums: &mut [f64],
    ) -> Option<[Inspection; 2]> {
        let samples = q.len();
        let firsts = [q[0], p[0]];
        self.of_q.clear();
        self.of_p.clear();
        self.padded.open(q);
        for run in (0..samples).step_by(RUN) {
            let part = run..(run + RUN + SPAN - P_STRIDE).min(samples);
            let copied = self.run([&q[part.clone()], &p[part]], firsts, sums)?;
            self.padded.advance(copied);
        }
        // One or two spans that go round the end of the row.
        const ENDS: usize = P_STRIDE + SPAN;
        let done = self.of_q.spans() * P_STRIDE;
        let others = (samples - done).div_ceil(P_STRIDE);
        let [q_end, p_end]: [[f64; ENDS]; 2] = [round_end(q, done), round_end(p, done)];
        let part = ..(others - 1) * P_STRIDE + SPAN;
        let copied = self.run([&q_end[part], &p_end[part]], firsts, sums)?;
        self.padded.close(q, copied, (samples - done) / 2, sums);
        Some([self.of_q.inspection(samples), self.of_p.inspection(samples)])
    }

    /// Visits the spans of a part of the rows. Returns the number of samples that were copied.
    fn run(&mut self, [q, p]: [&[f64]; 2], firsts: [f64; 2], sums: &mut [f64]) -> Option<usize> {
        let Visit { of_q, of_p, padded } = self;
        let before = of_q.spans();
        let of_run = visit_spans(q, p, firsts, of_q, of_p, &mut padded.q, &mut padded.p);
        add(of_run, sums);
        of_q.check()?;
        of_p.check()?;
        Some((of_q.spans() - before) * LANES)
    }
}

/// Samples from `start` on, round the end of the row.
fn round_end<const COUNT: usize>(row: &[f64], start: usize) -> [f64; COUNT] {
    let mut samples = [0.0; COUNT];
    let (mut to, mut from) = (0, start);
    while to < COUNT {
        let count = (COUNT - to).min(row.len() - from);
        samples[to..to + count].copy_from_slice(&row[from..from + count]);
        (to, from) = (to + count, 0);
    }
    samples
}

/// All work on the spans of a part of the rows, one span after the other, while the next ones are on their way from memory: adds its
/// windows, copies every second sample, and sums the terms of a group that was copied before.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
fn visit_spans(
    q: &[f64],
    p: &[f64],
    [q_first, p_first]: [f64; 2],
    of_q: &mut QWindows,
    of_p: &mut PWindows,
    q_half: &mut [f64],
    p_half: &mut [f64],
) -> [[f64; LANES]; LAGS] {
    let difference = *DIFFERENCE;
    let (mut q_sums, mut p_sums) = (of_q.samples(), of_p.samples());
    let mut lags = [[0.0; LANES]; LAGS];
    let spans = |row| <[f64]>::windows(row, SPAN).step_by(P_STRIDE);
    let count = spans(q).len();
    for (number, (q, p)) in spans(q).zip(spans(p)).enumerate() {
        for group in [0, LANES] {
            prefetch(q, AHEAD + group);
            prefetch(p, AHEAD + group);
        }
        of_q.add(number, q, q_first, &difference, &mut q_sums);
        of_p.add(number, p, p_first, &difference, &mut p_sums);
        let q_even: [f64; LANES] = std::array::from_fn(|k| q[2 * k]);
        let p_even: [f64; LANES] = std::array::from_fn(|k| p[2 * k] - p_first);
        let at = number * LANES;
        q_half[MARGIN + at..][..LANES].copy_from_slice(&q_even);
        p_half[MARGIN + at..][..LANES].copy_from_slice(&p_even);
        add_group::<0>(&q_half[at..], &p_half[at..], &mut lags);
    }
    of_q.end_run(count, q_sums);
    of_p.end_run(count, p_sums);
    lags
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::super::tests::row;
    use super::*;

    #[test]
    fn sums_are_those_of_every_second_sample() {
        let mut visit = Visit::new();
        for samples in (512..=546).step_by(2).chain([1022, 1024, 1026, 1098, 4096]) {
            let q = row(samples, |s| (TAU * s).sin());
            let p = row(samples, |s| 0.3 + (TAU * s + 1.0).cos());
            // What an earlier row left must not be read.
            visit.padded.q.fill(f64::NAN);
            visit.padded.p.fill(f64::NAN);
            let mut sums = [0.0; LAGS];
            assert!(visit.visit(&q, &p, &mut sums).is_some(), "{samples}");
            for (k, sum) in (1..).zip(sums) {
                let around =
                    |j: usize| q[(j + 2 * k) % samples] - q[(j + samples - 2 * k) % samples];
                let places = (0..samples).step_by(2);
                let expected: f64 = places.map(|j| p[j] * around(j)).sum();
                assert!(
                    (sum - expected).abs() < 1e-13,
                    "{samples}, {k}: {sum} {expected}"
                );
            }
        }
    }
}
