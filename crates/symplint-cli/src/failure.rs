//! Errors that end a command with exit status 2.

use std::path::PathBuf;

use symplint_config::{ConfigError, Place};
use symplint_files::LoopFileError;
use symplint_paper::PaperError;
use symplint_report::figure::FigureError;
use symplint_report::report::ReportError;
use symplint_report::run_folder::WriteError;
use symplint_run::RunError;

/// Errors of commands.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// The configuration.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// The folder of `--out`, or the calls of a program.
    #[error(transparent)]
    Folder(#[from] RunError),
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
    /// An option that the library refuses.
    #[error(transparent)]
    Option(symplint::Error),
    /// Options that are missing, out of range or contradict each other.
    #[error("{message}")]
    Usage {
        /// The mistake.
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
        /// The problem.
        error: ReportError,
    },
    /// A file that could not be written at the end of a run whose calls are in a journal.
    #[error("{failure}")]
    AfterCalls {
        /// What.
        failure: Box<Failure>,
        /// The command that continues the run.
        goes_on: String,
    },
    /// A folder that holds no run to continue.
    #[error("{} holds no run of `symplint check`: {reason}", folder.display())]
    NoRun {
        /// The folder.
        folder: PathBuf,
        /// The missing file.
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
    /// What to do about it, if the message does not name it itself.
    pub fn remedy(&self) -> Option<String> {
        Some(match self {
            Failure::Config(error) => return error.remedy.clone(),
            Failure::Folder(error) => return error.remedy().map(str::to_owned),
            Failure::LoopFile(error) => error.remedy(),
            Failure::Write { .. } => "give a path that can be written".into(),
            Failure::Figure(FigureError::Write { .. } | FigureError::Folder { .. }) => {
                "give a path that can be written".into()
            }
            Failure::AfterCalls { goes_on, .. } => format!(
                "all calls are kept: remove the cause, then `{goes_on}` continues from them"
            ),
            Failure::Unknown { suggestion, .. } => suggestion.clone(),
            Failure::Usage { remedy, .. } => remedy.clone(),
            Failure::Read { remedy, .. } => (*remedy).into(),
            Failure::NoRun { .. } => "give the folder of --out".into(),
            Failure::Threads { .. } => "try --threads 1".into(),
            Failure::Run(_)
            | Failure::Option(_)
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
