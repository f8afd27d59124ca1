//! Numbers with few digits.

/// How numbers are rounded.
#[derive(Clone, Copy, Debug)]
pub enum Rounding {
    /// Not at all.
    None,
    /// To single precision.
    Single,
    /// To this number of digits after the decimal point.
    Decimals(i32),
    /// To this number of significant digits.
    Digits(usize),
    /// To multiples of any number.
    Multiples(f64),
}

impl Rounding {
    /// The number as the rounding leaves it.
    pub fn of(self, value: f64) -> f64 {
        match self {
            Rounding::None => value,
            Rounding::Single => f64::from(value as f32),
            Rounding::Decimals(count) => {
                let unit = 10f64.powi(count);
                (value * unit).round() / unit
            }
            Rounding::Multiples(unit) => (value / unit).round() * unit,
            Rounding::Digits(count) => format!("{value:.*e}", count - 1).parse().unwrap(),
        }
    }

    /// The largest error of a number of size `value`.
    pub fn error(self, value: f64) -> f64 {
        match self {
            Rounding::None => f64::EPSILON / 2.0 * value,
            Rounding::Single => f64::from(f32::EPSILON) / 2.0 * value,
            Rounding::Decimals(count) => 0.5 * 10f64.powi(-count),
            Rounding::Multiples(unit) => 0.5 * unit,
            Rounding::Digits(count) => 5.0 * 10f64.powi(-(count as i32)) * value,
        }
    }

    /// Rounds a state.
    pub fn state(self, values: &mut [f64]) {
        for value in values {
            *value = self.of(*value);
        }
    }
}
