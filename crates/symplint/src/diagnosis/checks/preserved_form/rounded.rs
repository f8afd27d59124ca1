//! The entries of a form in the coordinates of the map, as a person would write them.

use super::limits::{EXTRA_DIGITS, MAX_UNITS, MIN_MEAN_SAVED_DIGITS, MIN_SAVED_DIGITS};
use super::{Entry, Term};
use crate::evidence::{FormEntry, monomial};
use crate::signal::UNEXPLAINED;

/// Digits of doubles.
const DIGITS_OF_DOUBLES: usize = 17;

/// The entries of a form in units of the loop, `size`, in the coordinates of the map.
pub(super) fn in_coordinates(entries: &[Entry], size: &[f64]) -> Vec<FormEntry> {
    let of_map = entries.iter().map(|entry| {
        let Term { pair, powers } = entry.term;
        let area = size[pair.0] * size[pair.1] * monomial(powers, |i| size[i]);
        FormEntry {
            coordinates: [pair.0, pair.1],
            powers,
            value: entry.value / area,
            error: entry.error / area,
            group: entry.group,
        }
    });
    of_map.collect()
}

/// The same in units of the loop, with errors that include those of rounding.
pub(super) fn in_units(entries: &[FormEntry], size: &[f64]) -> Vec<Entry> {
    let of_loop = entries.iter().map(|entry| {
        let ([a, b], powers) = (entry.coordinates, entry.powers);
        let area = size[a] * size[b] * monomial(powers, |i| size[i]);
        Entry {
            term: Term {
                pair: (a, b),
                powers,
            },
            value: entry.value * area,
            error: (1.0 + UNEXPLAINED) * entry.error * area,
            group: entry.group,
        }
    });
    of_loop.collect()
}

/// The entries rounded to the digits that their errors support, in units of one of each group: that in which they are shortest, if they are
/// short, then that of most entries. Entries that are much shorter than their errors allow are numbers that a person chose; others have the
/// digits of `resolution`, if loops show a relative change of the form as small as this.
pub(super) fn rounded(
    entries: &[FormEntry],
    dof: usize,
    resolution: Option<f64>,
) -> Vec<FormEntry> {
    let mut rounded = entries.to_vec();
    let groups = entries.iter().map(|entry| entry.group + 1).max();
    for group in 0..groups.unwrap_or(0) {
        let of_group: Vec<usize> = (0..entries.len())
            .filter(|&k| entries[k].group == group)
            .collect();
        let Some(numbers) = in_best_unit(entries, &of_group, dof) else {
            continue;
        };
        let are_short = are_short(&numbers);
        for (k, number) in of_group.into_iter().zip(numbers) {
            let saved = number.saved();
            let is_short = saved >= MIN_SAVED_DIGITS || are_short && saved >= MIN_MEAN_SAVED_DIGITS;
            let of_loops = resolution.map(|of| -of.max(f64::EPSILON).log10().floor());
            let digits = of_loops.unwrap_or(number.supported.max(0.0) + EXTRA_DIGITS);
            rounded[k].error = number.error;
            rounded[k].value = match is_short {
                true => number.shortest,
                false => with_digits(number.value, digits as usize),
            };
        }
    }
    rounded
}

/// A value in some unit.
struct Number {
    value: f64,
    error: f64,
    /// Digits that its error supports.
    supported: f64,
    /// The number with the fewest digits within its error.
    shortest: f64,
    /// How many it has.
    digits: usize,
}

impl Number {
    fn new(value: f64, relative_error: f64) -> Self {
        let error = value.abs() * relative_error;
        let within = |rounded: &f64| (rounded - value).abs() <= UNEXPLAINED * error;
        let shortest = (1..=DIGITS_OF_DOUBLES)
            .map(|digits| (with_digits(value, digits), digits))
            .find(|(rounded, _)| within(rounded));
        let (shortest, digits) = shortest.unwrap_or((value, DIGITS_OF_DOUBLES));
        Number {
            value,
            error,
            supported: -relative_error.max(f64::EPSILON).log10(),
            shortest,
            digits,
        }
    }

    /// The digits of those that its error supports that the shortest number does without.
    fn saved(&self) -> f64 {
        self.supported - self.digits as f64
    }

    fn is_one(&self) -> bool {
        (self.value - 1.0).abs() <= UNEXPLAINED * self.error
    }
}

/// Whether numbers, of which the unit does not count, are so short together that a person chose them.
fn are_short(numbers: &[Number]) -> bool {
    let others = || numbers.iter().filter(|of| of.error > 0.0);
    let saved: f64 = others().map(Number::saved).sum();
    saved >= (2.0 * MIN_SAVED_DIGITS).max(MIN_MEAN_SAVED_DIGITS * others().count() as f64)
}

/// The entries of a group in units of one of them.
fn in_best_unit(entries: &[FormEntry], of_group: &[usize], dof: usize) -> Option<Vec<Number>> {
    // Positions with momenta, if there are any: they are what weights are of.
    let is_mixed = |k: &&usize| {
        let [a, b] = entries[**k].coordinates;
        a < dof && b >= dof
    };
    let has_mixed = of_group.iter().any(|k| is_mixed(&k));
    let units = of_group.iter().filter(|k| !has_mixed || is_mixed(k));
    let in_unit = |&unit: &usize| -> Vec<Number> {
        let one = &entries[unit];
        let number = |&k: &usize| {
            let relative = match k == unit {
                true => 0.0,
                false => entries[k].relative_error() + one.relative_error(),
            };
            Number::new(entries[k].value / one.value, relative)
        };
        of_group.iter().map(number).collect()
    };
    units.take(MAX_UNITS).map(in_unit).min_by_key(|numbers| {
        // Digits of numbers that are not short mean nothing.
        let digits: usize = match numbers.iter().all(|of| of.saved() >= MIN_MEAN_SAVED_DIGITS) {
            true => numbers.iter().map(|of| of.digits).sum(),
            false => usize::MAX,
        };
        let others = numbers.iter().filter(|of| !of.is_one()).count();
        let negative = numbers.iter().filter(|of| of.value < 0.0).count();
        (digits, others, negative)
    })
}

fn with_digits(value: f64, digits: usize) -> f64 {
    let decimals = digits.clamp(1, DIGITS_OF_DOUBLES) - 1;
    format!("{value:.decimals$e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entries(values: &[f64], error: f64) -> Vec<FormEntry> {
        let entry = |(k, &value): (usize, &f64)| FormEntry {
            coordinates: [k, values.len() + k],
            powers: [0; 3],
            value,
            error: error * value.abs(),
            group: 0,
        };
        values.iter().enumerate().map(entry).collect()
    }

    fn values(of: &[f64], error: f64) -> Vec<f64> {
        let found = rounded(&entries(of, error), of.len(), None);
        found.iter().map(|of| of.value).collect()
    }

    #[test]
    fn numbers_that_a_person_chose_are_found() {
        assert_eq!(values(&[0.2, 0.600_000_02], 1e-7), [1.0, 3.0]);
        // In units of the last one.
        let found = values(&[0.31 / 0.7, 12e-5 / 0.7, 1.0 / 0.7], 1e-9);
        assert_eq!(found, [0.31, 12e-5, 1.0]);
        assert_eq!(values(&[-2.0, -2.0, 6.0], 1e-9), [1.0, 1.0, -3.0]);
        assert_eq!(values(&[-2.0, 6.0], 1e-9), [1.0, -3.0]);
    }

    #[test]
    fn other_numbers_keep_the_digits_that_their_errors_support() {
        let found = values(&[1.0, std::f64::consts::PI], 1e-6);
        assert!(
            (found[1] - std::f64::consts::PI).abs() < 1e-6,
            "{}",
            found[1]
        );
        assert!(found[1].to_string().len() < 10, "{}", found[1]);
    }
}
