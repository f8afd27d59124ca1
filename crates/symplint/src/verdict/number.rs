//! Numbers and names as sentences write them.

/// A step size as people read it: `2^-3`, or with six decimals; very small and large ones with four digits.
pub fn size(h: f64) -> String {
    let exponent = h.abs().log2();
    if exponent.fract() == 0.0 && h.abs() != 1.0 {
        let sign = if h < 0.0 { "-" } else { "" };
        return format!("{sign}2^{exponent}");
    }
    match h.abs() {
        0.001..1000.0 => format!("{}", (h * 1e6).round() / 1e6),
        _ => format!("{h:.3e}"),
    }
}

/// Two digits, and no exponent where none is needed.
pub(super) fn short(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        0.01..1000.0 => format!("{value:.2}"),
        _ => format!("{value:.1e}"),
    }
}

/// One digit, and no exponent where few zeros are needed.
pub(super) fn one_digit(value: f64) -> String {
    plain(value, &format!("{value:.0e}"))
}

/// The same with two digits.
pub(super) fn two_digits(value: f64) -> String {
    plain(value, &format!("{value:.1e}"))
}

fn plain(value: f64, rounded: &str) -> String {
    let rounded: f64 = rounded.parse().unwrap_or(value);
    match value.abs() {
        0.0 | 1e-3..1e5 => format!("{rounded}"),
        _ => format!("{rounded:e}"),
    }
}

/// Six digits, without trailing zeros.
pub(super) fn significant(value: f64) -> String {
    plain(value, &format!("{value:.5e}"))
}

/// A number with the digits that its uncertainty leaves, and one more.
pub(super) fn within(value: f64, uncertainty: f64) -> String {
    let decimals = 1.0 - uncertainty.abs().log10().floor();
    let decimals = if decimals > 0.0 {
        decimals.min(17.0) as usize
    } else {
        0
    };
    format!("{value:.decimals$}")
}

/// The name of a loop.
pub(super) fn loop_name(index: usize) -> String {
    match index {
        0 => "the given loop".into(),
        k => format!("random loop {k}"),
    }
}

/// A sentence begins with a capital letter.
pub(super) fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| {
        first.to_uppercase().chain(letters).collect()
    })
}

/// The coordinates that jump: the other one is left out where its jump is a thousandth.
pub(super) fn jumping(jump_q: f64, jump_p: f64) -> &'static str {
    let (q, p) = (jump_q.abs(), jump_p.abs());
    if q > 1e3 * p {
        "q"
    } else if p > 1e3 * q {
        "p"
    } else {
        "(q, p)"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_powers_of_two_decimals_or_four_digits() {
        for (h, text) in [
            (0.125, "2^-3"),
            (-0.125, "-2^-3"),
            (1.0, "1"),
            (0.1, "0.1"),
            (123.456, "123.456"),
            (9.87654321e-4, "9.877e-4"),
            (1000.5, "1.000e3"),
        ] {
            assert_eq!(size(h), text);
        }
    }

    #[test]
    fn short_numbers_have_an_exponent_where_one_is_needed() {
        let texts = [0.0, 0.012, 999.0, 0.009, 1234.0].map(short);
        assert_eq!(texts, ["0", "0.01", "999.00", "9.0e-3", "1.2e3"]);
        let texts = [0.00123, 23456.0, 0.0009, 234567.0].map(one_digit);
        assert_eq!(texts, ["0.001", "20000", "9e-4", "2e5"]);
        assert_eq!([0.0433, 1.26e-7].map(two_digits), ["0.043", "1.3e-7"]);
    }

    #[test]
    fn numbers_have_the_digits_that_their_uncertainty_leaves() {
        assert_eq!(within(0.941_764_533_6, 3e-6), "0.9417645");
        assert_eq!(within(12.34, 5.0), "12.3");
        assert_eq!(within(1234.5, 200.0), "1234");
    }

    #[test]
    fn a_coordinate_whose_jump_is_a_thousandth_is_left_out() {
        assert_eq!(jumping(-1.0, 9e-4), "q");
        assert_eq!(jumping(9e-4, -1.0), "p");
        assert_eq!(jumping(2e-3, 1.0), "(q, p)");
        assert_eq!(jumping(1.0, 2e-3), "(q, p)");
    }
}
