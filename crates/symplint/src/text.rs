//! Numbers and names as sentences write them.

use crate::signal::UNEXPLAINED;

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

/// A text with its numbers as people write them: `1.12e-1` becomes `0.112`, and `2.0e0` becomes `2.0`. Numbers below 0.1, and from
/// 100,000 on, keep their exponents.
pub fn plain_numbers(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find('e') {
        let (before, after) = (&rest[..at], &rest[at + 1..]);
        let digits = |c: char| c.is_ascii_digit();
        let start = before
            .rfind(|c: char| !digits(c) && c != '.')
            .map_or(0, |last| {
                last + before[last..].chars().next().map_or(0, char::len_utf8)
            });
        let sign = usize::from(after.starts_with('-'));
        let length = sign
            + after[sign..]
                .find(|c: char| !digits(c))
                .unwrap_or(after.len() - sign);
        // Names and codes such as `run1e2.csv` and `9e3f` are not numbers.
        let is_of_word = |c: char| c.is_alphanumeric() || c == '_';
        let left = if start > 0 { &before[..start] } else { &plain };
        let right = after[length..].strip_prefix('.');
        let is_number = !left.ends_with(is_of_word)
            && !right.unwrap_or(&after[length..]).starts_with(is_of_word);
        let power = after[..length]
            .parse()
            .ok()
            .filter(|power| is_number && (-1..5).contains(power));
        match power.and_then(|power| shifted(&before[start..], power)) {
            Some(number) => {
                plain += &before[..start];
                // Zero has no sign.
                if number.chars().all(|c| c == '0' || c == '.') {
                    plain.truncate(plain.trim_end_matches('+').len());
                    plain.push('0');
                } else {
                    plain += &number;
                }
                rest = &after[length..];
            }
            None => {
                plain += &rest[..=at];
                rest = after;
            }
        }
    }
    plain + rest
}

/// A decimal number with one digit before the point, times a power of ten. `None` for other texts.
fn shifted(number: &str, power: i32) -> Option<String> {
    let (first, others) = match number.split_once('.') {
        Some((first, others)) => (first, others),
        None => (number, ""),
    };
    if first.len() != 1 || others.contains('.') {
        return None;
    }
    if power < 0 {
        return Some(format!("0.{first}{others}"));
    }
    let (whole, rest) = others.split_at(others.len().min(power as usize));
    let zeros = "0".repeat(power as usize - whole.len());
    let point = if rest.is_empty() { "" } else { "." };
    Some(format!("{first}{whole}{zeros}{point}{rest}"))
}

/// `h³` for 3, `h` for 1.
pub(crate) fn power_of_h(order: f64) -> String {
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

/// A value that was given, with all its digits: `0.1`, `1e300`, and `2` for 2.0.
pub(crate) fn given(value: f64) -> String {
    let text = format!("{value:?}");
    text.strip_suffix(".0").unwrap_or(&text).to_owned()
}

/// Two digits, and no exponent where none is needed.
pub(crate) fn short(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        0.01..1000.0 => format!("{value:.2}"),
        _ => format!("{value:.1e}"),
    }
}

/// One digit, and no exponent where few zeros are needed.
pub(crate) fn one_digit(value: f64) -> String {
    plain(value, &format!("{value:.0e}"))
}

/// The same with two digits.
pub(crate) fn two_digits(value: f64) -> String {
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
pub(crate) fn significant(value: f64) -> String {
    plain(value, &format!("{value:.5e}"))
}

/// Digits of a number that people read.
const MAX_DIGITS: i32 = 8;

/// A factor and its uncertainty; one of which fewer than two digits of the change would be left, by its change: `1 − 4.112e-12 ± 3e-15`.
pub(crate) fn factor(value: f64, uncertainty: f64) -> String {
    let change = value - 1.0;
    if change == 0.0 || change.abs() >= 10f64.powi(2 - MAX_DIGITS) {
        return with_uncertainty(value, uncertainty);
    }
    let sign = if change < 0.0 { '−' } else { '+' };
    format!("1 {sign} {}", with_uncertainty(change.abs(), uncertainty))
}

/// A number and its uncertainty: `0.941765 ± 3e-6`. A number of more digits than people read is cut off: `0.99004983… (± 2e-14)`.
pub(crate) fn with_uncertainty(value: f64, uncertainty: f64) -> String {
    let error = one_digit(uncertainty.abs());
    // As the digits show it: logarithms are off by a rounding.
    let exponent = |x: f64| -> i32 {
        let text = format!("{x:e}");
        text.split_once('e')
            .and_then(|(_, power)| power.parse().ok())
            .unwrap_or(0)
    };
    let first = exponent(value);
    let has_exponent = value != 0.0 && !(1e-3..1e5).contains(&value.abs());
    // The last digit is the first digit of the error, after rounding.
    let last = exponent(error.parse().unwrap_or(uncertainty));
    let digits = (first - last + 1).max(1);
    if digits <= MAX_DIGITS {
        let number = match has_exponent {
            true => format!("{value:.*e}", digits as usize - 1),
            false => format!("{value:.*}", (-last).max(0) as usize),
        };
        return format!("{number} ± {error}");
    }
    // If the error explains the difference from a round number, the round number is written.
    let round: f64 = format!("{value:.*e}", MAX_DIGITS as usize - 1)
        .parse()
        .unwrap_or(value);
    if (round - value).abs() <= UNEXPLAINED * uncertainty.abs() {
        let number = match has_exponent {
            true => format!("{round:e}"),
            false => format!("{round}"),
        };
        return format!("{number} ± {error}");
    }
    // All digits of a double, of which the first ones are kept.
    let (number, power) = match has_exponent {
        true => {
            let text = format!("{value:.17e}");
            let (number, power) = text.split_once('e').unwrap_or((&text, "0"));
            (number.to_owned(), format!("e{power}"))
        }
        false => (format!("{value:.17}"), String::new()),
    };
    let decimals = match has_exponent {
        true => MAX_DIGITS - 1,
        false => MAX_DIGITS - 1 - first,
    };
    let end = number
        .find('.')
        .map_or(number.len(), |point| point + 1 + decimals.max(0) as usize);
    let cut = number.get(..end).unwrap_or(&number);
    format!("{cut}…{power} (± {error})")
}

/// The name of a loop.
pub(crate) fn loop_name(index: usize) -> String {
    match index {
        0 => "your loop".into(),
        k => format!("random loop {k}"),
    }
}

/// A sentence begins with a capital letter.
pub(crate) fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| {
        first.to_uppercase().chain(letters).collect()
    })
}

/// The coordinates that jump: the other one is left out if its jump is a thousandth.
pub(crate) fn jumping(dof: usize, jump_q: f64, jump_p: f64) -> String {
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
    fn numbers_of_usual_size_have_no_exponent() {
        for (text, plain) in [
            (
                "by +1.124e-1, not 5e0 ± 3.4e-15.",
                "by +0.1124, not 5 ± 3.4e-15.",
            ),
            ("3.141592654e0, +0.00e0", "3.141592654, 0"),
            ("−2e4 to 1.25e1", "−20000 to 12.5"),
            ("2.5e-2, 1e5, 1e-1", "2.5e-2, 1e5, 0.1"),
            (
                "the −e³ of 12e0 degrees, e-1, 1.e",
                "the −e³ of 12e0 degrees, e-1, 1.e",
            ),
            (
                "run_1e2.csv, v1e2, 9e3f, 1e2.h5, 1e2e3; (2e0)",
                "run_1e2.csv, v1e2, 9e3f, 1e2.h5, 1e2e3; (2)",
            ),
        ] {
            assert_eq!(plain_numbers(text), plain);
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
    fn numbers_end_where_their_uncertainty_begins() {
        let texts = [
            (0.941_764_533_6, 3e-6, "0.941765 ± 3e-6"),
            (12.34, 5.0, "12 ± 5"),
            (1234.5, 200.0, "1234 ± 200"),
            (0.1, 9.7e-3, "0.10 ± 0.01"),
            (-1.234_5e-7, 2e-9, "-1.23e-7 ± 2e-9"),
            (0.990_049_833_749_168, 2e-14, "0.99004983… (± 2e-14)"),
            (0.099_999_999_999_97, 3e-14, "0.1 ± 3e-14"),
            (1.0, 2e-14, "1 ± 2e-14"),
            (1.001_000_000_01, 2e-14, "1.0010000… (± 2e-14)"),
            (1.234_567_890_123e-7, 1e-18, "1.2345678…e-7 (± 1e-18)"),
        ];
        for (value, uncertainty, text) in texts {
            assert_eq!(with_uncertainty(value, uncertainty), text);
        }
    }

    #[test]
    fn a_coordinate_whose_jump_is_a_thousandth_is_left_out() {
        assert_eq!(jumping(2, -1.0, 9e-4), "q[2] jumps");
        assert_eq!(jumping(2, 9e-4, -1.0), "p[2] jumps");
        assert_eq!(jumping(0, 2e-3, 1.0), "q[0] and p[0] jump");
        assert_eq!(jumping(0, 1.0, 2e-3), "q[0] and p[0] jump");
    }
}
