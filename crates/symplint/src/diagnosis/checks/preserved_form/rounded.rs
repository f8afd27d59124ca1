//! The entries of a form in the coordinates of the map, as a person would write them.

use super::Entry;
use super::limits::ROUNDED_WITHIN;
use crate::evidence::FormEntry;

/// The entries of a form in units of the loop, `size`, in the coordinates of the map: scaled so that a common one is 1 in each group, and
/// rounded to the digits that their errors support. The rounded entries in units of the loop, with their errors, come second.
pub(super) fn in_coordinates(entries: &[Entry], size: &[f64]) -> (Vec<FormEntry>, Vec<Entry>) {
    let area = |entry: &Entry| size[entry.pair.0] * size[entry.pair.1];
    let groups = entries.iter().map(|entry| entry.group + 1).max();
    let (mut of_map, mut of_loop) = (Vec::new(), Vec::new());
    for group in 0..groups.unwrap_or(0) {
        let of_group = || entries.iter().filter(move |entry| entry.group == group);
        // Positions with momenta, if there are any: they are what weights are of.
        let dof = size.len() / 2;
        let is_mixed = |entry: &&Entry| entry.pair.0 < dof && entry.pair.1 >= dof;
        let mut of_unit: Vec<(f64, f64)> = (of_group().filter(is_mixed))
            .map(|entry| (entry.value / area(entry), entry.error / area(entry)))
            .collect();
        if of_unit.is_empty() {
            of_unit = of_group()
                .map(|entry| (entry.value / area(entry), entry.error / area(entry)))
                .collect();
        }
        let unit = common(&of_unit);
        for entry in of_group() {
            let scale = unit * area(entry);
            let (value, error) = (entry.value / scale, (entry.error / scale).abs());
            let value = shortest(value, ROUNDED_WITHIN * error);
            of_map.push(FormEntry {
                coordinates: [entry.pair.0, entry.pair.1],
                value,
                error,
                group,
            });
            of_loop.push(Entry {
                value: value * area(entry),
                error: ROUNDED_WITHIN * error * area(entry),
                ..*entry
            });
        }
    }
    (of_map, of_loop)
}

/// The value that most have, to within their errors, with the sign that most have; the first of equals.
fn common(values: &[(f64, f64)]) -> f64 {
    let alike = |&(a, of_a): &(f64, f64)| {
        let same = |(b, of_b): &&(f64, f64)| (a.abs() - b.abs()).abs() <= ROUNDED_WITHIN * (of_a + of_b);
        values.iter().filter(same).count()
    };
    let most = values.iter().map(alike).max().unwrap_or(0);
    let unit = values.iter().find(|of| alike(of) == most);
    let unit = unit.map_or(1.0, |of| of.0.abs());
    let negative = values.iter().filter(|of| of.0 < 0.0).count();
    let is_negative = match (2 * negative).cmp(&values.len()) {
        std::cmp::Ordering::Equal => values[0].0 < 0.0,
        order => order.is_gt(),
    };
    if is_negative { -unit } else { unit }
}

/// The number with the fewest digits within an error of a value.
fn shortest(value: f64, error: f64) -> f64 {
    let rounded = |digits: usize| format!("{value:.digits$e}").parse::<f64>().unwrap_or(value);
    let within = |rounded: &f64| (rounded - value).abs() <= error;
    (0..17).map(rounded).find(within).unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded_to_what_their_errors_support() {
        assert_eq!(shortest(3.000_000_1, 1e-6), 3.0);
        assert_eq!(shortest(3.000_000_1, 1e-8), 3.0000001);
        assert_eq!(shortest(-0.736_841_234, 1e-4), -0.7368);
        assert_eq!(shortest(1.000_000_000_1e-12, 1e-20), 1e-12);
    }

    #[test]
    fn a_common_value_is_one_and_most_signs_are_positive() {
        assert_eq!(common(&[(2.0, 1e-9), (6.0, 1e-9), (2.0, 1e-9)]), 2.0);
        assert_eq!(common(&[(-2.0, 1e-9), (6.0, 1e-9)]), -2.0);
        assert_eq!(common(&[(-2.0, 0.0), (-2.0, 0.0), (6.0, 0.0)]), -2.0);
    }
}
