//! `symplint judge REPORT.json`.

use std::io::Read;
use std::path::Path;

use symplint::Diagnosis;
use symplint_report::report::{read_evidence, to_json};

use super::check::exit_status;
use crate::cli::JudgeArgs;
use crate::failure::Failure;
use crate::output::{diagnosis_text, say};
use crate::status::Status;

/// Reaches the verdict again, from the evidence in a report.
pub fn judge(arguments: &JudgeArgs) -> Result<Status, Failure> {
    let path = match arguments.report.is_dir() {
        true => arguments.report.join("report.json"),
        false => arguments.report.clone(),
    };
    let text = read(&path).map_err(|error| Failure::Read {
        path: path.clone(),
        reason: error.to_string(),
        remedy: "give the report.json of a run folder",
    })?;
    let evidence = read_evidence(&text).map_err(|error| Failure::Report {
        path: path.clone(),
        error,
    })?;
    let diagnosis = Diagnosis::of(evidence);
    if arguments.json {
        say(to_json(&diagnosis.verdict))?;
    } else {
        let title = path.display().to_string();
        say(diagnosis_text(
            &title,
            &diagnosis,
            (arguments.quiet, arguments.all),
        ))?;
    }
    Ok(exit_status(diagnosis.verdict.kind))
}

/// The text of a file; of standard input if it is `-`.
fn read(path: &Path) -> std::io::Result<String> {
    if path == Path::new("-") {
        let mut text = String::new();
        std::io::stdin().read_to_string(&mut text)?;
        return Ok(text);
    }
    // A FIFO without a writer has no end.
    if !std::fs::metadata(path)?.is_file() {
        let reason = "it is not a regular file; give `-` for standard input";
        return Err(std::io::Error::other(reason));
    }
    std::fs::read_to_string(path)
}
