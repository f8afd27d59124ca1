//! The spacing of numbers that are multiples of something, in any unit.
//!
//! Output that is rounded in one unit and returned in another (%.3f degrees in radians) lies on a lattice whose
//! spacing has no short decimal or binary representation. It divides all differences of the numbers: Euclid's algorithm finds it.

/// Numbers are on a lattice but for the rounding of a product or quotient: this number of roundings of the largest.
const MAX_ROUNDINGS: f64 = 4.0;

/// A remainder below this part of a spacing counts as 0. Of numbers on no lattice one in 32 has such a remainder: that
/// all of [`MIN_DIFFERENCES`] differences and more do has a chance of 1e-7.
const MAX_REMAINDER: f64 = 1.0 / 64.0;

/// Differences that are needed to tell.
const MIN_DIFFERENCES: usize = 6;

/// The different ones of some numbers, in ascending order: those apart by the rounding of a product count as one.
pub(crate) struct Levels {
    values: Vec<f64>,
    /// How far numbers on a lattice are off it.
    rounding: f64,
}

impl Levels {
    pub fn of(values: impl Iterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.collect();
        values.sort_by(f64::total_cmp);
        let largest = values.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let rounding = MAX_ROUNDINGS * f64::EPSILON * largest;
        values.dedup_by(|x, before| *x - *before <= rounding);
        Levels { values, rounding }
    }

    /// How many they are.
    pub fn count(&self) -> usize {
        self.values.len()
    }

    fn differences(&self) -> Vec<f64> {
        self.values.windows(2).map(|x| x[1] - x[0]).collect()
    }

    /// The least difference of two of them.
    pub fn least_difference(&self) -> Option<f64> {
        self.differences().into_iter().reduce(f64::min)
    }

    /// The spacing of a lattice on which all of them are, or all of at least half the size of the largest: numbers of so
    /// many significant digits are on finer lattices the smaller they are.
    pub fn spacing(&self) -> Option<f64> {
        let largest = self.values.first()?.abs().max(self.values.last()?.abs());
        let large = self.values.iter().filter(|x| x.abs() >= 0.5 * largest);
        let of_large = Levels {
            values: large.copied().collect(),
            rounding: self.rounding,
        };
        let both = [self.of_all(), of_large.of_all()];
        both.into_iter().flatten().reduce(f64::max)
    }

    fn of_all(&self) -> Option<f64> {
        let mut differences = self.differences();
        if differences.len() < MIN_DIFFERENCES {
            return None;
        }
        differences.sort_by(f64::total_cmp);
        let mut spacing = differences[0];
        for &difference in &differences {
            spacing = self.common_divisor(difference, spacing)?;
        }
        // The multiples of the smallest do not tell it well: those of all do.
        let origin = self.values[0];
        for value in &self.values[1..] {
            let multiple = ((value - origin) / spacing).round();
            if (value - origin - multiple * spacing).abs() > 2.0 * MAX_REMAINDER * spacing {
                return None;
            }
            spacing = (value - origin) / multiple;
        }
        Some(spacing)
    }

    /// Of two differences, the second of which is not larger; `None` where it is not far above their rounding.
    fn common_divisor(&self, mut large: f64, mut small: f64) -> Option<f64> {
        loop {
            if MAX_REMAINDER * small <= 2.0 * self.rounding {
                return None;
            }
            let multiple = (large / small).round();
            let remainder = (large - multiple * small).abs();
            if remainder <= MAX_REMAINDER * small {
                return Some(large / multiple);
            }
            (large, small) = (small, remainder);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn levels(count: usize, of: impl Fn(f64) -> f64) -> Levels {
        Levels::of((0..count).map(|k| of((0.37 * k as f64).sin())))
    }

    #[test]
    fn lattices_are_found_in_any_unit() {
        for scale in [1.0, std::f64::consts::PI / 180.0, 0.0254, 1e9 / 3.0] {
            for decimals in [1, 2, 3, 5, 7] {
                for origin in [0.0, 0.3, -7.1] {
                    let unit = 10f64.powi(-decimals);
                    let on_lattice = |x: f64| ((x + origin) / unit).round() * unit * scale;
                    let found = levels(64, on_lattice).spacing();
                    let found = found.map_or(0.0, |found| found / (unit * scale));
                    assert!(
                        (found - 1.0).abs() < 1e-6,
                        "{scale} {decimals} {origin}: {found}"
                    );
                }
            }
        }
    }

    #[test]
    fn significant_digits_are_found_by_the_largest_numbers() {
        let inches = |x: f64| format!("{:.4e}", 3.0 * x).parse::<f64>().unwrap() * 0.0254;
        let found = levels(64, inches).spacing().unwrap() / (1e-4 * 0.0254);
        assert!((found - 1.0).abs() < 1e-6, "{found}");
        let degrees = |x: f64| f64::from((150.0 * x) as f32) * std::f64::consts::PI / 180.0;
        let unit = 64.0 * f64::from(f32::EPSILON) * std::f64::consts::PI / 180.0;
        let found = levels(64, degrees).spacing().unwrap() / unit;
        assert!((found - 1.0).abs() < 1e-6, "{found}");
    }

    #[test]
    fn other_numbers_are_on_none() {
        for count in [9, 24, 64, 1000] {
            assert_eq!(levels(count, |x| x).spacing(), None, "{count}");
            assert_eq!(levels(count, |x| 1e6 + x).spacing(), None, "{count}");
        }
        let circle = |k: u32| (f64::from(k) * std::f64::consts::TAU / 64.0).cos();
        assert_eq!(Levels::of((0..64).map(circle)).spacing(), None);
    }

    #[test]
    fn few_levels_have_a_least_difference() {
        let found = levels(64, |x| (2.0 * x).round() / 3.0);
        assert_eq!(found.count(), 5);
        assert!((found.least_difference().unwrap() - 1.0 / 3.0).abs() < 1e-15);
        assert_eq!(found.spacing(), None, "too few to tell");
        assert_eq!(levels(64, |_| 0.3).least_difference(), None);
    }
}
