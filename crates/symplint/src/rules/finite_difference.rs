//! The paper's finite-difference rule with cut-offs (section 2.3, appendix B).

use multiversion::multiversion;

use super::RowIntegral;
use crate::error::Error;
use crate::signal::{CompensatedSum, UNIT_ROUNDOFF, largest, unwrap_row, wraps};
use crate::state::scratch::with_buffer;
use crate::state::{Coordinates, Rows};

/// The slope above which a cell counts as a jump and is left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cutoff {
    /// λ: the cut-off is λ times the largest absolute value of the coordinate on the loop.
    Relative(f64),
    /// τ: the cut-off itself, in units of the coordinate per revolution of the loop.
    Absolute(f64),
}

impl Cutoff {
    fn slope(self, largest: f64) -> f64 {
        match self {
            Cutoff::Relative(lambda) => lambda * largest,
            Cutoff::Absolute(tau) => tau,
        }
    }
}

/// Cut-offs on the slopes of position and momentum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cutoffs {
    /// On dq/ds.
    pub q: Cutoff,
    /// On dp/ds.
    pub p: Cutoff,
}

impl Cutoffs {
    /// λ_q = λ_p = `lambda`. The paper takes 10 for the pendulum and 1000 for particle-in-cell.
    pub fn relative(lambda: f64) -> Self {
        Cutoffs {
            q: Cutoff::Relative(lambda),
            p: Cutoff::Relative(lambda),
        }
    }

    /// Retains every cell.
    pub fn none() -> Self {
        Cutoffs {
            q: Cutoff::Absolute(f64::INFINITY),
            p: Cutoff::Absolute(f64::INFINITY),
        }
    }

    pub(super) fn check(&self) -> Result<(), Error> {
        for (what, cutoff) in [("cut-off of q", self.q), ("cut-off of p", self.p)] {
            let (Cutoff::Relative(value) | Cutoff::Absolute(value)) = cutoff;
            if value.is_nan() || value <= 0.0 {
                return Err(Error::OutOfRange {
                    what,
                    value,
                    remedy: "give a positive number",
                });
            }
        }
        Ok(())
    }
}

/// A cell [s_k, s_{k+1}] that a rule left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OmittedCell {
    /// Degree of freedom.
    pub dof: usize,
    /// k: the cell goes from sample k to sample k + 1, round the loop.
    pub cell: usize,
}

/// An increment this part of the one over twice the distance has not halved: a jump. Half way between ½, which is
/// smooth, and 1.
const MIN_PART_AT_JUMP: f64 = 0.75;

/// A jump is this many times the mean increment, or more: a smooth loop of a few modes has increments of a few times
/// the mean.
const MIN_JUMP_OVER_MEAN: f64 = 20.0;

/// Pairs of neighbouring cells that are summed side by side: one in each lane of the widest vector register.
const PAIRS: usize = 8;

/// The sum over every second cell is off by twice as much, so that their difference is the error of the rule to leading
/// order: this many times it covers the terms that follow. In the truth set the largest ratio is 1.31.
const ERROR_MARGIN: f64 = 2.0;

/// Cells of this number of pairs.
const CELLS: usize = 2 * PAIRS;

/// The samples of this number of cells, both ends included.
type Span = [f64; CELLS + 1];

/// One coordinate round the loop.
struct ClosedRow<'a> {
    row: &'a [f64],
    /// Its gain in one turn: sample N is sample 0 and this.
    gain: f64,
    /// The largest absolute value.
    largest: f64,
    /// Cells with a larger slope are left out.
    most: f64,
    /// Jumps are larger than this.
    steep: f64,
}

impl<'a> ClosedRow<'a> {
    fn new(row: &'a [f64], gain: f64, cutoff: Cutoff) -> Self {
        let largest = largest(row);
        ClosedRow {
            row,
            gain,
            largest,
            most: cutoff.slope(largest),
            steep: MIN_JUMP_OVER_MEAN * variation(row, gain) / row.len() as f64,
        }
    }

    /// Sample k, round the loop.
    fn at(&self, k: usize) -> f64 {
        match k.checked_sub(self.row.len()) {
            None => self.row[k],
            Some(k) => self.row[k] + self.gain,
        }
    }

    /// The samples from `start` to the end of the last pair; beyond, the coordinate stands still.
    fn last_span(&self, start: usize) -> Span {
        let end = self.row.len() & !1;
        let mut span = [self.at(end); CELLS + 1];
        span[..end - start].copy_from_slice(&self.row[start..end]);
        span
    }

    /// Whether an increment has not halved from the pair of cells to one of them.
    #[inline(always)]
    fn jumps(&self, increment: f64, over_pair: f64) -> bool {
        (increment.abs() > MIN_PART_AT_JUMP * over_pair.abs()) & (increment.abs() > self.steep)
    }
}

/// Σ |x_{k+1} − x_k| round the loop.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
fn variation(row: &[f64], gain: f64) -> f64 {
    let mut sums = [0.0; PAIRS];
    let (groups, rest) = row[..row.len() - 1].as_chunks::<PAIRS>();
    let (next_groups, next_rest) = row[1..].as_chunks::<PAIRS>();
    for (group, next) in groups.iter().zip(next_groups) {
        for lane in 0..PAIRS {
            sums[lane] += (next[lane] - group[lane]).abs();
        }
    }
    let rest = rest.iter().zip(next_rest).map(|(x, next)| (next - x).abs());
    let closing = (row[0] + gain - row[row.len() - 1]).abs();
    sums.iter().sum::<f64>() + rest.sum::<f64>() + closing
}

/// Sums of which none grows less exact with the number of terms.
#[derive(Default)]
struct CompensatedLanes {
    sums: [f64; PAIRS],
    lost: [f64; PAIRS],
}

impl CompensatedLanes {
    /// Knuth's sum, without a comparison.
    #[inline(always)]
    fn add(&mut self, lane: usize, term: f64) {
        let before = self.sums[lane];
        let sum = before + term;
        let added = sum - before;
        self.lost[lane] += (before - (sum - added)) + (term - added);
        self.sums[lane] = sum;
    }

    fn total(&self) -> f64 {
        let mut total = CompensatedSum::default();
        self.sums
            .iter()
            .chain(&self.lost)
            .for_each(|part| total.add(*part));
        total.total()
    }
}

/// The summand of the cells of a loop.
#[derive(Default)]
struct Sums {
    /// Σ p Δq over the cells, and over the pairs, that are retained.
    value: CompensatedLanes,
    coarse: CompensatedLanes,
    /// Over the cells that are retained: Σ |p Δq|, Σ Δq² and Σ Δp².
    scale: [f64; PAIRS],
    q_squared: [f64; PAIRS],
    p_squared: [f64; PAIRS],
    omitted: Vec<usize>,
    /// Of the cells that were left out without a jump, or retained with one.
    uncertain: f64,
}

impl Sums {
    /// Adds a cell that is retained.
    #[inline(always)]
    fn add(&mut self, lane: usize, p: f64, dq: f64, dp: f64) {
        let term = p * dq;
        self.value.add(lane, term);
        self.scale[lane] += term.abs();
        self.q_squared[lane] += dq * dq;
        self.p_squared[lane] += dp * dp;
    }
}

/// The loop of one degree of freedom.
struct Row<'a> {
    q: ClosedRow<'a>,
    p: ClosedRow<'a>,
}

impl Row<'_> {
    /// Whether no slope is above its cut-off, for this number of increments round the loop.
    #[inline(always)]
    fn retains(&self, dq: f64, dp: f64, increments: f64) -> bool {
        (dq.abs() * increments <= self.q.most) & (dp.abs() * increments <= self.p.most)
    }

    /// Adds the cells and pairs of a span.
    #[inline(always)]
    fn add(&self, start: usize, q: &Span, p: &Span, sums: &mut Sums) {
        let cells = self.q.row.len() as f64;
        let mut special = [0; PAIRS];
        for lane in 0..PAIRS {
            let [q_0, q_1, q_2] = [q[2 * lane], q[2 * lane + 1], q[2 * lane + 2]];
            let [p_0, p_1, p_2] = [p[2 * lane], p[2 * lane + 1], p[2 * lane + 2]];
            let over_pair = q_2 - q_0;
            let retained = self.retains(over_pair, p_2 - p_0, 0.5 * cells);
            let dq = if retained { over_pair } else { 0.0 };
            sums.coarse.add(lane, p_0 * dq);
            for (p, dq, dp) in [(p_0, q_1 - q_0, p_1 - p_0), (p_1, q_2 - q_1, p_2 - p_1)] {
                let retained = self.retains(dq, dp, cells);
                special[lane] |= u64::from(!retained | self.q.jumps(dq, over_pair));
                let [dq, dp] = if retained { [dq, dp] } else { [0.0; 2] };
                sums.add(lane, p, dq, dp);
            }
        }
        if special.iter().fold(0, |any, special| any | special) != 0 {
            self.add_special(start, q, p, sums);
        }
    }

    /// What cells of a span are left out, or retained with a jump.
    #[cold]
    fn add_special(&self, start: usize, q: &Span, p: &Span, sums: &mut Sums) {
        for k in 0..CELLS {
            let pair = k - k % 2;
            self.add_if_special(
                start + k,
                [p[k], p[k + 1]],
                [q[k + 1] - q[k], p[k + 1] - p[k]],
                [q[pair + 2] - q[pair], p[pair + 2] - p[pair]],
                sums,
            );
        }
    }

    fn add_if_special(
        &self,
        cell: usize,
        p: [f64; 2],
        [dq, dp]: [f64; 2],
        over_pair: [f64; 2],
        sums: &mut Sums,
    ) {
        let q_jumps = self.q.jumps(dq, over_pair[0]);
        if self.retains(dq, dp, self.q.row.len() as f64) {
            if q_jumps {
                sums.uncertain += (p[0] * dq).abs();
            }
        } else {
            sums.omitted.push(cell);
            if !q_jumps && !self.p.jumps(dp, over_pair[1]) {
                // Steep but smooth: its part of the integral is missing.
                sums.uncertain += p[0].abs().max(p[1].abs()) * dq.abs();
            }
        }
    }

    /// The last cell of an odd number, which is in no pair: it is added to the coarse sum as it is.
    fn add_last(&self, sums: &mut Sums) {
        let cell = self.q.row.len() - 1;
        let [q, p] = [&self.q, &self.p].map(|x| [0, 1, 2].map(|k| x.at(cell + k)));
        let (dq, dp) = (q[1] - q[0], p[1] - p[0]);
        if self.retains(dq, dp, self.q.row.len() as f64) {
            sums.add(0, p[0], dq, dp);
            sums.coarse.add(0, p[0] * dq);
        }
        let over_pair = [q[2] - q[0], p[2] - p[0]];
        self.add_if_special(cell, [p[0], p[1]], [dq, dp], over_pair, sums);
    }
}

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
fn sums(row: &Row) -> Sums {
    let mut sums = Sums::default();
    let samples = row.q.row.len();
    let mut start = 0;
    while let (Some(q), Some(p)) = (
        row.q.row[start..].first_chunk(),
        row.p.row[start..].first_chunk(),
    ) {
        row.add(start, q, p, &mut sums);
        start += CELLS;
    }
    if start < samples & !1 {
        let (q, p) = (row.q.last_span(start), row.p.last_span(start));
        row.add(start, &q, &p, &mut sums);
    }
    if !samples.is_multiple_of(2) {
        row.add_last(&mut sums);
    }
    sums
}

fn integrate(q: &[f64], gain: f64, p: &[f64], cutoffs: &Cutoffs) -> RowIntegral {
    let row = Row {
        q: ClosedRow::new(q, gain, cutoffs.q),
        p: ClosedRow::new(p, 0.0, cutoffs.p),
    };
    let sums = sums(&row);
    let [scale, q_squared, p_squared] =
        [sums.scale, sums.q_squared, sums.p_squared].map(|lanes| lanes.iter().sum::<f64>());
    let (value, coarse) = (sums.value.total(), sums.coarse.total());
    let stored =
        UNIT_ROUNDOFF * (row.q.largest * p_squared.sqrt() + row.p.largest * q_squared.sqrt());
    RowIntegral {
        value,
        quadrature_error: (q.len() >= 6)
            .then(|| ERROR_MARGIN * (value - coarse).abs() + sums.uncertain),
        roundoff: stored + 2.0 * UNIT_ROUNDOFF * scale,
        scale,
        omitted: sums.omitted,
        regularity: None,
    }
}

pub(super) fn of_rows<'a>(
    q: Rows<'a>,
    p: Rows<'a>,
    coordinates: &'a Coordinates,
    cutoffs: &'a Cutoffs,
) -> impl Fn(usize) -> RowIntegral + Sync + 'a {
    move |i| {
        let (q, p, period) = (q.row(i), p.row(i), coordinates.period(i));
        if !wraps(q, period) {
            return integrate(q, 0.0, p, cutoffs);
        }
        with_buffer(q.len(), |unwrapped| {
            unwrapped.copy_from_slice(q);
            let winding = unwrap_row(unwrapped, period);
            integrate(unwrapped, winding as f64 * period, p, cutoffs)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cutoffs_are_positive() {
        assert_eq!(Cutoffs::none().check(), Ok(()));
        for (q, p) in [(0.0, 1.0), (1.0, -1.0), (f64::NAN, 1.0), (1.0, f64::NAN)] {
            let [q, p] = [q, p].map(Cutoff::Relative);
            assert!(Cutoffs { q, p }.check().is_err(), "{q:?} {p:?}");
        }
    }

    #[test]
    fn what_sums_lose_is_kept() {
        for terms in [[1e17, 1.0, -1e17, 3.0], [1.0, 1e17, 3.0, -1e17]] {
            for lane in [0, PAIRS - 1] {
                let mut lanes = CompensatedLanes::default();
                terms.iter().for_each(|&term| lanes.add(lane, term));
                assert_eq!(lanes.total(), 4.0, "{terms:?}");
            }
        }
    }

    #[test]
    fn the_variation_counts_every_increment_and_the_closing_one() {
        for n in [1, 2, 7, 9, 16, 17, 20] {
            // Down and up by one, and from the last sample to the first, which gained.
            let row: Vec<f64> = (0..n).map(|k| 5.0 + f64::from(k % 2 == 1)).collect();
            let last = row[n - 1] - 5.0;
            for gain in [0.0, 10.0, -10.0] {
                let expected = (n - 1) as f64 + (gain - last).abs();
                assert_eq!(variation(&row, gain), expected, "{n} samples, {gain}");
            }
        }
    }

    /// Σ over the cells that may be jumps, for a loop whose position or momentum rises slowly, but for a step of one
    /// in `cell`.
    fn uncertain(n: usize, cell: usize, q_steps: bool, cutoff: f64) -> f64 {
        let slow = |k: usize| 7.0 + 1e-3 * ((k + n - cell) as f64).sin();
        let step = |k: usize| f64::from((k + n - 1 - cell) % n < n / 2);
        let stepped: Vec<f64> = (0..n).map(|k| slow(k) + step(k)).collect();
        let smooth: Vec<f64> = (0..n).map(slow).collect();
        let (q, p) = if q_steps {
            (stepped, smooth)
        } else {
            (smooth, stepped)
        };
        let cutoff = Cutoff::Absolute(cutoff);
        let none = Cutoff::Absolute(f64::INFINITY);
        sums(&Row {
            q: ClosedRow::new(&q, 0.0, if q_steps { cutoff } else { none }),
            p: ClosedRow::new(&p, 0.0, if q_steps { none } else { cutoff }),
        })
        .uncertain
    }

    #[test]
    fn a_step_is_a_jump_in_every_cell() {
        for n in [121, 128] {
            for cell in [0, 1, 17, n / 2 - 1, n - 2, n - 1] {
                // Retained, it makes p Δq uncertain: once up, once down.
                let retained = uncertain(n, cell, true, 1e9);
                assert!(
                    (retained - 2.0 * 7.0).abs() < 0.1,
                    "{n}, {cell}: {retained}"
                );
                // A cell that is left out has no uncertainty.
                for q_steps in [true, false] {
                    let omitted = uncertain(n, cell, q_steps, 10.0);
                    assert_eq!(omitted, 0.0, "{n}, {cell}, {q_steps}");
                }
            }
        }
    }

    #[test]
    fn storing_an_ellipse_costs_what_theory_says() {
        // Σ Δx² of an ellipse with N samples is 2 N sin²(π/N) times the square of its semi-axis.
        let n = 64;
        let (a, b) = (3.0, 0.25);
        let angle = |k: usize| std::f64::consts::TAU * k as f64 / n as f64;
        let q: Vec<f64> = (0..n).map(|k| a * angle(k).cos()).collect();
        let p: Vec<f64> = (0..n).map(|k| b * angle(k).sin()).collect();
        let result = integrate(&q, 0.0, &p, &Cutoffs::none());
        let root = (2.0 * n as f64).sqrt() * (std::f64::consts::PI / n as f64).sin();
        // Each is the largest value of one times the root of the other.
        let expected = UNIT_ROUNDOFF * (2.0 * a * b * root + 2.0 * result.scale);
        assert!((result.roundoff / expected - 1.0).abs() < 1e-12);
    }
}
