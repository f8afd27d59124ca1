//! The paper's finite-difference rule with cut-offs (section 2.3, appendix B).

use rayon::prelude::*;

use super::RowIntegral;
use crate::error::Error;
use crate::signal::{CompensatedSum, UNIT_ROUNDOFF, unwrap_row};
use crate::state::Coordinates;
use crate::state::Ensemble;

/// The slope above which a cell counts as a jump and is left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cutoff {
    /// λ: the cut-off is λ times the largest absolute value of the coordinate on the loop.
    Relative(f64),
    /// τ: the cut-off itself, in units of the coordinate per turn of the loop.
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

/// One degree of freedom of a loop, positions unwrapped.
struct Row<'a> {
    q: &'a [f64],
    p: &'a [f64],
    /// What q gains in one turn.
    gain: f64,
}

impl Row<'_> {
    /// (Δq, Δp) from sample k to sample k + step, round the loop.
    fn increment(&self, k: usize, step: usize) -> (f64, f64) {
        let n = self.q.len();
        let next = k + step;
        let (to, gain) = if next < n {
            (next, 0.0)
        } else {
            (next - n, self.gain)
        };
        (self.q[to] + gain - self.q[k], self.p[to] - self.p[k])
    }
}

/// The largest absolute value.
fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m: f64, v| m.max(v.abs()))
}

/// An increment this part of the one over twice the distance has not halved: a jump.
const STAYS: f64 = 0.75;

/// A jump is this many times the mean increment, or more.
const STEEP: f64 = 20.0;

fn integrate(row: &Row<'_>, cutoffs: &Cutoffs) -> RowIntegral {
    let n = row.q.len();
    let (max_q, max_p) = (largest(row.q), largest(row.p));
    let (limit_q, limit_p) = (cutoffs.q.slope(max_q), cutoffs.p.slope(max_p));
    let retained = |(dq, dp): (f64, f64), cells: f64| {
        dq.abs() * cells <= limit_q && dp.abs() * cells <= limit_p
    };
    let (mut q_variation, mut p_variation) = (0.0, 0.0);
    for k in 0..n {
        let (dq, dp) = row.increment(k, 1);
        q_variation += dq.abs();
        p_variation += dp.abs();
    }
    let jumps = |increment: f64, wide: f64, variation: f64| {
        increment.abs() > STAYS * wide.abs() && increment.abs() > STEEP * variation / n as f64
    };

    let (mut value, mut coarse) = (CompensatedSum::default(), CompensatedSum::default());
    let (mut scale, mut doubtful) = (0.0, 0.0);
    let (mut q_squared, mut p_squared) = (0.0, 0.0);
    let mut omitted = Vec::new();
    for k in 0..n {
        let (dq, dp) = row.increment(k, 1);
        let term = row.p[k] * dq;
        // The cell of twice the width that holds this one.
        let wide = row.increment(k - k % 2, 2);
        let q_jumps = jumps(dq, wide.0, q_variation);
        if retained((dq, dp), n as f64) {
            value.add(term);
            scale += term.abs();
            q_squared += dq * dq;
            p_squared += dp * dp;
            if q_jumps {
                doubtful += term.abs();
            }
        } else {
            omitted.push(k);
            if !q_jumps && !jumps(dp, wide.1, p_variation) {
                // Steep but smooth: its part of the integral is missing.
                let larger_p = row.p[k].abs().max((row.p[k] + dp).abs());
                doubtful += larger_p * dq.abs();
            }
        }
        if k % 2 == 0 && k + 1 < n && retained(wide, n as f64 / 2.0) {
            coarse.add(row.p[k] * wide.0);
        }
    }
    if n % 2 == 1 {
        let last = row.increment(n - 1, 1);
        if retained(last, n as f64) {
            coarse.add(row.p[n - 1] * last.0);
        }
    }
    let stored = UNIT_ROUNDOFF * (max_q * p_squared.sqrt() + max_p * q_squared.sqrt());
    RowIntegral {
        value: value.total(),
        quadrature_error: (n >= 6).then(|| (value.total() - coarse.total()).abs() + doubtful),
        roundoff: stored + 2.0 * UNIT_ROUNDOFF * scale,
        scale,
        omitted,
        regularity: None,
    }
}

pub(super) fn rows(
    ensemble: &Ensemble,
    coordinates: &Coordinates,
    cutoffs: &Cutoffs,
) -> Vec<RowIntegral> {
    let (q, p) = (ensemble.q(), ensemble.p());
    (0..ensemble.dof())
        .into_par_iter()
        .map(|i| {
            let period = coordinates.period(i);
            let mut unwrapped;
            let (q, winding) = if period > 0.0 {
                unwrapped = q.row(i).to_vec();
                let winding = unwrap_row(&mut unwrapped, period);
                (unwrapped.as_slice(), winding)
            } else {
                (q.row(i), 0)
            };
            let row = Row {
                q,
                p: p.row(i),
                gain: winding as f64 * period,
            };
            integrate(&row, cutoffs)
        })
        .collect()
}
