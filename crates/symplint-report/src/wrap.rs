//! Paragraphs wrapped to a width.

/// The text in lines of at most `width` characters, the first after `first` and the others after `rest`. A
/// word that is longer than a line has its own line. Without a width the text stays on one line. `first`
/// may have several lines; the text continues after the last.
pub fn wrapped(first: &str, rest: &str, text: &str, width: Option<usize>) -> String {
    let Some(width) = width else {
        return format!("{first}{text}");
    };
    let mut out = first.to_owned();
    let last = first.rsplit('\n').next().unwrap_or(first);
    let mut column = last.chars().count();
    let mut at_start = true;
    for word in text.split(' ') {
        let length = word.chars().count();
        if !at_start && column + 1 + length > width {
            out.push('\n');
            out += rest;
            column = rest.chars().count();
            at_start = true;
        }
        if !at_start {
            out.push(' ');
            column += 1;
        }
        out += word;
        column += length;
        at_start = false;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_filled_and_indented() {
        let text = "one two three four";
        assert_eq!(
            wrapped("  · ", "    ", text, Some(12)),
            "  · one two\n    three\n    four"
        );
        assert_eq!(wrapped("", "", text, Some(13)), "one two three\nfour");
        assert_eq!(wrapped("", "", text, Some(12)), "one two\nthree four");
        assert_eq!(
            wrapped("  · ", "    ", text, None),
            "  · one two three four"
        );
    }

    #[test]
    fn characters_count_not_bytes_and_long_words_stay_whole() {
        assert_eq!(wrapped("", "", "∮p·dq ≤ 1", Some(7)), "∮p·dq ≤\n1");
        assert_eq!(wrapped("", " ", "a bcdefgh i", Some(4)), "a\n bcdefgh\n i");
        assert_eq!(wrapped("· ", "  ", "", Some(4)), "· ");
        assert_eq!(wrapped("title\n- ", "  ", "a b", Some(5)), "title\n- a b");
    }
}
