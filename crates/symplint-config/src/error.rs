//! Errors of a configuration, with their position in the source and the remedy.

use std::ops::Range;
use std::sync::Arc;

/// What is wrong with a configuration, where, and what to do.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub struct ConfigError {
    /// What is wrong.
    pub message: String,
    /// Where, and the label of that place; none for what is missing.
    pub position: Option<(Place, String)>,
    /// What to do, if the message does not say it.
    pub remedy: Option<String>,
}

impl ConfigError {
    /// An error without a position.
    pub fn new(message: impl Into<String>, remedy: impl Into<String>) -> Self {
        ConfigError {
            message: message.into(),
            position: None,
            remedy: Some(remedy.into()),
        }
    }

    /// An error whose message names the remedy.
    pub fn with_its_remedy(message: impl Into<String>) -> Self {
        ConfigError {
            message: message.into(),
            position: None,
            remedy: None,
        }
    }

    /// Adds the position.
    pub fn at(mut self, place: &Place, label: impl Into<String>) -> Self {
        self.position = Some((place.clone(), label.into()));
        self
    }
}

/// A text that settings are read from.
#[derive(Debug)]
pub struct Source {
    /// Its file, or `--set`.
    pub name: String,
    /// The text, as TOML.
    pub text: String,
}

/// The position of a setting.
#[derive(Clone, Debug)]
pub struct Place {
    /// The source.
    pub source: Arc<Source>,
    /// Byte range in its text.
    pub span: Range<usize>,
}
