//! The table of the census.

use std::fmt::Write;

use symplint::VerdictKind;
use symplint::verdict::plain_numbers;

use super::scheme_result::{SchemeResult, TableRow};

/// All schemes as a Markdown table; runs have steps of this size.
pub fn markdown(rows: &[SchemeResult], step_size: f64) -> String {
    let mut text = String::from(
        "| scheme | degree | verdict | order | breaks (crossings) | closed integrals | defect | energy | Gauss' law | momentum | which substep |\n\
         |---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for row in rows {
        let record = &row.record;
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} | {} | {:.0e} | {} | {:.0e} | {} |",
            record.scheme,
            record.degree,
            verdict(row),
            order(record),
            breaks(row),
            match record.closed_conserved {
                Some(true) => "conserved",
                Some(false) => "change",
                None if record.breaks > 0 => "open",
                None => "",
            },
            defect(record, step_size),
            record.energy_error,
            (record.gauss_residual).map_or("solved".into(), |residual| format!("{residual:.0e}")),
            record.momentum_change,
            record.substeps,
        );
    }
    plain_numbers(&text)
}

/// The verdict, with its digits.
fn verdict(row: &SchemeResult) -> String {
    match row.record.digits {
        Some(digits) => format!("{} to {digits} digits", row.kind),
        None => row.kind.to_string(),
    }
}

/// k of defect ~ h^k, of small loops and small steps.
fn order(record: &TableRow) -> String {
    (record.slope).map_or_else(String::new, |slope| format!("{slope:.1}"))
}

/// With its step size where it is another one.
fn defect(record: &TableRow, step_size: f64) -> String {
    match record.defect_step_size == step_size {
        true => format!("{:.0e}", record.defect),
        false => format!("{:.0e} (h = {})", record.defect, record.defect_step_size),
    }
}

/// Breaks, and how many cell boundaries particles pass on the loop.
fn breaks(row: &SchemeResult) -> String {
    match (row.kind, row.record.breaks) {
        (VerdictKind::BrokenLoops, 0) => "not counted".into(),
        (_, 0) => "none".into(),
        (_, breaks) => format!("{breaks} ({})", row.record.crossings),
    }
}
