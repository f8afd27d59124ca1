//! Central differences at a sequence of distances, extrapolated to distance zero.
//!
//! Richardson's extrapolation in the form of C. Ridders, "Accurate computation of F'(x) and
//! F'(x) F''(x)", Adv. Eng. Software 4 (1982): every entry of the table comes with an error estimate
//! from its neighbours, and the best entry counts. Three things are added, as a table can
//! converge to a wrong number:
//!
//! * the even part of the differences, which a kink keeps from going to zero, however symmetric it is;
//! * the noise of the map over the distance;
//! * the distance to the entry of the smallest differences, which are nearest to the definition.

use std::ops::Range;

use super::constants::CONSTANTS;
use super::derivative::Derivative;
use crate::signal::extrapolate;

pub(super) const LEVELS: usize = CONSTANTS.levels;
/// States at ±t for every distance.
pub(super) const STATES: usize = 2 * LEVELS;

/// The distances that every derivative has, and those that are added where they help.
pub(super) const FIRST_LEVELS: Range<usize> = 0..CONSTANTS.first_levels;
pub(super) const FINER_LEVELS: Range<usize> = CONSTANTS.first_levels..LEVELS;

/// States of the first distances.
pub(super) const FIRST_STATES: usize = 2 * FIRST_LEVELS.end;

/// The distance at a level, in units of the direction.
fn distance(level: usize) -> f64 {
    CONSTANTS.first_distance * CONSTANTS.ratio.powi(-(level as i32))
}

/// The states at some levels: +t, −t for each in turn.
pub(super) fn displacements(levels: Range<usize>) -> impl Iterator<Item = f64> {
    levels.map(distance).flat_map(|t| [t, -t])
}

/// Whether finer levels can improve a derivative from the first ones: if its error is of interest, and noise
/// over the finer distances is not as large.
pub(super) fn finer_levels_help(derivative: &Derivative, noise: f64) -> bool {
    let of_interest = CONSTANTS.least_defect_of_differences * derivative.largest();
    derivative.largest_error()
        > of_interest.max(CONSTANTS.gain * noise / distance(FINER_LEVELS.start))
}

type Table = [[f64; CONSTANTS.deepest + 1]; LEVELS];

/// One coordinate's tables: of the odd part of the differences, the derivative, and of the even part,
/// zero for a differentiable map.
struct Tables {
    odd: Table,
    even: Table,
    levels: usize,
    noise: f64,
}

/// An entry of a table with the two parts of its error.
struct Entry {
    value: f64,
    truncation: f64,
    noise: f64,
}

impl Tables {
    fn new(levels: usize, differences: &[f64; STATES], noise: f64) -> Self {
        let part = |sign: f64| {
            (0..levels).map(move |level| {
                let (ahead, behind) = (differences[2 * level], differences[2 * level + 1]);
                (ahead + sign * behind) / (2.0 * distance(level))
            })
        };
        Tables {
            odd: extrapolate(part(-1.0), CONSTANTS.ratio, 2),
            even: extrapolate(part(1.0), CONSTANTS.ratio, 1),
            levels,
            noise,
        }
    }

    fn plain_entry(&self, level: usize, depth: usize) -> Entry {
        let value = self.odd[level][depth];
        let step = (value - self.odd[level][depth - 1]).abs();
        let other = (value - self.odd[level - 1][depth - 1]).abs();
        Entry {
            value,
            truncation: step.max(other) + self.even[level][depth].abs(),
            noise: CONSTANTS.gain * self.noise / distance(level),
        }
    }

    fn entry(&self, level: usize, depth: usize) -> Entry {
        let mut entry = self.plain_entry(level, depth);
        let finest = self.plain_entry(self.levels - 1, 1);
        let apart = (entry.value - finest.value).abs() - finest.truncation - finest.noise;
        entry.truncation += apart.max(0.0);
        entry
    }
}

/// The derivative from this number of levels: for every coordinate the differences to its value at the centre, in the
/// order of [`displacements`], and the noise of a value.
///
/// One entry of the table serves all coordinates: if each chose its own, chance would pick
/// neighbours that agree by accident.
pub(super) fn derivative(
    coordinates: usize,
    levels: usize,
    differences: impl Fn(usize) -> ([f64; STATES], f64),
) -> Derivative {
    let entries = || {
        (1..levels)
            .flat_map(|level| (1..=level.min(CONSTANTS.deepest)).map(move |depth| (level, depth)))
    };
    let tables = |c: usize| {
        let (differences, noise) = differences(c);
        Tables::new(levels, &differences, noise)
    };
    let mut worst = [[0.0_f64; CONSTANTS.deepest + 1]; LEVELS];
    for c in 0..coordinates {
        let tables = tables(c);
        for (level, depth) in entries() {
            let entry = tables.entry(level, depth);
            let error = entry.truncation + entry.noise;
            worst[level][depth] = worst[level][depth].max(error);
        }
    }
    let chosen = entries().min_by(|a, b| worst[a.0][a.1].total_cmp(&worst[b.0][b.1]));
    let (level, depth) = chosen.unwrap_or((levels - 1, 1));
    let mut found = Derivative {
        value: Vec::with_capacity(coordinates),
        error: Vec::with_capacity(coordinates),
        converged: false,
        trials: Vec::new(),
    };
    let (mut truncation, mut noise) = (0.0_f64, 0.0_f64);
    for c in 0..coordinates {
        let entry = tables(c).entry(level, depth);
        truncation = truncation.max(entry.truncation);
        noise = noise.max(entry.noise);
        found.value.push(entry.value);
        found.error.push(entry.truncation + entry.noise);
    }
    let of_noise = CONSTANTS.noise_in_truncation * noise;
    found.converged = truncation <= of_noise.max(CONSTANTS.unresolved * found.largest());
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From the first levels, and the finer ones where they help.
    fn of(f: impl Fn(f64) -> f64, noise: f64) -> Derivative {
        let first = with_levels(&f, FIRST_LEVELS.end, noise);
        match finer_levels_help(&first, noise) {
            true => with_levels(&f, LEVELS, noise),
            false => first,
        }
    }

    fn with_levels(f: &impl Fn(f64) -> f64, levels: usize, noise: f64) -> Derivative {
        let mut differences = [0.0; STATES];
        for (difference, t) in differences.iter_mut().zip(displacements(0..levels)) {
            *difference = f(t) - f(0.0);
        }
        derivative(1, levels, |_| (differences, noise))
    }

    #[test]
    fn smooth_functions_have_their_derivative_within_the_error() {
        type Case = (fn(f64) -> f64, f64, f64);
        let cases: [Case; 6] = [
            (|t| (1.0 + t).sin(), 1f64.cos(), 1e-11),
            (|t| (2.0 * t).exp(), 2.0, 1e-11),
            (|t| 1.0 / (0.2 + t), -25.0, 1e-8),
            (|t| (30.0 * t + 0.3).cos(), -30.0 * 0.3f64.sin(), 1e-8),
            // Rounded over a hundredth: only the smaller distances resolve its slope.
            (
                |t| (t - 0.004).hypot(0.01),
                -0.004 / 0.004f64.hypot(0.01),
                1e-7,
            ),
            // Twice as steep nearby as the larger distances show, which agree with each other.
            (|t| t + t * (-(t / 3e-4).powi(2)).exp(), 2.0, 1e-6),
        ];
        for (k, (f, exact, tolerance)) in cases.into_iter().enumerate() {
            let found = of(f, 8.0 * f64::EPSILON);
            let difference = (found.value[0] - exact).abs();
            assert!(found.converged, "case {k}");
            assert!(
                difference <= found.error[0] && found.error[0] < tolerance,
                "case {k}: off by {difference:e}, error bar {:e}",
                found.error[0]
            );
        }
    }

    #[test]
    fn jumps_and_kinks_within_reach_are_no_derivatives() {
        for at in [0.0, 1e-9, 1e-7, -3e-7, 1e-6] {
            assert!(!of(|t| (t - at).abs(), 1e-16).converged, "kink at {at}");
            let jump = move |t: f64| t + if t < at { 0.0 } else { 1e-3 };
            assert!(!of(jump, 1e-16).converged, "jump at {at}");
        }
    }

    #[test]
    fn jumps_and_kinks_further_away_leave_the_derivative() {
        for at in [1e-4, -1e-3, 3e-3, 0.02, -0.1] {
            let slope = |t: f64| if t < at { 1.0 } else { 3.0 };
            let kink = of(|t| slope(t) * (t - at), 1e-16);
            let jump = of(|t| t + if t < at { 0.0 } else { 1.0 }, 1e-16);
            for (found, exact) in [(kink, slope(0.0)), (jump, 1.0)] {
                let difference = (found.value[0] - exact).abs();
                assert!(found.converged, "at {at}");
                assert!(difference <= found.error[0] && found.error[0] < 1e-9);
            }
        }
    }
}
