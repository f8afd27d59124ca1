//! Tables as text, and the text of a verdict.

use comfy_table::{CellAlignment, ContentArrangement, Table, presets};
use symplint::{Diagnosis, Point, Sweep, TracePoint, Verdict};

use crate::number::power_of_two;

/// Rows of one sweep at most, so that a screen holds the table.
const MOST_ROWS: usize = 16;

/// A relative quadrature error above this says nothing of the loop integral.
const UNRESOLVED: f64 = 1e-6;

/// A table with a header, at most `width` characters wide.
pub fn plain_table(header: &[&str], rows: Vec<Vec<String>>, width: u16) -> String {
    let mut table = Table::new();
    table.load_style(presets::UTF8_BORDERS_ONLY);
    table.set_content_arrangement(ContentArrangement::Dynamic);
    table.set_width(width);
    table.set_header(header.to_vec());
    table.add_rows(rows);
    table.to_string()
}

/// `1 degree of freedom`, `2 degrees of freedom`.
pub fn degrees_of_freedom(count: usize) -> String {
    format!(
        "{count} degree{} of freedom",
        if count == 1 { "" } else { "s" }
    )
}

/// The sweeps of the given loop, under a heading.
pub fn points_table(heading: &str, diagnosis: &Diagnosis) -> String {
    let mut text = format!("{heading}\n");
    let all = diagnosis.points();
    for sweep in [Sweep::StepSize, Sweep::Samples] {
        let points: Vec<&Point> = (all.iter())
            .filter(|point| point.sweep == sweep && point.loop_index == 0)
            .collect();
        if !points.is_empty() {
            text += &sweep_table(&points);
            text.push('\n');
        }
    }
    text
}

fn sweep_table(points: &[&Point]) -> String {
    let mut table = Table::new();
    table.load_style(presets::UTF8_BORDERS_ONLY);
    let omitted = points.iter().any(|point| point.omitted_cells.is_some());
    let mut header = vec![
        "h",
        "samples",
        "rule",
        "∮p·dq",
        "defect",
        "quadrature",
        "round-off",
    ];
    if omitted {
        header.push("omitted");
    }
    let breaks = points.iter().any(|point| point.jumps.is_some());
    if breaks {
        header.extend(["breaks", "closed"]);
    }
    table.set_header(header);
    let every = points.len().div_ceil(MOST_ROWS);
    for point in points.iter().step_by(every) {
        let mut row = vec![
            step_size(point.step_size),
            point.samples.to_string(),
            point.rule.to_string(),
            format!("{:.9e}", point.advanced),
            format!("{:+.2e}", point.signed_defect),
            point
                .quadrature_error
                .map_or("?".into(), |error| format!("{error:.0e}")),
            format!("{:.0e}", point.roundoff),
        ];
        if omitted {
            row.push(
                point
                    .omitted_cells
                    .map_or(String::new(), |cells| cells.to_string()),
            );
        }
        if breaks {
            row.push(point.jumps.map_or(String::new(), |count| count.to_string()));
            row.push(
                point
                    .closed_defect
                    .map_or(String::new(), |defect| format!("{defect:.2e}")),
            );
        }
        table.add_row(row);
    }
    for (index, column) in table.column_iter_mut().enumerate() {
        if index != 2 {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    with_note(&table, every)
}

/// The table, and a line on the points that it skips, if it does.
fn with_note(table: &Table, every: usize) -> String {
    if every <= 1 {
        return table.to_string();
    }
    let ending = match (every % 100, every % 10) {
        (11..=13, _) => "th",
        (_, 1) => "st",
        (_, 2) => "nd",
        (_, 3) => "rd",
        _ => "th",
    };
    format!("{table}\n(every {every}{ending} point is shown)")
}

/// A step size; a loop from a file may not state it.
fn step_size(h: f64) -> String {
    if h.is_nan() {
        "?".into()
    } else {
        power_of_two(h)
    }
}

/// What a verdict rests on: its summary, the evidence and the advice, below the headline.
pub fn reasons(verdict: &Verdict) -> String {
    let mut text = verdict.summary();
    for line in verdict.evidence() {
        text += &format!("\n  · {line}");
    }
    for line in verdict.advice() {
        text += &format!("\n  → {line}");
    }
    text
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
            .is_none_or(|error| error > UNRESOLVED)
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
    let mut table = Table::new();
    table.load_style(presets::UTF8_BORDERS_ONLY);
    table.set_header(["t", "∮p·dq", "defect", "quadrature", "energy error"]);
    let every = points.len().div_ceil(MOST_ROWS).max(1);
    for point in points.iter().step_by(every) {
        table.add_row([
            format!("{:.4}", point.time),
            format!("{:.9e}", point.integral),
            format!("{:+.2e}", point.signed_defect),
            point
                .quadrature_error
                .map_or("?".into(), |error| format!("{error:.0e}")),
            point
                .energy_error
                .map_or(String::new(), |error| format!("{error:+.2e}")),
        ]);
    }
    for column in table.column_iter_mut() {
        column.set_cell_alignment(CellAlignment::Right);
    }
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
        // Header, its rule and the borders, and two lines of summary besides the rows.
        const BESIDES: usize = 6;
        for (points, rows, note) in [
            (16, 16, None),
            (17, 9, Some("every 2nd point")),
            (31, 16, Some("every 2nd point")),
            (1001, 16, Some("every 63rd point")),
        ] {
            let points: Vec<TracePoint> = (0..points).map(point).collect();
            let text = trace_table(&points, false);
            let noted = usize::from(note.is_some());
            assert_eq!(text.lines().count(), rows + BESIDES + noted, "{text}");
            assert!(text.contains(note.unwrap_or("")), "{text}");
            assert_eq!(text.contains("point is shown"), note.is_some());
        }
    }
}
