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

use crate::signal::nearest;

/// Distances t = 2^-3, 2^-5, …, 2^-19: from what a smooth map needs down to what is left between
/// the many breaks of a map of many degrees of freedom.
pub(super) const LEVELS: usize = 9;

/// States at ±t for every distance.
pub(super) const STATES: usize = 2 * LEVELS;

/// Powers of t² that are removed at most.
const DEEPEST: usize = 4;

/// Distances shrink by this factor from level to level.
const RATIO: f64 = 4.0;

/// What a derivative may miss of convergence, relative to its largest component, and still be one.
pub(super) const UNRESOLVED: f64 = 1e-6;

/// The distance at a level, in units of the direction.
pub(super) fn distance(level: usize) -> f64 {
    0.125 * RATIO.powi(-(level as i32))
}

/// The derivative of all coordinates along a direction, in units of the frame.
pub(super) struct Derivative {
    pub value: Vec<f64>,
    /// Truncation and noise of differences, round-off of a tangent map.
    pub error: Vec<f64>,
    /// Whether the table converged: if not, the map is not differentiable on the scale of the distances. Of a
    /// tangent map, whether the last digit of the state decides nothing.
    pub converged: bool,
    /// The same derivative from other trials of a tangent map; differences have none.
    pub trials: Vec<Vec<f64>>,
}

/// What is known of one coordinate round a point.
pub(super) struct Neighbourhood {
    /// Values at +t, −t for each level in turn.
    pub values: [f64; STATES],
    pub centre: f64,
    /// Period of the coordinate, 0 where there is none.
    pub period: f64,
    /// Unit in which values are counted.
    pub size: f64,
    /// Noise of a value, in that unit.
    pub noise: f64,
}

type Table = [[f64; DEEPEST + 1]; LEVELS];

/// Removes the powers t^first, t^(first + 2), … from a sequence over the levels.
fn extrapolate(sequence: [f64; LEVELS], first: i32) -> Table {
    let mut table = [[0.0; DEEPEST + 1]; LEVELS];
    for level in 0..LEVELS {
        table[level][0] = sequence[level];
        for depth in 1..=level.min(DEEPEST) {
            let (fine, coarse) = (table[level][depth - 1], table[level - 1][depth - 1]);
            let factor = RATIO.powi(first + 2 * (depth as i32 - 1));
            table[level][depth] = fine + (fine - coarse) / (factor - 1.0);
        }
    }
    table
}

/// One coordinate's tables: of the odd part of the differences, the derivative, and of the even part,
/// zero for a differentiable map.
struct Tables {
    odd: Table,
    even: Table,
    noise: f64,
}

/// An entry of a table with the two parts of its error.
struct Entry {
    value: f64,
    truncation: f64,
    noise: f64,
}

impl Tables {
    fn new(of: &Neighbourhood) -> Self {
        let of_level = |level: usize| {
            let ahead = nearest(of.values[2 * level] - of.centre, of.period);
            let behind = nearest(of.centre - of.values[2 * level + 1], of.period);
            let scale = 2.0 * distance(level) * of.size;
            [(ahead + behind) / scale, (ahead - behind) / scale]
        };
        let parts: [[f64; 2]; LEVELS] = std::array::from_fn(of_level);
        Tables {
            odd: extrapolate(parts.map(|[odd, _]| odd), 2),
            even: extrapolate(parts.map(|[_, even]| even), 1),
            noise: of.noise,
        }
    }

    fn plain_entry(&self, level: usize, depth: usize) -> Entry {
        let value = self.odd[level][depth];
        let step = (value - self.odd[level][depth - 1]).abs();
        let other = (value - self.odd[level - 1][depth - 1]).abs();
        Entry {
            value,
            truncation: step.max(other) + self.even[level][depth].abs(),
            // The coefficients of the extrapolation enlarge the noise by less than 2.
            noise: 2.0 * self.noise / distance(level),
        }
    }

    fn entry(&self, level: usize, depth: usize) -> Entry {
        let mut entry = self.plain_entry(level, depth);
        let finest = self.plain_entry(LEVELS - 1, 1);
        let apart = (entry.value - finest.value).abs() - finest.truncation - finest.noise;
        entry.truncation += apart.max(0.0);
        entry
    }
}

/// The derivative from what is known of every coordinate.
///
/// One entry of the table serves all coordinates: if each chose its own, chance would pick
/// neighbours that agree by accident.
pub(super) fn derivative(
    coordinates: usize,
    neighbourhood: impl Fn(usize) -> Neighbourhood,
) -> Derivative {
    let mut worst = [[0.0_f64; DEEPEST + 1]; LEVELS];
    for c in 0..coordinates {
        let tables = Tables::new(&neighbourhood(c));
        for (level, depth) in entries() {
            let entry = tables.entry(level, depth);
            let error = entry.truncation + entry.noise;
            worst[level][depth] = worst[level][depth].max(error);
        }
    }
    let chosen = entries().min_by(|a, b| worst[a.0][a.1].total_cmp(&worst[b.0][b.1]));
    let (level, depth) = chosen.unwrap_or((LEVELS - 1, 1));
    let mut value = Vec::with_capacity(coordinates);
    let mut error = Vec::with_capacity(coordinates);
    let (mut truncation, mut noise, mut largest) = (0.0_f64, 0.0_f64, 1.0_f64);
    for c in 0..coordinates {
        let entry = Tables::new(&neighbourhood(c)).entry(level, depth);
        truncation = truncation.max(entry.truncation);
        noise = noise.max(entry.noise);
        largest = largest.max(entry.value.abs());
        value.push(entry.value);
        error.push(entry.truncation + entry.noise);
    }
    // Truncation up to the noise of the next distance, four times as large, is a matter of choice; and there
    // noise shows in what looks like truncation, too, by the even part a few times.
    let converged = truncation <= (UNRESOLVED * largest).max(4.0 * RATIO * noise);
    Derivative {
        value,
        error,
        converged,
        trials: Vec::new(),
    }
}

fn entries() -> impl Iterator<Item = (usize, usize)> {
    (1..LEVELS).flat_map(|level| (1..=level.min(DEEPEST)).map(move |depth| (level, depth)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(f: impl Fn(f64) -> f64, noise: f64) -> Derivative {
        let mut values = [0.0; STATES];
        for level in 0..LEVELS {
            values[2 * level] = f(distance(level));
            values[2 * level + 1] = f(-distance(level));
        }
        derivative(1, |_| Neighbourhood {
            values,
            centre: f(0.0),
            period: 0.0,
            size: 1.0,
            noise,
        })
    }

    #[test]
    fn smooth_functions_have_their_derivative_within_the_error() {
        type Case = (fn(f64) -> f64, f64, f64);
        let cases: [Case; 5] = [
            (|t| (1.0 + t).sin(), 1f64.cos(), 1e-11),
            (|t| (2.0 * t).exp(), 2.0, 1e-11),
            (|t| 1.0 / (0.2 + t), -25.0, 1e-8),
            (|t| (30.0 * t + 0.3).cos(), -30.0 * 0.3f64.sin(), 1e-8),
            // Rounded off over a hundredth: only the smaller distances know its slope.
            (
                |t| (t - 0.004).hypot(0.01),
                -0.004 / 0.004f64.hypot(0.01),
                1e-7,
            ),
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
