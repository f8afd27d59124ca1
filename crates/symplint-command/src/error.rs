//! Why a command cannot be used, before it is called.

use std::path::PathBuf;

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
