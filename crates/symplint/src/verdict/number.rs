//! Numbers and names as sentences write them.

/// A step size as people write it: all digits if it has four at most, and three of any other.
pub fn size(h: f64) -> String {
    let rounded = |text: String| text.parse().unwrap_or(h);
    let four: f64 = rounded(format!("{h:.3e}"));
    let shown = match four == h {
        true => four,
        false => rounded(format!("{h:.2e}")),
    };
    match h.abs() {
        0.0 | 1e-4..1e6 => format!("{shown}"),
        _ => format!("{shown:e}"),
    }
}

/// `h³` for 3, `h` for 1.
pub(super) fn power_of_h(order: f64) -> String {
    if order == 1.0 {
        return "h".into();
    }
    let digits = format!("{order}");
    let raised = digits.chars().map(|digit| match digit {
        '-' => '⁻',
        '.' => '·',
        '0'..='9' => {
            ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit as usize - '0' as usize]
        }
        other => other,
    });
    format!("h{}", raised.collect::<String>())
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

/// A number with the digits that its uncertainty leaves, and one more, as far as a double has them.
pub(super) fn within(value: f64, uncertainty: f64) -> String {
    let of_double = 15.0 - value.abs().max(f64::MIN_POSITIVE).log10().floor();
    let decimals = (1.0 - uncertainty.abs().log10().floor()).min(of_double);
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

/// The coordinates that jump: the other one is left out if its jump is a thousandth.
pub(super) fn jumping(dof: usize, jump_q: f64, jump_p: f64) -> String {
    let (q, p) = (jump_q.abs(), jump_p.abs());
    if q > 1e3 * p {
        format!("q[{dof}] jumps")
    } else if p > 1e3 * q {
        format!("p[{dof}] jumps")
    } else {
        format!("q[{dof}] and p[{dof}] jump")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_four_digits_or_three() {
        for (h, text) in [
            (0.125, "0.125"),
            (-0.125, "-0.125"),
            (1.0, "1"),
            (2f64.powi(-5), "0.03125"),
            (2f64.powi(-10), "0.000977"),
            (1.0 / 3.0, "0.333"),
            (123.456, "123"),
            (86400.0, "86400"),
            (9.87654321e-5, "9.88e-5"),
            (2e7, "2e7"),
        ] {
            assert_eq!(size(h), text);
        }
        assert_eq!([1.0, 2.0, 13.0].map(power_of_h), ["h", "h²", "h¹³"]);
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
        assert_eq!(jumping(2, -1.0, 9e-4), "q[2] jumps");
        assert_eq!(jumping(2, 9e-4, -1.0), "p[2] jumps");
        assert_eq!(jumping(0, 2e-3, 1.0), "q[0] and p[0] jump");
        assert_eq!(jumping(0, 1.0, 2e-3), "q[0] and p[0] jump");
    }
}
