//! Why a command ended with exit status 2.

use std::path::PathBuf;

use miette::Diagnostic;

use crate::config::ConfigError;
use crate::figure::FigureError;
use crate::loop_file::LoopFileError;

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
    #[error(transparent)]
    #[diagnostic(transparent)]
    LoopFile(#[from] LoopFileError),
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
