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
    let rounded: f64 = format!("{value:.0e}").parse().unwrap_or(value);
    match value.abs() {
        1e-3..1e5 => format!("{rounded}"),
        _ => format!("{rounded:e}"),
    }
}

/// What a loop is called.
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
