//! Why an item could not be reproduced.

use symplint_models::ModelError;
use symplint_report::figure::FigureError;
use symplint_report::run_folder::WriteError;

use crate::settings::SettingError;

/// What can end an item early.
#[derive(Debug, thiserror::Error)]
pub enum PaperError {
    /// A setting, or several that do not go together.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// A run.
    #[error(transparent)]
    Run(#[from] symplint::Error),
    /// A model.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A figure.
    #[error(transparent)]
    Figure(#[from] FigureError),
    /// A file of data.
    #[error(transparent)]
    Write(#[from] WriteError),
}
