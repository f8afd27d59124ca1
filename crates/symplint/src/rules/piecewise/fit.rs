//! The interpolant of a coordinate on a piece, and how far off it may be.

use super::lobatto::{DEGREE, LOBATTO, NODES, Values, derivative, evaluate};

/// Where an interpolant is held against states that it was not made of.
pub(super) const CHECKS: [f64; 2] = [-0.618, 0.267];

/// States of a piece that are looked at.
pub(super) const POINTS: usize = NODES + CHECKS.len();

/// A jump on a straight line leaves a point at least 1/`OF_A_JUMP` of it beside the line through the ends.
const OF_A_JUMP: f64 = 2.5;

/// The interpolant of one coordinate on a piece.
pub(super) struct Fit {
    pub values: Values,
    pub coefficients: Values,
    /// How far off it may be.
    pub off: f64,
}

impl Fit {
    /// Of values at the nodes and the checks; a `short` piece is a straight line.
    pub fn of(points: &[f64; POINTS], short: bool) -> Self {
        let values: Values = points[..NODES].try_into().expect("nodes come first");
        let coefficients = LOBATTO.coefficients(&values);
        let mut fit = Fit {
            values,
            coefficients,
            off: 0.0,
        };
        if short {
            let line = |x: f64| values[0] + 0.5 * (1.0 + x) * (values[DEGREE] - values[0]);
            let misses = LOBATTO.nodes.iter().chain(&CHECKS).zip(points);
            fit.off = (misses.map(|(&x, value)| (line(x) - value).abs()))
                .fold(0.0, |most: f64, miss| most.max(OF_A_JUMP * miss));
            return fit;
        }
        let last = &coefficients[DEGREE - 2..];
        let misses = CHECKS.iter().zip(&points[NODES..]);
        let misfit = misses.map(|(&x, value)| (evaluate(&coefficients, x) - value).abs());
        fit.off = (last.iter().map(|a| a.abs()))
            .chain(misfit)
            .fold(0.0, f64::max);
        fit
    }

    pub fn range(&self) -> f64 {
        let low = self.values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = self
            .values
            .iter()
            .copied()
            .fold(f64::NEG_INFINITY, f64::max);
        high - low
    }
}

/// Where the interpolant turns round, if it does so once.
pub(super) fn turn(fit: &Fit) -> Option<f64> {
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
