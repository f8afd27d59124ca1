//! Tables of a page: the measured points, and the places that a change comes from.

use std::fmt::Write;

use symplint::Diagnosis;
use symplint::evidence::{Localisation, Point, Sweep};
use symplint::verdict::{plain_numbers, step_size_text};

use super::html::escaped;

/// Rows of the table that are shown at once; the others are folded.
const FIRST_ROWS: usize = 12;

/// The title of a column, which narrow screens may hyphenate.
const UNCERTAINTY: &str = "uncer&shy;tainty";

/// The points of the given loop, and of random ones, as a table; all but the first rows are folded.
pub(super) fn points(points: &[Point]) -> String {
    let of_sizes: Vec<&Point> = (points.iter())
        .filter(|point| point.sweep == Sweep::StepSize)
        .collect();
    if of_sizes.is_empty() {
        return String::new();
    }
    let has_breaks = of_sizes
        .iter()
        .any(|point| point.jumps.is_some_and(|count| count > 0));
    let breaks = if has_breaks {
        "<th scope=\"col\">breaks</th><th scope=\"col\">change, breaks closed</th>"
    } else {
        ""
    };
    let header = format!(
        "<thead><tr><th scope=\"col\">loop</th><th scope=\"col\">step h</th><th scope=\"col\">samples</th>\
         <th scope=\"col\">change</th><th scope=\"col\">{UNCERTAINTY}</th>{breaks}</tr></thead>"
    );
    let row = |point: &&Point| {
        let name = match point.loop_index {
            0 => "yours".to_owned(),
            k => format!("random {k}"),
        };
        let size = match point.step_size.is_finite() {
            true => step_size_text(point.step_size),
            false => "none".into(),
        };
        let uncertainty = point
            .quadrature_error
            .map_or("unknown".into(), |error| size_of(error + point.roundoff));
        let mut row = format!(
            "<tr><th scope=\"row\">{name}</th><td>{size}</td><td>{}</td><td>{}</td><td>{uncertainty}</td>",
            point.samples,
            signed(point.signed_defect)
        );
        if has_breaks {
            let count = point.jumps.map_or(String::new(), |count| count.to_string());
            let closed = point.closed_defect.map_or(String::new(), size_of);
            row += &format!("<td>{count}</td><td>{closed}</td>");
        }
        row + "</tr>\n"
    };
    let of = |points: &[&Point], more: &str| -> String {
        let rows: String = points.iter().map(row).collect();
        let caption = format!("Relative change of the loop integral ∮ p·dq in one step{more}");
        scrolling(&caption, &format!("{header}\n<tbody>\n{rows}</tbody>"))
    };
    let (first, rest) = of_sizes.split_at(of_sizes.len().min(FIRST_ROWS));
    let mut text = of(first, "");
    if !rest.is_empty() {
        let _ = write!(
            text,
            "<details><summary>{} more rows</summary>\n{}</details>\n",
            rest.len(),
            of(rest, ", continued")
        );
    }
    text
}

/// The change by each substep and by each sector of the loop, with bars; nothing if they were not measured.
pub(super) fn places(diagnosis: &Diagnosis) -> String {
    let Some(place) = &diagnosis.evidence.localisation else {
        return String::new();
    };
    let Localisation {
        substeps, sectors, ..
    } = place;
    let of_loop = match place.loop_index {
        0 => "your loop".to_owned(),
        k => format!("random loop {k}"),
    };
    let at = (place.step_size).map_or(String::new(), |h| {
        format!(" at h\u{a0}=\u{a0}{}", step_size_text(h))
    });
    let breaks = substeps.iter().any(|of| of.new_breaks > 0);
    let rows = substeps.iter().map(|of| Bar {
        name: format!("{}: {}", of.substep.saturating_add(1), of.name),
        change: of.change,
        uncertainty: of.uncertainty,
        breaks: breaks.then_some(of.new_breaks),
    });
    let caption = format!("Relative change of ∮ p·dq by each substep, {of_loop}{at}");
    let by_substep = bars(&caption, "substep", &rows.collect::<Vec<Bar>>());
    let rows = sectors.iter().map(|of| Bar {
        name: format!("s = {} to {}", of.from, of.to),
        change: of.change,
        uncertainty: of.uncertainty,
        breaks: None,
    });
    let caption =
        format!("Relative change of ∮ p·dq by each sector of the disc within {of_loop}{at}");
    let by_sector = bars(&caption, "sector", &rows.collect::<Vec<Bar>>());
    if by_substep.is_empty() && by_sector.is_empty() {
        return String::new();
    }
    format!("<h2>Where the change comes from</h2>\n{by_substep}{by_sector}")
}

/// A part of a change.
struct Bar {
    name: String,
    change: f64,
    uncertainty: Option<f64>,
    /// Breaks that it makes, if any part makes some.
    breaks: Option<usize>,
}

/// A table of the parts of a change, with a bar for each that exceeds its uncertainty: the largest one fills its column.
fn bars(caption: &str, what: &str, rows: &[Bar]) -> String {
    let is_known = |row: &Bar| row.change.abs() > row.uncertainty.unwrap_or(0.0);
    let has_bars = rows.iter().any(is_known);
    if !has_bars && rows.iter().all(|row| row.breaks.unwrap_or(0) == 0) {
        return String::new();
    }
    let largest = (rows.iter().map(|row| row.change.abs())).fold(0.0, f64::max);
    let row = |row: &Bar| {
        let width = match is_known(row) {
            true => 100.0 * row.change.abs() / largest,
            false => 0.0,
        };
        let sign = if row.change < 0.0 { "less" } else { "more" };
        let bar = match has_bars {
            true => format!(
                "<td class=\"bar\" aria-hidden=\"true\"><span class=\"{sign}\" style=\"width: {width:.1}%\"></span></td>"
            ),
            false => String::new(),
        };
        let breaks = (row.breaks).map_or(String::new(), |count| format!("<td>{count}</td>"));
        format!(
            "<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td>{breaks}{bar}</tr>\n",
            escaped(&row.name),
            signed(row.change),
            row.uncertainty.map_or("unknown".into(), size_of),
        )
    };
    let breaks = match rows.iter().any(|row| row.breaks.is_some()) {
        true => "<th scope=\"col\">new breaks</th>",
        false => "",
    };
    let bar = if has_bars { "<td></td>" } else { "" };
    let rows: String = rows.iter().map(row).collect();
    scrolling(
        caption,
        &format!(
            "<thead><tr><th scope=\"col\">{what}</th><th scope=\"col\">change</th><th scope=\"col\">{UNCERTAINTY}</th>{breaks}{bar}\
             </tr></thead>\n<tbody>\n{rows}</tbody>"
        ),
    )
}

/// A table that scrolls on narrow screens, also by the keyboard.
fn scrolling(caption: &str, parts: &str) -> String {
    format!(
        "<div class=\"table\" role=\"region\" aria-label=\"{caption}\" tabindex=\"0\"><table>\n<caption>{caption}</caption>\n\
         {parts}\n</table></div>\n"
    )
}

/// A change with its sign.
fn signed(change: f64) -> String {
    match change == 0.0 {
        true => "0".into(),
        false => plain_numbers(&format!("{change:+.2e}")),
    }
}

/// The size of a change or an error.
fn size_of(value: f64) -> String {
    match value == 0.0 {
        true => "0".into(),
        false => plain_numbers(&format!("{value:.0e}")),
    }
}
