//! The folder of a run: its configuration, its journal, the calls that jobs make, and its results.

mod earlier;
mod jobs;
mod output;

use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use symplint_report::figure::FigureError;
use symplint_report::run_folder::WriteError;

pub use earlier::{OccupiedError, command_of};
pub use jobs::Round;
pub use output::{RunOutput, loop_file};

use crate::command::{CallsError, CommandError};
use crate::journal::JournalError;

/// Why a folder cannot be used for a run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// It holds something else.
    #[error(transparent)]
    Occupied(#[from] OccupiedError),
    /// A file cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A file cannot be read.
    #[error("cannot read {}: {reason}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// The calls of another run are kept in the folder of `keep`.
    #[error("system.keep")]
    Keep(#[from] CommandError),
    /// The round of calls is missing.
    #[error("{} has no round of calls", path.display())]
    NoRound {
        /// The folder of the run.
        path: PathBuf,
    },
    /// A figure cannot be written.
    #[error(transparent)]
    Figure(#[from] FigureError),
    /// The journal cannot be used.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// The program cannot be used.
    #[error(transparent)]
    Calls(#[from] CallsError),
}

impl RunError {
    /// The remedy, unless the message has it.
    pub fn remedy(&self) -> Option<&'static str> {
        match self {
            RunError::Occupied(error) => Some(error.remedy()),
            RunError::Write(_) => Some("give a path that can be written"),
            RunError::Figure(FigureError::Write { .. } | FigureError::Folder { .. }) => {
                Some("give a path that can be written")
            }
            RunError::Read { .. } => {
                Some("make it readable, or remove it: the calls in it are made again")
            }
            RunError::NoRound { .. } => Some("write one by `symplint plan CONFIG.toml --out DIR`"),
            RunError::Keep(_) | RunError::Figure(_) | RunError::Journal(_) | RunError::Calls(_) => {
                None
            }
        }
    }
}

fn cannot_read(path: &Path, error: &impl ToString) -> RunError {
    RunError::Read {
        path: path.to_owned(),
        reason: error.to_string(),
    }
}

fn cannot_write(path: &Path, error: &io::Error) -> RunError {
    let (path, reason) = (path.to_owned(), error.to_string());
    WriteError { path, reason }.into()
}

/// Removes a file that may not be there.
fn remove(path: &Path) -> Result<(), RunError> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(cannot_write(path, &error)),
        _ => Ok(()),
    }
}
