//! Why a command ended with exit status 2.

use std::path::PathBuf;

use miette::Diagnostic;
use symplint_paper::PaperError;
use symplint_report::figure::FigureError;
use symplint_report::loop_file::LoopFileError;
use symplint_report::run_folder::WriteError;

use crate::config::ConfigError;

/// Everything that can end a command early.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub enum Failure {
    /// The configuration.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Config(#[from] ConfigError),
    /// The run itself.
    #[error("the run failed")]
    Run(#[from] symplint::Error),
    /// A model of the paper's reproduction.
    #[error(transparent)]
    Model(#[from] symplint_models::ModelError),
    /// A loop in a file.
    #[error("{0}")]
    #[diagnostic(help("{}", .0.remedy()))]
    LoopFile(LoopFileError),
    /// A figure.
    #[error(transparent)]
    Figure(#[from] FigureError),
    /// A file of the run folder.
    #[error("cannot write {}: {reason}", path.display())]
    #[diagnostic(help("give --out a folder that can be written"))]
    Write {
        /// Which.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// A name on the command line.
    #[error("there is no {what} \"{name}\"")]
    #[diagnostic(help("{suggestion}"))]
    Unknown {
        /// Of what.
        what: &'static str,
        /// The name given.
        name: String,
        /// What there is.
        suggestion: String,
    },
    /// Options that do not go together.
    #[error("{message}")]
    #[diagnostic(help("{remedy}"))]
    Usage {
        /// What is wrong.
        message: String,
        /// What to do.
        remedy: String,
    },
    /// The thread pool.
    #[error("cannot start the threads: {reason}")]
    #[diagnostic(help("try --threads 1"))]
    Threads {
        /// Why.
        reason: String,
    },
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
