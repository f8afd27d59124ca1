//! The entries of a form in the coordinates of the map, as a person would write them.

use super::Entry;
use super::limits::{COINCIDENCE, COINCIDENCE_OF_MEAN, FURTHER_DIGITS, MOST_UNITS, ROUNDED_WITHIN};
use crate::evidence::FormEntry;

/// Digits of doubles.
const ALL_DIGITS: usize = 17;

/// The entries of a form in units of the loop, `size`, in the coordinates of the map.
pub(super) fn in_coordinates(entries: &[Entry], size: &[f64]) -> Vec<FormEntry> {
    let of_map = entries.iter().map(|entry| {
        let area = size[entry.pair.0] * size[entry.pair.1];
        FormEntry {
            coordinates: [entry.pair.0, entry.pair.1],
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
        let [a, b] = entry.coordinates;
        Entry {
            pair: (a, b),
            value: entry.value * size[a] * size[b],
            error: (1.0 + ROUNDED_WITHIN) * entry.error * size[a] * size[b],
            group: entry.group,
        }
    });
    of_loop.collect()
}

/// The entries rounded to the digits that their errors support, in units of one of each group: that in which they are shortest, then that of
/// most entries. The second value says whether all are much shorter than their errors allow, as numbers are that a person chose; others have the
/// digits of `resolution`, if loops show a relative change of the form as small as this.
pub(super) fn rounded(
    entries: &[FormEntry],
    dof: usize,
    resolution: Option<f64>,
) -> (Vec<FormEntry>, bool) {
    let mut rounded = entries.to_vec();
    let groups = entries.iter().map(|entry| entry.group + 1).max();
    let mut all_short = true;
    for group in 0..groups.unwrap_or(0) {
        let of_group: Vec<usize> = (0..entries.len())
            .filter(|&k| entries[k].group == group)
            .collect();
        // Positions with momenta, if there are any: they are what weights are of.
        let is_mixed = |k: &usize| {
            let [a, b] = entries[*k].coordinates;
            a < dof && b >= dof
        };
        let mut units: Vec<usize> = of_group.iter().copied().filter(is_mixed).collect();
        if units.is_empty() {
            units.clone_from(&of_group);
        }
        let in_unit = |unit: usize, k: usize| {
            let (of, one) = (&entries[k], &entries[unit]);
            let value = of.value / one.value;
            let relative = match k == unit {
                true => 0.0,
                false => of.relative_error() + one.relative_error(),
            };
            (value, value.abs() * relative)
        };
        let rank = |unit: usize| {
            let values = || of_group.iter().map(|&k| in_unit(unit, k));
            let digits: usize = values()
                .map(|(value, error)| shortest(value, error).1)
                .sum();
            let ones =
                values().filter(|(value, error)| (value - 1.0).abs() <= ROUNDED_WITHIN * error);
            let positive = values().filter(|of| of.0 > 0.0);
            (
                digits,
                usize::MAX - ones.count(),
                usize::MAX - positive.count(),
            )
        };
        let Some(unit) = (units.into_iter().take(MOST_UNITS)).min_by_key(|&unit| rank(unit)) else {
            continue;
        };
        // Digits that the errors support, and those of them that the shortest number does without.
        let digits = |k: usize| {
            let (value, error) = in_unit(unit, k);
            let supported = -(error / value.abs()).max(f64::EPSILON).log10();
            (supported, supported - shortest(value, error).1 as f64)
        };
        let others = of_group.iter().filter(|&&k| k != unit);
        let of_all: f64 = others.map(|&k| digits(k).1).sum();
        let mean = of_all / (of_group.len() - 1).max(1) as f64;
        let are_short = of_all >= 2.0 * COINCIDENCE && mean >= COINCIDENCE_OF_MEAN;
        for k in of_group {
            let (value, error) = in_unit(unit, k);
            let (short, _) = shortest(value, error);
            let (supported, saved) = digits(k);
            let is_short = saved >= COINCIDENCE || are_short && saved >= COINCIDENCE_OF_MEAN;
            let digits_of_loops = resolution.map(|of| -of.max(f64::EPSILON).log10().floor());
            let last = digits_of_loops.unwrap_or(supported.max(0.0) + FURTHER_DIGITS) as usize;
            all_short &= is_short;
            rounded[k].value = match is_short {
                true => short,
                false => with_digits(value, last),
            };
            rounded[k].error = error;
        }
    }
    (rounded, all_short)
}

fn with_digits(value: f64, digits: usize) -> f64 {
    let decimals = digits.clamp(1, ALL_DIGITS) - 1;
    format!("{value:.decimals$e}").parse().unwrap_or(value)
}

/// The number with the fewest digits within its error, and how many it has.
fn shortest(value: f64, error: f64) -> (f64, usize) {
    let within = |rounded: f64| (rounded - value).abs() <= ROUNDED_WITHIN * error;
    (1..=ALL_DIGITS)
        .map(|digits| (with_digits(value, digits), digits))
        .find(|&(rounded, _)| within(rounded))
        .unwrap_or((value, ALL_DIGITS))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entries(values: &[f64], error: f64) -> Vec<FormEntry> {
        let entry = |(k, &value): (usize, &f64)| FormEntry {
            coordinates: [k, values.len() + k],
            value,
            error: error * value.abs(),
            group: 0,
        };
        values.iter().enumerate().map(entry).collect()
    }

    fn values(of: &[f64], error: f64) -> (Vec<f64>, bool) {
        let (found, short) = rounded(&entries(of, error), of.len(), None);
        (found.iter().map(|of| of.value).collect(), short)
    }

    #[test]
    fn numbers_that_a_person_chose_are_found() {
        assert_eq!(values(&[0.2, 0.600_000_02], 1e-7), (vec![1.0, 3.0], true));
        // In units of the last one.
        let (found, short) = values(&[0.31 / 0.7, 12e-5 / 0.7, 1.0 / 0.7], 1e-9);
        assert_eq!((found, short), (vec![0.31, 12e-5, 1.0], true));
        assert_eq!(values(&[-2.0, -2.0, 6.0], 1e-9).0, [1.0, 1.0, -3.0]);
        assert_eq!(values(&[-2.0, 6.0], 1e-9).0, [1.0, -3.0]);
    }

    #[test]
    fn other_numbers_keep_the_digits_that_their_errors_support() {
        let (found, short) = values(&[1.0, std::f64::consts::PI], 1e-6);
        assert!(!short);
        assert!(
            (found[1] - std::f64::consts::PI).abs() < 1e-6,
            "{}",
            found[1]
        );
        assert!(found[1].to_string().len() < 10, "{}", found[1]);
    }
}
