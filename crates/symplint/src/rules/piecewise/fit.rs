//! The interpolant of a coordinate on a piece, and how far off it may be.

use multiversion::multiversion;

use super::limits::{
    CHECKS, DEGREES, ERROR_OVER_CHECK, FIRST_SMALL, FULL_LEVEL, MAX_JUMP_OVER_DISTANCE,
    MAX_TAIL_RATIO,
};
use super::lobatto::{
    DEGREE, LOBATTO, NODES, POINTS, Values, derivative, evaluate_each, tail_squared,
};
use crate::signal::Extent;

/// The interpolant of one coordinate on a piece.
pub(super) struct PieceFit {
    /// Its values at all nodes.
    pub values: Values,
    pub coefficients: Values,
    /// The range of those values.
    pub range: f64,
    /// How far off it may be, judged by its last coefficient as well. One that vanishes by symmetry says nothing, but
    /// then the checks do.
    pub off: f64,
    /// Estimate of how far off it is.
    pub error: f64,
}

impl PieceFit {
    /// Of values at all points, as a straight line.
    pub fn straight(points: &[f64; POINTS]) -> Self {
        let values: Values = points[..NODES].try_into().expect("nodes come first");
        let line = |x: f64| values[0] + 0.5 * (1.0 + x) * (values[DEGREE] - values[0]);
        let misses = LOBATTO.nodes.iter().chain(&CHECKS).zip(points);
        let most = misses.fold(0.0, |most: f64, (&x, value)| {
            most.max((line(x) - value).abs())
        });
        let off = MAX_JUMP_OVER_DISTANCE * most;
        PieceFit {
            values,
            coefficients: LOBATTO.coefficients(&values, FULL_LEVEL),
            range: Extent::of(&values).length(),
            off,
            error: off,
        }
    }
}

/// The interpolant of values at the checks and at the nodes of a level.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
pub(super) fn fit(points: &[f64; POINTS], level: usize) -> PieceFit {
    interpolant(points, level)
}

/// Adds the interpolants of several coordinates.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
pub(super) fn fit_all(of_each: &[[f64; POINTS]], level: usize, fits: &mut Vec<PieceFit>) {
    fits.extend(of_each.iter().map(|points| interpolant(points, level)));
}

#[inline(always)] // Into what is compiled for several processors.
fn interpolant(points: &[f64; POINTS], level: usize) -> PieceFit {
    let mut values: Values = *points.first_chunk().expect("nodes come first");
    let coefficients = LOBATTO.coefficients(&values, level);
    let interpolated = LOBATTO.interpolate(&values, level);
    if level < FULL_LEVEL {
        let stride = DEGREE / DEGREES[level];
        for j in (0..NODES).filter(|j| !j.is_multiple_of(stride)) {
            values[j] = interpolated[j];
        }
    }
    let last = coefficients[DEGREES[level]].abs();
    let misses = (NODES..POINTS).map(|k| (interpolated[k] - points[k]).abs());
    let misfit = misses.fold(0.0, f64::max);
    // The last coefficient and the checks can miss a jump 25 times their size; the tail as a whole does not.
    let tail = match level == FULL_LEVEL && !decays(&coefficients) {
        true => tail_squared(&coefficients).sqrt(),
        false => last,
    };
    PieceFit {
        range: Extent::of(&values).length(),
        values,
        coefficients,
        off: tail.max(misfit),
        error: ERROR_OVER_CHECK * misfit,
    }
}

/// Sums of squares of coefficients at the beginning and at the end of the tail.
#[inline(always)]
pub(super) fn ends_of_tail(coefficients: &Values) -> [f64; 2] {
    [FIRST_SMALL..FIRST_SMALL + 3, DEGREE - 2..DEGREE + 1].map(|range| {
        let part = &coefficients[range];
        part.iter().map(|a| a * a).sum()
    })
}

/// Whether the tail falls as for a smooth function.
#[inline(always)]
fn decays(coefficients: &Values) -> bool {
    let [early, late] = ends_of_tail(coefficients);
    late < MAX_TAIL_RATIO * early
}

/// The turning point of the interpolant, if it has one.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
pub(super) fn turning_point(fit: &PieceFit) -> Option<f64> {
    let slopes = derivative(&fit.coefficients);
    let (mut low, mut high) = (-1.0, 1.0);
    let [rising, to_rise] = evaluate_each(&slopes, &[low, high]).map(|slope| slope > 0.0);
    if rising == to_rise {
        return None;
    }
    // Down to 2/9¹³, which is 8e-13. Eight slopes fill vectors and take about as long as one.
    for _ in 0..13 {
        let ends = std::array::from_fn(|k| low + (high - low) * (k + 1) as f64 / 9.0);
        let slopes: [f64; 8] = evaluate_each(&slopes, &ends);
        let turned = |slope: &f64| (*slope > 0.0) != rising;
        match slopes.iter().position(turned) {
            Some(0) => high = ends[0],
            Some(k) => (low, high) = (ends[k - 1], ends[k]),
            None => low = ends[7],
        }
    }
    Some(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fit_of(value: impl Fn(f64) -> f64) -> PieceFit {
        let mut points = [0.0; POINTS];
        let places = LOBATTO.nodes.iter().chain(&CHECKS);
        (points.iter_mut().zip(places)).for_each(|(point, x)| *point = value(*x));
        fit(&points, FULL_LEVEL)
    }

    #[test]
    fn a_parabola_turns_at_its_vertex_and_a_line_does_not() {
        for vertex in [-1.0 + 1e-9, -0.7, -1.0 / 9.0, 0.0, 0.31, 1.0 - 1e-9] {
            for sign in [-1.0, 1.0] {
                let parabola = fit_of(|x| 3.0 + sign * (x - vertex).powi(2));
                let found = turning_point(&parabola).expect("the vertex is inside");
                assert!((found - vertex).abs() < 1e-11, "{vertex} {found}");
            }
        }
        assert_eq!(turning_point(&fit_of(|x| 2.0 * x)), None);
    }
}
