//! Texts in HTML.

use std::fmt::Write;

/// A sentence in HTML: exponents are raised, and what stands between backticks is code.
pub(super) fn sentence(text: &str) -> String {
    let escaped = escaped(text);
    let mut parts = escaped.split('^');
    let mut raised = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let end = match part.strip_prefix('(') {
            Some(rest) => rest.find(')').map_or(part.len(), |end| end + 2),
            None => {
                let is_of_number = |c: char| c.is_ascii_digit() || c == '-';
                let digits = part.trim_start_matches(is_of_number);
                let fraction = digits.strip_prefix('.').map_or(digits, |rest| {
                    match rest.trim_start_matches(|c: char| c.is_ascii_digit()) {
                        // The end of a sentence.
                        after if after.len() == rest.len() => digits,
                        after => after,
                    }
                });
                part.len() - fraction.len()
            }
        };
        let _ = write!(raised, "<sup>{}</sup>{}", &part[..end], &part[end..]);
    }
    let mut text = String::new();
    for (k, part) in raised.split('`').enumerate() {
        let is_code = k % 2 == 1;
        text += if is_code { "<code>" } else { "" };
        text += part;
        text += if is_code { "</code>" } else { "" };
    }
    text
}

/// A text in HTML.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_are_raised_and_names_of_functions_are_code() {
        for (text, html) in [
            (
                "h from 2^-10 to 2^-1.",
                "h from 2<sup>-10</sup> to 2<sup>-1</sup>.",
            ),
            (
                "as h^(3.0 ± 0.1) or H^0.5: `f`",
                "as h<sup>(3.0 ± 0.1)</sup> or H<sup>0.5</sup>: <code>f</code>",
            ),
            ("a < b", "a &lt; b"),
        ] {
            assert_eq!(sentence(text), html);
        }
    }
}
