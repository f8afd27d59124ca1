//! Tables as text, and the text of a verdict.

use comfy_table::{CellAlignment, LineStyle, Table, TableStyle};
use symplint::evidence::{Origin, Point, Sweep};
use symplint::rules::RuleKind;
use symplint::trace::TracePoint;
use symplint::verdict::Property;
use symplint::{Diagnosis, Verdict};

use crate::number::power_of_two;
use crate::wrap::wrapped;

/// Most rows of one sweep: the table fits on a screen.
const MAX_ROWS: usize = 16;

/// Largest relative quadrature error of a loop integral that is known.
const MAX_RESOLVED_ERROR: f64 = 1e-6;

/// Names and what they mean, one entry for each row: the name, and the text beside it in lines of `width`
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

/// The sweeps of the given loop, under a heading: one table for each rule. None is wider than 80 characters.
pub fn points_table(heading: &str, diagnosis: &Diagnosis) -> String {
    let mut text = format!("{heading}\n");
    let all = diagnosis.points();
    let of_files = diagnosis.evidence.origin == Origin::Samples;
    for (sweep, title) in [
        (Sweep::StepSize, "step sizes"),
        (Sweep::Samples, "numbers of samples"),
    ] {
        let points = (all.iter()).filter(|point| point.sweep == sweep && point.loop_index == 0);
        let mut rules: Vec<(RuleKind, Vec<&Point>)> = Vec::new();
        for point in points {
            match rules.iter_mut().find(|(rule, _)| *rule == point.rule) {
                Some((_, points)) => points.push(point),
                None => rules.push((point.rule, vec![point])),
            }
        }
        for (rule, points) in rules {
            let stated = points.iter().any(|point| !point.step_size.is_nan());
            let has_step_size = of_files || stated;
            let title = match (sweep, has_step_size) {
                (Sweep::StepSize, false) => "the map",
                _ => title,
            };
            text += &format!(
                "{title}, {rule} rule\n{}\n",
                sweep_table(&points, has_step_size)
            );
        }
    }
    text
}

/// A table of numbers, under a header that a line separates from them.
fn number_table(header: Vec<&str>, rows: Vec<Vec<String>>) -> Table {
    let line = LineStyle::none().fill('─');
    let mut table = Table::new();
    table.load_style(TableStyle::new().header_separator(line));
    table.set_header(header);
    table.add_rows(rows);
    for column in table.column_iter_mut() {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

/// The numbers of one sweep, with a column of step sizes unless the map has none.
fn sweep_table(points: &[&Point], has_step_size: bool) -> String {
    let omitted = points.iter().any(|point| point.omitted_cells.is_some());
    let breaks = points.iter().any(|point| point.jumps.is_some());
    let mut header = vec![
        "h",
        "samples",
        "∮p·dq",
        "defect",
        "quad.\nerror",
        "round-\noff",
    ];
    if omitted {
        header.push("omitted\ncells");
    }
    if breaks {
        header.extend(["breaks", "closed\ndefect"]);
    }
    let without = usize::from(!has_step_size);
    header.drain(..without);
    let every = points.len().div_ceil(MAX_ROWS);
    let row = |point: &&Point| {
        let mut row = vec![
            step_size(point.step_size),
            point.samples.to_string(),
            format!("{:.9e}", point.advanced),
            format!("{:+.2e}", point.signed_defect),
            point
                .quadrature_error
                .map_or("?".into(), |error| format!("{error:.0e}")),
            format!("{:.0e}", point.roundoff),
        ];
        let count = |count: usize| count.to_string();
        if omitted {
            row.push(point.omitted_cells.map_or(String::new(), count));
        }
        if breaks {
            row.push(point.jumps.map_or(String::new(), count));
            row.push(
                point
                    .closed_defect
                    .map_or(String::new(), |defect| format!("{defect:.2e}")),
            );
        }
        row.drain(..without);
        row
    };
    let rows = points.iter().step_by(every).map(row).collect();
    with_note(&number_table(header, rows), every)
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

/// A step size in at most six digits; a loop from a file may not state it.
fn step_size(h: f64) -> String {
    if h.is_nan() {
        return "?".into();
    }
    let text = power_of_two(h);
    if text.len() <= 8 {
        return text;
    }
    // To six digits, and without trailing zeros.
    power_of_two(format!("{h:.5e}").parse().unwrap_or(h))
}

/// What a verdict rests on: its summary, the evidence and the advice, below the headline. Paragraphs are
/// wrapped to `width` characters, or stay on one line each.
pub fn reasons(verdict: &Verdict, width: Option<usize>) -> String {
    let mut paragraphs = vec![wrapped("", "", &verdict.summary(), width)];
    let mut list = |bullet: &str, lines: &[String]| {
        paragraphs.extend(
            lines
                .iter()
                .map(|line| wrapped(bullet, "    ", line, width)),
        );
    };
    if let Some(cause) = &verdict.cause {
        list(
            &format!("  {}: ", cause.heading()),
            std::slice::from_ref(&cause.text),
        );
    }
    list("  · ", &verdict.sentences());
    list("  · ", properties(verdict).as_slice());
    list("  → ", &verdict.advice());
    paragraphs.join("\n")
}

/// The properties of the map that do not follow from the verdict, as one sentence, if there are any.
pub fn properties(verdict: &Verdict) -> Option<String> {
    let properties = verdict
        .properties
        .iter()
        .filter(|property| !property.implied);
    let texts: Vec<String> = properties.map(Property::to_string).collect();
    (!texts.is_empty()).then(|| format!("Also {}.", texts.join(", ")))
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
    fn step_sizes_are_short() {
        assert_eq!(step_size(0.125), "2^-3");
        assert_eq!(step_size(0.1), "0.1");
        assert_eq!(step_size(1.0 / 3.0), "0.333333");
        assert_eq!(step_size(0.12345678), "0.123457");
        assert_eq!(step_size(f64::NAN), "?");
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
