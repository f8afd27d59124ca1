//! Commands that measure nothing, and the options that mean nothing to them.

use super::Failure;
use crate::cli::Common;

/// Refuses what only a run has: settings, a folder, a report, progress. Threads do no harm.
///
/// # Errors
/// If one of these options was given to `command`.
pub fn refuse_options(command: &str, common: &Common) -> Result<(), Failure> {
    let given = [
        ("--set", !common.set.is_empty()),
        ("--out", common.out.is_some()),
        ("--json", common.json),
        ("--quiet", common.quiet),
    ];
    match given.iter().find(|(_, given)| *given) {
        None => Ok(()),
        Some((option, _)) => Err(Failure::Usage {
            message: format!("{option} means nothing to {command}, which only prints a text"),
            remedy: format!("leave {option} out; standard output can be sent to a file by >"),
        }),
    }
}
