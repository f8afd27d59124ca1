//! Tables as text.

use comfy_table::{CellAlignment, LineStyle, Table, TableStyle};
use symplint::trace::TracePoint;
use symplint::verdict::plain_numbers;

use crate::wrap::wrapped;

/// Most rows of one sweep: the table fits on a screen.
const MAX_ROWS: usize = 16;

/// Largest relative quadrature error of a loop integral that is known.
const MAX_RESOLVED_ERROR: f64 = 1e-6;

/// Names and what they mean, one entry for each row: the name, and the text next to it in lines of `width`
/// characters. Without a width each entry stays on one line.
pub fn definitions(rows: &[(String, String)], width: Option<usize>) -> String {
    let longest = rows.iter().map(|(name, _)| name.chars().count()).max();
    let column = longest.unwrap_or(0) + 2;
    let indent = " ".repeat(column);
    let entries: Vec<String> = (rows.iter())
        .map(|(name, text)| wrapped(&format!("{name:column$}"), &indent, text, width))
        .collect();
    entries.join("\n")
}

/// `1 degree of freedom`, `2 degrees of freedom`.
pub fn degrees_of_freedom(count: usize) -> String {
    format!(
        "{count} degree{} of freedom",
        if count == 1 { "" } else { "s" }
    )
}

/// A table of numbers, under a header that a line separates from them.
fn number_table(header: Vec<&str>, rows: Vec<Vec<String>>) -> Table {
    let line = LineStyle::none().fill('─');
    let mut table = Table::new();
    table.load_style(TableStyle::new().header_separator(line));
    table.set_header(header);
    let plain = |row: Vec<String>| row.into_iter().map(|cell| plain_numbers(&cell));
    table.add_rows(rows.into_iter().map(plain));
    for column in table.column_iter_mut() {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

/// The table, and a line on the points that it skips, if it does.
fn with_note(table: &Table, every: usize) -> String {
    let text = table.trim_fmt();
    if every <= 1 {
        return text;
    }
    let ending = match (every % 100, every % 10) {
        (11..=13, _) => "th",
        (_, 1) => "st",
        (_, 2) => "nd",
        (_, 3) => "rd",
        _ => "th",
    };
    format!("{text}\n(every {every}{ending} point is shown)")
}

/// Some moments of a trace and its worst.
pub fn trace_table(points: &[TracePoint], short: bool) -> String {
    let energy = (points.iter().filter_map(|point| point.energy_error))
        .map(f64::abs)
        .reduce(f64::max)
        .map_or(String::new(), |error| {
            format!(", largest energy error {error:.2e}")
        });
    let lost = points.iter().position(|point| {
        point
            .quadrature_error
            .is_none_or(|error| error > MAX_RESOLVED_ERROR)
    });
    let resolved = &points[..lost.unwrap_or(points.len())];
    let defect = resolved
        .iter()
        .map(|point| point.defect)
        .fold(0.0, f64::max);
    let until = match lost {
        None => "the samples resolve the loop to the end".to_owned(),
        Some(0) => "the samples do not resolve the loop: take more".to_owned(),
        Some(step) => format!(
            "the samples resolve the loop until t = {:.4}, beyond which its integral is not known",
            points[step].time
        ),
    };
    let summary = format!("{until}\nlargest defect while resolved {defect:.2e}{energy}");
    if short {
        return summary;
    }
    let header = vec!["t", "∮p·dq", "defect", "quad.\nerror", "energy\nerror"];
    let every = points.len().div_ceil(MAX_ROWS).max(1);
    let row = |point: &TracePoint| {
        vec![
            format!("{:.4}", point.time),
            format!("{:.9e}", point.integral),
            format!("{:+.2e}", point.signed_defect),
            point
                .quadrature_error
                .map_or("?".into(), |error| format!("{error:.0e}")),
            point
                .energy_error
                .map_or(String::new(), |error| format!("{error:+.2e}")),
        ]
    };
    let rows = points.iter().step_by(every).map(row).collect();
    let table = number_table(header, rows);
    format!("{}\n{summary}", with_note(&table, every))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trace_fits_on_a_screen_and_says_what_it_skips() {
        let point = |step: usize| TracePoint {
            step,
            time: step as f64,
            integral: 1.0,
            signed_defect: 0.0,
            defect: 0.0,
            quadrature_error: None,
            roundoff: 0.0,
            energy: None,
            energy_error: None,
        };
        // Two lines of header, the line below, and two lines of summary.
        const OTHER_LINES: usize = 5;
        for (points, rows, note) in [
            (16, 16, None),
            (17, 9, Some("every 2nd point")),
            (31, 16, Some("every 2nd point")),
            (1001, 16, Some("every 63rd point")),
        ] {
            let points: Vec<TracePoint> = (0..points).map(point).collect();
            let text = trace_table(&points, false);
            let noted = usize::from(note.is_some());
            assert_eq!(text.lines().count(), rows + OTHER_LINES + noted, "{text}");
            assert!(text.contains(note.unwrap_or("")), "{text}");
            assert_eq!(text.contains("point is shown"), note.is_some());
        }
    }

    #[test]
    fn names_have_their_text_beside_them() {
        let rows = [
            ("strang".to_owned(), "two drifts and one kick".to_owned()),
            ("rk2".to_owned(), "order 2".to_owned()),
        ];
        assert_eq!(
            definitions(&rows, Some(20)),
            "strang  two drifts\n        and one kick\nrk2     order 2"
        );
        assert_eq!(
            definitions(&rows, None),
            "strang  two drifts and one kick\nrk2     order 2"
        );
    }
}
