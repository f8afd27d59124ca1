//! The grain of a map: the distance of neighbouring values that it returns.

use crate::loops::FEW_SAMPLES;
use crate::signal::{BITS_OF_SINGLE, Digits, Extent, Format, Levels, Turns};
use crate::state::{Coordinates, Ensemble, coordinate, period};

/// Fewer samples tell nothing.
const MIN_SAMPLES: usize = 24;

/// In more degrees of freedom a grain takes too much memory.
const MAX_DOF: usize = 1 << 16;

/// Values are few if each is the value of this number of samples, or more. On a circle two samples have each value; where it
/// runs twice round, four have, but at its ends.
const MIN_VALUE_SAMPLES: usize = 4;

/// Increments of a straight line differ by this number of roundings of its largest value.
const MAX_LINE_ROUNDINGS: f64 = 8.0;

/// A jump of no more than this many grains may be rounding: each of several operations of a step rounds.
const MAX_GRAINS: f64 = 16.0;

/// Integrals of a circle in stairs are off by a quarter of this many times a stair, times the root of a stair over the
/// circle's width, on the average.
const ERROR_OF_STAIRS: f64 = 4.0;

/// Rounding in other coordinates hides no jump larger than sixteen times this part of a coordinate's range.
const MAX_ROUNDING_OF_OTHERS: f64 = 3e-3;

/// By how much rounding moves each coordinate, if a map returns numbers of fewer digits than double precision:
/// single precision, decimals, or multiples of anything.
///
/// That is the distance of its neighbouring values, or more: what is rounded in one coordinate moves the others in the
/// next substep. So the largest relative to the range of its coordinate counts for both of a degree of freedom, and
/// what is typical of all positions, or all momenta, for every one.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Grain {
    /// Distance of neighbouring values of each coordinate, as the map returns them.
    output: Vec<f64>,
    /// The same, or what it rounds to inside.
    units: Vec<f64>,
    /// By how much rounding of all of them moves it.
    sizes: Vec<f64>,
    ranges: Vec<f64>,
    /// Whether rounding leaves it so few values that a jump is not told from a step between two of them.
    unresolved: Vec<bool>,
}

/// The loop before the step, as far as it is known: some equispaced samples of it.
pub(crate) enum SamplesBefore {
    Unknown,
    /// The states before the step.
    Exact(Ensemble),
    /// What somebody wrote of it, with as few digits as the states.
    Written(Ensemble),
}

/// The rounding that the samples of one coordinate show.
struct CoordinateGrain {
    unit: f64,
    range: f64,
    /// How many different values they take, if these are few.
    few: Option<usize>,
    /// The least difference of these.
    least: Option<f64>,
    /// The largest value.
    magnitude: f64,
}

impl Grain {
    /// From coordinates c of states k round a loop that the map returned; `None` of too few. A map that works with
    /// fewer digits inside rounds each coordinate to `inside` at least.
    ///
    /// `before` makes this number of samples of the loop before the step. If that loop has few digits itself, what comes of it
    /// may have few, and is not rounded; but numbers of single precision are: a code that works in it reads such
    /// ones. And few values are rounding only where the loop had more.
    pub fn of(
        samples: usize,
        coordinates: &Coordinates,
        inside: Option<&[f64]>,
        value: impl Fn(usize, usize) -> f64,
        before: impl FnOnce(usize) -> SamplesBefore,
    ) -> Option<Self> {
        let dof = coordinates.dof();
        if samples < MIN_SAMPLES || !Self::is_affordable(dof) {
            return None;
        }
        let every = samples.div_ceil(FEW_SAMPLES);
        let of_coordinate = |c: usize| {
            let values = (0..samples).step_by(every).map(|k| value(c, k));
            CoordinateGrain::of(values, period(coordinates, c))
        };
        let mut seen: Vec<CoordinateGrain> = (0..2 * dof).map(of_coordinate).collect();
        let looks_rounded = |seen: &CoordinateGrain| seen.unit > 0.0 || seen.few.is_some();
        if seen.iter().any(looks_rounded) {
            correct(&mut seen, &before(samples.div_ceil(every)));
        }
        let output: Vec<f64> = seen.iter().map(|seen| seen.unit).collect();
        let mut units = output.clone();
        for (unit, inside) in units.iter_mut().zip(inside.unwrap_or_default()) {
            *unit = unit.max(*inside);
        }
        let ranges: Vec<f64> = seen.iter().map(|seen| seen.range).collect();
        Some(Grain {
            sizes: spread(&units, &ranges),
            output,
            units,
            ranges,
            unresolved: seen.iter().map(|seen| seen.few.is_some()).collect(),
        })
    }

    /// Whether a grain of this number of degrees of freedom fits into little memory.
    pub fn is_affordable(dof: usize) -> bool {
        dof <= MAX_DOF
    }

    /// Degrees of freedom.
    pub fn dof(&self) -> usize {
        self.units.len() / 2
    }

    /// The coordinate whose values are furthest apart on the scale of its range, of those that the map rounds as it
    /// returns them, and how far.
    pub fn coarsest(&self) -> Option<(usize, f64)> {
        let rounded = (0..self.units.len()).filter(|&c| self.output[c] > 0.0);
        let part = |c: usize| self.output[c] / self.ranges[c];
        let coarsest = rounded.max_by(|&a, &b| part(a).total_cmp(&part(b)))?;
        Some((coarsest, self.output[coarsest]))
    }

    /// The grain of a coordinate, positions first; 0 if it has all digits of double precision.
    pub fn of_coordinate(&self, c: usize) -> f64 {
        self.sizes[c]
    }

    /// Whether rounding moves a coordinate at all.
    pub fn is_rounded(&self, c: usize) -> bool {
        self.sizes[c] > 0.0
    }

    /// How many grains the widest coordinate of the loop has; infinite where none is rounded.
    pub fn widths(&self) -> f64 {
        let rounded = self.sizes.iter().zip(&self.ranges);
        let of = rounded.filter(|(size, _)| **size > 0.0);
        let widest = of.map(|(size, range)| range / size).fold(0.0, f64::max);
        if widest > 0.0 { widest } else { f64::INFINITY }
    }

    /// About what independent rounding of this number of samples makes of a loop integral. Each state is off by 1/√12 of a
    /// grain; what p·dq is off in all of them adds up as the root of their number.
    pub fn of_samples(&self, samples: usize, coordinates: &Coordinates) -> f64 {
        let dof = coordinates.dof();
        let of_dof = |i: usize| {
            let [q, p] = [i, dof + i].map(|c| (self.sizes[c], self.ranges[c]));
            coordinates.weight(i).abs() * (q.0 * p.1).hypot(p.0 * q.1)
        };
        (0..dof).map(of_dof).sum::<f64>() / (samples.max(1) as f64).sqrt()
    }

    /// The largest effect on a loop integral of noise of this size of each coordinate: its mean need not be 0, as for a
    /// solver which stops at a tolerance.
    pub fn of_noise(&self, deviations: &[f64], coordinates: &Coordinates) -> f64 {
        let dof = self.dof();
        let of_dof = |i: usize| {
            let of = |c: usize, other: usize| deviations[c] * self.ranges[other];
            coordinates.weight(i).abs() * (of(i, dof + i) + of(dof + i, i))
        };
        (0..dof).map(of_dof).sum()
    }

    /// What rounding makes of a loop integral, about.
    pub fn of_integral(&self, coordinates: &Coordinates) -> f64 {
        let of_dof = |i: usize| coordinates.weight(i).abs() * self.of_dof(i);
        (0..coordinates.dof()).map(of_dof).sum()
    }

    /// The same in one degree of freedom, without its weight: of an integral round by round it is off by the width of a
    /// stair, but stairs on both sides of it undo each other, all but the root of their number.
    fn of_dof(&self, i: usize) -> f64 {
        let dof = self.dof();
        let of = |c: usize, other: usize| {
            let part = match self.ranges[c] > 0.0 {
                true => (self.sizes[c] / self.ranges[c]).min(1.0).sqrt(),
                false => 0.0,
            };
            self.sizes[c] * part * (self.ranges[other] + self.sizes[other])
        };
        ERROR_OF_STAIRS * (of(i, dof + i) + of(dof + i, i))
    }

    /// What rounding makes of the integral of a degree of freedom, without its weight, if it leaves a coordinate so
    /// few values that samples do not show their scatter; else 0.
    pub fn of_unresolved(&self, i: usize) -> f64 {
        match self.unresolved[i] || self.unresolved[self.dof() + i] {
            true => self.of_dof(i),
            false => 0.0,
        }
    }

    /// Whether a jump of a coordinate is larger than rounding makes.
    pub fn is_exceeded(&self, c: usize, jump: f64) -> bool {
        if self.unresolved[c] {
            return false;
        }
        let of_others = self.sizes[c].min(MAX_ROUNDING_OF_OTHERS * self.ranges[c]);
        jump.abs() > MAX_GRAINS * self.units[c].max(of_others)
    }
}

impl CoordinateGrain {
    fn of(values: impl Iterator<Item = f64>, period: f64) -> Self {
        let (mut digits, mut extent, mut turns) =
            (Digits::default(), Extent::default(), Turns::default());
        let values: Vec<f64> = values.collect();
        let mut unwrapped = Vec::with_capacity(values.len());
        for &value in &values {
            digits.add(value);
            unwrapped.push(turns.unwrap(value, period));
        }
        unwrapped.iter().for_each(|&x| extent.include(x));
        let levels = Levels::of(values.iter().copied());
        let of_digits = digits.few().map(|(_, unit)| unit);
        // Equispaced samples of a straight line are at equal distances, and not rounded.
        let mut increments = Extent::default();
        (unwrapped.windows(2)).for_each(|x| increments.include(x[1] - x[0]));
        let is_line = increments.length() <= MAX_LINE_ROUNDINGS * f64::EPSILON * extent.magnitude();
        let spacing = levels.spacing().filter(|_| !is_line);
        let unit = of_digits.into_iter().chain(spacing);
        CoordinateGrain {
            unit: unit.fold(0.0, f64::max),
            range: extent.length(),
            few: Some(levels.count()).filter(|count| MIN_VALUE_SAMPLES * count <= values.len()),
            least: levels.least_difference(),
            magnitude: extent.magnitude(),
        }
    }

    /// Takes few values, if the loop had `before` them, for rounded ones.
    fn compare(&mut self, before: &[f64], written: bool) {
        let every = before.len().div_ceil(FEW_SAMPLES).max(1);
        let had = Levels::of(before.iter().step_by(every).copied()).count();
        let has_fewer = |count: usize| 2 * count < had || (written && had.max(count) > 1);
        let range = Extent::of(before).length();
        // Numbers rounded to one value other than 0 are rounded to that value at most, in any unit: a loop that is wider
        // takes several. One that does not is collapsed by the map.
        let collapsed = |count: usize| count == 1 && self.magnitude > 0.0 && self.magnitude < range;
        self.few = self
            .few
            .filter(|&count| has_fewer(count) && !collapsed(count));
        if self.few.is_some() {
            self.unit = self.unit.max(self.least.unwrap_or(0.0));
            // It is a few grains wide, or less.
            self.range = self.range.max(range);
        }
    }
}

/// Corrects what all coordinates show with what is known of the loop before the step.
fn correct(seen: &mut [CoordinateGrain], before: &SamplesBefore) {
    let (states, written) = match before {
        SamplesBefore::Unknown => (None, true),
        SamplesBefore::Exact(states) => (Some(states), false),
        SamplesBefore::Written(states) => (Some(states), true),
    };
    for (c, seen) in seen.iter_mut().enumerate() {
        match states {
            Some(states) => seen.compare(coordinate(states, c), written),
            None => seen.compare(&[], written),
        }
    }
    if let Some(states) = states.filter(|_| !written)
        && (0..seen.len()).any(|c| has_few_digits(coordinate(states, c)))
    {
        seen.iter_mut()
            .for_each(|seen| (seen.unit, seen.few) = (0.0, None));
    }
    // A single value does not show whether it is rounded, unless the other coordinate of its kind is.
    let dof = seen.len() / 2;
    let is_rounded = |seen: &CoordinateGrain| seen.unit > 0.0 || seen.few.is_some();
    let rounded: Vec<bool> = seen.iter().map(is_rounded).collect();
    for (c, seen) in seen.iter_mut().enumerate() {
        if seen.few == Some(1) {
            match rounded[(c + dof) % (2 * dof)] {
                true => seen.unit = seen.range,
                false => seen.few = None,
            }
        }
    }
}

/// Whether some numbers of the loop before the step have few digits, and more than a code in single precision reads.
fn has_few_digits(row: &[f64]) -> bool {
    let mut digits = Digits::default();
    row.iter().for_each(|&x| digits.add(x));
    match digits.few() {
        Some((format, _)) => format != Format::Binary(BITS_OF_SINGLE),
        None => Levels::of(row.iter().copied()).spacing().is_some(),
    }
}

/// What each coordinate is moved by where they have these `units` and `ranges`.
fn spread(units: &[f64], ranges: &[f64]) -> Vec<f64> {
    let dof = units.len() / 2;
    let relative = |c: usize| match ranges[c] > 0.0 {
        true => units[c] / ranges[c],
        false => 0.0,
    };
    // Products of q and p have one unit in all degrees of freedom.
    let areas: f64 = (0..dof).map(|i| ranges[i] * ranges[dof + i]).sum();
    let typical = [0, dof].map(|first| {
        let part = |i: usize| units[first + i] * ranges[dof - first + i];
        (0..dof).map(part).sum::<f64>() / areas
    });
    let typical = typical[0].max(typical[1]);
    let of = |c: usize| {
        let own = relative(c % dof).max(relative(dof + c % dof));
        units[c].max(ranges[c] * own.max(typical))
    };
    match areas > 0.0 {
        true => (0..2 * dof).map(of).collect(),
        false => units.to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_rounded_in_one_coordinate_moves_the_others() {
        // q has three decimals, p all digits; in other units of q and p, too.
        for unit in [1.0, 1e6] {
            let value = |c: usize, k: usize| match c {
                0 => unit * (1.5e3 * (k as f64).sin()).round() / 1e3,
                _ => 0.25 * (k as f64).cos() / unit,
            };
            let grain = Grain::of(64, &Coordinates::plain(1), None, value, |_| {
                SamplesBefore::Unknown
            })
            .unwrap();
            assert!((grain.of_coordinate(0) / unit - 1e-3).abs() < 1e-12);
            assert!((grain.of_coordinate(1) * unit - 0.5e-3 / 3.0).abs() < 1e-6);
            assert!(grain.is_exceeded(0, -0.017 * unit) && !grain.is_exceeded(0, 0.015 * unit));
        }
        let exact = Grain::of(
            64,
            &Coordinates::plain(1),
            None,
            |c, k| (c as f64 + 0.3 * k as f64).sin(),
            |_| SamplesBefore::Unknown,
        )
        .unwrap();
        assert_eq!(exact.sizes, [0.0; 2]);
        assert_eq!(exact.of_integral(&Coordinates::plain(1)), 0.0);
        assert_eq!(
            Grain::of(
                23,
                &Coordinates::plain(1),
                None,
                |_, _| 0.0,
                |_| SamplesBefore::Unknown
            ),
            None
        );
    }

    #[test]
    fn integrals_of_rounded_circles_are_as_exact_as_said() {
        for stairs in [1.0, 3.0, 10.0, 100.0, 1e3, 1e4] {
            let (mut off, mut said) = (0.0f64, 0.0);
            for trial in 0..20 {
                let at = |c: usize, k: usize, n: usize| {
                    let angle = (k as f64 / n as f64) * std::f64::consts::TAU;
                    let x = [angle.sin(), angle.cos()][c] + 0.37 * f64::from(trial) + 3.0;
                    (x * stairs).round() / stairs
                };
                let grain = Grain {
                    output: vec![1.0 / stairs; 2],
                    units: vec![1.0 / stairs; 2],
                    sizes: vec![1.0 / stairs; 2],
                    ranges: vec![2.0; 2],
                    unresolved: vec![false; 2],
                };
                said = grain.of_integral(&Coordinates::plain(1));
                let n = 100_000;
                let area: f64 = (0..n)
                    .map(|k| {
                        let mean = 0.5 * (at(1, k, n) + at(1, k + 1, n));
                        mean * (at(0, k + 1, n) - at(0, k, n))
                    })
                    .sum();
                off = off.max((area - std::f64::consts::PI).abs());
            }
            assert!(
                off < said && said < 40.0 * off,
                "{stairs}: {off:e} {said:e}"
            );
        }
    }

    #[test]
    fn a_coordinate_that_hardly_moves_hides_no_jumps_of_others() {
        let value = |c: usize, k: usize| {
            let x = ((2 * c + 1) as f64 + 0.37 * k as f64).sin();
            let x = if c == 1 || c == 3 { 50.0 + 1e-5 * x } else { x };
            f64::from(x as f32)
        };
        let grain = Grain::of(64, &Coordinates::plain(2), None, value, |_| {
            SamplesBefore::Unknown
        })
        .unwrap();
        assert!(grain.is_exceeded(0, 1e-5), "{grain:?}");
        // It does not hide jumps of the same degree of freedom either, except small ones.
        let value = |c: usize, k: usize| match c {
            0 => 1e-2 * (0.37 * k as f64).sin(),
            _ => f64::from((50.0 + 1e-5 * (0.37 * k as f64).cos()) as f32),
        };
        let grain = Grain::of(64, &Coordinates::plain(1), None, value, |_| {
            SamplesBefore::Unknown
        })
        .unwrap();
        assert!(grain.is_exceeded(0, 1e-3), "{grain:?}");
    }

    #[test]
    fn a_loop_across_the_end_of_a_period_is_no_wider() {
        let periodic = Coordinates::plain(1).with_periods(vec![1.0]).unwrap();
        let value = |c: usize, k: usize| match c {
            0 => (1e-3 * (k as f64).sin()).rem_euclid(1.0),
            _ => f64::from((k as f64).cos() as f32),
        };
        let grain = Grain::of(64, &periodic, None, value, |_| SamplesBefore::Unknown).unwrap();
        assert!(grain.of_coordinate(0) < 1e-9, "{grain:?}");
    }
}
