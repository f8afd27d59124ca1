//! The width of the terminal, and colours.

use anstyle::{AnsiColor, Style};
use symplint::{Diagnosis, Verdict, VerdictKind};
use symplint_report::text;
use terminal_size::{Width, terminal_size_of};

/// Longer lines are hard to read.
const MAX_WIDTH: usize = 100;

/// Characters of a line: `COLUMNS` of the environment, or else the width of the terminal, but at most 100.
/// None where standard output is not a terminal: paragraphs stay on one line each, for `grep` and the like.
pub fn width() -> Option<usize> {
    let columns = std::env::var("COLUMNS")
        .ok()
        .and_then(|text| text.parse().ok());
    let terminal = || terminal_size_of(std::io::stdout()).map(|(Width(width), _)| width.into());
    let width = columns.filter(|&width| width > 0).or_else(terminal);
    width.map(|width: usize| width.min(MAX_WIDTH))
}

/// A diagnosis with its headline in colour; the headline alone if little is to be shown.
pub fn diagnosis_text(title: &str, diagnosis: &Diagnosis, (quiet, all): (bool, bool)) -> String {
    let headline = headline(&diagnosis.verdict);
    if quiet {
        return headline;
    }
    let shown = text::DisplayOptions {
        width: width(),
        all,
    };
    format!(
        "{headline}\n{}",
        text::diagnosis_text(title, diagnosis, shown)
    )
}

/// The headline of a verdict, with the answer in capitals.
fn headline(verdict: &Verdict) -> String {
    let color = match verdict.kind {
        VerdictKind::Symplectic => AnsiColor::Green,
        VerdictKind::NotSymplectic | VerdictKind::BrokenLoops => AnsiColor::Red,
        VerdictKind::Undecided => AnsiColor::Yellow,
    };
    let style = Style::new().bold().fg_color(Some(color.into()));
    let (answer, rest) = text::headline(verdict);
    format!("{style}{answer}{rest}{style:#}")
}
