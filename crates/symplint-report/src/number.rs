//! Powers of two and counts as people read them.

use crate::figure::superscript;

/// k of 2^k, if that reads better than the number; 1 does not.
fn exponent(value: f64) -> Option<f64> {
    Some(value.log2()).filter(|exponent| exponent.fract() == 0.0 && *exponent != 0.0)
}

/// `2^-3` for 0.125; three decimals of other numbers, for sentences.
pub fn short_power(value: f64) -> String {
    match exponent(value) {
        Some(exponent) if exponent < 0.0 => format!("2^{exponent}"),
        _ => format!("{value:.3}"),
    }
}

/// A power with a raised exponent, for figures: `2⁻³` for 0.125.
pub fn raised_power_of_two(value: f64) -> String {
    match exponent(value) {
        Some(exponent) => format!("2{}", superscript(exponent)),
        None => format!("{value}"),
    }
}

/// `36,289`.
pub fn in_thousands(count: usize) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_and_others() {
        assert_eq!(short_power(0.125), "2^-3");
        assert_eq!(short_power(2.0), "2.000");
        assert_eq!(short_power(0.1), "0.100");
        assert_eq!(raised_power_of_two(1.0), "1");
        assert_eq!(raised_power_of_two(2f64.powi(-10)), "2⁻¹⁰");
    }

    #[test]
    fn counts_have_commas() {
        assert_eq!(
            [7, 999, 1000, 1234567].map(in_thousands),
            ["7", "999", "1,000", "1,234,567"]
        );
    }
}
