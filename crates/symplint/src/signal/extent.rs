//! The range of some numbers.

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
        // In lanes, so that it is vectorised.
        let (groups, rest) = row.as_chunks::<8>();
        let mut lanes = [Extent::default(); 8];
        for group in groups {
            for (lane, &value) in lanes.iter_mut().zip(group) {
                lane.include(value);
            }
        }
        let mut extent = Extent::default();
        for lane in lanes {
            extent.low = extent.low.min(lane.low);
            extent.high = extent.high.max(lane.high);
        }
        rest.iter().for_each(|&value| extent.include(value));
        extent
    }

    pub fn include(&mut self, value: f64) {
        self.low = self.low.min(value);
        self.high = self.high.max(value);
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
        let row: Vec<f64> = (0..21).map(|k| (1.3 * f64::from(k)).sin()).collect();
        for from in 0..20 {
            let row = &row[from..];
            let expected = row.iter().copied().fold(f64::NEG_INFINITY, f64::max)
                - row.iter().copied().fold(f64::INFINITY, f64::min);
            assert_eq!(Extent::of(row).length(), expected);
        }
        assert_eq!(Extent::of(&[-2.0]).length(), 0.0);
        assert_eq!(Extent::of(&[-2.0]).magnitude(), 2.0);
        let none = Extent::default();
        assert_eq!([none.length(), none.magnitude()], [0.0, 0.0]);
    }
}
