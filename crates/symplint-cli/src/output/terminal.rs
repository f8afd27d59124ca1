//! What belongs to the terminal: its width, colours.

use anstyle::{AnsiColor, Style};
use symplint::{Verdict, VerdictKind};
use symplint_report::table::reasons;

/// The width of tables where standard output is no terminal.
const WIDTH: u16 = 100;

/// Columns of the terminal on standard output.
pub fn width() -> u16 {
    let size = terminal_size::terminal_size_of(std::io::stdout());
    size.map_or(WIDTH, |(terminal_size::Width(columns), _)| columns)
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
        format!("{headline}\n{}", reasons(verdict))
    }
}
