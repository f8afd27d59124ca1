//! Reports: what `symplint judge` reads.

use symplint_report::report::read_evidence;

use crate::verdicts::judge_and_write;

/// Reads evidence from the bytes, judges it, and writes the verdict.
pub fn report(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else {
        return;
    };
    match read_evidence(text) {
        Ok(evidence) => drop(judge_and_write(evidence)),
        Err(error) => drop(error.to_string()),
    }
}
