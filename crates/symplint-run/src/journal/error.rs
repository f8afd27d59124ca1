//! Errors of journals.

use std::io;
use std::path::{Path, PathBuf};

use symplint::StepFailure;

/// Why a journal is not read or written.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum JournalError {
    /// Another run writes to it.
    #[error("{} is in use: another run writes to it; wait for its end, end the processes that it left behind, or use another folder", path.display())]
    InUse {
        /// The journal.
        path: PathBuf,
    },
    /// A file that is not a journal.
    #[error("{} is not a journal of symplint, or its beginning is damaged; use another folder, or remove the file", path.display())]
    NotAJournal {
        /// The file.
        path: PathBuf,
    },
    /// The journal of another map, configuration or version.
    #[error("{} is of another run: {difference}; put back what differs, use another folder, or remove the file to begin anew", path.display())]
    OtherRun {
        /// The journal.
        path: PathBuf,
        /// The first difference.
        difference: String,
    },
    /// The operating system refuses to read or write it.
    #[error(
        "cannot {action} {}: {reason}; evaluations that were written are kept, and the same run goes on from them once \
         the cause is gone",
        path.display()
    )]
    File {
        /// The operation: `"read"` or `"write"`.
        action: &'static str,
        /// The journal.
        path: PathBuf,
        /// The error of the operating system.
        reason: String,
    },
}

impl JournalError {
    pub(crate) fn of_file(action: &'static str, path: &Path, error: &io::Error) -> Self {
        JournalError::File {
            action,
            path: path.to_owned(),
            reason: error.to_string(),
        }
    }
}

impl From<JournalError> for StepFailure {
    /// That of a step that was not taken, or is lost.
    fn from(error: JournalError) -> Self {
        StepFailure {
            sample: 0,
            reason: error.to_string(),
        }
    }
}
