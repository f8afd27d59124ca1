//! Why a command cannot be used, before it is called, and why its calls end.

use std::path::{Path, PathBuf};

use crate::journal::JournalError;

/// Why a command is not a map.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CommandError {
    /// The program is missing.
    #[error("the list is empty; give the program and its arguments")]
    Empty,
    /// An argument that every command needs is missing.
    #[error("no argument contains {placeholder}; give the program the name of its {what} by it")]
    NoPlaceholder {
        /// The text that stands for the name.
        placeholder: &'static str,
        /// The file that it names.
        what: &'static str,
    },
    /// The folder that keeps the files of all calls holds others.
    #[error("{} is not empty; remove it, or name another folder", path.display())]
    Occupied {
        /// The folder.
        path: PathBuf,
    },
}

/// Why the calls of a run end. None of it is a failure of the map: the run resumes once the cause is gone.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CallsError {
    /// A file that identifies the program cannot be read.
    #[error(
        "cannot read {}: {reason}; make it readable: the contents of system.command[0] and system.files identify a run",
        path.display()
    )]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        reason: String,
    },
    /// A file that identifies the program has other contents than at the start.
    #[error(
        "{} changed while the run was under way; earlier calls are kept, and no call of the changed program: put the file back and \
         start the run again, or use another folder",
        path.display()
    )]
    Changed {
        /// The file.
        path: PathBuf,
    },
    /// The program is not there.
    #[error(
        "cannot run `{program}`: no such file; check system.command, whose paths start at the folder of the configuration"
    )]
    NoProgram {
        /// Its name.
        program: String,
    },
    /// The program is not executable.
    #[error(
        "cannot run `{program}`: permission denied; make it executable (chmod +x), or put its interpreter before it in system.command"
    )]
    NotExecutable {
        /// Its name.
        program: String,
    },
    /// The system could not start a process, or open or write a file.
    #[error(
        "cannot {action}: {reason}; check system.command and the limits of the system: end other processes or set system.workers \
         lower (`ulimit -a`), free space or name another folder by TMPDIR or --keep. The call says nothing of the map: finished calls \
         are kept, and the same command resumes"
    )]
    System {
        /// The action.
        action: String,
        /// The error of the operating system.
        reason: String,
    },
    /// The journal cannot be read or written.
    #[error(transparent)]
    Journal(#[from] JournalError),
}

impl CallsError {
    /// The error of an action that the system refuses.
    pub(crate) fn system(action: &str, error: &impl ToString) -> Self {
        CallsError::System {
            action: action.to_owned(),
            reason: error.to_string(),
        }
    }

    /// The error of a file or folder that cannot be written.
    pub(crate) fn of_file(path: &Path, error: &impl ToString) -> Self {
        let action = format!("write {}", path.display());
        // The folder of the calls was there before.
        match path.parent() {
            Some(folder) if !folder.exists() => {
                let reason = format!("{} was removed meanwhile", folder.display());
                Self::system(&action, &reason)
            }
            _ => Self::system(&action, error),
        }
    }
}
