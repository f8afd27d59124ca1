//! Why a command cannot be used, before it is called, and why its calls end.

use std::path::PathBuf;

use symplint_journal::JournalError;

use crate::lack::Lack;

/// Why a command is not a map.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CommandError {
    /// There is no program.
    #[error("the list is empty; give the program and its arguments")]
    Empty,
    /// An argument that every command needs is missing.
    #[error("no argument contains {placeholder}; give the program the name of its {what} by it")]
    NoPlaceholder {
        /// The text that stands for the name.
        placeholder: &'static str,
        /// What the name is that of.
        what: &'static str,
    },
    /// The folder that keeps the files of all calls holds others.
    #[error("{} is not empty; remove it, or name another folder", path.display())]
    Occupied {
        /// The folder.
        path: PathBuf,
    },
}

/// Why the calls of a run are not made, or not noted.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CallsError {
    /// A file that the program is known by cannot be read.
    #[error(
        "cannot read {}: {reason}; make it readable: a run is known by the contents of the files that system.command names",
        path.display()
    )]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        reason: String,
    },
    /// It has other contents than at the start, or is there, or not there, unlike at the start.
    #[error(
        "{} changed while the run went on (or was made, or removed); calls that were noted before are kept, none of the changed \
         program: put the file back as it was and start the run again, or use another folder; files that calls themselves write \
         are named after {{before}}",
        path.display()
    )]
    Changed {
        /// The file.
        path: PathBuf,
    },
    /// A call could not be made.
    #[error(transparent)]
    Lack(#[from] Lack),
    /// The journal cannot be read or written.
    #[error(transparent)]
    Journal(#[from] JournalError),
}
