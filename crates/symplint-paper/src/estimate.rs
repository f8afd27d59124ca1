//! Measured sizes with their errors.

/// A size and the bound of its error.
#[derive(Clone, Copy, Debug)]
pub struct Estimate {
    pub size: f64,
    pub error: f64,
}

impl Estimate {
    /// The bounds of the factor by which `self` is larger than `other`.
    pub fn factor_over(self, other: Estimate) -> (f64, f64) {
        let least = |estimate: Estimate| (estimate.size - estimate.error).max(0.0);
        (
            least(self) / (other.size + other.error),
            (self.size + self.error) / least(other),
        )
    }

    /// The larger one.
    pub fn max(self, other: Estimate) -> Estimate {
        Estimate {
            size: self.size.max(other.size),
            error: self.error.max(other.error),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_are_as_uncertain_as_what_they_compare() {
        let estimate = |size, error| Estimate { size, error };
        let (low, high) = estimate(100.0, 1.0).factor_over(estimate(10.0, 1.0));
        assert!((low - 9.0).abs() < 1e-12 && (high - 101.0 / 9.0).abs() < 1e-12);
        let (low, high) = estimate(1.0, 2.0).factor_over(estimate(1.0, 2.0));
        assert_eq!((low, high), (0.0, f64::INFINITY));
    }
}
