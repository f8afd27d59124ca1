//! Numbers as readers of papers expect them: real minus signs, raised exponents.

/// A number in raised figures: −16 is ⁻¹⁶, 2.5 is ²·⁵.
pub fn superscript(n: impl std::fmt::Display) -> String {
    n.to_string()
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            '.' => '·',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            '4' => '⁴',
            '5' => '⁵',
            '6' => '⁶',
            '7' => '⁷',
            '8' => '⁸',
            '9' => '⁹',
            _ => '⁰',
        })
        .collect()
}

/// A power such as 10⁻⁴.
pub(super) fn power(base: u32, exponent: i32) -> String {
    format!("{base}{}", superscript(exponent))
}

/// The power of ten of the leading figure of a positive `value`; bounded even for infinity.
pub(super) fn decade(value: f64) -> i32 {
    // The small push keeps 1000 = 10^2.9999… in its decade.
    (value.log10() + 1e-9).floor().clamp(-400.0, 400.0) as i32
}

/// A multiple of `step` on an axis whose largest value is `largest`, with the figures that
/// `step` needs and no more.
pub(super) fn tick_label(value: f64, step: f64, largest: f64) -> String {
    if value == 0.0 {
        return "0".to_string();
    }
    let (top, fine) = (decade(largest), decade(step));
    if (-3..5).contains(&top) {
        let places = usize::try_from(-fine).unwrap_or(0);
        return format!("{value:.places$}").replace('-', "−");
    }
    let exponent = decade(value.abs());
    let places = usize::try_from(exponent - fine).unwrap_or(0);
    let text = format!("{value:.places$e}");
    match text.split_once('e') {
        Some((mantissa, exponent)) => {
            let exponent = exponent.parse().unwrap_or(0);
            format!("{}×{}", mantissa.replace('-', "−"), power(10, exponent))
        }
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers() {
        assert_eq!(power(10, -16), "10⁻¹⁶");
        assert_eq!(power(2, -1), "2⁻¹");
        assert_eq!(power(2, 10), "2¹⁰");
        assert_eq!(power(10, 0), "10⁰");
        assert_eq!(superscript(2.5), "²·⁵");
    }

    #[test]
    fn labels_have_the_figures_of_the_step() {
        assert_eq!(tick_label(0.30000000000000004, 0.1, 1.0), "0.3");
        assert_eq!(tick_label(-2.0, 1.0, 3.0), "−2");
        assert_eq!(tick_label(2.5, 0.5, 3.0), "2.5");
        assert_eq!(tick_label(40000.0, 20000.0, 80000.0), "40000");
        assert_eq!(tick_label(2e-9, 1e-9, 5e-9), "2×10⁻⁹");
        assert_eq!(tick_label(-1.5e7, 5e6, 2e7), "−1.5×10⁷");
        assert_eq!(tick_label(0.0, 1e-9, 5e-9), "0");
    }
}
