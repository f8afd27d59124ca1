//! The message of a command that failed, with the line of the configuration that caused it.

use std::error::Error;

use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};
use symplint_config::{ConfigError, Place};
use symplint_report::wrap::wrapped;

use crate::failure::Failure;

/// Columns of a message. Words longer than a line, such as paths, stay whole.
const WIDTH: usize = 80;

/// Columns before the message.
const BEFORE_TITLE: usize = "error: ".len();

/// Columns before the remedy: a line number of up to four digits, and the sign that it belongs to the error.
const BEFORE_REMEDY: usize = "1234 = help: ".len();

/// What went wrong, the setting that caused it, and the remedy; of a configuration, all its errors.
pub fn failure_message(failure: &Failure) -> String {
    let position = failure.position();
    let first = message(&with_causes(failure), position, failure.remedy().as_deref());
    let others: &[ConfigError] = match failure {
        Failure::Config(error) => &error.others,
        _ => &[],
    };
    let others = others.iter().map(|error| {
        let position = error.position.as_ref();
        let position = position.map(|(place, label)| (place, label.as_str()));
        message(&error.message, position, error.remedy.as_deref())
    });
    let all: Vec<String> = std::iter::once(first).chain(others).collect();
    all.join("\n\n")
}

/// One error, with its line and its remedy.
fn message(text: &str, position: Option<(&Place, &str)>, remedy: Option<&str>) -> String {
    let title = folded(text, BEFORE_TITLE);
    let remedy = remedy.map(|text| folded(text, BEFORE_REMEDY));
    let snippet = position.map(|(place, label)| {
        let underlined = AnnotationKind::Primary.span(place.span.clone());
        Snippet::source(&place.source.text)
            .path(&place.source.name)
            .annotation(underlined.label(label))
    });
    let report = Level::ERROR
        .primary_title(title)
        .elements(snippet)
        .elements(remedy.map(|text| Level::HELP.message(text)));
    Renderer::styled().term_width(WIDTH).render(&[report])
}

/// The text of an error and of the errors that caused it.
fn with_causes(error: &dyn Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text += &format!(": {error}");
        cause = error.source();
    }
    text
}

/// The text in lines that fit after `before` columns. Lines with an indent, which another program printed, stay as they are.
fn folded(text: &str, before: usize) -> String {
    let line = |line: &str| match line.starts_with(' ') {
        true => line.to_owned(),
        false => wrapped("", "", line, Some(WIDTH - before)),
    };
    text.split('\n').map(line).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use symplint_config::document::parse;

    /// The message of a configuration that is not valid, without colours.
    fn parse_error(text: &str) -> Option<String> {
        let error = parse("run.toml", text.to_owned()).err()?;
        let styled = failure_message(&error.into());
        Some(anstream::adapter::strip_str(&styled).to_string())
    }

    #[test]
    fn the_line_is_shown_and_the_place_underlined() {
        let expected = "\
error: dates are not accepted
 --> run.toml:2:8
  |
2 | when = 2026-01-01 # ∮
  |        ^^^^^^^^^^ a date
  |
  = help: write a number or a string";
        assert_eq!(
            parse_error("a = 1\nwhen = 2026-01-01 # ∮\n").unwrap(),
            expected
        );
    }

    #[test]
    fn lines_of_other_programs_stay_whole() {
        let long =
            "it ended with exit status 1, which is not a success at all; its standard error:";
        let traceback = format!(
            "{long}\n  File \"advance.py\", line 8, in <module>{}",
            " word".repeat(20)
        );
        let folded = folded(&traceback, 7);
        let lines: Vec<&str> = folded.lines().collect();
        assert_eq!(lines.len(), 3, "{folded}");
        assert!(lines[2].starts_with("  File") && lines[2].ends_with("word"));
    }

    #[test]
    fn lines_fit_the_width() {
        let numbers = "1.0, ".repeat(60);
        for text in [
            format!("x = [{numbers} 1999-01-01]"),
            format!("{}x = [", "\n".repeat(1000)),
        ] {
            let said = parse_error(&text).unwrap();
            for line in said.lines() {
                assert!(line.chars().count() <= WIDTH, "{line}");
            }
        }
    }

    #[test]
    fn wherever_a_text_is_cut_or_damaged_its_message_can_be_drawn() {
        let whole = "[système]\r\nα = \"∮p·dq\\u03b1\" # é\n\"ключ\" = [1e3, '''\n𝛾''']\n";
        let cuts: Vec<usize> = (whole.char_indices()).map(|(index, _)| index).collect();
        for &cut in &cuts {
            for added in [
                "",
                "∮",
                "\u{1b}[31m",
                "\"",
                "= =",
                "\u{0}",
                "'''𝛾",
                "\\",
                "\\u00",
            ] {
                parse_error(&format!("{}{added}", &whole[..cut]));
                parse_error(&format!("{}{added}{}", &whole[..cut], &whole[cut..]));
            }
        }
    }
}
