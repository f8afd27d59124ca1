//! Errors that end a command with exit status 2.

use std::path::PathBuf;

use symplint_command::{CallsError, CommandError};
use symplint_config::{ConfigError, Place};
use symplint_files::LoopFileError;
use symplint_journal::JournalError;
use symplint_paper::PaperError;
use symplint_report::figure::FigureError;
use symplint_report::report::ReportError;
use symplint_report::run_folder::WriteError;

/// Errors of commands.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// The configuration.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// The folder of `--out` holds something else.
    #[error(transparent)]
    Occupied(#[from] OccupiedError),
    /// The run itself.
    #[error("the run failed")]
    Run(#[from] symplint::Error),
    /// A model of the paper's reproduction.
    #[error(transparent)]
    Model(#[from] symplint_models::ModelError),
    /// A loop in a file.
    #[error("{0}")]
    LoopFile(LoopFileError),
    /// A figure.
    #[error(transparent)]
    Figure(#[from] FigureError),
    /// A file or folder that cannot be written.
    #[error("cannot write {}: {reason}", path.display())]
    Write {
        /// Its path.
        path: PathBuf,
        /// The error of the operating system.
        reason: String,
    },
    /// A name on the command line.
    #[error("unknown {what} \"{name}\"")]
    Unknown {
        /// The kind of name.
        what: &'static str,
        /// The name given.
        name: String,
        /// The known names.
        suggestion: String,
    },
    /// Options that are missing, out of range or contradict each other.
    #[error("{message}")]
    Usage {
        /// What is wrong.
        message: String,
        /// The remedy.
        remedy: String,
    },
    /// A file that cannot be read.
    #[error("cannot read {}: {reason}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        reason: String,
        /// What to do about it.
        remedy: &'static str,
    },
    /// A report without evidence.
    #[error("cannot judge {}: {error}", path.display())]
    Report {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        error: ReportError,
    },
    /// The journal of a run.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// What a run whose calls are noted could not write at its end.
    #[error("{failure}")]
    AfterCalls {
        /// What.
        failure: Box<Failure>,
        /// The command that goes on.
        goes_on: String,
    },
    /// The calls of a program.
    #[error(transparent)]
    Calls(#[from] CallsError),
    /// A folder that holds no run to go on with.
    #[error("{} holds no run of `symplint check`: {reason}", folder.display())]
    NoRun {
        /// The folder.
        folder: PathBuf,
        /// What is missing.
        reason: String,
    },
    /// The thread pool.
    #[error("cannot start the threads: {reason}")]
    Threads {
        /// The error of the operating system.
        reason: String,
    },
}

impl Failure {
    /// What to do about it, where the text does not say so itself.
    pub fn remedy(&self) -> Option<String> {
        Some(match self {
            Failure::Config(error) => error.remedy.clone(),
            Failure::Occupied(error) => error.remedy().into(),
            Failure::LoopFile(error) => error.remedy(),
            Failure::Write { .. } => "give a path that can be written".into(),
            Failure::Figure(FigureError::Write { .. } | FigureError::Folder { .. }) => {
                "give a path that can be written".into()
            }
            Failure::AfterCalls { goes_on, .. } => format!(
                "all calls are noted: once the cause is gone, `{goes_on}` goes on from them"
            ),
            Failure::Unknown { suggestion, .. } => suggestion.clone(),
            Failure::Usage { remedy, .. } => remedy.clone(),
            Failure::Read { remedy, .. } => (*remedy).into(),
            Failure::NoRun { .. } => "give the folder of --out".into(),
            Failure::Threads { .. } => "try --threads 1".into(),
            Failure::Run(_)
            | Failure::Journal(_)
            | Failure::Calls(_)
            | Failure::Model(_)
            | Failure::Figure(_)
            | Failure::Report { .. } => {
                return None;
            }
        })
    }

    /// The setting that caused it, and a label for it.
    pub fn position(&self) -> Option<(&Place, &str)> {
        match self {
            Failure::Config(ConfigError { position, .. }) => position
                .as_ref()
                .map(|(place, label)| (place, label.as_str())),
            _ => None,
        }
    }

    /// A command that cannot be used as it is set. Its text ends with the remedy.
    pub fn of_command(error: CommandError) -> Self {
        let text = format!("system.keep: {error}");
        let (message, remedy) = text
            .split_once("; ")
            .unwrap_or((&text, "name another folder"));
        Failure::Usage {
            message: message.to_owned(),
            remedy: remedy.to_owned(),
        }
    }

    /// An error of the library that is caused by an option. Its text ends with the remedy.
    pub fn from_input(error: symplint::Error) -> Self {
        let text = error.to_string();
        let (message, remedy) = text
            .split_once("; ")
            .unwrap_or((&text, "give another value"));
        Failure::Usage {
            message: message.to_owned(),
            remedy: remedy.to_owned(),
        }
    }
}

impl From<LoopFileError> for Failure {
    fn from(error: LoopFileError) -> Self {
        Failure::LoopFile(error)
    }
}

impl From<PaperError> for Failure {
    fn from(error: PaperError) -> Self {
        match error {
            PaperError::Setting(error) => Failure::Usage {
                message: error.to_string(),
                remedy: error.remedy(),
            },
            PaperError::Run(error) => error.into(),
            PaperError::Model(error) => error.into(),
            PaperError::Figure(error) => error.into(),
            PaperError::Write(error) => error.into(),
        }
    }
}

impl From<WriteError> for Failure {
    fn from(error: WriteError) -> Self {
        let WriteError { path, reason } = error;
        Failure::Write { path, reason }
    }
}

/// Why a folder is not written to.
#[derive(Debug, thiserror::Error)]
pub enum OccupiedError {
    /// A file of the same name.
    #[error("{} is a file, not a folder", path.display())]
    NotAFolder {
        /// The path.
        path: PathBuf,
    },
    /// The folder or a file in it cannot be read.
    #[error("cannot read {}: {reason}", path.display())]
    Unreadable {
        /// The path.
        path: PathBuf,
        /// The error of the operating system.
        reason: String,
    },
    /// Files that symplint did not write.
    #[error("{} is not empty and not a run folder: symplint did not write {file}", folder.display())]
    Foreign {
        /// The folder.
        folder: PathBuf,
        /// One of the files.
        file: String,
    },
    /// A run folder that was changed by hand.
    #[error("config.toml in {} was changed after the run", folder.display())]
    Edited {
        /// The folder.
        folder: PathBuf,
    },
    /// The run of another command or configuration.
    #[error("{} holds another run: {difference}", folder.display())]
    OtherRun {
        /// The folder.
        folder: PathBuf,
        /// The first difference.
        difference: String,
    },
}

impl OccupiedError {
    /// What to do about it.
    pub fn remedy(&self) -> &'static str {
        match self {
            OccupiedError::NotAFolder { .. } | OccupiedError::Unreadable { .. } => {
                "give --out a folder that is new or empty"
            }
            OccupiedError::Foreign { .. } | OccupiedError::Edited { .. } => {
                "give --out a folder that is new or empty; --force does not replace such files"
            }
            OccupiedError::OtherRun { .. } => {
                "give --out another folder, or add --force to replace that run"
            }
        }
    }
}
