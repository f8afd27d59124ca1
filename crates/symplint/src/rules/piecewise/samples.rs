//! What equispaced samples of the advanced loop say of the interpolants of a piece.

use multiversion::multiversion;

use super::examine::View;
use super::fit::PieceFit;
use super::limits::{MARGIN_BETWEEN_POINTS, MAX_JUMP_OVER_MISS, SAMPLES_PER_ESTIMATE};
use super::lobatto::{Values, derivative, evaluate_each};
use super::piece::InterpolationMiss;
use crate::signal::{Extent, LANES, nearest};
use crate::state::{Ensemble, coordinate, period};

/// The samples between the ends of a piece.
struct InnerSamples<'a> {
    view: &'a View<'a>,
    advanced: &'a Ensemble,
    /// The number of the first one.
    first: usize,
    /// Where they are on the piece, from −1 to 1.
    x: Vec<f64>,
}

impl<'a> InnerSamples<'a> {
    /// There are samples of the loop itself alone, not of the segments that close its breaks.
    fn of(view: &'a View<'a>) -> Option<Self> {
        let advanced = view.samples.filter(|_| view.piece.curve == 0)?;
        let samples = advanced.samples() as f64;
        let first = ((view.piece.a * samples).floor() + 1.0).clamp(0.0, samples) as usize;
        let end = (view.piece.b * samples).ceil().min(samples) as usize;
        let inside = first..end.max(first);
        Some(InnerSamples {
            view,
            advanced,
            first,
            x: inside.map(|k| view.piece.x(k as f64 / samples)).collect(),
        })
    }

    /// The error of the interpolant of a coordinate at each of the first `count` samples.
    fn misses(&self, c: usize, fit: &PieceFit, count: usize) -> Vec<f64> {
        let row = &coordinate(self.advanced, c)[self.first..][..count];
        let period = period(self.view.coordinates, c);
        let mut misses = along(&self.x[..count], &fit.coefficients);
        for (miss, seen) in misses.iter_mut().zip(row) {
            *miss = nearest(seen - *miss, period);
        }
        misses
    }
}

/// Σ a_k T_k at each of the parameters.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
fn along(x: &[f64], coefficients: &Values) -> Vec<f64> {
    let mut values = x.to_vec();
    for chunk in values.chunks_mut(LANES) {
        let mut lanes = [0.0; LANES];
        lanes[..chunk.len()].copy_from_slice(chunk);
        chunk.copy_from_slice(&evaluate_each(coefficients, &lanes)[..chunk.len()]);
    }
    values
}

/// The parameter of the first sample on the piece that is not where the interpolant of some coordinate has it.
pub(super) fn missed_sample(view: &View<'_>) -> Option<f64> {
    let inside = InnerSamples::of(view)?;
    let all = inside.x.len();
    let first = view.fits.iter().enumerate().fold(all, |first, (c, fit)| {
        let most = MARGIN_BETWEEN_POINTS * view.allowed(c, fit);
        let misses = inside.misses(c, fit, first);
        let is_off = |off: &f64| off.abs() > most;
        misses.iter().position(is_off).unwrap_or(first)
    });
    let of_sample = |k: usize| (inside.first + k) as f64 / inside.advanced.samples() as f64;
    (first < all).then(|| of_sample(first))
}

/// ∫ (δp dq − δq dp) over the piece, where δq and δp are what the interpolants miss the loop by, by the trapezoidal rule on
/// every `SAMPLES_PER_ESTIMATE`-th sample: the error of the interpolated integral to first order, as δq vanishes at both ends. A jump
/// of q is not a part of the integral, but of the integral of the interpolant.
pub(super) fn missed(view: &View<'_>) -> Option<InterpolationMiss> {
    let inside = InnerSamples::of(view)?;
    let all = inside.x.len();
    if all < SAMPLES_PER_ESTIMATE {
        return None;
    }
    let dof = view.dof();
    let mut estimates = [0.0; SAMPLES_PER_ESTIMATE];
    let mut jump = 0.0;
    for i in 0..dof {
        let (q, p) = (&view.fits[i], &view.fits[dof + i]);
        let (of_q, of_p) = (inside.misses(i, q, all), inside.misses(dof + i, p, all));
        let [dq, dp] = [q, p].map(|fit| along(&inside.x, &derivative(&fit.coefficients)));
        let weight = view.coordinates.weight(i);
        let mut largest = 0.0f64;
        for k in 0..all {
            largest = largest.max(of_q[k].abs());
            let part = of_p[k] * dq[k] - of_q[k] * dp[k];
            estimates[(inside.first + k) % SAMPLES_PER_ESTIMATE] += weight * part;
        }
        // The noise of the map makes no jumps.
        let size = MAX_JUMP_OVER_MISS * (largest - view.scales.noise[i]).max(0.0);
        jump += weight.abs() * size * Extent::of(&p.values).magnitude();
    }
    // From the derivative by x to that by s, and from sums to means.
    let spacing = SAMPLES_PER_ESTIMATE as f64 / inside.advanced.samples() as f64;
    let of_spacing = spacing * 2.0 / view.piece.length();
    Some(InterpolationMiss {
        estimates: estimates.map(|sum| sum * of_spacing),
        jump,
    })
}
