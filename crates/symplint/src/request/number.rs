//! Numbers with powers, products and pi: `0.1`, `2^-3`, `pi/2`.

use std::f64::consts::PI;

/// Reads a product or quotient of numbers, powers `a^b` and `pi`, with an optional sign.
pub fn parse(text: &str) -> Option<f64> {
    let text = text.trim();
    let (sign, text) = match text.strip_prefix('-') {
        Some(rest) => (-1.0, rest),
        None => (1.0, text),
    };
    let mut value = sign;
    let mut operator = '*';
    let mut rest = text;
    loop {
        let end = rest.find(['*', '/']).unwrap_or(rest.len());
        let factor = power(&rest[..end])?;
        value = if operator == '*' {
            value * factor
        } else {
            value / factor
        };
        match rest[end..].chars().next() {
            None => return Some(value),
            Some(next) => {
                operator = next;
                rest = &rest[end + 1..];
            }
        }
    }
}

fn power(text: &str) -> Option<f64> {
    match text.split_once('^') {
        None => atom(text),
        Some((base, exponent)) => Some(atom(base)?.powf(atom(exponent)?)),
    }
}

fn atom(text: &str) -> Option<f64> {
    match text.trim() {
        "pi" | "π" => Some(PI),
        number => number.parse().ok(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_powers_products_and_pi() {
        assert_eq!(parse("2^-3"), Some(0.125));
        assert_eq!(parse("pi"), Some(PI));
        assert_eq!(parse("-pi/2"), Some(-PI / 2.0));
        assert_eq!(parse("3 * pi / 4"), Some(3.0 * PI / 4.0));
        assert_eq!(parse("1e-3"), Some(1e-3));
        assert_eq!(parse("2^20"), Some(1048576.0));
    }

    #[test]
    fn refuses_everything_else() {
        for text in ["", "two", "2^", "1//2", "pi pi", "2*"] {
            assert_eq!(parse(text), None, "{text}");
        }
    }
}
