//! The range of some numbers.

use multiversion::multiversion;

/// From the least to the greatest of some numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    low: f64,
    high: f64,
}

impl Default for Extent {
    /// Of no numbers.
    fn default() -> Self {
        Extent {
            low: f64::INFINITY,
            high: f64::NEG_INFINITY,
        }
    }
}

impl Extent {
    /// Of the values of a row.
    pub fn of(row: &[f64]) -> Self {
        let (groups, rest) = row.as_chunks();
        let mut extent = Extent::default();
        if !groups.is_empty() {
            extent.low = -greatest(groups, -1.0);
            extent.high = greatest(groups, 1.0);
        }
        rest.iter().for_each(|&value| extent.include(value));
        extent
    }

    pub fn include(&mut self, value: f64) {
        // Not `f64::min`, which takes several instructions for the sake of what is not a number; neither includes that.
        self.low = if value < self.low { value } else { self.low };
        self.high = if value > self.high { value } else { self.high };
    }

    /// Greatest less least; 0 of no numbers.
    pub fn length(&self) -> f64 {
        (self.high - self.low).max(0.0)
    }

    pub fn middle(&self) -> f64 {
        (self.low + self.high) / 2.0
    }

    /// The largest absolute value; 0 of no numbers.
    pub fn magnitude(&self) -> f64 {
        self.high.max(-self.low).max(0.0)
    }
}

/// Enough numbers that no register waits for the one before.
const GROUP: usize = 32;

/// The greatest value times `sign`.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
fn greatest(groups: &[[f64; GROUP]], sign: f64) -> f64 {
    let mut lanes = [f64::NEG_INFINITY; GROUP];
    for group in groups {
        for lane in 0..GROUP {
            let value = sign * group[lane];
            lanes[lane] = if value > lanes[lane] {
                value
            } else {
                lanes[lane]
            };
        }
    }
    let larger = |a: f64, b: f64| if b > a { b } else { a };
    lanes.into_iter().fold(f64::NEG_INFINITY, larger)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn least_and_greatest_give_length_middle_and_magnitude() {
        let extent = Extent::of(&[0.5, -3.0, 1.0]);
        assert_eq!(
            [extent.length(), extent.middle(), extent.magnitude()],
            [4.0, -1.0, 3.0]
        );
        let row: Vec<f64> = (0..75).map(|k| (1.3 * f64::from(k)).sin()).collect();
        for from in 0..74 {
            let row = &row[from..];
            let expected = row.iter().copied().fold(f64::NEG_INFINITY, f64::max)
                - row.iter().copied().fold(f64::INFINITY, f64::min);
            assert_eq!(Extent::of(row).length(), expected);
        }
        let with_nan = Extent::of(&[1.0, f64::NAN, 3.0]);
        assert_eq!([with_nan.length(), with_nan.magnitude()], [2.0, 3.0]);
        assert_eq!(Extent::of(&[-2.0]).length(), 0.0);
        assert_eq!(Extent::of(&[-2.0]).magnitude(), 2.0);
        let none = Extent::default();
        assert_eq!([none.length(), none.magnitude()], [0.0, 0.0]);
    }
}
