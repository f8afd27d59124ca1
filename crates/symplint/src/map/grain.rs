//! The grain of a map: the distance of neighbouring values that it returns.

use crate::loops::Loop;
use crate::signal::{Digits, Extent, Format, SINGLE, Turns};
use crate::state::{Coordinates, Ensemble, coordinate, period};

/// Samples that are looked at: more than the different values that tell a format.
const SAMPLES: usize = 64;

/// Fewer samples tell nothing.
const FEWEST: usize = 24;

/// In more degrees of freedom a grain takes too much memory.
const MOST_DOF: usize = 1 << 16;

/// A jump of no more than this many grains may be rounding: each of several operations of a step rounds.
const GRAINS_OF_A_JUMP: f64 = 16.0;

/// Integrals of a circle in stairs are off by a quarter of this many times a stair, times the root of a stair over the
/// circle's width, on the average.
const STAIRS: f64 = 4.0;

/// What is rounded in other coordinates hides no jump larger than sixteen times this part of a coordinate's range.
const MOST_OF_OTHERS: f64 = 3e-3;

/// By how much rounding moves each coordinate, where a map returns numbers of fewer digits than double precision:
/// single precision, or decimals.
///
/// That is the distance of its neighbouring values, or more: what is rounded in one coordinate moves the others in the
/// next substep. So the largest relative to the range of its coordinate counts for both of a degree of freedom, and
/// what is typical of all positions, or all momenta, for every one.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Grain {
    /// Distance of neighbouring values of each coordinate.
    units: Vec<f64>,
    /// By how much rounding of all of them moves it.
    sizes: Vec<f64>,
    ranges: Vec<f64>,
}

impl Grain {
    /// From coordinates c of states k round a loop that the map returned; `None` of too few. A map that works in
    /// single precision inside rounds to that at least.
    pub fn of(
        samples: usize,
        coordinates: &Coordinates,
        single_inside: bool,
        value: impl Fn(usize, usize) -> f64,
    ) -> Option<Self> {
        let dof = coordinates.dof();
        if samples < FEWEST || !Self::is_affordable(dof) {
            return None;
        }
        let every = samples.div_ceil(SAMPLES);
        let of_coordinate = |c: usize| {
            let (mut digits, mut extent) = (Digits::default(), Extent::default());
            let (mut turns, mut largest) = (Turns::default(), 0.0f64);
            for k in (0..samples).step_by(every) {
                digits.add(value(c, k));
                extent.include(turns.unwrap(value(c, k), period(coordinates, c)));
                largest = largest.max(value(c, k).abs());
            }
            let unit = digits.few().map_or(0.0, |(_, unit)| unit);
            let inside = match single_inside {
                true => f64::from(f32::EPSILON) * largest,
                false => 0.0,
            };
            (unit.max(inside), extent.length())
        };
        let (units, ranges): (Vec<f64>, Vec<f64>) = (0..2 * dof).map(of_coordinate).unzip();
        let sizes = spread(&units, &ranges);
        Some(Grain {
            units,
            sizes,
            ranges,
        })
    }

    /// Without those of coordinates that have few digits before the step: what comes of few digits may have few itself,
    /// and is not rounded. Numbers of single precision are: a code that works in it reads such ones.
    pub fn beside(mut self, phase_loop: &dyn Loop) -> Self {
        if self.units.iter().all(|unit| *unit == 0.0) {
            return self;
        }
        let dof = phase_loop.dof();
        let s: Vec<f64> = (0..SAMPLES).map(|k| k as f64 / SAMPLES as f64).collect();
        let mut states = Ensemble::zeros(dof, SAMPLES);
        phase_loop.sample(&s, &mut states.block());
        for (c, unit) in self.units.iter_mut().enumerate() {
            let mut digits = Digits::default();
            coordinate(&states, c).iter().for_each(|&x| digits.add(x));
            let single = Format::Binary(SINGLE);
            if *unit > 0.0 && digits.few().is_some_and(|(format, _)| format != single) {
                *unit = 0.0;
            }
        }
        self.sizes = spread(&self.units, &self.ranges);
        self
    }

    /// Whether a grain of so many degrees of freedom fits into little memory.
    pub fn is_affordable(dof: usize) -> bool {
        dof <= MOST_DOF
    }

    /// The largest unit, as a part of the range of its coordinate.
    pub fn largest_part(&self) -> f64 {
        let moving = (self.units.iter().zip(&self.ranges)).filter(|(_, range)| **range > 0.0);
        moving.map(|(unit, range)| unit / range).fold(0.0, f64::max)
    }

    /// Of a coordinate, positions first; 0 where it has all digits of double precision.
    pub fn of_coordinate(&self, c: usize) -> f64 {
        self.sizes[c]
    }

    /// What rounding makes of a loop integral, about: of one round by round it is off by the width of a stair, but
    /// stairs on both sides of it undo each other, all but the root of their number.
    pub fn of_integral(&self, coordinates: &Coordinates) -> f64 {
        let dof = coordinates.dof();
        let of_dof = |i: usize| {
            let of = |c: usize, other: usize| {
                let part = match self.ranges[c] > 0.0 {
                    true => (self.sizes[c] / self.ranges[c]).min(1.0).sqrt(),
                    false => 0.0,
                };
                self.sizes[c] * part * (self.ranges[other] + self.sizes[other])
            };
            coordinates.weight(i).abs() * (of(i, dof + i) + of(dof + i, i))
        };
        STAIRS * (0..dof).map(of_dof).sum::<f64>()
    }

    /// Whether a jump of a coordinate is larger than rounding makes.
    pub fn is_exceeded(&self, c: usize, jump: f64) -> bool {
        let of_others = self.sizes[c].min(MOST_OF_OTHERS * self.ranges[c]);
        jump.abs() > GRAINS_OF_A_JUMP * self.units[c].max(of_others)
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
            let grain = Grain::of(64, &Coordinates::plain(1), false, value).unwrap();
            assert!((grain.of_coordinate(0) / unit - 1e-3).abs() < 1e-12);
            assert!((grain.of_coordinate(1) * unit - 0.5e-3 / 3.0).abs() < 1e-6);
            assert!(grain.is_exceeded(0, -0.017 * unit) && !grain.is_exceeded(0, 0.015 * unit));
        }
        let exact = Grain::of(64, &Coordinates::plain(1), false, |c, k| {
            (c as f64 + 0.3 * k as f64).sin()
        })
        .unwrap();
        assert_eq!(exact.sizes, [0.0; 2]);
        assert_eq!(exact.of_integral(&Coordinates::plain(1)), 0.0);
        assert_eq!(
            Grain::of(23, &Coordinates::plain(1), false, |_, _| 0.0),
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
                    units: vec![1.0 / stairs; 2],
                    sizes: vec![1.0 / stairs; 2],
                    ranges: vec![2.0; 2],
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
        let grain = Grain::of(64, &Coordinates::plain(2), false, value).unwrap();
        assert!(grain.is_exceeded(0, 1e-5), "{grain:?}");
        // Not even of its own degree of freedom, but small ones.
        let value = |c: usize, k: usize| match c {
            0 => 1e-2 * (0.37 * k as f64).sin(),
            _ => f64::from((50.0 + 1e-5 * (0.37 * k as f64).cos()) as f32),
        };
        let grain = Grain::of(64, &Coordinates::plain(1), false, value).unwrap();
        assert!(grain.is_exceeded(0, 1e-3), "{grain:?}");
    }

    #[test]
    fn a_loop_across_the_end_of_a_period_is_no_wider() {
        let periodic = Coordinates::plain(1).with_periods(vec![1.0]).unwrap();
        let value = |c: usize, k: usize| match c {
            0 => (1e-3 * (k as f64).sin()).rem_euclid(1.0),
            _ => f64::from((k as f64).cos() as f32),
        };
        let grain = Grain::of(64, &periodic, false, value).unwrap();
        assert!(grain.of_coordinate(0) < 1e-9, "{grain:?}");
    }
}
