//! Powers of two as people read them.

use crate::figure::superscript;

/// `2^-3` for 0.125; other numbers as they are.
pub fn power_of_two(value: f64) -> String {
    let exponent = value.log2();
    if exponent.fract() == 0.0 && value != 1.0 {
        format!("2^{exponent}")
    } else if (1e-4..1e6).contains(&value) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}

/// A power with a raised exponent, for figures: `2⁻³` for 0.125.
pub fn raised_power_of_two(value: f64) -> String {
    let exponent = value.log2();
    if exponent.fract() == 0.0 && value != 1.0 {
        format!("2{}", superscript(exponent))
    } else {
        format!("{value}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_and_others() {
        assert_eq!(power_of_two(0.125), "2^-3");
        assert_eq!(power_of_two(1024.0), "2^10");
        assert_eq!(power_of_two(0.1), "0.1");
        assert_eq!(power_of_two(1.0), "1");
        assert_eq!(raised_power_of_two(2f64.powi(-10)), "2⁻¹⁰");
    }
}
