//! ∮ p dq of one degree of freedom whose samples jump in some cells.
//!
//! On the cells between, the trapezoid rule. In a flagged cell (a run of them, where several
//! adjoin) the smooth stretches on both sides are continued to its middle: where in the cell the break is,
//! the samples do not say, and what that makes uncertain is in the error.

use super::increments::Increments;
use crate::signal::{CompensatedSum, Extent};

/// The integral of one degree of freedom, without its weight.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pieces {
    /// The absolutely continuous part.
    pub continuous: f64,
    /// Estimate of its error.
    pub error: f64,
    /// Chords across the breaks, ½ (p⁻ + p⁺)(q⁺ − q⁻).
    pub chord: f64,
    /// Estimate of the error of `continuous + chord`.
    pub closed_error: f64,
    /// A bound on the contribution of the flagged cells if they are steep but not broken.
    pub steep: f64,
    /// Sum of the absolute values of all terms.
    pub scale: f64,
}

/// q and p with their derivatives in s, in units of one cell.
#[derive(Clone, Copy, Debug)]
struct Side {
    q: f64,
    p: f64,
    q_slope: f64,
    p_slope: f64,
    /// Integral from the last sample to here.
    integral: f64,
    /// How far the continuation may be off, times what it multiplies.
    error: f64,
}

/// One degree of freedom of a loop.
pub(super) struct Curve<'a> {
    pub q: &'a Increments,
    pub p: &'a Increments,
    /// p at the samples.
    pub momenta: &'a [f64],
    /// Cells that jump in q or in p.
    pub flagged: &'a [bool],
    /// Those of them in which rows may be missing, where the loop need not jump.
    pub gaps: &'a [bool],
}

impl Curve<'_> {
    pub fn integrate(&self) -> Pieces {
        let n = self.flagged.len();
        let mut pieces = Pieces::default();
        let (mut continuous, mut chord) = (CompensatedSum::default(), CompensatedSum::default());
        let mut refinement = 0.0;
        for k in (0..n).filter(|&k| !self.flagged[k]) {
            let (p, dq, dp) = (self.momenta[k], self.q.values[k], self.p.values[k]);
            let term = (p + 0.5 * dp) * dq;
            continuous.add(term);
            pieces.scale += term.abs();
            let next = (k + 1) % n;
            if !self.flagged[next] {
                // This cell and the next one as one: differs by the triangle between.
                refinement += 0.5 * (dp * self.q.values[next] - self.p.values[next] * dq).abs();
            }
        }
        // Every cell is in two pairs, and a pair is off by three times the error of its cells.
        pieces.error = refinement / 2.0;
        pieces.closed_error = pieces.error;
        // From a clean cell on, so that no run is cut at the last sample.
        let Some(origin) = (0..n).find(|&k| !self.flagged[k]) else {
            return pieces;
        };
        let mut k = 0;
        while k < n {
            let first = (origin + k) % n;
            if !self.flagged[first] {
                k += 1;
                continue;
            }
            let width = (0..n - k)
                .take_while(|j| self.flagged[(first + j) % n])
                .count();
            self.cross(first, width, &mut pieces, &mut continuous, &mut chord);
            k += width;
        }
        pieces.continuous = continuous.total();
        pieces.chord = chord.total();
        pieces
    }

    /// Adds a run of `width` flagged cells from `first` on.
    fn cross(
        &self,
        first: usize,
        width: usize,
        pieces: &mut Pieces,
        continuous: &mut CompensatedSum,
        chord: &mut CompensatedSum,
    ) {
        let n = self.flagged.len();
        let half = 0.5 * width as f64;
        let span: f64 = (first..first + width).map(|k| self.q.values[k % n]).sum();
        let left = self.continued(first, half, false);
        let right = self.continued((first + width) % n, half, true);
        continuous.add(left.integral + right.integral);
        pieces.scale += left.integral.abs() + right.integral.abs();
        // Positions are relative to the sample on either side of the run.
        let jump_q = span + right.q - left.q;
        let jump_p = right.p - left.p;
        let segment = 0.5 * (left.p + right.p) * jump_q;
        chord.add(segment);

        let off = left.error + right.error;
        // Moving the break by one cell changes the integral by the difference of p dq/ds, and the
        // closed one by less: what one side loses the chord mostly gains.
        let of_place = (left.p * left.q_slope - right.p * right.q_slope).abs();
        let of_closed = 0.5
            * ((left.p_slope + right.p_slope) * jump_q - jump_p * (left.q_slope + right.q_slope))
                .abs();
        // Several breaks may share a run: between them neither continuation need hold.
        let between = if width > 1 {
            self.spread(first, width)
        } else {
            0.0
        };
        pieces.error += half * of_place + off + between;
        pieces.closed_error += half * of_closed + off + between;
        // If rows were lost, one may be lost in this run as well, where the jump hides that it is a cell wider.
        if self.gaps.contains(&true) {
            let of_cell = |side: &Side| (side.p * side.q_slope).abs();
            pieces.error += 0.5 * of_place + of_cell(&left).max(of_cell(&right));
            pieces.closed_error += 0.5 * of_closed;
        }
        let steep = segment.abs() + 0.5 * (jump_q * jump_p).abs();
        pieces.steep += steep;
        if (first..first + width).any(|k| self.gaps[k % n]) {
            pieces.error += steep;
            pieces.closed_error += 0.5 * (jump_q * jump_p).abs();
        }
    }

    /// What p dq/ds may vary within a run, times its width.
    fn spread(&self, first: usize, width: usize) -> f64 {
        let n = self.flagged.len();
        let mut momenta = Extent::default();
        (first..=first + width).for_each(|k| momenta.include(self.momenta[k % n]));
        let slope = |k: usize| self.q.values[k % n].abs();
        let steepest = slope(first + n - 1).max(slope(first + width));
        width as f64 * momenta.length() * steepest
    }

    /// Continues the smooth stretch that ends (`backwards`: begins) at sample `k` by `distance` cells.
    fn continued(&self, k: usize, distance: f64, backwards: bool) -> Side {
        let n = self.flagged.len();
        let sign = if backwards { -1.0 } else { 1.0 };
        let cell = |j: usize| {
            if backwards {
                (k + j) % n
            } else {
                (k + n - 1 - j) % n
            }
        };
        let curved = !self.flagged[cell(1)];
        // The increment at distance j on the smooth side, and its change from cell to cell.
        let continue_one = |increments: &[f64]| {
            let near = increments[cell(0)];
            let change = if curved {
                near - increments[cell(1)]
            } else {
                0.0
            };
            // The slope at the sample, half a cell on, and at the end of the continuation.
            let slope = near + change / 2.0;
            let gained = distance * slope + 0.5 * distance * distance * change;
            (
                gained,
                slope + distance * change,
                (gained - distance * near).abs(),
            )
        };
        let (gained_q, q_slope, bent_q) = continue_one(&self.q.values);
        let (gained_p, p_slope, bent_p) = continue_one(&self.p.values);
        let start = self.momenta[k];
        let p = start + sign * gained_p;
        Side {
            q: sign * gained_q,
            p,
            q_slope,
            p_slope,
            integral: 0.5 * (start + p) * gained_q,
            error: bent_q * p.abs() + bent_p * gained_q.abs(),
        }
    }
}

/// What rounding of the stored values leaves uncertain in ∮ p dq: the rounding errors of both coordinates, as noise
/// along the loop, three standard deviations of it.
pub(super) fn stored_roundoff([q, p]: &[Increments; 2], [error_q, error_p]: [f64; 2]) -> f64 {
    let length = |x: &Increments| x.values.iter().map(|d| d * d).sum::<f64>().sqrt();
    let noise = 3.0 * (error_q * length(p) + error_p * length(q));
    // A winding loop adds the mean of p, which is rounded.
    noise + error_p * q.gain.abs()
}
