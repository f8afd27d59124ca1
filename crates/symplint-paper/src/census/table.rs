//! The table of the census.

use std::fmt::Write;

use super::judged::{Judged, Record};

/// All schemes as a Markdown table.
pub fn markdown(rows: &[Judged]) -> String {
    let mut text = String::from(
        "| scheme | degree | verdict | breaks a crossing | closed integrals | defect | energy | Gauss' law | momentum | which substep |\n\
         |---|---|---|---|---|---|---|---|---|---|\n",
    );
    for Judged { record, .. } in rows {
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {:.0e} | {:.0e} | {} | {:.0e} | {} |",
            record.scheme,
            record.degree,
            record.verdict,
            breaks(record),
            match record.closed_conserved {
                Some(true) => "conserved",
                Some(false) => "change",
                None => "",
            },
            record.defect,
            record.energy_error,
            (record.gauss_residual).map_or("solved".into(), |residual| format!("{residual:.0e}")),
            record.momentum_change,
            record.substeps,
        );
    }
    text
}

fn breaks(record: &Record) -> String {
    match record.breaks {
        0 => "none".into(),
        breaks => format!("{:.1}", breaks as f64 / record.crossings as f64),
    }
}
