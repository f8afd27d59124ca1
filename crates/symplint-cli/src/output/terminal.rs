//! The width of the terminal, and colours.

use anstyle::{AnsiColor, Style};
use symplint::{Verdict, VerdictKind};
use symplint_report::table::reasons;
use terminal_size::{Width, terminal_size_of};

/// Longer lines are hard to read.
const WIDEST: usize = 100;

/// Characters of a line: `COLUMNS` of the environment, or else the width of the terminal, and 100 at most.
/// None where standard output is not a terminal: paragraphs stay on one line each, for `grep` and the like.
pub fn width() -> Option<usize> {
    let columns = std::env::var("COLUMNS")
        .ok()
        .and_then(|text| text.parse().ok());
    let terminal = || terminal_size_of(std::io::stdout()).map(|(Width(width), _)| width.into());
    let width = columns.filter(|&width| width > 0).or_else(terminal);
    width.map(|width: usize| width.min(WIDEST))
}

/// The verdict with its headline in colour, and its reasons unless `short`.
pub fn verdict_text(verdict: &Verdict, short: bool) -> String {
    let color = match verdict.kind {
        VerdictKind::Symplectic => AnsiColor::Green,
        VerdictKind::NotSymplectic | VerdictKind::BrokenLoops => AnsiColor::Red,
        VerdictKind::Undecided => AnsiColor::Yellow,
    };
    let style = Style::new().bold().fg_color(Some(color.into()));
    let headline = format!("{style}{}{style:#}", verdict.headline());
    if short {
        headline
    } else {
        format!("{headline}\n{}", reasons(verdict, width()))
    }
}
