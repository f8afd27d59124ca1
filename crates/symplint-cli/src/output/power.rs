//! Powers of two as people read them.

/// `2^-3` for 0.125; other numbers in four digits.
pub fn power_of_two(value: f64) -> String {
    let exponent = value.log2();
    if exponent.fract() == 0.0 && exponent.abs() >= 1.0 {
        format!("2^{exponent}")
    } else {
        format!("{value:.4}")
    }
}

/// A power with a raised exponent, for figures: `2⁻³` for 0.125.
pub fn raised_power_of_two(value: f64) -> String {
    let exponent = value.log2();
    if exponent.fract() == 0.0 && exponent.abs() >= 1.0 {
        format!("2{}", superscript(exponent))
    } else {
        format!("{value}")
    }
}

/// An exponent in raised digits.
pub fn superscript(exponent: f64) -> String {
    (format!("{exponent}").chars())
        .map(|c| match c {
            '-' => '⁻',
            '0' => '⁰',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            '4' => '⁴',
            '5' => '⁵',
            '6' => '⁶',
            '7' => '⁷',
            '8' => '⁸',
            '9' => '⁹',
            _ => '·',
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_and_others() {
        assert_eq!(power_of_two(0.125), "2^-3");
        assert_eq!(power_of_two(1024.0), "2^10");
        assert_eq!(power_of_two(0.1), "0.1000");
        assert_eq!(power_of_two(1.0), "1.0000");
        assert_eq!(raised_power_of_two(2f64.powi(-10)), "2⁻¹⁰");
        assert_eq!(superscript(2.5), "²·⁵");
    }
}
