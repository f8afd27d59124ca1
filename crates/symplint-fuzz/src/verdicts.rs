//! A verdict, written in every way that programs write it.

use symplint::{Diagnosis, Evidence};
use symplint_report::figures::step_sizes;
use symplint_report::report::{ReportError, read_evidence, to_json};
use symplint_report::text::{DisplayOptions, diagnosis_text};

/// Judges evidence, and writes what is found as text, table, figure and JSON.
pub fn judge_and_write(evidence: Evidence) -> Diagnosis {
    let diagnosis = Diagnosis::of(evidence);
    let verdict = &diagnosis.verdict;
    for width in [None, Some(0), Some(80)] {
        for all in [false, true] {
            let _ = diagnosis_text("fuzz", &diagnosis, DisplayOptions { width, all });
        }
    }
    let _ = step_sizes("fuzz", &diagnosis).to_svg();
    let _ = to_json(verdict);
    let _ = read_again(&diagnosis.evidence);
    diagnosis
}

/// Evidence as a report has it.
pub fn read_again(evidence: &Evidence) -> Result<Evidence, ReportError> {
    read_evidence(&report_of(evidence))
}

/// The part of a report that `judge` reads.
pub fn report_of(evidence: &Evidence) -> String {
    let evidence = to_json(evidence);
    format!("{{\"schema\": \"symplint/report/3\", \"evidence\": {evidence}}}")
}
