//! The interpolant of a coordinate on a piece, and how far off it may be.

use super::limits::{CHECKS, DECAYS, DEGREES, FULL, OF_A_CHECK, OF_A_JUMP, SMOOTH};
use super::lobatto::{DEGREE, LOBATTO, NODES, Values, derivative, evaluate, tail_squared};
use crate::signal::Extent;

/// States of a piece that are examined: nodes, then checks.
pub(super) const POINTS: usize = NODES + CHECKS.len();

/// The interpolant of one coordinate on a piece.
pub(super) struct Fit {
    /// Its values at all nodes.
    pub values: Values,
    pub coefficients: Values,
    /// How far off it may be, judged by its last coefficient as well. One that vanishes by symmetry says nothing, but
    /// then the checks do.
    pub off: f64,
    /// Estimate of how far off it is.
    pub error: f64,
}

impl Fit {
    /// Of values at the checks and at the nodes of a level.
    pub fn of(points: &[f64; POINTS], level: usize) -> Self {
        let mut values: Values = points[..NODES].try_into().expect("nodes come first");
        let coefficients = LOBATTO.coefficients(&values, level);
        let stride = DEGREE / DEGREES[level];
        for j in (0..NODES).filter(|j| !j.is_multiple_of(stride)) {
            values[j] = evaluate(&coefficients, LOBATTO.nodes[j]);
        }
        let last = coefficients[DEGREES[level]].abs();
        let misses = CHECKS.iter().zip(&points[NODES..]);
        let misfit = misses.map(|(&x, value)| (evaluate(&coefficients, x) - value).abs());
        let misfit = misfit.fold(0.0, f64::max);
        // The last coefficient and the checks can miss a jump 25 times their size; the tail as a whole does not.
        let tail = match level == FULL && !decays(&coefficients) {
            true => tail_squared(&coefficients).sqrt(),
            false => last,
        };
        Fit {
            values,
            coefficients,
            off: tail.max(misfit),
            error: OF_A_CHECK * misfit,
        }
    }

    /// Of values at all points, as a straight line.
    pub fn straight(points: &[f64; POINTS]) -> Self {
        let values: Values = points[..NODES].try_into().expect("nodes come first");
        let line = |x: f64| values[0] + 0.5 * (1.0 + x) * (values[DEGREE] - values[0]);
        let misses = LOBATTO.nodes.iter().chain(&CHECKS).zip(points);
        let most = misses.fold(0.0, |most: f64, (&x, value)| {
            most.max((line(x) - value).abs())
        });
        let off = OF_A_JUMP * most;
        Fit {
            values,
            coefficients: LOBATTO.coefficients(&values, FULL),
            off,
            error: off,
        }
    }

    pub fn range(&self) -> f64 {
        Extent::of(&self.values).length()
    }
}

/// Sums of squares of coefficients at the beginning and at the end of the tail.
pub(super) fn ends_of_tail(coefficients: &Values) -> [f64; 2] {
    [SMOOTH..SMOOTH + 3, DEGREE - 2..DEGREE + 1].map(|range| {
        let part = &coefficients[range];
        part.iter().map(|a| a * a).sum()
    })
}

/// Whether the tail falls as for a smooth function.
fn decays(coefficients: &Values) -> bool {
    let [early, late] = ends_of_tail(coefficients);
    late < DECAYS * early
}

/// The turning point of the interpolant, if it has one.
pub(super) fn turning_point(fit: &Fit) -> Option<f64> {
    let slopes = derivative(&fit.coefficients);
    let (mut low, mut high) = (-1.0, 1.0);
    let rising = evaluate(&slopes, low) > 0.0;
    if rising == (evaluate(&slopes, high) > 0.0) {
        return None;
    }
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if (evaluate(&slopes, middle) > 0.0) == rising {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(0.5 * (low + high))
}
