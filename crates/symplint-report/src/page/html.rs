//! Texts in HTML.

use std::fmt::Write;

/// The longest text, in characters, that is never split between lines: it fits on a narrow page.
const MAX_UNBROKEN_LENGTH: usize = 20;

/// A sentence in HTML: exponents are raised, text between backticks is code, and lines do not end within numbers and equations.
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
        text += &match is_code {
            true => format!("<code>{part}</code>"),
            false => unbroken(part),
        };
    }
    text
}

/// A text in which numbers such as 1e-5 and equations such as h = 0.5 stay on one line, where they are short.
fn unbroken(text: &str) -> String {
    let words: Vec<&str> = text.split(' ').collect();
    let mut parts = Vec::new();
    let mut first = 0;
    while first < words.len() {
        let mut end = first + 1;
        while end + 1 < words.len() && matches!(words[end], "=" | "±" | "≤" | "−" | "→" | "&lt;")
        {
            end += 2;
        }
        let is_short = |end: usize| visible(&words[first..end].join(" ")) <= MAX_UNBROKEN_LENGTH;
        // Without the uncertainty, if that makes it short enough.
        while end > first + 1 && !is_short(end) {
            end -= 2;
        }
        let part = words[first..end].join(" ");
        let holds = |mark: &str| part.matches(mark).count();
        let is_whole = holds("<sup>") == holds("</sup>");
        let has_digits = part.contains(|c: char| c.is_ascii_digit());
        let is_breakable = end > first + 1 || (part.contains('-') && has_digits);
        parts.push(match is_whole && is_breakable && is_short(end) {
            true => format!("<span class=\"unbroken\">{part}</span>"),
            false => part,
        });
        first = end;
    }
    parts.join(" ")
}

/// The number of characters that a reader sees.
fn visible(html: &str) -> usize {
    let without_tags = html.replace("<sup>", "").replace("</sup>", "");
    without_tags.replace("&lt;", "<").chars().count()
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
                "h from 2^10 to 2^1.",
                "h from 2<sup>10</sup> to 2<sup>1</sup>.",
            ),
            ("in H^0.5: `f`", "in H<sup>0.5</sup>: <code>f</code>"),
            ("a & b", "a &amp; b"),
        ] {
            assert_eq!(sentence(text), html);
        }
    }

    #[test]
    fn numbers_and_short_equations_stay_on_one_line() {
        let span = |text: &str| format!("<span class=\"unbroken\">{text}</span>");
        for (text, html) in [
            (
                "at h = 0.5 by 3e-15.",
                format!("at {} by {}", span("h = 0.5"), span("3e-15.")),
            ),
            (
                "as h^(3.0 ± 0.1) falls",
                format!("as {} falls", span("h<sup>(3.0 ± 0.1)</sup>")),
            ),
            (
                "of the value = 1.2345e-2 ± 1.5e-15",
                format!("of the {} ± {}", span("value = 1.2345e-2"), span("1.5e-15")),
            ),
            (
                "if p → −p and |det M − 1| ≤ 6e-15",
                format!("if {} and |det {}", span("p → −p"), span("M − 1| ≤ 6e-15")),
            ),
            (
                "a time-reversible step, `tolerance = 1e-6`",
                "a time-reversible step, <code>tolerance = 1e-6</code>".into(),
            ),
        ] {
            assert_eq!(sentence(text), html);
        }
    }
}
